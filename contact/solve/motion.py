"""A run of the event-exact motion: the state it carries, and the arrays that the compiled kernel wants.

The only class here that changes: it guards the state of one slider on one wave, in the wave's own units.
"""

import copy
import math

import numpy as np

from contact.convergence import ConvergenceError
from contact.law import elastic, hysteretic, normal
from contact.problem import HYSTERETIC, Problem
from contact.solve import energy, event_driven, events, segment, warm_start
from contact.solve.collocation import Collocation

_SENTENCES = {
    event_driven.NOT_FINITE: ("not finite", "the motion overflowed; check mass, dampers and amplitude"),
    event_driven.TOO_MANY: (
        "too many events",
        "events follow each other without end; {advice}, or try another tolerance",
    ),
    event_driven.FULL: (
        "memory full",
        "the contact remembers more reversals than there is room for; raise the dampers",
    ),
    event_driven.STIFF: (
        "stiff",
        "contact or dampers are too stiff for the exact way on this time scale; raise the mass",
    ),
}


class Motion:
    """State of a slider on a wave, moved along by stretches between events.

    Parameters
    ----------
    problem : Problem
        The dimensionless problem.
    table : Collocation
        Points and matrices of a stretch.
    truncation : float
        Allowed per stretch, relative to the friction and preload impulse of a radian.
    """

    def __init__(self, problem: Problem, *, table: Collocation, truncation: float):
        contacts = problem.contacts
        self.problem, self.table, self.truncation = problem, table, truncation
        self.state = np.zeros(3 + contacts)
        self.regime, self.sign = np.zeros(contacts, np.int64), np.ones(contacts)
        self.tally, self.sums = np.zeros(event_driven.TALLY, np.int64), np.zeros(energy.SUMS)
        remembers = problem.law == HYSTERETIC and problem.limit_slope > 0.0
        # energies at the start of what the sums cover, where someone noted them
        self.begun = None
        self.memory = hysteretic.blank(contacts, table.sigma.size) if remembers else None

    def place(self, height, climb, speed, deformations=0.0):
        """Set the state at phase 0: slider position and its rate, slider velocity, deformations; all scaled.

        With the hysteretic law contacts that have a memory are taken there from where they are, on a straight line in
        approach and deformation.
        """
        if self.memory is not None:
            self._displace(height, climb, speed, deformations)
            return
        self.state[:3] = height, climb, speed
        self.state[3:] = deformations
        events.open_regimes(
            self.problem, 0.0, self.state, self.regime, self.sign
        )  # fmt: skip

    def copy(self) -> "Motion":
        """Return an independent motion in the same state."""
        twin = copy.copy(self)
        for name in ("state", "regime", "sign", "tally", "sums"):
            setattr(twin, name, getattr(self, name).copy())
        if self.memory is not None:
            twin.memory = hysteretic.copy(self.memory)
        return twin

    def turn(self, number: int, *, mobile: bool = True, stride: int = 0) -> np.ndarray:
        """Move through `number` whole cycles; return rows (v, z_s, mean v) every `stride` cycles."""
        rows = np.empty((number // stride if stride else 0, 3))
        nothing = np.empty((0, self.regime.size, 6))
        self._travel(0.0, 2.0 * np.pi, number, mobile, nothing[:, 0, 0], nothing, stride, rows)
        return rows

    def move(self, start: float, stop: float, at: np.ndarray) -> np.ndarray:
        """Move from one phase to another; return (k, contacts, 6) samples z, x, P, Q, regime, v at the phases `at`."""
        samples, cycles = np.zeros((at.size, self.regime.size, 6)), self.tally[event_driven.CYCLES]
        self._travel(start, stop, 1, True, at, samples, 0, np.empty((0, 3)))
        self.tally[event_driven.CYCLES] = cycles
        return samples

    def _travel(self, start, stop, number, mobile, at, samples, stride, rows):
        table, contacts = self.table, self.regime.size
        n = table.sigma.size
        shared, own = np.zeros((segment.ROWS, n)), np.zeros((segment.PLANES, contacts, n))
        why = event_driven.travel(
            self.problem, table.sigma, table.bary, table.tau, table.columns, table.rates,
            table.tail, self.state, self.regime, self.sign, start, stop, number, mobile, self.truncation, self.tally,
            self.sums, at, samples, stride, rows, self._limit(stop - start), self.memory,
            *warm_start.blank(contacts, n), shared, own, np.empty(n),
        )  # fmt: skip
        if why != event_driven.DONE:
            self.fail(why)

    def fail(self, why):
        """Raise the error that belongs to the reason for which a run ended."""
        status, sentence = _SENTENCES[why]
        # the hysteretic law knows no stick band
        advice = "set stick_band > 0" if self.memory is None else "raise normal_damping or contact_damping"
        raise ConvergenceError(status, sentence.format(advice=advice))

    def events(self) -> dict[str, int]:
        """Return the number of events by kind, and of stretches, halvings and sweeps."""
        names = (*elastic.NAMES, "stretches", "halvings", "sweeps", "cycles", "chatter", "wipe_out")
        return {name: int(number) for name, number in zip(names, self.tally, strict=True)}

    def energy(self) -> np.ndarray:
        """Return the energy of the contacts' springs, of the preload and of the slider, in units m (omega ell)^2.

        At phase 0: the surface's height there is what the approach is taken from.
        """
        problem = self.problem
        kappa, mu, c = problem.stiffness, problem.friction, problem.limit_slope
        height, climb, speed = self.state[:3]
        z = np.maximum(problem.paths.height + problem.paths.normal_cos - height, 0.0)
        stored = kappa * np.sum(normal.energy(z, problem.shape))
        if self.memory is None and c > 0.0:
            stick = np.maximum(z - np.abs(self.state[3:]) / c, 0.0)
            stored += mu * kappa * c * np.sum(elastic.friction_energy(z, stick, problem.shape))
        elif self.memory is not None:
            table = self.table
            for i in range(z.size):
                stored += mu * kappa * energy.chain_energy(
                    self.memory, i, self.regime[i], self.sign[i], z[i], self.state[3 + i], c, table.sigma, table.bary,
                    table.rates,
                )  # fmt: skip
        return np.array([stored, problem.preload * height, 0.5 * (climb**2 + speed**2)])

    def _displace(self, height, climb, speed, deformations):
        table, c = self.table, self.problem.limit_slope
        surface = self.problem.paths.height + self.problem.paths.normal_cos
        target = np.broadcast_to(np.asarray(deformations, float), self.regime.shape)
        for i in range(self.regime.size):
            # a memory is known at the end of a run, where the surface is as at phase 0
            old, new = surface[i] - self.state[0], surface[i] - height
            if old == new and target[i] == self.state[3 + i] and self.regime[i] != elastic.SEPARATED:
                continue
            self.regime[i], self.sign[i], self.state[3 + i] = hysteretic.jump(
                self.memory, i, self.regime[i], self.sign[i], old, self.state[3 + i], new, target[i], c, table.sigma,
                table.bary, table.rates,
            )  # fmt: skip
        self.state[:3] = height, climb, speed

    def smallest_gap(self) -> float:
        """Return the smallest time between two events since the sums were cleared, s; inf if there were not two."""
        crowding = self.sums[energy.CROWDING]
        return float(1.0 / (crowding * self.problem.omega)) if crowding > 0.0 else math.inf

    def _limit(self, span):
        """Return the stretches that a run may take: a guard that fires for ever must fail, not hang."""
        events = 500.0 * self.regime.size * (1.0 + span / (2.0 * math.pi))
        return int(min(events + 40.0 * span / self.problem.longest, 1e9))
