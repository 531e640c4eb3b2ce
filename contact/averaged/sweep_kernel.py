r"""The averaged equilibrium of many sliders and waves: one compiled loop, one error rule.

`solve_problems` solves one problem after the other, each in its own unit of length ell = max(rest approach, largest
amplitude), so that no answer depends on its neighbours. `equilibrium.solve_equilibrium` has the equations. One steady
state is a sweep of one problem.

The error of the velocity is that of second-order averaging or, if this is larger and the slider is held or hardly
moves, the change of the velocity on a larger wave: averaging may have misjudged the threshold.
"""

from typing import NamedTuple

import numpy as np

from contact.averaged.cycle_pieces import FORWARD
from contact.averaged.equilibrium import Entry, Work, full_slip_speed, net_force_at, solve_equilibrium, work_arrays
from contact.averaged.riding import riding
from contact.body import Paths, at_phase, normal_amplitude, of_run, tangential_amplitude
from contact.codes import Status, SteadyRegime
from contact.error_estimate import (
    MIN_WAVE_STEP,
    averaged_stall_error,
    axis_ratio,
    changed_waves_error,
    larger_wave,
    second_order_error,
)
from contact.jit.compiled import compiled, native, per_thread
from contact.law.normal import NormalLaw
from contact.law.protocol import Law
from contact.problem import ContactFactors, SliderNumber, changed, in_units

# f_n/f up to which a slider that moves at the larger amplitude is called held, with that velocity as its error.
# Beyond, averaging cannot tell.
MAX_RATIO_HELD = 0.1
EDGE = 2e-3  # velocity over the reference speed below which the threshold is near
NEARBY = 0.1  # relative change of velocity up to which secant steps serve


class Sweep(NamedTuple):
    """The n problems of a sweep: s sliders and w waves, and which of them each problem combines."""

    sliders: np.ndarray  # (s, len(SliderNumber)): `problem.numbers`, SI units
    laws: np.ndarray  # (s, k): numbers of the sliders' laws
    law: Law  # of all sliders, but for its numbers
    normal: NormalLaw  # of all sliders
    heights: np.ndarray  # (s, contacts), m
    contact_factors: np.ndarray  # (s, 2, contacts): the fields of `problem.ContactFactors`
    paths: Paths  # surface motion of the waves, m; arrays (w, contacts), their heights zero
    omegas: np.ndarray  # (w,), rad/s
    wave_errors: np.ndarray  # (w,), relative
    ratios: np.ndarray  # (n,): contact resonance over the wave's frequency
    which: np.ndarray  # (n, 2) of int: slider and wave
    factors: np.ndarray  # (n,): on the wave's amplitudes


class SweepArrays(NamedTuple):
    """Work arrays of a sweep."""

    work: Work
    paths: Paths  # scaled paths of the problem
    changed_result: np.ndarray  # (len(Entry),): result of the same problem on a changed wave
    changed_paths: Paths  # its paths


@per_thread
def sweep_arrays(harmonics: int, contacts: int) -> SweepArrays:
    """Return the work arrays for so many harmonics and contacts."""
    paths, changed_paths = (Paths(*np.zeros((5, contacts))) for _ in range(2))
    return SweepArrays(work_arrays(harmonics), paths, np.zeros(len(Entry)), changed_paths)


def solve_problems(sweep: Sweep, out, todo, harmonics: int, first: int, stride: int) -> None:
    """Fill the results of every `stride`-th problem of `todo`, from the `first`.

    Parameters
    ----------
    sweep : Sweep
    out : (n, len(Entry)) array
        The result of a problem that is not solved keeps its regime and says why in its status.
    todo : array of int
        Numbers of the problems to solve.
    harmonics : int
        Of the slider's fast motion; 0: averaging of first order.
    """
    law = sweep.law._replace(numbers=np.empty(sweep.laws.shape[1]))
    arrays = sweep_arrays(harmonics, sweep.paths.height.shape[1])
    _solve_problems(sweep, law, out, todo, harmonics, first, stride, arrays)


