r"""The event-exact motion: stretch after stretch, each ended by the first root of any guard.

A stretch is first laid out to its longest length; if a guard turns negative on it, the root is found on the
interpolant, the stretch is laid out anew to end there, and its length is corrected by Newton's method with the
guard's true rate until the guard vanishes to rounding. Where the last cycle had the same stretch, the length and the
accelerations of that one are the first guess, and Newton's and Picard's iterations go on together. Extrema of every
guard between the nodes are searched in either case, so no contact is skipped. A stretch whose highest Chebyshev
coefficients exceed the tolerance, or on which Picard's iteration does not gain, is halved.
"""

import numpy as np

from contact.interpolation import interpolate
from contact.jit.compiled import compiled, native
from contact.law.elastic import (
    ANNULUS,
    GROW,
    SEPARATED,
    STICK,
)
from contact.law.hysteretic import write_curve
from contact.solve.collocation import ROOT_AT_END, ROOT_AT_START, SMOOTH
from contact.solve.energy import DISPLACEMENT, account, mark
from contact.solve.events import earliest, end_guard, transit
from contact.solve.segment import (
    CLIMB,
    HEIGHT,
    LEVEL,
    PULL,
    PUSH,
    SPEED,
    P,
    Q,
    X,
    Z,
    end_kinematics,
    forces,
    guess,
    integrate,
    still,
    surface,
    sweep,
)
from contact.solve.warm_start import END, MAP, WHICH, WHO, kept, matching, recalled

# why a run ended
DONE, NOT_FINITE, TOO_MANY, STIFF, FULL = 0, 1, 2, 3, 4
# places in the tally after the kinds of event: stretches, halvings, sweeps, cycles
# and, after them, events at one instant beyond one per contact
STRETCHES, HALVINGS, SWEEPS, CYCLES, CHATTER, TALLY = 6, 7, 8, 9, 10, 12


@compiled
def _lay_out(problem, tau, columns, sigma, bary, state, regime, sign, phase, length, shared, own,
             mobile, memory):  # fmt: skip
    surface(phase, length, tau, problem.paths, own)
    guess(state, length, tau, shared[PUSH, 0], shared[PULL, 0], shared)
    converged = sweep(
        problem, state, length, tau, columns, regime, sign, shared, own, mobile, sigma, bary, memory, 25,
    )  # fmt: skip
    end_kinematics(regime, sign, state[3:], problem.limit_slope, shared, own)
    return converged


@compiled
def _fraction(s, map_):
    """Return tau at s in [0, 1]."""
    if map_ == ROOT_AT_START:
        return s * s
    return 1.0 - (1.0 - s) ** 2 if map_ == ROOT_AT_END else s


@compiled
def _sharp(which, regime):
    """Return whether a guard's root is one at which the force has a square root."""
    if which == 0:
        return regime != SEPARATED
    return (which == 1 and regime == STICK) or (which == 2 and regime == ANNULUS)


@compiled
def _met(problem, tau, columns, sigma, bary, rates, state, regime, sign, phase, length, end, who, which,
         shared, own, mobile, memory, values, tally):  # fmt: skip
    """Lay a stretch out from recalled accelerations to the event at its end, if any; return its length, 0 if it fails.

    Newton's iteration for the length and Picard's for the motion in one.
    """
    c, band = problem.limit_slope, problem.stick_band
    surface(phase, length, tau, problem.paths, own)
    integrate(state, length, tau, columns, shared)
    last = np.inf
    for _ in range(15):
        forces(problem, regime, sign, state[3:], shared, own, mobile, length, columns, sigma, bary, memory)
        change = 0.0
        if mobile:
            change = integrate(state, length, tau, columns, shared) / (1.0 + abs(state[0]))
        tally[SWEEPS] += 1
        if not change < 1e100:
            return 0.0
        arrived = still(change, last)
        last = change
        end_kinematics(regime, sign, state[3:], c, shared, own)
        if who >= 0:
            value, rate = end_guard(
                who, which, regime, sign, shared, own, problem.paths, phase + length, c, band, memory
            )
            step = -value / rate
            if not rate < 0.0 or abs(step) > 0.2 * length:
                return 0.0
            if abs(value) >= 1e-16 and abs(step) >= 2e-16:
                arrived = False
                length += step
                if not 0.0 < length < end:
                    return 0.0
                surface(phase, length, tau, problem.paths, own)
        if arrived:
            place, other, _ = earliest(sigma, bary, rates, regime, sign, shared, own, c, band, memory, values)
            # an event that this stretch did not have: the usual way will find it
            return length if other < 0 or (who >= 0 and place > 1.0 - 1e-6) else 0.0
    return 0.0


