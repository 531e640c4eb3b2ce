"""Points for drawing a field, with their displacements: of a section, of a solid, or of the surface under a beam.

The points are nodes of the mesh.  Nodes closer together than a pixel are skipped.  Between nodes that are far apart,
further points are evaluated from the modes and the elements' polynomials.  No value is an average.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from studies.model.model import model_of
from studies.record.surface_map import surface_map
from studies.refusal import refuse_if
from studies.view.field_quantities import MOTIONS, QUANTITIES, Shade, shade_of
from studies.view.run_field import LINES, RunField

AMPLITUDE = 0.08  # wavelengths: size at which the largest displacement is drawn
MAX_SPACING_RATIO = 4.0  # largest distance of drawn points over the smallest
PAIRED = 4, 8  # as below, where neighbours along x are averaged
PER_WAVELENGTH = 12, 8  # lines on the surface under a beam: along x; along x and y where beams cross


def magnification(run: RunField) -> float:
    """Return the default factor by which displacements are enlarged, rounded to one digit."""
    largest = float(abs(run.field.displacement).max())
    return float(f"{AMPLITUDE * run.wavelength / largest:.0e}") if largest else 1.0


@dataclass(frozen=True, kw_only=True)
class SectionPart:
    """Part of the section on a grid x (n,) and z (m,) in m: complex u_x and u_z (n, m, 2), and the drawn quantity.

    ``mean`` and ``amplitude``, (n, m), are those of the quantity that colours the picture (`Shade.parts`).
    """

    x: np.ndarray
    z: np.ndarray
    displacement: np.ndarray
    mean: np.ndarray
    amplitude: np.ndarray
    inside: np.ndarray  # shape (n, m): True for points in the solid
    meshed: tuple = ()  # `fem.PieceField` of every meshed piece in this part

    @classmethod
    def of(
        cls, run: RunField, shading: Shade, *, span: tuple[float, float], bottom: float, spacing: float
    ) -> "SectionPart":
        """Return the field within a span of x and down to z = ``bottom`` on points at least ``spacing`` (m) apart."""
        energies, facet = shading.quantity.harmonic == 2, MAX_SPACING_RATIO * spacing
        if facet < run.wavelength / LINES:
            field = run.compute(span=span, per_wavelength=run.wavelength / facet, energies=energies)
        else:
            field = run.with_energies if energies else run.field
        lines = thinned(field.x, spacing, *span)
        bottom = max(bottom, field.z[0])
        nodes = np.append(bottom, field.z[field.z > bottom])
        nodes = nodes[thinned(nodes, spacing, bottom, 0.0)]
        parts = [
            np.linspace(low, high, int(np.ceil((high - low) / facet)), endpoint=False) for low, high in pairwise(nodes)
        ]
        z = np.append(np.concatenate(parts), 0.0)
        basis = field.depth_basis(z)
        displacement, mean, amplitude = (
            np.einsum("kj,xj...->xk...", basis, values[lines])
            for values in (field.displacement[..., [0, 2]], *shading.parts(field))
        )
        inside = np.ones((len(lines), len(z)), dtype=bool)
        if field.inside is not None:
            inside = field.inside[np.ix_(lines, np.searchsorted(field.z, z).clip(0, len(field.z) - 1))]
        return cls(
            x=field.x[lines], z=z, displacement=displacement, mean=mean, amplitude=amplitude, inside=inside,
            meshed=field.pieces,
        )  # fmt: skip

    def surface(self, at: np.ndarray) -> np.ndarray:
        """Return the displacement of the surface at points (x, y) in m, shape (k, 3)."""
        return self.at_height(at, 0.0)

    def at_height(self, at: np.ndarray, z: float) -> np.ndarray:
        """Return the displacement at points (x, y) and one height z in m, shape (k, 3)."""
        above = int(np.clip(np.searchsorted(self.z, z), 1, len(self.z) - 1))
        share = (z - self.z[above - 1]) / (self.z[above] - self.z[above - 1])
        along = (1.0 - share) * self.displacement[:, above - 1] + share * self.displacement[:, above]
        u_x, u_z = (np.interp(at[:, 0], self.x, each) for each in along.T)
        return np.stack([u_x, 0.0 * u_x, u_z], axis=-1)


class Sheet(NamedTuple):
    """A surface to be drawn: points at rest, (n, m, copies, 3) in m, and values that broadcast to these points.

    The values are the complex displacement, and the mean and amplitude of the quantity that colours the picture.
    ``quads``: elements, if the points (n, 1, 1, 3) are no grid; ``hidden``: cells of a grid that are not drawn.
    """

    name: str
    rest: np.ndarray
    displacement: np.ndarray
    mean: np.ndarray
    amplitude: np.ndarray
    quads: np.ndarray | None = None
    hidden: np.ndarray | None = None


def sheets(run: RunField, drawn: SectionPart, shading: Shade, *, solid: bool) -> list[Sheet]:
    """Return the section; for a solid also its surface and its right end, as wide as the aperture.

    A sheet for each meshed piece follows, on the piece's own elements.
    """
    moved = np.insert(drawn.displacement, 1, 0.0, axis=-1)
    edges = np.array([-0.5, 0.5]) * run.aperture if solid else np.zeros(1)
    whole, last = slice(None), slice(-1, None)
    parts = [("section", whole, whole, edges[:1])]
    if solid:
        parts += [("surface", whole, last, edges), ("end", last, whole, edges)]
    listed = []
    for name, along, down, y in parts:
        points = np.meshgrid(drawn.x[along], drawn.z[down], y, indexing="ij")
        values = (each[along, down, None] for each in (moved, drawn.mean, drawn.amplitude))
        sheet = Sheet(name, np.stack(points, axis=-1)[..., [0, 2, 1]], *values)
        listed.append(sheet if name == "end" else sheet._replace(hidden=_hidden(drawn, surface=name == "surface")))
    for number, each in enumerate(drawn.meshed):
        rest = np.insert(each.points, 1, edges[0], axis=1)[:, None, None]
        moved = np.insert(each.displacement[:, [0, 2]], 1, 0.0, axis=-1)[:, None, None]
        mean, amplitude = (part[:, None, None] for part in shading.parts(each))
        listed.append(Sheet(f"piece {number}", rest, moved, mean, amplitude, quads=each.quads))
    return listed


def _hidden(drawn: SectionPart, *, surface: bool) -> np.ndarray:
    """Cells of the grid that are not drawn, because a mesh is drawn there or the mesh has no solid at the surface."""
    if surface:
        inside = drawn.inside[:, -1]
        return ~(inside[1:] & inside[:-1])
    middle = 0.5 * (drawn.x[1:] + drawn.x[:-1])
    meshed = np.zeros(len(middle), dtype=bool)
    for low, high in (each.span for each in drawn.meshed):
        meshed |= (middle > low) & (middle < high)
    return np.repeat(meshed[:, None], len(drawn.z) - 1, axis=1)


def beam_sheet(run: RunField, name: str, *, envelope: bool = False) -> tuple[Shade, Sheet, Callable]:
    """Return the colouring and the sheet of the surface under a beam, and its motion as a function of (x, y) in m.

    ``envelope``: colour by the amplitude, for pictures in which a wavelength is only a few pixels.
    """
    rule = f"must be one of {', '.join(MOTIONS)} on the surface of the beam, got {name!r}"
    refuse_if(name not in MOTIONS, "--quantity", f"{rule}: --show field has it in the section")
    paired = envelope and run.crossed is None
    x, y, motion = surface_map(run.beam, run.scene.stator, PAIRED if paired else PER_WAVELENGTH, picture=True)
    moved = np.moveaxis(motion, 0, -1)
    size = moved[..., MOTIONS.index(name), None]
    drawn = QUANTITIES[name]
    if envelope:
        drawn = drawn._replace(envelope=True, signed=False)
    if paired:
        # a quarter of a wavelength apart a standing wave's ripple has opposite signs: the mean square of two neighbours
        # is that of the two opposite waves, without stripes that the picture cannot resolve
        size = np.sqrt(0.5 * (abs(size) ** 2 + np.roll(abs(size) ** 2, -1, axis=0)))
        size[-1] = size[-2]
    shading = shade_of(drawn, abs(size), free=False)
    rest, amplitude = np.stack(np.meshgrid(x, y, 0.0, indexing="ij"), axis=-1), size * shading.scale
    mean = abs(amplitude) if envelope else 0.0 * amplitude.real
    sheet = Sheet("surface", rest, moved[:, :, None], mean, 0.0 * amplitude if envelope else amplitude)
    return shading, sheet, partial(between_lines, x, y, moved)


def between_lines(x: np.ndarray, y: np.ndarray, values: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Interpolate values on a grid, (x, y, ...), linearly in x and y at points (n, 2) on it; shape (n, ...).

    `scipy.interpolate` does the same, and its import takes a tenth of the time of a picture.
    """
    cells, shares = [], []
    for axis, along in zip((x, y), points.T, strict=True):
        cell = np.clip(np.searchsorted(axis, along, side="right") - 1, 0, len(axis) - 2)
        share = (along - axis[cell]) / (axis[cell + 1] - axis[cell])
        cells.append(cell)
        shares.append(share.reshape(-1, *[1] * (values.ndim - 2)))
    (i, j), (s, t) = cells, shares
    below, above = (1 - s) * values[i, j] + s * values[i + 1, j], (1 - s) * values[i, j + 1] + s * values[i + 1, j + 1]
    return (1 - t) * below + t * above


