r"""The steady velocity: the periodic motion itself, found without waiting for it.

Two steps. *Averaged*: a slider that is heavy on the wave's time scale keeps height h and velocity v through a cycle;
h follows from <sum P_i> = preload and v from <sum Q_i>(v) = R_t v + load, with the cycle mean between exact events.
For the elastic law this is `sweep.mean_motion`, with its second-order correction and its error; for other laws it is of
first order. *Exact*: the map of one whole cycle of the full equations, (z_s, z_s', v, x_i) -> the same a cycle later,
is brought to its fixed point by Newton's method from the averaged state.

Held: if one contact can stick for good, the deformations that the wave drives them to (from above and from below)
leave a whole interval of mean tractions. If load lies in it the slider stays, and its velocity is exactly zero.
"""

import time
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from contact import bounds
from contact.answers.ledger import Ledger, ledger
from contact.averaged.bounce import speed_lost
from contact.averaged.closed_forms import closed_form
from contact.averaged.event_cycle import Balance, balanced, cycle_at
from contact.averaged.run import STIFFEST_STEADY, refusals
from contact.averaged.sweep import mean_motion
from contact.averaged.sweep_rows import MAX_RATIO_HELD, MAX_THRESHOLD_ERROR, THRESHOLD_ERROR
from contact.choice import Answer, Answered, Method, first_to_converge
from contact.convergence_error import ConvergenceError
from contact.drive import reference_speed, relative_to_reference, towards_plus
from contact.orbit import Orbit, as_orbits
from contact.periodic.settling import long_run, mean_from_rest, reached
from contact.periodic.shooting import periodic
from contact.problem import scaled
from contact.slider import Slider

METHODS = ("auto", "exact", "averaged")
# largest ratio of contact resonance to wave for which a periodic motion is searched, and cycles to settle before
SLOWEST_WAVE, SETTLE = 20.0, 200
# periods of a bounce that nothing damps, and cycles at most, over which its mean velocity is taken
BOUNCES, MAX_BOUNCE_CYCLES = 20.0, 4000
# segments of a cycle up to which that is worth its time
MAX_SEGMENTS = 8000.0
# error of first order over (f_n/f)^2; true: 0.1 to 1.9 from 0.75 to 20 nm (`tests/benchmarks/contact_ways.py`)
AVERAGING_ERROR = 3.0
GOES_ON = (
    "without normal damping a start from rest goes on bouncing, at {:.4g} m/s in the mean: give slider.damping.normal "
    "or slider.damping.contact"
)


@dataclass(frozen=True, kw_only=True)
class SteadyState(Answered):
    """The periodic motion of a slider on a continuous wave.

    Attributes
    ----------
    slider, orbits
        What was asked.
    answer : Answer
        Mean velocity over a cycle, m/s, exactly 0 when held; its error, with what is in doubt about the motion that a
        start from rest reaches; status and reasons.
    regime : str
        "stick", "slip" or "intermittent".
    height : float
        Mean approach h of the contacts, m; the slider's mean position is -h.
    method : str
        What was used: "exact" or "averaged".
    ledger : Ledger
        Energies over one cycle; all zero where a closed form answers.
    other_velocity : float or None
        m/s, mean velocity of a second steady motion where one is known: the motion that repeats with the wave's period
        but is not reached from rest, or the one that a start from rest goes on with where nothing damps the bounce.
    statistics : dict
        Events by kind in one cycle, smallest gap between two in s (inf: fewer), chatter (whether events crowded at
        one instant); segments (`stretches`) and sweeps of the cycles counted.
    seconds : float
        Time taken.
    """

    slider: Slider
    orbits: tuple[Orbit, ...]
    answer: Answer
    regime: str
    height: float
    method: str
    ledger: Ledger
    other_velocity: float | None = None
    statistics: dict
    seconds: float

    @property
    def velocity(self) -> float:
        """Mean velocity over a cycle, m/s; exactly 0 when held."""
        return self.answer.value


