r"""The averaged equilibrium of many sliders and waves: one compiled loop, one error rule.

One problem after the other, each in its own unit of length ell = max(rest approach, largest amplitude), so that nothing
of an answer depends on its neighbours. See `equilibrium.balance_row` for the equations. `sweep` asks for one row or a
million; every door to an averaged steady state leads here.

Error of the velocity: the largest of the harmonics left out, the residual, a share of the second-order correction and
rounding. Where the slider is held or hardly moves, averaging may have misjudged the threshold, by up to 12 (f_n/f)^2 in
amplitude; the velocity at an amplitude larger by that is added.
"""

import threading
from typing import NamedTuple

import numpy as np

from contact.averaged.equilibrium import Entry, Work, balance_row, excess, room
from contact.averaged.riding import riding
from contact.body import Paths, at_phase, normal_amplitude, of_run, tangential_amplitude
from contact.codes import Status, Steady
from contact.jit.compiled import compiled, native
from contact.law.protocol import Law, with_numbers
from contact.problem import Own, changed, in_units

# Relative error of the threshold amplitude over (f_n/f)^2: at 0.75 nm, just above the threshold of Feenstra and
# Breedveld's slider, first order errs by 12 (f_n/f)^2 in velocity (`tests/benchmarks/contact_ways.py`).
# At most half the amplitude is added.
THRESHOLD_ERROR, MAX_THRESHOLD_ERROR = 12.0, 0.5
# f_n/f up to which a slider that moves at the larger amplitude is called held, with that velocity as its error.
# Beyond, averaging cannot tell.
MAX_RATIO_HELD = 0.1
# relative error of the averaged stalling load over (f_n/f)^2; true: 1.8 (`tests/contact/test_thrust.py`)
STALL_ERROR = 3.0
LEAST_STEP = 1e-4  # relative; a smaller change would measure rounding
EDGE = 2e-3  # velocity over the reference speed below which the threshold is near
MAX_AMPLITUDE_RATIO = 1e3  # larger over smaller amplitude up to which the smaller's error grows
NEARBY = 0.1  # relative change of velocity up to which secant steps serve
CORRECTION_ERROR = 1e-4  # share of the second-order correction that is not trusted
# Least relative error: the periodic motion of the full equations, which this is checked against, is itself known to
# some 1e-10 (tests/contact/test_calibration.py).
LEAST_ERROR = 1e-9


class Given(NamedTuple):
    """The problems of a sweep."""

    sliders: np.ndarray  # (s, 11) array: `problem.numbers`
    laws: np.ndarray  # (s, k) array: Numbers of the sliders' laws
    law: Law  # Of all of them, but for its numbers
    heights: np.ndarray  # (s, contacts) array: Of the contacts, m
    paths: Paths  # Of the waves, m; arrays (w, contacts), the heights zero
    # (w,) arrays: rad/s; relative
    omegas: np.ndarray
    wave_errors: np.ndarray
    ratios: np.ndarray  # (n,) array: Contact resonance over the wave's frequency, per problem
    # (n, 2) array of int, (n,) array: Slider and wave of each problem, factor on the amplitudes
    which: np.ndarray
    factors: np.ndarray


class Room(NamedTuple):
    """Work arrays of a sweep: those of an equilibrium, a second one of it, paths of a problem and of one changed."""

    work: Work
    tried: np.ndarray
    paths: Paths
    spare: Paths


_ROOMS = threading.local()  # by harmonics and contacts: a kernel finds the same arrays again


def states(given: Given, out, todo, harmonics: int, first: int, stride: int) -> None:
    """Fill the rows (n, len(Entry)) of `out` of every `stride`-th problem of `todo`, from the `first`.

    A row that is not reached keeps its regime and says why in its status; `harmonics` of the slider's fast motion.
    """
    key = harmonics, given.paths.height.shape[1]
    rooms = vars(_ROOMS).setdefault("rooms", {})
    if key not in rooms:
        paths, spare = (Paths(*np.zeros((5, key[1]))) for _ in range(2))
        rooms[key] = Room(room(harmonics), np.zeros(len(Entry)), paths, spare)
    _states(given, out, todo, harmonics, first, stride, rooms[key])


