"""Leaky waves of layers on a half-space: faster than its slowest bulk wave, to which they lose power.

At a real frequency the wavenumber is complex, k = omega/v with Im v > 0, so that exp(-i k x) decays along +x.  In the
half-space the partial waves are the outgoing ones: at the real part of v those that decay downwards and those that
carry power downwards; towards the complex v each is continued, so that the radiated wave grows with depth, as a wave
that left the surface earlier, where there was more of it (Farnell, *Physical Acoustics* VI (1970), chapter 3).  The
determinant of the surface's impedance, which is no longer Hermitian, vanishes at v.

The real determinant has no zeros above the limit; the search begins at the minima of its size on the real axis.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fem.analytic.half_space import surface_named
from fem.analytic.layered import LayeredImpedance
from fem.exceptions import ConvergenceError
from fem.geometry import Layer
from fem.materials import Solid

GRID, FASTEST = 400, 1.6  # velocities of the search, up to so many times the slowest bulk wave of the half-space
ABOVE_LIMIT = 1e-6  # relative distance of the slowest from the limit, where two partial waves coincide
CONTINUED = 12  # steps from the real velocity to the complex one
MAX_ATTENUATION = 0.1  # |Im k| / |Re k|: 5.5 dB in a wavelength, which is no wave along the surface any more
DECIBELS = 20.0 * math.log10(math.e) * 2.0 * math.pi  # in a wavelength, for |Im k| / |Re k| = 1
RESIDUAL = 1e-9  # of the determinant at a root, over its size beside it


@dataclass(frozen=True, kw_only=True)
class LeakyWave:
    """A wave along the surface that radiates into the half-space.

    Attributes
    ----------
    velocity : float
        omega / Re k, m/s.
    attenuation : float
        -Im k / Re k; times 2 pi it is nepers in a wavelength.
    displacement : ndarray, shape (3,), complex
        At the top, u_z = 1 (u_y = 1 for a transverse wave).
    transverse : bool
        True if u_y is larger than the sagittal motion.
    limiting_velocity : float
        Of the slowest bulk wave of the half-space along the surface, m/s.
    """

    velocity: float
    attenuation: float
    displacement: np.ndarray
    transverse: bool
    limiting_velocity: float

    @property
    def decibels(self) -> float:
        """Attenuation in dB in a wavelength.

        Examples
        --------
        >>> import fem
        >>> cut = fem.rotated(fem.material("LiNbO3 (Warner)"), "64YX")
        >>> print(f"{fem.leaky_waves(cut, surface='metallised')[0].velocity:.0f}")
        4475
        """
        return DECIBELS * self.attenuation

    @property
    def surface_ratio(self) -> float:
        """|u_x / u_z| at the top."""
        return float(abs(self.displacement[0] / self.displacement[2]))


def leaky_waves(
    substrate: Solid, layers: Sequence[Layer] = (), *, surface: str = "vacuum", frequency: float | None = None
) -> tuple[LeakyWave, ...]:
    """Return the leaky waves of layers on a half-space, the least attenuated first.

    Parameters
    ----------
    substrate, layers, surface, frequency
        As in `layered_waves`; thicknesses in wavelengths are those of Re k.

    Raises
    ------
    InputError
        For an unknown surface or a missing frequency.
    ConvergenceError
        If none is found up to `FASTEST` times the slowest bulk wave.
    """
    surface = surface_named(surface)
    impedance = LayeredImpedance(substrate, layers, frequency=frequency)
    grid = impedance.limit * np.linspace(1.0 + ABOVE_LIMIT, FASTEST, GRID)

    def determinant(velocity: complex) -> complex:
        return complex(np.linalg.det(impedance.outgoing(velocity, CONTINUED, surface=surface)))

    sizes = np.array([abs(np.linalg.eigvals(impedance.outgoing(each, 0, surface=surface))).min() for each in grid])
    starts = np.flatnonzero((sizes <= np.roll(sizes, 1)) & (sizes <= np.roll(sizes, -1)))
    found: list[LeakyWave] = []
    for start in grid[starts]:
        velocity = _root(determinant, start)
        if velocity is None or not impedance.limit < velocity.real < FASTEST * impedance.limit:
            continue
        attenuation = velocity.imag / velocity.real  # -Im k / Re k of k = omega/v
        repeated = any(abs(each.velocity / _phase(velocity) - 1.0) < 1e-9 for each in found)
        if not 0.0 < attenuation < MAX_ATTENUATION or repeated:
            continue
        matrix = impedance.outgoing(velocity, CONTINUED, surface=surface)
        motion = np.linalg.svd(matrix)[2][-1].conj()
        displacement = np.zeros(3, dtype=complex)
        names = [name for name in impedance.fields if name != "phi"]
        displacement[[("ux", "uy", "uz").index(name) for name in names]] = motion
        transverse = bool(2.0 * abs(displacement[1]) ** 2 > np.linalg.norm(displacement) ** 2)
        found.append(LeakyWave(
            velocity=_phase(velocity), attenuation=attenuation, transverse=transverse,
            displacement=displacement / displacement[1 if transverse else 2], limiting_velocity=impedance.limit,
        ))  # fmt: skip
    if not found:
        raise ConvergenceError(
            f"no leaky wave from {impedance.limit:.1f} m/s, the slowest bulk wave of {substrate.name}, to "
            f"{grid[-1]:.1f} m/s that loses less than {DECIBELS * MAX_ATTENUATION:.2g} dB in a "
            "wavelength"
        )
    return tuple(sorted(found, key=lambda each: each.attenuation))


def _phase(velocity: complex) -> float:
    """Return omega / Re k."""
    return abs(velocity) ** 2 / velocity.real


def _root(function, start: float) -> complex | None:
    """Return the zero of an analytic function near a real start by the secant method, or None."""
    before, here = complex(start), start * (1.0 + 1e-5 + 1e-5j)
    at_before, at_here = function(before), function(here)
    size = abs(at_before)
    for _ in range(50):
        if at_here == at_before:
            return None
        step = at_here * (here - before) / (at_here - at_before)
        before, at_before = here, at_here
        here = here - step
        if not 0.5 * start < here.real < 2.0 * start or abs(here.imag) > 0.3 * start:
            return None
        at_here = function(here)
        if abs(step) < 1e-13 * start:
            return here if abs(at_here) < RESIDUAL * size else None
    return here if abs(at_here) < RESIDUAL * size else None
