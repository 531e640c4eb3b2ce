/* FMI 3.0 for co-simulation around motor.c; signatures of the standard, fmi-standard.org. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "fmu_motor.c"

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;
typedef void (*Log)(void *environment, Status status, const char *category, const char *message);

typedef struct {
    Motor motor;
    Log log;
    void *environment;
} Instance;

static Status failed(Instance *instance, const char *message) {
    if (instance && instance->log) instance->log(instance->environment, ERROR, "logStatusError", message);
    return ERROR;
}

static Status status_of(Instance *instance, const char *message) { return message ? failed(instance, message) : OK; }

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

EXPORT Status fmi3SetDebugLogging(void *instance, bool on, size_t count, const char *const categories[]) {
    (void)instance; (void)on; (void)count; (void)categories;
    return OK;
}

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
    bool logging, bool events, bool early, const uint32_t intermediate[], size_t count, void *environment, Log log,
    void *update) {
    (void)name; (void)resources; (void)visible; (void)events; (void)early; (void)intermediate; (void)count;
    (void)update; (void)logging;
    if (!token || strcmp(token, SAWMOTOR_TOKEN) != 0) {
        if (log) log(environment, ERROR, "logStatusError", "the instantiation token is that of another FMU");
        return NULL;
    }
    Instance *instance = calloc(1, sizeof *instance);
    if (!instance) return NULL;
    instance->log = log;
    instance->environment = environment;
    motor_reset(&instance->motor);
    return instance;
}

EXPORT void *fmi3InstantiateModelExchange(const char *name, const char *token, const char *resources, bool visible,
    bool logging, void *environment, Log log) {
    (void)name; (void)token; (void)resources; (void)visible; (void)logging; (void)environment; (void)log;
    return NULL;
}

EXPORT void *fmi3InstantiateScheduledExecution(const char *name, const char *token, const char *resources,
    bool visible, bool logging, void *environment, Log log, void *update, void *lock, void *unlock) {
    (void)name; (void)token; (void)resources; (void)visible; (void)logging; (void)environment; (void)log;
    (void)update; (void)lock; (void)unlock;
    return NULL;
}

EXPORT void fmi3FreeInstance(void *instance) { free(instance); }

EXPORT Status fmi3EnterInitializationMode(void *instance, bool has_tolerance, double tolerance, double start,
    bool has_stop, double stop) {
    (void)has_tolerance; (void)tolerance; (void)has_stop; (void)stop;
    ((Instance *)instance)->motor.time = start;
    return OK;
}

EXPORT Status fmi3ExitInitializationMode(void *handle) {
    Instance *instance = handle;
    return status_of(instance, motor_begin(&instance->motor));
}

EXPORT Status fmi3Terminate(void *instance) { (void)instance; return OK; }

EXPORT Status fmi3Reset(void *handle) {
    motor_reset(&((Instance *)handle)->motor);
    return OK;
}

EXPORT Status fmi3GetFloat64(void *handle, const uint32_t references[], size_t count, double values[], size_t size) {
    Instance *instance = handle;
    if (size != count) return failed(instance, "every variable is one number");
    return status_of(instance, motor_read(&instance->motor, references, count, values));
}

EXPORT Status fmi3SetFloat64(void *handle, const uint32_t references[], size_t count, const double values[],
    size_t size) {
    Instance *instance = handle;
    if (size != count) return failed(instance, "every variable is one number");
    return status_of(instance, motor_write(&instance->motor, references, count, values));
}

EXPORT Status fmi3GetBoolean(void *handle, const uint32_t references[], size_t count, bool values[], size_t size) {
    Instance *instance = handle;
    for (size_t k = 0; k < count; k++) {
        if (references[k] != V_STICKS || size != count) return failed(instance, "fmi3GetBoolean: no such variable");
        values[k] = sawmotor_sticks(&instance->motor.state);
    }
    return OK;
}

EXPORT Status fmi3DoStep(void *handle, double now, double step, bool no_return, bool *event, bool *terminate,
    bool *early, double *last) {
    Instance *instance = handle;
    (void)no_return;
    if (event) *event = false;
    if (terminate) *terminate = false;
    if (early) *early = false;
    const char *message = motor_step(&instance->motor, now, step);
    if (last) *last = message ? now : now + step;
    return status_of(instance, message);
}

EXPORT Status fmi3GetFMUState(void *instance, void **state) {
    if (!*state && !(*state = malloc(sizeof(Motor)))) return ERROR;
    memcpy(*state, &((Instance *)instance)->motor, sizeof(Motor));
    return OK;
}

EXPORT Status fmi3SetFMUState(void *handle, void *state) {
    ((Instance *)handle)->motor = *(Motor *)state;
    return OK;
}

EXPORT Status fmi3FreeFMUState(void *instance, void **state) {
    (void)instance;
    free(*state);
    *state = NULL;
    return OK;
}

EXPORT Status fmi3SerializedFMUStateSize(void *instance, void *state, size_t *size) {
    (void)instance; (void)state;
    *size = sizeof(Motor);
    return OK;
}

EXPORT Status fmi3SerializeFMUState(void *instance, void *state, uint8_t bytes[], size_t size) {
    if (size < sizeof(Motor)) return failed(instance, "too little room for the state");
    memcpy(bytes, state, sizeof(Motor));
    return OK;
}

EXPORT Status fmi3DeserializeFMUState(void *instance, const uint8_t bytes[], size_t size, void **state) {
    if (size < sizeof(Motor)) return failed(instance, "these bytes are no state of this FMU");
    if (!*state && !(*state = calloc(1, sizeof(Motor)))) return ERROR;
    memcpy(*state, bytes, sizeof(Motor));
    return OK;
}

/* What this model has nothing of: the functions exist, as the standard asks, and say so. */
#define ABSENT(name, ...) EXPORT Status name(void *instance, __VA_ARGS__) { return failed(instance, #name " is not supported"); }
#define ABSENT_TYPE(kind, type) \
    ABSENT(fmi3Get##kind, const uint32_t r[], size_t n, type v[], size_t m) \
    ABSENT(fmi3Set##kind, const uint32_t r[], size_t n, const type v[], size_t m)
#if defined __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
ABSENT_TYPE(Float32, float)
ABSENT_TYPE(Int8, int8_t)
ABSENT_TYPE(UInt8, uint8_t)
ABSENT_TYPE(Int16, int16_t)
ABSENT_TYPE(UInt16, uint16_t)
ABSENT_TYPE(Int32, int32_t)
ABSENT_TYPE(UInt32, uint32_t)
ABSENT_TYPE(Int64, int64_t)
ABSENT_TYPE(UInt64, uint64_t)
ABSENT_TYPE(String, char *)
ABSENT(fmi3SetBoolean, const uint32_t r[], size_t n, const bool v[], size_t m)
ABSENT(fmi3GetBinary, const uint32_t r[], size_t n, size_t s[], const uint8_t *v[], size_t m)
ABSENT(fmi3SetBinary, const uint32_t r[], size_t n, const size_t s[], const uint8_t *const v[], size_t m)
ABSENT(fmi3GetClock, const uint32_t r[], size_t n, bool v[])
ABSENT(fmi3SetClock, const uint32_t r[], size_t n, const bool v[])
ABSENT(fmi3GetNumberOfVariableDependencies, uint32_t r, size_t *n)
ABSENT(fmi3GetVariableDependencies, uint32_t r, size_t a[], uint32_t b[], size_t c[], int d[], size_t n)
ABSENT(fmi3GetDirectionalDerivative, const uint32_t u[], size_t nu, const uint32_t k[], size_t nk, const double s[],
       size_t ns, double d[], size_t nd)
ABSENT(fmi3GetAdjointDerivative, const uint32_t u[], size_t nu, const uint32_t k[], size_t nk, const double s[],
       size_t ns, double d[], size_t nd)
ABSENT(fmi3GetIntervalDecimal, const uint32_t r[], size_t n, double i[], int q[])
ABSENT(fmi3GetIntervalFraction, const uint32_t r[], size_t n, uint64_t c[], uint64_t p[], int q[])
ABSENT(fmi3GetShiftDecimal, const uint32_t r[], size_t n, double s[])
ABSENT(fmi3GetShiftFraction, const uint32_t r[], size_t n, uint64_t c[], uint64_t p[])
ABSENT(fmi3SetIntervalDecimal, const uint32_t r[], size_t n, const double i[])
ABSENT(fmi3SetIntervalFraction, const uint32_t r[], size_t n, const uint64_t c[], const uint64_t p[])
ABSENT(fmi3SetShiftDecimal, const uint32_t r[], size_t n, const double s[])
ABSENT(fmi3SetShiftFraction, const uint32_t r[], size_t n, const uint64_t c[], const uint64_t p[])
ABSENT(fmi3CompletedIntegratorStep, bool a, bool *b, bool *c)
ABSENT(fmi3SetTime, double t)
ABSENT(fmi3SetContinuousStates, const double x[], size_t n)
ABSENT(fmi3GetContinuousStateDerivatives, double x[], size_t n)
ABSENT(fmi3GetEventIndicators, double x[], size_t n)
ABSENT(fmi3GetContinuousStates, double x[], size_t n)
ABSENT(fmi3GetNominalsOfContinuousStates, double x[], size_t n)
ABSENT(fmi3GetNumberOfEventIndicators, size_t *n)
ABSENT(fmi3GetNumberOfContinuousStates, size_t *n)
ABSENT(fmi3GetOutputDerivatives, const uint32_t r[], size_t n, const int32_t o[], double v[], size_t m)
ABSENT(fmi3ActivateModelPartition, uint32_t clock, double time)
ABSENT(fmi3UpdateDiscreteStates, bool *a, bool *b, bool *c, bool *d, bool *e, double *f)
EXPORT Status fmi3EnterEventMode(void *i) { return failed(i, "fmi3EnterEventMode is not supported"); }
EXPORT Status fmi3EnterContinuousTimeMode(void *i) { return failed(i, "fmi3EnterContinuousTimeMode is not supported"); }
EXPORT Status fmi3EnterStepMode(void *i) { return failed(i, "fmi3EnterStepMode is not supported"); }
EXPORT Status fmi3EnterConfigurationMode(void *i) { (void)i; return OK; }
EXPORT Status fmi3ExitConfigurationMode(void *i) { (void)i; return OK; }
EXPORT Status fmi3EvaluateDiscreteStates(void *i) { return failed(i, "fmi3EvaluateDiscreteStates is not supported"); }
