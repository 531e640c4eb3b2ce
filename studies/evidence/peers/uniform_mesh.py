"""The driven stator as a user of a general finite-element package would first do it: one even mesh of order 2.

Triangles P2 or quadrilaterals Q2 of scikit-fem over the whole section, lines of the mesh on every finger edge and no
refinement there, so many elements to a wavelength, a sparse direct solver.  Absorbing ends: damping layers behind
the outer transducers, x -> s x with a constant complex s (perfectly matched layers).  Of `fem` it takes the
coefficients of the weak form, the circuit and the call of the sparse solver.

Limits: as `peer`.
"""

from itertools import pairwise

import numpy as np

__all__ = ["uniform_solution"]

_GAP = 1.0  # wavelengths between the outer fingers and the damping layers
_LAYER = 4.0  # wavelengths
_STRETCH = 1 - 2j


def uniform_solution(
    stator,
    transducers,
    *,
    frequency: float,
    wavelength: float,
    per_wavelength: int,
    triangles: bool,
    place: float,
) -> tuple[complex, np.ndarray, int]:
    """Admittance of the first transducer, driven, the others open, and the motion of the surface.

    Parameters
    ----------
    stator : fem.Stator
    transducers : tuple of fem.Transducer
        From left to right; the first is driven.
    frequency : float
        Hz.
    wavelength : float
        m.
    per_wavelength : int
        Elements to a wavelength.
    triangles : bool
        P2 triangles; Q2 quadrilaterals otherwise.
    place : float
        m.

    Returns
    -------
    admittance : complex
        S.
    motion : ndarray, shape (2,)
        u_x and u_z, m per V.
    unknowns : int
    """
    from scipy.sparse import csr_matrix, identity, kron
    from skfem import Basis, BilinearForm, ElementQuad2, ElementTriP2, MeshQuad, MeshTri

    from fem import fields, sparse_solution
    from fem.materials.medium import medium, units

    names = fields(stator.solid)
    body, count = medium(stator.solid, names), len(names)
    absorbs = stator.ends == "absorbing"
    lines, layers = _lines(stator, transducers, wavelength, per_wavelength, absorbs)
    depth = stator.thickness / wavelength
    down = np.linspace(-depth, 0.0, int(np.ceil(depth * per_wavelength)) + 1)
    kind, element = (MeshTri, ElementTriP2()) if triangles else (MeshQuad, ElementQuad2())
    basis = Basis(kind.init_tensor(lines, down), element, intorder=4)

    def stretched(x):
        return np.where((x > layers[0]) & (x < layers[1]), 1.0, _STRETCH if absorbs else 1.0)

    forms = (
        (lambda u, v, w: u.grad[0] * v.grad[0] / stretched(w.x[0]), body.xx),
        (lambda u, v, w: u.grad[1] * v.grad[0], body.xz),
        (lambda u, v, w: u.grad[0] * v.grad[1], body.xz.T),
        (lambda u, v, w: u.grad[1] * v.grad[1] * stretched(w.x[0]), body.zz),
        (
            lambda u, v, w: u * v * stretched(w.x[0]),
            -((2 * np.pi * frequency * wavelength) ** 2) * np.diag(body.inertia),
        ),
    )
    system = sum(
        kron(BilinearForm(form, dtype=np.complex128).assemble(basis), csr_matrix(table))
        for form, table in forms
    ).tocsr()

    # each comb is one unknown behind all others
    phi, size = names.index("phi"), system.shape[0]
    target = np.arange(size)
    combs = [transducer.strips(sign) / wavelength for transducer in transducers for sign in "+-"]
    for comb, edges in enumerate(combs):
        facets = basis.mesh.facets_satisfying(lambda x, edges=edges: _under(x, edges))
        target[basis.get_dofs(facets).flatten() * count + phi] = size + comb
    expand = csr_matrix((np.ones(size), (np.arange(size), target)), shape=(size, size + len(combs)))
    reduced = (expand.T @ system @ expand).tocsr()
    held = size + np.arange(len(combs))
    free = np.setdiff1d(np.unique(target), held)
    answers = np.zeros((size + len(combs), len(combs)), dtype=complex)
    answers[held] = identity(len(combs)).toarray()
    answers[free] = sparse_solution(reduced[free][:, free].tocsc(), -reduced[free][:, held].toarray())
    charges = reduced[held] @ answers

    weights = np.zeros(len(combs), dtype=complex)
    weights[:2] = 0.5, -0.5
    if len(combs) > 2:
        weights[2:] = np.linalg.solve(charges[2:, 2:], -charges[2:, :2] @ weights[:2])
    stress, potential = units(stator.solid)
    charge = -(charges[0] - charges[1]) @ weights / 2 * stress / potential**2
    nodal = expand @ (answers @ weights) / potential
    probe = basis.probes(np.array([[place / wavelength], [0.0]]))
    motion = np.array([(probe @ nodal[names.index(name) :: count])[0] for name in ("ux", "uz")])
    return complex(2j * np.pi * frequency * transducers[0].aperture * charge), motion, len(free)


def _under(x, edges) -> np.ndarray:
    return (abs(x[1]) < 1e-12) & np.any((x[0] > edges[:, :1]) & (x[0] < edges[:, 1:]), axis=0)


def _lines(
    stator, transducers, wavelength, per_wavelength, absorbs
) -> tuple[np.ndarray, tuple[float, float]]:
    """Vertical mesh lines and where the damping layers end and begin, wavelengths."""
    edges = np.concatenate([transducer.fingers.ravel() for transducer in transducers]) / wavelength
    first, last = (edges[0] - _GAP, edges[-1] + _GAP) if absorbs else (0.0, stator.length / wavelength)
    stops = [first, *edges, last]
    if absorbs:
        stops = [first - _LAYER, *stops, last + _LAYER]
    lines = [
        np.linspace(a, b, max(1, int(np.ceil((b - a) * per_wavelength - 1e-6))) + 1)[:-1]
        for a, b in pairwise(stops)
    ]
    return np.append(np.concatenate(lines), stops[-1]), (first, last)
