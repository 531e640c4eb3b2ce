"""How large the effects are that the model leaves out, for one run: closed forms, apart from the numerical error.

Each function takes the record of a run and yields effects; none where the effect does not arise or is not neglected.
A size is a share of the quantity named with it, unless that has a unit.  Estimates hold to a factor of about 2.

Sources: side faces: `fem.surface_beam`; finite aperture: Fresnel's integral of a slit (Goodman, Introduction to Fourier
Optics, 3rd ed. 2005, section 4.5).  Load of a contact on the wave, mass of the electrodes: reciprocity with the surface
wave and perturbation (Auld, Acoustic Fields and Waves in Solids, vol. 2, 1973, chapters 10 and 12).
Radiation of a contact: load on a half-space (Miller and Pursey, Proc. R. Soc. A 223 (1954) 521, nu = 1/4).
"""

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace

import fem
from studies.chain import bridge
from studies.record import Record
from studies.scene import resolved

FINGER_END = 0.0745  # periods that each end adds to the aperture: static, endless comb, no busbar
# of it, what charges that are uniform along y have: fem.beam.own_aperture, 20 and 40 weakly coupled pairs, extrapolated
UNIFORM_END = 0.049
OWN_APERTURE = (
    0.4  # wavelengths over the aperture, of the power that given charges lose: 0.3 for 3 pairs, 0.4 for 10
)
POINT_ADMITTANCE = 0.93  # of Re(v / F) 2 pi mu c_T / omega^2, all waves together, nu = 1/4
ALUMINIUM, FILM = 2700.0, 100e-9  # kg/m3, m


@dataclass(frozen=True, kw_only=True)
class NeglectedEffect:
    """An effect that the model leaves out."""

    effect: str
    quantity: str  # what it changes
    size: float  # estimated change, a share of the quantity, or in the quantity's unit
    source: str  # where the estimate comes from


def model_error(record: Record) -> tuple[dict, ...]:
    """Return the neglected effects of a run with a driven stator, as in run.json."""
    if record.surface_wave is None:
        return ()
    found: list[NeglectedEffect] = []
    for each in (_aperture, _finger_ends, _vacuum, _electrode_mass, _contact, _travel, _power):
        found += each(record)
    return tuple(asdict(each) for each in found if math.isfinite(each.size))


def _places(record: Record) -> list[tuple[float, float]]:
    slider, length = record.scene.slider, record.scene.stator.length
    return [(length / 2, 0.0)] if slider is None else list(slider.places)


def _aperture(record: Record) -> Iterator[NeglectedEffect]:
    """Yield what the finite aperture or, where it counts, the side faces do to u_z: the worst over the contacts."""
    motion, places = record.surface_motion, _places(record)
    if any(motion.covered(place) for place in places):
        return
    if motion.beam is None:
        yield NeglectedEffect(
            effect="finite aperture",
            quantity="u_z",
            size=max((fresnel_ratio(record, *place) - 1 for place in places), key=abs),
            source="Fresnel's integral of the driven aperture",
        )
        return
    if record.scene.crossed:
        yield from _crossed(record, places)
        return
    block = record.scene.stator
    other = replace(motion.beam, mirror_width=None if block.mirror_width else block.width)
    ratios = abs(other.motion(*zip(*places, strict=True))[2] / motion.at(places)[2])
    yield NeglectedEffect(
        effect="side faces",
        quantity="u_z",
        size=max((float(each) - 1 for each in ratios), key=abs),
        source="the beam between side faces that reflect it as mirrors against none, or the other way round",
    )


