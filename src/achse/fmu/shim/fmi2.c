/* The functions of FMI 2.0 for co-simulation (FMI 2.0.4, 2.1 and 4.2). */

#include "fmi2.h"
#include "unit.h"

#include <float.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    unit *station;
    char *name;
    fmi2ComponentEnvironment environment;
    fmi2CallbackLogger log;
} component;

static void report(void *owner, unit_status status, const char *category, const char *text) {
    component *self = owner;
    if (self->log != NULL)
        self->log(self->environment, self->name, (fmi2Status)status, category, "%s", text);
}

/* NULL for a component that was freed. */
static unit *station(fmi2Component self) {
    return instance_lives(self) ? ((component *)self)->station : NULL;
}

static fmi2Status refused(fmi2Component self, const char *what) {
    return (fmi2Status)unit_refuse(station(self), what);
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

static int hexadecimal(char digit) {
    if (digit >= '0' && digit <= '9')
        return digit - '0';
    digit |= 0x20;
    return digit >= 'a' && digit <= 'f' ? digit - 'a' + 10 : -1;
}

/* The path of a URI file:/path, file:///path or file://host/path. */
static char *path_of(const char *uri) {
    if (uri == NULL)
        return strdup("");
    if (strncmp(uri, "file:", 5) == 0) {
        uri += 5;
        if (uri[0] == '/' && uri[1] == '/') {
            const char *path = strchr(uri + 2, '/');
            uri = path == NULL ? "" : path;
        }
    }
    char *path = strdup(uri), *to = path;
    for (const char *from = uri; path != NULL && *from != '\0'; from++) {
        int high = from[0] == '%' ? hexadecimal(from[1]) : -1;
        int low = high >= 0 ? hexadecimal(from[2]) : -1;
        if (low >= 0)
            from += 2;
        *to++ = low >= 0 ? (char)(16 * high + low) : *from;
    }
    if (path != NULL)
        *to = '\0';
    return path;
}

void fmi2FreeInstance(fmi2Component instance) {
    component *self = instance;
    if (!instance_freed(self))
        return;
    unit_close(self->station);
    free(self->name);
    free(self);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token,
                              fmi2String resources, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean logging) {
    (void)visible;
    component *self = calloc(1, sizeof *self);
    if (self == NULL)
        return NULL;
    instance_made(self);
    self->name = strdup(name == NULL ? "" : name);
    if (functions != NULL) {
        self->environment = functions->componentEnvironment;
        self->log = functions->logger;
    }
    char *path = path_of(resources);
    if (type != fmi2CoSimulation)
        report(self, UNIT_ERROR, "logStatusError", "model exchange: not supported by this unit");
    else if (path != NULL && self->name != NULL)
        self->station = unit_open(path, token, logging != 0, report, self);
    free(path);
    if (self->station == NULL) {
        fmi2FreeInstance(self);
        return NULL;
    }
    return self;
}

fmi2Status fmi2SetDebugLogging(fmi2Component self, fmi2Boolean on, size_t count,
                               const fmi2String categories[]) {
    (void)count, (void)categories;
    unit_verbose(station(self), on != 0);
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component self, fmi2Boolean has_tolerance, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean has_stop, fmi2Real stop) {
    (void)has_tolerance, (void)tolerance;
    return (fmi2Status)unit_begin(station(self), start, has_stop != 0, stop);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component self) {
    return (fmi2Status)unit_go(station(self), "fmi2EnterInitializationMode", INSTANTIATED,
                               INSTANTIATED, INITIALIZING);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component self) {
    return (fmi2Status)unit_go(station(self), "fmi2ExitInitializationMode", INITIALIZING,
                               INITIALIZING, STEPPING);
}

fmi2Status fmi2Terminate(fmi2Component self) {
    return (fmi2Status)unit_go(station(self), "fmi2Terminate", STEPPING, INITIALIZING, TERMINATED);
}

fmi2Status fmi2Reset(fmi2Component self) { return (fmi2Status)unit_reset(station(self)); }

fmi2Status fmi2DoStep(fmi2Component self, fmi2Real at, fmi2Real by, fmi2Boolean final) {
    (void)final;
    return (fmi2Status)unit_step(station(self), at, by);
}

/* Values: numbers of all widths are Integer or Real here */

static fmi2Status mismatch(fmi2Component self, fmi2ValueReference reference) {
    return (fmi2Status)unit_error(station(self), "value reference %u: another type", reference);
}

#define LOAD(type)                                                                                 \
    {                                                                                              \
        type value;                                                                                \
        memcpy(&value, bytes, sizeof value);                                                       \
        values[i] = value;                                                                         \
        break;                                                                                     \
    }
#define STORE(type)                                                                                \
    {                                                                                              \
        type value = (type)values[i];                                                              \
        if (sets)                                                                                  \
            memcpy(bytes, &value, sizeof value);                                                   \
        break;                                                                                     \
    }
#define WITHIN(least, most)                                                                        \
    if (values[i] < (least) || values[i] > (most))                                                 \
        return (fmi2Status)unit_error(station(self), "value reference %u: expected %g to %g",      \
                                      references[i], (double)(least), (double)(most));

/* Numbers that an Integer cannot hold are a Real: exactly up to 2^53. All values are checked before
one is set. */
#define ACCESS(name, kind, GET_CASES, SET_CASES)                                                   \
    fmi2Status fmi2Get##name(fmi2Component self, const fmi2ValueReference references[],            \
                             size_t count, kind values[]) {                                        \
        unit *from = station(self);                                                                \
        if (unit_arrays(from, count, references, values) != UNIT_OK)                               \
            return fmi2Error;                                                                      \
        for (size_t i = 0; i < count; i++) {                                                       \
            const variable *each = unit_variable(from, references[i]);                             \
            const void *bytes = each == NULL ? NULL : unit_read(from, each);                       \
            if (bytes == NULL)                                                                     \
                return (fmi2Status)unit_failure(from);                                             \
            switch (each->type) {                                                                  \
                GET_CASES                                                                          \
            default:                                                                               \
                return mismatch(self, references[i]);                                              \
            }                                                                                      \
        }                                                                                          \
        return fmi2OK;                                                                             \
    }                                                                                              \
    fmi2Status fmi2Set##name(fmi2Component self, const fmi2ValueReference references[],            \
                             size_t count, const kind values[]) {                                  \
        unit *to = station(self);                                                                  \
        if (unit_arrays(to, count, references, values) != UNIT_OK)                                 \
            return fmi2Error;                                                                      \
        for (int sets = 0; sets < 2; sets++)                                                       \
            for (size_t i = 0; i < count; i++) {                                                   \
                const variable *each = unit_variable(to, references[i]);                           \
                void *bytes = each == NULL ? NULL : unit_write(to, each);                          \
                if (bytes == NULL                                                                  \
                    || unit_finite(to, references[i], (double)values[i]) != UNIT_OK)               \
                    return fmi2Error;                                                              \
                switch (each->type) {                                                              \
                    SET_CASES                                                                      \
                default:                                                                           \
                    return mismatch(self, references[i]);                                          \
                }                                                                                  \
            }                                                                                      \
        return fmi2OK;                                                                             \
    }

