"""The event-driven motion of one slider on one wave: its state, and runs that change it.

All quantities are in the units of `contact.problem`.
"""

import copy
import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from contact.body import Coordinates, Point, approach
from contact.codes import At, Event, Recorded, Regime, Status, WorkCount
from contact.events import event_driven, segment
from contact.events.collocation import Collocation
from contact.events.energy import EnergySum, potential, spring_energy
from contact.events.many_contacts import MANY
from contact.events.segment import SampleColumn
from contact.events.transitions import open_regimes
from contact.exceptions import ConvergenceError
from contact.law import holding, hysteretic
from contact.problem import Problem, contact_parameters
from contact.slider import Slider

FAILURES = {
    Status.NOT_FINITE: "not finite: the motion overflowed; check mass, dampers and amplitude",
    Status.TOO_MANY: "too many events: events follow each other without end; {advice}, or try another tolerance",
    Status.FULL: "memory full: the contact remembers more reversals than there is room for; raise the dampers",
    Status.STIFF: "stiff: contact or dampers are too stiff for the exact way on this time scale; raise the mass",
}


def rest_state(slider: Slider, problem: Problem) -> np.ndarray:
    """Return the scaled state (z_s, z_s', v, x) of a slider at rest whose contacts are deformed by the load alone."""
    x = math.copysign(1.0, problem.load) * slider.rest_deformations(problem.contacts) / problem.length
    return np.array([-slider.rest_approach(problem.contacts) / problem.length, 0.0, 0.0, *x])


@lru_cache(maxsize=64)
def _whole_cycles(number, mobile, truncation, limit, contacts, close, warm):
    """Return the task of whole cycles without samples; a kernel knows the addresses of one that it was given before."""
    nothing = np.empty((0, contacts, len(SampleColumn)))
    return event_driven.Task(
        start=0.0, stop=2.0 * math.pi, number=number, mobile=mobile, tolerance=truncation, limit=limit,
        at=nothing[:, 0, 0], samples=nothing, stride=0, record=np.empty((0, len(Recorded))),
        close=close, warm=warm,
    )  # fmt: skip


class Beginning(NamedTuple):
    """Where the energies of a motion are counted from."""

    slider: np.ndarray  # (3,): z_s, z_s' and v
    lost: np.ndarray  # (3,): what rounding has cut off from them
    stored: float  # energy of the springs


