"""Warnings about a run that has an answer, each with a number and advice.

Each function takes the record of a run and yields sentences; it yields nothing if it has no objection. All of them
together take 0.05 s, because they evaluate closed forms on values that the run has already computed.
"""

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

import contact
import fem
from studies.model.fem_objects import unturned
from studies.model.free_way import free_way
from studies.model.model import model_of
from studies.model.wave_to_contact import Contact, contact_slider
from studies.record import Record
from studies.record.text import percent
from studies.record.waveform import is_step
from studies.remarks.ball_effects import NODE
from studies.remarks.ball_surface import AT_LARGEST, DECIDES, of_patch, smooth_balls
from studies.remarks.heat_warnings import heat_warnings
from studies.remarks.loaded_wave_effects import wave_warnings
from studies.remarks.model_error import SHARED
from studies.remarks.scene_warnings import scene_warnings
from studies.remarks.stator_effects import surface_strain
from studies.scene import Scene
from studies.scene.plane_keys import AXLE
from studies.scene.slider_keys import Slider
from studies.solve.solved_stator import contact_of_run

PASCHEN_A, PASCHEN_B, PASCHEN_GAMMA = 11.25, 273.8, 0.01  # of air, in 1/(Pa m), V/(Pa m) and 1
AIR = 101325.0  # pressure in Pa
CREEP = 0.01  # slider speed over the speed of the surface along x below which the slider counts as sticking
# Values above which a warning is issued:
OFF_RESONANCE = 1.15  # largest amplitude over frequency, relative to the present one; the ripple of a plate makes 1.1
USUAL_SPEED = 10.0  # m/s of a slider; surface-acoustic-wave motors reach 1 to 2 m/s
SIDEWAYS = 0.1  # |u_y|/|u_x|
RIPPLE = 0.1  # range of the velocity over half a wavelength, over the larger of its mean and omega u_x / 10


def warnings_of(record: Record) -> tuple[str, ...]:
    """Return all warnings about a run, ordered from the drive to the slider."""
    warnings = [*scene_warnings(record.scene), *_steps(record.scene)]
    if record.scene.piece:
        model = model_of(record.scene)
        warnings += model.stator.piece_warnings(record.scene.frequency, model.transducers)
    if record.scene.transducer:
        warnings += [
            *_drive(record),
            *_off_resonance(record),
            *_section(record),
            *heat_warnings(record),
            *_left_out(record),
        ]
    elif record.scene.wave is not None:
        warnings += _left_out(record)
    if record.scene.slider is not None:
        warnings += [
            *smooth_balls(record), *of_patch(record), *_contact(record), *_points(record), *_ripple(record),
            *_end_of_way(record), *_other_motion(record),
        ]  # fmt: skip
        warnings += wave_warnings(record)
    return tuple(warnings)


def _steps(scene: Scene) -> Iterator[str]:
    """Yield a warning for each edge of a burst's waveform that is shorter than a period of its wave."""
    source = scene.source
    if source is None or source.waveform is None:
        return
    for name in ("rise", "fall"):
        edge = getattr(source.waveform, name)
        if edge > 0.0 and is_step(edge, scene.frequency):
            period = f"{1e6 / scene.frequency:.3g} us"
            yield f"{source.block}.waveform.{name} of {edge * 1e6:.3g} us is taken as a step: a period is {period}"


def _strength(scene: Scene):
    """Return the ``fem.Strength`` of the stator's material; None without a stator or without known limits."""
    named = scene.stator is not None and isinstance(scene.stator.material, str)
    return fem.strength(scene.stator.material) if named else None


