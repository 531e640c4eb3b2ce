"""Heavy slider on rough balls each of whose asperities slips on its own: mean approaches and velocity.

The approaches u_j of the asperities of a ball are tabulated over the ball's approach, and each asperity has its own
stop (`asperity_cycle`). A mean field with the elastic law has one stop, of the force of the whole ball.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from contact.averaged.asperity_cycle import Table, asperity_powers, stops_motion
from contact.averaged.two_levels import Heavy
from contact.law.asperities import Rows
from contact.law.force_table import ForceTable, joined
from contact.orbit import Orbit
from contact.slider import Slider

PANELS = 8  # of Gauss's rule in a cycle, of a first table
CLOSE = 1e-6  # of a velocity: step of its search for a balance of powers, squared
FLAT = 1e-6  # of the tangential amplitude over c: a smaller normal one counts as this
EVEN = 1e-13  # force over the friction of a ball that ends the search for the velocity of a balance of powers
SEEN, BISECTIONS = 64, 50  # places within a row, and steps between two, of the search for where an asperity touches


class Balanced(NamedTuple):
    """Steady motion of a slider whose mean forces vanish."""

    velocity: float  # m/s
    heights: tuple[float, ...]  # mean approach of each ball, m
    rate: float = 0.0  # of the force that is left over the speed, N s/m; 0: unknown
    load: float = 0.0  # against the motion, N; negative where it drives the slider


class Powers(NamedTuple):
    """Mean powers of a steady motion of all balls, W; the normal force does no work over a cycle."""

    velocity: float  # m/s, at which no mean force is left to rounding
    work: float  # of the surface's motion along x through the tangential force
    slip: float  # lost
    leak: float = 0.0  # of a law that has no potential


class TangentialModel(Protocol):
    """Balls up to a deepest approach with a tangential law, as `RoughBalls` asks for their motion: `Stops`, `Memory`.

    A model is made from the slider, its balls, and the lowest and the deepest approach in m.
    """

    balls: Sequence[Any]
    deepest: float

    def solve(self, waves: tuple[Orbit, ...], doubling: int, /) -> Balanced:
        """Return the steady motion on the orbit of each ball, with so many doublings of the discretisation."""

    def solve_two(self, waves: tuple[Orbit, ...], doubling: int, near: Balanced | None, /) -> tuple[float, Balanced]:
        """Return the velocity with one doubling less, in m/s, and the motion with so many doublings, at least 1.

        ``near``: the motion with one doubling less, where it is known.
        """

    def powers(self, waves: tuple[Orbit, ...], doubling: int, solved: Balanced, /) -> Powers:
        """Return the powers of a motion that `solve_two` has found with as many doublings, and that is not at rest."""

    @property
    def said(self) -> str:
        """What the answers are, for the reasons of an `Answer`."""

    def refined(self, before: float, last: float, /) -> tuple[float, float]:
        """Return velocity and its error, m/s, from those of a doubling and of the next, which is twice as fine."""


def heavy_slider(slider: Slider, waves: tuple[Orbit, ...]) -> Heavy:
    """Return the numbers of a slider that moves at one velocity, and of its waves."""
    return Heavy(
        slider.friction_coefficient, slider.limit_slope, slider.load, slider.tangential_damping,
        slider.preload / len(waves), waves[0].omega,
    )  # fmt: skip


def motion_of(slider: Slider, wave: Orbit) -> tuple[float, float, float]:
    """Return A, and the parts of u_x along u_z and a quarter of a cycle before it, m."""
    size = abs(wave.normal)
    along = wave.tangential * (wave.normal.conjugate() / size if size > 0.0 else 1.0)
    return max(size, FLAT * abs(along) / slider.limit_slope), along.real, along.imag


class Stops:
    """Balls up to a deepest approach in m, with a stop for each asperity."""

    def __init__(self, slider: Slider, balls, _lowest: float, deepest: float):
        self.slider, self.balls, self.deepest = slider, balls, deepest
        self._distinct = list(dict.fromkeys(balls))
        self._which = np.array([self._distinct.index(each) for each in balls])
        self._tables: dict[int, tuple[ForceTable, Table]] = {}

    def solve(self, waves: tuple[Orbit, ...], doubling: int, /) -> Balanced:
        """As in `TangentialModel`."""
        return self._solve(waves, doubling, doubling, None)[1]

    def solve_two(self, waves: tuple[Orbit, ...], doubling: int, near: Balanced | None, /) -> tuple[float, Balanced]:
        """As in `TangentialModel`."""
        return self._solve(waves, doubling - 1, doubling, near)

    def _solve(self, waves, coarse: int, fine: int, near: Balanced | None) -> tuple[float, Balanced]:
        rows = [motion_of(self.slider, each) for each in waves]
        motions, heights = np.array(rows), np.empty((2, len(waves)))
        found = np.array([near.velocity, 0.0, near.rate, 0.0] if near else [0.0] * 4)
        (coarse_force, coarse_table), (fine_force, fine_table) = self._at(coarse), self._at(fine)
        if any(row[0] > 0.0 for row in rows):
            stops_motion(
                coarse_force, fine_force, coarse_table, fine_table, self._which, motions,
                heavy_slider(self.slider, waves), PANELS * 2**fine, heights, np.empty(4), found,
            )  # fmt: skip
        velocity, before, rate, load = found.tolist()
        return before, Balanced(velocity, tuple(heights[1].tolist()), rate, load)

    def powers(self, waves: tuple[Orbit, ...], doubling: int, solved: Balanced, /) -> Powers:
        """As in `TangentialModel`; the integrals are exact between the events of each asperity.

        The velocity differs from that of the search by its quadrature; where that is all of it, the slider rests.
        """
        slider, heavy, sums = self.slider, heavy_slider(self.slider, waves), np.empty(4)
        table, way = self._at(doubling)[1], math.copysign(1.0, solved.velocity)
        motions, heights = np.array([motion_of(slider, each) for each in waves]), np.array(solved.heights)

        def left(v, cut):
            asperity_powers(table, motions, heavy, heights, way, v, cut, sums)
            return slider.friction_coefficient * float(sums[0]) - solved.load - slider.tangential_damping * v

        least = EVEN * slider.friction_coefficient * heavy.share
        speed = abs(solved.velocity)
        v, force = speed, left(speed, 0)
        step = math.sqrt(CLOSE) * v
        for cut in (0, 0, 1, 1, 1, 1):
            v, before = v + step, force
            force = left(v, cut)
            if force == before or (cut and abs(force) <= least):
                break
            step *= force / (before - force)
        if not 0.5 < v / speed < 2.0:
            return Powers(0.0, 0.0, 0.0)  # no velocity balances: it moves within the error of the search only
        return Powers(way * v, *(slider.friction_coefficient * sums[1:]).tolist())

    @property
    def said(self) -> str:
        """As in `TangentialModel`."""
        return f"cycle means of {self._at(0)[1].touch.size} asperities, a stop each"

    def refined(self, before: float, last: float) -> tuple[float, float]:
        """Return velocity and error from those of a number of rows and twice as many."""
        # about the square of a row where an asperity touches; a third of the change would be the error of a smooth mean
        return last, 0.5 * abs(last - before)

    def forces(self, doubling: int) -> tuple[ForceTable, np.ndarray]:
        """Return the forces of the distinct balls, with so many doublings of their rows, and the row of each ball."""
        return self._at(doubling)[0], self._which

    def table(self, doubling: int) -> Table:
        """Return the approaches of the asperities of all balls with so many doublings of their rows."""
        return self._at(doubling)[1]

    def _at(self, doubling: int) -> tuple[ForceTable, Table]:
        """Return the tables of forces and of approaches with so many doublings of their rows."""
        if doubling not in self._tables:
            forces = joined([each.force_table(self.deepest, doubling) for each in self._distinct])
            rows = {each: each.rows(self.deepest, doubling) for each in self._distinct}
            self._tables[doubling] = forces, _table([rows[each] for each in self.balls], self.balls)
        return self._tables[doubling]


def _table(rows: Sequence[Rows], balls) -> Table:
    """Return one table of all balls, of those asperities that touch anywhere in it."""
    most = max(each.approaches.shape[0] for each in rows)
    parts = []
    for number, (each, ball) in enumerate(zip(rows, balls, strict=True)):
        approaches, spacing = each.approaches, each.z[1] - each.z[0]
        rates = spacing * each.rates
        used = (approaches > 0.0).any(axis=0)
        approaches, rates = approaches[:, used], rates[:, used]
        fill = (0, most - approaches.shape[0]), (0, 0)
        parts.append((
            np.pad(approaches, fill), np.pad(rates, fill), _touch(each.z, approaches, rates), ball.stiffness[used],
            ball.merged[used], np.full(approaches.shape[1], number),
        ))  # fmt: skip
    first, second, *columns = zip(*parts, strict=True)
    touch, stiffness, merged, balls_of = (np.concatenate(each) for each in columns)
    return Table(
        np.ascontiguousarray(np.hstack(first)), np.ascontiguousarray(np.hstack(second)), touch, stiffness, merged,
        balls_of, np.array([each.z[0] for each in rows]), np.array([each.z[1] - each.z[0] for each in rows]),
        np.array([each.z.size for each in rows]),
    )  # fmt: skip


def _touch(z: np.ndarray, approaches: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Return the approach of the ball at which the cubic of each asperity begins to be positive, shape (n,)."""
    # below the first row at which an asperity touches, u_j is smooth between two rows
    row, column = np.maximum((approaches > 0.0).argmax(axis=0), 1) - 1, np.arange(approaches.shape[1])
    low, high, rise, fall = (each[k, column] for each in (approaches, rates) for k in (row, row + 1))
    cubic, square = 2.0 * (low - high) + rise + fall, 3.0 * (high - low) - 2.0 * rise - fall

    def approach(t):
        return low + t * (rise + t * (square + t * cubic))

    # the last of the places where it is not positive
    seen = np.linspace(0.0, 1.0, SEEN + 1)[:, None]
    last = SEEN - (approach(seen)[::-1] <= 0.0).argmax(axis=0)
    below, above = last / SEEN, np.minimum(last + 1, SEEN) / SEEN
    for _ in range(BISECTIONS):
        middle = 0.5 * (below + above)
        out = approach(middle) <= 0.0
        below, above = np.where(out, middle, below), np.where(out, above, middle)
    begins = low < 0.0  # otherwise it touches from its first row on
    return z[row] + (z[1] - z[0]) * np.where(begins, above, 0.0)
