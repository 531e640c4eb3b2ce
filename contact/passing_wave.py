"""The surface wave under a slider: prescribed orbits, or plane waves from both sides that the slider may load."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from contact import parameter_check
from contact.exceptions import ConvergenceError, InputError
from contact.orbit import Orbit, Orbits, as_orbits, drive_direction
from contact.parameter_check import refuse_if
from contact.slider import Slider

HARMONICS = "harmonics"  # value of `loading` that includes the overtones of the wave
LOADED = 0.05  # loading number above which the slider acts back on the wave if `loading` is None


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
        Width w over which the contacts spread their load, m; required with a compliance.
    loading : bool or "harmonics", optional
        True if the contacts act back on the wave. None means True if the loading number is above 0.05. "harmonics" also
        includes the overtones that the contact forces radiate; on a bare crystal, which has no dispersion, they add up
        in phase along the slider.

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
    loading: bool | str | None = None
    orbit: complex = field(init=False, repr=False)  # u_x/u_z of the forward wave

    def __post_init__(self):
        for name, unit in (("frequency", "Hz"), ("wavelength", "m")):
            object.__setattr__(self, name, parameter_check.positive(f"wave.{name}", getattr(self, name), unit))
        for name, unit in (("ratio", ""), ("forward", "m"), ("backward", "m")):
            object.__setattr__(self, name, parameter_check.finite_complex(f"wave.{name}", getattr(self, name), unit))
        object.__setattr__(self, "compliance", parameter_check.non_negative("wave.compliance", self.compliance, "1/Pa"))
        object.__setattr__(self, "orbit", 1j * self.ratio)
        if self.compliance > 0.0:
            refuse_if(
                self.strip_width is None, "wave.strip_width", "is required with wave.compliance: Gamma acts per width"
            )
            object.__setattr__(self, "strip_width", parameter_check.positive("wave.strip_width", self.strip_width, "m"))
        refuse_if(
            self.loading not in (None, False, True, HARMONICS),
            "wave.loading",
            f'must be true, false or "{HARMONICS}"',
            self.loading,
        )

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

    def loaded_by(self, preload: float) -> bool:
        """Return True if a slider under a preload in N acts back on the wave."""
        loading = self.loading_number(preload) > LOADED if self.loading is None else self.loading
        refuse_if(
            loading and self.compliance == 0.0,
            "wave.compliance",
            "(Gamma, 1/Pa) is required where the slider loads the wave",
        )
        return bool(loading) and self.amplitude > 0.0

    @property
    def peak_speed(self) -> float:
        """Peak speed omega |u_x| of the larger wave along x, m/s."""
        return self.omega * abs(self.orbit) * self.amplitude

    def scaled(self, factor: complex) -> "PassingWave":
        """Return the same wave with both amplitudes multiplied by a factor."""
        return replace(self, forward=self.forward * factor, backward=self.backward * factor)

    def orbits_at(self, x) -> Orbits:
        """Return the motion of the surface at positions in m from the slider's centre, as it is without the slider."""
        turn = np.exp(-1j * self.wavenumber * np.atleast_1d(x))
        forward, backward = self.forward * turn, self.backward * turn.conj()
        normal, along = forward + backward, self.orbit * forward + self.orbit.conjugate() * backward
        return Orbits(frequency=self.frequency, normal=normal, tangential=along)


# The motion of the surface under a slider: one orbit, one per contact, or waves that give it at each place
Surface = Orbit | Sequence[Orbit] | PassingWave


def crest_direction(orbits) -> float:
    """Return +1 or -1, the direction of the surface velocity at the crests of orbits or of the larger wave."""
    if not isinstance(orbits, PassingWave):
        return drive_direction(as_orbits(orbits))
    return -1.0 if orbits.orbit.imag * (abs(orbits.forward) ** 2 - abs(orbits.backward) ** 2) > 0.0 else 1.0


def frequency(orbits) -> float:
    """Return the frequency of orbits or of a passing wave, Hz."""
    return (orbits if isinstance(orbits, PassingWave) else as_orbits(orbits)).frequency


def resonance_ratio(slider: Slider, orbits) -> float:
    """Return the contact resonance of a slider over the frequency of orbits, or of a passing wave."""
    contacts = slider.count if isinstance(orbits, PassingWave) else len(as_orbits(orbits))
    return slider.normal_resonance(contacts) / frequency(orbits)


def coupling(slider: Slider, orbits) -> tuple[str, ...]:
    """Return why the motion of the surface, or of the body, is not known before the forces; empty if it is.

    ``orbits``: `Orbit`, a sequence of them, or a `PassingWave`.
    """
    refuse_if(
        slider.freedom != "x",
        "slider.freedom",
        'must be "x" for this question; contact.plane answers those of the plane',
    )
    why: tuple[str, ...] = ("the slider tilts",) if slider.tilt != "held" else ()
    why += ("its backing is soft",) if slider.backing == "soft" else ()
    passes = isinstance(orbits, PassingWave)
    if why and not passes:
        key = "slider.tilt" if slider.tilt != "held" else "slider.backing"
        raise InputError(key, 'must be "held" (tilt) and "rigid" (backing) on prescribed orbits; give a PassingWave')
    return (*why, "it loads the wave") if passes and orbits.loaded_by(slider.preload) else why


def refuse_infinite_mass(slider: Slider) -> None:
    """Raise an InputError for a slider that has no motion in time."""
    refuse_if(slider.mass == math.inf, "slider.mass", "must be finite for a motion in time", slider.mass, "kg")


def prescribed(slider: Slider, orbits, *, in_time: bool = False, each: bool = False) -> tuple[Slider, Orbits]:
    """Return a slider and the orbit under each of its contacts.

    On a passing wave those that are equal and in one row are one of them, unless ``each`` is True: the answer has a
    value for each contact. ``in_time``: True if the motion is followed in time, which needs a finite mass.

    Raises
    ------
    ConvergenceError
        Status "not applicable" if the motion of surface or body is not known before the forces (`coupling`).
    """
    if why := coupling(slider, orbits):
        rule = "only averaged motions of it are known (steady, mean_motion, load_line, stall, burst)"
        raise ConvergenceError(
            "not applicable", f"{' and '.join(why)}: {rule}; give wave.loading = false to leave it out"
        )
    if in_time:
        refuse_infinite_mass(slider)
    if not isinstance(orbits, PassingWave):
        return slider, as_orbits(orbits)
    under = orbits.orbits_at(np.broadcast_to(slider.x, (slider.count,)))
    if each:
        return slider, under
    return _merged(slider, under, np.zeros((1, slider.count)))  # at one x all move alike


def merged(slider: Slider, orbits: Orbits) -> tuple[Slider, Orbits]:
    """Return a slider and its orbits with one contact, of their weights, for all that are equal and move alike."""
    u_z, u_x = orbits.normal, orbits.tangential
    return _merged(slider, orbits, np.array([u_z.real, u_z.imag, u_x.real, u_x.imag]))


def _merged(slider, orbits, motion):
    if len(orbits) == 1 or slider.friction is not None:  # other frictions than Coulomb's know no weights
        return slider, orbits
    member, classes, _ = slider.classes(motion)
    return (slider, orbits) if member.size == len(orbits) else (slider.merged(member, classes), orbits[member])