def _drive(record: Record) -> Iterator[str]:
    """Yield warnings about breakdown of solid or air between the fingers and about fracture of the stator."""
    scene, limits, circuit = record.scene, _strength(record.scene), record.surface_motion.circuit
    highest = max(scene.levels)
    between = dict(zip(circuit.names, np.abs(circuit.voltages).tolist(), strict=True))  # V per V, terminated ones too
    several = len(between) > 1
    for each in scene.transducer:
        gap, volts = each.gap, highest * between.get(each.name, 0.0)
        whose = f" of transducer {each.name}" if several else ""
        if gap is None or volts == 0.0:
            continue
        if limits is not None and limits.field is not None and volts > limits.field * gap:
            yield (
                f"the field between the fingers{whose}, {volts:.3g} V over {gap * 1e6:.3g} um, is "
                f"{volts / gap / 1e6:.3g} MV/m; {limits.field / 1e6:g} MV/m is the limit ({limits.field_source}): "
                f"keep the drive below {highest * limits.field * gap / volts:.3g} V, or widen the gaps"
            )
        if volts > (breakdown := breakdown_voltage(gap)):
            yield (
                f"{volts:.3g} V between fingers{whose} {gap * 1e6:.3g} um apart exceed the breakdown voltage of air "
                f"there, {breakdown:.3g} V (Paschen's law): keep the drive below {highest * breakdown / volts:.3g} V, "
                "widen the gaps or cover the fingers"
            )
    if limits is None or limits.tensile_stress is None:
        return
    c = model_of(scene).surface_solid.stiffness
    stiffness = c[0, 0] - c[0, 2] ** 2 / c[2, 2]  # plane strain, no traction on the surface
    u_x = highest * float(abs(record.surface.u_x_m_per_V).max())
    stress = stiffness * surface_strain(record, highest)
    if stress > limits.tensile_stress:
        yield (
            f"the wave's stress at the surface reaches {stress / 1e6:.3g} MPa (u_x = {u_x * 1e9:.3g} nm); "
            f"{limits.tensile_stress / 1e6:g} MPa is the rated dynamic tensile strength (Morgan TP-226): "
            f"keep the voltage below {highest * limits.tensile_stress / stress:.3g} V"
        )


def breakdown_voltage(gap: float) -> float:
    """Return the breakdown voltage in V of air at 1 atm over a gap in m.

    Paschen's law has a minimum over the gap; the minimum is returned for all smaller gaps. Source: M. A.
    Lieberman and A. J. Lichtenberg, Principles of Plasma Discharges, 2nd ed. 2005, eq. 14.3.5.
    """
    product_at_minimum = math.e * math.log(1 + 1 / PASCHEN_GAMMA) / PASCHEN_A
    product = max(AIR * gap, product_at_minimum)
    return PASCHEN_B * product / math.log(PASCHEN_A * product / math.log(1 + 1 / PASCHEN_GAMMA))


def _off_resonance(record: Record) -> Iterator[str]:
    """Yield a warning for each design of a driven transducer whose wave is larger at another frequency.

    The amplitudes are those of the coupled-mode model.
    """
    scene, drive = record.scene, record.scene.drive
    if drive.source_impedance or drive.match != "none":
        return
    stator, driven = model_of(scene).plain, scene.driven_transducers
    own = dict(drive.source_frequencies or ())
    if stator.layers:
        return  # the coupled modes are those of one solid
    plain = (each for each in driven if each.pattern is None and not each.split and each.even)
    designs = {(each.wavelength, each.finger_pairs, each.metallisation): each for each in plain}
    for each in designs.values():
        half_band, present = 2 / max(each.finger_pairs, 4), own.get(each.name, scene.frequency)
        frequencies = np.append(np.linspace(1 - half_band, 1 + half_band, 801) * present, present)
        transducer = unturned(each, each.wavelength)
        try:
            size = fem.relative_amplitude(stator.solid, transducer, frequencies, surface=stator.bare_surface)
        except fem.ConvergenceError:
            return  # the half-space of this cut has no surface wave: no estimate is possible
        best = int(np.argmax(size))
        gain = float(size[best] / max(size[-1], size[best] * 1e-3))
        if gain > OFF_RESONANCE:
            more = f"about {100 * (gain - 1):.0f} % larger" if gain < 10 else "ten times as large or more"
            whose = "the transducer's resonance" if len(driven) == 1 else f"the resonance of transducer {each.name}"
            yield (
                f"the drive is off {whose}: u_z would be {more} at {frequencies[best] / 1e6:.4g} MHz "
                f'(estimate by coupled modes): set drive.frequency = "center" with '
                f'period = "{each.wavelength * 1e3:.6g} mm", or period = "auto"'
            )


