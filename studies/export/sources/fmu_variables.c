/* Variables of a motor along x by value reference, its start and its steps: see fmu_motor.c. */
#define IMPOSSIBLE "an input is impossible: preload must be positive, the drive zero or positive where there is but " \
    "one, and a parameter is set before the simulation begins"

enum { V_TIME, V_DRIVE, V_LOAD, V_PRELOAD, V_POSITION, V_VELOCITY, V_AMPLITUDE, V_POWER, V_FORCE, V_DEFORMATION,
       V_APPROACH, V_STICKS, V_START, V_RISE, V_END };

typedef struct {
    sawmotor_state state;
    double drive, load, preload, start, time;
    int begun;
} Motor;

static void motor_reset(Motor *motor) {
    memset(motor, 0, sizeof *motor);
    motor->load = SAWMOTOR_LOAD;
    motor->preload = SAWMOTOR_PRELOAD;
}

static int motor_get(const Motor *motor, unsigned reference, double *value) {
    switch (reference) {
    case V_TIME: *value = motor->time; return 0;
    case V_DRIVE: *value = motor->drive; return 0;
    case V_LOAD: *value = motor->load; return 0;
    case V_PRELOAD: *value = motor->preload; return 0;
    case V_POSITION: *value = motor->start + sawmotor_position(&motor->state); return 0;
    case V_VELOCITY: *value = sawmotor_velocity(&motor->state); return 0;
    case V_AMPLITUDE: *value = sawmotor_surface_amplitude(&motor->state); return 0;
    case V_POWER: *value = sawmotor_power(motor->drive); return 0;
    case V_FORCE: *value = sawmotor_force(&motor->state); return 0;
    case V_DEFORMATION: *value = sawmotor_deformation(&motor->state); return 0;
    case V_APPROACH: *value = sawmotor_approach(&motor->state); return 0;
    case V_STICKS: *value = sawmotor_sticks(&motor->state); return 0;
    case V_START: *value = motor->start; return 0;
    case V_RISE: *value = sawmotor_temperature_rise(&motor->state); return 0;
    default: return 1;
    }
}

static int motor_set(Motor *motor, unsigned reference, double value) {
    if (value != value) return 1;
    switch (reference) {
    case V_DRIVE: if (value < 0.0 && SAWMOTOR_DRIVES < 2) return 1; motor->drive = value; return 0;
    case V_LOAD: motor->load = value; return 0;
    case V_PRELOAD: if (!(value > 0.0)) return 1; motor->preload = value; return 0;
    case V_START: if (motor->begun) return 1; motor->start = value; return 0;
    default: return 1;
    }
}

/* The following return why a call fails, or NULL. */
static const char *motor_begin(Motor *motor) {
    motor->begun = 1;
    return sawmotor_start(&motor->state, motor->preload, motor->load) ? "preload must be positive" : NULL;
}

static const char *motor_step(Motor *motor, double now, double step) {
    int reason = sawmotor_advance(&motor->state, motor->drive, motor->load, motor->preload, step);
    if (reason) return reason == 1 ? "an input is impossible" : "the motion is not finite";
    motor->time = now + step;
    return NULL;
}
