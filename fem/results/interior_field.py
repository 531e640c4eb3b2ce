"""Interior field of a driven stator on a grid, recovered on demand, and that of a free wave.

The lines of the grid are the nodes of the columns under the transducers, and evenly spaced lines in the segments, where
the field is a sum of modes.  Through the depth the nodes are those of the section, so that no value is averaged over an
element.  Derivatives are those of the elements' polynomials and of the modes.  The field of a meshed piece is also
evaluated on its own elements, each divided into small quadrilaterals, because a grid cannot follow its corners and
slopes.
"""

from dataclasses import dataclass, field

import numpy as np

from fem.condense.finger_columns import ColumnsField
from fem.discretize.spectral import gll_nodes, lagrange
from fem.materials import Solid
from fem.results.driven_answer import SurfaceWave
from fem.results.energy_densities import Densities, densities, flattened, layered_densities, shared, upward_slope
from fem.results.field_evaluation import ENDS, columns_in_order, recovered
from fem.results.segment_modes import FreeWave
from fem.results.stator_solution import Solution
from fem.results.surface import CondensedPiece, UniformSegment

SAME_LINE = 1e-6  # of the lines' distance: positions nearer than this are one
REPLACED = 1e-3  # of the lines' distance: even lines nearer than this to a requested position are left out
MIN_INTERVALS = 3  # between the lines of a segment, however short it is
MAX_CUTS = 8  # quadrilaterals along an element's edge: an element is half a wavelength long at most


@dataclass(frozen=True, kw_only=True)
class PieceField:
    """Complex field per volt of the drive on the elements of a meshed piece.

    Attributes
    ----------
    span : tuple of float
        Left and right edge of the piece, m from the stator's left end.
    points : ndarray, shape (n, 2)
        x from the stator's left end and z from the surface, m; the corners of an element are its own.
    quads : ndarray, shape (m, 4)
        Numbers of points.
    displacement, potential, densities
        As of `WaveField`, shapes (n, 3), (n,) and (n, ...).
    """

    span: tuple[float, float]
    points: np.ndarray = field(repr=False)
    quads: np.ndarray = field(repr=False)
    displacement: np.ndarray = field(repr=False)
    potential: np.ndarray = field(repr=False)
    densities: Densities | None = field(default=None, repr=False)


@dataclass(frozen=True, kw_only=True)
class WaveField:
    """Complex field per volt of the drive on a grid of the section.

    Attributes
    ----------
    x : ndarray, shape (nx,)
        m from the left end.
    z : ndarray, shape (nz,)
        m, 0 at the surface, negative below, increasing.
    displacement : ndarray, shape (nx, nz, 3)
        u_x, u_y, u_z in m per V.
    potential : ndarray, shape (nx, nz)
        V per V.
    frequency : float
        Hz.
    order : int
        Of the elements through the depth: every ``order``-th node is an element's end.
    densities : Densities or None
        Strain energy and power flow, if they were requested.
    inside : ndarray of bool, shape (nx, nz), or None
        True at nodes in the solid, if a meshed piece leaves some of the grid empty; the field is 0 at the other nodes.
        The part of a mesh above z = 0 is not on the grid.
    pieces : tuple of PieceField
        The meshed pieces in the span, on their own elements.
    """

    x: np.ndarray
    z: np.ndarray
    displacement: np.ndarray = field(repr=False)
    potential: np.ndarray = field(repr=False)
    frequency: float
    order: int
    densities: Densities | None = field(default=None, repr=False)
    inside: np.ndarray | None = field(default=None, repr=False)
    pieces: tuple[PieceField, ...] = field(default=(), repr=False)

    def depth_basis(self, z: np.ndarray) -> np.ndarray:
        """Return the matrix from nodal values to values at heights z (m) by the elements' polynomials, (m, nz)."""
        ends = self.z[:: self.order]
        element = np.clip(np.searchsorted(ends, z, side="right") - 1, 0, len(ends) - 2)
        local = (z - ends[element]) / (ends[element + 1] - ends[element])
        values, _ = lagrange(self.order, local)
        out = np.zeros((len(z), len(self.z)))
        columns = element[:, None] * self.order + np.arange(self.order + 1)
        np.put_along_axis(out, columns, values, axis=1)
        return out