def _section(record: Record) -> Iterator[str]:
    """Yield warnings about the finite aperture, about lossless stators with reflecting ends and about thin plates."""
    for each in record.model_error:
        if each.effect == "finite aperture" and abs(each.size) > DECIDES:
            refused = fem.beam_refusal(model_of(record.scene).stator)
            size = f"{100 * each.size:+.0f} % of u_z"
            remedy = refused or "stator.diffraction = true includes it"
            yield f"the plane section neglects that the aperture is finite, about {size}: {remedy}"
    stator, wave, frequency = record.scene.stator, record.surface_wave, record.scene.frequency
    solid = model_of(record.scene).solid
    if stator.ends != "absorbing" and math.isinf(solid.mechanical_quality):
        yield (
            "the stator is lossless and its ends reflect, so that the amplitude depends on fractions of a wavelength "
            f"(standing-wave ratio {record.wave.standing_wave_ratio:.3g}): give stator.mechanical_quality, "
            'or ends = "absorbing"'
        )
    if isinstance(stator.thickness, str) or stator.bottom == "absorbing":
        if fem.absorber_kind(solid) == "viscous":
            yield (
                "no fast absorbing layer is known for the half-space of this cut, whose slowness curve is too concave "
                "at the x axis: a viscous layer is used, which converges slowly; a stator.thickness of a few "
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
            f"the plate is {thickness:.2g} wavelengths thick: its wave is a plate wave that moves both faces, "
            "not a surface wave; take a thicker plate or a higher frequency"
        )


def _left_out(record: Record) -> Iterator[str]:
    """Yield a warning for each neglected effect that changes u_z or the velocity by ``DECIDES`` or more."""
    for each in record.model_error:
        effect, quantity, size = each.effect, each.quantity, each.size
        # `_section` warns about the finite aperture, `smooth_balls` about the surfaces of balls
        if quantity in SHARED and abs(size) >= DECIDES and effect not in ("finite aperture", *AT_LARGEST):
            yield (
                f"model error: a neglected effect ({effect}) changes {quantity} by about {percent(size)} "
                f"({each.source}); the numerical error does not include it"
            )


