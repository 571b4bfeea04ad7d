/* Skeleton of small units for co-simulation, FMI 2.0 and 3.0: a model has numbers and a step.

A model defines COUNT, `begin` and `step` and includes this file; all its variables are numbers in
one array, by value reference. Whatever type an importer names, it gets that number. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

typedef void (*log3)(void *, int, const char *, const char *);
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *allocate, *release, *finished, *environment;
} callbacks2;

typedef struct {
    double v[COUNT];
    void *environment;
    log3 log;
    callbacks2 callbacks;
    bool event, terminate, early; /* what a step of FMI 3.0 says beside its status */
} plant;

/* Values at the start; one step of `size` seconds: 0 if it worked, or an FMI status. */
static void begin(plant *p);
static int step(plant *p, double time, double size);

static void say(plant *p, int status, const char *text) {
    if (p->log != NULL)
        p->log(p->environment, status, "plant", text);
    else if (p->callbacks.logger != NULL)
        p->callbacks.logger(p->callbacks.environment, "plant", status, "plant", "%s", text);
}

static plant *make(void) {
    plant *p = calloc(1, sizeof *p);
    begin(p);
    return p;
}

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources,
                                  bool visible, bool logging, bool events, bool early,
                                  const uint32_t between[], size_t count, void *environment,
                                  log3 log, void *update) {
    plant *p = make();
    p->environment = environment;
    p->log = log;
    return p;
}
const char *fmi3GetVersion(void) { return "3.0"; }
int fmi3SetDebugLogging(void *p, bool on, size_t n, const char *const categories[]) { return 0; }
int fmi3EnterInitializationMode(void *p, bool t, double tolerance, double start, bool s, double stop) {
    return 0;
}
int fmi3ExitInitializationMode(void *p) { return 0; }
int fmi3Terminate(void *p) { return 0; }
int fmi3Reset(void *p) { return 0; }
void fmi3FreeInstance(void *p) { free(p); }
int fmi3DoStep(void *p, double time, double size, bool last, bool *event, bool *terminate,
               bool *early, double *done) {
    plant *self = p;
    self->event = self->terminate = self->early = false;
    int status = step(self, time, size);
    *event = self->event;
    *terminate = self->terminate;
    *early = self->early;
    *done = time + (self->early ? size / 2 : size);
    return status;
}

#define ACCESS3(name, type)                                                                        \
    int fmi3Get##name(void *p, const uint32_t r[], size_t n, type values[], size_t count) {        \
        for (size_t i = 0; i < n; i++)                                                             \
            values[i] = (type)((plant *)p)->v[r[i]];                                               \
        return 0;                                                                                  \
    }                                                                                              \
    int fmi3Set##name(void *p, const uint32_t r[], size_t n, const type values[], size_t count) {  \
        for (size_t i = 0; i < n; i++)                                                             \
            ((plant *)p)->v[r[i]] = (double)values[i];                                             \
        return 0;                                                                                  \
    }
ACCESS3(Float64, double)
ACCESS3(Float32, float)
ACCESS3(Int8, int8_t)
ACCESS3(UInt8, uint8_t)
ACCESS3(Int16, int16_t)
ACCESS3(UInt16, uint16_t)
ACCESS3(Int32, int32_t)
ACCESS3(UInt32, uint32_t)
ACCESS3(Int64, int64_t)
ACCESS3(UInt64, uint64_t)
ACCESS3(Boolean, bool)

void *fmi2Instantiate(const char *name, int type, const char *token, const char *resources,
                      const callbacks2 *callbacks, int visible, int logging) {
    plant *p = make();
    p->callbacks = *callbacks;
    return p;
}
const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
int fmi2SetDebugLogging(void *p, int on, size_t n, const char *const categories[]) { return 0; }
int fmi2SetupExperiment(void *p, int t, double tolerance, double start, int s, double stop) { return 0; }
int fmi2EnterInitializationMode(void *p) { return 0; }
int fmi2ExitInitializationMode(void *p) { return 0; }
int fmi2Terminate(void *p) { return 0; }
int fmi2Reset(void *p) { return 0; }
void fmi2FreeInstance(void *p) { free(p); }
int fmi2DoStep(void *p, double time, double size, int last) { return step(p, time, size); }

