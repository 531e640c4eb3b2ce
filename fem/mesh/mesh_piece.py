"""A meshed piece at its position on the stator: a mesh, its materials and what its electrodes are connected to."""

from dataclasses import dataclass, field

import numpy as np

from fem.materials.solids import Solid
from fem.mesh.section_mesh import ELECTRODE, SectionMesh

FLOATING, GROUNDED = "floating", "grounded"
MAX_UNKNOWNS = 2_000_000  # of one piece
SAME = 1e-6  # of the thickness: lengths nearer than this are equal


@dataclass(frozen=True, kw_only=True)
class MeshPiece:
    """A piece of the stator in the form of a mesh.

    Attributes
    ----------
    name : str
        Name in messages.
    mesh : SectionMesh
    position : float
        Of the mesh's x = 0, m from the stator's left end.
    solids : tuple of (str, Solid)
        Surface groups other than ``stator`` and their solids, in the stator's axes.
    electrodes : tuple of (str, str)
        Electrodes and what they are connected to: "floating", "grounded", or a transducer's name with "+" or "-".
        Those that are not named float.
    """

    name: str
    mesh: SectionMesh = field(repr=False)
    position: float
    solids: tuple[tuple[str, Solid], ...] = ()
    electrodes: tuple[tuple[str, str], ...] = ()

    @property
    def contents(self) -> tuple:
        """Mesh, solids and electrodes without the position: equal for pieces that are condensed once."""
        return self.mesh, self.solids, self.electrodes

    @property
    def extent(self) -> tuple[float, float]:
        """Smallest and largest x on the stator, m."""
        low, high = self.mesh.extent
        return self.position + low, self.position + high

    @property
    def where(self) -> str:
        """Its extent in words, for messages."""
        low, high = self.extent
        return f"{low * 1e3:.6g} to {high * 1e3:.6g} mm"

    @property
    def gaps(self) -> tuple[tuple[float, float], ...]:
        """Spans on the stator, m from its left end, without plain surface at z = 0, such as a groove."""
        return tuple((self.position + low, self.position + high) for low, high in self.mesh.gaps)

    def connection(self, electrode: str) -> str:
        """Connection of an electrode, as in ``electrodes``."""
        return dict(self.electrodes).get(electrode, FLOATING)

    def strips(self, connection: str) -> np.ndarray:
        """Edges of the electrodes that are connected to something, m from the stator's left end, (n, 2)."""
        spans = []
        for name in self.mesh.electrodes:
            if self.connection(name) == connection:
                x = self.mesh.points[self.mesh.lines[ELECTRODE + name], 0] + self.position
                spans += np.sort(x, axis=1).tolist()
        merged: list[list[float]] = []
        for low, high in sorted(spans):
            if merged and low <= merged[-1][1] + SAME * (high - low):
                merged[-1][1] = max(merged[-1][1], high)
            else:
                merged.append([low, high])
        return np.array(merged).reshape(-1, 2)

    def interface(self, side: str) -> tuple[float, float, float] | None:
        """Position on the stator, height and upper end z of an interface, m; None where the piece is an end."""
        line = self.mesh.interface(side)
        return None if line is None else (self.position + line[0], *line[1:])

    @property
    def depth(self) -> float:
        """Depth of its lowest point below the surface, m."""
        return -float(self.mesh.points[:, 1].min())

    def fits(self, side: str, thickness: float) -> bool:
        """True if an interface is as high as the stator and ends at its surface.

        On a half-space (infinite ``thickness``) it must reach down to the lowest point of the mesh.
        """
        line = self.interface(side)
        thickness = thickness if np.isfinite(thickness) else self.depth
        return line is not None and max(abs(line[1] - thickness), abs(line[2])) <= SAME * thickness