@compiled
def _roughness(tail, own, length, push_scale, pull_scale):
    """Return the largest of the two highest Chebyshev coefficients of the forces, times length over scale."""
    # an impact without preload has its own scale
    most = 0.0
    for i in range(own.shape[1]):
        for k in range(own.shape[2]):
            most = max(most, 1e-3 * own[P, i, k])
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
def advance(problem, sigma, bary, taus, columns, rates, tail, state, regime, sign, phase, stop, mobile,
            tolerance, tally, sums, sample_phase, samples, limit, memory, count, marks, numbers, new, shared, own,
            values):  # fmt: skip
    """Move the state from one phase to another; return the reason for ending; see `travel`.

    The pattern's row `new` is filled, the other one is the guess.
    """
    contacts, n = regime.size, sigma.size
    c, band, longest = problem.limit_slope, problem.stick_band, problem.longest
    push_scale, pull_scale = problem.preload + 1e-300, problem.friction * problem.preload + 1e-300
    length, idle, taken, spent = longest, 0, 0, 0
    old, first, familiar = 1 - new, 0, True
    count[new] = 0
    entered = False  # the stretch starts where a contact was made
    while phase < stop:
        spent += 1
        if spent > limit:
            return TOO_MANY
        if memory is not None:
            for i in range(contacts):
                if memory.count[i] > memory.kind.shape[1] - 4:
                    return FULL
        if not np.isfinite(state[0] + state[1] + state[2]):
            return NOT_FINITE
        push, pull = shared[PUSH, 0], shared[PULL, 0]
        length = min(length, longest)
        who, which, closing, full = -1, -1, False, 0.0
        m = matching(count, marks, numbers, old, first, phase, regime, sign) if familiar else -1
        if m >= 0:
            first = m + 1
            end, map_, who, which = (
                numbers[old, m, END],
                marks[old, m, MAP],
                marks[old, m, WHO],
                marks[old, m, WHICH],
            )
            closing = who < 0 and end >= stop - 1e-12
            end = (stop if closing else end) - phase
            if 0.0 < end <= longest and phase + end <= stop and (map_ == ROOT_AT_START) == entered:
                recalled(numbers, old, m, shared)
                full = _met(problem, taus[map_], columns[map_], sigma, bary, rates, state, regime, sign,
                            phase, end, min(longest, stop - phase), who, which, shared, own, mobile, memory, values,
                            tally)  # fmt: skip
                length = full if full > 0.0 else length
        if full == 0.0:
            who, which = -1, -1
            shared[PUSH, 0], shared[PULL, 0] = push, pull
            closing = phase + length >= stop - 1e-12
            if closing:
                length = stop - phase
            map_ = ROOT_AT_START if entered else SMOOTH
            ok, tried = _lay_out(problem, taus[map_], columns[map_], sigma, bary, state, regime, sign,
                                 phase, length, shared, own, mobile, memory)  # fmt: skip
            tally[SWEEPS] += tried
            if not ok:
                length *= 0.25
                tally[HALVINGS] += 1
                if length < 1e-9 * longest:
                    return STIFF
                continue
            full = length
            place, who, which = earliest(
                sigma, bary, rates, regime, sign, shared, own, c, band, memory, values
            )
            for _ in range(12):
                if who < 0:
                    break
                closing = False
                length *= _fraction(0.5 * (min(place, 1.0) + 1.0), map_)
                sharp = _sharp(which, regime[who])
                if sharp and entered and length > 1e-9:  # roots at both ends: cut in the middle
                    length *= 0.5
                    who = -1
                elif sharp:
                    map_ = ROOT_AT_END
                for trial in range(12):
                    if length < 1e-14:
                        length = 0.0
                    _, tried = _lay_out(problem, taus[map_], columns[map_], sigma, bary, state, regime,
                                        sign, phase, length, shared, own, mobile, memory)  # fmt: skip
                    tally[SWEEPS] += tried
                    if who < 0:
                        break
                    value, rate = end_guard(
                        who, which, regime, sign, shared, own, problem.paths, phase + length, c, band, memory
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
            change = 1.0
            if m < 0 or rough > tolerance:
                change = min(2.0, max(0.2, 0.9 * (tolerance / (rough + 1e-300)) ** (1.0 / (n - 1))))
            if rough > tolerance and length > 1e-6 * longest:
                length *= min(change, 0.7)
                tally[HALVINGS] += 1
                shared[PUSH, 0], shared[PULL, 0] = push, pull
                familiar = False
                continue
            familiar = True
            tally[STRETCHES] += 1
            account(problem, length, columns[map_, 0], regime, sign, shared, own, sums)
            taken = _record(
                phase, length, map_, sigma, bary, shared, own, regime, sample_phase, samples, taken
            )
            begin = phase
            phase = stop if closing else phase + length
            kept(count, marks, numbers, new, begin, phase, map_, who, which, regime, sign, shared)
            state[0], state[1], state[2] = shared[HEIGHT, n - 1], shared[CLIMB, n - 1], shared[SPEED, n - 1]
            for i in range(contacts):
                state[3 + i] = own[X, i, n - 1]
                if memory is not None and regime[i] == GROW:
                    write_curve(memory, i, own[Z, i], own[X, i], own[LEVEL, i], c, rates)
            shared[PUSH, 0], shared[PULL, 0] = shared[PUSH, n - 1], shared[PULL, n - 1]
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
                problem, sigma, bary, state, regime, sign, phase, who, which, shared, own, memory, tally,
            )  # fmt: skip
            mark(sums)
            entered = entered or made
    return DONE


