"""Pieces of a stator's cascade: each lies between two vertical lines and has ports.

A piece relates the outward nodal flux on its lines and the reactions of its ports to the fields there,

    [g_left, g_right, q] = A [u_left, u_right, v],      A complex symmetric,

at one frequency and one k_y.  The cascade does not depend on what is inside: columns of elements under fingers
(`fem.condense.finger_columns`) or a mesh (`fem.condense.condensed_mesh`).
"""

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Port:
    """A potential or a force that drives a piece or a cascade, besides its lines, and the reaction to it.

    Attributes
    ----------
    kind : "voltage", "mean" or "force"
        Of a piece: the potential of an electrode ("voltage"), whose reaction is minus its charge.  Of a cascade: the
        voltage between a transducer's electrodes; the mean of their potentials, which no source sets and which leaves
        the transducer without net charge; or a line force on the surface (N/m), whose reaction is the displacement.
    name : str
        Of a piece's electrode: a transducer's name with "+" or "-".  Of a cascade: the transducer or the force.
    component : "x" or "z"
        Of a force: along the surface, or normal to it.
    position : float
        Of a force, length units from the stator's left end.
    width, center : float
        Of a force that acts on a strip: its length along y and its middle, length units; infinite in a section.
    """

    kind: Literal["voltage", "mean", "force"]
    name: str = ""
    component: Literal["x", "z"] = "z"
    position: float = 0.0
    width: float = float("inf")
    center: float = 0.0


# Ports of every column of a transducer: the potentials of its two electrodes.
ELECTRODES = (Port(kind="voltage", name="+"), Port(kind="voltage", name="-"))


@dataclass(frozen=True)
class Blocks:
    """Slices of a piece's matrix and sides: both lines, of ``size`` unknowns each, then the ports."""

    size: int

    @property
    def left(self) -> slice:
        """The left line."""
        return slice(0, self.size)

    @property
    def right(self) -> slice:
        """The right line."""
        return slice(self.size, 2 * self.size)

    @property
    def lines(self) -> slice:
        """Both lines."""
        return slice(0, 2 * self.size)

    @property
    def ports(self) -> slice:
        """The ports."""
        return slice(2 * self.size, None)


class RecoveredField(Protocol):
    """The field inside a piece."""

    def motion(self, x: np.ndarray) -> np.ndarray:
        """u_x and u_z of the surface at positions x from the piece's left edge, length units: shape (2, positions)."""

    def loss(self) -> float:
        """Power lost inside, scaled, (omega / 2) sum u^H Im(A) u."""


class Piece(Protocol):
    """A condensed piece of the stator at one frequency; lengths in the section's unit."""

    @property
    def size(self) -> int:
        """Unknowns n of a line."""

    @property
    def matrix(self) -> np.ndarray:
        """Over left line, right line and ports, scaled, shape (2 n + ports, 2 n + ports)."""

    @property
    def width(self) -> float:
        """From line to line."""

    @property
    def ports(self) -> tuple[Port, ...]:
        """Its ports."""

    @property
    def floating_potential(self) -> bool:
        """True if a constant may be added to its potential, because no port and no ground holds it."""

    @property
    def unknowns(self) -> int:
        """Unknowns before the condensation."""

    def recover(self, sides: np.ndarray) -> RecoveredField:
        """Field inside for values on lines and ports, shape (2 n + ports,)."""