def wave_field(
    wave: SurfaceWave,
    *,
    per_wavelength: float = 16,
    places: tuple[float, ...] = (),
    span: tuple[float, float] | None = None,
    energies: bool = False,
) -> WaveField:
    """Rebuild the interior of a driven stator.

    Parameters
    ----------
    wave : SurfaceWave
    per_wavelength : float
        Lines per surface wavelength in the segments.
    places : tuple of float
        m from the left end: positions of additional lines; those outside the segments are ignored.
    span : tuple of float, optional
        m from the left end: only lines between these two positions.
    energies : bool
        True to compute strain energy and power flow too.
    """
    section = wave.solution.fields.section.full
    step = wave.phase_velocity / wave.frequency / per_wavelength
    depth = section.nodes[section.body]
    parts, meshed = _cascade_parts(wave, span or (0.0, wave.length), step, places, energies=energies)
    units = section.field_units
    values = np.concatenate([part.values for part in parts]) * units
    inside = np.concatenate([np.broadcast_to(part.inside, part.values.shape[:2]) for part in parts])
    return WaveField(
        x=np.concatenate([part.x for part in parts]),
        z=depth,
        displacement=values[:, :, :3],
        potential=values[:, :, 3],
        frequency=wave.frequency,
        order=section.order,
        densities=_grid_densities(wave, parts, values, depth) if energies else None,
        inside=None if inside.all() else inside,
        pieces=tuple(meshed),
    )


def _cascade_parts(
    wave: SurfaceWave, span: tuple[float, float], step: float, positions: tuple[float, ...], *, energies: bool
) -> tuple[list["_Part"], list[PieceField]]:
    """Fields of all pieces and segments within a span, from left to right; meshed pieces also on their mesh.

    ``step``: distance of the lines, m; ``positions``: of additional lines, m.

    If the section's potential floats, phi is known up to a constant in each segment: the modes give it relative to the
    transducer on the left.  All potentials are referred to the first transducer by adding ``offset``.
    """
    solution = wave.solution
    section = solution.fields.section.full
    depth = section.nodes[section.body]
    same_line = SAME_LINE * step
    parts: list[_Part] = []
    meshed: list[PieceField] = []
    offset: complex = 0.0  # mean potential of the transducer passed last, relative to the first one, scaled
    step_in_mean: complex = 0.0  # jump from that potential to the mean potential of the next transducer
    passed_first = False  # True to the right of the first piece of the cascade
    for piece in wave.pieces:
        if isinstance(piece, UniformSegment) and piece.beyond:
            continue  # another section: not on this grid
        start, stop = max(piece.start, span[0]), min(piece.stop, span[1])
        in_span = start < stop
        if isinstance(piece, CondensedPiece):
            is_end = piece.index in ENDS
            offset += 0.0 if is_end else step_in_mean
            passed_first |= not is_end
            if in_span:
                if not isinstance(recovered(solution, piece.index), ColumnsField):
                    meshed.append(_on_mesh(solution, piece, step, offset, energies=energies))
                part = _in_piece(solution, piece, depth, step, slopes=energies)
                part = part.on_lines((part.x > start - same_line) & (part.x < stop + same_line))
        else:
            if in_span:
                x = _lines(start, stop, step, positions)
                part = _Part(x, *_between(solution, piece, x, first=not passed_first, slopes=energies))
            step_in_mean = _gauge_step(solution, piece) if passed_first else 0.0
        if not in_span:
            continue
        part.values[..., 3] += offset * part.inside
        if parts and part.x[0] < parts[-1].x[-1] + same_line:  # the line shared with the piece before
            part = part.on_lines(slice(1, None))
        parts.append(part)
    return parts, meshed


def _grid_densities(wave: SurfaceWave, parts: list["_Part"], values: np.ndarray, depth: np.ndarray) -> Densities:
    """Strain energy and power flow on the grid; ``values``: the fields in SI units, (nx, nz, 4)."""
    fields = wave.solution.fields
    section = fields.section.full
    units = section.field_units
    along = np.concatenate([part.along for part in parts]) * units
    if fields.stator.layers:
        solids = section.solids_of_elements(fields.stator.solids)
        return layered_densities(solids, wave.frequency, values, along, depth[:: section.order])
    upward = np.concatenate([part.upward_slopes(section, depth) for part in parts]) * units
    whole = densities(fields.stator.solid, wave.frequency, values, along, upward)
    first = np.cumsum([0, *(len(part.x) for part in parts)])
    for part, start in zip(parts, first, strict=False):
        _in_other_solids(whole, wave.frequency, part, slice(start, start + len(part.x)), units)
    return whole


