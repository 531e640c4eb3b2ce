/* The averaged motor in the plane as plain C99: no allocation, no file, no global state that changes.
 *
 *     sawmotor_state state;
 *     sawmotor_inputs inputs = SAWMOTOR_INPUTS;
 *     sawmotor_start(&state);
 *     inputs.level[0] = 10.0;
 *     sawmotor_advance(&state, &inputs, 1e-5);
 *     x = sawmotor_pose(&state)[0];
 *
 * SI units, peak amplitudes; x and y along the surface, yaw positive from x to y.
 */
#ifndef SAWMOTOR_MOTOR_H
#define SAWMOTOR_MOTOR_H

/* PARAMETERS */

typedef struct {
    double number[SAWMOTOR_STATE_SIZE];
} sawmotor_state;

typedef struct {
    double level[2];  /* of each drive (SAWMOTOR_DRIVES), zero or positive, SAWMOTOR_LEVEL_UNIT */
    double force[2];  /* external force on the slider along +x and +y, N */
    double torque;    /* external, of positive yaw, N m */
    double preload;   /* N, positive */
} sawmotor_inputs;

/* Put the slider at rest at time 0, at its first place. */
void sawmotor_start(sawmotor_state *state);

/* Move on by a duration in s under constant inputs. Return 0, or 1 for an impossible input, 2 where the motion is not
 * finite, 3 where the levels lie beyond the tables (SAWMOTOR_REACH). */
int sawmotor_advance(sawmotor_state *state, const sawmotor_inputs *inputs, double duration);

double sawmotor_time(const sawmotor_state *state);                      /* s */
const double *sawmotor_pose(const sawmotor_state *state);               /* x, y in m, yaw in rad */
const double *sawmotor_rates(const sawmotor_state *state);              /* m/s, m/s, rad/s */
double sawmotor_surface_amplitude(const sawmotor_state *state, int drive); /* largest |u_z| under the contacts, m */
const double *sawmotor_force(const sawmotor_state *state);              /* mean, of the contacts: N, N, N m */
int sawmotor_sticks(const sawmotor_state *state);                       /* 1: friction holds the slider */

#endif
