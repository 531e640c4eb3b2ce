r"""The slider's equations in the wave's own units, as plain arrays for the compiled kernels.

Unit of time 1/omega (so time is phase), of length ell = max(rest approach, largest |u_z| or |u_x|), of force
m omega^2 ell. With zeta_i = u_i - z_s:

    z_s'' = sum kappa zeta_i^1.5 (1 + chi zeta_i') - d_n z_s' - p,    v' = sum Q_i - d_t v - q.
"""

import math
from dataclasses import dataclass

import numpy as np

from contact.orbit import Orbit
from contact.slider import Slider

# places in the parameter array
(
    KAPPA,
    CHI,
    NORMAL_DAMPING,
    PRELOAD,
    TANGENTIAL_DAMPING,
    LOAD,
    MU,
    LIMIT_SLOPE,
    STICK_BAND,
    LONGEST,
    LAW,
) = range(11)


# values of LAW: the hysteretic one has a potential, so that a reciprocal force would add nothing
ELASTIC, RECIPROCAL, HYSTERETIC = 0.0, 1.0, 2.0


@dataclass(frozen=True)
class Scaled:
    """Dimensionless problem.

    Attributes
    ----------
    parameters : (11,) array
        In the order of the names of this module; LOAD carries the sign of the load.
    waves : (n, 4) array
        Per contact a, b of u_z = a cos phi + b sin phi, then a, b of u_x.
    length : float
        ell, m.
    omega : float
        rad/s.
    """

    parameters: np.ndarray
    waves: np.ndarray
    length: float
    omega: float

    @property
    def speed(self) -> float:
        """Unit of velocity, m/s."""
        return self.length * self.omega

    @property
    def stretches(self) -> float:
        """Least number of stretches that a cycle of the full motion takes."""
        return 2.0 * math.pi / float(self.parameters[LONGEST])


def scaled(slider: Slider, orbits: tuple[Orbit, ...], *, direction: float, start: float) -> Scaled:
    """Return the dimensionless problem.

    Parameters
    ----------
    slider, orbits
        The slider, and one orbit per contact.
    direction : float
        +1 or -1: the direction of motion that the load opposes.
    start : float
        Angle of the wave at phase 0, rad: u = Re(amplitude exp(i (phase + start))).
    """
    omega = orbits[0].omega
    reach = max(max(abs(o.normal), abs(o.tangential)) for o in orbits)
    length = max(slider.rest_approach(len(orbits)), reach, 1e-300)
    unit = slider.mass * omega**2 * length
    kappa = slider.hertz_stiffness * length**1.5 / unit
    turned = [
        (o.normal * np.exp(1j * start) / length, o.tangential * np.exp(1j * start) / length) for o in orbits
    ]
    stiffest = math.sqrt(1.5 * len(orbits) * kappa * math.sqrt(2.0) + 1e-300)
    # Picard's iteration gains nothing on a stretch longer than a damper's time
    viscous = max(slider.normal_damping, slider.tangential_damping) / (slider.mass * omega)
    quickest = max(viscous, slider.contact_damping * omega * length * kappa) + 1e-300
    parameters = np.array(
        [
            kappa,
            slider.contact_damping * omega * length,
            slider.normal_damping / (slider.mass * omega),
            slider.preload / unit,
            slider.tangential_damping / (slider.mass * omega),
            direction * slider.load / unit,
            slider.friction_coefficient,
            slider.limit_slope,
            slider.stick_band / (omega * length),
            min(2.0 * math.pi / 8.0 if reach > 0.0 else math.inf, 0.8 / stiffest, 2.0 / quickest),
            HYSTERETIC if slider.law == "hysteretic" else RECIPROCAL if slider.reciprocal else ELASTIC,
        ]
    )
    waves = np.array([[n.real, -n.imag, t.real, -t.imag] for n, t in turned])
    return Scaled(parameters, waves, length, omega)


def unmoved(problem: Scaled) -> Scaled:
    """Return the same problem for a slider that does not answer its forces: stretches as long as the wave allows."""
    parameters = problem.parameters.copy()
    parameters[LONGEST] = 2.0 * math.pi / 8.0
    return Scaled(parameters, problem.waves, problem.length, problem.omega)


def quiet(problem: Scaled) -> Scaled:
    """Return the same problem in the same units with the wave switched off."""
    parameters = problem.parameters.copy()
    kappa, contacts = parameters[KAPPA], len(problem.waves)
    quickest = (
        max(parameters[NORMAL_DAMPING], parameters[TANGENTIAL_DAMPING], parameters[CHI] * kappa) + 1e-300
    )
    parameters[LONGEST] = min(
        0.8 / math.sqrt(1.5 * contacts * kappa * math.sqrt(2.0) + 1e-300), 2.0 / quickest
    )
    return Scaled(parameters, np.zeros_like(problem.waves), problem.length, problem.omega)
