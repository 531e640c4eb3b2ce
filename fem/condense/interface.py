"""Interface between a mesh and the uniform stator: L2 projection from the section's line to the mesh (mortar method).

The unknowns of the section's line are the master and those of the mesh the slave (Bernardi, Maday and Patera 1994).
With phi_i the functions of the mesh on the interface and psi_j those of the line,

    u_mesh = P u_line,    P = M^-1 B,    M_ik = int mu_i phi_k dz,    B_ij = int mu_i psi_j dz,

The multipliers are mu_i = phi_i, except next to a vertex that is fixed at zero (at a clamped or grounded bottom).  The
flux does not vanish there, and the mu_i must be able to represent it: the hat function of the fixed vertex replaces the
function of highest order of its edge.  On a line graded towards a clamped bottom the error is 1e-4 with the phi_i alone
and 2e-8 with the mu_i.  The integrals are exact, because they are taken over the union of both sets of breakpoints.
P^T A P is symmetric, reciprocal and conserves energy whatever P is.  An error in P can therefore be detected only by
comparison with the same segment without a mesh.
"""

import numpy as np
from numpy.polynomial import legendre

from fem.discretize.quads import QuadSpace
from fem.discretize.section import FIELD_COLUMN, Section
from fem.discretize.spectral import lagrange

SAME_CUT = 1e-12  # length units: breakpoints nearer to each other than this are one breakpoint


def line_projection(
    space: QuadSpace, edges: np.ndarray, section: Section, held: dict[str, np.ndarray]
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """For each field, the free functions of the mesh on an interface, and P from the section's line to them.

    ``edges``: directed edges of the interface, (m, 2); ``held``: for each field, True for functions of the mesh that
    are fixed at zero or tied to an electrode, (skeleton,).  P has the shape (functions, n).
    """
    numbers, place = np.unique(space.edge_numbers(edges), return_inverse=True)
    heights = (space.mesh.points[:, 1] - space.mesh.points[np.unique(edges), 1].max()) / space.unit
    ends = heights[edges]
    first = section.bottom // section.order
    body = section.breakpoints[first : section.surface // section.order + 1]
    cuts = np.sort(np.concatenate([body, ends.ravel()]).clip(body[0], body[-1]))
    cuts = cuts[np.append(True, np.diff(cuts) > SAME_CUT)]
    points, weights = legendre.leggauss(max(space.order, section.order) + 1)
    z = (cuts[:-1, None] + np.diff(cuts)[:, None] * (points + 1) / 2).ravel()
    measure = (np.diff(cuts)[:, None] * weights / 2).ravel()
    middle = np.repeat((cuts[:-1] + cuts[1:]) / 2, len(points))
    edge = np.argmax((ends.min(axis=1) < middle[:, None]) & (middle[:, None] < ends.max(axis=1)), axis=1)
    element = np.searchsorted(body, middle) - 1
    of_mesh = np.zeros((len(z), len(numbers)))
    values = space.edge_values((z - ends[edge, 0]) / (ends[edge, 1] - ends[edge, 0]))
    np.put_along_axis(of_mesh, place.reshape(len(edges), -1)[edge], values, axis=1)
    local = (z - body[element]) / (body[element + 1] - body[element])
    nodes = (first + element)[:, None] * section.order + np.arange(section.order + 1)
    of_line, _ = lagrange(section.order, local)
    result = {}
    for field, gone in held.items():
        free, tested = ~gone[numbers], ~gone[numbers]
        for own in place.reshape(len(edges), -1):
            hats = own[:2][~free[own[:2]]]
            tested[hats] = True
            tested[own[len(own) - len(hats) :]] = False
        dofs = section.dofs[nodes, FIELD_COLUMN[field]]
        line = np.zeros((len(z), section.size + 1))
        np.put_along_axis(line, np.where(dofs >= 0, dofs, section.size), of_line, axis=1)
        mesh = of_mesh[:, tested].T * measure
        result[field] = numbers[free], np.linalg.solve(mesh @ of_mesh[:, free], mesh @ line[:, :-1])
    return result
