r"""Steady states of many scaled problems: the compiled loop behind `answers.population`.

One problem after the other, each in its own unit of length ell = max(rest approach, largest amplitude), so that nothing
of an answer depends on its neighbours. See `averaged.balance` for the equations.
"""

import numpy as np

from contact.jit.compiled import compiled, native
from contact.solve.averaged import DONE, balance_row, riding, room
from contact.solve.cycle_mean import cycle

# places in a row of parameters, as `scaling` orders them
PARAMETERS = 11
AVERAGING = 12.0  # just above the threshold first order errs by so many (f_n/f)^2
TURNS2 = 4.0 * np.pi**2  # (omega/f)^2
LEAST_STEP = 1e-4  # relative; a smaller change would measure rounding
EDGE = 2e-3  # velocity over the reference speed below which the threshold is near
SLENDEREST = 1e3  # larger over smaller amplitude up to which the smaller's error grows
NEARBY = 0.1  # relative change of velocity up to which secant steps serve
MOVED = 1e-4  # share of the second-order correction that is not trusted


def states(
    sliders, shapes, omegas, wave_errors, ratios, which, factors, out, todo, rule, harmonics, first, stride
):
    """Fill rows (v, h, regime, error, error from the wave, blocked thrust, held) of every `stride`-th of `todo`.

    In SI units, errors over max(|v|, omega |u_x|/10); regime 1 stick, 2 slip, 3 intermittent; a row that is not
    reached keeps regime 0.
    """
    contacts = shapes.shape[1]
    _states(
        sliders, shapes, omegas, wave_errors, ratios, which, factors, out, todo, rule, first, stride,
        np.zeros(PARAMETERS), np.zeros((3, 7)), np.zeros((2, contacts, 4)), *room(harmonics),
    )  # fmt: skip


@native("f2 f3 f1 f1 f1 i2 f1 f2 i1 f2 i i f1 f2 f3 f2 f1 f2 f1 i1")
def _states(sliders, shapes, omegas, wave_errors, ratios, which, factors, out, todo, rule, first, stride,
            parameters, answers, pair, still, sums, fast, all_sums, counts):  # fmt: skip
    """Do the work of `states`; what follows `stride` is room. Return 0."""
    contacts, harmonics = shapes.shape[1], fast.shape[1]
    start, better, tried = answers[0], answers[1], answers[2]
    waves, changed = pair[0], pair[1]
    for t in range(first, todo.size, stride):
        k = todo[t]
        slider, omega = sliders[which[k, 0]], omegas[which[k, 1]]
        mass, hertz, preload = slider[0], slider[1], slider[3]
        reach = along = 0.0
        for i in range(contacts):
            for j in range(4):
                waves[i, j] = shapes[which[k, 1], i, j] * factors[k]
            along = max(along, np.hypot(waves[i, 2], waves[i, 3]))
            reach = max(reach, along, np.hypot(waves[i, 0], waves[i, 1]))
        length = max((preload / (contacts * hertz)) ** (2.0 / 3.0), reach)
        unit = mass * omega**2 * length
        parameters[0] = hertz * length * np.sqrt(length) / unit
        parameters[1] = slider[6] * omega * length
        parameters[2] = slider[7] / (mass * omega)
        parameters[3] = preload / unit
        parameters[4] = slider[8] / (mass * omega)
        parameters[5] = slider[4] / unit
        parameters[6], parameters[7] = slider[5], slider[2]
        for i in range(contacts):
            for j in range(4):
                waves[i, j] /= length
        along /= length
        if balance_row(parameters, waves, rule, start, 0, still, sums, fast, all_sums, counts) != DONE:
            continue
        if start[0] < 0.0 and slider[4] > 0.0:  # which way the load points is for `mean_motion` to say
            continue
        for j in range(start.size):
            better[j] = start[j]
        if (
            start[3] == 0.0
            and balance_row(parameters, waves, rule, better, harmonics, still, sums, fast, all_sums, counts)
            != DONE
        ):
            continue
        v = better[0]
        reference = max(abs(v), along / 10.0)
        error = max(better[6], better[2], MOVED * abs(v - start[0]), 1e-11 * abs(v))
        if start[3] == 1.0 or abs(v) < EDGE * reference:
            # the averaging may have misjudged the edge: look at the amplitude larger by its error
            _changed(
                waves,
                1.0 + min(AVERAGING * ratios[which[k, 0]] ** 2 * TURNS2 / omega**2, 0.5),
                0.0,
                0.0,
                changed,
            )
            if balance_row(parameters, changed, rule, tried, 0, still, sums, fast, all_sums, counts) != DONE:
                continue
            error = max(error, abs(tried[0] - start[0]))
        lost = _from_wave(
            parameters,
            waves,
            changed,
            rule,
            start[0],
            wave_errors[which[k, 1]],
            tried,
            still,
            sums,
            fast,
            all_sums,
            counts,
        )
        if not (np.isfinite(v) and np.isfinite(error) and np.isfinite(lost)):
            continue
        out[k, 0], out[k, 1] = v * length * omega, better[1] * length
        out[k, 2] = 3.0 if better[4] > 0.0 else 2.0 if better[5] > 0.0 else 1.0
        out[k, 3] = error / reference if reference > 0.0 else 0.0
        out[k, 4] = lost / reference if reference > 0.0 else 0.0
        out[k, 5] = _stall(parameters, waves, rule, still, sums, counts) * unit
        out[k, 6] = start[3]
    return 0