def _in_other_solids(whole: Densities, frequency: float, part: "_Part", lines: slice, units: np.ndarray) -> None:
    """Replace the densities at a part's nodes that lie in other solids than the stator's; ``lines``: of the part."""
    for solid, nodes in part.solids:
        known = (each for each in (part.values, part.along, part.upward) if each is not None)
        fields = ((each[nodes] * units)[None] for each in known)
        of_solid = densities(solid, frequency, *fields)
        for name in Densities.__annotations__:
            getattr(whole, name)[lines][nodes] = getattr(of_solid, name)[0]


@dataclass(frozen=True)
class _Part:
    """Scaled fields on some lines of the grid: values (lines, nodes, 4), their derivatives per m if requested."""

    x: np.ndarray
    values: np.ndarray
    along: np.ndarray | None
    upward: np.ndarray | None = None  # None: by the polynomials of the section's elements
    # True at nodes in a solid, (lines, nodes) or (1, 1)
    inside: np.ndarray = field(default_factory=lambda: np.ones((1, 1), dtype=bool))
    solids: tuple[tuple[Solid, np.ndarray], ...] = ()  # others than the stator's, and the nodes in them

    def on_lines(self, which) -> "_Part":
        """The part on some of its lines."""
        along, upward = (None if each is None else each[which] for each in (self.along, self.upward))
        inside = self.inside if len(self.inside) == 1 else self.inside[which]
        solids = tuple((solid, nodes[which]) for solid, nodes in self.solids)
        return _Part(self.x[which], self.values[which], along, upward, inside, solids)

    def upward_slopes(self, section, depth: np.ndarray) -> np.ndarray:
        """Derivatives along z per m."""
        if self.upward is not None:
            return self.upward
        return upward_slope(self.values, section.order, np.diff(depth[:: section.order]))


def _in_piece(solution: Solution, piece: CondensedPiece, depth: np.ndarray, step: float, *, slopes: bool) -> _Part:
    """Fields of a condensed piece: on the lines of its columns, or on even lines through its mesh."""
    inside = recovered(solution, piece.index)
    if isinstance(inside, ColumnsField):
        return _Part(*_in_columns(solution, piece.index, slopes=slopes))
    unit = solution.fields.section.length_unit
    x = _lines(piece.start, piece.stop, step, ())
    points = np.stack(np.meshgrid(x - piece.start, depth, indexing="ij"), axis=-1).reshape(-1, 2) / unit
    values, along, upward, group = inside.at(points)
    shape = (len(x), len(depth))
    values, along, upward = (each.reshape(*shape, 4) for each in (values, along / unit, upward / unit))
    group = group.reshape(shape)
    if not slopes:
        return _Part(x, values, None, inside=group != "")
    solids = tuple((solid, group == name) for name, solid in inside.assembly.piece.solids)
    return _Part(x, values, along, upward, group != "", solids)


