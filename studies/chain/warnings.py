"""What a physicist would remark about a run that gave an answer: each with its number and what to do about it.

Every function takes the record of a run and yields sentences, none where nothing is wrong. They cost nothing against
the run: closed forms of what it has computed already.
"""

import math
from collections.abc import Iterator
from itertools import pairwise

from studies.chain import bridge
from studies.record import Record
from studies.scene import Scene, resolved

__all__ = ["warnings_of"]

OFF_RESONANCE = 1.15  # largest over present amplitude from which it is said; the ripple of a plate makes 1.1
CREEP = 0.01  # of the surface's own speed along x
PASCHEN_A, PASCHEN_B, PASCHEN_GAMMA = 11.25, 273.8, 0.01  # 1/(Pa m), V/(Pa m), -: air
AIR = 101325.0  # Pa


def warnings_of(record: Record) -> tuple[str, ...]:
    """Return every warning about a run, in the order of the chain."""
    scene, found = record.scene, []
    if scene.transducer:
        for each in (_field, _breakdown, _stress, _off_resonance, _lossless, _thin_plate):
            found += each(record)
    if scene.slider is not None:
        for each in (_same_place, _pressure, _reversal, _other_motion, _all_stick):
            found += each(record)
    return tuple(found)


def _largest_voltage(record: Record) -> float:
    """Return the peak voltage between driven combs at the highest level, the largest where several are driven."""
    electrical = record.electrical
    several = [each["voltage_per_volt"] for each in electrical.get("sources", {}).values()]
    return max(record.scene.levels) * max(map(abs, [electrical["comb_voltage_per_volt"], *several]))


def _driven(scene: Scene):
    return next(each for each in scene.transducer if each.name == scene.drive.transducer)


def _gap(scene: Scene) -> float:
    """Return the width of a gap between fingers in m."""
    driven = _driven(scene)
    return (1 - driven.metallisation) * driven.period * driven.finger_pairs / driven.fingers


def _catalogue_strength(scene: Scene):
    from fem import strength

    if scene.stator is None or not isinstance(scene.stator.material, str):
        return None
    return strength(scene.stator.material)


def _field(record: Record) -> Iterator[str]:
    """Yield a warning where the field in the gaps, voltage over width, passes what the stator bears."""
    limits, volts, gap = _catalogue_strength(record.scene), _largest_voltage(record), _gap(record.scene)
    if limits is None or limits.field is None or volts <= limits.field * gap:
        return
    yield (
        f"the field between the fingers, {volts:.3g} V over {gap * 1e6:.3g} um, is {volts / gap / 1e6:.3g} MV/m; "
        f"{limits.field / 1e6:g} MV/m is the limit ({limits.field_source}): "
        f"keep the voltage below {limits.field * gap:.3g} V, or widen the gaps"
    )


def _breakdown(record: Record) -> Iterator[str]:
    """Yield a warning where the air above the gaps breaks down (Paschen's law)."""
    volts, gap = _largest_voltage(record), _gap(record.scene)
    limit = breakdown_voltage(gap)
    if volts > limit:
        yield (
            f"{volts:.3g} V between fingers {gap * 1e6:.3g} um apart exceed the breakdown voltage of air there, "
            f"{limit:.3g} V (Paschen's law): keep below it, widen the gaps or cover the fingers"
        )


def breakdown_voltage(gap: float) -> float:
    """Return the breakdown voltage in V of air at 1 atm over a gap in m; its minimum below the gap of the minimum.

    Paschen's law, M. A. Lieberman and A. J. Lichtenberg, Principles of Plasma Discharges, 2nd ed. 2005, eq. 14.3.5.
    """
    least = math.e * math.log(1 + 1 / PASCHEN_GAMMA) / PASCHEN_A
    product = max(AIR * gap, least)
    return PASCHEN_B * product / math.log(PASCHEN_A * product / math.log(1 + 1 / PASCHEN_GAMMA))


