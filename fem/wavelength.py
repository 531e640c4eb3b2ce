"""The shortest wavelength of a section: it sets the largest element and the unit of length."""

import numpy as np

from fem.materials import Solid, fields


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
