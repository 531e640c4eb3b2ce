"""Tables of mean forces of contacts whose force is no power of the approach: rough balls, and adhesion that holds on.

Their means depend on the size of the wave beside the two ratios of `force_grid`: the tables have a third axis, the
approach of the crest. They are made of `contact.HeldMeans`, the means that a run has. Rows are closer on both sides of
the ratio at which contacts open in the trough, where balls that hold on jump (`reduced_motor.force_tables`).
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import contact
from contact.roots import bracketed
from studies.export.motor_model import Drive
from studies.export.reduced_motor import index
from studies.export.reduced_motor.force_tables import EDGE

MAX_TAU = 0.995  # of the last row, in place of 1, where the load is zero
EDGE_STEP = 1e-9  # of the amplitude: approach on either side of the jump
FORCE_NODES = 257  # of the force at rest
BEYOND = 1.5  # of the scene's largest level: up to there the tables reach
MOST_PRELOAD = 2.0  # of the scene's preload


@dataclass(frozen=True, kw_only=True)
class Nodes:
    """Numbers of nodes of the crest's approach, of tau on both sides of the edge, and of either side of nu."""

    depths: int
    closed: int
    open: int
    columns: int
    fastest: float = 1.0  # sqrt(nu) of the last column


@dataclass(frozen=True, kw_only=True)
class LawTables:
    """Tables of one drive: shapes (depths, rows), (depths, rows) or None, and (2, depths, rows, columns)."""

    loads: np.ndarray
    pulls: np.ndarray | None
    forces: np.ndarray


@dataclass(frozen=True, kw_only=True)
class LawGrid:
    """Nodes of the tables of one slider, in SI units."""

    means: Any  # contact.HeldMeans
    nodes: Nodes
    deepest: float  # approach over `means.start` of the last node, m
    scale: float  # L of `contact_spring.place`, m
    force: np.ndarray  # repulsion at rest at its nodes, N
    attracts: bool

    @classmethod
    def of(cls, means, nodes: Nodes, *, count: int, preload: float, amplitude: float, holds: bool) -> "LawGrid":
        """Return the nodes for preloads up to `MOST_PRELOAD` times one in N, and waves up to an amplitude in m."""
        still = (contact.Orbit(frequency=1.0, normal=0.0, tangential=0.0),) * count

        def net(height):
            repulsion, attraction = means.loads(height, still)
            return repulsion - attraction

        def under(force):
            high = means.start + (means.makes - means.start) + amplitude
            while net(high) < force:
                high = means.start + 2.0 * (high - means.start)
            return bracketed(lambda h: net(h) - force, high - 0.999999 * (high - means.start), high, tolerance=1e-16)

        rest = under(preload) - means.start
        deepest = under(MOST_PRELOAD * preload) - means.start + BEYOND * amplitude
        # a depth that begins as a square root wants nodes that do so, too
        scale = 1e-3 * rest if holds else rest
        z = places(FORCE_NODES, deepest, scale)
        force = np.array([means.loads(means.start + each, still)[0] for each in z])
        return cls(means=means, nodes=nodes, deepest=deepest, scale=scale, force=force, attracts=holds)

    def tables(self, slider, drive: Drive) -> LawTables:
        """Return the tables of a drive of a slider."""
        nodes, means = self.nodes, self.means
        closed = EDGE * (1.0 - (1.0 - np.linspace(0.0, 1.0, nodes.closed)) ** 2)
        opened = EDGE + (1.0 - EDGE) * np.linspace(0.0, 1.0, nodes.open) ** 2
        taus = np.concatenate([closed, opened])
        depths = places(nodes.depths, self.deepest, self.scale)
        shape = (nodes.depths, taus.size)
        loads, pulls, forces = np.ones(shape), np.zeros(shape), np.zeros((2, *shape, nodes.columns))
        sizes = np.linspace(0.0, nodes.fastest, nodes.columns)
        forces[0], forces[1] = 1.0, -1.0  # without a wave friction has one direction
        still = tuple(replace(orbit, normal=0.0, tangential=0.0) for orbit in drive.orbits)
        known = np.zeros(shape, bool)
        for i in range(1, nodes.depths):
            z = float(depths[i])
            at_rest, attraction = means.loads(means.start + z, still)
            loads[i, 0], pulls[i, 0], known[i, 0] = 1.0, attraction / at_rest, True
            for j in range(1, taus.size):
                tau = min(float(taus[j]), MAX_TAU)
                size = z / (1.0 / tau - 1.0) ** 2
                step = EDGE_STEP * size * (1.0 if j == nodes.closed - 1 else -1.0 if j == nodes.closed else 0.0)
                found = self.at(slider, drive, means.start + z - size + step, size, sizes)
                if found is None:
                    loads[i, j] = pulls[i, j] = 0.0
                    continue
                load, pull, forces[:, i, j] = found
                loads[i, j], pulls[i, j], known[i, j] = load / at_rest, pull / at_rest, True
        _fill(known, loads, pulls, forces)
        return LawTables(loads=loads, pulls=pulls if self.attracts else None, forces=forces)

    def at(self, slider, drive: Drive, height: float, size: float, sizes: np.ndarray):
        """Return mean repulsion and attraction in N and g, shape (2, k), at ``sizes`` = sqrt(|nu|); None in the air."""
        waves = tuple(orbit.scaled(size / drive.amplitude) for orbit in drive.orbits)
        repulsion, attraction = self.means.loads(height, waves)
        if repulsion <= 0.0:
            return None
        speeds = sizes**2 * drive.saturation(slider) * size
        forces = self.means.tractions(height, waves, np.concatenate([-speeds, speeds])).reshape(2, -1)
        return repulsion, attraction, forces / (slider.friction_coefficient * repulsion)

    def parameters(self, p: np.ndarray) -> None:
        """Write what `reduced_motor` reads of the nodes into its parameters."""
        nodes = self.nodes
        p[index.START], p[index.MAKES] = self.means.start, self.means.makes
        p[index.FORCE_NODES], p[index.FORCE_SCALE], p[index.DEEPEST] = FORCE_NODES, self.scale, self.deepest
        p[index.SPRING] = 0.0 if self.attracts else 1.0
        p[index.DEPTHS], p[index.SPLIT], p[index.FASTEST] = nodes.depths, nodes.closed, nodes.fastest
        p[index.TAU_NODES], p[index.NU_NODES] = nodes.closed + nodes.open, nodes.columns


def places(count: int, deepest: float, scale: float) -> np.ndarray:
    """Return the approaches over the start in m of nodes, as `contact_spring.place` places them."""
    u = np.linspace(0.0, 1.0, count) * (np.sqrt(1.0 + deepest / scale) - 1.0)
    return scale * u * (2.0 + u)


def _fill(known: np.ndarray, loads: np.ndarray, pulls: np.ndarray, forces: np.ndarray) -> None:
    """Give nodes at which nothing touches the entries of the next depth at which something does."""
    depths, rows = known.shape
    for j in range(rows):
        for i in range(depths - 2, -1, -1):
            if not known[i, j] and known[i + 1, j]:
                loads[i, j], pulls[i, j], forces[:, i, j] = loads[i + 1, j], pulls[i + 1, j], forces[:, i + 1, j]
                known[i, j] = True