def _stress(record: Record) -> Iterator[str]:
    """Yield a warning where the wave's stress along x passes what a ceramic bears."""
    limits = _catalogue_strength(record.scene)
    if limits is None or limits.tensile_stress is None:
        return
    c = resolved.solid(record.scene.stator).stiffness
    stiffness = c[0, 0] - c[0, 2] ** 2 / c[2, 2]  # plane strain, no traction on the surface
    wavenumber = 2 * math.pi * record.wave["frequency_Hz"] / record.wave["phase_velocity_m_per_s"]
    motion = max(record.scene.levels) * float(abs(record.surface["u_x_m_per_V"]).max())
    stress = stiffness * wavenumber * motion
    if stress > limits.tensile_stress:
        highest = max(record.scene.levels) * limits.tensile_stress / stress
        yield (
            f"the wave's stress at the surface reaches {stress / 1e6:.3g} MPa (u_x = {motion * 1e9:.3g} nm); "
            f"{limits.tensile_stress / 1e6:g} MPa is the rated dynamic tensile strength (Morgan TP-226): "
            f"keep the voltage below {highest:.3g} V"
        )


def _off_resonance(record: Record) -> Iterator[str]:
    """Yield a warning where another frequency would give a larger wave, by coupled modes of the driven transducer."""
    scene = record.scene
    driven = _driven(scene)
    if driven.pattern is not None or driven.split or scene.drive.source_impedance:
        return
    import numpy as np

    from fem import ConvergenceError, relative_amplitude

    solid, present = resolved.solid(scene.stator), scene.frequency
    transducer = next(each for each in resolved.transducers(scene) if each.name == driven.name)
    surface = "open" if scene.stator.above == "none" else "vacuum"
    reach = 2 / max(driven.finger_pairs, 4)
    frequencies = np.append(np.linspace(1 - reach, 1 + reach, 801) * present, present)
    try:
        sizes = relative_amplitude(solid, transducer, frequencies, surface=surface)
    except ConvergenceError:
        return  # a cut whose half-space has no such wave: there is no estimate
    best = int(np.argmax(sizes))
    gain = float(sizes[best] / max(sizes[-1], sizes[best] * 1e-3))
    if gain > OFF_RESONANCE:
        better = frequencies[best] / 1e6
        more = f"about {100 * (gain - 1):.0f} % larger" if gain < 10 else "ten times as large or more"
        yield (
            f"the drive is off the transducer's resonance: u_z would be {more} at {better:.4g} MHz "
            f'(estimate by coupled modes): set drive.frequency = "{better:.4g} MHz" with '
            f'period = "{driven.period * 1e3:.6g} mm", or scale the period by {present / frequencies[best]:.4f}'
        )


def _lossless(record: Record) -> Iterator[str]:
    """Yield a warning where nothing but the transducers takes power out of a wave that the ends send back."""
    scene = record.scene
    if scene.stator.ends == "absorbing" or math.isfinite(resolved.solid(scene.stator).mechanical_quality):
        return
    yield (
        "the stator is lossless and its ends reflect, so that the amplitude depends on fractions of a wavelength "
        f"(standing-wave ratio {record.wave['standing_wave_ratio']:.3g}): give stator.mechanical_quality, "
        'or ends = "absorbing"'
    )


def _thin_plate(record: Record) -> Iterator[str]:
    """Yield a warning where the surface wave passes to the other face, or the plate is too thin for one."""
    stator, wave = record.scene.stator, record.surface_wave
    if isinstance(stator.thickness, str) or stator.bottom == "absorbing":
        return
    thickness = stator.thickness * record.scene.frequency / wave.phase_velocity
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


def _same_place(record: Record) -> Iterator[str]:
    """Yield a warning where a number of contacts stands for places."""
    slider = record.scene.slider
    if isinstance(slider.contacts, int) and slider.contacts > 1:
        yield (
            f"contacts = {slider.contacts} means {slider.contacts} balls at one place, moved by the same wave: "
            'give their offsets along x instead, such as contacts = ["-5 mm", "5 mm"]'
        )


