"""Bulk waves of the sagittal plane, from the Christoffel tensor.

A plane wave exp(-i k n . x) of direction n = (cos, 0, sin) has rho v^2 among the eigenvalues of the Christoffel tensor
(Auld, *Acoustic Fields and Waves in Solids*, vol. 1, 1973, sections 7.D and 8.F); where phi is coupled, eliminating it
stiffens the tensor.
"""

from typing import NamedTuple

import numpy as np

from fem.materials.medium import Medium, medium
from fem.materials.rotation import fields
from fem.materials.solids import Solid
from fem.parameters import positive

DIRECTIONS = 720
# Waves within this angle of the surface are not tested, because they hardly go down: a matched layer absorbs the waves
# of YZ LiNbO3, although the energy of those within 3.4 degrees goes the wrong way.
GRAZING = np.radians(5)


def christoffel(body: Medium, angles: np.ndarray, *, stiffened: bool = True) -> np.ndarray:
    """Christoffel tensors of the displacements that take part, over the stress unit, (angles, fields, fields).

    ``body``: real tables; ``angles`` of the direction from the x axis, rad; ``stiffened``: True to include the electric
    field of the wave (piezoelectric stiffening).
    """
    cosine, sine = np.cos(angles)[:, None, None], np.sin(angles)[:, None, None]
    tensors = cosine**2 * body.xx + cosine * sine * (body.xz + body.xz.T) + sine**2 * body.zz
    displaced = body.displaced
    acoustic = tensors[:, displaced][:, :, displaced]
    if stiffened and not displaced.all():
        across = tensors[:, displaced][:, :, ~displaced]
        acoustic = acoustic - across @ across.transpose(0, 2, 1) / tensors[:, -1:, -1:]
    return acoustic


def stretch_absorbs(solid: Solid) -> bool:
    """True if every bulk wave of the sagittal plane carries its energy to the side in depth to which its phase goes.

    A stretched depth (perfectly matched layer) damps exp(-i k_z z) by the sign of the phase velocity; a wave whose
    energy goes the other way would grow there (Becache, Fauqueux and Joly 2003).  Grazing directions do not count.
    """
    angles = GRAZING + (np.arange(DIRECTIONS) + 0.5) * (np.pi - 2 * GRAZING) / DIRECTIONS
    _, down = _group_velocity(medium(solid, fields(solid), lossy=False), angles)
    return bool(np.all(down > 0))


def _group_velocity(body: Medium, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Components of the group velocity along x and z by direction and sheet, slowest first: (angles, sheets) each.

    d(omega)/d(k_x) = v cos - v' sin and d(omega)/d(k_z) = v sin + v' cos with v(angle) the phase velocity, over
    sqrt(stress_unit / rho).
    """
    step = 1e-4
    speeds, ahead, behind = (
        np.sqrt(np.linalg.eigvalsh(christoffel(body, angles + shift))) for shift in (0.0, step, -step)
    )
    slopes = (ahead - behind) / (2 * step)
    cosine, sine = np.cos(angles)[:, None], np.sin(angles)[:, None]
    return speeds * cosine - slopes * sine, speeds * sine + slopes * cosine


class Sheet(NamedTuple):
    """A sheet of the slowness surface where the axis x meets it."""

    modulus: float  # rho v^2 of its wave along x, over the stress unit
    polarisation: np.ndarray  # of that wave, shape (displacements,)
    backwardness: float  # largest |k_z V_z / (k_x V_x)| of its waves with k_z V_z < 0; 0 if it has none


def slowness_sheets(solid: Solid) -> list[Sheet]:
    """Sheets of the slowness surface of the sagittal plane, slowest first, and how far each is concave at the x axis.

    A wave whose energy goes down while its phase goes up (k_z V_z < 0) grows in a stretched depth, unless the loss of
    its motion along x exceeds its ``backwardness``.
    """
    body = medium(solid, fields(solid), lossy=False)
    angles = (np.arange(2 * DIRECTIONS) + 0.5) * np.pi / (2 * DIRECTIONS) - np.pi / 2
    along, down = _group_velocity(body, angles)
    tangent = np.tan(angles)[:, None]
    backward = tangent * down < -1e-6 * abs(along)
    with np.errstate(divide="ignore"):
        ratio = np.where(backward, abs(tangent * down) / np.maximum(along, 0.0), 0.0)
    moduli, polarisations = np.linalg.eigh(christoffel(body, np.zeros(1))[0])
    return [Sheet(float(m), e, float(p)) for m, e, p in zip(moduli, polarisations.T, ratio.max(axis=0), strict=True)]


def slowest_wavelength(solid: Solid, frequency: float) -> float:
    """Wavelength in m of the slowest bulk wave in the sagittal plane among the coupled fields, unstiffened."""
    positive("frequency", frequency, "Hz")
    body = medium(solid, fields(solid), lossy=False)
    tensors = christoffel(body, np.linspace(0, np.pi, 37), stiffened=False)
    return float(np.sqrt(np.linalg.eigvalsh(tensors)[:, 0].min() / body.inertia[0]) / frequency)
