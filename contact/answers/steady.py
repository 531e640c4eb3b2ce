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
from contact.choice import Answer, Answered
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
    found = _closed(slider, listed) or _searched(slider, listed, method)
    velocity, message, relative = (found.pop(key) for key in ("velocity", "message", "relative_error"))
    reference = reference_speed(velocity, listed) or 1.0
    near = found["method"] == "averaged" and velocity == 0.0
    answer = Answer(value=velocity, error=relative * reference, reasons=(message,)).judged(
        tolerance, reference, "so near the threshold the slider may move" if near else ""
    )
    seconds = time.perf_counter() - begun
    return SteadyState(slider=slider, orbits=listed, answer=answer, seconds=seconds, **found)


def _closed(slider, orbits):
    """Return the answer of a closed form, else None."""
    found = closed_form(slider, orbits)
    if found is None:
        return None
    known = {"relative_error": 0.0, "message": f"{found.pop('why')}: closed form", "method": "exact"}
    return found | known | {"statistics": {}, "ledger": Ledger(*[0.0] * len(Ledger._fields))}


class _Search(NamedTuple):
    """A steady state, searched on the side on which the crests drive towards +x: mirrored waves, mirrored answers."""

    slider: Slider
    orbits: tuple[Orbit, ...]
    side: float
    ratio: float
    balance: Balance

    @property
    def unit(self):
        """Unit of velocity of the balance's problem, m/s."""
        return self.balance.problem.speed

    def relative(self, difference, velocity):
        """Return a difference of velocities over the reference speed."""
        return relative_to_reference(difference, velocity, self.orbits)

    def answer(self, message, motion, *, velocity, error, height, sticks, cycles=1, **statistics):
        """Return the answer of a motion whose sums cover some cycles; `velocity` on this side, `height` in m."""
        counted = motion.events()
        moving = "intermittent" if counted["release"] else "slip"
        return {
            "velocity": float(self.side * velocity) if velocity else 0.0, "regime": "stick" if sticks else moving,
            "relative_error": float(error), "height": float(height), "message": message, "method": "exact",
            "statistics": counted | statistics, "ledger": ledger(self.slider, motion, spans=cycles),
        }  # fmt: skip


def _searched(slider, orbits, method):
    side, driven = towards_plus(orbits)
    ratio = slider.normal_resonance(len(orbits)) / orbits[0].frequency
    mean, balance = _equilibrium(slider, driven, ratio, method)
    search = _Search(slider, driven, side, ratio, balance)
    if method == "averaged" or (mean is not None and mean["held"]):
        found = _averaged(search, mean)
        return _held_bouncing(search, found) if method != "averaged" and _undamped(slider) else found
    if balance.held or ratio > SLOWEST_WAVE:
        return _waited(search)
    try:
        return _reached(search)
    except ConvergenceError as failed:
        # the contact's damper acts on the slider within a few cycles, so that it does not ride still
        adhesive = balance.problem.contact_damping * balance.problem.preload > 1e-2
        if ratio > MAX_RATIO_HELD or failed.status == "unstable" or adhesive:
            return _waited(search)
        if method == "exact":
            raise
        found = _averaged(search, mean)
        return found | {"message": f"{found['message']}, for the full motion was not found: {failed}"}


def _reached(search):
    """Return the motion that repeats with the wave's period, or the one that a slider from rest reaches instead."""
    slider, answer, periodic_motion = search.slider, *_repeating(search)
    if search.ratio <= MAX_RATIO_HELD:
        return _bouncing(search, answer) if _undamped(slider) and answer["velocity"] != 0.0 else answer
    seen, unit, velocity = (
        reached(slider, search.orbits, search.balance, periodic_motion), search.unit, answer["velocity"],
    )  # fmt: skip
    if seen.instead is not None:
        found = _settled(search, seen.instead)
        note = f"; a motion that repeats every cycle has {velocity:.4g} m/s, but is not reached from rest"
        return found | {"message": found["message"] + note, "other_velocity": velocity}
    if not seen.reason:
        return answer
    other = None if seen.speed is None else float(search.side * seen.speed * unit)
    mean = "" if other is None else f", with {other:.4g} m/s in the mean"
    return answer | {
        "relative_error": answer["relative_error"] + search.relative(seen.doubt * unit, velocity),
        "message": f"{answer['message']}; {seen.reason}{mean}", "other_velocity": other,
    }  # fmt: skip


def _undamped(slider):
    """Return whether nothing ends the bounce of a start from rest."""
    return slider.normal_damping == 0.0 and slider.contact_damping == 0.0