class Motion:
    """State of a slider on a wave, moved along by segments between events.

    Attributes
    ----------
    problem : Problem
        Slider and wave, scaled.
    grid : Collocation
        Nodes of a segment.
    truncation : float
        Largest truncation error allowed in a segment (`segment.roughness`): of the impulse of a contact's normal force,
        over that of the preload in one radian of phase, and of its tangential force, over that of full friction.
    state : ndarray, shape (3 + contacts,)
        Slider position z_s, its rate z_s', slider velocity v, and the deformation of each contact.
    lost : ndarray, shape (3,)
        What rounding has cut off from the first three (`segment.advance_slider`).
    sign : ndarray, shape (contacts,)
        Sign of the deformation or of the slip.
    regime : ndarray of int, shape (contacts,)
        One of `codes.Regime`.
    tally : ndarray of int, shape (event_driven.TALLY,)
        Number of events of each kind (`codes.Event`) and measures of the work (`codes.WorkCount`).
    sums : ndarray, shape (len(EnergySum),)
        Integrals over the motion since `begin` (`energy.EnergySum`).
    memory : law.hysteretic.Memory or None
        Memory of the contacts; None for a law without one.
    begun : Beginning or None
        The state at the last `begin`; None before it.
    close : float
        Change of the scaled motion, in a segment known from the last cycle, that may be left out.
    """

    close = 0.0

    def __init__(self, problem: Problem, *, grid: Collocation, truncation: float):
        contacts = problem.contacts
        self.problem, self.grid, self.truncation = problem, grid, truncation
        tally, sums = np.zeros(event_driven.TALLY, np.int64), np.zeros(len(EnergySum))
        self.carry(np.zeros(3 + contacts), np.zeros(3), np.ones(contacts), np.zeros(contacts, np.int64), tally, sums)
        if problem.normal.hold is not None:
            self.regime[:] = Regime.STICK  # where both are possible, a contact without a history is closed
        remembers = problem.law.guard is hysteretic.guard  # the only law with a memory
        self.begun: Beginning | None = None
        self.memory = hysteretic.blank(contacts, grid) if remembers else None

    def carry(self, state, lost, sign, regime, tally, sums):
        """Make these arrays, all scaled, the state; the kernels change them in place."""
        self.state, self.lost, self.sign, self.regime, self.tally, self.sums = state, lost, sign, regime, tally, sums
        # for the kernels: the same arrays, not copies, as one tuple
        self.carried = segment.SegmentState(state[:3], lost, state[3:], sign, regime, tally, sums)

    def set_state(self, height, normal_velocity, speed, deformations=0.0, problem=None):
        """Set the state at phase 0: slider position and its rate, slider velocity, deformations; all scaled.

        With the hysteretic law the force depends on the path to this state: it is a straight line in approach and
        deformation from the present state of each contact. `problem` is that of the motion from here on, in the same
        units; None keeps it.
        """
        before = None if self.memory is None else self.approaches(self.state[At.POSITION])
        self.problem = problem or self.problem
        self.lost[:] = 0.0
        if self.memory is not None:
            self._displace(before, height, normal_velocity, speed, deformations)
            return
        self.state[:3] = height, normal_velocity, speed
        self.state[3:] = deformations
        open_regimes(self.problem, 0.0, self.carried)

    def copy(self) -> "Motion":
        """Return an independent motion in the same state."""
        other = copy.copy(self)
        other.carry(*(each.copy() for each in (self.state, self.lost, self.sign, self.regime, self.tally, self.sums)))
        if self.memory is not None:
            other.memory = hysteretic.copy(self.memory)
        return other

    def begin(self):
        """Set tally and sums to zero, and count the energies from this state on."""
        self.tally[:], self.sums[:] = 0, 0.0
        self.count_energies()

    def count_energies(self):
        """Count the increases of the energies from this state on, which must be at phase 0."""
        self.begun = Beginning(self.state[: At.DEFORMATIONS].copy(), self.lost.copy(), float(self.energy()[0]))

    def increases(self) -> np.ndarray:
        """Return how much the energies of `energy` have increased since `begin`, from the change of the state.

        A difference of two kinetic energies would be rounding: a heavy slider has 1e7 times the work of a cycle.
        """
        begun, now = self.begun, self.state[: At.DEFORMATIONS]
        if begun is None:
            raise ValueError("the energies of a motion are counted from its `begin` on")
        change, mean = now - begun.slider + (self.lost - begun.lost), 0.5 * (now + begun.slider)
        position, normal, along = change
        kinetic = mean[At.NORMAL_VELOCITY] * normal + mean[At.VELOCITY] * along
        return np.array([self.energy()[0] - begun.stored, self.problem.preload * position, kinetic])

    def turn(self, number: int, *, mobile: bool = True, stride: int = 0, warm: bool = False) -> np.ndarray:
        """Move through `number` whole cycles; return a sample (`Recorded`) every `stride` cycles, none for 0.

        `warm`: True if the motion computed last is a cycle of this one from almost the same state: its segments
        are then the first guess (`warm_start`).
        """
        limit = self._limit(2.0 * math.pi)
        task = _whole_cycles(number, mobile, self.truncation, limit, self.regime.size, self.close, int(warm))
        if stride:
            task = task._replace(stride=stride, record=np.empty((number // stride, len(Recorded))))
        self._travel(task)
        return task.record

    def move(self, start: float, stop: float, at: np.ndarray) -> np.ndarray:
        """Move from one phase to another; return samples (k, contacts, len(`SampleColumn`)) at the k phases `at`."""
        samples = np.zeros((at.size, self.regime.size, len(SampleColumn)))
        cycles = self.tally[WorkCount.CYCLES]
        self._travel(event_driven.Task(
            start=start, stop=stop, number=1, mobile=True, tolerance=self.truncation, limit=self._limit(stop - start),
            at=at, samples=samples, stride=0, record=np.empty((0, len(Recorded))),
        ))  # fmt: skip
        self.tally[WorkCount.CYCLES] = cycles  # a part of a cycle does not count as one
        return samples

    def mean_height(self, cycles: int) -> float:
        """Return minus the mean of z_s over so many cycles since `begin`."""
        return -float(self.sums[EnergySum.HEIGHT]) / (2.0 * math.pi * cycles)

    def _travel(self, task):
        if self.memory is not None:  # the velocities may have been set anew since the last run
            self.memory.growing[:] = 0
        many = self.memory is None and self.regime.size >= MANY and self.problem.normal.hold is None
        work = event_driven.work_arrays(self.regime.size, self.grid.sigma.size, many)
        why = event_driven.travel(self.problem, self.grid, self.carried, work, task, self.memory, work.span)
        if why != Status.DONE:
            raise self._failure(why)

    def _failure(self, why: Status) -> ConvergenceError:
        # the hysteretic law knows no stick band
        advice = "set stick_band > 0" if self.memory is None else "raise normal_damping or contact_damping"
        return ConvergenceError(*FAILURES[why].format(advice=advice).split(": ", 1))

    def events(self) -> dict:
        """Return the numbers of events by kind and the measures of the work since `begin`, by name.

        `stretches`: segments; `halvings`: rejected attempts at a segment; `sweeps`: Picard iterations; `chatter`: True
        if there was more than one event per contact at one instant; `smallest_gap`: shortest time between two events
        in s, inf if there were fewer than two.
        """
        kinds = [event.name.lower() for event in list(Event)[:6]]
        # in the order of the tally
        names = *kinds, "stretches", "halvings", "sweeps", "cycles", "chatter", "wipe_out"
        counted = {name: int(number) for name, number in zip(names, self.tally, strict=True)}
        crowding = float(self.sums[EnergySum.CROWDING])
        gap = 1.0 / (crowding * self.problem.omega) if crowding > 0.0 else math.inf
        return counted | {"chatter": bool(counted["chatter"]), "smallest_gap": gap}

    def energy(self) -> np.ndarray:
        """Return the energy of the contacts' springs, of the preload and of the slider, in units m (omega ell)^2.

        The state must be at phase 0, because the approaches are computed with the surface's height there.
        """
        problem, state = self.problem, self.carried
        height, normal_velocity, speed = state.slider
        approaches = self.approaches(height)
        hold = problem.normal.hold
        if hold is None:
            work = potential(approaches, problem.normal, hold)
        else:
            closed = np.where(self.regime != Regime.SEPARATED, approaches, math.nan)
            work = np.array([0.0 if math.isnan(z) else holding.stored(holding.depth(z, hold), hold) for z in closed])
        stored = problem.stiffness * np.sum(problem.factors.stiffness * work)
        if self.memory is None:
            stored += spring_energy(problem, state, approaches)
        else:
            for i, (z, x) in enumerate(zip(approaches, state.deformation, strict=True)):
                contact = contact_parameters(problem, i)
                stored += hysteretic.chain_energy(contact, self.memory, i, self.regime[i], self.sign[i], z, x)
        return np.array([stored, problem.preload * height, 0.5 * (normal_velocity**2 + speed**2)])

    def approaches(self, height):
        """Return the approach of every contact at phase 0, where the surface is as at the end of a cycle."""
        every = np.arange(self.problem.contacts)
        return approach(self.problem.paths, every, self.problem.paths.normal_cos, Coordinates(height, 0.0))

    def _displace(self, before, height, normal_velocity, speed, deformations):
        """Do what `set_state` does for the hysteretic law; `before`: the approaches up to now."""
        state, after = self.carried, self.approaches(height)
        target = np.broadcast_to(np.asarray(deformations, float), self.regime.shape)
        for i in range(self.regime.size):
            # a memory is known at the end of a run, where the surface is as at phase 0
            old = Point(before[i], state.deformation[i], 0.0, 0.0)
            new = Point(after[i], target[i], 0.0, 0.0)
            if old == new and self.regime[i] != Regime.SEPARATED:
                continue
            self.regime[i], self.sign[i], state.deformation[i] = hysteretic.jump(
                self.memory, i, self.regime[i], self.sign[i], old, new, contact_parameters(self.problem, i)
            )
        state.slider[:] = height, normal_velocity, speed

    @property
    def sticks(self) -> bool:
        """Whether some contact sticks, all others are apart, and nothing else has happened since `begin`."""
        moved = Event.CONTACT, Event.RELEASE, Event.STICK_TO_SLIP, Event.SLIP_TO_STICK
        rest = (self.regime == Regime.STICK) | (self.regime == Regime.SEPARATED)
        return bool(np.all(rest) and np.any(self.regime)) and not np.any(self.tally[list(moved)])

    def _limit(self, span):
        """Return the largest number of attempts at a segment in a run; more mean that events follow without end."""
        events = 500.0 * self.regime.size * (1.0 + span / (2.0 * math.pi))
        return int(min(events + 40.0 * span / self.problem.longest, 1e9))