def steady(
    slider: Slider, orbits: Orbit | tuple[Orbit, ...], *, tolerance: float, method: str = "auto"
) -> SteadyState:
    """Return the steady state.

    Parameters
    ----------
    slider : Slider
        The slider.
    orbits : Orbit or tuple of Orbit
        Motion of the surface under each contact.
    tolerance : float
        Error allowed in the velocity, relative to max(|v|, omega |u_x|/10).
    method : str
        "exact", "averaged", or "auto".

    Returns
    -------
    SteadyState
        With the error estimated; its status says when the estimate exceeds the tolerance.

    Raises
    ------
    ValueError
        For parameters that do not go together.
    ConvergenceError
        Status "runaway" (nothing balances the load), "unstable" (no stable motion repeats with the wave's period),
        or what the motion ran into.
    """
    begun = time.perf_counter()
    listed = as_orbits(orbits)
    bounds.positive("tolerance", tolerance, "")
    bounds.choice("method", method, METHODS)
    motion = _closed(slider, listed) or _by_methods(slider, listed, method)
    reference = reference_speed(motion.velocity, listed) or 1.0
    near = motion.method == "averaged" and motion.velocity == 0.0
    error = motion.relative_error * reference
    answer = Answer(value=motion.velocity, error=error, reasons=(motion.message,)).judged(
        tolerance, reference, "so near the threshold the slider may move" if near else ""
    )
    return SteadyState(
        slider=slider, orbits=listed, answer=answer, regime=motion.regime, height=motion.height, method=motion.method,
        ledger=motion.ledger, other_velocity=motion.other_velocity, statistics=motion.statistics,
        seconds=time.perf_counter() - begun,
    )  # fmt: skip


class _Solution(NamedTuple):
    """A steady motion as a method returns it, its error relative to the reference speed."""

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
        """Return the motion with a larger error, the reason for it, and the velocity of the other motion."""
        return self._replace(
            relative_error=self.relative_error + error, message=f"{self.message}; {reason}", other_velocity=other
        )  # fmt: skip

    def unchecked(self, reason):
        """Return the motion with an error of at least the reference speed, since it could not be checked."""
        return self.in_doubt(0.0, reason)._replace(relative_error=max(self.relative_error, 1.0))


def _closed(slider, orbits):
    """Return the motion of a closed form, else None."""
    known = closed_form(slider, orbits)
    if known is None:
        return None
    return _Solution(
        message=f"{known.pop('why')}: closed form", method="exact", relative_error=0.0, statistics={},
        ledger=Ledger(*[0.0] * len(Ledger._fields)), **known,
    )  # fmt: skip


class _Mean(NamedTuple):
    """The averaged steady state: velocity where the crests drive towards +x, and its relative error."""

    velocity: float
    error: float
    height: float
    regime: str


class _Question(NamedTuple):
    """A steady state to compute, on the side on which the crests drive towards +x: mirrored waves, mirrored answers."""

    slider: Slider
    orbits: tuple[Orbit, ...]
    method: str
    side: float  # sign of velocities on that side
    ratio: float  # contact resonance over frequency of the wave
    mean: _Mean | None  # None where averaging is no answer
    balance: Balance  # from which the full motion starts
    failure: ConvergenceError | None = None  # what the method before ran into

    @property
    def unit(self):
        """Unit of velocity of the balance's problem, m/s."""
        return self.balance.problem.speed

    @property
    def hops(self):
        """Whether a slider whose motion does not repeat with the wave's period may leave its mean height."""
        # the contact's damper acts on the slider within a few cycles, so that it does not ride still
        adhesive = self.balance.problem.contact_damping * self.balance.problem.preload > 1e-2
        unstable = self.failure is not None and self.failure.status == "unstable"
        return self.ratio > MAX_RATIO_HELD or unstable or adhesive

    def relative(self, difference, velocity):
        """Return a difference of velocities over the reference speed."""
        return relative_to_reference(difference, velocity, self.orbits)

    def solution(self, message, motion, *, velocity, error, height, sticks, cycles=1, **statistics):
        """Return the answer of a motion whose sums cover some cycles; `velocity` on this side, `height` in m."""
        counted = motion.events()
        moving = "intermittent" if counted["release"] else "slip"
        return _Solution(
            velocity=float(self.side * velocity) if velocity else 0.0, regime="stick" if sticks else moving,
            relative_error=float(error), height=float(height), message=message, method="exact",
            statistics=counted | statistics, ledger=ledger(self.slider, motion, spans=cycles),
        )  # fmt: skip