def _contact(record: Record) -> Iterator[str]:
    """Yield warnings about lateral motion, load, a damper that pulls, and pressures above a material's strength."""
    normal, tangential = (abs(record.wave.get(f"{name}_m_per_V", np.nan)) for name in ("normal", "tangential"))
    # NaN, and therefore false, for a scene with a [wave], which has no motion per volt
    driven = contact_of_run(record)
    if normal < NODE * tangential and not driven.passing:
        yield (
            "u_z vanishes at the slider's centre: the amplitudes of the points are taken "
            "at the centre and do not describe the wave under the contacts: choose another slider.position"
        )
    ratio = record.wave.largest_lateral_ratio or 0.0
    if ratio > SIDEWAYS and not record.scene.planar:
        nearer = "keep the contacts nearer to the middle of the beam"
        if not any(across for _, across in record.scene.slider.offsets):
            nearer = "in this cut the wave has u_y on its axis, and counts most where a standing wave's u_x is small"
        yield (
            f"the surface moves sideways under the slider, |u_y/u_x| = {ratio:.2g}, but the contact follows it along "
            f"x alone: {'reduce the drive of the crossing transducers' if record.scene.crossed else nearer}"
        )
    yield from _dragged(record.scene.slider, driven)
    slider, orbits = contact_slider(record.scene.slider.along_x), driven.at(max(record.scene.levels))
    if slider.preload == 0:
        return
    pull, share = contact.damper_pull(slider, orbits)
    if pull < 0.0:
        yield (
            f"slider.damping.contact, {slider.contact_damping:g} s/m, is so large that a contact pulls the slider "
            f"down, with up to {-pull * 1e3:.3g} mN during {100 * share:.2g} % of a cycle, which a dry contact cannot: "
            "choose a smaller one"
        )
    at_rest = float(np.max(slider.pressure(slider.rest_approaches(driven.contacts))))
    highest = max((point.contact_pressure_Pa or 0.0 for point in record.points), default=0.0)
    highest = max(highest, at_rest)
    punch = slider.shape == "punch"
    kind, what = ("Mean pressure under a punch,", "punches") if punch else ("Hertz pressure", "balls")
    parts = ((f"the {what} bear", fem.strength("steel")), ("the stator bears", _strength(record.scene)))
    for part, limits in parts:
        if limits is None or highest <= limits.contact_pressure:
            continue
        resting = at_rest > limits.contact_pressure
        pressure, when = (at_rest, "at rest") if resting else (highest, "on the wave's crest")
        yield (
            f"{kind} {pressure / 1e9:.3g} GPa {when} exceeds what {part}, {limits.contact_pressure / 1e9:.3g} GPa "
            f"({limits.pressure_source}): choose more or larger {what}, or less preload{'' if resting else ' or drive'}"
        )


def _dragged(block: Slider, driven: Contact) -> Iterator[str]:
    """Yield warnings about a force or a torque on the slider that is larger than the friction which holds it."""
    load, key = block.scalar_load, "slider.load"
    if block.incline is not None and any(block.incline):
        from studies.model.plane import contact_load

        load, key = (
            math.hypot(*contact_load(block)) + load * block.opposes,
            "slider.incline" + f" with {key}" * (load > 0),
        )
    friction = block.share * contact_slider(block.along_x).static_friction(driven.contacts)
    if load > friction and block.freedom != AXLE:  # an axle carries it
        limit = "the damper alone" if block.damping.tangential else "nothing"
        yield (
            f"{key}, {load:.4g} N, exceeds the friction that holds the slider, "
            f"{friction:.4g} N: it drags the slider back even without a wave, and {limit} limits the speed: "
            f"lower {key}"
        )
    if not block.turns or not block.torque:
        return
    from studies.solve.plane_motor import friction_torque  # a slider along x imports nothing of the plane

    if abs(block.torque) > (friction := friction_torque(driven.slider)):
        yield (
            f"slider.torque, {block.torque:.4g} N m, exceeds the torque of the friction that holds the slider, "
            f"{friction:.4g} N m: it turns the slider even without a wave, and nothing limits the rate: "
            "lower slider.torque"
        )


def _points(record: Record) -> Iterator[str]:
    """Yield warnings about a slider that turns between two points, that is too fast, or that always sticks."""
    omega, named = 2 * math.pi * record.wave.frequency_Hz, record.scene.named
    moving = [
        (point.level, velocity)
        for point in record.points
        if abs(velocity := point.velocity_m_per_s or 0.0) > CREEP * omega * point.tangential_amplitude_m
    ]
    for (low, before), (high, after) in pairwise(moving):
        if before * after < 0:
            yield (
                f"the slider reverses its direction between {named(low)} and {named(high)} ({before * 1e3:.3g} and "
                f"{after * 1e3:.3g} mm/s): give {record.scene.level_key} more values between them"
            )
    speeds = (math.hypot(each.velocity_m_per_s or 0.0, each.lateral_velocity_m_per_s or 0.0) for each in record.points)
    fastest = max(speeds, default=0.0)
    if fastest > USUAL_SPEED:
        yield (
            f"the slider runs at {fastest:.4g} m/s; surface-acoustic-wave motors reach 1 to 2 m/s: check the units of "
            f"{record.scene.level_key} and of slider.load"
        )
    if record.at_rest:  # the only answer is the threshold, whose error is that of the wave
        error, threshold = record.wave.relative_error, record.limit("threshold")
        starts = "" if threshold is None else f"; it starts at {named(threshold)}"
        accuracy = "" if error is None else f"; the relative error of the wave under the slider is {error:.1e}"
        yield f"the slider sticks at every point, so that neither a velocity nor its error is given{starts}{accuracy}"


