"""The Rayleigh wave of a half-space, without a mesh.

A wave exp(i(omega t - k x)) over a body at z < 0 leaves its surface free of traction where an eigenvalue
of the surface impedance (stroh.py) is zero.  The eigenvalues are real and fall with v up to the limiting
velocity, so each crosses zero at most once and bisection cannot miss it.  With v = v_limit sin(angle)
they are analytic up to the limit, and a few steps of regula falsi give all digits.

Limits: only waves below the limiting velocity of the coupled fields.  A leaky one is refused.
"""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Literal, get_args

import numpy as np

from fem.analytic.stroh import SurfaceImpedance, limiting_velocity
from fem.exceptions import ConvergenceError
from fem.materials import Solid, fields
from fem.materials.medium import Medium, medium
from fem.parameters import InputError, non_negative, positive

Surface = Literal["vacuum", "open", "metallised"]
SURFACES: tuple[Surface, ...] = get_args(Surface)

_DISPLACEMENTS = ("ux", "uy", "uz")
BELOW_LIMIT = 1e-9  # relative distance of the largest velocity that is searched from the limiting velocity
_ROOT_STEPS = 60


@dataclass(frozen=True, kw_only=True)
class HalfSpaceWave:
    """A surface wave, normalised to u_z = 1 at the surface.

    Attributes
    ----------
    solid : Solid
    surface : str
        "vacuum", "open" (D_n = 0) or "metallised" (phi = 0).
    fields : tuple of str
        Fields that take part.
    velocity : float
        m/s.
    limiting_velocity : float
        Of the coupled bulk waves along the surface, m/s.
    displacement : ndarray, shape (3,), complex
        u_x, u_y, u_z at the surface; u_x = i |u_x| is retrograde.
    potential : complex
        V per m of u_z at the surface.
    """

    solid: Solid
    surface: str
    fields: tuple[str, ...]
    velocity: float
    limiting_velocity: float
    displacement: np.ndarray
    potential: complex
    _decay: np.ndarray = field(repr=False)
    _amplitude: np.ndarray = field(repr=False)
    _potential_unit: float = field(repr=False)

    @property
    def surface_ratio(self) -> float:
        """|u_x / u_z| at the surface."""
        return float(abs(self.displacement[0]))

    def profile(self, depth) -> tuple[np.ndarray, np.ndarray]:
        """Return displacement and potential against depth.

        Parameters
        ----------
        depth : array_like, shape (n,)
            Below the surface, in wavelengths; 0 or positive.

        Returns
        -------
        displacement : ndarray, shape (n, 3), complex
        potential : ndarray, shape (n,), complex
            V per m of u_z at the surface.
        """
        from scipy.linalg import expm

        depth = np.atleast_1d(np.asarray(depth, dtype=float))
        non_negative("depth", depth.min(initial=0.0), "wavelengths")
        amplitudes = expm(2j * np.pi * depth[:, None, None] * self._decay) @ self._amplitude
        return expanded(amplitudes, self.fields, self._potential_unit)


def surface_named(word: str) -> Surface:
    """Return the member of `SURFACES` that a word stands for, "free" for "vacuum"; a ValueError for any other word."""
    for surface in SURFACES:
        if surface == ("vacuum" if word == "free" else word):
            return surface
    raise InputError("surface", f"must be one of {', '.join(SURFACES)} or free", word)


@lru_cache(maxsize=256)  # one run asks for the same wave about ten times
def rayleigh(solid: Solid, surface: str = "vacuum") -> HalfSpaceWave:
    """Return the Rayleigh wave of a half-space.

    Parameters
    ----------
    solid : Solid
        In the frame x along the propagation, z out of the surface; its losses are ignored.
    surface : str
        "vacuum" (or "free"), "open" (D_n = 0), "metallised" (phi = 0).

    Raises
    ------
    ValueError
        For an unknown surface.
    ConvergenceError
        If the cut has no subsonic wave with sagittal motion: what propagates is leaky or shear-horizontal.
    """
    surface = surface_named(surface)
    names, body, _ = _bulk(solid)
    impedance, limit = surface_impedance(solid, surface)
    unit = impedance.velocity_unit
    top = np.arcsin(1.0 - BELOW_LIMIT)
    waves = int(np.sum(impedance.eigenvalues(limit * np.sin(top)) < 0))
    for index in range(waves):
        angle = falling_root(lambda angle, i=index: impedance.eigenvalues(limit * np.sin(angle))[i], top)
        velocity = limit * np.sin(angle)
        amplitude = impedance.mode(velocity, index)
        displacement, potential = expanded(amplitude, names, body.potential_unit)
        if 2 * abs(displacement[1]) ** 2 > np.linalg.norm(displacement) ** 2:
            continue
        scale = displacement[2]
        return HalfSpaceWave(
            solid=solid,
            surface=surface,
            fields=names,
            velocity=float(velocity * unit),
            limiting_velocity=float(limit * unit),
            displacement=displacement / scale,
            potential=complex(potential / scale),
            _decay=impedance.decay(velocity),
            _amplitude=amplitude / scale,
            _potential_unit=body.potential_unit,
        )
    exists = "only a shear-horizontal wave" if waves else "no surface wave"
    raise ConvergenceError(
        f"{solid.name} ({solid.frame}), surface {surface}: {exists} below the limiting velocity "
        f"{limit * unit:.1f} m/s; the Rayleigh wave of this cut is leaky. Try another orientation"
    )


