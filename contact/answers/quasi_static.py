r"""Burst of a slider whose height, tilts and wave follow its velocity at once.

    m v' = sum <Q>(v, U(t)) - R_t v - load,

with <sum Q> from `averaged.coupled_motion` at each velocity and amplitude of the wave. There is no bounce. After the
burst the surface is at rest and friction slows the slider down evenly.
"""

import math

import numpy as np

from contact.averaged.coupled_motion import CoupledSearch, coupled_motion
from contact.choice import Answer
from contact.error_estimate import first_order_error, reference_speed
from contact.exceptions import ConvergenceError
from contact.wave import resonance_ratio

RATE_TOLERANCE = 3e-5  # relative tolerance of the averaged velocity
LEAST_WAVE = 1e-3  # factor on the wave below which it does not move the slider


def quasi_static(slider, wave, time, duration, envelope):
    """Return (answer, velocities in m/s, mean approach in m) at times in s of a burst from rest and after it.

    ``envelope``: factor on the wave during the burst (`Envelope`), or None. The answer is the velocity at the end of
    the burst.
    """
    from scipy.integrate import solve_ivp

    steady = coupled_motion(slider, wave)
    search, load = CoupledSearch(slider, wave, steady.rows.harmonics, steady.rows), steady.rows.load

    def rate(instant, velocity):
        size = 1.0 if envelope is None else float(np.interp(instant, envelope.time, np.abs(envelope.amplitude)))
        if size < LEAST_WAVE:
            return [0.0]
        force = search.traction(velocity[0], load, size) - slider.tangential_damping * velocity[0] - load
        held = velocity[0] == 0.0 and force * math.copysign(1.0, steady.velocity) <= 0.0
        return [0.0 if held else force / slider.mass]

    during = np.append(time[time < duration], duration)
    solution = solve_ivp(
        rate, (0.0, duration), [0.0], method="RK45", t_eval=during, rtol=RATE_TOLERANCE,
        atol=RATE_TOLERANCE * max(abs(steady.velocity), 1e-6), max_step=duration / 8,
    )  # fmt: skip
    if not solution.success:
        raise ConvergenceError("not converged", f"the averaged velocity in the burst: {solution.message}")
    end, after = float(solution.y[0, -1]), time[time >= duration] - duration
    # the load assists friction in stopping the slider, or opposes it
    sign = math.copysign(1.0, end)
    slowing = (slider.static_coefficient * slider.preload + load * sign) / slider.mass
    slide = np.maximum(abs(end) - slowing * after, 0.0) if slowing > 0.0 else abs(end) - slowing * after
    error = 10 * RATE_TOLERANCE + first_order_error(resonance_ratio(slider, wave))
    answer = Answer(
        value=end, error=error * reference_speed(end, wave), reasons=("height, tilts and wave in equilibrium",)
    )
    return answer, np.append(solution.y[0, :-1], sign * slide), steady.height
