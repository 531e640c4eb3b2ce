r"""Many cycles in fixed steps: the stop operator inside a Verlet step.

Positions by Verlet, forces at the step's ends, and the stop operator as a projection: the deformation follows the
surface and is cut to [-c z, c z]. Two corrections keep the order at about 2.5 where plain projection drops to 1:

* entry: the instant of contact is found on the cubic through the approach and its rates, and the deformation grows
  from that instant only;
* end of slip: where the slip speed changes sign within the step, the deformation leaves the limit from that instant.

The force is known to h^2.5 at a contact in mid-step (t^1.5), whatever else is done. The surface motion of one cycle is
tabulated. Not for a stick band (creep), nor where the contact resonance is not well resolved by the step.
"""

import numpy as np

from contact.compiled import compiled


@compiled
def _entry(z0, z1, r0, r1):
    """Return the fraction of the step (rates times step in r0, r1) at which the cubic approach leaves zero."""
    s = z0 / (z0 - z1)
    for _ in range(4):
        value = z0 + s * (r0 + s * (3.0 * (z1 - z0) - 2.0 * r0 - r1 + s * (2.0 * (z0 - z1) + r0 + r1)))
        slope = r0 + s * (2.0 * (3.0 * (z1 - z0) - 2.0 * r0 - r1) + s * 3.0 * (2.0 * (z0 - z1) + r0 + r1))
        if slope <= 0.0:
            return s
        s = min(max(s - value / slope, 0.0), 1.0)
    return s


@compiled
def steps(parameters, waves, state, number, per_cycle, stride, rows):
    """Move through `number` whole cycles of `per_cycle` steps; record (v, z_s, mean v) every `stride` cycles.

    `state` (z_s, z_s', v, x_1..x_n) is changed in place; arguments as in `integrate.cycles`. Returns False if the
    motion is not finite.
    """
    kappa, chi, d_n, p, d_t, q, mu, c = parameters[:8]
    n = waves.shape[0]
    h = 2.0 * np.pi / per_cycle
    u_z, u_x = np.empty((per_cycle + 1, n)), np.empty((per_cycle + 1, n))
    w_z, w_x = np.empty((per_cycle + 1, n)), np.empty((per_cycle + 1, n))
    for k in range(per_cycle + 1):
        co, si = np.cos(h * (k % per_cycle)), np.sin(h * (k % per_cycle))
        for i in range(n):
            u_z[k, i], u_x[k, i] = waves[i, 0] * co + waves[i, 1] * si, waves[i, 2] * co + waves[i, 3] * si
            w_z[k, i], w_x[k, i] = waves[i, 1] * co - waves[i, 0] * si, waves[i, 3] * co - waves[i, 2] * si
    height, climb, speed = state[0], state[1], state[2]
    x = state[3:].copy()
    slip = np.zeros(n)  # sign of the slip, 0 in stick
    z = np.empty(n)
    push, pull = 0.0, 0.0  # contact forces alone
    for i in range(n):
        z[i] = u_z[0, i] - height
        if z[i] > 0.0:
            elastic = kappa * z[i] * np.sqrt(z[i])
            push += elastic * (1.0 + chi * (w_z[0, i] - climb))
            left = max(1.0 - abs(x[i]) / (c * z[i]), 0.0)
            pull += np.sign(x[i]) * mu * elastic * (1.0 - left * np.sqrt(left))
            slip[i] = np.sign(x[i]) if left < 1e-13 else 0.0
    damp_n, damp_t = 1.0 / (1.0 + 0.5 * h * d_n), 1.0 / (1.0 + 0.5 * h * d_t)
    for cycle in range(number):
        travelled = 0.0
        for k in range(per_cycle):
            climb_half = climb + 0.5 * h * (push - p - d_n * climb)
            speed_half = speed + 0.5 * h * (pull - q - d_t * speed)
            height += h * climb_half
            travel = h * speed_half
            travelled += travel
            climb_next = 2.0 * climb_half - climb  # enough for rates at the step's end
            speed_next = 2.0 * speed_half - speed
            push, pull = 0.0, 0.0
            for i in range(n):
                z_old, z_new = z[i], u_z[k + 1, i] - height
                z[i] = z_new
                if z_new <= 0.0:
                    x[i], slip[i] = 0.0, 0.0
                    continue
                z_rate, x_rate = w_z[k + 1, i] - climb_next, w_x[k + 1, i] - speed_next
                limit = c * z_new
                if z_old <= 0.0:
                    s = _entry(z_old, z_new, h * (w_z[k, i] - climb), h * z_rate)
                    x_rate_old = w_x[k, i] - speed
                    mean_rate = 0.5 * ((1.0 + s) * x_rate + (1.0 - s) * x_rate_old)
                    deformation = h * (1.0 - s) * mean_rate
                else:
                    deformation = x[i] + u_x[k + 1, i] - u_x[k, i] - travel
                    if slip[i] != 0.0:
                        v_old = slip[i] * (w_x[k, i] - speed) - c * (w_z[k, i] - climb)
                        v_new = slip[i] * x_rate - c * z_rate
                        if v_new < 0.0 < v_old:  # slip ends within the step
                            rest = h * v_new / (v_new - v_old)
                            deformation = slip[i] * (limit + 0.5 * rest * v_new)
                slip[i] = 0.0
                if deformation >= limit:
                    deformation, slip[i] = limit, 1.0
                elif deformation <= -limit:
                    deformation, slip[i] = -limit, -1.0
                x[i] = deformation
                elastic = kappa * z_new * np.sqrt(z_new)
                push += elastic * (1.0 + chi * z_rate)
                if slip[i] != 0.0:
                    pull += slip[i] * mu * elastic
                else:
                    left = 1.0 - abs(deformation) / limit
                    force = mu * elastic * (1.0 - left * np.sqrt(left))
                    pull += force if deformation > 0.0 else -force
            climb = (climb_half + 0.5 * h * (push - p)) * damp_n
            speed = (speed_half + 0.5 * h * (pull - q)) * damp_t
        if not np.isfinite(height + climb + speed):
            return False
        if stride > 0 and (cycle + 1) % stride == 0:
            row = (cycle + 1) // stride - 1
            rows[row, 0], rows[row, 1], rows[row, 2] = speed, height, travelled / (2.0 * np.pi)
    state[0], state[1], state[2] = height, climb, speed
    state[3:] = x
    return True
