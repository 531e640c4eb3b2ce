r"""The motion of a surface under contacts in the plane: several frequencies, three components, several directions.

Time dependence exp(+i omega t), complex peak amplitudes; x and y along the surface, z out of it. A plane wave towards
the direction beta has u_along = i r u_z, as the forward wave of `contact.PassingWave`: it drives towards -beta.
"""

import cmath
import math
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from contact import parameter_check
from contact.exceptions import InputError


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceWaves:
    """Motion of the surface under each contact.

    Attributes
    ----------
    frequencies : (w,) array
        Hz, positive, each different.
    amplitudes : (w, n, 3) array, complex
        Peak amplitudes (u_x, u_y, u_z) under each of n contacts, m.

    Examples
    --------
    >>> x_wave = SurfaceWaves(frequencies=[2.2e6], amplitudes=[[[-6.7e-9j, 0.0, 10e-9]]])
    >>> bool(np.allclose(x_wave.turned(math.pi / 2).amplitudes, [[[0.0, -6.7e-9j, 10e-9]]]))
    True
    """

    frequencies: np.ndarray
    amplitudes: np.ndarray

    def __post_init__(self):
        frequencies, amplitudes = np.array(self.frequencies, float), np.array(self.amplitudes, complex)
        if frequencies.ndim != 1 or frequencies.size == 0 or np.unique(frequencies).size != frequencies.size:
            raise InputError("wave.frequencies", "must be a list of different frequencies in Hz", frequencies.tolist())
        for each in frequencies:
            parameter_check.positive("wave.frequencies", float(each), "Hz")
        if amplitudes.ndim != 3 or amplitudes.shape[0] != frequencies.size or amplitudes.shape[2] != 3:
            raise InputError(
                "wave.amplitudes", f"must have the shape ({frequencies.size}, contacts, 3)", str(amplitudes.shape)
            )
        if not np.isfinite(amplitudes).all():
            raise InputError("wave.amplitudes", "must be finite, m")
        for name, value in (("frequencies", frequencies), ("amplitudes", amplitudes)):
            value.flags.writeable = False
            object.__setattr__(self, name, value)

    @property
    def count(self) -> int:
        """Number of contacts."""
        return self.amplitudes.shape[1]

    @property
    def omega(self) -> float:
        """The largest angular frequency, rad/s."""
        return 2.0 * math.pi * float(self.frequencies.max())

    @property
    def peak_speed(self) -> float:
        """Largest tangential speed of the surface that the amplitudes allow, m/s."""
        speeds = 2.0 * math.pi * self.frequencies[:, None] * np.linalg.norm(self.amplitudes[..., :2], axis=2)
        return float(speeds.sum(axis=0).max())

    def scaled(self, factor: complex) -> "SurfaceWaves":
        """Return the motion with all amplitudes multiplied by a factor."""
        return replace(self, amplitudes=self.amplitudes * factor)

    def later(self, time: float) -> "SurfaceWaves":
        """Return the motion whose time begins at a later time in s."""
        turn = np.exp(2j * math.pi * self.frequencies * time)
        return replace(self, amplitudes=self.amplitudes * turn[:, None, None])

    @property
    def upward_zero(self) -> float:
        """Angle of the fastest wave in rad, 0 to 2 pi, at which its u_z of the first contact crosses zero upwards."""
        normal = self.amplitudes[int(np.argmax(self.frequencies)), 0, 2]
        return (-0.5 * math.pi - cmath.phase(complex(normal))) % (2.0 * math.pi)

    def turned(self, angle: float) -> "SurfaceWaves":
        """Return the motion turned by an angle in rad, positive from x to y."""
        turn = np.array([[math.cos(angle), math.sin(angle), 0], [-math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
        return replace(self, amplitudes=self.amplitudes @ turn)


class Field(Protocol):
    """A surface whose motion is known at every place."""

    def at(self, x: np.ndarray, y: np.ndarray) -> SurfaceWaves:
        """Return the motion at positions (n,) in m, from where the slider's centre starts."""
        ...


@dataclass(frozen=True, kw_only=True)
class PlaneWave:
    """One plane wave.

    Attributes
    ----------
    frequency, wavelength : float
        Hz and m, positive.
    direction : float
        Direction in which it runs, rad from x towards y.
    normal : complex
        Peak u_z at the origin, m.
    ratio : complex
        r of u_along = i r u_z.
    """

    frequency: float
    wavelength: float
    direction: float
    normal: complex
    ratio: complex

    def __post_init__(self):
        for name, unit in (("frequency", "Hz"), ("wavelength", "m")):
            object.__setattr__(self, name, parameter_check.positive(f"wave.{name}", getattr(self, name), unit))
        object.__setattr__(self, "direction", parameter_check.finite("wave.direction", self.direction, "rad"))
        for name, unit in (("normal", "m"), ("ratio", "")):
            object.__setattr__(self, name, parameter_check.finite_complex(f"wave.{name}", getattr(self, name), unit))

    def at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the amplitudes (n, 3) at positions in m."""
        towards = np.array([math.cos(self.direction), math.sin(self.direction)])
        path = towards[0] * np.asarray(x) + towards[1] * np.asarray(y)
        u_z = self.normal * np.exp(-2j * math.pi / self.wavelength * path)
        along = 1j * self.ratio * u_z
        return np.stack([along * towards[0], along * towards[1], u_z], axis=-1)


@dataclass(frozen=True, kw_only=True)
class PlaneWaves:
    """Several plane waves on one surface.

    Examples
    --------
    >>> beam = PlaneWave(frequency=2.2e6, wavelength=1.8e-3, direction=math.pi, normal=10e-9, ratio=0.67)
    >>> surface = PlaneWaves(waves=(beam,))
    >>> surface.at(np.array([0.0, 0.9e-3]), np.zeros(2)).count
    2
    """

    waves: tuple[PlaneWave, ...]

    def at(self, x: np.ndarray, y: np.ndarray) -> SurfaceWaves:
        """Return the motion at positions in m; waves of one frequency are added."""
        x, y = np.broadcast_arrays(np.atleast_1d(x), np.atleast_1d(y))
        frequencies = list(dict.fromkeys(wave.frequency for wave in self.waves))
        amplitudes = np.zeros((len(frequencies), x.size, 3), complex)
        for wave in self.waves:
            amplitudes[frequencies.index(wave.frequency)] += wave.at(x, y)
        return SurfaceWaves(frequencies=np.array(frequencies), amplitudes=amplitudes)


Surface = SurfaceWaves | Field


@dataclass(frozen=True, kw_only=True)
class Later:
    """A field of waves whose time begins at a later time in s."""

    surface: Field
    time: float

    def at(self, x: np.ndarray, y: np.ndarray) -> SurfaceWaves:
        """Return the motion at positions (n,) in m."""
        return self.surface.at(x, y).later(self.time)


def from_upward_zero(slider, surface: Surface) -> Surface:
    """Return the waves with a time that begins where u_z of the first contact crosses zero upwards.

    So begins a burst along x (`contact.burst`).  The waves keep their phases against each other; of several frequencies
    it is u_z of the fastest.

    Examples
    --------
    >>> from contact import Slider
    >>> slider = Slider(
    ...     radius=1e-3, mass=1e-7, preload=0.87309e-3, load=(0.0, 0.0), friction_coefficient=0.08,
    ...     effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0,
    ...     contact_damping=0.0, normal_damping=0.05, tangential_damping=0.0, freedom="xy",
    ... )
    >>> waves = from_upward_zero(slider, SurfaceWaves(frequencies=[2.2e6], amplitudes=[[[-1.34e-9j, 0.0, 2e-9]]]))
    >>> (1e9 * waves.amplitudes).round(6) + 0.0  # u_z = 2 nm sin(omega t)
    array([[[-1.34+0.j,  0.  +0.j,  0.  -2.j]]])
    """
    waves = surface_under(slider, surface)
    time = waves.upward_zero / waves.omega
    return waves.later(time) if isinstance(surface, SurfaceWaves) else Later(surface=surface, time=time)


def surface_under(slider, surface: Surface, pose=(0.0, 0.0, 0.0)) -> SurfaceWaves:
    """Return the motion under the contacts of a slider at a pose (x, y, yaw) in m and rad.

    A motion given at the contacts alone is that of any pose.
    """
    if isinstance(surface, SurfaceWaves):
        return surface
    return surface.at(*places(slider, pose))


def places(slider, pose) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions of the contacts at a pose, which turns about the axle or the centre."""
    n = slider.count
    x, y = (np.broadcast_to(each, (n,)).astype(float) for each in (slider.x, slider.y))
    about = slider.axis if slider.freedom == "axle" else (0.0, 0.0)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    x, y = x - about[0], y - about[1]
    return pose[0] + about[0] + c * x - s * y, pose[1] + about[1] + s * x + c * y
