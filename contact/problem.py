r"""The slider's equations in the wave's own units: one named tuple that every kernel takes.

Unit of time 1/omega (so time is phase), of length ell = max(rest approach, largest |u_z| or |u_x|), of force
m omega^2 ell. With approach zeta_i:

    z_s'' = sum kappa_i p(zeta_i) (1 + chi zeta_i') - d_n z_s' - p_0,    v' = sum Q_i - d_t v - q,

with p(zeta) the load of `law.normal`, p_0 the preload and zeta_i of `body`. A contact that stands for w equal ones has
w times the stiffness of one. Its forces are then those of all w.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from contact.body import Paths
from contact.jit.compiled import compiled, formula
from contact.law import normal
from contact.law.holding import attraction_under, depth
from contact.law.normal import NormalLaw
from contact.law.protocol import Law
from contact.orbit import as_orbits, product
from contact.slider import Slider

WAVE_SEGMENT = 2.0 * math.pi / 8.0  # longest segment that the wave allows


class ContactFactors(NamedTuple):
    """What distinguishes the contacts of one slider, relative to the numbers of the problem; arrays (n,)."""

    stiffness: np.ndarray  # kappa_i/kappa, the number of equal contacts that it stands for included
    limit_slope: np.ndarray  # c_i/c


class ContactParameters(NamedTuple):
    """Parameters of one contact, in the units of the problem: what its forces and its law depend on."""

    stiffness: float  # kappa_i
    limit_slope: float  # c_i
    friction: float
    contact_damping: float
    stick_band: float
    normal: NormalLaw
    length: float
    omega: float
    law: Law


class Problem(NamedTuple):
    """A dimensionless problem."""

    stiffness: float  # kappa of P = kappa p(z), of one contact, the stiffest
    contact_damping: float  # chi
    # d_n and d_t
    normal_damping: float
    preload: float  # p_0
    tangential_damping: float
    load: float  # q, with the sign of the load
    # mu and c, the slip limit over the approach; of a law without one such number a typical mu, and the largest c
    friction: float
    limit_slope: float
    stick_band: float  # `slider.stick_band`, DV in Feenstra and Breedveld
    longest: float  # Longest segment of the event-driven solver
    normal: NormalLaw  # Of each contact
    paths: Paths  # Of the contacts
    factors: ContactFactors  # Of the contacts, on `stiffness` and `limit_slope`
    length: float  # ell, m
    omega: float  # rad/s
    law: Law  # Of the tangential force

    @property
    def contacts(self) -> int:
        """Number of contacts."""
        return len(self.paths.height)

    @property
    def speed(self) -> float:
        """Unit of velocity, m/s."""
        return self.length * self.omega

    @property
    def segments(self) -> float:
        """Least number of segments that a cycle of the full motion takes."""
        return 2.0 * math.pi / self.longest


def repeated(problem: Problem, times: int) -> Problem:
    """Return the problem with all its contacts so many times, one set after the other."""
    paths = Paths(*(np.tile(each, times) for each in problem.paths))
    return problem._replace(paths=paths, factors=ContactFactors(*(np.tile(each, times) for each in problem.factors)))


@compiled
def changed(problem, load, paths):
    """Return the problem with another load and other paths."""
    return Problem(
        problem.stiffness, problem.contact_damping, problem.normal_damping, problem.preload,
        problem.tangential_damping, load, problem.friction, problem.limit_slope, problem.stick_band, problem.longest,
        problem.normal, paths, problem.factors, problem.length, problem.omega, problem.law,
    )  # fmt: skip


@formula
def contact_parameters(problem, i):
    """Return the parameters of contact i; of a column of contacts the two that may differ are columns."""
    factors = problem.factors
    return ContactParameters(
        problem.stiffness * factors.stiffness[i], problem.limit_slope * factors.limit_slope[i], problem.friction,
        problem.contact_damping, problem.stick_band, problem.normal, problem.length, problem.omega, problem.law,
    )  # fmt: skip


@formula
def unpacked(contact):
    """Return the parameters with the normal law as `in_units` makes it, so that kernels share what is compiled."""
    return ContactParameters(
        contact.stiffness, contact.limit_slope, contact.friction, contact.contact_damping, contact.stick_band,
        normal.with_pull(contact.normal, contact.normal.pull, contact.normal.hold), contact.length, contact.omega,
        contact.law,
    )  # fmt: skip


@formula
def full_friction(problem):
    """Return mu times preload and attraction, the friction of closed contacts that carry the preload and all slip."""
    number = np.sum(problem.factors.stiffness)
    own = attraction_under(problem.preload / (problem.stiffness * number), problem.normal.pull, problem.normal.hold)
    return problem.friction * (problem.preload + problem.stiffness * own * number)


@formula
def load_direction(largest):
    """Return +1 or -1, the direction of motion that a load opposes, of `orbit.towards_plus` orbits.

    It is that of the unloaded slider: -1 where even the largest mean force of a cycle at rest is negative. The load on
    a slider that the wave does not move without it acts against the crests.
    """
    return -1.0 if largest < 0.0 else 1.0


class SliderNumber(IntEnum):
    """Indices of the numbers of a slider (`numbers`), SI units."""

    MASS = 0
    STIFFNESS = 1  # K of the stiffest contact
    SLOPE = 2  # c, the largest
    PRELOAD = 3
    LOAD = 4
    FRICTION = 5
    CHI = 6
    NORMAL_DAMPING = 7
    TANGENTIAL_DAMPING = 8
    REST = 9  # the largest approach at rest


def numbers(s: Slider, contacts: int) -> list[float]:
    """Return what `in_units` takes of a slider, in the order of `SliderNumber`."""
    return [
        s.unit_mass, s.stiffness_unit, s.slope_unit, s.preload, s.load, s.static_coefficient, s.contact_damping,
        s.normal_damping, s.tangential_damping, float(s.rest_approaches(contacts).max()),
    ]  # fmt: skip


def paths_of(u_z: np.ndarray, u_x: np.ndarray, heights: np.ndarray) -> Paths:
    """Return the paths of contacts of these heights over surfaces with complex amplitudes u_z and u_x."""
    return Paths(heights, u_z.real.copy(), -u_z.imag, u_x.real.copy(), -u_x.imag)


@formula
def in_units(numbers, length, omega, paths, factors, law, own):
    """Return the problem of a slider with these `numbers` on scaled paths, without a longest segment.

    `law` is its tangential law, and `own` its normal law in SI units.
    """
    mass = numbers[SliderNumber.MASS]
    unit = mass * omega**2 * length
    return Problem(
        numbers[SliderNumber.STIFFNESS] * normal.load(length, own) / unit, numbers[SliderNumber.CHI] * omega * length,
        numbers[SliderNumber.NORMAL_DAMPING] / (mass * omega), numbers[SliderNumber.PRELOAD] / unit,
        numbers[SliderNumber.TANGENTIAL_DAMPING] / (mass * omega), numbers[SliderNumber.LOAD] / unit,
        numbers[SliderNumber.FRICTION], numbers[SliderNumber.SLOPE], 0.0, np.inf, normal.scaled(own, length), paths,
        factors, length, omega, law,
    )  # fmt: skip


def scaled(slider: Slider, orbits, *, direction: float, start: float) -> Problem:
    """Return the dimensionless problem of a slider and one orbit per contact.

    `direction`: +1 or -1, that of the motion that the load opposes; `start`: angle of the wave at phase 0, rad:
    u = Re(amplitude exp(i (phase + start))).
    """
    orbits = as_orbits(orbits)
    own, reach = numbers(slider, len(orbits)), orbits.reach
    length, omega = max(own[SliderNumber.REST], reach, 1e-300), orbits.omega
    unit = np.exp(1j * start) / length
    u_z, u_x = product(orbits.normal, unit), product(orbits.tangential, unit)
    paths = paths_of(u_z, u_x, slider.offsets(len(orbits)) / length)
    factors = ContactFactors(*slider.contact_factors(len(orbits)))
    problem = in_units(own, length, omega, paths, factors, slider.tangential_law, slider.profile)
    return _with_longest(
        problem, WAVE_SEGMENT if reach > 0.0 else math.inf, stiffness=float(problem.stiffness),
        load=direction * problem.load, stick_band=slider.stick_band / problem.speed,
    )  # fmt: skip


@formula
def largest_stiffness(problem):
    """Return the largest stiffness of all contacts together, omega_n^2; the approach is at most twice the unit."""
    total = np.sum(problem.factors.stiffness) * problem.stiffness
    return total * normal.slope(depth(2.0, problem.normal.hold), problem.normal)


def largest_resonance(problem: Problem) -> float:
    """Return the largest contact resonance over the wave's frequency."""
    return math.sqrt(float(largest_stiffness(problem)))


def _with_longest(problem, longest, **changed):
    """Return the problem with the longest segment that wave, contact and dampers allow.

    Beyond these lengths the Picard iteration of a segment converges too slowly.
    """
    stiffness = problem.stiffness * float(problem.factors.stiffness.max())
    damping = max(problem.normal_damping, problem.tangential_damping, problem.contact_damping * stiffness)
    longest = min(0.8 / (largest_resonance(problem) + 1e-150), 2.0 / (damping + 1e-300), longest)
    return problem._replace(longest=longest, **changed)


def immobile(problem: Problem) -> Problem:
    """Return the same problem for a slider that does not answer its forces: segments as long as the wave allows."""
    return problem._replace(longest=WAVE_SEGMENT)


def with_longer_segments(problem: Problem, factor: float) -> Problem:
    """Return the same problem with the wave's limit of a segment so many times longer, and those of the others kept."""
    longer = _with_longest(problem, factor * WAVE_SEGMENT).longest
    return problem._replace(longest=max(problem.longest, longer))


def without_wave(problem: Problem) -> Problem:
    """Return the same problem in the same units with the wave switched off."""
    paths = Paths(problem.paths.height, *np.zeros((4, problem.contacts)))
    return _with_longest(problem, math.inf, paths=paths)