def _by_methods(slider, orbits, method):
    """Return the motion by the method wanted, or by the first of the table that applies and converges."""
    side, driven = towards_plus(orbits)
    ratio = slider.normal_resonance(len(orbits)) / orbits[0].frequency
    question = _Question(slider, driven, method, side, ratio, *_equilibrium(slider, driven, ratio, method))
    return _averaged(question) if method == "averaged" else first_to_converge(STEADY_METHODS, question)


def _equilibrium(slider, orbits, ratio, method):
    """Return (averaged steady state, None where averaging is no answer; balance to start the full motion from)."""
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
    """Return the averaged steady state of a law that only the event-driven solver knows; of first order."""
    error = AVERAGING_ERROR * ratio**2
    if balance.held:
        larger = 1.0 + min(THRESHOLD_ERROR * ratio**2, MAX_THRESHOLD_ERROR)
        beyond = balanced(slider, tuple(orbit.scaled(larger) for orbit in orbits))
        error = relative_to_reference(beyond.speed * beyond.problem.speed, 0.0, orbits)
    events = balance.motion.events()
    slips = "slip" if events["stick_to_slip"] or not balance.held else "stick"
    return _Mean(
        balance.speed * balance.problem.speed, error, balance.height * balance.problem.length,
        "intermittent" if events["release"] else slips,
    )  # fmt: skip


def _periodic(question):
    """Return the motion that repeats with the wave's period, or the one that a slider from rest reaches instead."""
    motion, repeating = _repeating(question)
    if question.ratio <= MAX_RATIO_HELD:
        bounces = motion.velocity != 0.0 and _undamped(question.slider)
        return _bouncing(question, motion) if bounces else motion
    seen = reached(question.slider, question.orbits, question.balance, repeating)
    if seen.instead is not None:
        note = (
            f"a motion that repeats every cycle has {motion.velocity:.4g} m/s, but is not reached from rest"
        )
        return _settled(question, seen.instead).in_doubt(0.0, note, motion.velocity)
    if not seen.reason:
        return motion
    other = None if seen.speed is None else float(question.side * seen.speed * question.unit)
    mean = "" if other is None else f", with {other:.4g} m/s in the mean"
    doubt = question.relative(seen.doubt * question.unit, motion.velocity)
    return motion.in_doubt(doubt, f"{seen.reason}{mean}", other)


def _periodic_refusals(question):
    if question.balance.held:
        return ("friction holds the slider in the mean",)
    return ("the wave is too slow for the contact",) if question.ratio > SLOWEST_WAVE else ()


def _repeating(question):
    """Return (motion of the full equations, as `periodic` returns it): stable, repeating with the wave's period."""
    balance = question.balance
    unit, segments = balance.problem.speed, balance.problem.segments
    if segments > MAX_SEGMENTS:
        raise ConvergenceError(
            "out of reach", f"a cycle takes {segments:.3g} stretches of the motion; raise the mass"
        )
    try:
        fine = periodic(balance, nodes=16, truncation=1e-12)
    except ConvergenceError:
        # averaging is no start here: let the motion settle by itself first, for some 30 000 segments at most
        settle = int(min(SETTLE, 5.0 + 5000.0 * balance.problem.longest))
        fine = periodic(balance, nodes=16, truncation=1e-12, settle=settle)
    coarse = periodic(balance, nodes=10, truncation=1e-8, near=fine)
    if not fine.stable:
        raise ConvergenceError(
            "unstable",
            f"the motion that repeats with the wave's period grows by {fine.growth:.6g} per cycle: the slider hops",
        )
    sticks = fine.motion.memory is None and fine.motion.sticks
    velocity, error = fine.speed * unit, (abs(fine.speed - coarse.speed) + fine.step + fine.rounding) * unit
    velocity, error = (0.0, 0.0) if sticks else (velocity, question.relative(error, velocity))  # 0: rounding
    motion = question.solution(
        "periodic motion of the full equations", fine.motion, velocity=velocity, error=error, sticks=sticks,
        height=-fine.state[0] * balance.problem.length,
    )  # fmt: skip
    return motion, fine


