"""Heavy slider on rough balls each of whose asperities slips on its own: mean approaches and velocity, in steps.

The approaches u_j of the asperities of a ball are tabulated over the ball's approach, and each asperity has its own
stop (`asperity_cycle`). A mean field with the elastic law has one stop, of the force of the whole ball.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from contact.averaged.asperity_cycle import Table, mean_normal, mean_pull
from contact.law.asperities import ROWS, solved
from contact.orbit import Orbit
from contact.roots import bracketed
from contact.slider import Slider

STEPS = 128  # of phase, of the first answer
REPEATS = 1e-9  # change of a deformation from one cycle to the next over the largest, at which it repeats
CLOSE = 1e-6  # of the velocity over its range


class Balanced(NamedTuple):
    """Steady motion of a slider whose mean forces vanish."""

    velocity: float  # m/s
    heights: tuple[float, ...]  # mean approach of each ball, m
    rate: float = 0.0  # of the force that is left over the speed, N s/m; 0: unknown


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

    @property
    def said(self) -> str:
        """What the answers are, for the reasons of an `Answer`."""

    def refined(self, before: float, last: float, /) -> tuple[float, float]:
        """Return velocity and its error, m/s, from those of a doubling and of the next, which is twice as fine."""


class Stops:
    """Balls up to a deepest approach in m, with a stop for each asperity."""

    def __init__(self, slider: Slider, balls, lowest: float, deepest: float):
        self.slider, self.balls, self.lowest, self.deepest = slider, balls, lowest, deepest
        self._tables: dict[int, list[Table]] = {}

    def solve(self, waves: tuple[Orbit, ...], doubling: int, _near: Balanced | None = None, /) -> Balanced:
        """Return the steady motion with so many doublings of steps and rows; the bisection needs no start."""
        heights = self._heights(waves, doubling)
        return Balanced(self._velocity(waves, doubling, heights), heights)

    @property
    def said(self) -> str:
        """As in `TangentialModel`."""
        number = sum(table.touch.size for table in self._at(0))
        return f"cycle means of {number} asperities, a stop each"

    def refined(self, before: float, last: float) -> tuple[float, float]:
        """Return velocity and error from those of a number of steps and twice as many."""
        # about the square of the step: of a smooth mean a third of the change would be the error
        return last, 0.5 * abs(last - before)

    def _at(self, doubling: int) -> list[Table]:
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

        return tuple(height(*each) for each in zip(self._at(doubling), waves, strict=True))

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
            for table, place, along in zip(self._at(doubling), z, u_x, strict=True):
                mean_pull(table, place, along - np.roll(along, 1) - travel, c, repeats, answer)
                pull += float(answer[0])
            return friction * pull - load - slider.tangential_damping * v

        drive = left(0.0)
        way, load = math.copysign(1.0, drive), math.copysign(slider.load, drive)
        if abs(drive) - slider.load <= 1e-9 * friction * slider.preload:
            return 0.0
        # at this speed every asperity slips backwards all the time
        return bracketed(lambda v: left(v, load), 0.0, way * top, tolerance=CLOSE * top)


def _turn(doubling: int) -> np.ndarray:
    steps = STEPS * 2**doubling
    return np.exp(2j * np.pi * np.arange(steps) / steps)
