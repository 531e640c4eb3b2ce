"""The section through the depth: its elements and unknowns, and the matrices of a uniform segment.

Nodes run upwards, from the bottom (z = -thickness) to the surface (z = 0) and, where the scene asks for it, on
through the vacuum.  Elements are graded geometrically towards the surface, where the charge of a finger edge is
singular (r^-1/2), by a fixed ratio per layer, and towards the bottom where a clamped face meets a free one.  An
absorbing bottom is described in absorber.py; the complex coordinate stretching of a perfectly matched layer is a
complex height of the element and needs no change of the weak form.  Lengths here are in ``length_unit``.

A segment of the stator that is uniform in x obeys (semi-analytical finite elements; Kausel 1981; Kiefer 2022)

    - d/dx (K2 u' + K1 u) + K1t u' + (K0 - omega^2 M) u = 0,    nodal flux f = K2 u' + K1 u,

with K1t = K1^T where nothing depends on y; with a lateral wavenumber K1t(k_y) = K1(-k_y)^T.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fem.analytic.half_space import rayleigh
from fem.convergence import ConvergenceError
from fem.discretize.absorber import absorber
from fem.discretize.grading import CORNER_RATIO, Resolution, bottom_corners, edge_layers, graded
from fem.discretize.spectral import line_nodes, reference_matrices
from fem.geometry import Stator
from fem.materials import fields as coupled_fields
from fem.materials.medium import Medium, medium, units, vacuum_medium

HALF_SPACE_DEPTH, MAX_DEPTH = 2.0, 8.0  # wavelengths of ordinary solid above the absorbing layer
# Wavelengths; the near field of a wider finger needs no layers of its own through the depth.
FINGER_SCALE = 0.125
MAX_UNKNOWNS, TYPICAL_ORDER = 2000, 7  # of a line; a driven stator with as many takes
MINUTES_AT_MAX = 10
# Length units; the field of a transducer without net charge decays as the square of the distance.
VACUUM_HEIGHT = 64.0


@dataclass(frozen=True, kw_only=True)
class Section:
    """Discretised depth of a stator.

    Attributes
    ----------
    heights : ndarray, shape (elements,)
        Element heights from the bottom up, in length units; complex in an absorbing layer.
    breakpoints : ndarray, shape (elements + 1,)
        Real z of the element ends, in length units.
    media : tuple of Medium, one per element
    order : int
    length_unit : float
        m.
    dofs : ndarray, shape (nodes, 4)
        Number of the unknown for ux, uy, uz, phi at a node; -1 where there is none.
    surface : int
        Node of the surface.
    bottom : int
        Node of the solid's lower end: 0, or where an absorbing layer begins.
    surface_speed : float or None
        Velocity of the half-space's Rayleigh wave in m/s, used to identify the surface wave among the modes; None
        where the cut has none.
    """

    heights: np.ndarray
    breakpoints: np.ndarray
    media: tuple[Medium, ...]
    order: int
    length_unit: float
    dofs: np.ndarray = field(repr=False)
    surface: int
    bottom: int
    surface_speed: float | None

    @property
    def size(self) -> int:
        """Unknowns on one vertical line."""
        return int(self.dofs.max()) + 1

    @property
    def full(self) -> "Section":
        """The section itself, of which nothing is reduced to a basis."""
        return self

    def lift(self, lines: np.ndarray) -> np.ndarray:
        """Unknowns of the full section on lines, shape (size, ...)."""
        return lines

    @property
    def solid(self) -> Medium:
        """Medium of the stator."""
        return self.media[0]

    @cached_property
    def nodes(self) -> np.ndarray:
        """Real z of the nodes in m."""
        return line_nodes(self.breakpoints, self.order) * self.length_unit

    @property
    def body(self) -> slice:
        """Nodes of the solid without absorbing layer and vacuum, from its bottom to its surface."""
        return slice(self.bottom, self.surface + 1)

    def on_nodes(self, lines: np.ndarray) -> np.ndarray:
        """Scaled u_x, u_y, u_z and phi at the body's nodes for unknowns of lines (size, m): shape (m, nodes, 4)."""
        dofs = self.dofs[self.body]
        out = np.zeros((lines.shape[1], *dofs.shape), dtype=complex)
        exists = dofs >= 0
        out[:, exists] = np.moveaxis(lines[dofs[exists]], 0, 1)
        return out

    @property
    def field_units(self) -> np.ndarray:
        """What scaled u_x, u_y, u_z and phi are to be multiplied by."""
        return np.array([1.0, 1.0, 1.0, self.solid.potential_unit])

    @cached_property
    def surface_dofs(self) -> dict[str, int]:
        """Unknowns at the surface node by field."""
        return {name: int(self.dofs[self.surface, FIELD_COLUMN[name]]) for name in self.solid.fields}

    @cached_property
    def surface_rows(self) -> np.ndarray:
        """Matrix that selects u_x and u_z at the surface from a line's unknowns, shape (2, size)."""
        rows = np.zeros((2, self.size))
        rows[[0, 1], [self.surface_dofs["ux"], self.surface_dofs["uz"]]] = 1.0
        return rows

    def surface_share(self, shapes: np.ndarray) -> np.ndarray:
        """Squared motion at the surface over its integral through the depth; shapes (size, m) -> (m,)."""
        return np.sum(abs(self.surface_rows @ shapes) ** 2, axis=0) / (
            self._motion_weights @ abs(shapes) ** 2
        )

    @cached_property
    def odd(self) -> np.ndarray | None:
        """Unknowns that change sign under x -> -x, shape (size,); None if the solid has no such symmetry."""
        return self._unknowns_of(self.solid.parity)

    @cached_property
    def lateral_odd(self) -> np.ndarray | None:
        """As `odd`, for fields with a lateral wavenumber."""
        return self._unknowns_of(self.solid.lateral_parity)

    def _unknowns_of(self, parity: np.ndarray | None) -> np.ndarray | None:
        """Unknowns of the fields that are odd, shape (size,)."""
        if parity is None:
            return None
        odd = np.zeros(self.size, dtype=bool)
        for name, changes in zip(self.solid.fields, parity, strict=True):
            column = self.dofs[:, FIELD_COLUMN[name]]
            odd[column[column >= 0]] = changes
        return odd

    @cached_property
    def mechanical(self) -> np.ndarray:
        """Unknowns that are displacements."""
        columns = self.dofs[:, :3]
        return columns[columns >= 0]

    @cached_property
    def _motion_weights(self) -> np.ndarray:
        """Quadrature weights of the displacements over the depth (stretched if absorbing), (size,); zero for phi."""
        weights = np.zeros(len(self.dofs))
        lumped = reference_matrices(self.order).mass.sum(axis=1)
        for element, height in enumerate(abs(self.heights)):
            weights[element * self.order : (element + 1) * self.order + 1] += height * lumped
        out = np.zeros(self.size)
        exists = self.dofs[:, :3] >= 0
        out[self.dofs[:, :3][exists]] = np.repeat(weights[:, None], 3, axis=1)[exists]
        return out

    @property
    def floating_potential(self) -> bool:
        """True if the potential floats: adding a constant to phi changes nothing in a uniform segment."""
        return "phi" in self.solid.fields and self.dofs[0, FIELD_COLUMN["phi"]] >= 0

    @cached_property
    def constant_potential(self) -> np.ndarray:
        """The field phi = 1, u = 0, shape (size,)."""
        column = self.dofs[:, FIELD_COLUMN["phi"]]
        constant = np.zeros(self.size)
        constant[column[column >= 0]] = 1.0
        return constant

    def element_dofs(self, element: int) -> tuple[np.ndarray, np.ndarray]:
        """Unknowns of an element, shape (order + 1, fields), and which of them exist."""
        here = slice(element * self.order, (element + 1) * self.order + 1)
        columns = [FIELD_COLUMN[name] for name in self.media[element].fields]
        dofs = self.dofs[here][:, columns]
        return dofs, dofs >= 0

    def matrices(self, frequency: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """K2, K1 and K0 - omega^2 M of a uniform segment at a frequency in Hz, each (size, size), scaled."""
        reference = reference_matrices(self.order)
        factor = (2 * np.pi * frequency * self.length_unit) ** 2
        dtype = np.result_type(self.heights, *(part.xx for part in self.media))
        second, first, zeroth = (np.zeros((self.size, self.size), dtype=dtype) for _ in range(3))
        for element, (height, part) in enumerate(zip(self.heights, self.media, strict=True)):
            dofs, exists = self.element_dofs(element)
            keep = dofs[exists]
            chosen = np.flatnonzero(exists.ravel())
            at, inside = np.ix_(keep, keep), np.ix_(chosen, chosen)
            mass = height * reference.mass
            second[at] += np.kron(mass, part.xx)[inside]
            first[at] += np.kron(reference.advection.T, part.xz)[inside]
            zeroth[at] += (
                np.kron(reference.stiffness / height, part.zz) - factor * np.kron(mass, np.diag(part.inertia))
            )[inside]
        return second, first, zeroth

    def lateral_matrices(self, frequency: float, wavenumber: float) -> tuple[np.ndarray, ...]:
        """Matrices of a uniform segment for fields that vary as exp(-i k_y y).

        Parameters
        ----------
        frequency : float
            Hz.
        wavenumber : float
            k_y in radians per length unit.

        Returns
        -------
        second, first, adjoint, zeroth : ndarray, shape (size, size)
            K2, K1, its counterpart in the test functions (K1(-k_y)^T; K1^T where y -> -y is a symmetry, because the
            odd fields are then scaled by i), and K0 - omega^2 M.
        """
        second, first, zeroth = self.matrices(frequency)
        adjoint = first.T
        reference = reference_matrices(self.order)
        along, back, across = (np.zeros((self.size, self.size), dtype=complex) for _ in range(3))
        for element, (height, part) in enumerate(zip(self.heights, self.media, strict=True)):
            tables = part.lateral(wavenumber)
            dofs, exists = self.element_dofs(element)
            keep = dofs[exists]
            chosen = np.flatnonzero(exists.ravel())
            at, inside = np.ix_(keep, keep), np.ix_(chosen, chosen)
            mass = height * reference.mass
            along[at] += np.kron(mass, tables.xy)[inside]
            back[at] += np.kron(mass, tables.yx)[inside]
            across[at] += (
                np.kron(reference.advection, tables.zy)
                + np.kron(reference.advection.T, tables.yz)
                + np.kron(mass, tables.yy)
            )[inside]
        return second, *(_real_if_real(each) for each in (first + along, adjoint + back, zeroth + across))


def _real_if_real(matrix: np.ndarray) -> np.ndarray:
    return matrix if np.any(matrix.imag) else matrix.real


FIELD_COLUMN = {"ux": 0, "uy": 1, "uz": 2, "phi": 3}


def discretise(
    stator: Stator,
    resolution: Resolution,
    *,
    wavelength: float,
    surface_scale: float,
    lateral: bool = False,
) -> Section:
    """Elements and unknowns through the depth of a stator.

    Parameters
    ----------
    stator : Stator
    resolution : Resolution
    wavelength : float
        Of the slowest bulk wave at the drive frequency, in m: it sets the largest element.
    surface_scale : float
        Length in m over which the surface's electrodes vary (half a finger): the graded element's height; infinite
        where there is no electrode.
    lateral : bool
        The fields will have a lateral wavenumber: all displacements, and phi of a piezoelectric solid, take part.

    Returns
    -------
    Section
    """
    names = lateral_fields(stator.solid) if lateral else coupled_fields(stator.solid)
    body = medium(stator.solid, names)
    unit = wavelength
    largest = resolution.element_size
    unknowns = stator.thickness / unit / largest * TYPICAL_ORDER * len(names)
    if unknowns > MAX_UNKNOWNS and not stator.absorbs_below:
        minutes = MINUTES_AT_MAX * (unknowns / MAX_UNKNOWNS) ** 3
        raise ConvergenceError(
            f"a section of {stator.thickness / unit:.3g} wavelengths of thickness, {stator.thickness:g} m, has "
            f"about {unknowns:.3g} unknowns on a line, takes {minutes:.2g} minutes "
            'or more and is not begun: take a thinner one, or bottom = "absorbing" where the bottom does not matter'
        )
    layers = resolution.edge_layers if np.isfinite(surface_scale) else 0
    depth = stator.thickness / unit if np.isfinite(stator.thickness) else HALF_SPACE_DEPTH
    if stator.absorbs_below:
        # Any thickness is the same half-space; too near the surface the layer errs by 1e-4.
        depth = min(max(depth, HALF_SPACE_DEPTH), MAX_DEPTH)
    scale = surface_scale / unit
    top = min(max(scale, FINGER_SCALE), depth / 2, largest) if layers else min(depth, largest)
    layers = edge_layers(resolution, top, min(scale, top)) if layers else 0
    corner_layers = resolution.edge_layers if bottom_corners(stator) and layers else 0
    pieces = []
    if depth > top * (1 + 1e-9):
        sizes = graded(depth - top, corner_layers, largest=largest, smallest_first=True, ratio=CORNER_RATIO)
        pieces.append(sizes)
    pieces.append(graded(top, layers, largest=largest))
    heights = np.concatenate(pieces)
    complex_heights = heights.astype(complex) if stator.absorbs_below else heights
    below = absorber(stator.solid, body, resolution.lossy_elements) if stator.absorbs_below else []
    heights = np.concatenate([[each.real for each, _, _ in below], heights])
    complex_heights = np.concatenate([[each * stretch for each, stretch, _ in below], complex_heights])
    solid_elements = len(heights)
    media = [each for _, _, each in below] + [body] * (solid_elements - len(below))
    if stator.above == "vacuum" and "phi" in names:
        gap = vacuum_medium(*units(stator.solid))
        sizes = list(graded(top, layers, largest=largest, smallest_first=True))
        while sum(sizes) < VACUUM_HEIGHT:
            sizes.append(min(sum(sizes), 0.5) if sum(sizes) < 2 else sum(sizes))
        heights = np.concatenate([heights, sizes])
        complex_heights = np.concatenate([complex_heights, sizes])
        media += [gap] * len(sizes)
    breakpoints = np.concatenate([[0.0], np.cumsum(heights)])
    breakpoints -= breakpoints[solid_elements]
    return Section(
        heights=complex_heights,
        breakpoints=breakpoints,
        media=tuple(media),
        order=resolution.order,
        length_unit=unit,
        dofs=_numbered(names, solid_elements, len(media), resolution.order, stator),
        surface=solid_elements * resolution.order,
        bottom=len(below) * resolution.order,
        surface_speed=_surface_speed(stator.solid),
    )


def lateral_fields(solid) -> tuple[str, ...]:
    """Fields that take part where something depends on y."""
    return ("ux", "uy", "uz", "phi") if solid.is_piezoelectric else ("ux", "uy", "uz")


def _surface_speed(solid) -> float | None:
    try:
        return rayleigh(solid, "open").velocity
    except ConvergenceError:
        return None


def _numbered(names, solid_elements, elements, order, stator) -> np.ndarray:
    exists = np.zeros((elements * order + 1, 4), dtype=bool)
    for name in names:
        exists[: solid_elements * order + 1, FIELD_COLUMN[name]] = True
    if elements > solid_elements:
        exists[solid_elements * order :, FIELD_COLUMN["phi"]] = True
    if stator.bottom == "clamped" or stator.absorbs_below:
        exists[0, :3] = False
    if stator.bottom == "grounded" or stator.absorbs_below:
        exists[0, FIELD_COLUMN["phi"]] = False
    dofs = np.full(exists.shape, -1)
    dofs[exists] = np.arange(exists.sum())
    return dofs
