"""Parameters of a slider on many contacts and of the surface wave that passes below it."""

import math
from dataclasses import dataclass, field

import numpy as np

from contact import parameter_check
from contact.exceptions import InputError
from contact.law.normal import SHAPES, stiffness
from contact.slider import Slider

TILTS, BACKINGS = ("held", "pitch", "free"), ("rigid", "soft")


@dataclass(frozen=True, kw_only=True)
class Pillars:
    """A rigid slider on contacts with individual positions, heights and stiffnesses.

    The slider is heavy on the wave's time scale. The contacts are flat pillars, or balls (`balls_of` makes them from a
    `Slider`).

    Attributes
    ----------
    x, y : array_like, shape (n,)
        Positions along and across the wave, from the slider's centre, m.
    normal_stiffness, tangential_stiffness : float or array_like, shape (n,)
        k_n and k_t of each pillar, N/m, positive. For a ball P = k_n z^(3/2) with k_n in N/m^1.5, and
        k_t = 4 (G/E) k_n. In both cases the slip limit is c = mu k_n/k_t times the approach.
    heights : float or array_like, shape (n,)
        Height of each pillar, positive towards the surface, m.
    weights : float or array_like, shape (n,)
        Number of equal pillars that each entry represents, positive.
    friction_coefficient : float
        Coefficient of friction mu, positive. A pillar slips as a whole at |Q| = mu P.
    preload : float
        Normal force on the slider including its weight, N, positive.
    tangential_damping : float
        Viscous damper on the slider's velocity, N s/m.
    tilt : str
        "held" (no rotation), "pitch" (rotation about y) or "free" (rotation about x and y).
    preload_at : tuple of float
        Position (x, y) at which the preload acts, m. It has no effect if `tilt` is "held".
    load_height : float
        Height above the surface at which a load acts, m. It has no effect if `tilt` is "held".
    backing : str
        "rigid": all pillars are on one plane. "soft": every row along the wave carries the same force per pillar.
    curvature : float
        Curvature of the slider's face, 1/m. If it is positive, the middle protrudes: a pillar at (x, y) is set back by
        (x^2 + y^2)/2 times the curvature.
    shape : str
        "punch" (flat pillars, default) or "sphere" (balls).

    Examples
    --------
    >>> slider = Pillars(
    ...     x=[-1e-4, 0.0, 2e-4], y=[0.0, 0.0, 0.0], normal_stiffness=1.8e6, tangential_stiffness=1.52e6,
    ...     friction_coefficient=0.18, preload=9e-3,
    ... )
    >>> slider.number
    3.0
    """

    x: np.ndarray
    y: np.ndarray
    normal_stiffness: np.ndarray
    tangential_stiffness: np.ndarray
    # one number applies to all pillars
    heights: np.ndarray = 0.0  # type: ignore[assignment]
    weights: np.ndarray = 1.0  # type: ignore[assignment]
    friction_coefficient: float
    preload: float
    tangential_damping: float = 0.0
    tilt: str = "held"
    preload_at: tuple[float, float] = (0.0, 0.0)
    load_height: float = 0.0
    backing: str = "rigid"
    curvature: float = 0.0
    shape: str = "punch"

    def __post_init__(self):
        x = np.atleast_1d(np.asarray(self.x, dtype=float))
        if x.ndim != 1 or x.size == 0:
            raise InputError("pillars.x", f"must be a list of at least one position, got the shape {np.shape(self.x)}")
        for name, unit in (
            ("x", "m"), ("y", "m"), ("heights", "m"), ("normal_stiffness", "N/m"), ("tangential_stiffness", "N/m"),
            ("weights", ""),
        ):  # fmt: skip
            value = np.asarray(getattr(self, name), dtype=float)
            if value.ndim > 1 or (value.ndim == 1 and value.size != x.size):
                raise InputError(f"pillars.{name}", f"must hold one value for each of the {x.size} pillars")
            if not np.all(np.isfinite(value)):
                raise InputError(f"pillars.{name}", "must be finite", value[~np.isfinite(value)].flat[0], unit)
            if name.endswith(("stiffness", "weights")) and not np.all(value > 0.0):
                raise InputError(f"pillars.{name}", "must be positive", float(value.min()), unit)
            object.__setattr__(self, name, np.broadcast_to(value, x.shape))
        for name, unit, rule in (
            ("friction_coefficient", "", parameter_check.positive), ("preload", "N", parameter_check.positive),
            ("tangential_damping", "N s/m", parameter_check.non_negative), ("load_height", "m", parameter_check.finite),
            ("curvature", "1/m", parameter_check.finite),
        ):  # fmt: skip
            object.__setattr__(self, name, rule(f"pillars.{name}", getattr(self, name), unit))
        at = tuple(parameter_check.finite("pillars.preload_at", each, "m") for each in self.preload_at)
        object.__setattr__(self, "preload_at", at)
        parameter_check.choice("pillars.shape", self.shape, SHAPES)
        parameter_check.choice("pillars.tilt", self.tilt, TILTS)
        parameter_check.choice("pillars.backing", self.backing, BACKINGS)
        if self.backing == "soft" and self.tilt != "held":
            rule = 'must be "held" with a soft backing, which has no plane to tilt'
            raise InputError("pillars.tilt", rule, self.tilt)
        self._check_tilt()

    def _check_tilt(self):
        """Raise if the pillars lie on a line and cannot support a tilt, or if the preload acts outside the pillars."""
        if self.tilt == "held":
            return
        for name, positions in (("x", self.x), ("y", self.y))[: 1 if self.tilt == "pitch" else 2]:
            if np.ptp(positions) == 0.0:
                raise InputError("pillars.tilt", f'must be "held" where all pillars have the same {name}')
        self.preload_point(0.0)

    def preload_point(self, load: float) -> tuple[float, float]:
        """Return where the preload acts together with a load in N along -x, m; raise if it lifts a side that may tilt.

        A load at a height b above the surface shifts the point by -b load/preload.
        """
        x, y = self.preload_at
        x -= self.load_height * load / self.preload
        lifts = "" if self.tilt == "held" else self.lifts(x, y)
        if not lifts:
            return x, y
        rest = f"within the pillars unless the tilt is held, got ({x:g}, {y:g}) m: no equilibrium, the {lifts} lifts"
        if self.lifts(*self.preload_at):
            raise InputError("pillars.preload_at", f"must lie {rest}")
        raise InputError("pillars.load_height", f"must keep preload and load of {abs(load):.4g} N {rest}")

    def lifts(self, x: float, y: float) -> str:
        """Return which side lifts off under a force at (x, y), or an empty string where the pillars carry it."""
        if not self.x.min() < x < self.x.max():
            return "side at smaller x" if x >= self.x.max() else "side at larger x"
        if self.tilt != "free":
            return ""
        if not self.y.min() < y < self.y.max():
            return "side at smaller y" if y >= self.y.max() else "side at larger y"
        # within the convex hull: no direction in which all pillars lie behind the point
        angle = np.sort(np.arctan2(self.y - y, self.x - x))
        gaps = np.diff(np.append(angle, angle[0] + 2.0 * math.pi))
        if gaps.max() >= math.pi:
            towards = math.degrees(angle[int(gaps.argmax())] + 0.5 * gaps.max()) + 180.0
            return f"side at {towards % 360.0:.0f} degrees from the wave's direction"
        return ""

    @property
    def number(self) -> float:
        """Number of pillars, that of their weights."""
        return float(self.weights.sum())

    @property
    def limit_slope(self) -> np.ndarray:
        """Slip limit over the approach, c = mu k_n/k_t, of each pillar."""
        return self.friction_coefficient * self.normal_stiffness / self.tangential_stiffness


