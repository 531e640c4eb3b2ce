r"""Steady velocity of a slider on a continuous wave, computed without following the transient.

The computation has two steps.

1. *Averaged equilibrium.* A slider that is heavy on the wave's time scale keeps its height h and its velocity v nearly
   constant through a cycle. The condition <sum P_i> = preload gives h, and <sum Q_i>(v) = R_t v + load gives v, where
   <> is the mean over a cycle, integrated exactly between events. For the elastic law `steady_sweep.mean_motion` adds
   the second-order correction and an error estimate. The other laws are averaged to first order.
2. *Shooting* (method "exact"). The cycle map of the full equations takes the state (z_s, z_s', v, x_i) to the state one
   cycle later. Newton's method finds the fixed point of this map, starting from the averaged equilibrium.

A slider is held if at least one contact can stick through all cycles. The mean tangential force at v = 0 then depends
on the deformations at the start and fills an interval. If the load lies in this interval, the slider stays at rest and
its velocity is exactly zero.
"""

import math
import time
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from contact import parameter_check
from contact.answers.ledger import Ledger, ledger
from contact.answers.pull import damper_pull
from contact.averaged.burst import STIFFEST_STEADY, refusals
from contact.averaged.closed_forms import closed_form
from contact.averaged.coupled_motion import WaveRows, coupled_motion
from contact.averaged.endless_bounce import speed_lost
from contact.averaged.event_equilibrium import Balance, balanced, cycle_at
from contact.averaged.steady_sweep import mean_motion
from contact.averaged.sweep_kernel import MAX_RATIO_HELD
from contact.choice import Answer, Answered, Method, first_to_converge
from contact.error_estimate import (
    first_order_error,
    larger_wave,
    reference_speed,
    relative_to_reference,
    two_orders_error,
)
from contact.exceptions import ConvergenceError
from contact.orbit import Orbits, towards_plus
from contact.passing_wave import PassingWave, Surface, coupling, merged, prescribed, resonance_ratio
from contact.periodic.settling import long_run, mean_from_rest, reached
from contact.periodic.shooting import SETTLE, coarse_periodic, fine_periodic, quick_periodic
from contact.problem import scaled
from contact.slider import Slider

METHODS = ("auto", "exact", "averaged")
# SLOWEST_WAVE: largest ratio of contact resonance to wave frequency for which shooting is tried. Above it a long run
# takes a third to all of the time; in seven draws at ratios of 22 to 136 both gave the same velocity.
SLOWEST_WAVE = 20.0
# The mean velocity of an undamped bounce covers this many bounce periods, at least SETTLE and at most this many wave
# cycles (less than a second). In 40 draws the mean over 80 periods was 0.45 of that over 20 in the median, and more
# than twice as large in 4.
BOUNCES, MAX_BOUNCE_CYCLES = 20.0, 4000
# Shooting would take too long if a cycle has more segments than this: a segment takes 2 to 4 us for one to three
# contacts, and a search about 40 cycles.
MAX_SEGMENTS = 8000.0
GOES_ON = (
    "without normal damping a start from rest goes on bouncing, at {:.4g} m/s in the mean: give slider.damping.normal "
    "or slider.damping.contact"
)


@dataclass(frozen=True, kw_only=True)
class SteadyState(Answered):
    """Steady state of a slider on a continuous wave.

    Attributes
    ----------
    slider, orbits
        The arguments of `steady`.
    answer : Answer
        Mean velocity over a cycle in m/s (exactly 0 when held), its error, status and reasons. The error includes the
        doubt whether a slider that starts from rest reaches this motion.
    regime : str
        "stick", "slip" or "intermittent".
    height : float
        Mean approach h of the contacts, m; the slider's mean position is -h.
    method : str
        Method that gave the answer: "exact" or "averaged".
    ledger : Ledger
        Energies over one cycle; all zero if a closed form gives the velocity.
    tilt : tuple of float
        Rotations in rad: increase of the approach along x (pitch) and along y (roll).
    loaded : WaveRows or None
        The wave at the rows of contacts and the forces of each contact, of a slider on a `PassingWave` that loads it,
        that tilts, has a soft backing or an infinite mass; None otherwise.
    other_velocity : float or None
        Mean velocity of a second steady motion in m/s, None if none is known. It is either a motion that repeats with
        the wave's period but is not reached from rest, or the motion of a slider that starts from rest and whose
        undamped bounce never ends.
    statistics : dict
        Number of events of each kind in one cycle; smallest time between two events in s (inf for fewer than two);
        chatter (True if many events occurred at almost the same time); number of segments (`stretches`) and sweeps.
        Contacts that are equal and move alike are followed, and counted, as one.
    seconds : float
        Computing time.
    """

    slider: Slider
    orbits: Orbits | PassingWave
    answer: Answer
    regime: str
    height: float
    method: str
    ledger: Ledger
    tilt: tuple[float, float] = (0.0, 0.0)
    loaded: WaveRows | None = None
    other_velocity: float | None = None
    statistics: dict
    seconds: float

    @property
    def velocity(self) -> float:
        """Mean velocity over a cycle, m/s; exactly 0 when held."""
        return self.answer.value


