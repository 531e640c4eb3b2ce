/* Variables of a motor in the plane by value reference, its start and its steps: see fmu_motor.c. */
#define IMPOSSIBLE "an input is impossible: preload must be positive, and drives zero or positive"

enum { V_TIME, V_DRIVE, V_SECOND_DRIVE, V_FORCE_X, V_FORCE_Y, V_TORQUE, V_PRELOAD, V_X, V_Y, V_YAW, V_VELOCITY_X,
       V_VELOCITY_Y, V_YAW_RATE, V_ROTATION, V_AMPLITUDE, V_SECOND_AMPLITUDE, V_CONTACT_X, V_CONTACT_Y, V_MOMENT,
       V_STICKS };

typedef struct {
    sawmotor_state state;
    sawmotor_inputs inputs;
    double time;
} Motor;

static void motor_reset(Motor *motor) {
    const sawmotor_inputs inputs = SAWMOTOR_INPUTS;
    memset(motor, 0, sizeof *motor);
    motor->inputs = inputs;
}

static int motor_get(const Motor *motor, unsigned reference, double *value) {
    const double *pose = sawmotor_pose(&motor->state), *rates = sawmotor_rates(&motor->state);
    const double *force = sawmotor_force(&motor->state);
    switch (reference) {
    case V_TIME: *value = motor->time; return 0;
    case V_DRIVE: case V_SECOND_DRIVE: *value = motor->inputs.level[reference - V_DRIVE]; return 0;
    case V_FORCE_X: case V_FORCE_Y: *value = motor->inputs.force[reference - V_FORCE_X]; return 0;
    case V_TORQUE: *value = motor->inputs.torque; return 0;
    case V_PRELOAD: *value = motor->inputs.preload; return 0;
    case V_X: case V_Y: case V_YAW: *value = pose[reference - V_X]; return 0;
    case V_VELOCITY_X: case V_VELOCITY_Y: case V_YAW_RATE: *value = rates[reference - V_VELOCITY_X]; return 0;
    case V_ROTATION: *value = rates[2]; return 0;
    case V_AMPLITUDE: case V_SECOND_AMPLITUDE:
        *value = sawmotor_surface_amplitude(&motor->state, (int)(reference - V_AMPLITUDE)); return 0;
    case V_CONTACT_X: case V_CONTACT_Y: case V_MOMENT: *value = force[reference - V_CONTACT_X]; return 0;
    default: return 1;
    }
}

static int motor_set(Motor *motor, unsigned reference, double value) {
    if (value != value) return 1;
    switch (reference) {
    case V_DRIVE: case V_SECOND_DRIVE:
        if (value < 0.0) return 1;
        motor->inputs.level[reference - V_DRIVE] = value; return 0;
    case V_FORCE_X: case V_FORCE_Y: motor->inputs.force[reference - V_FORCE_X] = value; return 0;
    case V_TORQUE: motor->inputs.torque = value; return 0;
    case V_PRELOAD: if (!(value > 0.0)) return 1; motor->inputs.preload = value; return 0;
    default: return 1;
    }
}

/* The following return why a call fails, or NULL. */
static const char *motor_begin(Motor *motor) {
    sawmotor_start(&motor->state);
    return NULL;
}

static const char *motor_step(Motor *motor, double now, double step) {
    int reason = sawmotor_advance(&motor->state, &motor->inputs, step);
    if (reason == 3) return "the drives lie beyond the tables, which reach up to " SAWMOTOR_REACH;
    if (reason) return reason == 1 ? "an input is impossible" : "the motion is not finite";
    motor->time = now + step;
    return NULL;
}
