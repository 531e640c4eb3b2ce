r"""Steps of the motor: displacement by a burst of N cycles, and number of cycles for a required displacement.

A step consists of a burst from rest and the motion after it, until the contacts stick and the slider only rings about
its final position. Envelopes may describe the wave's amplitude during the burst and the ring-down of the surface after
it. The net displacement is the distance to the final position, at which the tangential springs carry just the load. It
follows from the slider's position and the contact deformation at any time after the last slip, so that the amplitude
of the ring does not affect it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from contact import parameter_check
from contact.answers.event_driven_burst import EXACT_CYCLES
from contact.answers.rest_motion import rest, rest_problem, silence
from contact.answers.ring_down import ring_down, shaped_steps, spent
from contact.answers.stepped_burst import stepped_refusals
from contact.choice import Answer
from contact.codes import Event, Recorded, Regime
from contact.envelope import Envelope
from contact.error_estimate import travel_error
from contact.events.energy import EnergySum
from contact.exceptions import ConvergenceError
from contact.law.protocol import slip_limit
from contact.orbit import towards_plus
from contact.passing_wave import Surface, prescribed
from contact.problem import contact_parameters
from contact.slider import Slider
from contact.stepping.time_stepping import steps

MAX_CYCLES = 2**21  # the last number that `cycles_for` tries when it doubles from 256
# The slider counts as held after this many spans (half periods of the ring) without slip: QUIET_SPANS if no slip can
# follow, UNSURE_SPANS if one might. A beat of bounce and ring takes 2/(f_n/f_t - 1) spans, 4 to 30 for usual moduli.
QUIET_SPANS, UNSURE_SPANS = 12, 200
# It is also held after QUIET_SPANS whose bounce, over the approach at rest, is below CALM and in each of which it slips
# by less than CALM_SLIP, over the slip limit at rest: a ring that just touches the limit slips by its rounding for
# ever. In 60 random steps with f_t = 0.8 to 1.1 f_n no CALM from 1e-11 to 1e-2 changed the step by more than 3e-12
# slip limits.
CALM, CALM_SLIP = 1e-9, 1e-6
# Without a damper the bounce never ends. It moves a slider on under a load, and to and fro where the ring is about as
# fast as the bounce: such a slider still slips after ENDLESS_SPANS half periods of the ring (2 s). With very light
# dampers (f_n/f = 0.2 and a loss of 1e-6 of the bounce in a cycle) the same takes very long: MAX_SPANS (half a minute).
ENDLESS_SPANS, MAX_SPANS = 10_000, 100_000
# Distances over the slip limit at rest. SETTLED: smaller displacements by slip are ignored. VISIBLE: the stopping time
# ends with the last slip above this one.
SETTLED, VISIBLE = 1e-12, 1e-3
# regimes in which a contact does not slip as a whole
HOLDING = (Regime.STICK, Regime.ANNULUS, Regime.GROW)


@dataclass(frozen=True, kw_only=True)
class Step:
    """A step of the motor.

    Attributes
    ----------
    cycles : int
        Number of cycles of the drive; 0 if none is needed.
    displacement : float
        Net displacement along +x to the final position, without the ring, m.
    during, stopping : float
        Travel during the burst and after it (with the ring-down of the surface), m. Their sum is `displacement`.
    velocity : float
        Velocity at the end of the burst, m/s.
    stopping_time : float
        Time in s from the end of the burst to the last slip above a thousandth of the slip limit. If the surface rings
        down, it is at least the duration of the ring-down.
    ring : float
        Amplitude of the remaining ring, m.
    error : float
        Estimated error of the displacement, m, from a second computation at another order or step size. With the
        hysteretic law it is mostly half of the ring, because partial slip may shift the final position.
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
    slider: Slider, orbits: Surface, *, cycles: int, envelope: Envelope | None = None, after: Envelope | None = None
) -> Step:
    """Return the step that a burst of whole cycles makes from rest.

    Parameters
    ----------
    slider, orbits
        As for `steady`. Friction must exceed the load, or the slider never stops.
    cycles : int
        Number of cycles of the drive, at least one.
    envelope : Envelope, optional
        Factor on the orbits during the burst. Without it the wave has its full amplitude from the first cycle.
    after : Envelope, optional
        Factor on the orbits during the ring-down of the surface, with the time from the end of the burst. Without it
        the surface is at rest after the burst. A wave that is left at its last time ends there, and its amplitude is in
        the error.

    Returns
    -------
    Step
    """
    slider, listed = prescribed(slider, orbits, in_time=True)
    cycles = parameter_check.count("cycles", cycles, 1)
    if slider.static_friction(len(listed)) <= slider.load:
        raise ConvergenceError("runaway", "friction cannot hold the load, so the slider never stops; lower slider.load")
    (fine, fine_steps, fine_way), (coarse, coarse_steps, coarse_way) = (
        _step_at(slider, listed, cycles, envelope, after, level) for level in (FINE, COARSE)
    )
    # the two displacements may agree by chance, the ways to them do not
    apart = np.abs(fine_way - coarse_way)[fine_way.size // 2 :]
    scale = max(abs(fine.displacement), abs(fine.during), slider.slope_unit * slider.rest_approach(len(listed)))
    amplitude_left = 0.0
    if after is not None:
        largest = max(abs(amplitude) for each in listed for amplitude in (each.normal, each.tangential))
        amplitude_left = abs(complex(after.at(np.array([spent(after)]))[0])) * largest
    error = travel_error(
        float(np.max(apart, initial=abs(fine.displacement - coarse.displacement))),
        [(f, c) for f, c in zip(fine_steps, coarse_steps, strict=True) if f and c],
        scale=scale, ring=fine.ring if slider.law == "hysteretic" else 0.0, cut=amplitude_left,
    )  # fmt: skip
    return replace(fine, error=error)


class _Level(NamedTuple):
    """Resolution at which a step is computed."""

    nodes: int  # per segment of the event-driven motion
    truncation: float  # allowed truncation error per segment
    longest: float  # maximum segment length over that of the problem
    steps: int  # fixed steps per cycle, under an envelope; more if the contact is stiff (`_shaped_steps`)
    ringing_steps: int  # the same while the surface rings down


FINE = _Level(12, 1e-10, 1.0, 96, 80)
COARSE = _Level(10, 1e-8, 0.8, 64, 56)


def _shaped_steps(slider, problem, least, coarsest):
    """Return the steps per cycle of a level that has at least `least`, where the coarse level has `coarsest`.

    A stiff contact raises the number of the coarse level. That of the fine level rises with it, since two levels with
    equal numbers would differ by nothing.
    """
    return shaped_steps(slider, problem, coarsest) * least // coarsest


def _step_at(slider, orbits, cycles, envelope, after, level):
    """Return (step at one level without its error, fixed steps per cycle in the burst and in the ring-down, way).

    The number of steps is 0 where no fixed steps were used. The way is the travel in m from rest to the ends of the
    cycles that were followed in fixed steps.
    """
    side, driven = towards_plus(orbits)
    problem = rest_problem(slider, driven)
    problem = problem._replace(longest=level.longest * problem.longest)
    factor = complex(envelope.at(np.zeros(1))[0]) if envelope is not None else 1.0
    motion = rest(slider, driven, problem, nodes=level.nodes, truncation=level.truncation, factor=factor)
    burst_travel, burst_steps, way = _drive(slider, motion, cycles, envelope, level.steps)
    velocity, ringing_time, ringing_travel, ringing_steps = float(motion.state[2]), 0.0, 0.0, 0
    if after is not None:
        ringing_steps = _shaped_steps(slider, problem, level.ringing_steps, COARSE.ringing_steps)
        times, record = ring_down(slider, motion, after, least=ringing_steps)
        ringing_time = float(times[-1]) if times.size else 0.0
        ringing = _way(record)
        ringing_travel, way = float(np.sum(ringing[-1:])), np.append(way, burst_travel + ringing)
    still_travel, last_slip, ring = _stopped(slider, motion)
    during, stopping = (side * problem.length * burst_travel, side * problem.length * (ringing_travel + still_travel))
    result = Step(
        cycles=cycles, displacement=during + stopping, during=during, stopping=stopping,
        velocity=side * velocity * problem.speed, stopping_time=ringing_time + last_slip / problem.omega,
        ring=ring * problem.length, error=0.0,
    )  # fmt: skip
    return result, (burst_steps, ringing_steps), problem.length * way


def cycles_for(
    slider: Slider,
    orbits: Surface,
    *,
    displacement: float,
    envelopes: Callable[[int], tuple[Envelope, Envelope | None]] | None = None,
) -> tuple[Step, Step]:
    """Return the longest step that does not reach a displacement, and the step with one cycle more, which reaches it.

    If one cycle is enough, the first step has no cycles.

    Parameters
    ----------
    slider, orbits
        As for `step`.
    displacement : float
        Required size of the step in the direction of the motor's motion, m, positive.
    envelopes : callable, optional
        Takes the number of cycles of the burst and returns its `envelope` and `after`, as for `step`.

    Raises
    ------
    ConvergenceError
        Status "out of reach" if 2^21 cycles, about 2 million, do not reach the displacement.
    """
    slider, listed = prescribed(slider, orbits, in_time=True)
    wanted = parameter_check.positive("displacement", displacement, "m")
    known = {0: Step(cycles=0, **dict.fromkeys(Step.__annotations__.keys() - {"cycles"}, 0.0))}

    def shape(number):
        return (None, None) if envelopes is None else envelopes(number)

    def at(number):
        if number not in known:
            known[number], *_ = _step_at(slider, listed, number, *shape(number), FINE)
        return known[number]

    def with_error(number):
        if number == 0:  # a burst of no cycles has no envelope
            return at(0)
        envelope, after = shape(number)
        return step(slider, listed, cycles=number, envelope=envelope, after=after)

    # Take the direction of motion from many cycles: a few cycles may end on either side of the start, and an envelope
    # may be small at first.
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
    """Advance the motion through the burst; return (scaled travel, fixed steps per cycle or 0, their `_way`)."""
    problem = motion.problem
    if envelope is None:
        if cycles <= EXACT_CYCLES or stepped_refusals(slider, problem, per_cycle):
            motion.turn(cycles)
            return float(motion.sums[EnergySum.DISPLACEMENT]), 0, np.empty(0)
    else:
        per_cycle = _shaped_steps(slider, problem, per_cycle, COARSE.steps)
    way = _way(steps(problem, motion.state, cycles, per_cycle, envelope=envelope))
    return float(way[-1]), per_cycle, way


def _way(record):
    """Return the scaled travel to the end of each cycle, one per sample."""
    return 2.0 * math.pi * np.cumsum(record[:, Recorded.MEAN_VELOCITY])


@dataclass
class _Quiet:
    """What has been observed since the last slip that changed the final position, scaled."""

    final_position: float
    spans: int  # half periods of the ring
    ring: float  # largest distance of the slider from the final position
    least_approach: np.ndarray  # (contacts,)
    largest_deformation: np.ndarray  # (contacts,), absolute

    @classmethod
    def begin(cls, final_position: float, contacts: int) -> "_Quiet":
        """Return the state right after a slip."""
        return cls(final_position, 0, 0.0, np.full(contacts, math.inf), np.zeros(contacts))

    def add(self, to_rest, approach, deformation):
        """Add one span: the slider's distances to rest (samples,), the contacts' states (samples, contacts)."""
        self.spans += 1
        self.ring = max(self.ring, float(np.max(np.abs(to_rest))))
        self.least_approach = np.minimum(self.least_approach, np.min(approach, axis=0))
        self.largest_deformation = np.maximum(self.largest_deformation, np.max(np.abs(deformation), axis=0))

    def is_held(self, problem, holding) -> bool:
        """Return True if the slider counts as held; `holding`: contacts that touch at rest."""
        if self.spans < QUIET_SPANS:
            return False
        if self.spans >= UNSURE_SPANS:
            return True
        contacts = (contact_parameters(problem, i) for i in holding)
        limits = [
            slip_limit(each, float(z)) if z > 0.0 else 0.0
            for each, z in zip(contacts, self.least_approach[holding], strict=True)
        ]
        return bool(np.all(self.largest_deformation[holding] < limits))


def _stopped(slider, motion):
    """Follow the slider until it is held; return (travel, phase of the last visible slip, remaining ring), scaled.

    While every contact sticks, the travel so far plus the distance to rest, at which the springs carry just the load,
    is constant: the final position. A slip changes it. The run proceeds in spans of half a ring period, longer ones
    while the slider brakes. It ends after a number of spans in which the final position changes by less than `SETTLED`.
    The number is `QUIET_SPANS` if the largest deformation stays below the slip limit at the least approach, because no
    slip can then follow, and if the bounce has died out (`CALM`), because only a bounce lowers the limit again.
    Otherwise it is `UNSURE_SPANS`, because the beat of bounce and ring may cause a later slip.
    """
    problem, contacts = motion.problem, motion.problem.contacts
    holding = np.flatnonzero(slider.rest_approaches(contacts))
    still = silence(motion)

    def distance_to_rest():
        load = math.copysign(slider.load, problem.load)
        return slider.distance_to_rest(still.state[3:] * problem.length, load) / problem.length

    half_period = 0.5 * problem.omega / slider.tangential_resonance(contacts)  # of the ring, as a phase of the wave
    braking = _braking_phase(slider, motion)
    rest = slider.rest_approaches(contacts)[holding] / problem.length
    slip_limit_at_rest = problem.limit_slope * slider.rest_approach(contacts) / problem.length
    undamped = problem.normal_damping == problem.contact_damping == 0.0
    max_phase = braking + (ENDLESS_SPANS if undamped else MAX_SPANS) * half_period
    phase, last_slip = 0.0, 0.0
    final_position = distance_to_rest()
    quiet, calm = _Quiet.begin(final_position, contacts), 0
    while calm < QUIET_SPANS and not quiet.is_held(problem, holding):
        span = half_period if phase >= braking else max(half_period, 0.25 * braking)
        at = phase + span * np.arange(1, 33) / 32
        still.tally[:] = 0
        samples = still.move(phase, float(at[-1]) * (1.0 + 1e-14), at)
        phase = float(at[-1])
        approach, deformation, _, _, regime, _ = np.moveaxis(samples, -1, 0)
        # a contact that does not touch at rest does not hold the slider, so that its separation is ignored
        loose = ~np.isin(regime, HOLDING) & ((regime != Regime.SEPARATED) | np.isin(np.arange(contacts), holding))
        slipping = np.flatnonzero(np.any(loose, axis=1))
        to_rest = distance_to_rest()
        before, final_position = final_position, float(still.sums[EnergySum.DISPLACEMENT]) + to_rest
        bounces = np.max(np.abs(approach[:, holding] / rest - 1.0)) > CALM
        calm = 0 if bounces or abs(final_position - before) > CALM_SLIP * slip_limit_at_rest else calm + 1
        # many slips are shorter than the sampling interval, but the tally counts every event
        slipped = slipping.size or still.tally[Event.STICK_TO_SLIP] + still.tally[Event.RELEASE] > 0
        if slipped and abs(final_position - before) > VISIBLE * slip_limit_at_rest:
            last_slip = float(at[slipping[-1] if slipping.size else -1])
        settled = (CALM_SLIP if calm else SETTLED) * slip_limit_at_rest
        if slipped and abs(final_position - quiet.final_position) > settled:
            quiet = _Quiet.begin(final_position, contacts)
        else:
            # A contact that sticks to the surface at rest is deformed by as much as the slider moves back. All that
            # hold move alike: the first one gives the distance to rest at the earlier samples.
            first = holding[0]
            quiet.add(to_rest + deformation[:, first] - still.state[3 + first], approach, deformation)
        if phase > max_phase:
            dampers = "normal" if undamped else "normal or tangential"
            raise ConvergenceError("not converged", f"the slider goes on slipping; give it {dampers} damping")
    return final_position, last_slip, quiet.ring


def _braking_phase(slider, motion):
    """Return an estimate of the phase in which friction stops the slider; it only sets the length of the spans."""
    problem, speed = motion.problem, abs(float(motion.state[2]))
    force = slider.least_friction(problem.contacts) - slider.load
    if force <= 0.0:
        force = slider.static_friction(problem.contacts) - slider.load
    return speed * problem.speed * slider.mass / force * problem.omega
