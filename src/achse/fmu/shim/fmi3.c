/* The functions of FMI 3.0 for co-simulation; the others answer fmi3Error (FMI 3.0.2, 2.3 and 4.2). */

#include "fmi3.h"
#include "unit.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    unit *station;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} instance;

static void report(void *owner, unit_status status, const char *category, const char *text) {
    instance *self = owner;
    if (self->log != NULL)
        self->log(self->environment, (fmi3Status)status, category, text);
}

/* NULL for an instance that was freed. */
static unit *station(fmi3Instance self) {
    return instance_lives(self) ? ((instance *)self)->station : NULL;
}

static fmi3Status refused(fmi3Instance self, const char *what) {
    return (fmi3Status)unit_refuse(station(self), what);
}

const char *fmi3GetVersion(void) { return "3.0"; }

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
    const fmi3ValueReference intermediate[], size_t intermediate_count,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3IntermediateUpdateCallback update) {
    (void)name, (void)visible, (void)early_return, (void)intermediate, (void)update;
    instance *self = calloc(1, sizeof *self);
    if (self == NULL)
        return NULL;
    self->environment = environment;
    self->log = log;
    if (event_mode || intermediate_count > 0)
        report(self, UNIT_ERROR, "logStatusError",
               "expected neither event mode nor intermediate variables: the unit has none");
    else
        self->station = unit_open(resources, token, logging, report, self);
    if (self->station == NULL) {
        free(self);
        return NULL;
    }
    instance_made(self);
    return self;
}

fmi3Instance fmi3InstantiateModelExchange(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging;
    if (log != NULL)
        log(environment, fmi3Error, "logStatusError", "model exchange: not supported by this unit");
    return NULL;
}

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
    fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging;
    (void)update, (void)lock, (void)unlock;
    if (log != NULL)
        log(environment, fmi3Error, "logStatusError",
            "scheduled execution: not supported by this unit");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance self) {
    if (!instance_freed(self))
        return;
    unit_close(((instance *)self)->station);
    free(self);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance self, fmi3Boolean on, size_t count,
                               const fmi3String categories[]) {
    (void)count, (void)categories;
    unit_verbose(station(self), on);
    return fmi3OK;
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance self, fmi3Boolean has_tolerance,
                                       fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean has_stop, fmi3Float64 stop) {
    (void)has_tolerance, (void)tolerance;
    unit_status status = unit_begin(station(self), start, has_stop, stop);
    if (status == UNIT_OK)
        status = unit_go(station(self), "fmi3EnterInitializationMode", INSTANTIATED, INSTANTIATED,
                         INITIALIZING);
    return (fmi3Status)status;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance self) {
    return (fmi3Status)unit_go(station(self), "fmi3ExitInitializationMode", INITIALIZING,
                               INITIALIZING, STEPPING);
}

fmi3Status fmi3Terminate(fmi3Instance self) {
    return (fmi3Status)unit_go(station(self), "fmi3Terminate", STEPPING, INITIALIZING, TERMINATED);
}

fmi3Status fmi3Reset(fmi3Instance self) { return (fmi3Status)unit_reset(station(self)); }

fmi3Status fmi3DoStep(fmi3Instance self, fmi3Float64 at, fmi3Float64 by, fmi3Boolean final,
                      fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early,
                      fmi3Float64 *last_time) {
    (void)final;
    unit_status status = unit_step(station(self), at, by);
    if (event_needed != NULL)
        *event_needed = false;
    if (terminate != NULL)
        *terminate = false;
    if (early != NULL)
        *early = false;
    if (last_time != NULL)
        *last_time = unit_last_time(station(self));
    return (fmi3Status)status;
}

/* Values: arrays one after another, each with all its elements */

/* UNIT_OK if these variables have that type and so many values together. */
static unit_status check(unit *self, const fmi3ValueReference references[], size_t count,
                         value_type type, const void *values, size_t value_count) {
    unit_status status = unit_arrays(self, count, references, values);
    size_t expected = 0;
    for (size_t i = 0; status == UNIT_OK && i < count; i++) {
        const variable *each = unit_variable(self, references[i]);
        if (each == NULL)
            return UNIT_ERROR;
        if (each->type != type)
            return unit_error(self, "value reference %u: another type", references[i]);
        expected += each->count;
    }
    if (status == UNIT_OK && expected != value_count)
        return unit_error(self, "expected %zu values, got %zu", expected, value_count);
    return status;
}

