"""Static compliance of a half-space under a surface load, by two ways that share nothing with ``fem.analytic``.

``surface_compliance``: Stroh's eigenproblem for one direction of the wavevector. ``axial_modulus`` and
``axial_tangential_compliance``: closed forms where the normal (axis 3) is the axis of symmetry of a transversely
isotropic solid: H. A. Elliott, Proc. Camb. Phil. Soc. 44 (1948) 522; A. Delafargue and F.-J. Ulm, Int. J. Solids
Struct. 41 (2004) 7351, eq. 30.
"""

import math

import numpy as np

VOIGT = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])


def surface_compliance(c, angle):
    """Displacement times |k| for unit traction exp(i k.x) on the half-space z < 0; shape (3, 3), 1/Pa, complex."""
    full = c[VOIGT][:, :, VOIGT]  # c_ijkl
    m, n = np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([0.0, 0.0, 1.0])

    def mixed(a, b):
        return np.einsum("i,ijkl,l->jk", a, full, b)

    q, r, t = mixed(m, m), mixed(m, n), mixed(n, n)
    inverse = np.linalg.inv(t)
    stroh = np.block([[-inverse @ r.T, inverse], [r @ inverse @ r.T - q, -r @ inverse]])
    roots, vectors = np.linalg.eig(stroh)
    decaying = roots.imag < 0  # exp(i k p z) at z -> -infinity
    a, b = vectors[:3, decaying], vectors[3:, decaying]
    return np.linalg.inv(1j * b @ np.linalg.inv(a))


def averaged(c, directions=16):
    """Mean of the real part over directions of k, shape (3, 3), 1/Pa."""
    angles = np.arange(directions) * np.pi / directions + 0.1
    return np.mean([surface_compliance(c, angle).real for angle in angles], axis=0)


def axial_modulus(c):
    """Indentation modulus M in Pa."""
    c11, c13, c33, c44 = c[0, 0], c[0, 2], c[2, 2], c[3, 3]
    flexible = 1 / c44 + 2 / (c13 + math.sqrt(c11 * c33))
    return 2 * math.sqrt((c11 * c33 - c13**2) / c11 / flexible)


def axial_tangential_compliance(c):
    """Compliance along k plus that across k, in 1/Pa."""
    return 2 / axial_modulus(c) * math.sqrt(c[2, 2] / c[0, 0]) + 1 / math.sqrt(c[3, 3] * c[5, 5])
