"""Warnings about the stator of a run: field, breakdown, stress, resonance, reflecting ends, a plate too thin."""

import math
from collections.abc import Iterator

import numpy as np

from studies.record import Record
from studies.scene import Scene, resolved

OFF_RESONANCE = 1.15  # largest over present amplitude from which it is said; the ripple of a plate makes 1.1
PASCHEN_A, PASCHEN_B, PASCHEN_GAMMA = 11.25, 273.8, 0.01  # 1/(Pa m), V/(Pa m), -: air
AIR = 101325.0  # Pa


def _largest_voltage(record: Record) -> float:
    """Return the peak voltage between driven combs at the highest level, the largest where several are driven."""
    electrical = record.electrical
    several = [each["voltage_per_volt"] for each in electrical.get("sources", {}).values()]
    return max(record.scene.levels) * max(map(abs, [electrical["comb_voltage_per_volt"], *several]))


def _gap(scene: Scene) -> float:
    """Return the width of a gap between fingers in m."""
    driven = scene.driven_transducer
    return (1 - driven.metallisation) * driven.period * driven.finger_pairs / driven.fingers


def catalogue_strength(scene: Scene):
    """Return the ``fem.Strength`` of the stator's material; None without a stator or without known limits."""
    from fem import strength

    if scene.stator is None or not isinstance(scene.stator.material, str):
        return None
    return strength(scene.stator.material)


def _field(record: Record) -> Iterator[str]:
    """Yield a warning where the field in the gaps, voltage over width, passes what the stator bears."""
    limits, volts, gap = catalogue_strength(record.scene), _largest_voltage(record), _gap(record.scene)
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
    limits = catalogue_strength(record.scene)
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
    driven = scene.driven_transducer
    if (
        driven.pattern is not None
        or driven.split
        or scene.drive.source_impedance
        or scene.drive.match != "none"
    ):
        return
    from fem import ConvergenceError, relative_amplitude

    solid, present = resolved.solid(scene.stator), scene.frequency
    surface = "open" if scene.stator.above == "none" else "vacuum"
    reach = 2 / max(driven.finger_pairs, 4)
    frequencies = np.append(np.linspace(1 - reach, 1 + reach, 801) * present, present)
    try:
        sizes = relative_amplitude(solid, resolved.driven(scene), frequencies, surface=surface)
    except ConvergenceError:
        return  # a cut whose half-space has no such wave: there is no estimate
    best = int(np.argmax(sizes))
    gain = float(sizes[best] / max(sizes[-1], sizes[best] * 1e-3))
    if gain > OFF_RESONANCE:
        better = frequencies[best] / 1e6
        more = f"about {100 * (gain - 1):.0f} % larger" if gain < 10 else "ten times as large or more"
        yield (
            f"the drive is off the transducer's resonance: u_z would be {more} at {better:.4g} MHz "
            f'(estimate by coupled modes): set drive.frequency = "center" with '
            f'period = "{driven.period * 1e3:.6g} mm", or period = "auto"'
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


OF_THE_STATOR = (_field, _breakdown, _stress, _off_resonance, _lossless, _thin_plate)
