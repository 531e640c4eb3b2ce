"""A run of the event-exact motion: the state it carries, and the arrays that the compiled kernel wants.

The only class here that changes: it guards the state of one slider on one wave, in the wave's own units.
"""

import copy

import numpy as np

from contact import integrate, regimes
from contact.collocation import Collocation
from contact.convergence import ConvergenceError
from contact.scaling import Scaled

_SENTENCES = {
    integrate.NOT_FINITE: ("not finite", "the motion overflowed; check mass, dampers and amplitude"),
    integrate.TOO_MANY: (
        "too many events",
        "events follow each other without end; try stick_band > 0 or another tolerance",
    ),
    integrate.STIFF: (
        "stiff",
        "contact or dampers are too stiff for the exact way on this time scale; raise the mass",
    ),
}


class Motion:
    """State of a slider on a wave, moved along by stretches between events.

    Parameters
    ----------
    problem : Scaled
        The dimensionless problem.
    table : Collocation
        Points and matrices of a stretch.
    truncation : float
        Allowed per stretch, relative to the friction and preload impulse of a radian.
    """

    def __init__(self, problem: Scaled, *, table: Collocation, truncation: float):
        contacts = len(problem.waves)
        self.problem, self.table, self.truncation = problem, table, truncation
        self.state = np.zeros(3 + contacts)
        self.regime, self.sign = np.zeros(contacts, np.int64), np.ones(contacts)
        self.tally, self.sums = np.zeros(integrate.TALLY, np.int64), np.zeros(3)

    def place(self, height, climb, speed, deformations=0.0):
        """Set the state at phase 0: slider position and its rate, slider velocity, deformations; all scaled."""
        self.state[:3] = height, climb, speed
        self.state[3:] = deformations
        integrate.open_regimes(
            self.problem.parameters, self.problem.waves, 0.0, self.state, self.regime, self.sign
        )  # fmt: skip

    def copy(self) -> "Motion":
        """Return an independent motion in the same state."""
        twin = copy.copy(self)
        for name in ("state", "regime", "sign", "tally", "sums"):
            setattr(twin, name, getattr(self, name).copy())
        return twin

    def turn(self, number: int, *, mobile: bool = True, stride: int = 0) -> np.ndarray:
        """Move through `number` whole cycles; return rows (v, z_s, mean v) every `stride` cycles."""
        rows = np.empty((number // stride if stride else 0, 3))
        why = integrate.cycles(
            self.problem.parameters, self.problem.waves, *self._matrices(), self.state, self.regime, self.sign,
            number, mobile, self.truncation, self.tally, self.sums, stride, rows, 100_000,
        )  # fmt: skip
        self._refuse(why)
        return rows

    def move(self, start: float, stop: float, at: np.ndarray) -> np.ndarray:
        """Move from one phase to another; return (k, contacts, 6) samples z, x, P, Q, regime, v at the phases `at`."""
        samples = np.zeros((at.size, self.regime.size, 6))
        why = integrate.advance(
            self.problem.parameters, self.problem.waves, *self._matrices(), self.state, self.regime, self.sign,
            start, stop, True, self.truncation, self.tally, self.sums, at, samples, 10_000_000,
        )  # fmt: skip
        self._refuse(why)
        return samples

    def events(self) -> dict[str, int]:
        """Return the number of events by kind, and of stretches, halvings and sweeps."""
        names = (*regimes.NAMES, "stretches", "halvings", "sweeps", "cycles")
        return {name: int(number) for name, number in zip(names, self.tally, strict=True)}

    def _matrices(self):
        table = self.table
        return table.sigma, table.bary, table.tau, table.once, table.twice, table.rates, table.tail

    def _refuse(self, why):
        if why != integrate.DONE:
            raise ConvergenceError(*_SENTENCES[why])