@native("t f2 i1 i i i t")
def _states(given, out, todo, harmonics, first, stride, room):
    """Do the work of `states`; return 0."""
    for t in range(first, todo.size, stride):
        k = todo[t]
        slider, wave = given.sliders[given.which[k, 0]], given.which[k, 1]
        omega = given.omegas[wave]
        heights, paths = given.heights[given.which[k, 0]], of_run(given.paths, wave)
        law = with_numbers(given.law, given.laws[given.which[k, 0]])
        problem = _scaled(slider, law, heights, paths, given.factors[k], omega, room.paths)
        _state(problem, given.ratios[k], given.wave_errors[wave], harmonics, room, out[k])
        row, speed = out[k], problem.length * omega
        row[Entry.VELOCITY] *= speed
        row[Entry.FIRST_ORDER] *= speed
        row[Entry.HEIGHT] *= problem.length
        row[Entry.THRUST] *= slider[Own.MASS] * omega * speed
        row[Entry.THRUST_ERROR] *= slider[Own.MASS] * omega * speed
    return 0


@compiled
def _state(problem, ratio, wave_error, harmonics, room, row):
    """Fill the scaled answer of one problem."""
    tried, work, spare = room.tried, room.work, room.spare
    status = balance_row(problem, harmonics, work, row)
    row[Entry.STATUS] = status.value
    if status != Status.DONE:
        return
    problem = changed(problem, row[Entry.LOAD_SIGN] * abs(problem.load), problem.paths)
    along = 0.0
    for i in range(problem.paths.height.size):
        along = max(along, tangential_amplitude(problem.paths, i))
    v = row[Entry.VELOCITY]
    reference = max(abs(v), along / 10.0)
    error = max(row[Entry.TAIL], row[Entry.RESIDUAL], row[Entry.QUADRATURE], LEAST_ERROR * abs(v))
    error = max(error, CORRECTION_ERROR * abs(v - row[Entry.FIRST_ORDER]))
    if row[Entry.HELD] == 1.0 or abs(v) < EDGE * reference:
        larger = 1.0 + min(THRESHOLD_ERROR * ratio**2, MAX_THRESHOLD_ERROR)
        status = balance_row(_with_error(problem, larger, 0.0, 0.0, spare), 0, work, tried)
        beyond = abs(tried[Entry.VELOCITY] - row[Entry.FIRST_ORDER])
        if status == Status.DONE and beyond > 0.0 and ratio > MAX_RATIO_HELD:
            status = Status.NEAR_THRESHOLD
        row[Entry.STATUS] = status.value
        if status != Status.DONE:
            return
        error = max(error, beyond)
        reference = max(reference, beyond) if reference == 0.0 else reference
    lost = _from_wave(problem, spare, row[Entry.COARSE], wave_error, work, tried)
    if not (np.isfinite(v) and np.isfinite(error) and np.isfinite(lost)):
        return
    stall = row[Entry.LEAST_AT_REST]
    if row[Entry.LARGEST_AT_REST] <= -stall:  # driven against its crests
        stall = -row[Entry.LARGEST_AT_REST]
    row[Entry.REGIME] = Steady.STICK.value
    if row[Entry.MADE_PER_CYCLE] > 0.0:
        row[Entry.REGIME] = Steady.INTERMITTENT.value
    elif row[Entry.SLIPS_PER_CYCLE] > 0.0:
        row[Entry.REGIME] = Steady.SLIP.value
    row[Entry.ERROR] = error / reference if reference > 0.0 else 0.0
    row[Entry.FROM_WAVE] = lost / reference if reference > 0.0 else 0.0
    row[Entry.THRUST] = max(stall, 0.0)
    row[Entry.THRUST_ERROR] = row[Entry.THRUST] * min(STALL_ERROR * ratio**2, 1.0)