#define ACCESS2(name, type)                                                                        \
    int fmi2Get##name(void *p, const unsigned r[], size_t n, type values[]) {                      \
        for (size_t i = 0; i < n; i++)                                                             \
            values[i] = (type)((plant *)p)->v[r[i]];                                               \
        return 0;                                                                                  \
    }                                                                                              \
    int fmi2Set##name(void *p, const unsigned r[], size_t n, const type values[]) {                \
        for (size_t i = 0; i < n; i++)                                                             \
            ((plant *)p)->v[r[i]] = (double)values[i];                                             \
        return 0;                                                                                  \
    }
ACCESS2(Real, double)
ACCESS2(Integer, int)
ACCESS2(Boolean, int)

/* Functions that importers look for and these units do not have */
#define UNUSED(name)                                                                               \
    int name(void) { return 3; }
UNUSED(fmi3InstantiateModelExchange) UNUSED(fmi3InstantiateScheduledExecution)
UNUSED(fmi3EnterEventMode) UNUSED(fmi3GetString) UNUSED(fmi3SetString) UNUSED(fmi3GetBinary)
UNUSED(fmi3SetBinary) UNUSED(fmi3GetClock) UNUSED(fmi3SetClock)
UNUSED(fmi3GetNumberOfVariableDependencies) UNUSED(fmi3GetVariableDependencies)
UNUSED(fmi3GetFMUState) UNUSED(fmi3SetFMUState) UNUSED(fmi3FreeFMUState)
UNUSED(fmi3SerializedFMUStateSize) UNUSED(fmi3SerializeFMUState) UNUSED(fmi3DeserializeFMUState)
UNUSED(fmi3GetDirectionalDerivative) UNUSED(fmi3GetAdjointDerivative)
UNUSED(fmi3EnterConfigurationMode) UNUSED(fmi3ExitConfigurationMode)
UNUSED(fmi3GetIntervalDecimal) UNUSED(fmi3GetIntervalFraction) UNUSED(fmi3GetShiftDecimal)
UNUSED(fmi3GetShiftFraction) UNUSED(fmi3SetIntervalDecimal) UNUSED(fmi3SetIntervalFraction)
UNUSED(fmi3SetShiftDecimal) UNUSED(fmi3SetShiftFraction) UNUSED(fmi3EvaluateDiscreteStates)
UNUSED(fmi3UpdateDiscreteStates) UNUSED(fmi3EnterContinuousTimeMode)
UNUSED(fmi3CompletedIntegratorStep) UNUSED(fmi3SetTime) UNUSED(fmi3SetContinuousStates)
UNUSED(fmi3GetContinuousStateDerivatives) UNUSED(fmi3GetEventIndicators)
UNUSED(fmi3GetContinuousStates) UNUSED(fmi3GetNominalsOfContinuousStates)
UNUSED(fmi3GetNumberOfEventIndicators) UNUSED(fmi3GetNumberOfContinuousStates)
UNUSED(fmi3EnterStepMode) UNUSED(fmi3GetOutputDerivatives) UNUSED(fmi3ActivateModelPartition)
UNUSED(fmi2GetString) UNUSED(fmi2SetString) UNUSED(fmi2GetFMUstate) UNUSED(fmi2SetFMUstate)
UNUSED(fmi2FreeFMUstate) UNUSED(fmi2SerializeFMUstate) UNUSED(fmi2DeSerializeFMUstate)
UNUSED(fmi2SerializedFMUstateSize) UNUSED(fmi2GetDirectionalDerivative)
UNUSED(fmi2SetRealInputDerivatives) UNUSED(fmi2GetRealOutputDerivatives) UNUSED(fmi2CancelStep)
UNUSED(fmi2GetStatus) UNUSED(fmi2GetRealStatus) UNUSED(fmi2GetIntegerStatus)
UNUSED(fmi2GetBooleanStatus) UNUSED(fmi2GetStringStatus)
