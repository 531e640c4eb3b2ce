"""Heavy slider on rough balls with the memory of Mindlin and Deresiewicz: mean approaches and velocity.

Errors on the ball of Feenstra and Breedveld with 3 nm, at waves of 1.5 to 8 nm (`tests/contact/test_memory_motion.py`,
`tests/contact/test_rough.py` and `tests/benchmarks/rough_table.py`):

- In the stated error: cells of depth, about 1e-4 of the velocity at a tolerance of 2.5e-4; rows of the table of P, 3e-5
  of the velocity with the first table, 2e-6 with the second, whose forces have 2e-5.
- Not in it: the 160 rings of a mean field, 2e-5 of the approach; the table of tails, 1e-6 of a pressure; the law
  against asperities that are coupled step by step, at most 4e-4 of the velocity, most of it from their steps.
"""

import numpy as np

from contact.averaged.asperity_stops import Balanced, Powers, heavy_slider, motion_of
from contact.averaged.memory_cycle import Heavy, memory_motion, memory_powers
from contact.law.force_table import ForceTable, joined
from contact.orbit import Orbit
from contact.slider import Slider

CELLS = 16  # of depth, of the first answer; 32 and extrapolation: 5e-5 of the velocity, `tests/contact/test_memory.py`
ERROR = 1.0 / 12.0  # of an extrapolated velocity over the change before it; `tests/contact/test_memory_motion.py`


class Memory:
    """Balls up to a deepest approach in m, with the memory of their whole contact."""

    def __init__(self, slider: Slider, balls, _lowest: float, deepest: float):
        self.slider, self.balls, self.deepest = slider, balls, deepest
        distinct = self._distinct = list(dict.fromkeys(balls))
        self._which = np.array([distinct.index(each) for each in balls])
        self._tables: dict[int, ForceTable] = {}
        self._heavy: dict[float, Heavy] = {}

    def solve(self, waves: tuple[Orbit, ...], doubling: int) -> Balanced:
        """Return the steady motion with so many doublings of cells and rows."""
        return self._solve(waves, doubling, doubling, None)[1]

    def solve_two(self, waves: tuple[Orbit, ...], doubling: int, near: Balanced | None) -> tuple[float, Balanced]:
        """As in `TangentialModel`: every second depth of the finer cells is one of the coarser ones."""
        return self._solve(waves, doubling - 1, doubling, near)

    def _solve(self, waves, coarse: int, fine: int, near: Balanced | None) -> tuple[float, Balanced]:
        rows = [motion_of(self.slider, each) for each in waves]
        motions, heights = np.array(rows), np.empty((2, len(waves)))
        found = np.array([near.velocity, 0.0, near.rate, 0.0] if near else [0.0] * 4)
        if any(row[0] > 0.0 for row in rows):
            numbers = self._at(coarse), self._at(fine), self._which, motions, self._numbers(waves)
            memory_motion(*numbers, CELLS * 2**fine, heights, found)
            if not any(wave.normal for wave in waves):
                found[:2] = 0.0  # a friction limit that stays as it is holds as much forwards as backwards
        velocity, before, rate, load = found.tolist()
        return before, Balanced(velocity, tuple(heights[1].tolist()), rate, load)

    def powers(self, waves: tuple[Orbit, ...], doubling: int, solved: Balanced, /) -> Powers:
        """Return the powers of a motion that `solve_two` has found with as many doublings, and that is not at rest."""
        motions = np.array([motion_of(self.slider, each) for each in waves])
        found, heights = np.array([solved.velocity, 0.0, 0.0]), np.array([solved.heights] * 2)
        numbers = self._at(doubling), self._which, motions, self._numbers(waves)._replace(load=solved.load)
        memory_powers(*numbers, CELLS * 2**doubling, heights, found)
        return Powers(*map(float, found))

    @property
    def said(self) -> str:
        """As in `TangentialModel`."""
        return "cycle means with the memory of Mindlin and Deresiewicz in the force of the rough balls"

    def refined(self, before: float, last: float) -> tuple[float, float]:
        """Return velocity and error from those of a number of cells and twice as many, which err by their square."""
        if min(abs(before), abs(last)) == 0.0:
            return last, abs(last - before)
        return last + (last - before) / 3.0, ERROR * abs(last - before)

    def forces(self, doubling: int) -> tuple[ForceTable, np.ndarray]:
        """Return the forces of the distinct balls, with so many doublings of their rows, and the row of each ball."""
        return self._at(doubling), self._which

    def _numbers(self, waves: tuple[Orbit, ...]) -> Heavy:
        """Return the numbers of the slider and its waves, one object for each frequency: kernels know it again."""
        omega = waves[0].omega
        if omega not in self._heavy:
            self._heavy[omega] = heavy_slider(self.slider, waves)
        return self._heavy[omega]

    def _at(self, doubling: int) -> ForceTable:
        if doubling not in self._tables:
            self._tables[doubling] = joined([each.force_table(self.deepest, doubling) for each in self._distinct])
        return self._tables[doubling]
