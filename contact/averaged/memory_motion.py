"""Heavy slider on rough balls with the memory of Mindlin and Deresiewicz: mean approaches and velocity.

Errors on the ball of Feenstra and Breedveld with 3 nm, at waves of 1.5 to 8 nm (`tests/contact/test_memory_motion.py`,
`tests/contact/test_rough.py` and `tests/benchmarks/rough_table.py`):

- In the stated error: cells of depth, about 1e-4 of the velocity at a tolerance of 2.5e-4; rows of the table of P, 3e-5
  of the velocity with the first table, 2e-6 with the second, whose forces have 2e-5.
- Not in it: the 160 rings of a mean field, 2e-5 of the approach; the table of tails, 1e-6 of a pressure; the law
  against asperities that are coupled step by step, at most 4e-4 of the velocity, most of it from their steps.
"""

import numpy as np

from contact.averaged.asperity_stops import Balanced
from contact.averaged.memory_cycle import Heavy, memory_motion
from contact.law.force_table import ForceTable, joined
from contact.orbit import Orbit
from contact.slider import Slider

CELLS = 16  # of depth, of the first answer; 32 and extrapolation: 5e-5 of the velocity, `tests/contact/test_memory.py`
ERROR = 1.0 / 12.0  # of an extrapolated velocity over the change before it; `tests/contact/test_memory_motion.py`
FLAT = 1e-6  # of the tangential amplitude over c: a smaller normal one counts as this


class Memory:
    """Balls up to a deepest approach in m, with the memory of their whole contact."""

    def __init__(self, slider: Slider, balls, _lowest: float, deepest: float):
        self.slider, self.balls, self.deepest = slider, balls, deepest
        distinct = self._distinct = list(dict.fromkeys(balls))
        self._which = np.array([distinct.index(each) for each in balls])
        self._tables: dict[int, ForceTable] = {}

    def solve(self, waves: tuple[Orbit, ...], doubling: int, near: Balanced | None = None, /) -> Balanced:
        """Return the steady motion with so many doublings of cells and rows; the search starts from another one."""
        slider = self.slider
        heavy = Heavy(
            slider.friction_coefficient, slider.limit_slope, slider.load, slider.tangential_damping,
            slider.preload / len(waves), waves[0].omega,
        )  # fmt: skip
        motions = np.empty((len(waves), 3))
        for motion, wave in zip(motions, waves, strict=True):
            size = abs(wave.normal)
            along = wave.tangential * (wave.normal.conjugate() / size if size > 0.0 else 1.0)
            motion[:] = max(size, FLAT * abs(along) / slider.limit_slope), along.real, along.imag
        heights, found = np.empty(len(waves)), np.array([near.velocity, near.rate] if near else [0.0, 0.0])
        if np.any(motions[:, 0] > 0.0):
            memory_motion(self._at(doubling), self._which, motions, heavy, CELLS * 2**doubling, heights, found)
            if not any(wave.normal for wave in waves):
                found[0] = 0.0  # a friction limit that stays as it is holds as much forwards as backwards
        return Balanced(float(found[0]), tuple(map(float, heights)), float(found[1]))

    @property
    def said(self) -> str:
        """As in `TangentialModel`."""
        return "cycle means with the memory of Mindlin and Deresiewicz in the force of the rough balls"

    def refined(self, before: float, last: float) -> tuple[float, float]:
        """Return velocity and error from those of a number of cells and twice as many, which err by their square."""
        if min(abs(before), abs(last)) == 0.0:
            return last, abs(last - before)
        return last + (last - before) / 3.0, ERROR * abs(last - before)

    def _at(self, doubling: int) -> ForceTable:
        if doubling not in self._tables:
            self._tables[doubling] = joined([each.force_table(self.deepest, doubling) for each in self._distinct])
        return self._tables[doubling]