def _pressure(record: Record) -> Iterator[str]:
    """Yield warnings where the Hertz pressure passes what ball or stator bear, at rest or on the highest crest."""
    from contact import riding_height
    from fem import strength

    scene = record.scene
    slider = bridge.contact_slider(scene.slider)
    if slider.preload == 0:
        return
    level = max(scene.levels)
    if record.surface_wave is not None:
        orbits = bridge.scaled(bridge.orbits_per_volt(record.surface_wave, scene.slider), level)
    else:
        orbits = bridge.scaled(bridge.given_orbits(scene.wave), level)
    approach = riding_height(slider, orbits) + max(abs(orbit.normal) for orbit in orbits)
    highest = hertz_pressure(slider, max(approach, 0.0))
    at_rest = hertz_pressure(slider, slider.rest_approach(len(orbits)))
    known = (("the balls bear", strength("steel")), ("the stator bears", _catalogue_strength(scene)))
    for part, limits in known:
        if limits is None or highest <= limits.contact_pressure:
            continue
        resting = at_rest > limits.contact_pressure
        pressure, when = (at_rest, "at rest") if resting else (highest, "on the wave's crest")
        remedy = "more or larger balls, or less preload" + ("" if resting else " or drive")
        yield (
            f"Hertz pressure {pressure / 1e9:.3g} GPa {when} exceeds what {part}, "
            f"{limits.contact_pressure / 1e9:.3g} GPa ({limits.pressure_source}): {remedy}"
        )


def hertz_pressure(slider, approach: float) -> float:
    """Return p0 = 2 E* a / (pi R), a^2 = R z, in Pa, of a ball pressed in by z in m; (6 P E*^2 / (pi^3 R^2))^(1/3)."""
    return 2 * slider.effective_modulus / math.pi * math.sqrt(approach / slider.radius)


def _reversal(record: Record) -> Iterator[str]:
    """Yield a warning where the slider runs one way at one point and the other way at the next."""
    omega = 2 * math.pi * record.wave["frequency_Hz"]
    moving = [point for point in record.points if _moves(point, omega)]
    for one, other in pairwise(moving):
        if one["velocity_m_per_s"] * other["velocity_m_per_s"] < 0:
            low, high = (f"{point[record.level]:.3g}" for point in (one, other))
            unit = "m" if record.scene.wave is not None else "V"
            key = "wave.normal_amplitude" if record.scene.wave is not None else "drive.voltage"
            yield (
                f"the slider reverses its direction between {low} and {high} {unit} "
                f"({one['velocity_m_per_s'] * 1e3:.3g} and {other['velocity_m_per_s'] * 1e3:.3g} mm/s): "
                f"give {key} more values between them"
            )


def _other_motion(record: Record) -> Iterator[str]:
    """Yield a warning where a second steady motion is known: the one that a start from rest misses or goes on with."""
    several = [point for point in record.points if "other_velocity_m_per_s" in point]
    if not several:
        return
    point, damping = several[-1], record.scene.slider.damping
    level = f"{point[record.level]:.3g} {'m' if record.scene.wave is not None else 'V'}"
    here, other = (f"{point[key] * 1e3:.4g}" for key in ("velocity_m_per_s", "other_velocity_m_per_s"))
    where = f"at {len(several)} of {len(record.points)} points (at {level}: {here} and {other} mm/s)"
    if damping is None or damping.normal == damping.contact == 0:
        yield (
            f"nothing damps the slider's bounce, so that after a start from rest it goes on for ever and changes the "
            f"mean velocity {where}: give slider.damping.normal or slider.damping.contact"
        )
    else:
        yield (
            f"a second steady motion exists {where}, the first of them being that of a start from rest: raise "
            "slider.damping.normal, or the wave's frequency above the contact's resonance"
        )


def _moves(point: dict, omega: float) -> bool:
    """Return whether the slider runs faster than the creep next to the threshold."""
    return abs(point.get("velocity_m_per_s", 0.0)) > CREEP * omega * point["tangential_amplitude_m"]


def _all_stick(record: Record) -> Iterator[str]:
    """Yield a warning where no point moves: the answer is the threshold, and the wave's own error counts."""
    if not record.at_rest:
        return
    key, unit, factor = (
        ("threshold_amplitude_m", "nm", 1e9)
        if record.scene.wave is not None
        else ("threshold_voltage_V", "V", 1)
    )
    threshold = record.summary.get(key)
    known = record.wave.get("relative_error")
    accuracy = "" if known is None else f", the wave under the slider being known to {known:.1e}"
    yield (
        "the slider sticks at every point: no velocity, and no error of it"
        + (f"; it starts at {threshold * factor:.4g} {unit}{accuracy}" if threshold is not None else accuracy)
    )
