r"""Cycle means of the forces of rough or adhesive balls at a given mean approach and velocity: what tables are made of.

A slider that is heavy on the wave's time scale keeps its mean approach h and its velocity V through a cycle. The means
of the normal and the tangential force of all balls then depend on the wave, h and V alone, also where h is not that of
the steady motion: of a slider that bounces, or whose wave grows. Friction feels the repulsion of the balls alone.

Of unlike balls h is the mean: each stands where it carries an equal part of the mean normal force, as statics demands
of three balls about the centre of mass (`asperity_motion`).
"""

import math
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from contact.averaged.adhesive_motion import AdhesiveBalls
from contact.averaged.asperity_cycle import asperity_powers
from contact.averaged.asperity_motion import RoughBalls
from contact.averaged.asperity_stops import Stops, heavy_slider, motion_of
from contact.averaged.memory_cycle import Balls, mean_memory, net_force, path_of
from contact.averaged.riding import quadrature
from contact.jit.compiled import native
from contact.law.force_table import force_at
from contact.orbit import Orbit
from contact.roots import bracketed

CELLS = 32  # of depth, and twice as many: their extrapolation has 3e-5 of mu P
NODES = 64  # of a mean normal force
STEPS = 512  # of phase, of balls that hold on
EVENED, EVEN, SLOPE = (
    6,
    1e-6,
    1e-4,
)  # steps of Newton's method to equal loads, their difference, and its steps of approach
DOUBLING = 1  # of the rows of the tables of forces
AT_REST = Orbit(frequency=1.0, normal=0.0, tangential=0.0)


class HeldMeans(Protocol):
    """Mean forces of all balls of a slider at a mean approach h in m.

    Attributes
    ----------
    start : float
        Approach at which the first ball touches, or the last one opens, m.
    makes : float
        Approach which a crest must reach for balls that open in the cycle to close again, m.
    """

    start: float
    makes: float

    def loads(self, height: float, waves: tuple[Orbit, ...], /) -> tuple[float, float]:
        """Return the mean repulsion and the mean attraction in N, on the orbit of each ball."""

    def tractions(self, height: float, waves: tuple[Orbit, ...], velocities: np.ndarray, /) -> np.ndarray:
        """Return the mean tangential forces in N along +x at velocities in m/s; at 0.0 and -0.0 their limits."""


@native("t i f f f1 f1 f1", {"node": "k", "weight": "k", "out": "1"})
def mean_force(table, k, height, normal, node, weight, out):
    """Write the mean normal force of contact k on a wave of an amplitude, over the half of its cycle that touches."""
    half = math.pi
    if height - table.start[k] < normal:
        half = math.acos(min(max((table.start[k] - height) / normal, -1.0), 1.0))
    total = 0.0
    for i in range(node.size):
        total += weight[i] * force_at(table, k, height + normal * math.cos(half * node[i]))
    out[0] = total * half / math.pi
    return 0


@native("t i1 f2 t i f2 f1 f2", {"which": "n", "waves": "n 3", "heights": "2 n", "velocities": "m", "out": "2 m"})
def memory_tractions(table, which, waves, heavy, cells, heights, velocities, out):
    """Write the mean tangential forces of balls along +x over mu at signed velocities, by cells and by half of them.

    ``heights``: mean approaches of the balls, twice.
    """
    balls = Balls(table, table, which, waves, heights, heavy, net_force)
    for j in range(velocities.size):
        way = math.copysign(1.0, velocities[j])
        out[0, j] = out[1, j] = 0.0
        for ball in range(which.size):
            fine, coarse = mean_memory(balls, ball, path_of(waves[ball], heavy, way, abs(velocities[j])), cells)
            out[0, j] += way * fine
            out[1, j] += way * coarse
    return 0