def balls_of(slider: Slider, x, y=0.0, *, radius=None, weights=1.0) -> Pillars:
    """Return the contacts of a `Slider` at their own positions, balls or punches of one material.

    Parameters
    ----------
    slider : Slider
        With the elastic law and Coulomb's friction; its preload is carried by all of them.
    x, y : array_like, shape (n,)
        Positions from the slider's centre, m.
    radius : float or array_like, shape (n,), optional
        Of each contact, m; None: `slider.radius`.
    weights : float or array_like, shape (n,)
        How many equal contacts each of them stands for.

    Examples
    --------
    >>> slider = Slider(
    ...     radius=1e-3, mass=8.9e-5, preload=8.7e-4, load=0.0, friction_coefficient=0.08, effective_modulus=64e9,
    ...     tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0,
    ...     normal_damping=0.5, tangential_damping=1e-4,
    ... )
    >>> float(balls_of(slider, x=[0.0, 1e-3], radius=[1e-3, 4e-3]).normal_stiffness @ [-0.5, 0.25])
    0.0
    """
    if slider.law != "elastic" or slider.reciprocal or slider.stick_band > 0.0 or slider.friction is not None:
        raise InputError("slider.law", 'must be "elastic", not reciprocal, with Coulomb\'s friction and no stick band')
    x = np.atleast_1d(np.asarray(x, dtype=float))
    radii = np.broadcast_to(np.asarray(slider.radius if radius is None else radius, dtype=float), x.shape)
    for each in radii:
        parameter_check.positive("radius", each, "m")
    k_n = stiffness(radii, slider.effective_modulus, slider.contact_shape)
    return Pillars(
        x=x, y=np.broadcast_to(np.asarray(y, dtype=float), x.shape), normal_stiffness=k_n,
        tangential_stiffness=4.0 * slider.tangential_modulus / slider.effective_modulus * k_n,
        heights=slider.offsets(x.size), weights=weights, friction_coefficient=slider.friction_coefficient,
        preload=slider.preload, tangential_damping=slider.tangential_damping, shape=slider.shape,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class PassingWave:
    """Surface waves that run below a slider from both sides, as they would be without it.

    u_z(x) = forward exp(-i k x) + backward exp(+i k x), times exp(+i omega t), x from the slider's centre;
    u_x = i r u_z of the forward and -i r u_z of the backward wave.

    Attributes
    ----------
    frequency, wavelength : float
        Hz and m, positive.
    ratio : float or complex
        r = |u_x/u_z|; or, for a general cut, a complex r: the forward wave has u_x = i r u_z, the backward one the
        conjugate, u_x = (i r)* u_z.
    forward, backward : complex
        Peak amplitudes of u_z at the slider's centre, m.
    compliance : float
        Gamma, 1/Pa: G_zz = Gamma/(k - k_R) near the pole; the wave's power per width is |U|^2 omega/(4 Gamma). 0: the
        slider does not act back on the wave.
    strip_width : float
        Width w over which the pillars spread their load, m; required with a compliance.

    Examples
    --------
    >>> wave = PassingWave(
    ...     frequency=9.61e6, wavelength=414.05e-6, ratio=0.88995, forward=20e-9,
    ...     compliance=2.5078e-12, strip_width=5e-3,
    ... )
    >>> round(wave.power(wave.forward), 2)  # W
    12.04
    """

    frequency: float
    wavelength: float
    ratio: complex
    forward: complex = 0.0
    backward: complex = 0.0
    compliance: float = 0.0
    strip_width: float | None = None
    orbit: complex = field(init=False, repr=False)  # u_x/u_z of the forward wave

    def __post_init__(self):
        for name, unit in (("frequency", "Hz"), ("wavelength", "m")):
            object.__setattr__(self, name, parameter_check.positive(f"wave.{name}", getattr(self, name), unit))
        for name, unit in (("ratio", ""), ("forward", "m"), ("backward", "m")):
            object.__setattr__(self, name, parameter_check.finite_complex(f"wave.{name}", getattr(self, name), unit))
        object.__setattr__(self, "compliance", parameter_check.non_negative("wave.compliance", self.compliance, "1/Pa"))
        object.__setattr__(self, "orbit", 1j * self.ratio)
        if self.compliance > 0.0:
            if self.strip_width is None:
                raise InputError("wave.strip_width", "is required with wave.compliance: Gamma acts per width")
            object.__setattr__(self, "strip_width", parameter_check.positive("wave.strip_width", self.strip_width, "m"))

    @property
    def omega(self) -> float:
        """rad/s."""
        return 2.0 * math.pi * self.frequency

    @property
    def wavenumber(self) -> float:
        """k, rad/m."""
        return 2.0 * math.pi / self.wavelength

    @property
    def amplitude(self) -> float:
        """Amplitude of the larger of both waves, m."""
        return max(abs(self.forward), abs(self.backward))

    @property
    def compliance_per_width(self) -> float:
        """Gamma/w, 1/(Pa m); 0 where Gamma is not known."""
        return 0.0 if self.strip_width is None else self.compliance / self.strip_width

    def power(self, amplitude: complex) -> float:
        """Return the power in W of one wave of this amplitude within the strip; 0 where Gamma is not known."""
        if self.compliance == 0.0 or self.strip_width is None:
            return 0.0
        return float(abs(amplitude)) ** 2 * self.omega * self.strip_width / (4.0 * self.compliance)

    def loading_number(self, preload: float) -> float:
        """Return Lambda = 2 Gamma F/(w A), about the phase advance in rad under a hopping slider; 0 without Gamma."""
        return 2.0 * self.compliance_per_width * preload / self.amplitude if self.amplitude > 0.0 else 0.0
