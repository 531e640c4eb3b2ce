"""The section through the depth: its elements and unknowns, and the matrices of a uniform segment.

Nodes run upwards, from the bottom (z = -thickness) to the surface (z = 0) and on through the vacuum above, if that is
part of the model.  The complex coordinate stretching of a perfectly matched layer is a complex height of the element
and needs no change of the weak form.  Lengths here are in ``length_unit``.

A segment of the stator that is uniform in x obeys (semi-analytical finite elements; Kausel 1981; Kiefer 2022)

    - d/dx (K2 u' + K1 u) + K1t u' + (K0 - omega^2 M) u = 0,    nodal flux f = K2 u' + K1 u,

with K1t = K1^T where nothing depends on y; with a lateral wavenumber K1t(k_y) = K1(-k_y)^T.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np

from fem.discretize.graded_medium import along_x, element_line, is_bond
from fem.discretize.spectral import line_nodes, reference_matrices
from fem.materials.medium import Medium

FIELD_COLUMN = {"ux": 0, "uy": 1, "uz": 2, "phi": 3}


class LineSpace(Protocol):
    """Unknowns of a vertical line, as guided modes, networks and results use them.

    `Section` has all of them; `fem.reduce.basis.ReducedSection` those of a basis of fields, which `lift` takes
    back to the lines of the ``full`` section.
    """

    @property
    def size(self) -> int: ...  # noqa: D102

    @property
    def full(self) -> "Section": ...  # noqa: D102

    @property
    def solid(self) -> Medium: ...  # noqa: D102

    @property
    def length_unit(self) -> float: ...  # noqa: D102

    @property
    def surface_speed(self) -> float | None: ...  # noqa: D102

    @property
    def odd(self) -> np.ndarray | None: ...  # noqa: D102

    @property
    def mechanical(self) -> np.ndarray: ...  # noqa: D102

    @property
    def floating_potential(self) -> bool: ...  # noqa: D102

    @property
    def constant_potential(self) -> np.ndarray: ...  # noqa: D102

    @property
    def surface_rows(self) -> np.ndarray: ...  # noqa: D102

    def lift(self, lines: np.ndarray) -> np.ndarray:
        """Unknowns of the full section on lines, shape (full size, ...)."""

    def surface_share(self, shapes: np.ndarray) -> np.ndarray:
        """Squared motion at the surface over its integral through the depth; shapes (size, m) -> (m,)."""

    def matrices(self, frequency: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """K2, K1 and K0 - omega^2 M of a uniform segment at a frequency in Hz, each (size, size), scaled."""


@dataclass(frozen=True, kw_only=True)
class Section:
    """Discretised depth of a stator."""

    # shape (elements,): element heights from the bottom up, in length units; complex in an absorbing layer
    heights: np.ndarray
    breakpoints: np.ndarray  # shape (elements + 1,): real z of the element ends, in length units
    media: tuple[Medium, ...]
    solid: Medium  # of the stator's solid below its layers, in all fields
    owners: tuple[int, ...]  # of each element of the solid, its layers and an absorbing layer: its solid, from below
    order: int
    length_unit: float  # m
    # shape (nodes, 4): number of the unknown for ux, uy, uz, phi at a node; -1 where there is none
    dofs: np.ndarray = field(repr=False)
    surface: int  # node of the surface
    plane: int  # node of the fingers: the surface, or an interface between two layers
    bottom: int  # node of the solid's lower end: 0, or where an absorbing layer begins
    # m; shortest length over which fields vary along the surface, to which the elements below it are graded
    surface_scale: float
    # velocity of the half-space's Rayleigh wave in m/s, used to identify the surface wave among the modes;
    # None where the cut has none
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
        """Return the lines themselves: they are full."""
        return lines

    @cached_property
    def nodes(self) -> np.ndarray:
        """Real z of the nodes in m."""
        return line_nodes(self.breakpoints, self.order) * self.length_unit

    @property
    def body(self) -> slice:
        """Nodes of the solid without absorbing layer and vacuum, from its bottom to its surface."""
        return slice(self.bottom, self.surface + 1)

    def solids_of_elements(self, solids: Sequence) -> tuple:
        """Solids of the body's elements from the bottom up, of those of the stator; None for a bond."""
        elements = range(self.bottom // self.order, self.surface // self.order)
        return tuple(None if is_bond(self.media[k]) else solids[self.owners[k]] for k in elements)

    def on_nodes(self, lines: np.ndarray) -> np.ndarray:
        """Scaled u_x, u_y, u_z and phi at the body's nodes for unknowns of lines (size, m): shape (m, nodes, 4)."""
        dofs = self.dofs[self.body]
        out = np.zeros((lines.shape[1], *dofs.shape), dtype=complex)
        exists = dofs >= 0
        out[:, exists] = np.moveaxis(lines[dofs[exists]], 0, 1)
        self.fill_bonds(out, self.bottom // self.order)
        return out

    def fill_bonds(self, values: np.ndarray, first: int = 0) -> None:
        """Set values (..., nodes, 4) between the faces of bonds to the mean of both; ``first``: first element."""
        for element, medium in enumerate(self.media[first : len(self.owners)]):
            if is_bond(medium):
                low, high = element * self.order, (element + 1) * self.order
                values[..., low + 1 : high, :] = 0.5 * (values[..., [low], :] + values[..., [high], :])

    @property
    def field_units(self) -> np.ndarray:
        """Factors from scaled u_x, u_y, u_z and phi to m and V."""
        return np.array([1.0, 1.0, 1.0, self.solid.potential_unit])

    @cached_property
    def surface_dofs(self) -> dict[str, int]:
        """Unknowns at the surface node by field."""
        return {name: int(self.dofs[self.surface, FIELD_COLUMN[name]]) for name in self.solid.fields}

    @property
    def finger_potential(self) -> int | None:
        """Unknown of the potential at the node of the fingers; None where the stator has no potential."""
        unknown = int(self.dofs[self.plane, FIELD_COLUMN["phi"]])
        return unknown if unknown >= 0 else None

    @cached_property
    def surface_rows(self) -> np.ndarray:
        """Matrix that selects u_x and u_z at the surface from a line's unknowns, shape (2, size)."""
        rows = np.zeros((2, self.size))
        rows[[0, 1], [self.surface_dofs["ux"], self.surface_dofs["uz"]]] = 1.0
        return rows

    def surface_share(self, shapes: np.ndarray) -> np.ndarray:
        """Squared motion at the surface over its integral through the depth."""
        inside = self.motion_weights @ abs(shapes) ** 2
        above = np.sum(abs(self.surface_rows @ shapes) ** 2, axis=0)
        return np.divide(above, inside, out=np.zeros_like(inside), where=inside > 0)  # the constant potential: 0

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
    def motion_weights(self) -> np.ndarray:
        """Quadrature weights of the displacements over the depth, (size,), in length units; zero for phi.

        In an absorbing layer the depth is that of the stretched coordinate, in absolute value.
        """
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
        return "phi" in self.solid.fields and bool(np.all(self.dofs[:: self.order, FIELD_COLUMN["phi"]] >= 0))

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

    @cached_property
    def frequency_free_matrices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """K2, K1, K0 and M of a uniform segment, scaled, each (size, size)."""

        def of_element(height: complex, part: Medium):
            line = element_line(part, self.order)
            yield along_x(part, self.order, height)
            yield np.kron(line.advection.T, part.xz)
            yield np.kron(line.stiffness / height, part.zz)
            yield np.kron(self.length_unit**2 * height * line.mass, np.diag(part.inertia))

        dtype = np.result_type(self.heights, *(part.xx for part in self.media))
        second, first, zeroth, mass = self._assembled(of_element, dtype, 4)
        return second, first, zeroth, mass

    def matrices(self, frequency: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """K2, K1 and K0 - omega^2 M of a uniform segment at a frequency in Hz, scaled."""
        second, first, static, mass = self.frequency_free_matrices
        return second, first, static - (2 * np.pi * frequency) ** 2 * mass

    def _assembled(self, of_element: Callable, dtype, count: int) -> tuple[np.ndarray, ...]:
        """Sums over the elements of ``count`` matrices that each has, shape (size, size), read-only."""
        sums = tuple(np.zeros((self.size, self.size), dtype=dtype) for _ in range(count))
        for element, (height, part) in enumerate(zip(self.heights, self.media, strict=True)):
            dofs, exists = self.element_dofs(element)
            keep, existing = dofs[exists], np.flatnonzero(exists.ravel())
            for total, own in zip(sums, of_element(height, part), strict=True):
                total[keep[:, None], keep] += own[existing[:, None], existing]
        for total in sums:
            total.flags.writeable = False  # because its users share it
        return sums

    def lateral_matrices(self, frequency: float, wavenumber: complex) -> tuple[np.ndarray, ...]:
        """Matrices of a uniform segment for fields that vary as exp(-i k_y y), k_y in radians per length unit.

        K2, K1, its counterpart in the test functions (K1(-k_y)^T; K1^T where y -> -y is a symmetry, because the odd
        fields are then scaled by i), and K0 - omega^2 M; shape (size, size) each.
        """
        second, first, zeroth = self.matrices(frequency)
        adjoint = first.T

        def of_element(height: complex, part: Medium):
            line = element_line(part, self.order)
            tables, mass = part.lateral(wavenumber), height * line.mass
            yield np.kron(mass, tables.xy)
            yield np.kron(mass, tables.yx)
            through = np.kron(line.advection, tables.zy) + np.kron(line.advection.T, tables.yz)
            yield through + np.kron(mass, tables.yy)

        along, back, across = self._assembled(of_element, complex, 3)
        return second, *(_real_if_real(each) for each in (first + along, adjoint + back, zeroth + across))


def _real_if_real(matrix: np.ndarray) -> np.ndarray:
    return matrix if np.any(matrix.imag) else matrix.real
