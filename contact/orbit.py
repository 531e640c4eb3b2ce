"""Prescribed harmonic motion of the surface point under one contact.

The displacement is u = Re(amplitude exp(i omega t)) with peak amplitudes; x points along the surface and z out of it,
towards the slider. ``normal=A, tangential=-1j*r*A`` describes an elliptic motion with u_x and u_z in quadrature
whose surface points move towards +x at its crests. A Rayleigh wave of this orbit (retrograde) runs towards -x.
"""

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from contact import parameter_check
from contact.exceptions import InputError


@dataclass(frozen=True, kw_only=True)
class Orbit:
    """Harmonic motion of the stator's surface at one contact.

    Attributes
    ----------
    frequency : float
        Frequency in Hz, positive.
    normal : complex
        Peak amplitude of u_z, m.
    tangential : complex
        Peak amplitude of u_x, m.
    """

    frequency: float
    normal: complex
    tangential: complex

    def __post_init__(self):
        object.__setattr__(self, "frequency", parameter_check.positive("orbit.frequency", self.frequency, "Hz"))
        object.__setattr__(self, "normal", parameter_check.finite_complex("orbit.normal", self.normal, "m"))
        object.__setattr__(self, "tangential", parameter_check.finite_complex("orbit.tangential", self.tangential, "m"))

    @property
    def omega(self) -> float:
        """Angular frequency, rad/s."""
        return 2.0 * math.pi * self.frequency

    @property
    def crest_velocity(self) -> float:
        """Tangential surface velocity at the time of largest u_z, m/s; zero without normal motion."""
        if self.normal == 0:
            return 0.0
        return (1j * self.omega * self.tangential * self.normal.conjugate()).real / abs(self.normal)

    @property
    def upward_zero(self) -> float:
        """Angle of the wave in rad at which u_z crosses zero upwards."""
        return -0.5 * math.pi - cmath.phase(self.normal)

    def scaled(self, factor: complex) -> "Orbit":
        """Return the same orbit with both amplitudes multiplied by `factor` (its angle shifts time)."""
        return replace(self, normal=self.normal * factor, tangential=self.tangential * factor)

    def mirrored(self) -> "Orbit":
        """Return the orbit of the wave that travels in the opposite direction (u_x negated)."""
        return replace(self, tangential=-self.tangential)


def as_orbits(orbits: "Orbit | Sequence[Orbit]") -> tuple[Orbit, ...]:
    """Return one orbit per contact as a tuple; all must have one frequency."""
    listed = (orbits,) if isinstance(orbits, Orbit) else tuple(orbits)
    if not listed:
        raise InputError("orbits", "must hold at least one Orbit, one per contact, got none")
    for orbit in listed:
        if not isinstance(orbit, Orbit):
            raise InputError("orbits", "must hold objects of type Orbit", orbit)
        if orbit.frequency != listed[0].frequency:
            raise InputError("orbits", f"must share one frequency, got {listed[0].frequency} and {orbit.frequency} Hz")
    return listed


def drive_direction(orbits: tuple[Orbit, ...]) -> float:
    """Return +1 or -1, the direction of the surface velocity at the wave crests (+1 if it is zero)."""
    return -1.0 if sum(orbit.crest_velocity for orbit in orbits) < 0.0 else 1.0


def towards_plus(orbits: tuple[Orbit, ...]) -> tuple[float, tuple[Orbit, ...]]:
    """Return (drive direction, orbits mirrored if necessary so that their crests drive towards +x).

    All problems are solved for a drive towards +x, so that the answers of mirrored waves are equal and opposite to the
    last bit.
    """
    side = drive_direction(orbits)
    return side, orbits if side > 0.0 else tuple(orbit.mirrored() for orbit in orbits)
