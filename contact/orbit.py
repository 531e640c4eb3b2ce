"""Prescribed harmonic motion of the surface point under each contact.

The displacement is u = Re(amplitude exp(i omega t)) with peak amplitudes; x points along the surface and z out of it,
towards the slider. ``normal=A, tangential=-1j*r*A`` describes an elliptic motion with u_x and u_z in quadrature
whose surface points move towards +x at its crests. A Rayleigh wave of this orbit (retrograde) runs towards -x.
"""

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from contact import parameter_check
from contact.exceptions import InputError

AMPLITUDES = "normal", "tangential", "lateral"  # of an orbit


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
    lateral : complex
        Peak amplitude of u_y, m. Motions along x alone do not depend on it.
    """

    frequency: float
    normal: complex
    tangential: complex
    lateral: complex = 0.0

    def __post_init__(self):
        object.__setattr__(self, "frequency", parameter_check.positive("orbit.frequency", self.frequency, "Hz"))
        for name in AMPLITUDES:
            value = parameter_check.finite_complex(f"orbit.{name}", getattr(self, name), "m")
            object.__setattr__(self, name, value)

    @property
    def omega(self) -> float:
        """Angular frequency, rad/s."""
        return 2.0 * math.pi * self.frequency

    @property
    def crest_velocity(self) -> float:
        """Tangential surface velocity at the time of largest u_z, m/s; zero without normal motion."""
        return float(as_orbits(self).crest_velocities[0])

    @property
    def upward_zero(self) -> float:
        """Angle of the wave in rad at which u_z crosses zero upwards."""
        return -0.5 * math.pi - cmath.phase(self.normal)

    def scaled(self, factor: complex) -> "Orbit":
        """Return the same orbit with its amplitudes multiplied by `factor` (its angle shifts time)."""
        return replace(self, **{name: getattr(self, name) * factor for name in AMPLITUDES})

    def mirrored(self) -> "Orbit":
        """Return the orbit of the wave that travels in the opposite direction (u_x negated)."""
        return replace(self, tangential=-self.tangential)


class Orbits(Sequence):
    """Orbits of one frequency, one for each contact, as arrays; a sequence of `Orbit`.

    Attributes
    ----------
    frequency : float
        Frequency of all orbits in Hz, positive.
    normal, tangential, lateral : ndarray, shape (n,), complex
        Peak amplitudes of u_z, u_x and u_y, m.

    Examples
    --------
    >>> orbits = Orbits(frequency=2.2e6, normal=[1e-9, 2e-9], tangential=[0.7e-9j, 1.4e-9j])
    >>> len(orbits), orbits[1].tangential, orbits.scaled(3.0)[:1].normal
    (2, 1.4e-09j, array([3.e-09+0.j]))
    """

    def __init__(self, *, frequency: float, normal, tangential, lateral=0.0):
        self.frequency = parameter_check.positive("orbit.frequency", frequency, "Hz")
        self.normal, self.tangential = (_amplitudes("normal", normal), _amplitudes("tangential", tangential))
        if self.normal.ndim != 1 or self.normal.size == 0 or self.normal.shape != self.tangential.shape:
            raise InputError("orbits", "must hold at least one orbit, with as many amplitudes u_x as u_z")
        self.lateral = np.broadcast_to(_amplitudes("lateral", lateral), self.normal.shape)

    @classmethod
    def checked(cls, frequency: float, normal, tangential, lateral) -> "Orbits":
        """Return orbits of amplitudes that need no check."""
        orbits = object.__new__(cls)
        orbits.frequency, orbits.normal, orbits.tangential, orbits.lateral = frequency, normal, tangential, lateral
        return orbits

    def __len__(self):
        return self.normal.size

    def __getitem__(self, index):
        u_z, u_x, u_y = self.normal[index], self.tangential[index], self.lateral[index]
        if isinstance(index, slice | np.ndarray):
            return self.checked(self.frequency, u_z, u_x, u_y)
        return Orbit(frequency=self.frequency, normal=complex(u_z), tangential=complex(u_x), lateral=complex(u_y))

    def __eq__(self, other):
        return isinstance(other, Orbits) and self._key == other._key

    def __hash__(self):
        return hash(self._key)

    def __repr__(self):
        amplitudes = ", ".join(f"{name}={getattr(self, name)}" for name in AMPLITUDES)
        return f"Orbits(frequency={self.frequency}, {amplitudes})"

    @property
    def _key(self):
        return self.frequency, *((getattr(self, name) + 0.0).tobytes() for name in AMPLITUDES)  # 0.0 for -0.0

    @property
    def omega(self) -> float:
        """Angular frequency, rad/s."""
        return 2.0 * math.pi * self.frequency

    @cached_property
    def normal_size(self) -> np.ndarray:
        """|u_z| of each orbit, m."""
        return np.hypot(self.normal.real, self.normal.imag)

    @cached_property
    def tangential_size(self) -> np.ndarray:
        """|u_x| of each orbit, m."""
        return np.hypot(self.tangential.real, self.tangential.imag)

    @property
    def reach(self) -> float:
        """Largest amplitude along x or z, m."""
        return float(max(self.normal_size.max(), self.tangential_size.max()))

    @property
    def still(self) -> bool:
        """True if the surface does not move in x and z."""
        return not (self.normal.any() or self.tangential.any())

    @property
    def alike(self) -> bool:
        """True if all contacts move alike along x and z."""
        return bool(np.all(self.normal == self.normal[0]) and np.all(self.tangential == self.tangential[0]))

    @property
    def peak_speed(self) -> float:
        """Largest peak speed omega |u_x| along x, m/s."""
        return float(self.omega * self.tangential_size.max())

    @property
    def crest_velocities(self) -> np.ndarray:
        """Tangential surface velocity of each orbit at the time of largest u_z, m/s; zero without normal motion."""
        return crest_velocities(self.omega, self.normal, self.tangential)

    def scaled(self, factor: complex) -> "Orbits":
        """Return the same orbits with their amplitudes multiplied by `factor` (its angle shifts time)."""
        return self.checked(self.frequency, *(product(getattr(self, name), factor) for name in AMPLITUDES))

    def mirrored(self) -> "Orbits":
        """Return the orbits of the wave that travels in the opposite direction (u_x negated)."""
        return self.checked(self.frequency, self.normal, -self.tangential, self.lateral)


def crest_velocities(omega, normal: np.ndarray, tangential: np.ndarray) -> np.ndarray:
    """Return the tangential surface velocities at the time of largest u_z, m/s; zero without normal motion."""
    forward = omega * tangential.real * normal.imag - omega * tangential.imag * normal.real  # Re(i omega u_x u_z*)
    size = np.hypot(normal.real, normal.imag)
    return np.divide(forward, size, out=np.zeros(size.shape), where=size > 0.0)


def product(amplitudes: np.ndarray, factor: complex) -> np.ndarray:
    """Return complex amplitudes times a factor, rounded alike whatever their number.

    The rounding of numpy's own complex product depends on the processor (fused multiply-add).
    """
    out, factor = np.empty(amplitudes.shape, complex), complex(factor)
    out.real = amplitudes.real * factor.real - amplitudes.imag * factor.imag
    out.imag = amplitudes.real * factor.imag + amplitudes.imag * factor.real
    return out


def _amplitudes(name, values):
    """Return amplitudes in m as a complex array; raise where one is not finite."""
    array = np.asarray(values, complex)
    if not np.isfinite(array).all():
        parameter_check.finite_complex(f"orbit.{name}", complex(array[~np.isfinite(array)][0]), "m")
    return array


def as_orbits(orbits: "Orbit | Orbits | Sequence[Orbit]") -> Orbits:
    """Return `Orbits` of one orbit per contact; all must have one frequency."""
    if isinstance(orbits, Orbits):
        return orbits
    listed = (orbits,) if isinstance(orbits, Orbit) else tuple(orbits)
    if not listed:
        raise InputError("orbits", "must hold at least one Orbit, one per contact, got none")
    for orbit in listed:
        if not isinstance(orbit, Orbit):
            raise InputError("orbits", "must hold objects of type Orbit", orbit)
        if orbit.frequency != listed[0].frequency:
            raise InputError("orbits", f"must share one frequency, got {listed[0].frequency} and {orbit.frequency} Hz")
    return Orbits.checked(
        listed[0].frequency, *np.array([(o.normal, o.tangential, o.lateral) for o in listed]).T.copy()
    )


def drive_direction(orbits: Orbits) -> float:
    """Return +1 or -1, the direction of the surface velocity at the wave crests (+1 if it is zero)."""
    return -1.0 if sum(orbits.crest_velocities.tolist()) < 0.0 else 1.0


def towards_plus(orbits) -> tuple[float, Orbits]:
    """Return (drive direction, orbits mirrored if necessary so that their crests drive towards +x).

    All problems are solved for a drive towards +x, so that the answers of mirrored waves are equal and opposite to the
    last bit.
    """
    listed = as_orbits(orbits)
    side = drive_direction(listed)
    return side, listed if side > 0.0 else listed.mirrored()