/* clang-format off */
ACCESS(Real, fmi2Real,
    case TYPE_FLOAT64: LOAD(double)
    case TYPE_FLOAT32: LOAD(float)
    case TYPE_UINT32: LOAD(uint32_t)
    ,
    case TYPE_FLOAT64: STORE(double)
    case TYPE_FLOAT32: WITHIN(-FLT_MAX, FLT_MAX) STORE(float)
    case TYPE_UINT32: WITHIN(0.0, 4294967295.0) STORE(uint32_t)
)
ACCESS(Integer, fmi2Integer,
    case TYPE_INT8: LOAD(int8_t)
    case TYPE_UINT8: LOAD(uint8_t)
    case TYPE_INT16: LOAD(int16_t)
    case TYPE_UINT16: LOAD(uint16_t)
    case TYPE_INT32: LOAD(int32_t)
    ,
    case TYPE_INT8: WITHIN(INT8_MIN, INT8_MAX) STORE(int8_t)
    case TYPE_UINT8: WITHIN(0, UINT8_MAX) STORE(uint8_t)
    case TYPE_INT16: WITHIN(INT16_MIN, INT16_MAX) STORE(int16_t)
    case TYPE_UINT16: WITHIN(0, UINT16_MAX) STORE(uint16_t)
    case TYPE_INT32: STORE(int32_t)
)
ACCESS(Boolean, fmi2Boolean,
    case TYPE_BOOLEAN: LOAD(uint8_t)
    ,
    case TYPE_BOOLEAN: if (sets) *(uint8_t *)bytes = values[i] != 0; break;
)
/* clang-format on */

