/* What both FMI versions share: a motor at its time, and its variables by value reference (fmu_variables.c). */
#include <stdlib.h>
#include <string.h>
#include "motor.h"

#if defined _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

#include "fmu_variables.c"

/* The following return why a call fails, or NULL. */
static const char *motor_read(const Motor *motor, const unsigned references[], size_t count, double values[]) {
    for (size_t k = 0; k < count; k++)
        if (references[k] == V_STICKS || motor_get(motor, references[k], values + k))
            return "no such variable of real numbers";
    return NULL;
}

static const char *motor_write(Motor *motor, const unsigned references[], size_t count, const double values[]) {
    for (size_t k = 0; k < count; k++)
        if (motor_set(motor, references[k], values[k]))
            return IMPOSSIBLE;
    return NULL;
}
