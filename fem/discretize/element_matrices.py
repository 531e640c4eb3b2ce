"""Element matrices: stiffness, piezoelectric coupling, permittivity and inertia integrated over one element.

They discretise the weak form of time-harmonic piezoelectricity (medium.py).  In a rectangular element of a homogeneous
medium every integral is a product of integrals along x and z, so that the element's matrix is a sum of Kronecker
products of one-dimensional matrices (spectral.py).  Elsewhere are the matrices of the quadrilaterals of a mesh
(`QuadSpace` in quad_elements.py), of uniform segments (`Section.matrices` in section.py) and of absorbing layers along
their depth (graded_medium.py).
"""

from functools import lru_cache

import numpy as np

from fem.discretize.graded_medium import GradedMedium, element_line
from fem.discretize.spectral import reference_matrices
from fem.materials.medium import Medium


def element_matrix(
    medium: Medium, width: float, height: complex, order: int, angular: float, *, part: str = "all"
) -> np.ndarray:
    """Matrix of one rectangular element, nodes x-major then z, fields innermost: shape ((order + 1)^2 fields,) * 2.

    Width and height in length units, ``angular`` omega times the length unit in m/s; ``part``: "all", or "loss" for
    the imaginary part of the moduli alone, as a real matrix.
    """
    return combined(element_parts(medium, order, part), width, height, angular)


def combined(parts: np.ndarray, width: float, height: complex, angular: float) -> np.ndarray:
    """Matrix of an element of some size from the four of `element_parts`, or from blocks of them: shape (4, n, n)."""
    factors = np.array([height / width, 1.0, width / height, -(angular**2) * width * height])
    # real products in one pass over the memory, instead of one pass for each term of the sum
    flat = parts.reshape(4, -1).view(float)
    whole = (factors.real @ flat).view(parts.dtype)
    if np.iscomplexobj(factors):
        whole = whole + 1j * (factors.imag @ flat).view(parts.dtype)
    return whole.reshape(parts.shape[1:])


@lru_cache(maxsize=16)
def element_parts(medium: Medium, order: int, part: str = "all") -> np.ndarray:
    """The four matrices that an element of any size is a combination of: d_x d_x, mixed, d_z d_z, inertia."""
    line, depth = reference_matrices(order), element_line(medium, order)
    xx, xz, zz, inertia = medium.xx, medium.xz, medium.zz, np.diag(medium.inertia)
    if part == "loss":
        xx, xz, zz, inertia = (np.imag(table) for table in (xx, xz, zz, inertia))
    across = np.kron(line.advection, depth.advection.T)
    along = np.kron(np.kron(line.stiffness, depth.mass), xx)
    if isinstance(medium, GradedMedium):
        along = along + 1j * np.kron(np.kron(line.stiffness, medium.lossy_mass), medium.loss)
    parts = np.stack(
        (
            along,
            np.kron(across, xz) + np.kron(across.T, xz.T),
            np.kron(np.kron(line.mass, depth.stiffness), zz),
            np.kron(np.kron(line.mass, depth.mass), inertia),
        )
    )
    return 0.5 * (parts + parts.swapaxes(1, 2))  # exactly symmetric