static fmi3Status get(fmi3Instance self, const fmi3ValueReference references[], size_t count,
                      value_type type, void *values, size_t value_count, size_t value_size) {
    unit *from = station(self);
    size_t done = 0;
    if (check(from, references, count, type, values, value_count) != UNIT_OK)
        return fmi3Error;
    for (size_t i = 0; i < count; i++) {
        const variable *each = unit_variable(from, references[i]);
        const uint8_t *bytes = unit_read(from, each);
        if (bytes == NULL)
            return (fmi3Status)unit_failure(from);
        if (type == TYPE_STRING)
            ((fmi3String *)values)[done] = (fmi3String)bytes;
        else
            memcpy((uint8_t *)values + done * value_size, bytes, each->size);
        done += each->count;
    }
    return fmi3OK;
}

static unit_status all_finite(unit *self, fmi3ValueReference reference, value_type type,
                              const void *values, size_t count) {
    unit_status status = UNIT_OK;
    for (size_t i = 0; status == UNIT_OK && i < count; i++)
        if (type == TYPE_FLOAT64)
            status = unit_finite(self, reference, ((const fmi3Float64 *)values)[i]);
        else if (type == TYPE_FLOAT32)
            status = unit_finite(self, reference, (double)((const fmi3Float32 *)values)[i]);
    return status;
}

/* All values are checked before one is set. */
static fmi3Status set(fmi3Instance self, const fmi3ValueReference references[], size_t count,
                      value_type type, const void *values, size_t value_count, size_t value_size) {
    unit *to = station(self);
    if (check(to, references, count, type, values, value_count) != UNIT_OK)
        return fmi3Error;
    for (int sets = 0; sets < 2; sets++) {
        size_t done = 0;
        for (size_t i = 0; i < count; i++) {
            const variable *each = unit_variable(to, references[i]);
            const uint8_t *from = (const uint8_t *)values + done * value_size;
            done += each->count;
            if (type == TYPE_STRING) {
                const char *text = *(const fmi3String *)(const void *)from;
                if (unit_write_text(to, each, text, !sets) != UNIT_OK)
                    return fmi3Error;
                continue;
            }
            uint8_t *bytes = unit_write(to, each);
            if (bytes == NULL || all_finite(to, references[i], type, from, each->count) != UNIT_OK)
                return fmi3Error;
            for (size_t n = 0; sets && n < each->size; n++)
                bytes[n] = type == TYPE_BOOLEAN ? from[n] != 0 : from[n];
        }
    }
    return fmi3OK;
}

#define ACCESS(name, type, code)                                                                   \
    fmi3Status fmi3Get##name(fmi3Instance self, const fmi3ValueReference references[],             \
                             size_t count, type values[], size_t value_count) {                    \
        return get(self, references, count, code, values, value_count, sizeof(type));              \
    }                                                                                              \
    fmi3Status fmi3Set##name(fmi3Instance self, const fmi3ValueReference references[],             \
                             size_t count, const type values[], size_t value_count) {              \
        return set(self, references, count, code, values, value_count, sizeof(type));              \
    }

ACCESS(Float32, fmi3Float32, TYPE_FLOAT32)
ACCESS(Float64, fmi3Float64, TYPE_FLOAT64)
ACCESS(Int8, fmi3Int8, TYPE_INT8)
ACCESS(UInt8, fmi3UInt8, TYPE_UINT8)
ACCESS(Int16, fmi3Int16, TYPE_INT16)
ACCESS(UInt16, fmi3UInt16, TYPE_UINT16)
ACCESS(Int32, fmi3Int32, TYPE_INT32)
ACCESS(UInt32, fmi3UInt32, TYPE_UINT32)
ACCESS(Int64, fmi3Int64, TYPE_INT64)
ACCESS(UInt64, fmi3UInt64, TYPE_UINT64)
ACCESS(Boolean, fmi3Boolean, TYPE_BOOLEAN)
ACCESS(String, fmi3String, TYPE_STRING)

/* States */

fmi3Status fmi3GetFMUState(fmi3Instance self, fmi3FMUState *state) {
    return (fmi3Status)unit_save(station(self), (unit_state **)state);
}

fmi3Status fmi3SetFMUState(fmi3Instance self, fmi3FMUState state) {
    return (fmi3Status)unit_restore(station(self), state);
}

fmi3Status fmi3FreeFMUState(fmi3Instance self, fmi3FMUState *state) {
    if (state != NULL && *state != NULL)
        unit_drop(station(self), *state);
    if (state != NULL)
        *state = NULL;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance self, fmi3FMUState state, size_t *size) {
    const void *bytes;
    return (fmi3Status)unit_pack(station(self), state, &bytes, size);
}

