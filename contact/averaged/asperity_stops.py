"""Heavy slider on rough balls each of whose asperities slips on its own: mean approaches and velocity, in steps.

The approaches u_j of the asperities of a ball are tabulated over the ball's approach, and each asperity has its own
stop (`asperity_cycle`). A mean field with the elastic law has one stop, of the force of the whole ball.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from contact.averaged.asperity_cycle import Table, asperity_powers, mean_normal, mean_pull
from contact.averaged.memory_cycle import Heavy
from contact.law.asperities import ROWS, solved
from contact.orbit import Orbit
from contact.roots import bracketed
from contact.slider import Slider

STEPS = 128  # of phase, of the first answer
REPEATS = 1e-9  # change of a deformation from one cycle to the next over the largest, at which it repeats
CLOSE = 1e-6  # of the velocity over its range
FLAT = 1e-6  # of the tangential amplitude over c: a smaller normal one counts as this
EVEN = 1e-13  # force over the friction of a ball that ends the search for the velocity of a balance of powers
SEEN, BISECTIONS = 64, 50  # places within a row, and steps between two, of a search for where an asperity touches


class Balanced(NamedTuple):
    """Steady motion of a slider whose mean forces vanish."""

    velocity: float  # m/s
    heights: tuple[float, ...]  # mean approach of each ball, m
    rate: float = 0.0  # of the force that is left over the speed, N s/m; 0: unknown


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

    def solve(self, waves: tuple[Orbit, ...], doubling: int, near: Balanced | None = None, /) -> Balanced:
        """Return the steady motion on the orbit of each ball.

        ``doubling``: number of doublings of the discretisation; ``near``: the motion with fewer, where a search may
        start.
        """

    def powers(self, waves: tuple[Orbit, ...], doubling: int, solved: Balanced, /) -> Powers:
        """Return the powers of a motion that `solve` has found with as many doublings, and that is not at rest."""

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


def motion_of(slider: Slider, wave: Orbit) -> np.ndarray:
    """Return A, and the parts of u_x along u_z and a quarter of a cycle before it, m."""
    size = abs(wave.normal)
    along = wave.tangential * (wave.normal.conjugate() / size if size > 0.0 else 1.0)
    return np.array([max(size, FLAT * abs(along) / slider.limit_slope), along.real, along.imag])


class Stops:
    """Balls up to a deepest approach in m, with a stop for each asperity."""

    def __init__(self, slider: Slider, balls, lowest: float, deepest: float):
        self.slider, self.balls, self.lowest, self.deepest = slider, balls, lowest, deepest
        self._tables: dict[int, list[Table]] = {}

    def solve(self, waves: tuple[Orbit, ...], doubling: int, _near: Balanced | None = None, /) -> Balanced:
        """Return the steady motion with so many doublings of steps and rows; the bisection needs no start."""
        heights = self._heights(waves, doubling)
        return Balanced(self._velocity(waves, doubling, heights), heights)

    def powers(self, waves: tuple[Orbit, ...], doubling: int, solved: Balanced, /) -> Powers:
        """As in `TangentialModel`; the integrals are exact between the events of each asperity.

        The velocity differs from that of the steps by their error; where that is all of it, the slider rests.
        """
        slider, heavy, answer = self.slider, heavy_slider(self.slider, waves), np.zeros(4)
        tables = [_touching_at_roots(each) for each in self.tables(doubling)]
        motions, way = [motion_of(slider, each) for each in waves], math.copysign(1.0, solved.velocity)

        def sums(v, cut):
            total = np.zeros(4)
            for table, motion, height in zip(tables, motions, solved.heights, strict=True):
                asperity_powers(table, motion, heavy, height, v, cut, answer)
                total += slider.friction_coefficient * answer
            return total, float(total[0]) - way * slider.load - slider.tangential_damping * v

        least = EVEN * slider.friction_coefficient * heavy.share
        v, force = solved.velocity, sums(solved.velocity, 0)[1]
        step = math.sqrt(CLOSE) * v
        for cut in (0, 0, 1, 1, 1, 1):
            v, before = v + step, force
            total, force = sums(v, cut)
            if force == before or (cut and abs(force) <= least):
                break
            step *= force / (before - force)
        if not 0.5 < v / solved.velocity < 2.0:
            return Powers(0.0, 0.0, 0.0)  # no velocity balances: it moves within the error of the steps only
        return Powers(v, *map(float, total[1:]))

    @property
    def said(self) -> str:
        """As in `TangentialModel`."""
        number = sum(table.touch.size for table in self.tables(0))
        return f"cycle means of {number} asperities, a stop each"

    def refined(self, before: float, last: float) -> tuple[float, float]:
        """Return velocity and error from those of a number of steps and twice as many."""
        # about the square of the step: of a smooth mean a third of the change would be the error
        return last, 0.5 * abs(last - before)

    def tables(self, doubling: int) -> list[Table]:
        """Return the tables with so many doublings of their rows."""
        if doubling not in self._tables:
            self._tables[doubling] = [self._table(each, ROWS * 2**doubling) for each in self.balls]
        return self._tables[doubling]

    def _table(self, ball, rows: int) -> Table:
        z = np.linspace(self.lowest, self.deepest, rows + 1)
        spacing, (approaches, rates) = z[1] - z[0], solved(ball, z)
        # the approach at which an asperity touches first: below, u_j is smooth between two rows
        touching = np.maximum((approaches > 0.0).argmax(axis=0), 1)
        column = np.arange(approaches.shape[1])
        low, high = approaches[touching - 1, column], approaches[touching, column]
        share = np.clip(-low / np.where(high > low, high - low, 1.0), 0.0, 1.0)
        touch = np.where((approaches > 0.0).any(axis=0), z[touching - 1] + share * spacing, np.inf)
        used = np.isfinite(touch)
        return Table(
            np.ascontiguousarray(approaches[:, used]), np.ascontiguousarray(spacing * rates[:, used]), touch[used],
            ball.stiffness[used], ball.merged[used], float(z[0]), float(spacing),
        )  # fmt: skip

    def _heights(self, waves: tuple[Orbit, ...], doubling: int) -> tuple[float, ...]:
        """Return the mean approaches at which the mean normal force of each ball is its part of the preload."""
        turn, answer, share = _turn(doubling), np.zeros(1), self.slider.preload / len(waves)

        def height(table, wave):
            u_z, size = (wave.normal * turn).real, abs(wave.normal)

            def left(h):
                mean_normal(table, h + u_z, answer)
                return float(answer[0]) - share

            span = self.deepest - self.lowest
            return bracketed(left, self.lowest - size, self.deepest - size, tolerance=1e-9 * span)

        return tuple(height(*each) for each in zip(self.tables(doubling), waves, strict=True))

    def _velocity(self, waves: tuple[Orbit, ...], doubling: int, heights: tuple[float, ...]) -> float:
        """Return the velocity at which no mean force is left, with so many doublings of steps and rows."""
        slider, turn, answer = self.slider, _turn(doubling), np.zeros(1)
        u_x = [(each.tangential * turn).real for each in waves]
        size, steps = max(abs(each.normal) for each in waves), turn.size
        z = [height + (each.normal * turn).real for height, each in zip(heights, waves, strict=True)]
        c, friction = slider.limit_slope, slider.friction_coefficient
        tangential, omega = max(abs(each.tangential) for each in waves), waves[0].omega
        top = omega * (tangential + c * size)
        repeats = REPEATS * (tangential + c * size)

        def left(v, load=0.0):
            """Return the force that is left at a velocity under a load with its sign."""
            travel = v * 2.0 * np.pi / (steps * omega)
            pull = 0.0
            for table, place, along in zip(self.tables(doubling), z, u_x, strict=True):
                mean_pull(table, place, along - np.roll(along, 1) - travel, c, repeats, answer)
                pull += float(answer[0])
            return friction * pull - load - slider.tangential_damping * v

        drive = left(0.0)
        way, load = math.copysign(1.0, drive), math.copysign(slider.load, drive)
        if abs(drive) - slider.load <= 1e-9 * friction * slider.preload:
            return 0.0
        # at this speed every asperity slips backwards all the time
        return bracketed(lambda v: left(v, load), 0.0, way * top, tolerance=CLOSE * top)


def _touching_at_roots(table: Table) -> Table:
    """Return a table whose asperities touch where their cubics begin to be positive, instead of straight lines."""
    column, place = np.arange(table.touch.size), (table.touch - table.start) / table.spacing
    row = np.minimum(place.astype(int), table.approaches.shape[0] - 2)
    low, high, rise, fall = (each[k, column] for each in (table.approaches, table.rates) for k in (row, row + 1))
    cubic, square = 2.0 * (low - high) + rise + fall, 3.0 * (high - low) - 2.0 * rise - fall

    def approach(t):
        return low + t * (rise + t * (square + t * cubic))

    # the last of the places where it is not positive
    seen = np.linspace(0.0, 1.0, SEEN + 1)[:, None]
    last = SEEN - (approach(seen)[::-1] <= 0.0).argmax(axis=0)
    begins = (low < 0.0) & (last < SEEN)  # a mean field's begins in the first row
    below, above = last / SEEN, np.minimum(last + 1, SEEN) / SEEN
    for _ in range(BISECTIONS):
        middle = 0.5 * (below + above)
        out = approach(middle) <= 0.0
        below, above = np.where(out, middle, below), np.where(out, above, middle)
    return table._replace(touch=np.where(begins, table.start + table.spacing * (row + above), table.touch))


def _turn(doubling: int) -> np.ndarray:
    steps = STEPS * 2**doubling
    return np.exp(2j * np.pi * np.arange(steps) / steps)
