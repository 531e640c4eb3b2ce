r"""The event-exact motion: stretch after stretch, each ended by the first root of any guard.

A stretch is first laid out to its longest length; if a guard turns negative on it, the root is found on the
interpolant, the stretch is laid out anew to end there, and its length is corrected by Newton's method with the
guard's true rate until the guard vanishes to rounding. Extrema of every guard between the nodes are searched too, so no
contact is skipped. A stretch whose highest Chebyshev coefficients exceed the tolerance, or on which Picard's iteration
does not gain, is halved.
"""

import numpy as np

from contact.collocation import ROOT_AT_END, ROOT_AT_START, SMOOTH
from contact.compiled import compiled
from contact.energy import DISPLACEMENT, account, mark
from contact.events import earliest, end_guard, transit
from contact.memory import write_curve
from contact.regimes import (
    ANNULUS,
    GROW,
    SEPARATED,
    STICK,
)
from contact.roots import interpolate
from contact.stretch import (
    CLIMB,
    HEIGHT,
    LEVEL,
    PLANES,
    PULL,
    PUSH,
    SPEED,
    P,
    Q,
    X,
    Z,
    guess,
    surface,
    sweep,
)

# why a run ended
DONE, NOT_FINITE, TOO_MANY, STIFF, FULL = 0, 1, 2, 3, 4
# places in the tally after the kinds of event: stretches, halvings, sweeps, cycles
# and, after them, events at one instant beyond one per contact
STRETCHES, HALVINGS, SWEEPS, CYCLES, CHATTER, TALLY = 6, 7, 8, 9, 10, 12


@compiled
def _lay_out(parameters, waves, tau, once, twice, sigma, bary, state, regime, sign, phase, length, shared, own,
             mobile, memory):  # fmt: skip
    surface(phase, length, tau, waves, own)
    guess(state, length, tau, shared[PUSH, 0], shared[PULL, 0], shared)
    return sweep(
        parameters,
        state,
        length,
        tau,
        once,
        twice,
        regime,
        sign,
        shared,
        own,
        mobile,
        sigma,
        bary,
        memory,
        25,
    )


@compiled
def _fraction(s, map_):
    """Return tau at s in [0, 1]."""
    if map_ == ROOT_AT_START:
        return s * s
    return 1.0 - (1.0 - s) ** 2 if map_ == ROOT_AT_END else s


@compiled
def _roughness(tail, own, length, push_scale, pull_scale):
    """Return the largest of the two highest Chebyshev coefficients of the forces, times length over scale."""
    # an impact without preload has its own scale
    most = 1e-3 * np.max(own[P])
    if most > push_scale:
        push_scale, pull_scale = most, most * pull_scale / push_scale
    worst = 0.0
    for r in range(2):
        for i in range(own.shape[1]):
            ep, eq = 0.0, 0.0
            for k in range(own.shape[2]):
                ep += tail[r, k] * own[P, i, k]
                eq += tail[r, k] * own[Q, i, k]
            worst = max(worst, length * abs(ep) / push_scale, length * abs(eq) / pull_scale)
    return worst


@compiled
def _record(phase, length, map_, sigma, bary, shared, own, regime, sample_phase, samples, taken):
    """Interpolate the samples that fall on the stretch; return how many are taken by now."""
    while taken < sample_phase.size and sample_phase[taken] <= phase + length:
        t = min(max((sample_phase[taken] - phase) / length, 0.0), 1.0)
        if map_ == ROOT_AT_START:
            t = np.sqrt(t)
        elif map_ == ROOT_AT_END:
            t = 1.0 - np.sqrt(1.0 - t)
        for i in range(regime.size):
            for k in range(4):
                samples[taken, i, k] = interpolate(2.0 * t - 1.0, sigma, bary, own[Z + k, i])
            samples[taken, i, 4] = regime[i]
            samples[taken, i, 5] = interpolate(2.0 * t - 1.0, sigma, bary, shared[SPEED])
        taken += 1
    return taken


