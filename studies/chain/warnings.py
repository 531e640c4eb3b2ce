"""What a physicist would remark about a run that gave an answer: each with its number and what to do about it.

Every function takes the record of a run and yields sentences, none where nothing is wrong. They take 0.05 s:
closed forms of what the run has computed already. Those about the stator are in ``stator_warnings``.
"""

import math
from collections.abc import Iterator
from itertools import pairwise

from studies.chain import bridge
from studies.chain.points import contact_load
from studies.chain.stator_warnings import OF_THE_STATOR, catalogue_strength
from studies.record import Record
from studies.scene import Scene

SIDEWAYS = 0.1  # |u_y| over |u_x| from which it is said
CREEP = 0.01  # of the surface's own speed along x
MAX_USUAL_LENGTH = 1.0  # m of a stator: a longer one is probably a mistaken unit


def warnings_of(record: Record) -> tuple[str, ...]:
    """Return every warning about a run, in the order of the chain."""
    scene = record.scene
    found = list(scene_warnings(scene))
    if scene.transducer:
        for each in OF_THE_STATOR:
            found += each(record)
    if scene.slider is not None:
        for each in (_sideways, _pressure, _reversal, _other_motion, _all_stick):
            found += each(record)
    return tuple(found)


def scene_warnings(scene: Scene) -> Iterator[str]:
    """Yield warnings that need no computation: a length in the wrong unit, balls at one place or over fingers."""
    stator, slider = scene.stator, scene.slider
    if stator is not None and stator.length > MAX_USUAL_LENGTH:
        yield f"stator.length is {stator.length:g} m: a number without a unit is in m"
    if slider is None:
        return
    for each in scene.transducer:
        half = each.finger_pairs * each.period / 2 if isinstance(each.period, float) else 0.0
        if slider.position is None or each.turned:
            continue
        if abs(slider.center[0] - each.place[0]) < half:
            yield f"the slider lies over the fingers of transducer {each.name}: its balls would rub on the metal"
    if isinstance(slider.contacts, int) and slider.contacts > 1:
        yield (
            f"contacts = {slider.contacts} means {slider.contacts} balls at one place, moved by the same wave: "
            'give their offsets along x instead, such as contacts = ["-5 mm", "5 mm"]'
        )


def _sideways(record: Record) -> Iterator[str]:
    """Yield a warning where the surface moves a ball sideways, which the contact leaves out."""
    ratio = record.wave.get("largest_lateral_ratio", 0.0)
    if ratio > SIDEWAYS:
        crossed = record.scene.crossed
        remedy = "drive less across" if crossed else "keep the balls nearer to the middle of the beam"
        yield (
            f"the surface moves sideways under a ball, |u_y/u_x| = {ratio:.2g}, but the contact follows it along "
            f"x alone: {remedy}"
        )


def _pressure(record: Record) -> Iterator[str]:
    """Yield warnings where the Hertz pressure passes what ball or stator bear, at rest or on the highest crest."""
    from fem import strength

    scene = record.scene
    slider = bridge.contact_slider(scene.slider)
    if slider.preload == 0:
        return
    level = max(scene.levels)
    if record.surface_wave is not None:
        orbits = bridge.scaled(bridge.orbits_per_volt(record.surface_motion, scene.slider), level)
    else:
        orbits = bridge.scaled(bridge.given_orbits(scene.wave), level)
    highest = contact_load(slider, orbits, math.inf)["contact_pressure_Pa"]
    at_rest = slider.pressure(max(slider.rest_approaches(len(orbits))))
    kind = "Mean pressure under a punch," if slider.shape == "punch" else "Hertz pressure"
    what = "punches" if slider.shape == "punch" else "balls"
    known = ((f"the {what} bear", strength("steel")), ("the stator bears", catalogue_strength(scene)))
    for part, limits in known:
        if limits is None or highest <= limits.contact_pressure:
            continue
        resting = at_rest > limits.contact_pressure
        pressure, when = (at_rest, "at rest") if resting else (highest, "on the wave's crest")
        remedy = f"more or larger {what}, or less preload" + ("" if resting else " or drive")
        yield (
            f"{kind} {pressure / 1e9:.3g} GPa {when} exceeds what {part}, "
            f"{limits.contact_pressure / 1e9:.3g} GPa ({limits.pressure_source}): {remedy}"
        )


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
