"""Where a mesh meets the uniform stator: the mesh's unknowns from those of the section's line, by L2 projection.

The line of the section is master, the mesh slave (mortar method; Bernardi, Maday and Patera 1994): with phi_i the
mesh's functions on the interface and psi_j the line's,

    u_mesh = P u_line,    P = M^-1 B,    M_ik = int phi_i phi_k dz,    B_ij = int phi_i psi_j dz,

integrated exactly over the union of both sets of breakpoints.  P^T A P keeps symmetry, reciprocity and energy whatever
P is: only a comparison with the same stretch without a mesh sees a wrong one.
"""

import itertools

import numpy as np
from numpy.polynomial import legendre

from fem.discretize.quads import QuadSpace
from fem.discretize.section import FIELD_COLUMN, Section
from fem.discretize.spectral import lagrange


def line_projection(
    space: QuadSpace, edges: np.ndarray, section: Section, field: str, free: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Functions of the mesh on an interface that are free, and P from the section's line to them, (functions, n).

    ``edges``: directed edges of the interface, (m, 2); ``free``: whether a function of the mesh is free for this field
    (it is not where the field is held or tied), (skeleton,).
    """
    numbers = space.edge_numbers(edges)
    own = np.unique(numbers)
    own = own[free[own]]
    place = np.full(space.skeleton, -1)
    place[own] = np.arange(len(own))
    mass, mixed = np.zeros((len(own), len(own))), np.zeros((len(own), section.size))
    points, weights = legendre.leggauss(max(space.order, section.order) + 1)
    points, weights = (points + 1) / 2, weights / 2
    heights = (space.mesh.points[:, 1] - space.mesh.points[np.unique(edges), 1].max()) / space.unit
    body = section.breakpoints[section.bottom // section.order : section.surface // section.order + 1]
    first = section.bottom // section.order
    for (start, stop), functions in zip(edges.tolist(), numbers, strict=True):
        low, high = sorted((heights[start], heights[stop]))
        inside = body[(body > low + 1e-12) & (body < high - 1e-12)]
        cuts = np.concatenate([[low], inside, [high]])
        here = place[functions] >= 0
        for below, above in itertools.pairwise(cuts):
            z, measure = below + (above - below) * points, (above - below) * weights
            mesh_values = space.edge_values((z - heights[start]) / (heights[stop] - heights[start]))[:, here]
            element = int(np.clip(np.searchsorted(body, (below + above) / 2) - 1, 0, len(body) - 2))
            local = (z - body[element]) / (body[element + 1] - body[element])
            line_values, _ = lagrange(section.order, local)
            nodes = (first + element) * section.order + np.arange(section.order + 1)
            dofs = section.dofs[nodes, FIELD_COLUMN[field]]
            exists = dofs >= 0
            rows = place[functions[here]]
            mass[np.ix_(rows, rows)] += mesh_values.T @ (measure[:, None] * mesh_values)
            mixed[np.ix_(rows, dofs[exists])] += mesh_values.T @ (measure[:, None] * line_values[:, exists])
    return own, np.linalg.solve(mass, mixed)