@native(
    "t f1 f1 f2 f4 f2 f2 f1 i1 f1 f f i i f i1 f1 f1 f3 i f2 i t i1 i3 f3 f2 f3 f1",
    {
        "problem.paths.height": "n", "problem.paths.normal_cos": "n", "problem.paths.tangential_cos": "n",
        "sigma": "m", "bary": "m", "taus": "3 m", "columns": "3 2 m m",
        "rates": "m m", "tail": "2 m", "state": "3+n", "regime": "n", "sign": "n", "tally": "12", "sums": "13",
        "sample_phase": "s", "samples": "s n 6", "speeds": "r 3", "memory.count": "n", "memory.kind": "n p",
        "memory.corner": "n p 4", "memory.curve": "n p 5 m", "memory.level": "n", "count": "2", "marks": "2 c 3+2n",
        "numbers": "2 c 2+2m", "shared": "6 m", "own": "11 n m", "values": "m",
    },
)  # fmt: skip
def travel(problem, sigma, bary, taus, columns, rates, tail, state, regime, sign, start, stop, number, mobile,
           tolerance, tally, sums, sample_phase, samples, stride, speeds, limit, memory, count, marks, numbers, shared,
           own, values):  # fmt: skip
    """Move the state from one phase to another, or again and again over the same cycle; return the reason for ending.

    Parameters
    ----------
    problem : Problem
    sigma, bary, taus, columns, rates, tail : arrays
        See `collocation`.
    state, regime, sign : (3 + contacts,), (contacts,), (contacts,) arrays
        Slider position, its rate, slider velocity, deformations; all changed in place.
    start, stop : float
        Phases; with a wave, within one cycle (rounding).
    number : int
        How many times; more than once over a whole cycle only.
    mobile : bool
        False: the slider's velocity stays as it is whatever the forces (a body of infinite mass).
    tolerance : float
        Truncation allowed per stretch, relative to the friction and preload impulse of a radian.
    tally, sums : (TALLY,) int array, (SUMS,) array
        Added to; see `energy` for the sums.
    sample_phase, samples : (k,), (k, contacts, 6) arrays
        Where to record z, x, P, Q, regime and v; rising, in (start, stop]. Recording alters nothing else.
    stride, speeds : int, (number // stride, 3) array
        Every `stride` cycles a row (v, z_s, mean v of the last cycle) is recorded; stride 0 records nothing.
    limit : int
        Largest number of stretches each time.
    memory : memory.Memory or None
        Of the hysteretic law; None for the elastic one, and then nothing of it is compiled.
    count, marks, numbers : arrays
        See `warm_start`; work.
    shared, own, values : (ROWS, n), (PLANES, contacts, n), (n,) arrays
        Work.
    """
    count[0] = count[1] = 0
    for k in range(number):
        before = sums[DISPLACEMENT]
        shared[PUSH, 0] = shared[PULL, 0] = 0.0
        why = advance(problem, sigma, bary, taus, columns, rates, tail, state, regime, sign, start, stop,
                      mobile, tolerance, tally, sums, sample_phase, samples, limit, memory, count, marks, numbers,
                      k % 2, shared, own, values)  # fmt: skip
        if why != DONE:
            return why
        tally[CYCLES] += 1
        if stride > 0 and (k + 1) % stride == 0:
            row = (k + 1) // stride - 1
            speeds[row, 0] = state[2]
            speeds[row, 1] = state[0]
            speeds[row, 2] = (sums[DISPLACEMENT] - before) / (2.0 * np.pi)
    return DONE