fmi3Status fmi3SerializeFMUState(fmi3Instance self, fmi3FMUState state, fmi3Byte serialized[],
                                 size_t size) {
    const void *bytes;
    size_t needed;
    fmi3Status status = (fmi3Status)unit_pack(station(self), state, &bytes, &needed);
    if (status != fmi3OK)
        return status;
    if (size < needed)
        return (fmi3Status)unit_error(station(self), "state: expected room for %zu bytes, got %zu",
                                      needed, size);
    memcpy(serialized, bytes, needed);
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance self, const fmi3Byte serialized[], size_t size,
                                   fmi3FMUState *state) {
    return (fmi3Status)unit_unpack(station(self), serialized, size, (unit_state **)state);
}

/* Functions that the unit has no use for */

#define REFUSED(name, ...)                                                                         \
    fmi3Status fmi3##name(fmi3Instance self, __VA_ARGS__) { return refused(self, "fmi3" #name); }
#define REFUSED_ALONE(name)                                                                        \
    fmi3Status fmi3##name(fmi3Instance self) { return refused(self, "fmi3" #name); }

#if defined __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

typedef const fmi3ValueReference *references;

REFUSED_ALONE(EnterEventMode)
REFUSED_ALONE(EnterConfigurationMode)
REFUSED_ALONE(ExitConfigurationMode)
REFUSED_ALONE(EvaluateDiscreteStates)
REFUSED_ALONE(EnterContinuousTimeMode)
REFUSED_ALONE(EnterStepMode)
REFUSED(GetBinary, references of, size_t n, size_t sizes[], fmi3Binary values[], size_t count)
REFUSED(SetBinary, references of, size_t n, const size_t sizes[], const fmi3Binary values[],
        size_t count)
REFUSED(GetClock, references of, size_t n, fmi3Clock values[])
REFUSED(SetClock, references of, size_t n, const fmi3Clock values[])
REFUSED(GetNumberOfVariableDependencies, fmi3ValueReference of, size_t *count)
REFUSED(GetVariableDependencies, fmi3ValueReference of, size_t elements[],
        fmi3ValueReference independents[], size_t independent_elements[],
        fmi3DependencyKind kinds[], size_t count)
REFUSED(GetDirectionalDerivative, references unknowns, size_t unknown_count, references knowns,
        size_t known_count, const fmi3Float64 seed[], size_t seed_count, fmi3Float64 values[],
        size_t count)
REFUSED(GetAdjointDerivative, references unknowns, size_t unknown_count, references knowns,
        size_t known_count, const fmi3Float64 seed[], size_t seed_count, fmi3Float64 values[],
        size_t count)
REFUSED(GetIntervalDecimal, references of, size_t n, fmi3Float64 intervals[],
        fmi3IntervalQualifier qualifiers[])
REFUSED(GetIntervalFraction, references of, size_t n, fmi3UInt64 counters[],
        fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
REFUSED(GetShiftDecimal, references of, size_t n, fmi3Float64 shifts[])
REFUSED(GetShiftFraction, references of, size_t n, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
REFUSED(SetIntervalDecimal, references of, size_t n, const fmi3Float64 intervals[])
REFUSED(SetIntervalFraction, references of, size_t n, const fmi3UInt64 counters[],
        const fmi3UInt64 resolutions[])
REFUSED(SetShiftDecimal, references of, size_t n, const fmi3Float64 shifts[])
REFUSED(SetShiftFraction, references of, size_t n, const fmi3UInt64 counters[],
        const fmi3UInt64 resolutions[])
REFUSED(UpdateDiscreteStates, fmi3Boolean *need_update, fmi3Boolean *terminate,
        fmi3Boolean *nominals_changed, fmi3Boolean *values_changed, fmi3Boolean *next_defined,
        fmi3Float64 *next_time)
REFUSED(CompletedIntegratorStep, fmi3Boolean final, fmi3Boolean *enter_event_mode,
        fmi3Boolean *terminate)
REFUSED(SetTime, fmi3Float64 time)
REFUSED(SetContinuousStates, const fmi3Float64 states[], size_t n)
REFUSED(GetContinuousStateDerivatives, fmi3Float64 derivatives[], size_t n)
REFUSED(GetEventIndicators, fmi3Float64 indicators[], size_t n)
REFUSED(GetContinuousStates, fmi3Float64 states[], size_t n)
REFUSED(GetNominalsOfContinuousStates, fmi3Float64 nominals[], size_t n)
REFUSED(GetNumberOfEventIndicators, size_t *n)
REFUSED(GetNumberOfContinuousStates, size_t *n)
REFUSED(GetOutputDerivatives, references of, size_t n, const fmi3Int32 orders[],
        fmi3Float64 values[], size_t count)
REFUSED(ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time)
