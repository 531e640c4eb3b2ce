"""Sizes of the effects that the model neglects in one run, by closed forms; the numerical error does not contain them.

Each function takes the record of a run and yields effect, quantity, size and source, or nothing where the effect does
not arise or is not neglected.  A size is a share of the quantity named with it, unless that has a unit.  Estimates hold
to a factor of about 2; that of the finite aperture is the size of a ripple, whose sign may be wrong in cuts that hardly
spread a beam.

Sources: side faces: `fem.surface_beam`; finite aperture: `fem.Slowness`, the angular spectrum of a slit.  Load of a
contact on the wave, mass of the electrodes: reciprocity with the surface wave and perturbation (Auld, Acoustic Fields
and Waves in Solids, vol. 2, 1973, chapters 10 and 12).
Radiation of a contact: `studies.chain.radiation`.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import contact
import fem
from studies.chain import bridge, resolve
from studies.chain.blocks import node
from studies.chain.radiation import point_admittance
from studies.record import Record

# of |u_z|, where the charge is taken as uniform along the fingers: combs of 3 to 30 pairs and 5 to 30 wavelengths in
# PZT-8, worst of 80 places 2.6 to 10 %, rms 0.9 to 3.7 % (tests/fem/beam/test_finger_ends.py)
UNIFORM_CHARGE = 0.05
# of |u_z|, what static finger ends leave of that: at least, and per finger pair; PZT-8, rms of 80 places 0.9 to 1.1 %
# with 2 to 10 pairs, 4.7 % with 30 (the same test)
UNEVEN_CHARGE, UNEVEN_PER_PAIR = 0.01, 0.0016
ALUMINIUM, FILM = 2700.0, 100e-9  # kg/m3, m


NO_FRICTION = 1e-9  # a coefficient that stands for none where one is required

Rows = Iterator[tuple[str, str, float, str]]
SHARED = (
    "u_z",
    "velocity",
)  # quantities at the slider, whose relative changes are the model error of an answer
NO_ANSWER = 1.0  # relative change from which on the answer is refused
NEVER_DECISIVE = ("overtones of the wave under the pillars",)  # an upper bound by first order: a warning
# What an effect changes, by which share (or in the quantity's unit), and where the estimate comes from
KEYS = ("effect", "quantity", "size", "source")


def model_error(record: Record) -> tuple[dict, ...]:
    """Return the neglected effects of a run with a driven stator, as in run.json."""
    rows: list[tuple] = []
    if record.scene.slider is not None and record.scene.slider.pillars is not None:
        from studies.chain.pillar_budget import pillar_rows

        rows += pillar_rows(record)
    parts = (
        ()
        if record.surface_wave is None
        else (_aperture, _finger_ends, _vacuum, _electrode_mass, _contact, _travel, _power)
    )
    for each in parts:
        rows += each(record)
    return tuple(dict(zip(KEYS, row, strict=True)) for row in rows if math.isfinite(row[2]))


def with_model_error(record: Record) -> Record:
    """Return the record with its model error: the effects, what they make of each point, and whether they decide.

    The effects on u_z and on the velocity are added up as if all had the same sign. A point's
    ``model_relative_error`` is their sum in the sense of ``relative_error``: the change of u_z times
    ``amplitude_sensitivity``, the relative change of the velocity for one of the wave. An effect as large as the
    quantity itself leaves no answer.
    """
    rows = model_error(record)
    shares = {
        quantity: sum(abs(row["size"]) for row in rows if row["quantity"] == quantity) for quantity in SHARED
    }
    if not rows:
        return record
    points = tuple(
        point | {"model_relative_error": shares["velocity"] + shares["u_z"] * point["amplitude_sensitivity"]}
        if "amplitude_sensitivity" in point
        else point
        for point in record.points
    )
    error = record.error | ({"model": sum(shares.values())} if record.error else {})
    decisive = [
        row
        for row in rows
        if row["quantity"] in SHARED and abs(row["size"]) >= NO_ANSWER and row["effect"] not in NEVER_DECISIVE
    ]
    shortfall = record.shortfall
    if decisive and not shortfall.startswith("no answer"):  # a node of the wave is the better reason
        worst = max(decisive, key=lambda row: abs(row["size"]))
        shortfall = (
            f"no answer: the model leaves out what changes {worst['quantity']} by about {100 * worst['size']:+.2g} % "
            f"({worst['effect']}); {100 * NO_ANSWER:g} % or more is refused"
        )
    return replace(record, model_error=rows, points=points, error=error, shortfall=shortfall)


def _wavelength(record: Record) -> float:
    """Return the wavelength of the surface wave, m."""
    return record.wave["phase_velocity_m_per_s"] / record.wave["frequency_Hz"]


def _aperture(record: Record) -> Rows:
    """Yield the effect on u_z of the finite aperture or, with a beam, of the side faces: worst over the contacts."""
    motion, slider, block = record.surface_motion, record.scene.slider, record.scene.stator
    places = [(block.length / 2, 0.0)] if slider is None else list(slider.places)
    if record.scene.piece:  # a mesh has no modes, but the beam of the fingers reaches it
        spans = [each.extent for each in resolve.transducers(record.scene)]
        covered = any(low <= x <= high for x, _ in places for low, high in spans)
    else:
        covered = any(motion.covered(place) for place in places)
    if covered:
        return
    if motion.beam is None:
        worst = max(_spread(record, *zip(*places, strict=True)) - 1, key=abs)
        yield (
            "finite aperture",
            "u_z",
            float(worst),
            "angular spectrum of the driven aperture, on the cut's slowness curve",
        )
        return
    if record.scene.crossed:
        yield from _crossed(record, places)
        return
    beam, at = motion.beam, tuple(zip(*places, strict=True))
    here, other = (
        beam.with_side_faces(each).motion(*at)[2]
        for each in (beam.mirror_width, None if block.mirror_width else block.width)
    )
    ratios = abs(other / here)
    worst = max((float(each) - 1 for each in ratios), key=abs)
    how = "the beam between side faces that reflect it as mirrors against none, or the other way round"
    yield "side faces", "u_z", worst, how


def _crossed(record: Record, places) -> Rows:
    """Yield what is neglected where beams cross: their images in the side faces, and the metal that they pass under."""
    beam, (x, y) = record.surface_motion.beam, zip(*places, strict=True)
    here, solid = abs(beam.motion(x, y)[2]), resolve.solid(record.scene.stator)
    images = float((beam.first_images(x, y) / here).max())
    how = "first images of the beams in both side faces, as if these reflected everything and in phase"
    yield "side faces", "u_z", images, how
    bare, metal = (fem.rayleigh(solid, surface).velocity for surface in ("open", "metallised"))
    turned = float(beam.shadowed(1 - metal / bare) / here.min())
    how = "phase that a beam gains along the fingers it crosses, by the velocities with and without metal"
    yield "metal of the transducers in the way of crossing beams", "u_z", turned, how


def _spread(record: Record, x, y) -> np.ndarray:
    """Return the amplitude of the driven aperture over that of a plane wave at places from left end and axis, m."""
    driven, stator = record.scene.driven_transducer, resolve.stator(record.scene.stator)
    wave, frequency = record.wave, record.wave["frequency_Hz"]
    try:
        curve = fem.Slowness.of_half_space(stator.solid, frequency, stator.bare_surface)
    except fem.ConvergenceError:  # no surface wave in some directions: as if it were as fast in all of them
        curve = fem.Slowness.circle(2 * math.pi * frequency / wave["phase_velocity_m_per_s"])
    return curve.spectrum(driven.aperture, np.subtract(x, driven.place[0]), y)


def _finger_ends(record: Record) -> Rows:
    """Yield what is left of the charges' variation along the fingers, and that they end where that is left out."""
    driven, motion, slider = record.scene.driven_transducer, record.surface_motion, record.scene.slider
    beam, effect, ceramic = motion.beam, "charge at the finger ends", "in lead zirconate titanate"
    places = [(record.scene.stator.length / 2, 0.0)] if slider is None else list(slider.places)
    if beam is None or any(motion.covered(place) for place in places):
        yield effect, "u_z", UNIFORM_CHARGE, f"fingers whose charge varies along them, {ceramic}"
        return
    at = tuple(zip(*places, strict=True))
    left = beam.charge_error(*at)
    if left is not None:
        yield effect, "u_z", float(left.max()), "the charge in fewer steps along the fingers"
        return
    if record.scene.crossed:
        yield effect, "u_z", UNIFORM_CHARGE, f"fingers whose charge varies along them, {ceramic}"
        return
    stator = resolve.stator(record.scene.stator)
    longer = beam.with_longer_fingers(fem.end_excess(stator.solid, stator.bare_surface))
    changes = abs(longer.motion(*at)[2]) / abs(motion.at(places)[2]) - 1
    yield effect, "u_z", float(max(changes, key=abs)), "static charge at the ends of fingers in a long row"
    rest = max(UNEVEN_CHARGE, UNEVEN_PER_PAIR * driven.finger_pairs)
    effect = "ripple of the charge along the fingers"
    yield effect, "u_z", rest, f"what static ends leave of it, {ceramic}"


