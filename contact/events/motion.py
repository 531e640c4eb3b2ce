"""The event-driven motion of one slider on one wave: its state, and runs that change it.

All quantities are in the units of `contact.problem`.
"""

import copy
import math

import numpy as np

from contact.body import Coordinates, Point, approach, approach_rate, travel
from contact.codes import Count, Event, Regime, Status
from contact.events import event_driven, segment
from contact.events.collocation import Collocation
from contact.events.energy import Sum
from contact.events.segment import At, Column, Sample
from contact.events.transitions import open_regimes
from contact.exceptions import ConvergenceError
from contact.law import elastic, hysteretic, normal
from contact.problem import Problem
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


class Motion:
    """State of a slider on a wave, moved along by segments between events.

    `state` (3 + contacts,) holds z_s, z_s', v and the deformations. `truncation` is that allowed per segment, relative
    to the friction and preload impulse of a radian.
    """

    def __init__(self, problem: Problem, *, grid: Collocation, truncation: float):
        contacts = problem.contacts
        self.problem, self.grid, self.truncation = problem, grid, truncation
        tally, sums = np.zeros(event_driven.TALLY, np.int64), np.zeros(len(Sum))
        self.carry(np.zeros(3 + contacts), np.ones(contacts), np.zeros(contacts, np.int64), tally, sums)
        remembers = problem.law.guard is hysteretic.guard
        self.begun = None  # energies at the start of what the sums cover, set by `begin`
        self.memory = hysteretic.blank(contacts, grid) if remembers else None

    def carry(self, state, sign, regime, tally, sums):
        """Take these arrays, which the kernels change, as the motion's own; all scaled."""
        self.state, self.sign, self.regime, self.tally, self.sums = state, sign, regime, tally, sums
        # what the kernels take: the arrays themselves
        self.carried = segment.State(state[:3], state[3:], sign, regime, tally, sums)

    def set_state(self, height, normal_velocity, speed, deformations=0.0, problem=None):
        """Set the state at phase 0: slider position and its rate, slider velocity, deformations; all scaled.

        With the hysteretic law contacts that have a memory are taken there from where they are, on a straight line in
        approach and deformation. `problem` is that of the motion from here on, in the same units; None keeps it.
        """
        before = self._approaches(self.state[At.POSITION])
        self.problem = problem or self.problem
        if self.memory is not None:
            self._displace(before, height, normal_velocity, speed, deformations)
            return
        self.state[:3] = height, normal_velocity, speed
        self.state[3:] = deformations
        open_regimes(self.problem, 0.0, self.carried)

    def copy(self) -> "Motion":
        """Return an independent motion in the same state."""
        other = copy.copy(self)
        other.carry(*(each.copy() for each in (self.state, self.sign, self.regime, self.tally, self.sums)))
        if self.memory is not None:
            other.memory = hysteretic.copy(self.memory)
        return other

    def begin(self):
        """Set what has been counted and summed to zero, and note the energies at this start."""
        self.tally[:], self.sums[:], self.begun = 0, 0.0, self.energy()

    def turn(self, number: int, *, mobile: bool = True, stride: int = 0) -> np.ndarray:
        """Move through `number` whole cycles; return a sample (`Column`) every `stride` cycles, none for 0."""
        record = np.empty((number // stride if stride else 0, len(Column)))
        nothing = np.empty((0, self.regime.size, len(Sample)))
        whole = 2.0 * np.pi
        self._travel(event_driven.Task(
            0.0, whole, number, mobile, self.truncation, self._limit(whole), nothing[:, 0, 0], nothing, stride, record
        ))  # fmt: skip
        return record

    def move(self, start: float, stop: float, at: np.ndarray) -> np.ndarray:
        """Move from one phase to another; return samples (k, contacts, len(`Sample`)) at the k phases `at`."""
        samples = np.zeros((at.size, self.regime.size, len(Sample)))
        cycles = self.tally[Count.CYCLES]
        limit, record = self._limit(stop - start), np.empty((0, len(Column)))
        self._travel(event_driven.Task(start, stop, 1, True, self.truncation, limit, at, samples, 0, record))
        self.tally[Count.CYCLES] = cycles
        return samples

    def _travel(self, task):
        work = event_driven.work_arrays(self.regime.size, self.grid.sigma.size)
        why = event_driven.travel(self.problem, self.grid, self.carried, work, task, self.memory)
        if why != Status.DONE:
            raise self._failure(why)

    def _failure(self, why: Status) -> ConvergenceError:
        # the hysteretic law knows no stick band
        advice = "set stick_band > 0" if self.memory is None else "raise normal_damping or contact_damping"
        return ConvergenceError(*FAILURES[why].format(advice=advice).split(": ", 1))

    def events(self) -> dict:
        """Return the number of events by kind, whether they crowd, their smallest gap in s, and the work.

        The gap is inf where there were not two events.
        """
        kinds = [event.name.lower() for event in list(Event)[:6]]
        names = *kinds, "stretches", "halvings", "sweeps", "cycles", "chatter", "wipe_out"
        counted = {name: int(number) for name, number in zip(names, self.tally, strict=True)}
        crowding = float(self.sums[Sum.CROWDING])
        gap = 1.0 / (crowding * self.problem.omega) if crowding > 0.0 else math.inf
        return counted | {"chatter": bool(counted["chatter"]), "smallest_gap": gap}

    def energy(self) -> np.ndarray:
        """Return the energy of the contacts' springs, of the preload and of the slider, in units m (omega ell)^2.

        At phase 0: the surface's height there is what the approach is taken from.
        """
        problem, state = self.problem, self.carried
        height, normal_velocity, speed = state.slider
        rate, paths = Coordinates(normal_velocity, speed), problem.paths
        approaches = self._approaches(height)
        stored = problem.stiffness * np.sum(normal.energy(approaches, problem.shape))
        for i, (z, x) in enumerate(zip(approaches, state.deformation, strict=True)):
            regime, sign = self.regime[i], self.sign[i]
            if self.memory is None:
                z_rate = approach_rate(paths.normal_sin[i], rate)
                x_rate = travel(paths.tangential_sin[i], rate)
                stored += elastic.spring(problem, regime, sign, Point(z, x, z_rate, x_rate))[2]
            else:
                stored += hysteretic.chain_energy(problem, self.memory, i, regime, sign, z, x)
        return np.array([stored, problem.preload * height, 0.5 * (normal_velocity**2 + speed**2)])

    def _approaches(self, height):
        """Return the approach of every contact at phase 0, where the surface is as at the end of a cycle."""
        every = np.arange(self.problem.contacts)
        return approach(self.problem.paths, every, self.problem.paths.normal_cos, Coordinates(height, 0.0))

    def _displace(self, before, height, normal_velocity, speed, deformations):
        c, state, after = self.problem.limit_slope, self.carried, self._approaches(height)
        target = np.broadcast_to(np.asarray(deformations, float), self.regime.shape)
        for i in range(self.regime.size):
            # a memory is known at the end of a run, where the surface is as at phase 0
            old = Point(before[i], state.deformation[i], 0.0, 0.0)
            new = Point(after[i], target[i], 0.0, 0.0)
            if old == new and self.regime[i] != Regime.SEPARATED:
                continue
            self.regime[i], self.sign[i], state.deformation[i] = hysteretic.jump(
                self.memory, i, self.regime[i], self.sign[i], old, new, c
            )
        state.slider[:] = height, normal_velocity, speed

    @property
    def sticks(self) -> bool:
        """Whether some contact sticks, all others are apart, and nothing else has happened since `begin`."""
        moved = Event.CONTACT, Event.RELEASE, Event.STICK_TO_SLIP, Event.SLIP_TO_STICK
        rest = (self.regime == Regime.STICK) | (self.regime == Regime.SEPARATED)
        return bool(np.all(rest) and np.any(self.regime)) and not np.any(self.tally[list(moved)])

    def _limit(self, span):
        """Return the largest number of segments of a run, after which it fails: a guard may fire without end."""
        events = 500.0 * self.regime.size * (1.0 + span / (2.0 * math.pi))
        return int(min(events + 40.0 * span / self.problem.longest, 1e9))
