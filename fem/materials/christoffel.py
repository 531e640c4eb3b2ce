"""Bulk waves of the sagittal plane: whether one runs down while its phase runs up.

A stretched depth (perfectly matched layer) damps exp(-i k_z z) by the sign of the phase velocity.  In a cut without
symmetry the energy of a wave may go the other way (Becache, Fauqueux and Joly 2003): it would grow.
"""

import numpy as np

from fem.materials import Solid, fields

DIRECTIONS = 720
# Nearer to the surface a wave hardly goes down: LiNbO3 YZ, wrong within 3.4 degrees, is absorbed all the same.
GRAZING = np.radians(5)
_COLUMN = {"ux": 0, "uy": 1, "uz": 2}
_VOIGT = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])


def christoffel(solid: Solid, angles: np.ndarray) -> np.ndarray:
    """Stiffened Christoffel tensors of the coupled displacements along (cos, 0, sin), shape (angles, m, m), Pa."""
    names = fields(solid)
    moving = [_COLUMN[name] for name in names if name != "phi"]
    directions = np.stack([np.cos(angles), np.zeros_like(angles), np.sin(angles)], axis=1)
    stiffness = solid.stiffness[_VOIGT[:, :, None, None], _VOIGT[None, None, :, :]]
    tensors = np.einsum("aj,ijkl,al->aik", directions, stiffness, directions)
    if "phi" in names:
        coupling = solid.coupling[:, _VOIGT]
        polar = np.einsum("am,mij,aj->ai", directions, coupling, directions)
        dielectric = np.einsum("am,mn,an->a", directions, solid.permittivity, directions)
        tensors = tensors + polar[:, :, None] * polar[:, None, :] / dielectric[:, None, None]
    return tensors[:, moving][:, :, moving]


def stretch_absorbs(solid: Solid) -> bool:
    """Whether every bulk wave of the sagittal plane sends its energy to the side in depth to which its phase goes.

    Grazing directions do not count.  The group velocity's z component is d(omega)/d(k_z) = v sin + v' cos with
    v(angle) the phase velocity.
    """
    angles = GRAZING + (np.arange(DIRECTIONS) + 0.5) * (np.pi - 2 * GRAZING) / DIRECTIONS
    step = 1e-4
    speeds, ahead, behind = (
        np.sqrt(np.linalg.eigvalsh(christoffel(solid, angles + shift)) / solid.density)
        for shift in (0.0, step, -step)
    )
    slopes = (ahead - behind) / (2 * step)
    down = speeds * np.sin(angles)[:, None] + slopes * np.cos(angles)[:, None]
    return bool(np.all(down > 0))


def slowest_wavelength(solid: Solid, frequency: float) -> float:
    """Wavelength in m of the slowest bulk wave in the sagittal plane among the coupled fields, unstiffened."""
    mechanical = [{"ux": 0, "uy": 1, "uz": 2}[name] for name in fields(solid) if name != "phi"]
    voigt = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
    slowest = np.inf
    for angle in np.linspace(0, np.pi, 37):
        direction = np.array([np.cos(angle), 0.0, np.sin(angle)])
        tensor = solid.stiffness[voigt[:, :, None, None], voigt[None, None, :, :]]
        christoffel = np.einsum("j,ijkl,l->ik", direction, tensor, direction)[np.ix_(mechanical, mechanical)]
        slowest = min(slowest, np.linalg.eigvalsh(christoffel)[0])
    return float(np.sqrt(slowest / solid.density) / frequency)