def surface_impedance(solid: Solid, surface: str) -> tuple[SurfaceImpedance, float]:
    """Return the impedance of a half-space and its limiting velocity over the impedance's ``velocity_unit``."""
    _, body, limit = _bulk(solid)
    return SurfaceImpedance(body, surface_named(surface)), limit


def coupling(solid: Solid) -> float:
    """Return K2 = 2 (v_vacuum - v_metallised) / v_vacuum of a solid in the frame of the cut."""
    if "phi" not in fields(solid):
        return 0.0
    free, metallised = (rayleigh(solid, surface).velocity for surface in ("vacuum", "metallised"))
    return 2 * (free - metallised) / free


@lru_cache(maxsize=16)
def _bulk(solid: Solid) -> tuple[tuple[str, ...], Medium, float]:
    """Fields, scaled tables and limiting velocity, which all surfaces of a solid share."""
    names = fields(solid)
    body = medium(solid, names, lossy=False)
    return names, body, limiting_velocity(body)


def falling_root(function, top: float) -> float:
    """Zero of a falling function on (0, top): bracketed, by the Anderson-Bjorck variant of regula falsi."""
    low, high = top / 2, top
    f_low, f_high = function(low), function(high)
    while f_low < 0:
        low, high, f_high = low / 2, low, f_low
        f_low = function(low)
    above = None  # True if the last value was above zero
    for _ in range(_ROOT_STEPS):
        new = (low * f_high - high * f_low) / (f_high - f_low)
        f_new = function(new)
        step = min(abs(new - low), abs(new - high))
        if step < 1e-15 * top or abs(f_new) * (high - low) < 1e-15 * top * (f_low - f_high):
            return new
        repeated, above = above is (f_new > 0), f_new > 0
        ratio = f_new / (f_low if above else f_high)
        reduction = 1.0 if not repeated else (1 - ratio if ratio < 1 else 0.5)
        if above:
            low, f_low, f_high = new, f_new, f_high * reduction
        else:
            high, f_high, f_low = new, f_new, f_low * reduction
    raise ConvergenceError(f"surface impedance has no root after {_ROOT_STEPS} steps")


def expanded(amplitudes: np.ndarray, names: tuple[str, ...], potential_unit: float):
    """Displacement (..., 3) and potential (...) in V/m of scaled amplitudes (..., fields)."""
    displacement = np.zeros((*amplitudes.shape[:-1], 3), dtype=complex)
    potential = np.zeros(amplitudes.shape[:-1], dtype=complex)
    for index, name in enumerate(names):
        if name == "phi":
            potential[...] = amplitudes[..., index] * potential_unit
        else:
            displacement[..., _DISPLACEMENTS.index(name)] = amplitudes[..., index]
    return displacement, potential


def automatic_period(solid: Solid, frequency: float, metallisation: float) -> float:
    """Return the period in m that a transducer on a solid in the stator's frame needs at a frequency in Hz.

    It is the wavelength of the lossless half-space, part metallised, (metallisation v_metal + (1 - metallisation)
    v_vacuum) over the frequency; metallisation: finger width over finger width plus gap.
    """
    positive("frequency", frequency, "Hz")
    metal, vacuum = rayleigh(solid, "metallised").velocity, rayleigh(solid, "vacuum").velocity
    return (metallisation * metal + (1 - metallisation) * vacuum) / frequency