def strips(run: RunField, electrode, *, spreads: bool) -> np.ndarray:
    """Return the corners (x, y) of an electrode's strips in m, shape (4 n, 2).

    ``spreads``: as they lie on the surface, for a beam; otherwise as wide as the drawn section.
    """
    if spreads:
        transducers = model_of(run.scene).transducers
        corners = [each.on_surface(each.strips(electrode.sign)) for each in transducers]
        return np.concatenate(corners).reshape(-1, 2)
    x = np.array(electrode.strips)[:, [0, 1, 1, 0]].ravel()
    return np.stack([x, np.resize(0.5 * run.aperture * np.array([-1, -1, 1, 1]), len(x))], axis=-1)


def thinned(positions: np.ndarray, spacing: float, start: float, stop: float) -> np.ndarray:
    """Return indices of increasing positions between two limits, such that neighbours are at least a spacing apart.

    The first and the last position within the limits are always included.

    Examples
    --------
    >>> thinned(np.array([0.0, 0.1, 0.2, 1.0, 2.0, 3.0]), 0.15, 0.0, 2.0)
    array([0, 2, 3, 4])
    """
    inside = np.flatnonzero((positions >= start) & (positions <= stop)).tolist()
    selected = inside[:1]
    for number in inside[1:]:
        if positions[number] - positions[selected[-1]] >= spacing:
            selected.append(number)
    if selected[-1] != inside[-1]:
        # the last position replaces the one that is too near to it
        selected[max(len(selected) - 1, 1) :] = inside[-1:]
    return np.array(selected)
