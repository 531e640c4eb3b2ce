r"""The averaged equilibrium of many sliders and waves: one compiled loop, one error rule.

One problem after the other, each in its own unit of length ell = max(rest approach, largest amplitude), so that nothing
of an answer depends on its neighbours. See `averaged.balance_row` for the equations. `answers.sweep` asks for one row
or a million; every door to an averaged steady state leads here.

Error of the velocity: the largest of the harmonics left out, the residual, a share of the second-order correction and
rounding. Where the slider is held or hardly moves, averaging may have misjudged the threshold, by up to 12 (f_n/f)^2 in
amplitude; the velocity at an amplitude larger by that is added.
"""

import numpy as np

from contact.jit.compiled import compiled, native
from contact.solve.averaged import (
    COARSE,
    COLUMNS,
    DONE,
    FIRST,
    IS_HELD,
    LARGEST_AT_REST,
    LEAST_AT_REST,
    MADE_PER_CYCLE,
    NEAR_THRESHOLD,
    QUADRATURE,
    RESIDUAL,
    SLIPS_PER_CYCLE,
    TAIL,
    H,
    V,
    balance_row,
    riding,
    room,
    rules,
)
from contact.solve.cycle_mean import cycle

# places in a row of parameters, as `scaling` orders them
PARAMETERS = 11
# columns of an answer, SI units; the first velocity is that of first order, errors are over max(|v|, omega |u_x|/10)
VELOCITY, FIRST_ORDER, HEIGHT, REGIME, HELD, ERROR, FROM_WAVE, THRUST, LOAD_SIGN, STATUS, ANSWER = range(11)
UNKNOWN, STICK, SLIP, INTERMITTENT = 0, 1, 2, 3
# Relative error of the threshold amplitude over (f_n/f)^2: at 0.75 nm, just above the seed's threshold, first order
# errs by 12 (f_n/f)^2 in velocity (`tests/benchmarks/contact_ways.py`). At most half the amplitude is added.
THRESHOLD_ERROR, MAX_THRESHOLD_ERROR = 12.0, 0.5
# f_n/f up to which a slider that moves at the larger amplitude is called held, with that velocity as its error.
# Beyond, averaging cannot tell.
MAX_RATIO_HELD = 0.1
LEAST_STEP = 1e-4  # relative; a smaller change would measure rounding
EDGE = 2e-3  # velocity over the reference speed below which the threshold is near
MAX_AMPLITUDE_RATIO = 1e3  # larger over smaller amplitude up to which the smaller's error grows
NEARBY = 0.1  # relative change of velocity up to which secant steps serve
CORRECTION_ERROR = 1e-4  # share of the second-order correction that is not trusted


def states(sliders, shapes, omegas, wave_errors, ratios, which, factors, out, todo, harmonics, first, stride):
    """Fill the rows of `out`, by the names of the columns in this module, of every `stride`-th of `todo`.

    Parameters
    ----------
    sliders : (s, 9) array
        Mass, Hertz stiffness, slip limit over approach, preload, load, mu, chi, normal and tangential damping; SI.
    shapes : (w, contacts, 4) array
        Amplitudes of the waves, m: a, b of u_z = a cos + b sin, then of u_x.
    omegas, wave_errors : (w,) arrays
        rad/s; relative.
    ratios : (n,) array
        Contact resonance over the wave's frequency, per problem.
    which, factors : (n, 2) array of int, (n,) array
        Slider and wave of each problem, factor on the amplitudes.
    out : (n, ANSWER) array
        To be filled. A row that is not reached keeps its regime and says why in its status.
    todo : (k,) array of int
        Problems to be solved.
    harmonics : int
        Of the slider's fast motion.
    first, stride : int
        Which of `todo`.
    """
    contacts = shapes.shape[1]
    _states(
        sliders, shapes, omegas, wave_errors, ratios, which, factors, out, todo, *rules(), first, stride,
        np.zeros(PARAMETERS), np.zeros((2, COLUMNS)), np.zeros((2, contacts, 4)), *room(harmonics),
    )  # fmt: skip