def _on_mesh(solution: Solution, piece: CondensedPiece, step: float, offset: complex, *, energies: bool) -> PieceField:
    """Field on the elements of a mesh, cut into quadrilaterals of the grid's step (m) or a little more."""
    inside, section = recovered(solution, piece.index), solution.fields.section.full
    unit, frequency = section.length_unit, solution.fields.frequency
    corners = inside.assembly.space.mesh.points[inside.assembly.space.mesh.quads[:, :4]]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max()
    count = int(np.clip(np.ceil(longest / step), 1, MAX_CUTS))
    even = np.linspace(0.0, 1.0, count + 1)
    reference = np.stack(np.meshgrid(even, even, indexing="ij"), axis=-1).reshape(-1, 2)
    corner = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    cut = np.stack([corner, corner + count + 1, corner + count + 2, corner + 1], axis=1)
    # Equal pieces share the assembly of the first one: its solids are those of this piece, its position is not.
    solids = {"stator": solution.fields.stator.solid} | dict(inside.assembly.piece.solids)
    points, values, by_solid = [], [], []
    for name, positions, fields in inside.on_elements(reference):
        fields[0, ..., 3] += offset
        fields *= section.field_units
        points.append(positions.reshape(-1, 2) * unit + [piece.start, 0.0])
        values.append(fields[0].reshape(-1, 4))
        if energies:
            by_solid.append(densities(solids[name], frequency, fields[0], fields[1] / unit, fields[2] / unit))
    flat = np.concatenate(values)
    return PieceField(
        span=(piece.start, piece.stop),
        points=np.concatenate(points),
        quads=(np.arange(len(flat) // len(reference))[:, None, None] * len(reference) + cut).reshape(-1, 4),
        displacement=flat[:, :3],
        potential=flat[:, 3],
        densities=flattened(by_solid) if energies else None,
    )


def free_field(
    wave: FreeWave, *, span: tuple[float, float], per_wavelength: float = 24, energies: bool = False
) -> WaveField:
    """Return the field of a free wave over a length.

    Parameters
    ----------
    wave : FreeWave
        u_z = 1 m at the surface at x = 0.
    span : tuple of float
        m.
    per_wavelength : float
        Lines per wavelength.
    energies : bool
        True to compute strain energy and power flow too.

    Returns
    -------
    WaveField
        Over u_z at the surface.
    """
    wavelength = wave.velocity / wave.frequency
    x = _lines(*span, wavelength / per_wavelength, ())
    exponent = -(2j * np.pi / wavelength + wave.attenuation)
    values = np.exp(exponent * x)[:, None, None] * wave.profile
    field_densities = None
    if energies:
        ends = wave.depth[:: wave.order]
        field_densities = layered_densities(wave.solids, wave.frequency, values, exponent * values, ends)
    return WaveField(
        x=x,
        z=wave.depth,
        displacement=values[:, :, :3],
        potential=values[:, :, 3],
        frequency=wave.frequency,
        order=wave.order,
        densities=field_densities,
    )


def _lines(start: float, stop: float, step: float, positions) -> np.ndarray:
    """Evenly spaced lines of a segment, and lines at the requested positions in it."""
    even = np.linspace(start, stop, max(MIN_INTERVALS, int(np.ceil((stop - start) / step))) + 1)
    requested = np.array([x for x in positions if start + SAME_LINE * step < x < stop - SAME_LINE * step])
    if not len(requested):
        return even
    replaced = abs(even[:, None] - requested).min(axis=1) < REPLACED * step
    replaced[[0, -1]] = False
    return np.union1d(even[~replaced], requested)


def _constant_shape(solution: Solution) -> tuple[int, complex, complex] | None:
    """Index of the mode of constant potential and its potentials to the right and left; None if grounded."""
    modes = solution.fields.modes
    constant = np.flatnonzero(modes.wavenumbers == 0)
    if not len(constant):
        return None
    index, surface = int(constant[0]), solution.fields.section.full.surface_dofs["phi"]
    lift = solution.fields.section.lift
    right, left = (complex(lift(shapes[:, index])[surface]) for shapes in (modes.right, modes.left))
    return index, right, left


def _gauge_step(solution: Solution, piece) -> complex:
    """Mean potential of the transducer to the right of a segment minus that of the one to its left, scaled."""
    constant = _constant_shape(solution)
    if constant is None or not np.isfinite(piece.stop):
        return 0.0
    index, rightwards, leftwards = constant
    return rightwards * piece.right[index] - leftwards * piece.left[index]


def _between(solution: Solution, piece, x: np.ndarray, *, first: bool, slopes: bool):
    """Fields of a segment at lines x, (lines, nodes, 4), and their x derivatives per m if requested."""
    modes = solution.fields.modes
    right, left = piece.right.copy(), piece.left.copy()
    constant = _constant_shape(solution)
    if constant is not None:
        # Potentials refer to the transducer on the left; before the first one, to that.
        (right if first else left)[constant[0]] = 0.0
    lines = along = np.zeros((len(modes.right), len(x)), dtype=complex)
    for amplitudes, shapes, wavenumbers, origin in (
        (right, modes.right, piece.wavenumbers, piece.start),
        (left, modes.left, piece.backwards, piece.stop),
    ):
        if not np.any(amplitudes):
            continue
        phases = amplitudes[:, None] * np.exp(-1j * np.outer(wavenumbers, x - origin))
        lines = lines + shapes @ phases
        if slopes:
            along = along + shapes @ (-1j * wavenumbers[:, None] * phases)
    section = solution.fields.section
    on_nodes = section.full.on_nodes
    return on_nodes(section.lift(lines)), on_nodes(section.lift(along)) if slopes else None


def _in_columns(solution: Solution, index: int, *, slopes: bool):
    """Lines of a transducer's or an end's columns in m, fields there (lines, nodes, 4), and x derivatives per m."""
    section = solution.fields.section.full
    order = section.order
    start, width, values = columns_in_order(
        solution, index, lambda column, sides: column.values(sides)[:, section.body]
    )
    nodes = gll_nodes(order)
    x = np.append((start[:, None] + width[:, None] * nodes[:-1]).ravel(), start[-1] + width[-1])
    along = None
    if slopes:
        _, slope = lagrange(order, nodes)
        along = shared(np.einsum("ij,pj...->pi...", slope, values) / width[:, None, None, None], axis=0)
    joined = np.concatenate([values[:, :-1].reshape(-1, *values.shape[2:]), values[-1:, -1]])
    return x, joined, along