def steady(
    slider: Slider, orbits: Surface, *, tolerance: float, method: str = "auto",
    near: SteadyState | None = None,
) -> SteadyState:  # fmt: skip
    """Return the steady state of a slider on a continuous wave.

    Parameters
    ----------
    slider : Slider
        The slider.
    orbits : Orbit, sequence of Orbit or PassingWave
        Motion of the surface under each contact, or the waves below the slider.
    tolerance : float
        Allowed error of the velocity, relative to max(|v|, omega |u_x|/10).
    method : str
        "exact", "averaged" or "auto".
    near : SteadyState, optional
        A state of the same contacts on a similar wave that they load, from which the search starts. With "harmonics"
        its number of harmonics is used if it has overtones.

    Returns
    -------
    SteadyState
        Its status says if the estimated error exceeds the tolerance.

    Raises
    ------
    ValueError
        If the parameters contradict each other.
    ConvergenceError
        With status "runaway" (nothing balances the load), "unstable" (no stable motion repeats with the wave's period)
        or the status of the solver that failed.
    """
    begun = time.perf_counter()
    parameter_check.positive("tolerance", tolerance, "")
    parameter_check.choice("method", method, METHODS)
    if isinstance(orbits, PassingWave) and method != "exact" and (coupling(slider, orbits) or slider.mass == math.inf):
        return _on_rows(slider, orbits, tolerance, near, begun)
    given, (slider, listed) = slider, prescribed(slider, orbits)
    alike = (slider, listed) if slider.profile.hold is not None else merged(slider, listed)
    solution = _closed(slider, listed) or _searched(*alike, method, tolerance)
    reference = reference_speed(solution.velocity, listed) or 1.0
    near = solution.method == "averaged" and solution.velocity == 0.0
    error = solution.relative_error * reference
    answer = Answer(value=solution.velocity, error=error, reasons=(solution.message, *_pull(slider, listed))).judged(
        tolerance, reference, "so near the threshold the slider may move" if near else ""
    )
    return SteadyState(
        slider=given, orbits=orbits if isinstance(orbits, PassingWave) else listed, answer=answer,
        regime=solution.regime, height=solution.height,
        method=solution.method, ledger=solution.ledger, other_velocity=solution.other_velocity,
        statistics=solution.statistics, seconds=time.perf_counter() - begun,
    )  # fmt: skip


def _on_rows(slider, wave, tolerance, near, begun):
    """Return the averaged state of a slider at the rows of a passing wave."""
    motion = coupled_motion(slider, wave, None if near is None else near.loaded)
    rows, cycle = motion.rows, 1.0 / wave.frequency
    error = motion.relative_error + first_order_error(resonance_ratio(slider, wave))
    reference = reference_speed(motion.velocity, wave) or 1.0
    how = "averaged equilibrium of the rows" + (" on the wave that they load" if rows.loading else "")
    answer = Answer(value=motion.velocity, error=error * reference, reasons=(how,)).judged(tolerance, reference)
    losses = rows.friction_power, 0.0, 0.0, rows.damping_power, rows.thrust_power, rows.leak_power
    powers = (*rows.work, *losses, 0.0, 0.0, 0.0, 0.0)
    return SteadyState(
        slider=slider, orbits=wave, answer=answer, regime=motion.regime, height=motion.height, method="averaged",
        ledger=Ledger(*(cycle * each for each in powers)), tilt=motion.tilt, loaded=rows,
        statistics={"sweeps": rows.sweeps}, seconds=time.perf_counter() - begun,
    )  # fmt: skip


