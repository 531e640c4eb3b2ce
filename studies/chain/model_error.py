"""Closed-form estimates of the effects that the model of one run neglects. The numerical error does not contain them.

Each function takes the record of a run and yields (effect, quantity, size, source). It yields nothing if the effect
does not arise or if the model includes it. A size is relative to the quantity named with it, unless that name states a
unit. The estimates hold to a factor of about 2. The size of the finite aperture is that of a ripple; its sign may be
wrong in cuts in which a beam hardly spreads.

Sources:

- side faces: `fem.surface_beam`;
- finite aperture: `fem.Slowness`, the angular spectrum of a slit;
- load of a contact on the wave and mass of the electrodes: reciprocity with the surface wave and perturbation theory
  (Auld, Acoustic Fields and Waves in Solids, vol. 2, 1973, chapters 10 and 12);
- radiation of a contact: `studies.chain.radiation`.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import contact
import fem
from studies.chain import bridge, resolve
from studies.chain.radiation import point_admittance
from studies.record import Record
from studies.record.text import percent

# Relative error of |u_z| if the charge is assumed uniform along the fingers. Measured on PZT-8 for combs of 3 to 30
# pairs and apertures of 5 to 30 wavelengths: 2.6 to 10 % at the worst of 80 points, 0.9 to 3.7 % rms
# (tests/fem/beam/test_finger_ends.py).
UNIFORM_CHARGE = 0.05
# Relative error of |u_z| that remains with the static charge at the finger ends: the minimum, and the increase per
# finger pair. Measured on PZT-8, rms over 80 points: 0.9 to 1.1 % with 2 to 10 pairs, 4.7 % with 30
# (tests/fem/beam/test_finger_ends.py).
UNEVEN_CHARGE, UNEVEN_PER_PAIR = 0.01, 0.0016
# Change of |u_z| by the vacuum over its share of the permittivity times K2, the largest measured: 2.4 in twente-left,
# 4.0 in twente, 1.3 in lithium-niobate-128yx, 3.4 in lithium-niobate-yz (sawmotor run SCENE --set
# stator.above=vacuum).
VACUUM_FACTOR = 4.0
ALUMINIUM, FILM = 2700.0, 100e-9  # density in kg/m3 and thickness in m of the electrodes

# Friction coefficient of a frictionless contact: the averaged equilibrium requires a positive one
NO_FRICTION = 1e-9

Rows = Iterator[tuple]  # of values of `KEYS`
SHARED = ("u_z", "velocity")  # quantities at the slider whose relative changes add up to the model error
NO_ANSWER = 1.0  # smallest relative change for which the answer is refused
LOADS = 5  # levels of a run at which the load on the wave is computed, 6 ms each; linear in the voltage between them
NODE = 1e-6  # |u_z|/|u_x| below which u_z is a node: waves from both sides cancel
# A first-order upper bound, which causes only a warning
NEVER_DECISIVE = ("overtones of the wave under the pillars",)
# Keys of an effect in run.json: name, changed quantity, relative change (with a unit: change in that), source, unit
KEYS = ("effect", "quantity", "size", "source", "unit")


def model_error(record: Record) -> tuple[dict, ...]:
    """Return the neglected effects of a run with a driven stator, as in run.json.

    An effect that depends on the level has its largest size over the points, or for a slider on pillars its size at the
    largest level.
    """
    return _table(record, *_effects(record))


def _effects(record: Record) -> tuple[tuple, list[tuple]]:
    """Return the effects that do not depend on the level, and for each point those that do."""
    always: list[tuple] = []
    at_points: list[list[tuple]] = [[] for _ in record.points]
    if record.scene.on_pillars:
        from studies.chain.pillar_budget import pillar_rows

        at_points = pillar_rows(record)
    if record.surface_wave is not None:
        for each in (_aperture, _finger_ends, vacuum_effect, _electrode_mass, _contact, _power):
            always += each(record)
        for rows, point, load in zip(at_points, record.points, _load(record), strict=True):
            rows += [*load, *_travel(record, point)]
    return _finite(always), [_finite(rows) for rows in at_points]


def _finite(rows: list[tuple]) -> tuple:
    return tuple(row for row in rows if math.isfinite(row[2]))


def _table(record: Record, always: tuple, at_points: list[tuple]) -> tuple[dict, ...]:
    if record.scene.on_pillars:
        of_points = list(max(zip(record.points, at_points, strict=True), key=lambda each: each[0][record.level])[1])
    else:
        of_points = sorted((row for rows in at_points for row in rows), key=lambda row: abs(row[2]))
    largest = {row[0]: row for row in of_points}
    return tuple(dict(zip(KEYS, row, strict=False)) for row in (*largest.values(), *always))


def with_model_error(record: Record) -> Record:
    """Return the record with its model error.

    The effects on u_z and on the velocity are added as if they all had the same sign. The ``model_relative_error`` of
    a point is the change of the velocity plus the change of u_z times ``amplitude_sensitivity`` (the relative change
    of the velocity divided by the relative change of the wave amplitude), with the sizes at that point. If one effect
    is as large as the quantity itself, the answer is refused: the record gets a shortfall.
    """
    always, at_points = _effects(record)
    rows = _table(record, always, at_points)
    if not rows:
        return record

    def share(quantity: str, rows) -> float:
        return sum(abs(size) for _, changed, size, *_ in rows if changed == quantity)

    points = []
    for point, own in zip(record.points, at_points, strict=True):
        if "amplitude_sensitivity" in point:
            velocity, u_z = share("velocity", always + own), share("u_z", always + own)
            point = point | {"model_relative_error": float(velocity + u_z * point["amplitude_sensitivity"])}
        points.append(point)
    shares = {quantity: share(quantity, (row.values() for row in rows)) for quantity in SHARED}
    error = record.error | ({"model": sum(shares.values())} if record.error else {})
    decisive = [
        row
        for row in rows
        if row["quantity"] in SHARED and abs(row["size"]) >= NO_ANSWER and row["effect"] not in NEVER_DECISIVE
    ]
    shortfall = record.shortfall
    if decisive and not record.refused:  # an earlier reason, such as a node of the wave, is kept
        worst = max(decisive, key=lambda row: abs(row["size"]))
        shortfall = (
            f"no answer: a neglected effect changes {worst['quantity']} by about {percent(worst['size'])} "
            f"({worst['effect']}); {100 * NO_ANSWER:g} % or more is refused"
        )
    refused = record.refused or bool(decisive)
    return replace(record, model_error=rows, points=tuple(points), error=error, shortfall=shortfall, refused=refused)


def _wavelength(record: Record) -> float:
    """Return the wavelength of the surface wave, m."""
    return record.wave["phase_velocity_m_per_s"] / record.wave["frequency_Hz"]


def _aperture(record: Record) -> Rows:
    """Yield the largest effect at the contacts on u_z of the finite aperture or, in a beam model, of the side faces."""
    motion, block = record.surface_motion, record.scene.stator
    places = record.scene.contact_places
    if record.scene.piece:
        # a meshed piece has no guided modes to test; compare with the extents of the transducers
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
    same, other = map(beam.with_side_faces, (beam.mirror_width, None if block.mirror_width else block.width))
    as_modelled = motion.at(places) if same is beam else same.motion(*at)
    ratios = abs(other.motion(*at)[2] / as_modelled[2])
    worst = max((float(each) - 1 for each in ratios), key=abs)
    how = "the beam with side faces that reflect like mirrors, compared with the beam without side faces"
    yield "side faces", "u_z", worst, how


def _crossed(record: Record, places) -> Rows:
    """Yield the neglected effects of crossing beams: images in the side faces, and metal of transducers they pass."""
    beam, (x, y) = record.surface_motion.beam, zip(*places, strict=True)
    amplitude, solid = abs(beam.motion(x, y)[2]), resolve.solid(record.scene.stator)
    images = float((beam.first_images(x, y) / amplitude).max())
    how = "first images of the beams in both side faces, which are assumed to reflect everything in phase"
    yield "side faces", "u_z", images, how
    bare, metal = (fem.rayleigh(solid, surface).velocity for surface in ("open", "metallised"))
    phase_shift = float(beam.shadowed(1 - metal / bare) / amplitude.min())
    how = "phase change of a beam along the fingers that it crosses, from the velocities with and without metal"
    yield "metal of the transducers in the way of crossing beams", "u_z", phase_shift, how


def _spread(record: Record, x, y) -> np.ndarray:
    """Return the amplitude radiated by the driven aperture, relative to a plane wave.

    ``x`` is measured from the left end of the stator and ``y`` from its axis, both in m.
    """
    driven, stator = record.scene.driven_transducer, resolve.stator(record.scene.stator)
    wave, frequency = record.wave, record.wave["frequency_Hz"]
    try:
        curve = fem.Slowness.of_half_space(stator.solid, frequency, stator.bare_surface)
    except fem.ConvergenceError:
        # some directions have no surface wave: assume the velocity along x in all directions
        curve = fem.Slowness.circle(2 * math.pi * frequency / wave["phase_velocity_m_per_s"])
    return curve.spectrum(driven.aperture, np.subtract(x, driven.place[0]), y)


def _finger_ends(record: Record) -> Rows:
    """Yield the effect of the charge distribution along the fingers.

    The section, and a beam at a covered point, take the charge as uniform. Other beams represent it by steps or by the
    static charge at the finger ends; the remaining error is yielded.
    """
    driven, motion = record.scene.driven_transducer, record.surface_motion
    beam, effect, ceramic = motion.beam, "charge at the finger ends", "in lead zirconate titanate"
    places = record.scene.contact_places
    if beam is None or any(motion.covered(place) for place in places):
        yield effect, "u_z", UNIFORM_CHARGE, f"fingers whose charge varies along them, {ceramic}"
        return
    at = tuple(zip(*places, strict=True))
    charge_error = beam.charge_error(*at)
    if charge_error is not None:
        yield (effect, "u_z", float(charge_error.max()), "change by fewer steps of the charge along the fingers")
        return
    if record.scene.crossed:
        yield effect, "u_z", UNIFORM_CHARGE, f"fingers whose charge varies along them, {ceramic}"
        return
    stator = resolve.stator(record.scene.stator)
    longer = beam.with_longer_fingers(fem.end_excess(stator.solid, stator.bare_surface))
    changes = abs(longer.motion(*at)[2]) / abs(motion.at(places)[2]) - 1
    yield effect, "u_z", float(max(changes, key=abs)), "static charge at the ends of fingers in a long row"
    remainder = max(UNEVEN_CHARGE, UNEVEN_PER_PAIR * driven.finger_pairs)
    effect = "ripple of the charge along the fingers"
    yield effect, "u_z", remainder, f"error that remains with static charge at the ends, {ceramic}"


def vacuum_effect(record: Record) -> Rows:
    """Yield the effect of the field in the vacuum on u_z, which is of second order.

    The charges grow by the share eps_0 / eps_p, and the potential of the wave, to which they couple, falls by as much.
    """
    if record.scene.stator.above == "none":
        solid = resolve.solid(record.scene.stator)
        permittivity = solid.permittivity
        squared_permittivity = permittivity[0, 0] * permittivity[2, 2] - permittivity[0, 2] ** 2
        share = fem.VACUUM_PERMITTIVITY / math.sqrt(squared_permittivity)
        try:
            bare, metal = (fem.rayleigh(solid, surface).velocity for surface in ("open", "metallised"))
            size = VACUUM_FACTOR * share * 2 * (bare - metal) / bare
            how = "eps_0 over the permittivity of the solid, times the coupling K2 of the surface wave"
        except fem.ConvergenceError:
            size, how = share, "eps_0 over the permittivity of the solid: K2 of a leaky wave is not known"
        yield "vacuum above the surface", "u_z", size, how


def _amplitude_per_power(record: Record) -> float | None:
    """Return the constant C of u_z = C (P / (W f))^(1/2) in SI units, or None if it cannot be determined.

    P is half of the power that the transducer takes in, W the aperture and f the frequency. u_z is the amplitude of the
    surface mode half a wavelength outside the driven fingers. C is unknown if the ends of the stator reflect, if
    several sources drive, or if that point is covered by electrodes.
    """
    scene, wave, power = record.scene, record.surface_wave, record.electrical["power_W_per_V2"]
    driven = resolve.driven(scene)
    if scene.crossed:  # the beam row of the driven transducer has its own axes
        transducers = record.surface_motion.beam.rows[0].transducers
        driven = next(each for each in transducers if scene.drive.driven.get(each.name))
    (left, right), half_wavelength = driven.extent, _wavelength(record) / 2
    sample_x = right + half_wavelength if driven.center < wave.length / 2 else left - half_wavelength
    is_free = 0 <= sample_x <= wave.length and not wave.covered(sample_x)
    several = "sources" in record.electrical
    if several or scene.stator.ends != "absorbing" or not is_free or not power > 0:
        return None
    per_width = power / 2 / driven.aperture
    return float(abs(wave.rayleigh_motion(sample_x)[1])) / math.sqrt(per_width / record.wave["frequency_Hz"])


def _electrode_mass(record: Record) -> Rows:
    constant, wave = _amplitude_per_power(record), record.wave
    if constant is None:
        return
    omega = 2 * math.pi * wave["frequency_Hz"]
    # |u|^2 per power and width
    motion = constant**2 / wave["frequency_Hz"] * (1 + wave["surface_ratio"] ** 2)
    slower = -wave["phase_velocity_m_per_s"] / 4 * ALUMINIUM * FILM * omega**2 * motion
    effect = "mass of 100 nm aluminium on the fingers"
    # phase accumulated from the middle of the transducer to its end
    phase = math.pi * record.scene.driven_transducer.finger_pairs * slower
    yield (effect, "u_z", phase, "first-order perturbation of the velocity under the fingers, over half of the row")


def _contact(record: Record) -> Rows:
    slider = record.scene.slider
    if slider is None or record.scene.on_pillars or not slider.preload_force > 0:
        return
    solid, contacts = resolve.solid(record.scene.stator), slider.computed_contacts
    omega = 2 * math.pi * record.wave["frequency_Hz"]
    body = bridge.contact_slider(slider)
    stiffness = (2 * math.pi * body.normal_resonance(contacts)) ** 2 * body.mass / contacts
    shear = float(solid.stiffness[4, 4])
    radiated = stiffness * point_admittance(omega, shear, math.sqrt(shear / solid.density)) / omega
    effect, how = "radiation of a contact into the stator", "point load on an isotropic half-space, nu = 1/4"
    yield effect, "the contact's elastic force", radiated, how


def _load(record: Record) -> list[list[tuple]]:
    """Return the effect of the contacts' load on the wave at each point."""
    slider = record.scene.slider
    rows: list[list[tuple]] = [[] for _ in record.points]
    if slider is None or record.scene.on_pillars or not slider.preload_force > 0:
        return rows
    tangential, _, normal = abs(record.surface_motion.at(list(slider.places)))
    if normal.max() < NODE * tangential.max() or _amplitude_per_power(record) is None:
        return rows
    how = "averaged equilibrium of the contacts on a wave that they load (elastic law)"
    voltages = np.unique([point["voltage_V"] for point in record.points if point["voltage_V"] > 0.0])
    some = voltages[np.unique(np.linspace(0, voltages.size - 1, LOADS).round().astype(int))] if voltages.size else ()
    sizes = wave_load(record, some)
    for own, point in zip(rows, record.points, strict=True):
        if point["voltage_V"] > 0.0:
            size = float(np.interp(point["voltage_V"], some, sizes))
            own.append(("load of the slider on the wave", "u_z", size, how))
    return rows


