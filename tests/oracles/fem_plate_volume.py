"""A plate with a short comb whose fingers end, as a three-dimensional mesh of scikit-fem: no modes, no k_y.

Hexahedra of second order with u_x, u_y, u_z and phi; a quarter of the plate, x >= 0 and y >= 0, of a ceramic poled
along z, its bottom clamped: y -> -y turns the sign of u_y, x -> -x of u_y, u_z and phi (fingers of opposite
potential).  Fingers end at y = W/2, without busbars; they carry potentials or given charges.  A perfectly matched layer
surrounds the quarter.  With ``aperture`` infinite the same mesh along x and z is one element wide and nothing depends
on y.
"""

import numpy as np
from scipy.sparse import kron
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementHex2, MeshHex

PER_PERIOD = 4  # elements
CLEAR, LAYER = 1.0, 1.5  # periods of plate beyond the points and the aperture, and of matched layer
STRENGTH = 2.5  # of the layer: s = 1 - i STRENGTH (depth / LAYER)^2


def comb_motion(
    solid,
    *,
    thickness,
    frequency,
    period,
    fingers,
    aperture,
    points,
    reactions=None,
    per_period=PER_PERIOD,
    face=np.inf,
):
    """Surface motion per volt between the fingers.

    Parameters
    ----------
    solid : object
        ``stiffness_lossy`` (6, 6), ``coupling`` (3, 6), ``permittivity_lossy`` (3, 3), ``density``; SI.
    thickness, period, aperture : float
        m; fingers of a quarter period, half a period apart, centred on x = 0.
    fingers : int
        Even.
    points : ndarray, shape (p, 2)
        x and y from the middle of the comb, m, x beyond the fingers, y multiples of half a period within the aperture
        or 0; x at one place.
    reactions : tuple of ndarray, optional
        Of the plane problem: its charges within the aperture drive the plate instead of potentials.
    face : float
        m: the plate ends at x = face (and -face), free of traction and charge; without, the layer absorbs.

    Returns
    -------
    ndarray, shape (3, p)
        u_x, u_y, u_z in m per V; of the plane problem also the reactions, places and reaction per unit of y.
    """
    stress = abs(solid.stiffness_lossy).max()
    volt = np.sqrt(stress / abs(solid.permittivity_lossy).max())  # V per m of displacement
    law = np.zeros((9, 9), dtype=complex)
    law[:6, :6] = solid.stiffness_lossy / stress
    law[6:, :6] = solid.coupling * (volt / stress)
    law[:6, 6:] = law[6:, :6].T
    law[6:, 6:] = -solid.permittivity_lossy * (volt**2 / stress)
    inertia = solid.density * (2 * np.pi * frequency * period) ** 2 / stress
    half_fingers = [(0.125 + 0.5 * number, 0.375 + 0.5 * number) for number in range(fingers // 2)]
    outer = half_fingers[-1][1]
    x_end = points[:, 0].max() / period + CLEAR
    edges = np.unique(
        np.concatenate([[0.0], np.ravel([[a, a + 0.04, (a + b) / 2, b - 0.04, b] for a, b in half_fingers])])
    )
    x_lines = np.concatenate([edges, _lines(outer, points[:, 0].max() / period, per_period)])
    x_end, x_stop = (x_end, x_end + LAYER) if np.isinf(face) else (face / period, face / period)
    x_lines = np.concatenate([x_lines, _lines(x_lines[-1], x_stop, per_period)])
    plane = not np.isfinite(aperture)
    tip = 1.0 if plane else aperture / 2 / period
    y_end = tip + CLEAR
    if plane:
        y_lines = np.array([0.0, tip])
    else:
        y_lines = np.concatenate([[0.0], *(_lines(a, a + 0.5, per_period) for a in np.arange(0, tip - 0.4, 0.5))])
        y_lines = np.concatenate([y_lines[:-1], [tip - 0.2, tip - 0.05, tip, tip + 0.05, tip + 0.2]])
        y_lines = np.concatenate([y_lines, _lines(y_lines[-1], y_end + LAYER, per_period)])
    depth = thickness / period
    z_lines = -np.array([1.0, 0.4, 0.0]) * depth
    mesh = MeshHex.init_tensor(x_lines, y_lines, z_lines)
    basis = Basis(mesh, ElementHex2(), intorder=4)

    def stretches(w):
        s_x = 1 - 1j * STRENGTH * np.clip((w.x[0] - x_end) / LAYER, 0, None) ** 2
        s_y = 1 - 1j * STRENGTH * np.clip((w.x[1] - y_end) / LAYER, 0, None) ** 2 * (not plane)
        return s_x, s_y, np.ones_like(s_x)

    def stored(i, j):
        @BilinearForm(dtype=complex)
        def form(u, v, w):
            s = stretches(w)
            return v.grad[i] / s[i] * u.grad[j] / s[j] * s[0] * s[1]

        return form.assemble(basis)

    @BilinearForm(dtype=complex)
    def mass(u, v, w):
        s = stretches(w)
        return inertia * u * v * s[0] * s[1]

    rows = [np.zeros((9, 4)) for _ in range(3)]  # d_x, d_y, d_z of u_x, u_y, u_z, phi -> S, grad phi
    for table, places in zip(rows, ((0, 5, 4, 6), (5, 1, 3, 7), (4, 3, 2, 8)), strict=True):
        table[places, range(4)] = 1.0
    matrix = -kron(mass.assemble(basis), np.diag([1.0, 1.0, 1.0, 0.0]))
    for i in range(3):
        for j in range(3):
            matrix = matrix + kron(stored(i, j), rows[i].T @ law @ rows[j])
    matrix = matrix.tocsr()
    x, y, z = np.repeat(basis.doflocs, 4, axis=1)
    component, near = np.tile(np.arange(4), basis.N), 1e-9
    held = (abs(y) < near) & (component == 1)
    held |= (abs(x) < near) & (component != 0)
    held |= (z < z_lines[0] + near) & (component < 3)
    if plane:
        held |= component == 1
    outside = (x > x_lines[-1] - near) & np.isinf(face)
    held |= (outside | ((y > y_lines[-1] - near) & (not plane))) & (component < 3)
    values, on_fingers = np.zeros(4 * basis.N, dtype=complex), np.zeros(4 * basis.N, dtype=bool)
    for number, (start, stop) in enumerate(half_fingers):
        under = (x > start - near) & (x < stop + near) & (y < tip + near) & (abs(z) < near) & (component == 3)
        values[under] = (0.5 if number % 2 == 0 else -0.5) / (volt * period)
        on_fingers |= under
    load = np.zeros(4 * basis.N, dtype=complex)
    if reactions is None:
        held |= on_fingers
    else:
        values[:] = 0.0
        nodes = np.flatnonzero(on_fingers)
        inner = y_lines[y_lines < tip + near]
        heights = np.diff(inner)
        lines = np.sort(np.append(inner, inner[:-1] + heights / 2))
        weights = np.zeros(len(lines))
        for element, height in enumerate(heights):
            weights[2 * element : 2 * element + 3] += height * np.array([1, 4, 1]) / 6
        along = np.argmin(abs(x[nodes, None] - reactions[0]), axis=1)
        across = np.argmin(abs(y[nodes, None] - lines), axis=1)
        load[nodes] = reactions[1][along] * weights[across]
    free = np.flatnonzero(~held)
    values[free] = _solved(matrix[free][:, free], load[free] - matrix[free][:, held] @ values[held])
    places = np.stack([points[:, 0], 0 * points[:, 0] if plane else points[:, 1], 0 * points[:, 0]]) / period
    vertices = [int(np.argmin(np.sum((mesh.p - place[:, None]) ** 2, axis=0))) for place in places.T]
    motion = values.reshape(-1, 4)[basis.nodal_dofs[0, vertices], :3].T * period
    if not plane:
        return motion
    nodes = np.flatnonzero(on_fingers)
    places, here = np.unique(x[nodes].round(9), return_inverse=True)
    total = np.zeros(len(places), dtype=complex)
    np.add.at(total, here, (matrix @ values)[nodes] / tip)
    return motion, (places, total)


def _lines(start: float, stop: float, per_period: float) -> np.ndarray:
    return np.linspace(start, stop, max(int(np.ceil((stop - start) * per_period)), 1) + 1)[1:]


def _solved(matrix, load):
    try:
        from tests.fem.direct import sparse_solution
    except ImportError:
        return splu(matrix.tocsc()).solve(load)
    return sparse_solution(matrix, load[:, None])[:, 0]