def _pull(slider, orbits):
    """Return the remark that the contact damper pulls the slider down, in a tuple; an empty tuple if it does not."""
    force, share = damper_pull(slider, orbits)
    if force == 0.0:
        return ()
    return (f"the contact damper pulls the slider down, with up to {-force:.3g} N during {share:.0%} of a cycle",)


class _Solution(NamedTuple):
    """A steady state as a method returns it; fields as in `SteadyState`."""

    velocity: float
    relative_error: float
    message: str
    regime: str
    height: float
    method: str
    ledger: Ledger
    statistics: dict
    other_velocity: float | None = None

    def in_doubt(self, error, reason, other=None):
        """Return the solution with a relative error added, the reason for it and the velocity of another motion."""
        return self._replace(
            relative_error=self.relative_error + error, message=f"{self.message}; {reason}", other_velocity=other
        )  # fmt: skip

    def unchecked(self, reason):
        """Return the solution with an error of at least the reference speed, because it could not be checked."""
        return self.in_doubt(0.0, reason)._replace(relative_error=max(self.relative_error, 1.0))


def _closed(slider, orbits):
    """Return the solution by a closed form, or None if no closed form applies."""
    fields = closed_form(slider, orbits)
    if fields is None:
        return None
    return _Solution(
        message=f"{fields.pop('why')}: closed form", method="exact", relative_error=0.0, statistics={},
        ledger=Ledger(*[0.0] * len(Ledger._fields)), **fields,
    )  # fmt: skip


class _Mean(NamedTuple):
    """Averaged steady state; the velocity is that on the mirrored orbits, the error is relative."""

    velocity: float
    error: float
    height: float
    regime: str


class _Search(NamedTuple):
    """Inputs of the search for a steady state.

    The orbits are mirrored if necessary so that the wave crests drive the slider towards +x; `side` is the sign that
    turns a velocity back to the original orbits.
    """

    slider: Slider
    orbits: Orbits
    method: str
    tolerance: float
    side: float
    ratio: float  # resonance frequency of the contacts over wave frequency
    mean: _Mean | None  # None if averaging does not apply
    balance: Balance  # averaged equilibrium
    failure: ConvergenceError | None = None  # error of the method tried before

    @property
    def unit(self):
        """Unit of velocity of the scaled problem, m/s."""
        return self.balance.problem.speed

    @property
    def hops(self):
        """True if the slider's height and velocity change within a cycle.

        The averaged motion cannot stand in then for a periodic motion that was not found.
        """
        # a strong contact damper moves the slider within a few cycles, so that averaging does not apply
        strongly_damped = self.balance.problem.contact_damping * self.balance.problem.preload > 1e-2
        unstable = self.failure is not None and self.failure.status == "unstable"
        return self.ratio > MAX_RATIO_HELD or unstable or strongly_damped

    def relative(self, difference, velocity):
        """Return a velocity difference divided by the reference speed."""
        return relative_to_reference(difference, velocity, self.orbits)

    def within(self, fine, coarse):
        """Return True if the error of a periodic motion known at two orders is within the tolerance."""
        return self.relative(_two_orders(fine, coarse) * self.unit, fine.speed * self.unit) <= self.tolerance

    def solution(self, message, motion, *, velocity, error, height, sticks, cycles=1, **statistics):
        """Return the solution with energies and events from a motion over a number of cycles.

        `velocity` in m/s is that on the mirrored orbits, `height` is in m.
        """
        if self.slider.load > 0.0 and velocity * self.balance.load_sign < 0.0:
            message += "; it moves in the direction of the load, which opposes the unloaded motion of the cycle means"
        counted = motion.events()
        moving = "intermittent" if counted["release"] else "slip"
        return _Solution(
            velocity=float(self.side * velocity) if velocity else 0.0, regime="stick" if sticks else moving,
            relative_error=float(error), height=float(height), message=message, method="exact",
            statistics=counted | statistics, ledger=ledger(self.slider, motion, spans=cycles),
        )  # fmt: skip


def _searched(slider, orbits, method, tolerance):
    """Return the solution by averaging, shooting or a long run from rest."""
    side, driven = towards_plus(orbits)
    ratio = slider.normal_resonance(len(orbits)) / orbits.frequency
    search = _Search(slider, driven, method, tolerance, side, ratio, *_equilibrium(slider, driven, ratio, method))
    return _averaged(search) if method == "averaged" else first_to_converge(STEADY_METHODS, search)


