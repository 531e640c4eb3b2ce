"""Crystals with four-index tensors: rotation by summation, and surface waves by search for partial waves.

Nothing here uses Bond matrices, surface impedances or a reduced Voigt form: tensors are rotated by
c'_ijkl = a_ip a_jq a_kr a_ls c_pqrs, and a surface wave is where the boundary conditions over the decaying
partial waves become singular (Campbell and Jones 1968; Farnell 1970).  exp(i(omega t - k x)), body at z < 0.
"""

import numpy as np

PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
VACUUM = 8.8541878188e-12


def stiffness_tensor(voigt: np.ndarray) -> np.ndarray:
    """c_ijkl of a 6x6 table."""
    tensor = np.empty((3, 3, 3, 3))
    for row, (i, j) in enumerate(PAIRS):
        for column, (k, m) in enumerate(PAIRS):
            for p, q in ((i, j), (j, i)):
                tensor[p, q, k, m] = tensor[p, q, m, k] = voigt[row, column]
    return tensor


def coupling_tensor(voigt: np.ndarray) -> np.ndarray:
    """e_kij of a 3x6 table."""
    tensor = np.empty((3, 3, 3))
    for column, (i, j) in enumerate(PAIRS):
        tensor[:, i, j] = tensor[:, j, i] = voigt[:, column]
    return tensor


def stiffness_table(tensor: np.ndarray) -> np.ndarray:
    """6x6 table of c_ijkl."""
    return np.array([[tensor[i, j, k, m] for k, m in PAIRS] for i, j in PAIRS])


def coupling_table(tensor: np.ndarray) -> np.ndarray:
    """3x6 table of e_kij."""
    return np.array([[tensor[k, i, j] for i, j in PAIRS] for k in range(3)])


def rotated_tables(a, stiffness, coupling, permittivity):
    """Tables in the frame whose axes are the rows of a."""
    c = np.einsum("ip,jq,kr,ls,pqrs->ijkl", a, a, a, a, stiffness_tensor(stiffness))
    e = np.einsum("ip,jq,kr,pqr->ijk", a, a, a, coupling_tensor(coupling))
    return stiffness_table(c), coupling_table(e), np.einsum("ip,jq,pq->ij", a, a, permittivity)


class SurfaceProblem:
    """Boundary conditions over the partial waves of a half-space; SI throughout but phi, in V per 1e-10 m."""

    def __init__(self, stiffness, coupling, permittivity, density, components, surface):
        potential = 1e10
        full = np.zeros((4, 3, 4, 3))  # generalised c_JlKm: J, K run over u_1 u_2 u_3 phi
        full[:3, :, :3, :] = stiffness_tensor(stiffness)
        e = coupling_tensor(coupling) * potential
        full[:3, :, 3, :] = np.einsum("kij->ijk", e)
        full[3, :, :3, :] = np.einsum("kij->kij", e)
        full[3, :, 3, :] = -np.asarray(permittivity) * potential**2
        keep = list(components)
        full = full[keep][:, :, keep] / 1e10
        self.xx, self.xz, self.zz = full[:, 0, :, 0], full[:, 0, :, 2], full[:, 2, :, 2]
        self.zx = full[:, 2, :, 0]
        self.inertia = np.diag([0.0 if j == 3 else density / 1e10 for j in keep])
        self.electric = keep.index(3) if 3 in keep else None
        self.surface, self.gap = surface, VACUUM * potential**2 / 1e10

    def conditions(self, velocity: float) -> np.ndarray:
        """Conditions (rows) on the partial waves (columns), each wave of norm 1; None above the limit."""
        n = len(self.xx)
        zero, one = np.zeros((n, n)), np.eye(n)
        constant = self.xx - velocity**2 * self.inertia
        left = np.block([[zero, one], [-constant, -(self.xz + self.zx)]])
        right = np.block([[one, zero], [zero, self.zz]])
        p, shapes = np.linalg.eig(np.linalg.solve(right, left))
        decaying = p.imag > 1e-7
        if decaying.sum() != n:
            return None
        p, a = p[decaying], shapes[:n, decaying]
        a = a / np.linalg.norm(a, axis=0)
        rows = self.zx @ a + self.zz @ a * p  # traction / (-i k)
        if self.electric is not None:
            if self.surface == "metallised":
                rows[self.electric] = a[self.electric]
            elif self.surface == "vacuum":
                rows[self.electric] += -1j * self.gap * a[self.electric]
        return rows

    def defect(self, velocity: float) -> float:
        """Smallest over largest singular value of the conditions: zero for a surface wave."""
        rows = self.conditions(velocity)
        if rows is None:
            return np.inf
        sizes = np.linalg.svd(rows / np.linalg.norm(rows, axis=1)[:, None], compute_uv=False)
        return float(sizes[-1] / sizes[0])

    def velocity_between(self, low: float, high: float, points: int = 400) -> float:
        """Velocity of the deepest dip of the defect, by repeated subdivision."""
        for _ in range(12):
            trial = np.linspace(low, high, points)
            best = int(np.argmin([self.defect(v) for v in trial]))
            low, high = trial[max(best - 1, 0)], trial[min(best + 1, points - 1)]
            points = 12
        return float((low + high) / 2)
