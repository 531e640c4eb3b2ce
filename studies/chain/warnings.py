"""Warnings on a run that gave an answer, each with its number and what to do about it.

Every function takes the record of a run and yields sentences, none where nothing is wrong. They take 0.05 s:
closed forms of what the run has computed already.
"""

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

import fem
from studies.chain import resolve
from studies.chain.bridge import DrivenContact
from studies.chain.model_error import SHARED
from studies.chain.points import contact_load
from studies.chain.scene_warnings import scene_warnings
from studies.record import Record
from studies.scene import Scene

# Largest over present amplitude, from which on a warning says so; a plate's ripple makes 1.1
OFF_RESONANCE = 1.15
PASCHEN_A, PASCHEN_B, PASCHEN_GAMMA = 11.25, 273.8, 0.01  # 1/(Pa m), V/(Pa m), -: air
AIR = 101325.0  # Pa
SIDEWAYS = 0.1  # |u_y| over |u_x|, from which on a warning says so
NODE = 1e-6  # of |u_x|: smaller |u_z| are those of waves from both sides that cancel
CREEP = 0.01  # of the surface's own speed along x
SPREADS = 0.1  # of u_z that the finite aperture changes, from which it is said that the section leaves it out
DECIDES = 0.1  # relative change of u_z or of the velocity from which an effect outside the model is a warning


def warnings_of(record: Record) -> tuple[str, ...]:
    """Return every warning about a run, in the order of the chain."""
    warnings = list(scene_warnings(record.scene))
    if record.scene.piece:
        stator, row = resolve.whole_stator(record.scene), resolve.transducers(record.scene)
        warnings += stator.piece_warnings(record.scene.frequency, row)
    if record.scene.transducer:
        for each in (_drive, _off_resonance, _section, _left_out):
            warnings += each(record)
    if record.scene.slider is not None:
        driven = DrivenContact.of_run(record)
        for of_contact in (_contact, _points, _other_motion):
            warnings += of_contact(record, driven)
        if record.scene.slider.pillars is not None:
            from studies.chain.pillar_budget import pillar_warnings

            warnings += _left_out(record) if not record.scene.transducer else ()
            warnings += pillar_warnings(record)
    return tuple(warnings)


def _strength(scene: Scene):
    """Return the ``fem.Strength`` of the stator's material; None without a stator or without known limits."""
    known = scene.stator is not None and isinstance(scene.stator.material, str)
    return fem.strength(scene.stator.material) if known else None


def _drive(record: Record) -> Iterator[str]:
    """Yield warnings where fingers or air break down between the combs, or the wave's stress breaks the stator."""
    scene, driven, electrical = record.scene, record.scene.driven_transducer, record.electrical
    highest, limits = max(scene.levels), _strength(scene)
    gap = (1 - driven.metallisation) * driven.wavelength * driven.finger_pairs / driven.fingers
    voltages = [each["voltage_per_volt"] for each in electrical.get("sources", {}).values()]
    volts = highest * max(map(abs, [electrical["comb_voltage_per_volt"], *voltages]))
    breakdown = breakdown_voltage(gap)
    if limits is not None and limits.field is not None and volts > limits.field * gap:
        yield (
            f"the field between the fingers, {volts:.3g} V over {gap * 1e6:.3g} um, is {volts / gap / 1e6:.3g} MV/m; "
            f"{limits.field / 1e6:g} MV/m is the limit ({limits.field_source}): "
            f"keep the voltage below {limits.field * gap:.3g} V, or widen the gaps"
        )
    if volts > breakdown:
        yield (
            f"{volts:.3g} V between fingers {gap * 1e6:.3g} um apart exceed the breakdown voltage of air there, "
            f"{breakdown:.3g} V (Paschen's law): keep below it, widen the gaps or cover the fingers"
        )
    if limits is None or limits.tensile_stress is None:
        return
    c = resolve.solid(scene.stator).stiffness
    stiffness = c[0, 0] - c[0, 2] ** 2 / c[2, 2]  # plane strain, no traction on the surface
    wavenumber = 2 * math.pi * record.wave["frequency_Hz"] / record.wave["phase_velocity_m_per_s"]
    motion = highest * float(abs(record.surface["u_x_m_per_V"]).max())
    stress = stiffness * wavenumber * motion
    if stress > limits.tensile_stress:
        yield (
            f"the wave's stress at the surface reaches {stress / 1e6:.3g} MPa (u_x = {motion * 1e9:.3g} nm); "
            f"{limits.tensile_stress / 1e6:g} MPa is the rated dynamic tensile strength (Morgan TP-226): "
            f"keep the voltage below {highest * limits.tensile_stress / stress:.3g} V"
        )


