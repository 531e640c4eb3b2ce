"""The whole stator as one sparse problem: an independent check of the structured solver.

scikit-fem assembles a tensor mesh of quadrilaterals over the whole section with its own hierarchical basis and
quadrature.  A sparse direct solver factorises it: MKL Pardiso for complex symmetric matrices if `pypardiso` is
installed, SuperLU in symmetric mode otherwise (one BLAS thread; it runs out of memory beyond 3e5 unknowns).  Only the
coefficients of the weak form and, for absorbing ends, the matrices of the ends are shared with the structured solver.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from scipy.sparse import csr_matrix, identity, kron, triu
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementQuadP, MappingIsoparametric, MeshQuad

from fem.condense.electrode_conditions import electrode_potentials, is_port, transducer_ports
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution, edge_layers, graded
from fem.discretize.section import FIELD_COLUMN, Section
from fem.geometry import Stator, Transducer, outer_gaps
from fem.layout import check_layout
from fem.materials.medium import Medium, media, units
from fem.waveguide.guided_modes import guided_modes
from fem.waveguide.port_fields import charge_currents

MATRIX_TYPE = 6  # of Pardiso: complex symmetric
# Raised without pypardiso, without MKL, or by another version of pypardiso's private interface
MISSING = (ImportError, AttributeError, TypeError, OSError)


@dataclass(frozen=True, kw_only=True)
class DirectSolution:
    """Fields per volt at each port, the other ports at zero."""

    names: tuple[str, ...]  # transducers that are ports, from left to right
    admittances: np.ndarray  # shape (ports, ports): short-circuit admittance matrix, S
    unknowns: int
    # positions x (m) -> u_x and u_z in m per V at each port, shape (2, positions, ports)
    surface: Callable = field(repr=False)


@dataclass(frozen=True, kw_only=True)
class _Strips:
    """The same with one potential per electrode and per open strip; reactions int grad psi . D, C/m per volt."""

    charges: np.ndarray
    unknowns: int
    surface: Callable


def direct_solution(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    *,
    frequency: float,
    resolution: Resolution,
    wavelength: float,
    segment_size: float = 0.5,
    segment_layers: int = 0,
) -> DirectSolution:
    """Solve the driven stator by brute force.

    Parameters
    ----------
    stator : Stator
        Bottom free, grounded or clamped; nothing above.
    transducers, frequency, resolution
        As in `solve_driven`.
    wavelength : float
        Length unit in m, the slowest bulk wave's.
    segment_size, segment_layers : float, int
        Largest element in the uniform segments, wavelengths, and geometric layers towards both ends of each, where
        evanescent fields vary fast.
    """
    check_layout(stator, transducers)
    if stator.absorbs_below or stator.above != "none" or stator.pieces:
        raise ValueError("the direct solver takes a stator with a real bottom, nothing above and no meshed pieces")
    if any(each.bond or each.solid.conducting for each in stator.layers):
        raise ValueError("the direct solver takes no bonds and no metal layers")
    transducers = tuple(sorted(transducers, key=lambda transducer: transducer.center))
    names = stator.fields
    section = discretise(
        stator,
        resolution,
        wavelength=wavelength,
        surface_scale=min(transducer.finger_width / 2 for transducer in transducers),
    )
    across = _x_lines(stator, transducers, resolution, wavelength, (segment_layers, segment_size))
    mesh = MeshQuad.init_tensor(across, section.breakpoints)
    mapping = MappingIsoparametric(mesh, mesh.elem(), mesh.bndelem)
    # exact in one step on rectangles; rounding of the later steps exceeds the default 1e-12 in narrow cells
    mapping.invF = partial(mapping.invF, newton_tol=1e-6)
    basis = Basis(mesh, ElementQuadP(resolution.order), mapping, intorder=2 * resolution.order)
    height = np.searchsorted(section.breakpoints, mesh.p[1, mesh.t].mean(axis=0)) - 1
    owners = np.array(section.owners)[height]
    system = sum(
        _assembled(
            Basis(mesh, basis.elem, mapping, intorder=2 * resolution.order, elements=np.flatnonzero(owners == number)),
            body,
            2 * np.pi * frequency * wavelength,
        )
        for number, body in enumerate(media(stator.solids, names))
    )
    if stator.ends == "absorbing":
        modes = guided_modes(section, frequency)
        for position, ends in ((across[0], modes.left_impedance), (across[-1], modes.right_impedance)):
            system = system - _at_line(basis, section, position, ends)
    plane = section.breakpoints[section.plane // section.order]
    electrodes = _electrode_dofs(basis, transducers, wavelength, plane, len(names), names.index("phi"))
    held = _held_dofs(basis, stator, names, section.breakpoints[0], across[[0, -1]])
    reduced = _reduced_solution(system, basis, names, electrodes, held, wavelength, units(*stator.solids))
    return _by_port(reduced, transducers, frequency)


def _by_port(by_strip: _Strips, transducers: tuple[Transducer, ...], frequency: float) -> DirectSolution:
    """Eliminate strips: open strips, and the two electrodes of a transducer together, carry no net charge."""
    total, columns, uncharged = len(by_strip.charges), [], []
    at = 0
    for transducer in transducers:
        own = electrode_potentials(transducer, transducer_ports(transducer, mean=False))
        column = np.zeros((total, own.shape[1]))
        column[at : at + 2] = own
        columns.append(column)
        electrodes = [float(sign in transducer.signs) for sign in "+-"]
        if any(electrodes):
            uncharged.append(np.eye(total)[:, at : at + 2] @ electrodes)
        strips = transducer.signs.count("o")
        uncharged += list(np.eye(total)[at + 2 : at + 2 + strips])
        at += 2 + strips
    ports = np.hstack(columns)
    if uncharged:
        free = np.stack(uncharged, axis=1)
        among = free.T @ by_strip.charges @ free
        ports = ports - free @ np.linalg.pinv(among, rcond=1e-8) @ (free.T @ by_strip.charges @ ports)
    two = [each for each in transducers if is_port(each)]
    charges = ports.T @ by_strip.charges @ ports
    return DirectSolution(
        names=tuple(each.name for each in two),
        admittances=charge_currents(charges * np.minimum.outer(*2 * [[each.aperture for each in two]]), frequency),
        unknowns=by_strip.unknowns,
        surface=lambda positions: by_strip.surface(positions) @ ports,
    )


def _x_lines(stator, transducers, resolution, wavelength, segment) -> np.ndarray:
    """Element ends along x in length units: graded to every finger edge, even in the segments between."""
    largest = resolution.element_size
    sizes: list[np.ndarray] = []
    here = 0.0
    for transducer, gaps in zip(transducers, outer_gaps(stator, transducers), strict=True):
        fingers = transducer.fingers / wavelength
        halves = [gap / wavelength for gap in gaps]
        halves += [transducer.half_gap / wavelength, transducer.finger_width / 2 / wavelength]
        *outer_layers, gap_layers, finger_layers = (edge_layers(resolution, half, min(halves)) for half in halves)
        before, after = (
            graded(half, layers, largest=largest, smallest_first=later)
            for half, layers, later in zip(halves[:2], outer_layers, (False, True), strict=True)
        )
        sizes += [_both_graded(fingers[0, 0] - before.sum() - here, *segment), before]
        for number, (left, right) in enumerate(fingers):
            if number:
                sizes.append(_both_graded(left - fingers[number - 1, 1], gap_layers, largest))
            sizes.append(_both_graded(right - left, finger_layers, largest))
        sizes.append(after)
        here = fingers[-1, 1] + after.sum()
    sizes.append(_both_graded(stator.length / wavelength - here, *segment))
    return np.append(0.0, np.cumsum(np.concatenate(sizes)))


def _both_graded(length, layers, largest) -> np.ndarray:
    half = graded(length / 2, layers, largest=largest)
    return np.concatenate([half[::-1], half])


def _assembled(basis, body: Medium, angular: float):
    """System matrix over (scalar unknown, field), fields innermost: real scalar matrices times small tables."""
    xx, xz, zz, mass = (form.assemble(basis) for form in scikit_fem_derivatives())
    tables = (body.xx, body.xz, body.zz, -(angular**2) * np.diag(body.inertia))
    parts = [kron(matrix, csr_matrix(table)) for matrix, table in zip((xx, xz, zz, mass), tables, strict=True)]
    return (sum(parts) + kron(xz.T, csr_matrix(body.xz.T))).tocsr()


def scikit_fem_derivatives():
    """Scalar forms (d_x v)(d_x u), (d_x v)(d_z u), (d_z v)(d_z u) and v u for a scikit-fem basis in (x, z).

    All are real: complex factors are contained in the tables of moduli that multiply them.
    """
    return (
        BilinearForm(lambda u, v, _: v.grad[0] * u.grad[0]),
        BilinearForm(lambda u, v, _: v.grad[0] * u.grad[1]),
        BilinearForm(lambda u, v, _: v.grad[1] * u.grad[1]),
        BilinearForm(lambda u, v, _: v * u),
    )


def _at_line(basis, section: Section, position: float, ends: np.ndarray):
    """An end's matrix over the section's nodes, carried over to the hierarchical basis of the mesh."""
    nodes = section.nodes / section.length_unit
    probes = basis.probes(np.stack([np.full(len(nodes), position), nodes])).tocsr()
    columns = [FIELD_COLUMN[name] for name in section.solid.fields]
    dofs = section.dofs[:, columns].reshape(-1)
    carried = kron(probes, identity(len(columns))).tocsr()[np.flatnonzero(dofs >= 0)]
    return carried.T @ csr_matrix(ends) @ carried


def _electrode_dofs(basis, transducers, wavelength, plane, count, phi) -> list[tuple[np.ndarray, np.ndarray]]:
    """Potential unknowns of each electrode at z = ``plane``: vertices carry its value, the edges' bubbles vanish."""
    mesh = basis.mesh
    electrodes = []
    for transducer in transducers:
        groups = [transducer.strips("+"), transducer.strips("-"), *(strip[None] for strip in transducer.strips("o"))]
        for group in groups:
            edges = group / wavelength
            facets = mesh.facets_satisfying(
                lambda x, edges=edges: (
                    (abs(x[1] - plane) < 1e-12) & np.any((x[0] > edges[:, :1]) & (x[0] < edges[:, 1:]), axis=0)
                )
            )
            if not len(facets):
                electrodes.append((np.empty(0, dtype=int), np.empty(0, dtype=int)))
                continue
            dofs = basis.get_dofs(facets)
            vertices = np.unique(next(iter(dofs.nodal.values())))
            electrodes.append((vertices * count + phi, np.setdiff1d(dofs.flatten(), vertices) * count + phi))
    return electrodes