def _crossed(record: Record, places) -> Iterator[NeglectedEffect]:
    """Yield what is left out where beams cross: images in the side faces, and metal in one another's way."""
    beam, (x, y) = record.surface_motion.beam, zip(*places, strict=True)
    here = abs(beam.motion(x, y)[2])
    yield NeglectedEffect(
        effect="side faces",
        quantity="u_z",
        size=float((beam.first_images(x, y) / here).max()),
        source="first images of the beams in both side faces, as if these reflected everything and in phase",
    )
    solid = resolved.solid(record.scene.stator)
    bare, metal = (fem.rayleigh(solid, surface).velocity for surface in ("open", "metallised"))
    yield NeglectedEffect(
        effect="metal of the transducers in the way of crossing beams",
        quantity="u_z",
        size=float(beam.shadowed(1 - metal / bare) / here.min()),
        source="phase that a beam gains along the fingers it crosses, by the velocities with and without metal",
    )


def fresnel_ratio(record: Record, x: float, y: float = 0.0) -> float:
    """Return `slit_ratio` of the driven transducer at a place: m from the stator's left end, and from its axis."""
    driven = record.scene.driven_transducer
    wavelength = record.wave["phase_velocity_m_per_s"] / record.wave["frequency_Hz"]
    return slit_ratio(driven.aperture, wavelength, abs(x - driven.place[0]), y)


def slit_ratio(aperture: float, wavelength: float, distance: float, lateral: float = 0.0) -> float:
    """Return the amplitude behind a uniform aperture over that of a plane wave, by Fresnel's integral.

    Parameters
    ----------
    aperture, wavelength, distance, lateral : float
        m; the last from the axis.

    Examples
    --------
    >>> round(slit_ratio(20e-3, 0.99e-3, 1e-6), 2)  # at the aperture
    1.0
    """
    from scipy.special import fresnel

    scale = math.sqrt(2 / (wavelength * distance))
    (below_sine, below_cosine), (above_sine, above_cosine) = (
        fresnel(scale * (edge - lateral)) for edge in (-aperture / 2, aperture / 2)
    )
    return math.hypot(above_sine - below_sine, above_cosine - below_cosine) / math.sqrt(2)


def _finger_ends(record: Record) -> Iterator[NeglectedEffect]:
    """Yield what the charges leave out: how they vary along the fingers, and that these end where it is left out."""
    driven, beam = record.scene.driven_transducer, record.surface_motion.beam
    responds = beam is not None and record.scene.stator.ends == "absorbing"
    responds = responds and fem.isotropic_about_normal(resolved.solid(record.scene.stator))
    yield NeglectedEffect(
        effect="charge at the finger ends",
        quantity="the aperture",
        size=2 * (FINGER_END - responds * UNIFORM_END) * driven.period / driven.aperture,
        source="static field of an endless comb that ends, without busbars",
    )
    if beam is not None and not responds:
        wavelength = record.wave["phase_velocity_m_per_s"] / record.wave["frequency_Hz"]
        yield NeglectedEffect(
            effect="a transducer's response to the finite aperture of its own charges",
            quantity="its conductance",
            size=-OWN_APERTURE * wavelength / driven.aperture,
            source="surface wave that given charges send to all sides, in a solid isotropic about its normal",
        )


def _vacuum(record: Record) -> Iterator[NeglectedEffect]:
    if record.scene.stator.above != "none":
        return
    from fem import VACUUM_PERMITTIVITY

    permittivity = resolved.solid(record.scene.stator).permittivity
    within = permittivity[0, 0] * permittivity[2, 2] - permittivity[0, 2] ** 2
    yield NeglectedEffect(
        effect="vacuum above the surface",
        quantity="the capacitance",
        size=VACUUM_PERMITTIVITY / math.sqrt(within),
        source="strips on a half-space: capacitance in proportion to eps_0 + eps_p",
    )