@native("t t f2 i1 i i i t")
def _solve_problems(sweep, law, out, todo, harmonics, first, stride, arrays):
    """Do the work of `solve_problems`; `law` takes the numbers of one slider's law after the other's. Return 0."""
    for t in range(first, todo.size, stride):
        k = todo[t]
        own, wave = sweep.which[k, 0], sweep.which[k, 1]
        slider, omega = sweep.sliders[own], sweep.omegas[wave]
        for number in range(law.numbers.size):
            law.numbers[number] = sweep.laws[own, number]
        paths = of_run(sweep.paths, wave)
        length = _scale_paths(slider, sweep.heights[own], paths, sweep.factors[k], arrays.paths)
        own_factors = ContactFactors(sweep.contact_factors[own, 0], sweep.contact_factors[own, 1])
        problem = in_units(slider, length, omega, arrays.paths, own_factors, law, sweep.normal)
        result, speed = out[k], problem.length * omega
        _solve_problem(problem, sweep.ratios[k], sweep.wave_errors[wave], harmonics, arrays, result)
        result[Entry.VELOCITY] *= speed
        result[Entry.FIRST_ORDER] *= speed
        result[Entry.HEIGHT] *= problem.length
        result[Entry.THRUST] *= slider[SliderNumber.MASS] * omega * speed
        result[Entry.THRUST_ERROR] *= slider[SliderNumber.MASS] * omega * speed
    return 0


@compiled
def _solve_problem(problem, ratio, wave_error, harmonics, arrays, result):
    """Fill the result of one scaled problem, its velocities and thrusts scaled."""
    work, changed_result, changed_paths = arrays.work, arrays.changed_result, arrays.changed_paths
    status = solve_equilibrium(problem, harmonics, work, result)
    result[Entry.STATUS] = status.value
    if status != Status.DONE:
        return
    problem = changed(problem, result[Entry.LOAD_SIGN] * abs(problem.load), problem.paths)
    v = result[Entry.VELOCITY]
    reference = max(abs(v), full_slip_speed(problem.paths, 0.0) / 10.0)
    error = second_order_error(
        result[Entry.TAIL], result[Entry.RESIDUAL], result[Entry.QUADRATURE], v, result[Entry.FIRST_ORDER]
    )
    if result[Entry.HELD] == 1.0 or abs(v) < EDGE * reference:
        larger = _changed_wave(problem, larger_wave(ratio), 0.0, 0.0, changed_paths)
        status = solve_equilibrium(larger, 0, work, changed_result)
        difference = abs(changed_result[Entry.VELOCITY] - result[Entry.FIRST_ORDER])
        if status == Status.DONE and difference > 0.0 and ratio > MAX_RATIO_HELD:
            status = Status.NEAR_THRESHOLD
        result[Entry.STATUS] = status.value
        if status != Status.DONE:
            return
        error = max(error, difference)
        reference = max(reference, difference) if reference == 0.0 else reference
    from_wave = _error_from_wave(problem, changed_paths, result[Entry.COARSE], wave_error, work, changed_result)
    if not (np.isfinite(v) and np.isfinite(error) and np.isfinite(from_wave)):
        return
    # A slider at rest carries the least mean force that its contacts can have there; if the wave drives it towards -x,
    # against the direction of its crests, minus the largest one.
    thrust = result[Entry.LEAST_AT_REST]
    if result[Entry.LARGEST_AT_REST] <= -thrust:
        thrust = -result[Entry.LARGEST_AT_REST]
    result[Entry.REGIME] = SteadyRegime.STICK.value
    if result[Entry.MADE_PER_CYCLE] > 0.0:
        result[Entry.REGIME] = SteadyRegime.INTERMITTENT.value
    elif result[Entry.SLIPS_PER_CYCLE] > 0.0:
        result[Entry.REGIME] = SteadyRegime.SLIP.value
    result[Entry.ERROR] = error / reference if reference > 0.0 else 0.0
    result[Entry.FROM_WAVE] = from_wave / reference if reference > 0.0 else 0.0
    result[Entry.THRUST] = max(thrust, 0.0)
    result[Entry.THRUST_ERROR] = result[Entry.THRUST] * averaged_stall_error(ratio)