@native("f2 f3 f1 f1 f1 i2 f1 f2 i1 f2 f2 i i f1 f2 f3 f2 f1 f2 f1 i1")
def _states(sliders, shapes, omegas, wave_errors, ratios, which, factors, out, todo, rule, fine, first, stride,
            parameters, answers, pair, still, sums, fast, all_sums, counts):  # fmt: skip
    """Do the work of `states`; what follows `stride` is room. Return 0."""
    harmonics = fast.shape[1]
    state, tried = answers[0], answers[1]
    waves, changed = pair[0], pair[1]
    for t in range(first, todo.size, stride):
        k = todo[t]
        omega = omegas[which[k, 1]]
        length, unit = _scaled(
            sliders[which[k, 0]], shapes[which[k, 1]], factors[k], omega, parameters, waves
        )
        along = 0.0
        for i in range(waves.shape[0]):
            along = max(along, np.hypot(waves[i, 2], waves[i, 3]))
        why = balance_row(
            parameters, waves, rule, fine, state, harmonics, still, sums, fast, all_sums, counts
        )
        out[k, STATUS] = why
        if why != DONE:
            continue
        v = state[V]
        reference = max(abs(v), along / 10.0)
        error = max(state[TAIL], state[RESIDUAL], state[QUADRATURE], 1e-11 * abs(v))
        error = max(error, CORRECTION_ERROR * abs(v - state[FIRST]))
        if state[IS_HELD] == 1.0 or abs(v) < EDGE * reference:
            larger = 1.0 + min(THRESHOLD_ERROR * ratios[k] ** 2, MAX_THRESHOLD_ERROR)
            _changed(waves, larger, 0.0, 0.0, changed)
            why = balance_row(parameters, changed, rule, fine, tried, 0, still, sums, fast, all_sums, counts)
            beyond = abs(tried[V] - state[FIRST])
            if why == DONE and beyond > 0.0 and ratios[k] > MAX_RATIO_HELD:
                why = NEAR_THRESHOLD
            out[k, STATUS] = why
            if why != DONE:
                continue
            error = max(error, beyond)
            reference = max(reference, beyond) if reference == 0.0 else reference
        lost = _from_wave(
            parameters,
            waves,
            changed,
            rule,
            fine,
            state[COARSE],
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
        stall = state[LEAST_AT_REST]
        if state[LARGEST_AT_REST] <= -stall:  # driven against its crests
            stall = -state[LARGEST_AT_REST]
        out[k, VELOCITY], out[k, FIRST_ORDER] = v * length * omega, state[FIRST] * length * omega
        out[k, HEIGHT] = state[H] * length
        out[k, REGIME] = STICK
        if state[MADE_PER_CYCLE] > 0.0:
            out[k, REGIME] = INTERMITTENT
        elif state[SLIPS_PER_CYCLE] > 0.0:
            out[k, REGIME] = SLIP
        out[k, HELD] = state[IS_HELD]
        out[k, ERROR] = error / reference if reference > 0.0 else 0.0
        out[k, FROM_WAVE] = lost / reference if reference > 0.0 else 0.0
        out[k, THRUST] = max(stall, 0.0) * unit
        out[k, LOAD_SIGN] = -1.0 if parameters[5] < 0.0 else 1.0
    return 0


@compiled
def _scaled(slider, shape, factor, omega, parameters, waves):
    """Fill the scaled parameters and waves of one problem; return the units of length and force."""
    contacts = waves.shape[0]
    mass, hertz, preload = slider[0], slider[1], slider[3]
    reach = 0.0
    for i in range(contacts):
        for j in range(4):
            waves[i, j] = shape[i, j] * factor
        along = np.hypot(waves[i, 2], waves[i, 3])
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
    return length, unit


@compiled
def _changed(waves, factor, shear, turn, out):
    """Set waves with both amplitudes, then the tangential one and its phase, changed.

    The last two by as many times more as the larger amplitude exceeds the smaller: errors are relative to the larger.
    """
    for i in range(waves.shape[0]):
        normal, along = np.hypot(waves[i, 0], waves[i, 1]), np.hypot(waves[i, 2], waves[i, 3])
        small, large = min(normal, along), max(normal, along)
        slender = min(large / small, MAX_AMPLITUDE_RATIO) if small > 0.0 else 1.0
        co, si = np.cos(turn * slender), np.sin(turn * slender)
        more = factor * (1.0 + shear * slender)
        out[i, 0], out[i, 1] = waves[i, 0] * factor, waves[i, 1] * factor
        out[i, 2] = more * (waves[i, 2] * co + waves[i, 3] * si)
        out[i, 3] = more * (waves[i, 3] * co - waves[i, 2] * si)


@compiled
def _from_wave(
    parameters, waves, changed, rule, fine, base, wave_error, tried, still, sums, fast, all_sums, counts
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
            _moved(parameters, changed, base, slope, rule, fine, tried, still, sums, fast, all_sums, counts)
            - base
        )
        if m < 2:
            both = max(both, effect)
        else:
            turned += effect**2
    return np.sqrt(both**2 + turned) * wave_error / step


@compiled
def _moved(parameters, waves, base, slope, rule, fine, tried, still, sums, fast, all_sums, counts):
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
        tried[COARSE]
        if balance_row(parameters, waves, rule, fine, tried, 0, still, sums, fast, all_sums, counts) == DONE
        else np.inf
    )


@compiled
def _surplus(parameters, waves, v, rule, still, sums, counts):
    """Return the mean traction that is left to accelerate a slider riding at a velocity."""
    h = riding(parameters[0], waves, parameters[3], rule)
    cycle(parameters, waves, h, v, still, rule, sums, counts)
    return sums[1] - parameters[4] * v - parameters[5]