def wave_load(record: Record, voltages) -> list[float]:
    """Return the relative changes of a wave that passes below the slider, in a strip as wide as the aperture.

    If the averaged equilibrium does not converge, the change is the loading number, which approximates the phase that
    the contacts add to the wave.
    """
    slider, stator = record.scene.slider, resolve.stator(record.scene.stator)
    body = bridge.contact_slider(slider)
    body = replace(
        body, law="elastic", reciprocal=False, stick_band=0.0, friction=None,
        friction_coefficient=body.static_coefficient or NO_FRICTION,
    )  # fmt: skip
    offsets = [x - slider.center[0] for x, _ in slider.places]
    balls = contact.balls_of(replace(body, preload=body.preload * slider.share), offsets, weights=slider.share)
    tangential, _, normal = abs(record.surface_motion.at(list(slider.places)))
    strongest = int(np.argmax(normal))  # the centre may be a node of the wave
    at_one_volt = contact.PassingWave(
        frequency=record.wave["frequency_Hz"],
        wavelength=_wavelength(record),
        forward=float(normal[strongest]),
        ratio=float(tangential[strongest] / normal[strongest]),
        compliance=fem.wave_compliance(stator.solid, stator.bare_surface),
        strip_width=record.scene.driven_transducer.aperture,
    )  # fmt: skip
    changes, near = [], None
    for voltage in voltages:
        wave = replace(at_one_volt, forward=at_one_volt.forward * float(voltage))
        try:
            near = contact.pillar_motion(balls, wave, loading=True, near=near)
            changes.append(abs(near.exit_over_entry - 1.0))
        except contact.ConvergenceError:
            changes.append(wave.loading_number(balls.preload))
    return changes


def _travel(record: Record, point: dict) -> Rows:
    scene, ratio = record.scene, record.wave["standing_wave_ratio"]
    if scene.slider is None or scene.burst is None or "travel_m" in point:
        return
    if abs(point.get("velocity_m_per_s", 0.0)) * scene.burst > _wavelength(record) / 4:
        how = "standing-wave ratio, over a travel of more than a quarter of a wavelength"
        effect = "travel of the slider along the rippled field"
        yield effect, "u_z", (ratio - 1) / (ratio + 1), how


def _power(record: Record) -> Rows:
    highest = max(record.scene.levels, default=0.0)
    power = record.electrical["power_W_per_V2"] * highest**2
    yield "heating of the stator", f"the whole power taken in at {highest:g} V", power, "admittance", "W"
