"""A piezoelectric solid in Stroh's form: the derivatives across its depth by wave vectors of its surface.

Ting, *Anisotropic Elasticity*, 1996, chapter 5; exp(+i omega t - i k x).
"""

import numpy as np

VOIGT = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])


class StrohSolid:
    """Constants in SI, complex with loss: stiffness (6, 6), coupling e (3, 6), permittivity (3, 3), density."""

    def __init__(self, *, stiffness, coupling, permittivity, density, frequency):
        self.unit = abs(stiffness).max()
        self.volt = np.sqrt(self.unit / abs(permittivity).max())
        self.wavenumber = 2 * np.pi * frequency * np.sqrt(density / self.unit)
        table = np.zeros((3, 3, 4, 4), dtype=complex)  # of derivatives a, b: rows and columns u_x, u_y, u_z, phi
        for a in range(3):
            for b in range(3):
                for i in range(3):
                    for k in range(3):
                        table[a, b, i, k] = stiffness[VOIGT[i, a], VOIGT[k, b]] / self.unit
                    table[a, b, i, 3] = coupling[b, VOIGT[i, a]] * self.volt / self.unit
                    table[a, b, 3, i] = coupling[a, VOIGT[i, b]] * self.volt / self.unit
                table[a, b, 3, 3] = -permittivity[a, b] * self.volt**2 / self.unit
        self.table = table

    def blocks(self, kx, ky):
        """Return the matrices k_a A_ab k_b - omega^2, k_a A_az, A_zb k_b, (n, 4, 4), and A_zz^-1, all scaled."""
        t, k = self.table, np.stack([kx, ky]) / self.wavenumber
        plane = np.einsum("an,bn,abij->nij", k, k, t[:2, :2]) - np.diag([1.0, 1.0, 1.0, 0.0])
        out, back = np.einsum("an,aij->nij", k, t[:2, 2]), np.einsum("an,aij->nij", k, t[2, :2])
        inverse = np.linalg.inv(t[2, 2])
        return plane, out, back, inverse
