"""The wave along the slider's way: the orbits under its contacts as functions of its displacement.

The surface is known at any place of a free span; here it is interpolated between nodes, evaluated where the slider
comes near them. The phase of the orbits turns from node to node by what the wave's phase turns, so that a slider that
moves past them meets the Doppler shift.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from contact import parameter_check
from contact.orbit import Orbits
from contact.parameter_check import refuse_if

BLOCK = 32  # nodes that are evaluated together
LEAST_NODES = 8
NODES = 6  # of the polynomial between two of them


@dataclass(frozen=True, kw_only=True, eq=False)
class Track:
    """Orbits along the displacement of a slider, between two ends.

    Attributes
    ----------
    amplitudes : callable
        Takes displacements of the slider along +x in m, shape (k,), and returns u_x and u_z of its n contacts in m,
        complex, shape (2, n, k).
    spacing : float
        Largest distance of two nodes, m. Six of them make a polynomial: with 32 nodes per wavelength its error is 3e-7
        of the amplitude.
    limits : (float, float)
        Displacements in m, below and above 0, at which the track ends.
    factor : complex
        Factor on all amplitudes.
    """

    amplitudes: Callable[[np.ndarray], np.ndarray] = field(repr=False)
    spacing: float
    limits: tuple[float, float]
    factor: complex = 1.0
    _blocks: dict = field(default_factory=dict, init=False, repr=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, init=False, repr=False)

    def __post_init__(self):
        low, high = self.limits
        refuse_if(not low < 0.0 < high, "track.limits", "must lie on both sides of 0", self.limits)
        parameter_check.positive("track.spacing", self.spacing, "m")

    def scaled(self, factor: complex) -> "Track":
        """Return the track with all amplitudes multiplied by a factor; nodes that one knows are known to the other."""
        track = replace(self, factor=self.factor * factor)
        for shared in ("_blocks", "_lock"):
            object.__setattr__(track, shared, getattr(self, shared))
        return track

    @property
    def count(self) -> int:
        """Number of nodes, with one at either end."""
        low, high = self.limits
        return max(LEAST_NODES, int(np.ceil((high - low) / self.spacing)) + 1)

    @property
    def step(self) -> float:
        """Distance of two nodes, m."""
        return (self.limits[1] - self.limits[0]) / (self.count - 1)

    def values(self, first: int, last: int) -> np.ndarray:
        """Return u_x and u_z at the nodes from ``first`` to before ``last``, m, shape (2, n, last - first)."""
        blocks = range(first // BLOCK, (last - 1) // BLOCK + 1)
        with self._lock:  # two levels of resolution are followed in two threads
            for block in blocks:
                if block not in self._blocks:
                    nodes = np.arange(BLOCK * block, min(BLOCK * (block + 1), self.count))
                    self._blocks[block] = np.asarray(self.amplitudes(self.limits[0] + self.step * nodes), complex)
        together = np.concatenate([self._blocks[block] for block in blocks], axis=2)
        begin = first - BLOCK * blocks[0]
        return self.factor * together[:, :, begin : begin + last - first]

    def at(self, displacements) -> np.ndarray:
        """Return u_x and u_z at displacements in m, shape (k,), interpolated between the nodes; m, shape (2, n, k)."""
        t = (np.asarray(displacements, float) - self.limits[0]) / self.step
        base = np.clip(np.floor(t).astype(int) - 2, 0, self.count - NODES)
        first, last = int(base.min()), int(base.max()) + NODES
        nodes = self.values(first, last)
        found = np.zeros((*nodes.shape[:2], t.size), complex)
        for k in range(NODES):
            others = np.delete(np.arange(NODES), k)
            weight = np.prod((t - base)[:, None] - others, axis=1) / np.prod(k - others)
            found = found + weight * nodes[:, :, base - first + k]
        return found

    def orbits(self, displacements, frequency: float) -> list[Orbits]:
        """Return the orbits of the contacts at displacements in m, shape (k,)."""
        u_x, u_z = self.at(displacements)
        return [Orbits(frequency=frequency, normal=z, tangential=x) for x, z in zip(u_x.T, u_z.T, strict=True)]
