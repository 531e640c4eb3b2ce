/* FMI 2.0 for co-simulation around motor.c; signatures of the standard, fmi-standard.org. */
#include <stddef.h>
#include "fmu_motor.c"

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } Status;
typedef void (*Log)(void *environment, const char *name, Status status, const char *category, const char *message, ...);
typedef struct {
    Log log;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void *finished;
    void *environment;
} Callbacks;

typedef struct {
    Motor motor;
    Log log;
    void *environment;
    char name[128];
} Instance;

static Status failed(Instance *instance, const char *message) {
    if (instance && instance->log)
        instance->log(instance->environment, instance->name, ERROR, "logStatusError", "%s", message);
    return ERROR;
}

static Status status_of(Instance *instance, const char *message) { return message ? failed(instance, message) : OK; }

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT void *fmi2Instantiate(const char *name, int type, const char *token, const char *resources,
    const Callbacks *callbacks, int visible, int logging) {
    (void)resources; (void)visible; (void)logging;
    if (type != 1 || !token || strcmp(token, SAWMOTOR_TOKEN) != 0) {
        if (callbacks && callbacks->log)
            callbacks->log(callbacks->environment, name, ERROR, "logStatusError",
                           "this FMU is for co-simulation, and its GUID must be the one of its description");
        return NULL;
    }
    Instance *instance = calloc(1, sizeof *instance);
    if (!instance) return NULL;
    instance->log = callbacks ? callbacks->log : NULL;
    instance->environment = callbacks ? callbacks->environment : NULL;
    strncpy(instance->name, name ? name : "", sizeof instance->name - 1);
    motor_reset(&instance->motor);
    return instance;
}

EXPORT void fmi2FreeInstance(void *instance) { free(instance); }

EXPORT Status fmi2SetDebugLogging(void *instance, int on, size_t count, const char *const categories[]) {
    (void)instance; (void)on; (void)count; (void)categories;
    return OK;
}

EXPORT Status fmi2SetupExperiment(void *instance, int has_tolerance, double tolerance, double start, int has_stop,
    double stop) {
    (void)has_tolerance; (void)tolerance; (void)has_stop; (void)stop;
    ((Instance *)instance)->motor.time = start;
    return OK;
}

EXPORT Status fmi2EnterInitializationMode(void *instance) { (void)instance; return OK; }

EXPORT Status fmi2ExitInitializationMode(void *handle) {
    Instance *instance = handle;
    return status_of(instance, motor_begin(&instance->motor));
}

EXPORT Status fmi2Terminate(void *instance) { (void)instance; return OK; }

EXPORT Status fmi2Reset(void *handle) {
    motor_reset(&((Instance *)handle)->motor);
    return OK;
}

EXPORT Status fmi2GetReal(void *handle, const unsigned references[], size_t count, double values[]) {
    Instance *instance = handle;
    return status_of(instance, motor_read(&instance->motor, references, count, values));
}

EXPORT Status fmi2SetReal(void *handle, const unsigned references[], size_t count, const double values[]) {
    Instance *instance = handle;
    return status_of(instance, motor_write(&instance->motor, references, count, values));
}

EXPORT Status fmi2GetBoolean(void *handle, const unsigned references[], size_t count, int values[]) {
    Instance *instance = handle;
    for (size_t k = 0; k < count; k++) {
        if (references[k] != V_STICKS) return failed(instance, "fmi2GetBoolean: no such variable");
        values[k] = sawmotor_sticks(&instance->motor.state);
    }
    return OK;
}

EXPORT Status fmi2DoStep(void *handle, double now, double step, int no_return) {
    Instance *instance = handle;
    (void)no_return;
    return status_of(instance, motor_step(&instance->motor, now, step));
}

EXPORT Status fmi2GetFMUstate(void *instance, void **state) {
    if (!*state && !(*state = malloc(sizeof(Motor)))) return ERROR;
    memcpy(*state, &((Instance *)instance)->motor, sizeof(Motor));
    return OK;
}

EXPORT Status fmi2SetFMUstate(void *handle, void *state) {
    ((Instance *)handle)->motor = *(Motor *)state;
    return OK;
}

EXPORT Status fmi2FreeFMUstate(void *instance, void **state) {
    (void)instance;
    free(*state);
    *state = NULL;
    return OK;
}

#define ABSENT(name, ...) EXPORT Status name(void *instance, __VA_ARGS__) { return failed(instance, #name " is not supported"); }
#if defined __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
ABSENT(fmi2GetInteger, const unsigned r[], size_t n, int v[])
ABSENT(fmi2SetInteger, const unsigned r[], size_t n, const int v[])
ABSENT(fmi2SetBoolean, const unsigned r[], size_t n, const int v[])
ABSENT(fmi2GetString, const unsigned r[], size_t n, const char *v[])
ABSENT(fmi2SetString, const unsigned r[], size_t n, const char *const v[])
ABSENT(fmi2SerializedFMUstateSize, void *state, size_t *size)
ABSENT(fmi2SerializeFMUstate, void *state, char bytes[], size_t size)
ABSENT(fmi2DeSerializeFMUstate, const char bytes[], size_t size, void **state)
ABSENT(fmi2GetDirectionalDerivative, const unsigned u[], size_t nu, const unsigned k[], size_t nk, const double s[],
       double d[])
ABSENT(fmi2SetRealInputDerivatives, const unsigned r[], size_t n, const int o[], const double v[])
ABSENT(fmi2GetRealOutputDerivatives, const unsigned r[], size_t n, const int o[], double v[])
ABSENT(fmi2GetStatus, int kind, int *value)
ABSENT(fmi2GetRealStatus, int kind, double *value)
ABSENT(fmi2GetIntegerStatus, int kind, int *value)
ABSENT(fmi2GetBooleanStatus, int kind, int *value)
ABSENT(fmi2GetStringStatus, int kind, const char **value)
EXPORT Status fmi2CancelStep(void *i) { return failed(i, "fmi2CancelStep is not supported"); }