class RoughMeans:
    """Means of rough balls; ``deepest``: largest approach that is asked for, m. See `HeldMeans`."""

    def __init__(self, balls: RoughBalls, deepest: float):
        self.slider = balls.slider
        self.model: Any = balls.reaching(deepest)  # Memory or Stops
        count, low, high = len(balls.samples), balls.lowest, self.model.deepest
        share = self.slider.preload / count
        rest = np.array(
            [
                bracketed(lambda z, k=k: self._load(k, z, AT_REST) - share, low, high, tolerance=1e-9 * (high - low))
                for k in range(count)
            ]
        )
        self.offsets = rest - rest.mean()
        self.start = self.makes = float(low - self.offsets.max())

    def loads(self, height, waves):
        """As in `HeldMeans`."""
        return float(self._heights(height, waves)[1].sum()), 0.0

    def _heights(self, height: float, waves: tuple[Orbit, ...]) -> tuple[np.ndarray, np.ndarray]:
        """Return approaches in m whose mean is `height`, at which all balls carry alike, and what each carries, N."""
        z, each = height + self.offsets, range(self.offsets.size)
        loads = np.array([self._load(k, z[k], waves[k]) for k in each])
        for _ in range(EVENED if self.offsets.size > 1 else 0):
            if np.ptp(loads) <= EVEN * loads.max():
                break
            step = SLOPE * (abs(height) + max(abs(wave.normal) for wave in waves))
            slopes = np.array([self._load(k, z[k] + step, waves[k]) - loads[k] for k in each]) / step
            if slopes.min() <= 0.0:
                break  # one ball is in the air
            goal = np.sum(loads / slopes) / np.sum(1.0 / slopes)
            z = z + (goal - loads) / slopes
            loads = np.array([self._load(k, z[k], waves[k]) for k in each])
        return z, loads

    def tractions(self, height, waves, velocities):
        """As in `HeldMeans`."""
        velocities, (heights, _) = np.asarray(velocities, float), self._heights(height, waves)
        heavy, motions = heavy_slider(self.slider, waves), np.array([motion_of(self.slider, each) for each in waves])
        if isinstance(self.model, Stops):
            table, sums, found = self.model.table(DOUBLING), np.empty(4), []
            for v in velocities.tolist():
                way = math.copysign(1.0, v)
                asperity_powers(table, motions, heavy, heights, way, abs(v), 0, sums)
                found.append(way * float(sums[0]))
            return self.slider.friction_coefficient * np.array(found)
        out, twice = np.empty((2, velocities.size)), np.array([heights, heights])
        memory_tractions(*self.model.forces(DOUBLING), motions, heavy, 2 * CELLS, twice, velocities, out)
        fine, coarse = out
        return self.slider.friction_coefficient * (fine + (fine - coarse) / 3.0)

    def _load(self, ball: int, z: float, wave: Orbit) -> float:
        """Return the mean normal force of one ball in N."""
        out, (table, which) = np.zeros(1), self.model.forces(DOUBLING)
        mean_force(table, which[ball], z, abs(wave.normal), *quadrature(NODES), out)
        return float(out[0])


def rough_first_normal(balls: RoughBalls, orbits: Sequence[Orbit], heights: Sequence[float]) -> np.ndarray:
    """Return the first harmonic of the normal force of each rough ball at its mean approach in m, N, complex.

    The force is P_0 + Re P_1 exp(i omega t), with the phase of the orbits' amplitudes.
    """
    model: Any = balls.on(orbits)
    (table, which), out, found = model.forces(DOUBLING), np.zeros(1), np.zeros(len(orbits), complex)
    rule = quadrature(NODES)
    for k, (height, wave) in enumerate(zip(heights, orbits, strict=True)):
        size = abs(wave.normal)
        if size == 0.0:
            continue
        # half of the cycle that touches, as in `mean_force`
        half = math.acos(min(max((table.start[which[k]] - height) / size, -1.0), 1.0))
        mean_force(table, which[k], height, size, rule.node, 2.0 * rule.weight * np.cos(half * rule.node), out)
        found[k] = wave.normal / size * out[0]
    return found


class AdhesiveMeans:
    """Means of balls whose adhesion holds on beyond the touch; see `HeldMeans`."""

    def __init__(self, balls: AdhesiveBalls):
        self.balls, self.start, self.makes = balls, balls.ball.break_approach, balls.ball.make_approach

    def loads(self, height, waves):
        """As in `HeldMeans`."""
        cycles = self.balls.cycles(waves, height, STEPS)
        repulsion = sum(float(each.weights @ self.balls.repulsion(each)) for each in cycles if each is not None)
        return repulsion, repulsion - sum(float(each.weights @ each.forces) for each in cycles if each is not None)

    def tractions(self, height, waves, velocities):
        """As in `HeldMeans`."""
        cycles = self.balls.cycles(waves, height, STEPS)
        return self.balls.dragged(waves, cycles, np.asarray(velocities, float))