def breakdown_voltage(gap: float) -> float:
    """Return the breakdown voltage in V of air at 1 atm over a gap in m; its minimum below the gap of the minimum.

    Paschen's law, M. A. Lieberman and A. J. Lichtenberg, Principles of Plasma Discharges, 2nd ed. 2005, eq. 14.3.5.
    """
    least = math.e * math.log(1 + 1 / PASCHEN_GAMMA) / PASCHEN_A
    product = max(AIR * gap, least)
    return PASCHEN_B * product / math.log(PASCHEN_A * product / math.log(1 + 1 / PASCHEN_GAMMA))


def _off_resonance(record: Record) -> Iterator[str]:
    """Yield a warning where another frequency would give a larger wave, by coupled modes of the driven transducer."""
    scene, driven, drive = record.scene, record.scene.driven_transducer, record.scene.drive
    if driven.pattern is not None or driven.split or drive.source_impedance or drive.match != "none":
        return
    stator, present = resolve.stator(scene.stator), scene.frequency
    reach = 2 / max(driven.finger_pairs, 4)
    frequencies = np.append(np.linspace(1 - reach, 1 + reach, 801) * present, present)
    try:
        sizes = fem.relative_amplitude(
            stator.solid, resolve.driven(scene), frequencies, surface=stator.bare_surface
        )
    except fem.ConvergenceError:
        return  # a cut whose half-space has no such wave: there is no estimate
    best = int(np.argmax(sizes))
    gain = float(sizes[best] / max(sizes[-1], sizes[best] * 1e-3))
    if gain > OFF_RESONANCE:
        better = frequencies[best] / 1e6
        more = f"about {100 * (gain - 1):.0f} % larger" if gain < 10 else "ten times as large or more"
        yield (
            f"the drive is off the transducer's resonance: u_z would be {more} at {better:.4g} MHz "
            f'(estimate by coupled modes): set drive.frequency = "center" with '
            f'period = "{driven.wavelength * 1e3:.6g} mm", or period = "auto"'
        )


def _section(record: Record) -> Iterator[str]:
    """Yield warnings where the section leaves out much, reflecting ends meet no loss, or the plate is too thin."""
    for each in record.model_error:
        if each["effect"] == "finite aperture" and abs(each["size"]) > SPREADS:
            refused = fem.beam_refusal(resolve.whole_stator(record.scene))
            yield (
                f"the plane section leaves out that the aperture is finite, about {100 * each['size']:+.0f} % of u_z: "
                + (refused or "stator.diffraction = true takes it in")
            )
    stator, wave, frequency = record.scene.stator, record.surface_wave, record.scene.frequency
    if stator.ends != "absorbing" and math.isinf(resolve.solid(stator).mechanical_quality):
        yield (
            "the stator is lossless and its ends reflect, so that the amplitude depends on fractions of a wavelength "
            f"(standing-wave ratio {record.wave['standing_wave_ratio']:.3g}): give stator.mechanical_quality, "
            'or ends = "absorbing"'
        )
    if isinstance(stator.thickness, str) or stator.bottom == "absorbing":
        if fem.absorber_kind(resolve.solid(stator)) == "viscous":
            yield (
                "no fast absorbing layer is known for the half-space of this cut, whose slowness curve is too concave "
                "at the x axis: a viscous layer stands for it, which converges slowly; a stator.thickness of a few "
                "wavelengths with a free bottom is much faster"
            )
        return
    thickness = stator.thickness * frequency / abs(wave.phase_velocity)
    if wave.transfer_length < stator.length:
        yield (
            f"the plate is thin, {thickness:.2g} wavelengths: the wave passes to its other face and back, fully after "
            f"{wave.transfer_length * 1e3:.3g} mm of the stator's {stator.length * 1e3:.3g} mm; "
            'take a thicker plate, or bottom = "absorbing" if it is glued to a lossy base'
        )
    elif thickness < 1:
        yield (
            f"the plate is {thickness:.2g} wavelengths thick: what runs in it is a plate wave that moves both faces, "
            "no surface wave; take a thicker plate or a higher frequency"
        )


def _left_out(record: Record) -> Iterator[str]:
    """Yield a warning for every effect outside the model that changes the wave or the velocity by a tenth or more."""
    for row in record.model_error:
        size, quantity = row["size"], row["quantity"]
        if (
            quantity in SHARED and abs(size) >= DECIDES and row["effect"] != "finite aperture"
        ):  # `_section` has it
            yield (
                f"model error: {row['effect']} changes {quantity} by about {100 * size:+.2g} %, which the model leaves "
                f"out ({row['source']}); the numerical error does not contain it"
            )