@compiled
def _changed(waves, factor, shear, turn, out):
    """Set waves with both amplitudes, then the tangential one and its phase, changed.

    The last two by as many times more as the larger amplitude exceeds the smaller: errors are relative to the larger.
    """
    for i in range(waves.shape[0]):
        normal, along = np.hypot(waves[i, 0], waves[i, 1]), np.hypot(waves[i, 2], waves[i, 3])
        small, large = min(normal, along), max(normal, along)
        slender = min(large / small, SLENDEREST) if small > 0.0 else 1.0
        co, si = np.cos(turn * slender), np.sin(turn * slender)
        more = factor * (1.0 + shear * slender)
        out[i, 0], out[i, 1] = waves[i, 0] * factor, waves[i, 1] * factor
        out[i, 2] = more * (waves[i, 2] * co + waves[i, 3] * si)
        out[i, 3] = more * (waves[i, 3] * co - waves[i, 2] * si)


@compiled
def _from_wave(
    parameters, waves, changed, rule, base, wave_error, tried, still, sums, fast, all_sums, counts
):
    """Return the change of the first-order velocity by the wave's relative error; inf where it is not found."""
    if wave_error == 0.0:
        return 0.0
    step = max(wave_error, LEAST_STEP)
    slope = 0.0
    if base != 0.0:
        high, low = 1.0 + LEAST_STEP, 1.0 - LEAST_STEP
        slope = _surplus(parameters, waves, high * base, rule, still, sums, counts) - _surplus(
            parameters, waves, low * base, rule, still, sums, counts
        )
        slope /= (high - low) * base
    both = turned = 0.0
    for m in range(4):
        factor = 1.0 + step if m == 0 else 1.0 - step if m == 1 else 1.0
        _changed(waves, factor, step if m == 2 else 0.0, step if m == 3 else 0.0, changed)
        effect = abs(
            _moved(parameters, changed, base, slope, rule, tried, still, sums, fast, all_sums, counts) - base
        )
        if m < 2:
            both = max(both, effect)
        else:
            turned += effect**2
    return np.sqrt(both**2 + turned) * wave_error / step


@compiled
def _moved(parameters, waves, base, slope, rule, tried, still, sums, fast, all_sums, counts):
    """Return the first-order velocity on a wave a little different, by two secant steps where they are small."""
    if slope < 0.0:
        before, f = base, _surplus(parameters, waves, base, rule, still, sums, counts)
        v = base - f / slope
        if abs(v - base) < NEARBY * abs(base):
            g = _surplus(parameters, waves, v, rule, still, sums, counts)
            if v != before and g != f:
                last = v - g * (v - before) / (g - f)
                if abs(last - v) < 0.1 * abs(v - base):
                    return last
    return (
        tried[0]
        if balance_row(parameters, waves, rule, tried, 0, still, sums, fast, all_sums, counts) == DONE
        else np.inf
    )


@compiled
def _surplus(parameters, waves, v, rule, still, sums, counts):
    """Return the mean traction that is left to accelerate a slider riding at a velocity."""
    h = riding(parameters[0], waves, parameters[3], rule)
    cycle(parameters, waves, h, v, still, rule, sums, counts)
    return sums[1] - parameters[4] * v - parameters[5]


@compiled
def _stall(parameters, waves, rule, still, sums, counts):
    """Return the mean traction at rest at which the motor stalls, 0 where the unloaded slider is held."""
    h = riding(parameters[0], waves, parameters[3], rule)
    cycle(parameters, waves, h, 0.0, still, rule, sums, counts)
    low = sums[1]
    cycle(parameters, waves, h, -1e-300, still, rule, sums, counts)
    high = sums[1]
    return max(low if high > -low else -high, 0.0)
