/* The averaged motor as plain C99: no allocation, no file, no global state that changes.
 *
 *     sawmotor_state state;
 *     sawmotor_start(&state, SAWMOTOR_PRELOAD, SAWMOTOR_LOAD);
 *     sawmotor_advance(&state, level, load_force, preload, 1e-5);
 *     x = sawmotor_position(&state);
 *
 * SI units, peak amplitudes, positions and velocities positive along +x.
 */
#ifndef SAWMOTOR_MOTOR_H
#define SAWMOTOR_MOTOR_H

/* PARAMETERS */

typedef struct {
    double number[SAWMOTOR_STATE_SIZE];
} sawmotor_state;

/* Put the slider at rest at time 0 and position 0. Return 0, or 1 where the preload is not positive. */
int sawmotor_start(sawmotor_state *state, double preload, double load_force);

/* Move on by a duration in s under constant inputs. Return 0, or 1 for an impossible input, 2 where the motion is not
 * finite.
 * level: of the drive (SAWMOTOR_LEVEL_UNIT); negative: of the drive the other way, if there is one (SAWMOTOR_DRIVES).
 * load_force: external force on the slider along +x, N. preload: N, positive. */
int sawmotor_advance(sawmotor_state *state, double level, double load_force, double preload, double duration);

double sawmotor_time(const sawmotor_state *state);               /* s */
double sawmotor_position(const sawmotor_state *state);           /* m */
double sawmotor_velocity(const sawmotor_state *state);           /* m/s */
double sawmotor_surface_amplitude(const sawmotor_state *state);  /* largest |u_z| under the contacts, m */
double sawmotor_force(const sawmotor_state *state);              /* mean tangential force on the slider, N */
double sawmotor_deformation(const sawmotor_state *state);        /* of the contacts, m */
double sawmotor_approach(const sawmotor_state *state);           /* mean approach of the contacts, m */
int sawmotor_sticks(const sawmotor_state *state);                /* 1: the slider sticks */
double sawmotor_temperature_rise(const sawmotor_state *state);   /* of the stator, mean, above its surroundings, K */
double sawmotor_power(double level);                             /* into the driven transducer in the steady state, W */

#endif