fmi2Status fmi2GetString(fmi2Component self, const fmi2ValueReference references[], size_t count,
                         fmi2String values[]) {
    unit *from = station(self);
    if (unit_arrays(from, count, references, values) != UNIT_OK)
        return fmi2Error;
    for (size_t i = 0; i < count; i++) {
        const variable *each = unit_variable(from, references[i]);
        if (each == NULL)
            return fmi2Error;
        if (each->type != TYPE_STRING)
            return mismatch(self, references[i]);
        values[i] = unit_read(from, each);
        if (values[i] == NULL)
            return (fmi2Status)unit_failure(from);
    }
    return fmi2OK;
}

fmi2Status fmi2SetString(fmi2Component self, const fmi2ValueReference references[], size_t count,
                         const fmi2String values[]) {
    unit *to = station(self);
    if (unit_arrays(to, count, references, values) != UNIT_OK)
        return fmi2Error;
    for (int sets = 0; sets < 2; sets++)
        for (size_t i = 0; i < count; i++) {
            const variable *each = unit_variable(to, references[i]);
            if (each == NULL)
                return fmi2Error;
            if (each->type != TYPE_STRING)
                return mismatch(self, references[i]);
            if (unit_write_text(to, each, values[i], !sets) != UNIT_OK)
                return fmi2Error;
        }
    return fmi2OK;
}

/* States */

fmi2Status fmi2GetFMUstate(fmi2Component self, fmi2FMUstate *state) {
    return (fmi2Status)unit_save(station(self), (unit_state **)state);
}

fmi2Status fmi2SetFMUstate(fmi2Component self, fmi2FMUstate state) {
    return (fmi2Status)unit_restore(station(self), state);
}

fmi2Status fmi2FreeFMUstate(fmi2Component self, fmi2FMUstate *state) {
    if (state != NULL && *state != NULL)
        unit_drop(station(self), *state);
    if (state != NULL)
        *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component self, fmi2FMUstate state, size_t *size) {
    const void *bytes;
    return (fmi2Status)unit_pack(station(self), state, &bytes, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component self, fmi2FMUstate state, fmi2Byte serialized[],
                                 size_t size) {
    const void *bytes;
    size_t needed;
    fmi2Status status = (fmi2Status)unit_pack(station(self), state, &bytes, &needed);
    if (status != fmi2OK)
        return status;
    if (size < needed)
        return (fmi2Status)unit_error(station(self), "state: expected room for %zu bytes, got %zu",
                                      needed, size);
    memcpy(serialized, bytes, needed);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component self, const fmi2Byte serialized[], size_t size,
                                   fmi2FMUstate *state) {
    return (fmi2Status)unit_unpack(station(self), serialized, size, (unit_state **)state);
}

/* Steps are done when fmi2DoStep returns: only the last time has a meaning */

fmi2Status fmi2GetRealStatus(fmi2Component self, const fmi2StatusKind kind, fmi2Real *value) {
    if (kind != fmi2LastSuccessfulTime)
        return refused(self, "fmi2GetRealStatus");
    *value = unit_last_time(station(self));
    return fmi2OK;
}

#define REFUSED(name, ...)                                                                         \
    fmi2Status fmi2##name(fmi2Component self, __VA_ARGS__) { return refused(self, "fmi2" #name); }

#if defined __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

REFUSED(GetDirectionalDerivative, const fmi2ValueReference unknowns[], size_t unknown_count,
        const fmi2ValueReference knowns[], size_t known_count, const fmi2Real seed[],
        fmi2Real values[])
REFUSED(SetRealInputDerivatives, const fmi2ValueReference of[], size_t n,
        const fmi2Integer orders[], const fmi2Real values[])
REFUSED(GetRealOutputDerivatives, const fmi2ValueReference of[], size_t n,
        const fmi2Integer orders[], fmi2Real values[])
REFUSED(GetStatus, const fmi2StatusKind kind, fmi2Status *value)
REFUSED(GetIntegerStatus, const fmi2StatusKind kind, fmi2Integer *value)
REFUSED(GetBooleanStatus, const fmi2StatusKind kind, fmi2Boolean *value)
REFUSED(GetStringStatus, const fmi2StatusKind kind, fmi2String *value)

fmi2Status fmi2CancelStep(fmi2Component self) { return refused(self, "fmi2CancelStep"); }