def _bouncing(search, answer):
    """Return the answer with the bounce that no damper ends as a part of its error.

    For the laws that the cycle means do not know the difference in velocity is that of the elastic law.
    """
    elastic = replace(search.slider, law="elastic", reciprocal=False)
    problem = scaled(elastic, search.orbits, direction=search.balance.load_sign, start=0.0)
    rest, level = (
        elastic.rest_approach(len(search.orbits)) / problem.length,
        answer["height"] / problem.length,
    )
    lost = speed_lost(problem, rest, level) * problem.speed
    if not np.isfinite(lost):
        message = f"{answer['message']}; how fast the slider is while it bounces without normal damping was not found"
        return answer | {"relative_error": max(answer["relative_error"], 1.0), "message": message}
    other = answer["velocity"] + search.side * lost
    error = answer["relative_error"] + search.relative(lost, answer["velocity"])
    message = (
        f"{answer['message']}; without normal damping a start from rest goes on bouncing, at {other:.4g} m/s in the "
        "mean: give slider.damping.normal or slider.damping.contact"
    )
    return answer | {"relative_error": error, "message": message, "other_velocity": float(other)}


def _held_bouncing(search, answer):
    """Return the answer of a slider that is held, with what the bounce of a start from rest, never damped, moves it."""
    cycles = int(min(max(BOUNCES / search.ratio, SETTLE), MAX_BOUNCE_CYCLES))
    try:
        moved = search.side * mean_from_rest(search.slider, search.orbits, search.balance.load_sign, cycles)
    except ConvergenceError as failed:
        return answer | {
            "relative_error": max(answer["relative_error"], 1.0),
            "message": f"{answer['message']}; the bounce of a start from rest was not followed: {failed}",
        }
    if search.relative(moved, 0.0) <= answer["relative_error"]:
        return answer
    return answer | {
        "relative_error": answer["relative_error"] + search.relative(moved, 0.0), "other_velocity": float(moved),
        "message": f"{answer['message']}; without normal damping a start from rest goes on bouncing, at {moved:.4g} "
                   "m/s in the mean: give slider.damping.normal or slider.damping.contact",
    }  # fmt: skip


def _equilibrium(slider, orbits, ratio, method):
    """Return (averaged steady state or None where averaging is no answer, balance to start the full motion from).

    The averaged state is a dictionary: velocity on this side, height, held, error (relative) and regime.
    """
    if not refusals(slider, orbits, STIFFEST_STEADY):
        try:
            mean = mean_motion(slider, orbits)
        except ConvergenceError as failed:
            if failed.status == "runaway" or method == "averaged":
                raise
        else:
            known = {"height": mean.height, "held": bool(mean.held)}
            balance = cycle_at(slider, orbits, velocity=mean.first_order, load_sign=mean.load_sign, **known)
            known |= {"velocity": mean.velocity, "error": mean.relative_error, "regime": str(mean.regime)}
            return known, balance
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
    return {
        "velocity": balance.speed * balance.problem.speed, "height": balance.height * balance.problem.length,
        "regime": "intermittent" if events["release"] else slips, "held": balance.held, "error": error,
    }  # fmt: skip


def _repeating(search):
    """Return (answer of the full equations, the motion): stable, and repeating with the wave's period."""
    balance = search.balance
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
    velocity, error = (
        (0.0, 0.0) if sticks else (velocity, search.relative(error, velocity))
    )  # sticks: rounding
    answer = search.answer(
        "periodic motion of the full equations", fine.motion, velocity=velocity, error=error, sticks=sticks,
        height=-fine.state[0] * balance.problem.length,
    )  # fmt: skip
    return answer, fine


def _waited(search):
    """Return the answer of a long run from rest: the slider hops, or is carried by a slow wave."""
    return _settled(search, long_run(search.slider, search.orbits, search.balance.load_sign))


def _settled(search, run):
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
    return search.answer(
        note, run.motion, velocity=run.speed * unit, error=search.relative(run.error * unit, run.speed * unit),
        sticks=run.sticks, height=run.height * run.motion.problem.length, cycles=run.cycles, period_cycles=run.period,
        averaged_cycles=run.cycles,
    )  # fmt: skip


def _averaged(search, mean):
    """Return the averaged answer; the energies are those of a cycle at constant height and velocity."""
    held = mean.pop("held")
    regime = mean.pop("regime")
    note = "held by friction" if held else "cycle means"
    motion = search.balance.motion
    motion.begun = motion.energy()  # the cycle repeats
    answer = search.answer(note, motion, sticks=held, **mean)
    return answer | {"method": "averaged", "regime": regime}
