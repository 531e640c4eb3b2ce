int sawmotor_start(sawmotor_state *state, double preload, double load_force) {
    if (!(preload > 0.0)) return 1;
    model_begin(parameters, tables, state->number, preload / SAWMOTOR_SHARE, load_force / SAWMOTOR_SHARE);
    return 0;
}

int sawmotor_advance(sawmotor_state *state, double level, double load_force, double preload, double duration) {
    if (!(preload > 0.0) || !(duration >= 0.0) || level != level || load_force != load_force) return 1;
    if (level < 0.0 && SAWMOTOR_DRIVES < 2) return 1;
    return model_advance(parameters, tables, state->number, level, load_force / SAWMOTOR_SHARE,
                         preload / SAWMOTOR_SHARE, duration) == 0 ? 0 : 2;
}

double sawmotor_time(const sawmotor_state *state) { return state->number[TIME]; }
double sawmotor_position(const sawmotor_state *state) { return state->number[POSITION]; }
double sawmotor_velocity(const sawmotor_state *state) { return state->number[VELOCITY]; }
double sawmotor_surface_amplitude(const sawmotor_state *state) { return state->number[SURFACE]; }
double sawmotor_force(const sawmotor_state *state) { return state->number[FORCE] * SAWMOTOR_SHARE; }
double sawmotor_deformation(const sawmotor_state *state) {
    return model_deformation(parameters, tables, (double *)state->number);
}
double sawmotor_approach(const sawmotor_state *state) { return state->number[APPROACH]; }
int sawmotor_sticks(const sawmotor_state *state) { return state->number[STICKS] > 0.5; }
double sawmotor_temperature_rise(const sawmotor_state *state) { return state->number[TEMPERATURE]; }
double sawmotor_power(double level) {
    int drive = level < 0.0 && SAWMOTOR_DRIVES > 1;
    return parameters[FIRST_DRIVE + drive * DRIVE_SIZE + POWER] * level * level;
}