def _undamped(slider):
    """Return whether nothing ends the bounce of a start from rest."""
    return slider.normal_damping == 0.0 and slider.contact_damping == 0.0


def _bouncing(question, motion):
    """Return the motion with the bounce that no damper ends as a part of its error.

    For the laws that the cycle means do not know the difference in velocity is that of the elastic law.
    """
    elastic = replace(question.slider, law="elastic", reciprocal=False)
    problem = scaled(elastic, question.orbits, direction=question.balance.load_sign, start=0.0)
    rest = elastic.rest_approach(len(question.orbits)) / problem.length
    lost = speed_lost(problem, rest, motion.height / problem.length) * problem.speed
    if not np.isfinite(lost):
        return motion.unchecked(
            "how fast the slider is while it bounces without normal damping was not found"
        )
    other = float(motion.velocity + question.side * lost)
    return motion.in_doubt(question.relative(lost, motion.velocity), GOES_ON.format(other), other)


def _held_bouncing(question, motion):
    """Return the answer of a slider that is held, with what the bounce of a start from rest, never damped, moves it."""
    cycles = int(min(max(BOUNCES / question.ratio, SETTLE), MAX_BOUNCE_CYCLES))
    try:
        mean = mean_from_rest(question.slider, question.orbits, question.balance.load_sign, cycles)
    except ConvergenceError as failed:
        return motion.unchecked(f"the bounce of a start from rest was not followed: {failed}")
    moved = float(question.side * mean)
    error = question.relative(moved, 0.0)
    return motion if error <= motion.relative_error else motion.in_doubt(error, GOES_ON.format(moved), moved)


def _averaged(question):
    """Return the averaged motion; the energies are those of a cycle at constant height and velocity."""
    mean, held, cycle = question.mean, question.balance.held, question.balance.motion
    cycle.begun = cycle.energy()  # the cycle repeats
    note = "held by friction" if held else "cycle means"
    if question.failure is not None:
        note += f", for the full motion was not found: {question.failure}"
    motion = question.solution(
        note, cycle, velocity=mean.velocity, error=mean.error, height=mean.height, sticks=held
    )._replace(method="averaged", regime=mean.regime)
    bounces = held and question.method != "averaged" and _undamped(question.slider)
    return _held_bouncing(question, motion) if bounces else motion


def _averaged_refusals(question):
    if question.mean is not None and question.balance.held:
        return ()
    if question.method == "exact":
        return ("the exact motion is wanted",)
    return ("the slider may leave its mean height",) if question.hops else ()


def _from_rest(question):
    """Return the answer of a long run from rest: the slider hops, or is carried by a slow wave."""
    return _settled(question, long_run(question.slider, question.orbits, question.balance.load_sign))


def _from_rest_refusals(question):
    return () if question.hops else ("the slider keeps its mean height and takes long to settle",)


def _settled(question, run):
    """Return the answer that a long run gives."""
    unit = run.motion.problem.speed
    if run.sticks:
        note = "every contact sticks"
    elif run.period:
        note = f"motion that repeats after {run.period} cycles, reached from rest in {run.passed}"
    else:
        note = (
            f"mean of {run.cycles} cycles after {run.passed} from rest, for no motion that repeats was seen"
        )
    if run.starts > 1:
        note += "; two runs from almost the same start were compared"
    return question.solution(
        note, run.motion, velocity=run.speed * unit, error=question.relative(run.error * unit, run.speed * unit),
        sticks=run.sticks, height=run.height * run.motion.problem.length, cycles=run.cycles, period_cycles=run.period,
        averaged_cycles=run.cycles,
    )  # fmt: skip


# In the order in which they are tried. The averaged method answers for a slider that friction holds, and for one that
# keeps its height but whose periodic motion was not found; a long run from rest answers for the others.
STEADY_METHODS = {
    "periodic": Method(_periodic, _periodic_refusals),
    "averaged": Method(_averaged, _averaged_refusals),
    "from rest": Method(_from_rest, _from_rest_refusals),
}