def _vacuum(record: Record) -> Rows:
    if record.scene.stator.above == "none":
        permittivity = resolve.solid(record.scene.stator).permittivity
        within = permittivity[0, 0] * permittivity[2, 2] - permittivity[0, 2] ** 2
        how = "strips on a half-space: charge in proportion to eps_0 + eps_p"
        share = fem.VACUUM_PERMITTIVITY / math.sqrt(within)
        yield "vacuum above the surface", "u_z", share, how


def _amplitude_per_power(record: Record) -> float | None:
    """Return C of u_z = C (P / (W f))^(1/2) in SI; None where ends send waves back or others drive.

    P is half of the power taken in, u_z the surface mode's half a wavelength beside the driven fingers.
    """
    scene, wave, power = record.scene, record.surface_wave, record.electrical["power_W_per_V2"]
    driven = resolve.driven(scene)
    if scene.crossed:  # in the section's own axes
        row = record.surface_motion.beam.rows[0].transducers
        driven = next(each for each in row if scene.drive.driven.get(each.name))
    (left, right), apart = driven.extent, _wavelength(record) / 2
    beside = right + apart if driven.center < wave.length / 2 else left - apart
    within = 0 <= beside <= wave.length and not wave.covered(beside)
    several = "sources" in record.electrical
    if several or scene.stator.ends != "absorbing" or not within or not power > 0:
        return None
    per_width = power / 2 / driven.aperture
    return float(abs(wave.rayleigh_motion(beside)[1])) / math.sqrt(per_width / record.wave["frequency_Hz"])


