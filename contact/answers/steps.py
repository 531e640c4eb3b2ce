r"""Steps on demand: what a number of cycles moves the slider by, how many cycles a step takes, where it stops.

A step is a burst from rest and what follows until the slider is held by its spring and rings about where it will stay.
The wave may swell and fade as envelopes say: a step of N cycles of the drive takes in what the surface still does after
the drive's end.
The net displacement is the travel of the slider to where its tangential spring is relaxed: position plus the load's
own deformation of the contact, so the ring does not blur it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from contact import bounds
from contact.answers.methods import (
    EXACT_CYCLES,
    rest,
    rest_problem,
    ring_down,
    shaped_steps,
    silence,
    stepped_refusals,
)
from contact.choice import Answer
from contact.codes import Event, Regime
from contact.convergence_error import ConvergenceError
from contact.drive import towards_plus
from contact.envelope import Envelope
from contact.events.energy import Sum
from contact.events.segment import Column
from contact.law.normal import slope
from contact.orbit import Orbit, as_orbits
from contact.slider import Slider
from contact.stepping.time_stepping import steps

MAX_CYCLES = 3_000_000
# Half ring periods without a slip after which the slider is held, and that many where a slip might still follow: a beat
# of bounce and ring takes 2/(f_n/f_t - 1) of them, 4 to 30 for the usual moduli
QUIET_SPANS, UNSURE_SPANS = 12, 200
# slip that is waited for, and slip up to which the stopping time counts, over the slip limit at rest
SETTLED, VISIBLE = 1e-12, 1e-3
# Least error, over the largest of the step, its travel during the burst and the slip limit at rest: two levels may
# agree by chance, and the finer one errs by up to 3e-11 (90 draws of `tests/contact/aimed.py`)
LEAST_ERROR = 2e-11
# A hysteretic contact remembers partial slip, so that the ring dies out about another place: 0.07 to 0.37 of the ring
# away in `tests/contact/test_stall_and_steps.py` and five scenes like it
MEMORY_SHIFT = 0.5
# regimes of a contact that holds its place; in the last two it does not slip as a whole
HOLDING = (Regime.STICK, Regime.ANNULUS, Regime.GROW)


@dataclass(frozen=True, kw_only=True)
class Step:
    """A step of the motor.

    Attributes
    ----------
    cycles : int
        Of the drive; 0 where none is needed.
    displacement : float
        Net, m, positive along +x: where the slider settles, the ring taken out.
    during, stopping : float
        Travel during the burst and after it, the ring-down included, m; they sum to `displacement`.
    velocity : float
        At the end of the burst, m/s.
    stopping_time : float
        s from the end of the burst to the last slip of more than a thousandth of the slip limit; after a ring-down at
        least to its end.
    ring : float
        Amplitude of the ring that is left, m.
    error : float
        Estimated error of the displacement, m, from a second computation at another order or step size; with the
        hysteretic law mostly half of the ring, by which its memory may shift the place where it settles.
    """

    cycles: int
    displacement: float
    during: float
    stopping: float
    velocity: float
    stopping_time: float
    ring: float
    error: float

    @property
    def answer(self) -> Answer:
        """The displacement, m, with its error."""
        return Answer(value=self.displacement, error=self.error, reasons=(f"{self.cycles} cycles from rest",))


def step(
    slider: Slider,
    orbits: Orbit | tuple[Orbit, ...],
    *,
    cycles: int,
    envelope: Envelope | None = None,
    after: Envelope | None = None,
) -> Step:
    """Return the step that a burst of whole cycles makes from rest.

    Parameters
    ----------
    slider, orbits
        As for `steady`; without friction the slider never stops.
    cycles : int
        Of the drive, at least one.
    envelope : Envelope, optional
        Factor on the orbits during the burst; without one the wave is at full size from the first cycle.
    after : Envelope, optional
        Factor on the orbits while the surface rings down, time from the end of the burst; without one it stands still.

    Returns
    -------
    Step
    """
    listed = as_orbits(orbits)
    cycles = bounds.count("cycles", cycles, 1)
    if slider.static_friction(len(listed)) <= slider.load:
        raise ConvergenceError(
            "runaway", "friction cannot hold the load, so the slider never stops; lower slider.load"
        )
    (fine, factor), (coarse, _) = (
        _step_at(slider, listed, cycles, envelope, after, level) for level in (FINE, COARSE)
    )
    scale = max(
        abs(fine.displacement), abs(fine.during), slider.limit_slope * slider.rest_approach(len(listed))
    )
    estimate = factor * abs(fine.displacement - coarse.displacement)
    remembered = MEMORY_SHIFT * fine.ring if slider.law == "hysteretic" else 0.0
    return replace(fine, error=estimate + LEAST_ERROR * scale + remembered)


class _Level(NamedTuple):
    """How finely a step is computed."""

    nodes: int  # per segment of the event-driven motion
    truncation: float  # allowed per segment
    longest: float  # longest segment over that of the problem
    steps: int  # fixed steps per cycle, under an envelope
    ringing_steps: int  # fixed steps per cycle while the surface rings down


FINE = _Level(12, 1e-10, 1.0, 96, 80)
COARSE = _Level(10, 1e-8, 0.8, 64, 56)


def _step_at(slider, orbits, cycles, envelope, after, level):
    """Return (step at one level, its error left 0; factor from the difference of two levels to the finer one's error).

    Every event is followed with spectral accuracy, so that the difference is the coarser level's error; fixed steps
    are counted on to converge with first order.
    """
    side, driven = towards_plus(orbits)
    problem = rest_problem(slider, driven)
    problem = problem._replace(longest=level.longest * problem.longest)
    factor = complex(envelope.at(np.zeros(1))[0]) if envelope is not None else 1.0
    motion = rest(slider, driven, problem, nodes=level.nodes, truncation=level.truncation, factor=factor)
    burst_travel, stepped = _drive(slider, motion, cycles, envelope, level.steps)
    velocity, ringing_time, ringing_travel = float(motion.state[2]), 0.0, 0.0
    if after is not None:
        times, rows = ring_down(slider, motion, after, least=level.ringing_steps)
        ringing_time, stepped = float(times[-1]) if times.size else 0.0, True
        ringing_travel = _distance(rows)
    still_travel, last_slip, ring = _stopped(slider, motion)
    during, stopping = (
        side * problem.length * burst_travel,
        side * problem.length * (ringing_travel + still_travel),
    )
    found = Step(
        cycles=cycles, displacement=during + stopping, during=during, stopping=stopping,
        velocity=side * velocity * problem.speed, stopping_time=ringing_time + last_slip / problem.omega,
        ring=ring * problem.length, error=0.0,
    )  # fmt: skip
    return found, 1.0 / (FINE.steps / COARSE.steps - 1.0) if stepped else 1.0


def cycles_for(
    slider: Slider,
    orbits: Orbit | tuple[Orbit, ...],
    *,
    displacement: float,
    envelopes: Callable[[int], tuple[Envelope, Envelope | None]] | None = None,
) -> tuple[Step, Step]:
    """Return the largest step that does not reach a displacement and the next, one cycle more, that does.

    The first has no cycles where one cycle is enough.

    Parameters
    ----------
    slider, orbits
        As for `step`.
    displacement : float
        Size of the step, m, positive; the direction is the motor's.
    envelopes : callable, optional
        Number of cycles of the burst to its `envelope` and `after`, as for `step`.

    Raises
    ------
    ConvergenceError
        Status "out of reach" when 3 million cycles do not move the slider so far.
    """
    listed = as_orbits(orbits)
    wanted = bounds.positive("displacement", displacement, "m")
    known = {0: Step(cycles=0, **dict.fromkeys(Step.__annotations__.keys() - {"cycles"}, 0.0))}

    def shape(number):
        return (None, None) if envelopes is None else envelopes(number)

    def at(number):
        if number not in known:
            known[number], _ = _step_at(slider, listed, number, *shape(number), FINE)
        return known[number]

    def with_error(number):
        envelope, after = shape(number)
        return step(slider, listed, cycles=number, envelope=envelope, after=after) if number else at(0)

    # A few cycles may leave the slider on either side of its start, and a wave may take longer to arrive: the motor's
    # direction is that of many cycles.
    many = 256
    while abs(at(many).displacement) < wanted:
        many *= 2
        if many > MAX_CYCLES:
            raise ConvergenceError(
                "out of reach",
                f"{many // 2} cycles move the slider by {at(many // 2).displacement:.3g} m; raise the amplitude or the "
                "time",
            )
    direction = math.copysign(1.0, at(many).displacement)
    low, high = 0, 8
    while direction * at(high).displacement < wanted:
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if direction * at(middle).displacement >= wanted else (middle, high)
    return with_error(low), with_error(high)


def _drive(slider, motion, cycles, envelope, per_cycle):
    """Move through the burst; return the distance travelled, scaled, and whether in fixed steps."""
    problem = motion.problem
    if envelope is None:
        if cycles <= EXACT_CYCLES or stepped_refusals(slider, problem, per_cycle):
            motion.turn(cycles)
            return float(motion.sums[Sum.DISPLACEMENT]), False
        return _distance(steps(problem, motion.state, cycles, per_cycle)), True
    number = shaped_steps(slider, problem, per_cycle)
    shape = envelope.at(np.arange(cycles + 1) * (2.0 * math.pi / problem.omega))
    return _distance(steps(problem, motion.state, cycles, number, envelope=shape)), True


def _distance(rows) -> float:
    """Return the distance travelled over cycles of which every one has a row, scaled."""
    return float(2.0 * math.pi * np.sum(rows[:, Column.MEAN_VELOCITY]))


def _stopped(slider, motion):
    """Follow the slider until it is held; return (travel, phase of its last visible slip, ring that is left), scaled.

    While every contact sticks, the travel plus the deformation of the contacts is constant; less the deformation that
    the load causes it is where the slider will settle. A slip moves that place. The run goes in spans of half a ring
    period and ends after some in which the place moves by less than `SETTLED`: `QUIET_SPANS` where the largest
    deformation stays below the slip limit at the least approach, so that no slip can follow, else
    `UNSURE_SPANS`, for bounce and ring beat against each other.
    """
    problem, contacts, speed = motion.problem, motion.problem.contacts, abs(float(motion.state[2]))
    # the load's own deformation of the contacts, each weighted with its share of the stiffness at rest
    share = slope(slider.rest_approach(contacts) + slider.offsets(contacts), slider.contact_shape)
    share = share / np.sum(share)
    spring = np.copysign(share @ slider.rest_deformations(contacts), problem.load) / problem.length
    still = silence(motion)
    period = problem.omega / slider.tangential_resonance(contacts)
    friction = slider.least_friction(contacts) - slider.load
    if friction <= 0.0:  # the slips are waited for in any case
        friction = slider.static_friction(contacts) - slider.load
    brake = speed * problem.speed * slider.mass / friction * problem.omega
    unit = problem.limit_slope * slider.rest_approach(contacts) / problem.length
    phase, last, quiet = 0.0, 0.0, 0
    now = settled = float(still.state[3:] @ share - spring)
    ring, lowest, farthest = 0.0, np.full(contacts, math.inf), np.zeros(contacts)
    while quiet < (QUIET_SPANS if _surely_sticks(problem, share, lowest, farthest) else UNSURE_SPANS):
        span = 0.5 * period if phase >= brake else max(0.5 * period, 0.25 * brake)
        at = phase + span * np.arange(1, 33) / 32
        still.tally[:] = 0
        samples = still.move(phase, float(at[-1]) * (1.0 + 1e-14), at)
        phase = float(at[-1])
        approach, deformation, _, _, regime, _ = np.moveaxis(samples, -1, 0)
        # a contact that does not touch at rest holds nothing
        loose = ~np.isin(regime, HOLDING) & ((regime != Regime.SEPARATED) | (share > 0.0))
        slipping = np.flatnonzero(np.any(loose, axis=1))
        before, now = now, float(still.sums[Sum.DISPLACEMENT] + still.state[3:] @ share - spring)
        # many slips are shorter than the time between two samples: the tally has them all
        slipped = slipping.size or still.tally[Event.STICK_TO_SLIP] + still.tally[Event.RELEASE] > 0
        if slipped and abs(now - before) > VISIBLE * unit:
            last = float(at[slipping[-1] if slipping.size else -1])
        if slipped and abs(now - settled) > SETTLED * unit:
            quiet, settled = 0, now
            ring, lowest, farthest = 0.0, np.full(contacts, math.inf), np.zeros(contacts)
        else:
            quiet += 1
            ring = max(ring, float(np.max(np.abs(deformation @ share - spring))))
            lowest = np.minimum(lowest, np.min(approach, axis=0))
            farthest = np.maximum(farthest, np.max(np.abs(deformation), axis=0))
        if phase > 1e9:
            raise ConvergenceError(
                "not converged", "the slider goes on slipping; give it normal or tangential damping"
            )
    return now, last, ring


def _surely_sticks(problem, share, lowest, farthest):
    """Return whether contacts with these least approaches and largest deformations stay within the slip limit."""
    holding = np.flatnonzero(share)
    limits = [problem.law.limit(problem, float(z)) if z > 0.0 else 0.0 for z in lowest[holding]]
    return bool(np.all(farthest[holding] < limits))