def _equilibrium(slider, orbits, ratio, method):
    """Return (averaged steady state, averaged equilibrium from which shooting starts).

    The averaged state is None if averaging does not apply.
    """
    if not refusals(slider, orbits, STIFFEST_STEADY):
        try:
            mean = mean_motion(slider, orbits)
        except ConvergenceError as failed:
            if failed.status == "runaway" or method == "averaged":
                raise
        else:
            balance = cycle_at(
                slider, orbits, height=mean.height, velocity=mean.first_order, held=bool(mean.held),
                load_sign=mean.load_sign,
            )  # fmt: skip
            return _Mean(mean.velocity, mean.relative_error, mean.height, str(mean.regime)), balance
    elif method == "averaged" and ratio > MAX_RATIO_HELD:
        raise ConvergenceError(
            "not applicable",
            f"the contact resonates at {ratio:.3g} of the wave's frequency, so that the slider does not ride still "
            f"through a cycle (allowed: {MAX_RATIO_HELD}); use method exact",
        )
    balance = balanced(slider, orbits)
    return (None if ratio > MAX_RATIO_HELD else _first_order(slider, orbits, balance, ratio)), balance


def _first_order(slider, orbits, balance, ratio):
    """Return the first-order averaged steady state of a law that only the event-driven solver supports."""
    error = first_order_error(ratio)
    if balance.held:
        on_larger_wave = balanced(slider, orbits.scaled(larger_wave(ratio)))
        error = relative_to_reference(on_larger_wave.speed * on_larger_wave.problem.speed, 0.0, orbits)
    events = balance.motion.events()
    slips = "slip" if events["stick_to_slip"] or not balance.held else "stick"
    return _Mean(
        balance.speed * balance.problem.speed, error, balance.height * balance.problem.length,
        "intermittent" if events["release"] else slips,
    )  # fmt: skip


def _shooting(search):
    """Return the solution by shooting, or by a long run if a slider from rest reaches another motion."""
    solution, periodic_motion = _periodic_solution(search)
    if search.ratio <= MAX_RATIO_HELD:
        bounces = solution.velocity != 0.0 and _undamped(search.slider)
        return _with_bounce_error(search, solution) if bounces else solution
    seen = reached(search.slider, search.orbits, search.balance, periodic_motion)
    velocity = solution.velocity
    if seen.instead is not None:
        note = f"a motion that repeats every cycle has {velocity:.4g} m/s, but is not reached from rest"
        return _of_long_run(search, seen.instead).in_doubt(0.0, note, velocity)
    if not seen.reason:
        return solution
    other = None if seen.speed is None else float(search.side * seen.speed * search.unit)
    mean = "" if other is None else f", with {other:.4g} m/s in the mean"
    return solution.in_doubt(search.relative(seen.doubt * search.unit, velocity), f"{seen.reason}{mean}", other)


def _shooting_refusals(search):
    if search.slider.mass == math.inf:
        return ("the mass is infinite",)
    if search.balance.held:
        return ("friction holds the slider in the mean",)
    return ("the wave is too slow for the contact",) if search.ratio > SLOWEST_WAVE else ()


def _periodic_solution(search):
    """Return (solution, periodic motion) by shooting; raise if the periodic motion is unstable."""
    balance = search.balance
    unit, segments = balance.problem.speed, balance.problem.segments
    if segments > MAX_SEGMENTS:
        raise ConvergenceError("out of reach", f"a cycle takes {segments:.3g} stretches of the motion; raise the mass")
    quick = quick_periodic(balance, search.tolerance)
    if quick is not None and search.within(*quick):
        fine, coarse = quick
    else:
        fine = fine_periodic(balance)
        coarse = coarse_periodic(balance, fine)
    if not fine.stable:
        raise ConvergenceError(
            "unstable",
            f"the motion that repeats with the wave's period grows by {fine.growth:.6g} per cycle: the slider hops",
        )
    sticks = fine.motion.memory is None and fine.motion.sticks
    velocity, error = fine.speed * unit, _two_orders(fine, coarse) * unit
    # velocity and error of a sticking slider are rounding errors
    velocity, error = (0.0, 0.0) if sticks else (velocity, search.relative(error, velocity))
    solution = search.solution(
        "periodic motion of the full equations", fine.motion, velocity=velocity, error=error, sticks=sticks,
        height=fine.motion.mean_height(1) * balance.problem.length,
    )  # fmt: skip
    return solution, fine