def _amplitude_per_power(record: Record) -> float | None:
    """Return C of u_z = C (P / (W f))^(1/2) in SI; None where ends send waves back or others drive.

    P is half of the power taken in, u_z the surface mode's half a wavelength beside the driven fingers.
    """
    scene = record.scene
    driven = resolved.driven(scene)
    if scene.crossed:  # in the section's own axes
        driven = next(
            each
            for each in record.surface_motion.beam.rows[0].transducers
            if scene.drive.driven.get(each.name)
        )
    wavelength = record.wave["phase_velocity_m_per_s"] / record.wave["frequency_Hz"]
    left, right = driven.extent
    beside = (
        right + wavelength / 2 if driven.center < record.surface_wave.length / 2 else left - wavelength / 2
    )
    wave, power = record.surface_wave, record.electrical["power_W_per_V2"]
    within = 0 <= beside <= wave.length and not wave.covered(beside)
    several = "sources" in record.electrical
    if several or scene.stator.ends != "absorbing" or not within or not power > 0:
        return None
    per_width = power / 2 / driven.aperture
    return float(abs(wave.rayleigh_motion(beside)[1])) / math.sqrt(per_width / record.wave["frequency_Hz"])


def _electrode_mass(record: Record) -> Iterator[NeglectedEffect]:
    constant = _amplitude_per_power(record)
    if constant is None:
        return
    wave = record.wave
    omega = 2 * math.pi * wave["frequency_Hz"]
    motion = (
        constant**2 / wave["frequency_Hz"] * (1 + wave["surface_ratio"] ** 2)
    )  # |u|^2 per power and width
    yield NeglectedEffect(
        effect="mass of 100 nm aluminium on the fingers",
        quantity="the velocity under them",
        size=-wave["phase_velocity_m_per_s"] / 4 * ALUMINIUM * FILM * omega**2 * motion,
        source="first-order perturbation",
    )


def _contact(record: Record) -> Iterator[NeglectedEffect]:
    slider = record.scene.slider
    if slider is None or not slider.preload > 0:
        return
    solid = resolved.solid(record.scene.stator)
    count = len(slider.offsets)
    share, omega = slider.preload / count, 2 * math.pi * record.wave["frequency_Hz"]
    body, places = bridge.contact_slider(slider), 1 if isinstance(slider.contacts, int) else count
    stiffness = (2 * math.pi * body.normal_resonance(places)) ** 2 * body.mass / places
    shear = float(solid.stiffness[4, 4])
    yield NeglectedEffect(
        effect="radiation of a contact into the stator",
        quantity="the contact's elastic force",
        size=stiffness * POINT_ADMITTANCE * omega / (2 * math.pi * shear * math.sqrt(shear / solid.density)),
        source="point load on an isotropic half-space, nu = 1/4",
    )
    constant = _amplitude_per_power(record)
    if constant is None:
        return
    sizes = []
    for point in record.points:
        if point["normal_amplitude_m"] > 0:
            force = min(stiffness * point["normal_amplitude_m"], 2 * share)
            sizes.append(count * force / point["normal_amplitude_m"])
    if sizes:
        yield NeglectedEffect(
            effect="load of the slider on the wave",
            quantity="u_z",
            size=math.pi / 2 * max(sizes) * constant**2 / record.scene.driven_transducer.aperture,
            source="reciprocity with the surface wave; first harmonic of the force at most twice the preload",
        )


def _travel(record: Record) -> Iterator[NeglectedEffect]:
    scene = record.scene
    if scene.slider is None or scene.burst is None or any("travel_m" in point for point in record.points):
        return
    fastest = max((abs(point.get("velocity_m_per_s", 0.0)) for point in record.points), default=0.0)
    wavelength = record.wave["phase_velocity_m_per_s"] / record.wave["frequency_Hz"]
    ratio = record.wave["standing_wave_ratio"]
    if fastest * scene.burst > wavelength / 4:
        yield NeglectedEffect(
            effect="travel of the slider along the rippled field",
            quantity="u_z",
            size=(ratio - 1) / (ratio + 1),
            source="standing-wave ratio, over a travel of more than a quarter of a wavelength",
        )


def _power(record: Record) -> Iterator[NeglectedEffect]:
    yield NeglectedEffect(
        effect="heating of the stator",
        quantity="power taken in at the highest voltage, in W",
        size=record.electrical["power_W_per_V2"] * max(record.scene.levels, default=0.0) ** 2,
        source="admittance",
    )