def _ripple(record: Record) -> Iterator[str]:
    """Yield a warning if the velocity depends on where within half a wavelength the slider is."""
    summary, rippled = record.summary, []
    if (summary.velocity_ripple or 0.0) < RIPPLE:
        return
    for point in record.points:
        if point.mean_velocity_m_per_s is not None:
            mean, low, high = point.mean_velocity_m_per_s, point.lowest_velocity_m_per_s, point.highest_velocity_m_per_s
            if high > low and high - low >= RIPPLE * abs(mean):
                rippled.append((point.level, point.velocity_m_per_s, mean, low, high))
    level, *speeds = max(rippled)
    here, mean, low, high = (f"{1e3 * speed:.4g}" for speed in speeds)
    yield (
        f"the wave is partly a standing one, and the velocity depends on fractions of its length: {low} to {high} mm/s "
        f"within half a wavelength about the slider's position, {mean} mm/s in the mean over place, {here} mm/s at the "
        f"position ({record.scene.named(level)}): take the mean for a slider that travels, or reduce the reflection "
        "(standing-wave ratio "
        f"{record.wave.standing_wave_ratio:.3g}; split fingers reflect least)"
    )


def _end_of_way(record: Record) -> Iterator[str]:
    """Yield a warning if a burst carries the slider to fingers, a piece or the end of the stator."""
    scene = record.scene
    if scene.burst is None or scene.stator is None:
        return
    way = free_way(model_of(scene))
    ended = [point for point in record.points if point.way_ends_after_s is not None]
    ends = [(point.way_ends_after_s, point.level, point.displacement_m) for point in ended]
    if ends:
        after, level, displacement = min(ends, key=lambda each: each[:2])
        what = "a contact comes to fingers, a piece or an edge"
        if not scene.planar:
            what = way.at_high if displacement > 0 else way.at_low
        yield (
            f"the burst carries the slider to the end of its way at {len(ends)} of {len(record.points)} points, where "
            f"its motion stops: at {scene.named(level)} {what} {after:.4g} s after the start, and the velocity at the "
            f"burst's end is that of this instant: shorten {scene.source.block}.burst, or move slider.position"
        )
    along = () if scene.planar else record.points  # in the plane the waves are followed
    moved = [(p.level, p.displacement_m) for p in along if p.way_ends_after_s is None and p.displacement_m]
    beyond = [(level, x) for level, x in moved if not way.low <= x <= way.high]
    if beyond:
        level, displacement = max(beyond, key=lambda each: abs(each[1]))
        what = way.at_high if displacement > 0 else way.at_low
        yield (
            f"the burst carries the slider {1e3 * displacement:.4g} mm along x ({scene.named(level)}) on the wave at "
            f"its first position, although {what}: shorten {scene.source.block}.burst, or leave slider.travel out"
        )


def _other_motion(record: Record) -> Iterator[str]:
    """Yield a warning if some points have a second steady motion."""
    several = [point for point in record.points if point.other_velocity_m_per_s is not None]
    if not several:
        return
    point, damping = several[-1], record.scene.slider.damping
    here, other = (f"{each * 1e3:.4g}" for each in (point.velocity_m_per_s, point.other_velocity_m_per_s))
    level = record.scene.named(point.level)
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
