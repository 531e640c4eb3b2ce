"""Radiation of a contact into the stator: the admittance of an oscillating point load on an isotropic half-space.

G. F. Miller and H. Pursey, Proc. R. Soc. A 223 (1954) 521; for Poisson's ratio 1/4, all waves together.
"""

import math

POINT_ADMITTANCE = 0.93  # Re(v/F) over omega^2 / (2 pi mu c_T)


def point_admittance(omega: float, shear_modulus: float, shear_speed: float) -> float:
    """Return Re(v/F) in m/(N s) of a load normal to the surface at an angular frequency in rad/s."""
    return POINT_ADMITTANCE * omega**2 / (2 * math.pi * shear_modulus * shear_speed)