def _electrode_mass(record: Record) -> Rows:
    constant, wave = _amplitude_per_power(record), record.wave
    if constant is None:
        return
    omega = 2 * math.pi * wave["frequency_Hz"]
    # |u|^2 per power and width
    motion = constant**2 / wave["frequency_Hz"] * (1 + wave["surface_ratio"] ** 2)
    slower = -wave["phase_velocity_m_per_s"] / 4 * ALUMINIUM * FILM * omega**2 * motion
    effect = "mass of 100 nm aluminium on the fingers"
    phase = (
        math.pi * record.scene.driven_transducer.finger_pairs * slower
    )  # from the middle of the row to its end
    yield effect, "u_z", phase, "first-order perturbation of the velocity under them, over half the row"


def _contact(record: Record) -> Rows:
    slider = record.scene.slider
    if slider is None or slider.pillars is not None or not slider.preload_force > 0:
        return
    solid, count = resolve.solid(record.scene.stator), len(slider.offsets)
    omega = 2 * math.pi * record.wave["frequency_Hz"]
    body, places = bridge.contact_slider(slider), 1 if isinstance(slider.contacts, int) else count
    stiffness = (2 * math.pi * body.normal_resonance(places)) ** 2 * body.mass / places
    shear = float(solid.stiffness[4, 4])
    sent = stiffness * point_admittance(omega, shear, math.sqrt(shear / solid.density)) / omega
    effect, how = "radiation of a contact into the stator", "point load on an isotropic half-space, nu = 1/4"
    yield effect, "the contact's elastic force", sent, how
    moved = [point for point in record.points if point["normal_amplitude_m"] > 0]
    if not moved or node(record.surface_motion, list(slider.places)):
        return
    if _amplitude_per_power(record) is not None:
        how = "averaged equilibrium of the contacts on a wave that they load (elastic law)"
        load = max(_loaded(record, point) for point in (moved[0], moved[-1]))
        yield "load of the slider on the wave", "u_z", load, how


def _loaded(record: Record, point: dict) -> float:
    """Return by how much the slider changes the wave that passes below it, of a strip as wide as the aperture.

    Where the equilibrium is not reached: the loading number, about the phase that the contacts add.
    """
    slider, stator = record.scene.slider, resolve.stator(record.scene.stator)
    body = bridge.contact_slider(slider)
    body = replace(
        body, law="elastic", reciprocal=False, stick_band=0.0, friction=None,
        friction_coefficient=body.static_coefficient or NO_FRICTION,
    )  # fmt: skip
    equal = isinstance(slider.contacts, int)
    places = [0.0] if equal else [x - slider.center[0] for x, _ in slider.places]
    count = len(slider.offsets) if equal else 1
    balls = contact.balls_of(replace(body, preload=body.preload * count), places, weights=count)
    tangential, _, normal = abs(record.surface_motion.at(list(slider.places)))
    strongest = int(np.argmax(normal))  # the centre may be a node of the wave
    wave = contact.PassingWave(
        frequency=record.wave["frequency_Hz"],
        wavelength=_wavelength(record),
        forward=float(normal[strongest]) * point["voltage_V"],
        ratio=float(tangential[strongest] / normal[strongest]),
        compliance=fem.wave_compliance(stator.solid, stator.bare_surface),
        strip_width=record.scene.driven_transducer.aperture,
    )  # fmt: skip
    try:
        return abs(contact.pillar_motion(balls, wave, loading=True).exit_over_entry - 1.0)
    except contact.ConvergenceError:
        return wave.loading_number(balls.preload)


def _travel(record: Record) -> Rows:
    scene, ratio = record.scene, record.wave["standing_wave_ratio"]
    if scene.slider is None or scene.burst is None or any("travel_m" in point for point in record.points):
        return
    fastest = max((abs(point.get("velocity_m_per_s", 0.0)) for point in record.points), default=0.0)
    if fastest * scene.burst > _wavelength(record) / 4:
        how = "standing-wave ratio, over a travel of more than a quarter of a wavelength"
        effect = "travel of the slider along the rippled field"
        yield effect, "u_z", (ratio - 1) / (ratio + 1), how


def _power(record: Record) -> Rows:
    highest = max(record.scene.levels, default=0.0)
    power = record.electrical["power_W_per_V2"] * highest**2
    quantity = f"the whole power taken in at {highest:g} V, in W"
    yield "heating of the stator", quantity, power, "admittance"