@compiled
def _scale_paths(slider, heights, motion, factor, paths):
    """Fill the scaled paths of a slider's contacts on the surface motion times a factor; return the unit of length."""
    reach = 0.0
    for i in range(paths.height.size):
        reach = max(reach, factor * tangential_amplitude(motion, i), factor * normal_amplitude(motion, i))
    length = max(slider[SliderNumber.REST], reach)
    for i in range(paths.height.size):
        paths.height[i] = heights[i] / length
        paths.normal_cos[i] = motion.normal_cos[i] * factor / length
        paths.normal_sin[i] = motion.normal_sin[i] * factor / length
        paths.tangential_cos[i] = motion.tangential_cos[i] * factor / length
        paths.tangential_sin[i] = motion.tangential_sin[i] * factor / length
    return length


@compiled
def _changed_wave(problem, factor, ratio_change, phase_change, out):
    """Return the problem on a changed wave, whose paths are written to `out`.

    Both amplitudes are multiplied by `factor`; u_x/u_z changes by `ratio_change` (relative) and `phase_change` (rad),
    both times the larger amplitude over the smaller, because errors are relative to the larger one.
    """
    paths = problem.paths
    for i in range(paths.height.size):
        normal, along = normal_amplitude(paths, i), tangential_amplitude(paths, i)
        unequal = axis_ratio(normal, along)
        co, si = np.cos(phase_change * unequal), np.sin(phase_change * unequal)
        tangential = factor * (1.0 + ratio_change * unequal)
        _, _, u_x, u_x_rate = at_phase(paths, i, co, si)
        out.height[i] = paths.height[i]
        out.normal_cos[i], out.normal_sin[i] = paths.normal_cos[i] * factor, paths.normal_sin[i] * factor
        out.tangential_cos[i], out.tangential_sin[i] = tangential * u_x, tangential * u_x_rate
    return changed(problem, problem.load, out)


@compiled
def _error_from_wave(problem, changed_paths, base, wave_error, work, changed_result):
    """Return the change of the first-order velocity `base` by the wave's relative error; inf if it cannot be computed.

    See `changed_waves_error`.
    """
    if wave_error == 0.0:
        return 0.0
    step = max(wave_error, MIN_WAVE_STEP)
    slope = 0.0
    if base != 0.0:
        high, low = (1.0 + MIN_WAVE_STEP) * base, (1.0 - MIN_WAVE_STEP) * base
        slope = (_surplus(problem, high, work) - _surplus(problem, low, work)) / (high - low)
    larger = _change(_changed_wave(problem, 1.0 + step, 0.0, 0.0, changed_paths), base, slope, work, changed_result)
    smaller = _change(_changed_wave(problem, 1.0 - step, 0.0, 0.0, changed_paths), base, slope, work, changed_result)
    ratio = _change(_changed_wave(problem, 1.0, step, 0.0, changed_paths), base, slope, work, changed_result)
    phase = _change(_changed_wave(problem, 1.0, 0.0, step, changed_paths), base, slope, work, changed_result)
    return changed_waves_error(larger, smaller, ratio, phase) * wave_error / step


@compiled
def _change(problem, base, slope, work, result):
    """Return the distance of the first-order velocity of a problem on a changed wave from `base`, inf if it has none.

    `slope` is the derivative of the mean force with respect to the velocity at `base`, on the unchanged wave. A Newton
    step with it and a secant step are enough if both are small; otherwise the equilibrium is solved into `result`.
    """
    if slope < 0.0:
        f_base = _surplus(problem, base, work)
        v = base - f_base / slope
        if abs(v - base) < NEARBY * abs(base):
            f = _surplus(problem, v, work)
            if v != base and f != f_base:
                secant = v - f * (v - base) / (f - f_base)
                if abs(secant - v) < 0.1 * abs(v - base):
                    return abs(secant - base)
    return abs(result[Entry.COARSE] - base) if solve_equilibrium(problem, 0, work, result) == Status.DONE else np.inf


@compiled
def _surplus(problem, v, work):
    """Return the mean net force on a slider that rides at a velocity."""
    return net_force_at(problem, work.rule, riding(problem, work.rule), v, FORWARD, work)