def _two_orders(fine, coarse):
    """Return the error of the speed of a periodic motion known at two orders, scaled."""
    return two_orders_error(abs(fine.speed - coarse.speed), fine.unseen_error)


def _undamped(slider):
    """Return True if no damper ends the bounce of a slider that starts from rest."""
    return slider.normal_damping == 0.0 and slider.contact_damping == 0.0


def _with_bounce_error(search, solution):
    """Return the solution with the effect of an undamped bounce on the velocity added to its error.

    The effect is computed with the elastic law, because only its cycle means are available.
    """
    elastic = replace(search.slider, law="elastic", reciprocal=False)
    problem = scaled(elastic, search.orbits, direction=search.balance.load_sign, start=0.0)
    rest = elastic.rest_approach(len(search.orbits)) / problem.length
    lost = speed_lost(problem, rest, solution.height / problem.length) * problem.speed
    if not np.isfinite(lost):
        reason = "how fast the slider is while it bounces without normal damping was not found"
        return solution.unchecked(reason)
    other = float(solution.velocity + search.side * lost)
    return solution.in_doubt(search.relative(lost, solution.velocity), GOES_ON.format(other), other)


def _held_with_bounce_error(search, solution):
    """Return the solution of a held slider, with the drift that an undamped bounce causes added to its error."""
    cycles = int(min(max(BOUNCES / search.ratio, SETTLE), MAX_BOUNCE_CYCLES))
    try:
        mean = mean_from_rest(search.slider, search.orbits, search.balance.load_sign, cycles)
    except ConvergenceError as failed:
        return solution.unchecked(f"the bounce of a start from rest was not followed: {failed}")
    other = float(search.side * mean)
    error = search.relative(other, 0.0)
    below = error <= solution.relative_error
    return solution if below else solution.in_doubt(error, GOES_ON.format(other), other)


def _averaged(search):
    """Return the averaged solution, with the energies of a cycle at constant height and velocity."""
    mean, held, motion = search.mean, search.balance.held, search.balance.motion
    motion.count_energies()  # the cycle repeats, so that the stored energy does not change
    note = "held by friction" if held else "cycle means"
    if search.failure is not None:
        note += f", for the full motion was not found: {search.failure}"
    solution = search.solution(
        note, motion, velocity=mean.velocity, error=mean.error, height=mean.height, sticks=held
    )._replace(method="averaged", regime=mean.regime)
    bounces = held and search.method != "averaged" and _undamped(search.slider)
    return _held_with_bounce_error(search, solution) if bounces else solution


def _averaged_refusals(search):
    if search.mean is not None and search.balance.held:
        return ()
    if search.method == "exact":
        return ("the exact motion is required",)
    return ("the slider does not keep its height and velocity through a cycle",) if search.hops else ()


def _long_run(search):
    """Return the solution by a long run from rest, for a slider that hops or that a slow wave carries along."""
    return _of_long_run(search, long_run(search.slider, search.orbits, search.balance.load_sign))


def _long_run_refusals(search):
    return () if search.hops else ("a slider that keeps its height takes too long to settle",)


def _of_long_run(search, run):
    """Return the solution for a long run (`periodic.settling.LongRun`)."""
    unit = run.motion.problem.speed
    if run.sticks:
        note = "every contact sticks"
    elif run.period:
        note = f"motion that repeats after {run.period} cycles, reached from rest in {run.passed}"
    else:
        note = f"mean of {run.cycles} cycles after {run.passed} from rest, for no motion that repeats was seen"
    if run.starts > 1:
        note += "; two runs from almost the same start were compared"
    return search.solution(
        note, run.motion, velocity=run.speed * unit, error=search.relative(run.error * unit, run.speed * unit),
        sticks=run.sticks, height=run.height * run.motion.problem.length, cycles=run.cycles, period_cycles=run.period,
        averaged_cycles=run.cycles,
    )  # fmt: skip


# In the order in which they are tried. The averaged method answers for a slider that friction holds, and for one that
# keeps its height but whose periodic motion is not known; a long run from rest answers for the others.
STEADY_METHODS = {
    "shooting": Method(_shooting, _shooting_refusals),
    "averaged": Method(_averaged, _averaged_refusals),
    "long run": Method(_long_run, _long_run_refusals),
}
