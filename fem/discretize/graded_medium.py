"""Medium of an absorbing layer: complex coordinate stretching that varies within an element, and a loss along x.

With the stretch s(z) of the depth, the loss factor delta(z) and the table R of the moduli that are lossy, the weak form
(element_matrices.py, section.py) has the coefficients

    s (C_xx + i delta R),   C_xz,   C_zz / s,   s rho omega^2.

The one-dimensional matrices of an element are therefore integrated with the weights s, 1, 1/s, s and s delta.  The
tractions stay continuous from element to element, because R multiplies derivatives along x only.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
from numpy.polynomial import legendre

from fem.discretize.spectral import LineMatrices, lagrange, reference_matrices
from fem.materials.medium import Medium

POINTS = 8  # Gauss points in excess of the order, for the weights; s varies slowly within an element


@dataclass(frozen=True, kw_only=True, eq=False)
class OwnLineMedium(Medium):
    """Medium of an element that has one-dimensional matrices of its own through the depth."""

    line: LineMatrices  # for an element of height 1
    inner_nodes: bool = True  # False if only the nodes on both faces have unknowns


@dataclass(frozen=True, kw_only=True, eq=False)
class GradedMedium(OwnLineMedium):
    """Medium of one element in a layer whose stretch varies within the element.

    Its ``line`` is weighted by s over its mean, and the element's height contains the mean.
    """

    lossy_mass: np.ndarray  # shape (order + 1,) * 2: the mass weighted by s delta over the mean of s
    loss: np.ndarray  # shape (fields, fields): R


def graded_medium(
    body: Medium, order: int, *, stretch: Callable, damping: Callable, loss: np.ndarray
) -> tuple[complex, GradedMedium]:
    """Mean of the stretch over an element, and the medium of the element.

    ``stretch`` and ``damping`` are s and delta as functions of the relative height in the element, from 0 to 1;
    ``loss`` is R over the stress unit, shape (fields, fields).
    """
    points, weights = legendre.leggauss(order + POINTS)
    points, weights = (points + 1) / 2, weights / 2
    values, slopes = lagrange(order, points)
    factor = stretch(points)
    mean = complex(weights @ factor)

    def integral(density: np.ndarray, left: np.ndarray) -> np.ndarray:
        return np.einsum("q,qi,qj->ij", weights * density, left, left)

    line = LineMatrices(
        mass=integral(factor / mean, values),
        stiffness=integral(mean / factor, slopes),
        advection=reference_matrices(order).advection,
    )
    own = {each.name: getattr(body, each.name) for each in fields(body)}
    lossy_mass = integral(factor * damping(points) / mean, values)
    return mean, GradedMedium(**own, line=line, lossy_mass=lossy_mass, loss=loss)


def is_bond(medium: Medium) -> bool:
    """True for the medium of an element whose faces alone have unknowns."""
    return isinstance(medium, OwnLineMedium) and not medium.inner_nodes


def element_line(medium: Medium, order: int) -> LineMatrices:
    """One-dimensional matrices of an element through the depth, for an element of height 1."""
    return medium.line if isinstance(medium, OwnLineMedium) else reference_matrices(order)


def along_x(medium: Medium, order: int, height: complex) -> np.ndarray:
    """Matrix that multiplies (d_x v)(d_x u) in an element, fields innermost, shape ((order + 1) fields,) * 2."""
    out = np.kron(height * element_line(medium, order).mass, medium.xx)
    if isinstance(medium, GradedMedium):
        out = out + 1j * np.kron(height * medium.lossy_mass, medium.loss)
    return out