@compiled
def _scaled(slider, law, heights, given, factor, omega, paths):
    """Return the scaled problem, with its paths in the room given."""
    reach = 0.0
    for i in range(paths.height.size):
        reach = max(reach, factor * tangential_amplitude(given, i), factor * normal_amplitude(given, i))
    length = max(slider[Own.REST], reach)
    for i in range(paths.height.size):
        paths.height[i] = heights[i] / length
        paths.normal_cos[i] = given.normal_cos[i] * factor / length
        paths.normal_sin[i] = given.normal_sin[i] * factor / length
        paths.tangential_cos[i] = given.tangential_cos[i] * factor / length
        paths.tangential_sin[i] = given.tangential_sin[i] * factor / length
    return in_units(slider, length, omega, paths, law)


@compiled
def _with_error(problem, factor, ratio_change, phase_change, out):
    """Return the problem on a changed wave, whose paths are written to `out`.

    Both amplitudes are multiplied by `factor`; u_x/u_z changes by `ratio_change` (relative) and `phase_change` (rad),
    both times the larger amplitude over the smaller, because errors are relative to the larger one.
    """
    paths = problem.paths
    for i in range(paths.height.size):
        normal, along = normal_amplitude(paths, i), tangential_amplitude(paths, i)
        small, large = min(normal, along), max(normal, along)
        unequal = min(large / small, MAX_AMPLITUDE_RATIO) if small > 0.0 else 1.0
        co, si = np.cos(phase_change * unequal), np.sin(phase_change * unequal)
        tangential = factor * (1.0 + ratio_change * unequal)
        _, _, u_x, u_x_rate = at_phase(paths, i, co, si)
        out.height[i] = paths.height[i]
        out.normal_cos[i], out.normal_sin[i] = paths.normal_cos[i] * factor, paths.normal_sin[i] * factor
        out.tangential_cos[i], out.tangential_sin[i] = tangential * u_x, tangential * u_x_rate
    return changed(problem, problem.load, out)


@compiled
def _from_wave(problem, spare, base, wave_error, work, tried):
    """Return the change of the first-order velocity by the wave's relative error; inf where it is not found."""
    if wave_error == 0.0:
        return 0.0
    step = max(wave_error, LEAST_STEP)
    slope = 0.0
    if base != 0.0:
        high, low = (1.0 + LEAST_STEP) * base, (1.0 - LEAST_STEP) * base
        slope = (_surplus(problem, high, work) - _surplus(problem, low, work)) / (high - low)
    both = turned = 0.0
    for m in range(4):
        factor = 1.0 + step if m == 0 else 1.0 - step if m == 1 else 1.0
        other = _with_error(problem, factor, step if m == 2 else 0.0, step if m == 3 else 0.0, spare)
        effect = abs(_velocity_on(other, base, slope, work, tried) - base)
        if m < 2:
            both = max(both, effect)
        else:
            turned += effect**2
    return np.sqrt(both**2 + turned) * wave_error / step


@compiled
def _velocity_on(problem, base, slope, work, tried):
    """Return the first-order velocity of a problem near that of `base`: two secant steps where they are small."""
    if slope < 0.0:
        before, f = base, _surplus(problem, base, work)
        v = base - f / slope
        if abs(v - base) < NEARBY * abs(base):
            g = _surplus(problem, v, work)
            if v != before and g != f:
                last = v - g * (v - before) / (g - f)
                if abs(last - v) < 0.1 * abs(v - base):
                    return last
    return tried[Entry.COARSE] if balance_row(problem, 0, work, tried) == Status.DONE else np.inf


@compiled
def _surplus(problem, v, work):
    """Return the mean tangential force that is left to accelerate a slider riding at a velocity."""
    return excess(problem, work.rule, riding(problem, work.rule), v, work)