def _held_dofs(basis, stator, names, depth, ends) -> np.ndarray:
    """Unknowns that are zero at the bottom and at clamped ends."""
    moving = [name for name in names if name != "phi"]
    sides: list[tuple[Callable, list[str]]] = [
        (lambda x: abs(x[1] - depth), {"clamped": moving, "grounded": ["phi"]}.get(stator.bottom, []))
    ]
    if stator.ends == "clamped":
        sides += [(lambda x, end=end: abs(x[0] - end), moving) for end in ends]
    held = [np.empty(0, dtype=int)]
    for distance, fields_held in sides:
        facets = basis.mesh.facets_satisfying(lambda x, distance=distance: distance(x) < 1e-9 * abs(depth))
        dofs = basis.get_dofs(facets).flatten()
        held += [dofs * len(names) + names.index(name) for name in fields_held]
    return np.unique(np.concatenate(held))


def _reduced_solution(system, basis, names, electrodes, held, wavelength, unit_pair) -> _Strips:
    """Solve with one potential per electrode; ``held``: unknowns that are zero, ``unit_pair``: of stress and phi."""
    stress, potential = unit_pair
    size = system.shape[0]
    # Every electrode's vertices share one unknown; what is held or vanishes is left out.
    target = np.arange(size)
    gone = np.zeros(size, dtype=bool)
    gone[held] = True
    for index, (vertices, bubbles) in enumerate(electrodes):
        target[vertices] = size + index
        gone[bubbles] = True
    keep = np.flatnonzero(~gone)
    expand = csr_matrix((np.ones(len(keep)), (keep, target[keep])), shape=(size, size + len(electrodes)))
    reduced = (expand.T @ system @ expand).tocsr()
    free = np.setdiff1d(np.unique(target[keep]), size + np.arange(len(electrodes)))
    fixed = size + np.arange(len(electrodes))
    inner = reduced[free][:, free].tocsc()
    load = -reduced[free][:, fixed].toarray()
    solution = np.zeros((size + len(electrodes), len(electrodes)), dtype=complex)
    solution[free] = sparse_solution(inner, load)
    solution[fixed] = np.eye(len(electrodes))
    charges = reduced[fixed] @ solution * (stress / potential**2)
    nodal = expand @ solution / potential

    def surface(positions: np.ndarray) -> np.ndarray:
        points = np.stack([np.asarray(positions) / wavelength, np.zeros(len(positions))])
        probes = basis.probes(points)
        return np.stack([probes @ nodal[names.index(name) :: len(names)] for name in ("ux", "uz")])

    return _Strips(charges=charges, unknowns=len(free), surface=surface)


def sparse_solution(matrix, load: np.ndarray) -> np.ndarray:
    """Solve a sparse complex symmetric system (n, n) for loads (n, m), shape (n, m)."""
    try:
        return _pardiso_solution(matrix, load)
    except MISSING:
        symmetric = {"permc_spec": "MMD_AT_PLUS_A", "options": {"SymmetricMode": True}}
        factor = splu(matrix.tocsc().astype(complex), diag_pivot_thresh=0.01, **symmetric)
        return factor.solve(np.asarray(load, dtype=complex))


def _upper(matrix):
    upper = triu(matrix, format="csr").astype(complex)
    upper.sort_indices()
    return upper


def _pardiso_solution(matrix, load: np.ndarray) -> np.ndarray:
    """Solve with MKL Pardiso; the public ``solve`` of pypardiso takes float64 only."""
    from pypardiso import PyPardisoSolver

    solver = PyPardisoSolver(mtype=MATRIX_TYPE, phase=13)
    answer = solver._call_pardiso(_upper(matrix), np.asfortranarray(load, dtype=complex))  # noqa: SLF001 - see above
    solver.free_memory(everything=True)
    return answer