@compiled
def advance(parameters, waves, sigma, bary, taus, onces, twices, rates, tail, state, regime, sign, phase, stop, mobile,
            tolerance, tally, sums, sample_phase, samples, limit, memory):  # fmt: skip
    """Move the state from one phase to another; return the reason for ending.

    Parameters
    ----------
    parameters, waves : arrays
        See `scaling`.
    sigma, bary, taus, onces, twices, rates, tail : arrays
        See `collocation`.
    state, regime, sign : (3 + contacts,), (contacts,), (contacts,) arrays
        Slider position, its rate, slider velocity, deformations; all changed in place.
    phase, stop : float
        Start and end; with a wave, within one cycle (rounding).
    mobile : bool
        False: the slider's velocity stays as it is whatever the forces (a body of infinite mass).
    tolerance : float
        Truncation allowed per stretch, relative to the friction and preload impulse of a radian.
    tally, sums : (TALLY,) int array, (SUMS,) array
        Added to; see `energy` for the sums.
    sample_phase, samples : (k,), (k, contacts, 6) arrays
        Where to record z, x, P, Q, regime and v; rising, in (phase, stop]. Recording alters nothing else.
    limit : int
        Largest number of stretches.
    memory : memory.Memory or None
        Of the hysteretic law; None for the elastic one, and then nothing of it is compiled.
    """
    contacts, n = regime.size, sigma.size
    shared, own, values = np.zeros((6, n)), np.zeros((PLANES, contacts, n)), np.empty(n)
    c, band, longest = parameters[7], parameters[8], parameters[9]
    push_scale, pull_scale = parameters[3] + 1e-300, parameters[6] * parameters[3] + 1e-300
    length, idle, taken, spent = longest, 0, 0, 0
    entered = False  # the stretch starts where a contact was made
    while phase < stop:
        spent += 1
        if spent > limit:
            return TOO_MANY
        if memory is not None and np.max(memory.count) > memory.kind.shape[1] - 4:
            return FULL
        if not np.isfinite(state[0] + state[1] + state[2]):
            return NOT_FINITE
        length = min(length, longest)
        closing = phase + length >= stop - 1e-12
        if closing:
            length = stop - phase
        map_ = ROOT_AT_START if entered else SMOOTH
        ok, count = _lay_out(parameters, waves, taus[map_], onces[map_], twices[map_], sigma, bary, state, regime, sign,
                             phase, length, shared, own, mobile, memory)  # fmt: skip
        tally[SWEEPS] += count
        if not ok:
            length *= 0.25
            tally[HALVINGS] += 1
            if length < 1e-9 * longest:
                return STIFF
            continue
        full = length
        place, who, which = earliest(sigma, bary, rates, regime, sign, shared, own, c, band, memory, values)
        for _ in range(12):
            if who < 0:
                break
            closing = False
            length *= _fraction(0.5 * (min(place, 1.0) + 1.0), map_)
            sharp = (which == 0 and regime[who] != SEPARATED) or (which == 1 and regime[who] == STICK)
            sharp = sharp or (which == 2 and regime[who] == ANNULUS)
            if sharp and entered and length > 1e-9:  # roots at both ends: cut in the middle
                length *= 0.5
                who = -1
            elif sharp:
                map_ = ROOT_AT_END
            for trial in range(12):
                if length < 1e-14:
                    length = 0.0
                _, count = _lay_out(parameters, waves, taus[map_], onces[map_], twices[map_], sigma, bary, state,
                                    regime, sign, phase, length, shared, own, mobile, memory)  # fmt: skip
                tally[SWEEPS] += count
                if who < 0:
                    break
                value, rate = end_guard(
                    who, which, regime, sign, shared, own, waves, phase + length, c, band, memory
                )
                if length == 0.0 or abs(value) < 1e-16 or not rate < 0.0:
                    break
                step = -value / rate
                if abs(step) < 2e-16 or (trial > 6 and abs(step) < 1e-14):
                    break
                length = min(max(length + step, 0.5 * length), min(1.1 * length + 1e-12, full))
            if length == 0.0 or who < 0:
                break
            # with the better motion another guard may come first
            place, other, another = earliest(
                sigma, bary, rates, regime, sign, shared, own, c, band, memory, values
            )
            if other < 0 or (other == who and another == which) or place > 1.0 - 1e-6:
                break
            who, which = other, another
        if length > 0.0:
            rough = _roughness(tail, own, length, push_scale, pull_scale)
            change = min(2.0, max(0.2, 0.9 * (tolerance / (rough + 1e-300)) ** (1.0 / (n - 1))))
            if rough > tolerance and length > 1e-6 * longest:
                length *= min(change, 0.7)
                tally[HALVINGS] += 1
                continue
            tally[STRETCHES] += 1
            account(parameters, length, onces[map_], regime, sign, shared, own, sums)
            taken = _record(
                phase, length, map_, sigma, bary, shared, own, regime, sample_phase, samples, taken
            )
            state[0], state[1], state[2] = shared[HEIGHT, n - 1], shared[CLIMB, n - 1], shared[SPEED, n - 1]
            for i in range(contacts):
                state[3 + i] = own[X, i, n - 1]
                if memory is not None and regime[i] == GROW:
                    write_curve(memory, i, own[Z, i], own[X, i], own[LEVEL, i], c, rates)
            shared[PUSH, 0], shared[PULL, 0] = shared[PUSH, n - 1], shared[PULL, n - 1]
            phase = stop if closing else phase + length
            idle, entered = 0, False
            length = max(length * change, 0.3 * full)
        else:
            idle += 1
            if idle > contacts:
                tally[CHATTER] += 1
            if idle > 20 * contacts + 20:
                return TOO_MANY
            length = full
        if who >= 0:
            made = transit(
                parameters,
                waves,
                sigma,
                bary,
                state,
                regime,
                sign,
                phase,
                who,
                which,
                shared,
                own,
                memory,
                tally,
            )
            mark(sums)
            entered = entered or made
    return DONE


@compiled
def cycles(parameters, waves, sigma, bary, taus, onces, twices, rates, tail, state, regime, sign, number, mobile,
           tolerance, tally, sums, stride, speeds, limit, memory):  # fmt: skip
    """Move through whole cycles; record phase-0 velocity and height every `stride` cycles; return the reason.

    `speeds` has a row (v, z_s, mean v of the last cycle) per record; stride 0 records nothing.
    """
    nothing, none = np.empty(0), np.empty((0, regime.size, 6))
    for k in range(number):
        before = sums[DISPLACEMENT]
        why = advance(parameters, waves, sigma, bary, taus, onces, twices, rates, tail, state, regime, sign, 0.0,
                      2.0 * np.pi, mobile, tolerance, tally, sums, nothing, none, limit, memory)  # fmt: skip
        if why != DONE:
            return why
        tally[CYCLES] += 1
        if stride > 0 and (k + 1) % stride == 0:
            row = (k + 1) // stride - 1
            speeds[row, 0] = state[2]
            speeds[row, 1] = state[0]
            speeds[row, 2] = (sums[DISPLACEMENT] - before) / (2.0 * np.pi)
    return DONE
