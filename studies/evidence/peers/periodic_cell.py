"""Half a wavelength of a half-space, cut off at a depth, in high-order elements.

A wave of this length changes sign after half of it, so half a cell with u(x + 1/2) = -u(x) is the whole
problem of the periodic cell, without the even harmonics (among them the resonances through the depth).
The bottom is clamped and grounded.  The grid is a tensor product and the solid homogeneous: scikit-fem
assembles the matrices of a line (`MeshLine`, `ElementLinePp`) and those of the weak form (forms.py) are
sums of their Kronecker products. The space is that of `ElementQuadP` on the same grid.  Lengths are in
wavelengths.
"""

from copy import copy
from functools import partial

import numpy as np

from fem.materials import VACUUM_PERMITTIVITY
from fem.materials.medium import Medium


class PeriodicCell:
    """Matrices and unknowns of a cell; the unknowns run over z, then x, then the field.

    Parameters
    ----------
    body : Medium
        Real tables.
    surface : str
        "vacuum", "open" or "metallised".
    order : int
        Polynomial order in both directions.
    columns : int
        Elements in half a wavelength.
    heights : ndarray, shape (layers + 1,)
        Of the layer interfaces, ending at 0.
    """

    def __init__(self, body: Medium, surface: str, order: int, columns: int, heights: np.ndarray):
        from skfem import Basis, ElementLineP1, ElementLineP2, ElementLinePp, MeshLine

        self.element = {1: ElementLineP1, 2: ElementLineP2}.get(order, partial(ElementLinePp, order))
        self.body, self.surface = body, surface
        self.across = Basis(MeshLine(np.linspace(0, 0.5, columns + 1)), self.element())
        self.down = Basis(MeshLine(heights), self.element())
        self.top = int(self.down.get_dofs(lambda z: z[0] == heights[-1]).flatten()[0])
        self.bottom = int(self.down.get_dofs(lambda z: z[0] == heights[0]).flatten()[0])
        ends = [int(self.across.get_dofs(lambda x, at=at: x[0] == at).flatten()[0]) for at in (0.0, 0.5)]
        self.folded = _opposite(self.across.N, *ends)
        grid = np.zeros((self.down.N, self.folded.shape[1], len(body.fields)), dtype=bool)
        grid[self.bottom] = True
        if surface == "metallised" and "phi" in body.fields:
            grid[self.top, :, body.fields.index("phi")] = True
        self.kept = np.flatnonzero(~grid.ravel())
        self.grid = grid.shape

    def matrices(self):
        """K and M, sparse, scaled; eigenvalues are (2 pi v)^2 with v in sqrt(stress_unit / rho)."""
        from scipy.sparse import csc_matrix, kron

        body, p = self.body, self.folded
        mass_x, stiff_x, advect_x = (p.T @ part @ p for part in _line_matrices(self.across))
        mass_z, stiff_z, advect_z = _line_matrices(self.down)
        mixed = kron(advect_z.T, kron(advect_x, body.xz))
        stiffness = kron(mass_z, kron(stiff_x, body.xx)) + mixed + mixed.T
        stiffness = stiffness + kron(stiff_z, kron(mass_x, body.zz))
        if self.surface == "vacuum" and "phi" in body.fields:
            # exp(-k z) above: D_n = eps0 k phi, exact for the first harmonic, which is all that the wave has
            gap = 2 * np.pi * VACUUM_PERMITTIVITY * body.potential_unit**2 / body.stress_unit
            phi = np.diag([float(name == "phi") for name in body.fields])
            here = csc_matrix(([1.0], ([self.top], [self.top])), shape=mass_z.shape)
            stiffness = stiffness - gap * kron(here, kron(mass_x, phi))
        inertia = kron(mass_z, kron(mass_x, np.diag(body.inertia / body.inertia[0])))
        keep = self.kept
        return (csc_matrix(part)[keep][:, keep].tocsc() for part in (stiffness, inertia))

    def travelling(self, pair: np.ndarray) -> tuple[np.ndarray, float]:
        """Amplitude of exp(-i k x) in the combination of a pair with least of exp(+i k x), and that rest.

        Shape (z unknowns, fields).
        """
        from skfem import LinearForm

        wave = LinearForm(lambda v, w: np.exp(2j * np.pi * w.x[0]) * v, dtype=np.complex128)
        forward = self.folded.T @ wave.assemble(self.across)
        field_on_grid = np.zeros((np.prod(self.grid), 2))
        field_on_grid[self.kept] = pair
        field_on_grid = field_on_grid.reshape(*self.grid, 2)
        ahead, back = (np.einsum("x,zxfm->zfm", w, field_on_grid) for w in (forward, forward.conj()))
        _, sizes, rows = np.linalg.svd(back.reshape(-1, 2), full_matrices=False)
        combination = rows[1].conj()
        return ahead @ combination, float(sizes[1] / sizes[0])

    def at_depth(self, shape: np.ndarray, depth) -> tuple[np.ndarray, np.ndarray]:
        """Displacement (n, 3) and potential (n,) in V/m at depths in wavelengths."""
        z = -np.atleast_1d(np.asarray(depth, dtype=float))
        lowest = float(self.down.mesh.p.min())
        if not np.all((z <= 0) & (z >= lowest)):
            raise ValueError(f"depth must lie between 0 and {-lowest:g} wavelengths, got {-z!r}")
        line = copy(self.down)
        # ElementLinePp remembers its values by the number of points alone: ask a fresh one
        line.elem = self.element()
        values = line.probes(z[None, :]) @ shape
        displacement, potential = np.zeros((len(z), 3), dtype=complex), np.zeros(len(z), dtype=complex)
        for column, name in enumerate(self.body.fields):
            if name == "phi":
                potential = values[:, column] * self.body.potential_unit
            else:
                displacement[:, ("ux", "uy", "uz").index(name)] = values[:, column]
        return displacement, potential


def _line_matrices(basis):
    """Mass int N_i N_j, stiffness int N_i' N_j', advection int N_i' N_j of a line."""
    from skfem import BilinearForm

    forms = (lambda u, v, _: u * v, lambda u, v, _: u.grad[0] * v.grad[0], lambda u, v, _: u * v.grad[0])
    return tuple(BilinearForm(form).assemble(basis) for form in forms)


def _opposite(count: int, kept: int, dropped: int):
    """Sparse (count, count - 1) matrix that gives unknown ``dropped`` minus the value of unknown ``kept``."""
    from scipy.sparse import csr_matrix

    columns = np.arange(count) - (np.arange(count) > dropped)
    columns[dropped] = columns[kept]
    signs = np.where(np.arange(count) == dropped, -1.0, 1.0)
    return csr_matrix((signs, (np.arange(count), columns)), shape=(count, count - 1))


def graded_heights(layers: int, depth: float, grading: float) -> np.ndarray:
    """Return the heights of layer interfaces from -depth to exactly 0, the layer sizes a geometric row.

    Parameters
    ----------
    layers : int
    depth : float
    grading : float
        Lowest layer over uppermost one.

    Returns
    -------
    ndarray, shape (layers + 1,)
    """
    sizes = grading ** (np.arange(layers) / max(layers - 1, 1))
    return -depth * np.concatenate([[0.0], np.cumsum(sizes) / sizes.sum()])[::-1]