def _contact(record: Record, driven: DrivenContact) -> Iterator[str]:
    """Yield warnings where a ball is moved sideways, or presses harder than it or the stator bears."""
    normal, tangential = (
        abs(record.wave.get(f"{name}_m_per_V", np.nan)) for name in ("normal", "tangential")
    )
    if normal < NODE * tangential:  # not of a given wave, which has no motion per volt
        yield (
            "u_z vanishes at the slider's centre: the amplitudes of the points are taken "
            "at the centre and say nothing about the wave under the balls: another slider.position"
        )
    ratio = record.wave.get("largest_lateral_ratio", 0.0)
    if ratio > SIDEWAYS:
        nearer = "keep the balls nearer to the middle of the beam"
        if not any(across for _, across in record.scene.slider.offsets):
            nearer = "in this cut the wave has u_y on its axis, and counts most where a standing wave's u_x is small"
        yield (
            f"the surface moves sideways under a ball, |u_y/u_x| = {ratio:.2g}, but the contact follows it along "
            f"x alone: {'drive less across' if record.scene.crossed else nearer}"
        )
    slider, orbits = driven.slider, driven.at(max(record.scene.levels))
    if slider.preload == 0:
        return
    highest = contact_load(slider, orbits, math.inf)["contact_pressure_Pa"]
    at_rest = slider.pressure(max(slider.rest_approaches(len(orbits))))
    kind, what = "Hertz pressure", "balls"
    if slider.shape == "punch":
        kind, what = "Mean pressure under a punch,", "punches"
    known = ((f"the {what} bear", fem.strength("steel")), ("the stator bears", _strength(record.scene)))
    for part, limits in known:
        if limits is None or highest <= limits.contact_pressure:
            continue
        resting = at_rest > limits.contact_pressure
        pressure, when = (at_rest, "at rest") if resting else (highest, "on the wave's crest")
        yield (
            f"{kind} {pressure / 1e9:.3g} GPa {when} exceeds what {part}, {limits.contact_pressure / 1e9:.3g} GPa "
            f"({limits.pressure_source}): more or larger {what}, or less preload{'' if resting else ' or drive'}"
        )


def _points(record: Record, driven: DrivenContact) -> Iterator[str]:
    """Yield warnings where the slider runs one way at a point and the other way at the next, or sticks at all."""
    omega, unit = 2 * math.pi * record.wave["frequency_Hz"], _unit(record)
    moving = [
        (point[record.level], velocity)
        for point in record.points
        if abs(velocity := point.get("velocity_m_per_s", 0.0))
        > CREEP * omega * point["tangential_amplitude_m"]
    ]
    for (low, before), (high, after) in pairwise(moving):
        if before * after < 0:
            yield (
                f"the slider reverses its direction between {low:.3g} and {high:.3g} {unit} ({before * 1e3:.3g} and "
                f"{after * 1e3:.3g} mm/s): give {driven.level_key} more values between them"
            )
    if record.at_rest:  # the answer is the threshold, and the wave's own error counts
        known = record.wave.get("relative_error")
        threshold = record.summary.get("threshold_amplitude_m" if unit == "m" else "threshold_voltage_V")
        starts = "" if threshold is None else f"; it starts at {driven.named(threshold)}"
        accuracy = "" if known is None else f", the wave under the slider being known to {known:.1e}"
        yield f"the slider sticks at every point: no velocity, and no error of it{starts}{accuracy}"


def _unit(record: Record) -> str:
    return "m" if record.scene.wave is not None else "V"


def _other_motion(record: Record, _driven: DrivenContact) -> Iterator[str]:
    """Yield a warning where a second steady motion is known: the one that a start from rest misses or goes on with."""
    several = [point for point in record.points if "other_velocity_m_per_s" in point]
    if not several:
        return
    point, damping = several[-1], record.scene.slider.damping
    here, other = (f"{point[key] * 1e3:.4g}" for key in ("velocity_m_per_s", "other_velocity_m_per_s"))
    level = f"{point[record.level]:.3g} {_unit(record)}"
    where = f"at {len(several)} of {len(record.points)} points (at {level}: {here} and {other} mm/s)"
    if damping.normal == damping.contact == 0:
        yield (
            f"nothing damps the slider's bounce, so that after a start from rest it goes on for ever and changes the "
            f"mean velocity {where}: give slider.damping.normal or slider.damping.contact"
        )
    else:
        yield (
            f"a second steady motion exists {where}, the first of them being that of a start from rest: raise "
            "slider.damping.normal, or the wave's frequency above the contact's resonance"
        )
