r"""How much surface wave a force on the surface makes: the residue of the surface's compliance at the Rayleigh pole.

A traction t exp(i(omega t - k x)) moves the surface by u = Z(omega/k)^-1 t/k with the surface impedance Z of `stroh`.
Next to the root of its eigenvalue lambda (with unit vector m), at fixed frequency,

    u_z = |m_z|^2 t_z / (k lambda' (v - v_R)) = Gamma t_z/(k - k_R),    Gamma = -|m_z|^2 / (lambda'(v_R) v_R),

for v - v_R = -v_R (k - k_R)/k. Gamma in 1/Pa does not depend on the frequency. The wave's power per width is
|u_z|^2 omega/(4 Gamma), and u_x answers a tangential traction by r^2 Gamma. Compare Auld, *Acoustic Fields and Waves in
Solids* II (1973), sections 10 and 12.
"""

import numpy as np

from fem.analytic.half_space import _bulk, rayleigh, surface_named
from fem.analytic.stroh import SurfaceImpedance
from fem.materials import Solid

STEP = 1e-4  # of the angle, in five points: the derivative is good to 1e-11, as its halves and doubles show


def wave_compliance(solid: Solid, surface: str = "vacuum") -> float:
    """Return Gamma of a half-space's Rayleigh wave in 1/Pa.

    Parameters
    ----------
    solid : Solid
        In the frame x along the propagation, z out of the surface; its losses are ignored.
    surface : str
        As of `rayleigh`.

    Raises
    ------
    InputError
        For an unknown surface.
    ConvergenceError
        If the cut has no subsonic wave.

    Examples
    --------
    >>> import fem
    >>> print(f"{fem.wave_compliance(fem.material('PZT-8')):.4e}")
    4.8674e-12
    """
    wave = rayleigh(solid, surface)
    _, body, limit = _bulk(solid)
    impedance = SurfaceImpedance(body, surface_named(surface))
    unit = float(np.sqrt(1.0 / body.inertia[0]))
    velocity = wave.velocity / unit
    index = int(np.argmin(np.abs(impedance.eigenvalues(velocity))))
    # lambda is analytic in the angle with v = limit sin(angle), up to the limiting velocity
    angle = np.arcsin(velocity / limit)
    step = STEP * min(1.0, 10.0 * (np.pi / 2 - angle))
    values = [impedance.eigenvalues(limit * np.sin(angle + n * step))[index] for n in (-2, -1, 1, 2)]
    slope = (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * step) / (limit * np.cos(angle))
    amplitude = impedance.mode(velocity, index)[impedance.displaced]
    share = abs(amplitude[-1]) ** 2 / float(np.sum(np.abs(amplitude) ** 2))
    softest = np.diag(body.zz)[body.displaced].min()
    return float(-share / (slope * velocity) / (softest * body.stress_unit))
