void sawmotor_start(sawmotor_state *state) { model_begin(parameters, state->number); }

int sawmotor_advance(sawmotor_state *state, const sawmotor_inputs *inputs, double duration) {
    double first = inputs->level[0], second = SAWMOTOR_DRIVES > 1 ? inputs->level[1] : 0.0;
    double known = inputs->force[0] + inputs->force[1] + inputs->torque;
    if (!(inputs->preload > 0.0) || !(duration >= 0.0) || !(first >= 0.0) || !(second >= 0.0) || known != known) return 1;
    double failed = model_advance(parameters, tables, state->number, first, second, inputs->force[0], inputs->force[1],
                                  inputs->torque, inputs->preload, duration);
    return failed == 0.0 ? 0 : failed == 1.0 ? 2 : 3;
}

double sawmotor_time(const sawmotor_state *state) { return state->number[TIME]; }
const double *sawmotor_pose(const sawmotor_state *state) { return state->number + POSE; }
const double *sawmotor_rates(const sawmotor_state *state) { return state->number + RATES; }
double sawmotor_surface_amplitude(const sawmotor_state *state, int drive) {
    return state->number[LEVEL + drive] * parameters[AMPLITUDE + drive];
}
const double *sawmotor_force(const sawmotor_state *state) { return state->number + FORCE; }
int sawmotor_sticks(const sawmotor_state *state) { return state->number[RESTS] > 0.5; }
