"""Interface between a mesh and the uniform stator: L2 projection from the section's line to the mesh (mortar method).

The unknowns of the section's line are the master and those of the mesh the slave (Bernardi, Maday and Patera 1994).
With phi_i the functions of the mesh on the interface and psi_j those of the line,

    u_mesh = P u_line,    P = M^-1 B,    M_ik = int mu_i phi_k dz,    B_ij = int mu_i psi_j dz,            (1)

The multipliers are mu_i = phi_i, except next to a vertex that is fixed at zero (at a clamped or grounded bottom).  The
flux does not vanish there, and the mu_i must be able to represent it: the hat function of the fixed vertex replaces the
function of highest order of its edge.  On a line graded towards a clamped bottom the error is 1e-4 with the phi_i alone
and 2e-8 with the mu_i.  The integrals are exact, because they are taken over the union of both sets of breakpoints.
With A the matrix of the condensed mesh, P^T A P is symmetric, reciprocal and conserves energy whatever P is.  An error
in P can therefore be detected only by comparison with the same segment without a mesh.
"""

import numpy as np
from numpy.polynomial import legendre

from fem.discretize.quad_elements import QuadSpace
from fem.discretize.section import FIELD_COLUMN, Section
from fem.discretize.spectral import lagrange

SAME_CUT = 1e-12  # length units: breakpoints nearer to each other than this are one breakpoint


def line_projection(
    space: QuadSpace, edges: np.ndarray, section: Section, held: dict[str, np.ndarray]
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """For each field, the free functions of the mesh on an interface, and P from the section's line to them.

    Parameters
    ----------
    space : QuadSpace
    edges : ndarray, shape (m, 2)
        Directed edges of the interface.
    section : Section
        Of the uniform segment beside it.
    held : dict
        For each field, True for functions of the mesh that are fixed at zero or tied to an electrode, shape
        (functions of vertices and edges of the mesh,).

    Returns
    -------
    dict
        By field: numbers of the free functions, and P of equation (1), shape (free functions, n).
    """
    # ``functions``: numbers in the mesh of all functions on the interface.  ``position``: for each edge, the positions
    # of its functions in that list, shape (edges, order + 1).
    functions, position = np.unique(space.edge_numbers(edges), return_inverse=True)
    position = position.reshape(len(edges), -1)
    heights = (space.mesh.points[:, 1] - space.mesh.points[np.unique(edges), 1].max()) / space.unit
    edge_ends = heights[edges]
    first_element = section.bottom // section.order
    element_ends = section.breakpoints[first_element : section.surface // section.order + 1]
    z, weights, middle = _quadrature(element_ends, edge_ends, max(space.order, section.order) + 1)

    low, high = edge_ends.min(axis=1), edge_ends.max(axis=1)
    edge = np.argmax((low < middle[:, None]) & (middle[:, None] < high), axis=1)
    along = (z - edge_ends[edge, 0]) / (edge_ends[edge, 1] - edge_ends[edge, 0])
    of_mesh = np.zeros((len(z), len(functions)))
    np.put_along_axis(of_mesh, position[edge], space.edge_values(along), axis=1)

    element = np.searchsorted(element_ends, middle) - 1
    local = (z - element_ends[element]) / (element_ends[element + 1] - element_ends[element])
    of_element, _ = lagrange(section.order, local)
    nodes = (first_element + element)[:, None] * section.order + np.arange(section.order + 1)

    result = {}
    for name, fixed in held.items():
        free = ~fixed[functions]
        multipliers = _multipliers(free, position)
        unknowns = section.dofs[nodes, FIELD_COLUMN[name]]
        of_line = np.zeros((len(z), section.size + 1))  # the last column: nodes without an unknown
        np.put_along_axis(of_line, np.where(unknowns >= 0, unknowns, section.size), of_element, axis=1)
        tested = of_mesh[:, multipliers].T * weights
        result[name] = functions[free], np.linalg.solve(tested @ of_mesh[:, free], tested @ of_line[:, :-1])
    return result


def _quadrature(
    element_ends: np.ndarray, edge_ends: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gauss points of the parts between all breakpoints, their weights, and the middle of the part of each point."""
    cuts = np.sort(np.concatenate([element_ends, edge_ends.ravel()]).clip(element_ends[0], element_ends[-1]))
    cuts = cuts[np.append(True, np.diff(cuts) > SAME_CUT)]
    points, weights = legendre.leggauss(count)
    z = (cuts[:-1, None] + np.diff(cuts)[:, None] * (points + 1) / 2).ravel()
    return z, (np.diff(cuts)[:, None] * weights / 2).ravel(), np.repeat((cuts[:-1] + cuts[1:]) / 2, count)


def _multipliers(free: np.ndarray, position: np.ndarray) -> np.ndarray:
    """True for the functions of the interface that serve as multipliers mu_i, as many as are ``free``.

    ``position``: of each edge's functions among those of the interface: both vertices, then rising order.
    """
    is_multiplier = free.copy()
    for own in position:
        fixed_vertices = own[:2][~free[own[:2]]]
        is_multiplier[fixed_vertices] = True
        is_multiplier[own[len(own) - len(fixed_vertices) :]] = False
    return is_multiplier
