r"""The slider's equations in the wave's own units: one named tuple that every kernel takes.

Unit of time 1/omega (so time is phase), of length ell = max(rest approach, largest |u_z| or |u_x|), of force
m omega^2 ell. With zeta_i = u_i - z_s:

    z_s'' = sum kappa zeta_i^1.5 (1 + chi zeta_i') - d_n z_s' - p,    v' = sum Q_i - d_t v - q.
"""

import math
from typing import NamedTuple

import numpy as np

from contact.jit.compiled import compiled
from contact.orbit import Orbit
from contact.slider import Slider

# values of `law`: the hysteretic one has a potential, so that a reciprocal force would add nothing
ELASTIC, RECIPROCAL, HYSTERETIC = 0, 1, 2


class Problem(NamedTuple):
    """A dimensionless problem.

    Attributes
    ----------
    stiffness : float
        kappa of P = kappa z^1.5, of one contact.
    contact_damping : float
        chi.
    normal_damping, tangential_damping : float
        d_n and d_t.
    preload : float
        p.
    load : float
        q, with the sign of the load.
    friction, limit_slope : float
        mu and c, the slip limit over the approach.
    stick_band : float
        The seed's DV.
    longest : float
        Longest segment of the event-driven solver.
    law : int
        ELASTIC, RECIPROCAL or HYSTERETIC.
    waves : (n, 4) array
        Per contact a, b of u_z = a cos phi + b sin phi, then a, b of u_x.
    length : float
        ell, m.
    omega : float
        rad/s.
    """

    stiffness: float
    contact_damping: float
    normal_damping: float
    preload: float
    tangential_damping: float
    load: float
    friction: float
    limit_slope: float
    stick_band: float
    longest: float
    law: int
    waves: np.ndarray
    length: float
    omega: float

    @property
    def speed(self) -> float:
        """Unit of velocity, m/s."""
        return self.length * self.omega

    @property
    def segments(self) -> float:
        """Least number of segments that a cycle of the full motion takes."""
        return 2.0 * math.pi / self.longest

    @property
    def row(self) -> np.ndarray:
        """The numbers that `from_row` takes, as an array."""
        return np.array([*self[:10], float(self.law), self.length, self.omega])


@compiled
def from_row(row, waves):
    """Return the problem with these numbers (`Problem.row`) and waves."""
    return Problem(
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9], int(row[10]), waves, row[11],
        row[12],
    )  # fmt: skip


@compiled
def with_load(problem, load):
    """Return the problem with another load."""
    return Problem(
        problem.stiffness, problem.contact_damping, problem.normal_damping, problem.preload,
        problem.tangential_damping, load, problem.friction, problem.limit_slope, problem.stick_band, problem.longest,
        problem.law, problem.waves, problem.length, problem.omega,
    )  # fmt: skip


@compiled
def with_waves(problem, waves):
    """Return the problem with other waves."""
    return Problem(
        problem.stiffness, problem.contact_damping, problem.normal_damping, problem.preload,
        problem.tangential_damping, problem.load, problem.friction, problem.limit_slope, problem.stick_band,
        problem.longest, problem.law, waves, problem.length, problem.omega,
    )  # fmt: skip


def scaled(slider: Slider, orbits: tuple[Orbit, ...], *, direction: float, start: float) -> Problem:
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
    viscous = max(slider.normal_damping, slider.tangential_damping) / (slider.mass * omega)
    law = HYSTERETIC if slider.law == "hysteretic" else RECIPROCAL if slider.reciprocal else ELASTIC
    return Problem(
        stiffness=kappa,
        contact_damping=slider.contact_damping * omega * length,
        normal_damping=slider.normal_damping / (slider.mass * omega),
        preload=slider.preload / unit,
        tangential_damping=slider.tangential_damping / (slider.mass * omega),
        load=direction * slider.load / unit,
        friction=slider.friction_coefficient,
        limit_slope=slider.limit_slope,
        stick_band=slider.stick_band / (omega * length),
        longest=min(
            2.0 * math.pi / 8.0 if reach > 0.0 else math.inf,
            _longest(kappa, len(orbits), max(viscous, slider.contact_damping * omega * length * kappa)),
        ),
        law=law,
        waves=np.array([[n.real, -n.imag, t.real, -t.imag] for n, t in turned]),
        length=length,
        omega=omega,
    )


def _longest(kappa, contacts, damping):
    """Return the longest segment that contact and dampers allow: Picard's iteration gains nothing on a longer one."""
    stiffest = math.sqrt(1.5 * contacts * kappa * math.sqrt(2.0) + 1e-300)
    return min(0.8 / stiffest, 2.0 / (damping + 1e-300))


def immobile(problem: Problem) -> Problem:
    """Return the same problem for a slider that does not answer its forces: segments as long as the wave allows."""
    return problem._replace(longest=2.0 * math.pi / 8.0)


def without_wave(problem: Problem) -> Problem:
    """Return the same problem in the same units with the wave switched off."""
    damping = max(
        problem.normal_damping, problem.tangential_damping, problem.contact_damping * problem.stiffness
    )
    return problem._replace(
        longest=_longest(problem.stiffness, len(problem.waves), damping), waves=np.zeros_like(problem.waves)
    )
