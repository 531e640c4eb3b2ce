r"""Burst of a slider whose height, tilts and wave follow its velocity at once.

    m v' = sum <Q>(v, U(t)) - R_t v - load,

with <sum Q> from `averaged.coupled_motion` at each velocity and amplitude of the wave. There is no bounce. After the
burst the surface is at rest and friction slows the slider down evenly.
"""

import math
from types import SimpleNamespace

import numpy as np

from contact.averaged.coupled_motion import CoupledSearch, coupled_motion
from contact.averaged.runge_kutta import integrate, stages
from contact.choice import Answer
from contact.codes import Status
from contact.error_estimate import first_order_error, reference_speed
from contact.exceptions import ConvergenceError
from contact.passing_wave import resonance_ratio

RATE_TOLERANCE = 3e-5  # relative tolerance of the averaged velocity
# Parts of a burst under an envelope, at least, and for each change of its amplitude by the largest one: each part
# begins with a short step, so that none passes over a change of the wave
PARTS, PARTS_PER_CHANGE = 8, 2
LEAST_WAVE = 1e-3  # factor on the wave below which it does not move the slider


def quasi_static(slider, wave, time, duration, envelope):
    """Return (answer, velocities in m/s, mean approach in m) at times in s of a burst from rest and after it.

    ``envelope``: factor on the wave during the burst (`Envelope`), or None. The answer is the velocity at the end of
    the burst.
    """
    steady = coupled_motion(slider, wave)
    search, load = CoupledSearch(slider, wave, steady.rows.harmonics, steady.rows), steady.rows.load

    def rates(_, instant, velocity, out):
        size = 1.0 if envelope is None else float(np.interp(instant, envelope.time, np.abs(envelope.amplitude)))
        out[0] = 0.0
        if size >= LEAST_WAVE:
            force = search.traction(float(velocity[0]), load, size) - slider.tangential_damping * velocity[0] - load
            held = velocity[0] == 0.0 and force * math.copysign(1.0, steady.velocity) <= 0.0
            out[0] = 0.0 if held else force / slider.mass
        return Status.DONE

    during, velocity, work = time[time < duration], np.zeros(1), stages(1)
    record, tolerance = np.zeros((during.size, 1)), RATE_TOLERANCE * max(abs(steady.velocity), 1e-6)
    means = SimpleNamespace(rates=rates, sampled=lambda _, number: None)
    parts = 1 if envelope is None else max(PARTS, math.ceil(PARTS_PER_CHANGE * _changes(envelope)))
    for part in range(parts):
        start, stop = duration * part / parts, duration * (part + 1) / parts
        rates(means, start, velocity, work.rates[0])
        taken, span = int(np.searchsorted(during, start)), SimpleNamespace(stop=stop, at=during, record=record)
        first = min(duration / 64, 0.5 * (stop - start))
        if integrate(means, span, tolerance, start, taken, velocity, first, work) != Status.DONE:
            raise ConvergenceError("not converged", "the averaged velocity in the burst changes too abruptly")
    end, after = float(velocity[0]), time[time >= duration] - duration
    # the load assists friction in stopping the slider, or opposes it
    sign = math.copysign(1.0, end)
    slowing = (slider.static_coefficient * slider.preload + load * sign) / slider.mass
    slide = np.maximum(abs(end) - slowing * after, 0.0) if slowing > 0.0 else abs(end) - slowing * after
    error = 10 * RATE_TOLERANCE + first_order_error(resonance_ratio(slider, wave))
    answer = Answer(
        value=end, error=error * reference_speed(end, wave), reasons=("height, tilts and wave in equilibrium",)
    )
    return answer, np.append(record[:, 0], sign * slide), steady.height


def _changes(envelope) -> float:
    """Return the total variation of an envelope's amplitude over its largest value."""
    return float(np.abs(np.diff(envelope.amplitude)).sum() / max(envelope.amplitude.max(), LEAST_WAVE))
