"""The averaged motor of a scene whose slider moves in the plane, or turns: its tables, and what they leave out.

The tables are those of the waves at the slider's first place, of a rotor the mean over a turn. How much the steady
motion differs from there within a wavelength, or over the turn, is measured and stated, and refused above
`MAX_VARIATION`: of sources of one frequency, a fraction of a wavelength decides the direction.
"""

import logging
from dataclasses import replace
from typing import Any

import numpy as np

import contact
from contact import plane
from studies.export.averaged_motor import refuse_special_contacts, refuse_special_friction
from studies.export.planar_motor import PlanarMotor
from studies.export.planar_tables import BEYOND, Body, Forces, Grid, packed, tables_of
from studies.export.reduced_plane import plane_index as index
from studies.export.reduced_plane.plane_force_tables import element_force, set_wave
from studies.model.plane import StatorSurface
from studies.model.scene_errors import as_run_errors, slider_keys
from studies.model.wave_to_contact import Contact
from studies.scene import Scene
from studies.solve.plane_motor import PlaneMotor, contact_speed
from studies.solve.plane_ripple import differs, states_nearby
from studies.solve.ring_up import ring_up
from studies.study_list import driven_contact

LOGGER = logging.getLogger(__name__)

TOLERANCE = 1e-2  # of the steady states that the tables are compared with, at least: averaged ones
PROBES = 100  # random points at which the tables are compared with the exact means
CREEP = 1e-5  # of the largest speed of the surface at the scene's levels
MAX_STEP, FAST_STEP, RISE_STEPS = 1e-4, 1e-5, 5.0  # s, s, steps in the rise's time constant
MAX_VARIATION = 0.3  # of the steady motion over the places near the first one, over its speed
DECAYS = 3.0  # time constants of the bounce after a start that the tables leave out
MAX_CYCLES = 6000  # of the fastest wave times contacts, through which a start is followed event by event


def planar_motor(scene: str | Scene, *, tolerance: float = 1e-3, nodes: tuple | None = None) -> PlanarMotor:
    """Return the averaged motor of a scene whose slider moves in the plane, or turns about an axle.

    Parameters
    ----------
    scene
        A path, a shipped name or a scene, with sources of one or two frequencies.
    tolerance : float
        Relative, of the slider velocity; the stator is solved to it.
    nodes : tuple, optional
        Number of nodes of tau, phi, speed and angle; by default those of `planar_tables`.

    Raises
    ------
    SceneError, RunError
        If the tables do not hold what the scene asks for, or the motion depends on the place.
    """
    scene = Scene.load(scene)
    refuse_special_contacts(scene)
    driven = driven_contact(scene, tolerance=tolerance, planar=True)
    refuse_special_friction(driven)
    surfaces, levels = _surfaces_of_frequencies(driven), driven.levels
    if len(surfaces) > 2:
        key = "wave.sources" if driven.scene.wave is not None else "drive.source_frequencies"
        rule = (
            f"must hold at most two frequencies here: tables of mean forces over more are too long, got {len(surfaces)}"
        )
        driven.scene.refuse(key, rule)
    if not levels:
        driven.scene.refuse(driven.scene.level_key, "must hold a value above 0: the tables reach as far as the levels")
    with slider_keys(), as_run_errors():
        variation = _variation(driven, levels[-1], tolerance)
        body = Body(
            slider=replace(driven.slider, load=(0.0, 0.0), torque=0.0),
            share=driven.scene.slider.share,
            surfaces=tuple(surfaces.values()),
        )
        forces = Forces(body)
        size = BEYOND * levels[-1] * sum(forces.amplitudes)
        grid = Grid.of(forces, forces.tau(size), nodes)
        LOGGER.info("tables of mean forces")
        tables = tables_of(forces, grid)
        rise = _rise(driven)
        speed = PlaneMotor.of(driven, levels[-1], tolerance).waves.peak_speed
        fast = max(min(FAST_STEP, rise / RISE_STEPS), 1e-7) if rise > 0.0 else FAST_STEP
        p, flat = packed(body, forces, grid, tables, creep=CREEP * speed, steps=(MAX_STEP, fast), rise=rise)
        motor = PlanarMotor(
            scene=driven.scene, body=body, drives=tuple(surfaces), parameters=p, tables=flat,
            load=_load(driven, levels[-1], tolerance), limits=tuple(size / each for each in forces.amplitudes),
        )  # fmt: skip
        LOGGER.info("errors of the tables")
        velocity, averaging = _steady_errors(driven, motor, tolerance)
        return replace(
            motor, interpolation_error=_interpolation_error(motor, forces), velocity_error=velocity,
            averaging_error=averaging, left_out=tuple(_left_out(driven, motor, variation, rise)),
        )  # fmt: skip


def _surfaces_of_frequencies(driven: Contact) -> dict[str, Any]:
    """Return the surface motion of each frequency alone for a level of 1, by the names of its sources.

    Sources of one frequency keep the ratio and the phase that the scene gives them.
    """
    scene, surface = driven.scene, driven.surface
    if scene.wave is not None:
        groups: dict[float, list[int]] = {}
        for number, each in enumerate(surface.waves):
            groups.setdefault(each.frequency, []).append(number)
        return {
            " and ".join(f"wave {k + 1}" for k in numbers): replace(
                surface, waves=tuple(surface.waves[k] for k in numbers)
            )
            for numbers in groups.values()
        }
    own, first = dict(scene.drive.source_frequencies or ()), scene.frequency
    names = [name for name, size in scene.drive.driven.items() if size]
    return {
        " and ".join(name for name in names if own.get(name, first) == frequency): replace(
            surface, frequencies=(frequency,), motions=(motion,)
        )
        for frequency, motion in zip(surface.frequencies, surface.motions, strict=True)
    }


def _load(driven: Contact, level: float, tolerance: float) -> tuple[float, float, float]:
    """Return the scene's load as it acts on the slider: a load that is a number is that at a level."""
    slider, share = PlaneMotor.of(driven, level, max(tolerance, TOLERANCE)).slider, driven.scene.slider.share
    x, y = (-float(each) * share + 0.0 for each in slider.load)
    return x, y, -float(slider.torque) + 0.0


def _variation(driven: Contact, level: float, tolerance: float) -> float:
    """Return how far steady motions near the first place, or over a turn, are from it or their mean, relative.

    Raises
    ------
    SceneError
        Where it exceeds `MAX_VARIATION`.
    """
    if not differs(driven):
        return 0.0
    motor = PlaneMotor.of(driven, level, max(tolerance, TOLERANCE))
    states = states_nearby(driven, motor)
    rates = np.array([[*each.velocity, each.yaw_rate] for each in states])
    here = rates.mean(axis=0) if motor.slider.freedom == "axle" else rates[0]  # the first one is that of the place
    apart = max(contact_speed(motor.slider, each[:2] - here[:2], each[2] - here[2]) for each in rates)
    reference = contact.speed_scale(contact_speed(motor.slider, here[:2], here[2]), motor.waves.peak_speed)
    if apart > MAX_VARIATION * reference:
        key = "wave.sources" if driven.scene.wave is not None else "drive.source_frequencies"
        where = "over a turn" if motor.slider.freedom == "axle" else "within a wavelength"
        rule = (
            f"must make a motion that depends less on the place: {where} it differs by {apart / reference:.0%}, at "
            f"most {MAX_VARIATION:.0%} for tables of mean forces; sources of different frequencies do not interfere"
        )
        driven.scene.refuse(key, rule)
    return apart / reference


def _rise(driven: Contact) -> float:
    """Return the time constant with which the waves follow their drives, s; 0 at once."""
    if not isinstance(driven.surface, StatorSurface):
        return 0.0
    from studies.solve.plane_burst import Rise

    drive, center, rings = driven.scene.drive, driven.scene.slider.center, []
    if driven.record.surface_motion.covered(center):
        return 0.0
    for frequency in drive.frequencies:
        each = driven.model.alone_with(drive.at_frequency(frequency))
        rings.append(ring_up(each.with_blocks(drive=replace(each.scene.drive, burst=1.0 / frequency)), center))
    if any(each.response is None for each in rings):
        return 0.0
    duration = 20.0 * max(float(each.response.settling) for each in rings)
    return Rise(rings=tuple(each.lasting(duration) for each in rings), duration=duration).time


def _interpolation_error(motor: PlanarMotor, forces: Forces) -> tuple[float, float]:
    """Return the largest error of g at random points above the creep, and its 95 % quantile."""
    random, errors, p = np.random.default_rng(1), [], motor.parameters
    state, count = np.zeros(index.STATE_SIZE), len(motor.body.places)
    for _ in range(PROBES):
        tau, phi = random.uniform(0.05, 1.0) * p[index.MAX_TAU], random.uniform() * (len(motor.drives) - 1)
        u, angle = random.uniform(0.0, 0.98), random.uniform(0.0, 2.0 * np.pi)
        angle = angle if motor.freedom != "axle" else np.pi * (angle > np.pi)
        s = forces.size(tau)
        speed = max(u**2 / (1.0 - u**2) * forces.speed * s, 2.0 * p[index.CREEP])
        exact, _ = forces.at(tau, phi, np.array([speed / (forces.speed * s)]), np.array([angle]))
        set_wave(p, state, (1.0 - phi) * s, phi * s, motor.preload)
        for element in range(count):
            element_force(p, motor.tables, state, element, speed * np.cos(angle), speed * np.sin(angle), s)
            errors.append(float(np.hypot(*(state[index.FOUND : index.FOUND + 2] - exact[0, element]))))
    return max(errors), float(np.quantile(errors, 0.95))


def _steady_errors(driven: Contact, motor: PlanarMotor, tolerance: float) -> tuple[float, float]:
    """Return the largest difference of the steady motions from averaged ones, and the error of averaging, relative.

    Of a rotor from their mean over a turn.
    """
    worst, averaging = 0.0, 0.0
    for level in driven.levels:
        there = PlaneMotor.of(driven, level, max(tolerance, TOLERANCE))
        try:
            states = states_nearby(driven, there) if motor.freedom == "axle" else [there.state()]
        except contact.ConvergenceError as error:
            if error.status != "near the threshold":
                raise
            continue  # at rest, or too slow to test the tables with
        exact = np.mean([[*each.velocity, each.yaw_rate] for each in states], axis=0)
        rates = replace(motor, load=_load(driven, level, tolerance)).steady(*[level] * len(motor.drives))
        speed = contact_speed(there.slider, exact[:2], exact[2])
        reference = contact.speed_scale(speed, there.waves.peak_speed)
        worst = max(worst, contact_speed(there.slider, rates[:2] - exact[:2], rates[2] - exact[2]) / reference)
        averaging = max(averaging, *(each.relative_error for each in states))
    return worst, averaging


def _start_error(driven: Contact, motor: PlanarMotor, rise: float) -> tuple[float, np.ndarray]:
    """Return a time in s in which the bounce of a start decays, and by how much the tables miss the rates after it."""
    level, slider = driven.levels[-1], motor.body.slider
    there = PlaneMotor.of(driven, level, TOLERANCE)
    damping = slider.normal_damping + slider.contact_damping * slider.preload
    cycle = 2.0 * np.pi / (there.waves.omega * slider.count)
    duration = min(DECAYS * 2.0 * slider.mass / damping if damping > 0.0 else 1.0, MAX_CYCLES * cycle)
    loaded = replace(slider, load=there.slider.load, torque=there.slider.torque)
    followed = plane.burst(
        loaded, there.waves, duration=duration, after=0.0, tolerance=1e-2, samples=1, method="exact", rise_time=rise
    )
    state = motor.start()
    state.advance(duration, *[level] * len(motor.drives), load=motor.load)
    return duration, np.abs(followed.rates[-1] - state.rates)


def _left_out(driven: Contact, motor: PlanarMotor, variation: float, rise: float):
    """Yield what the motor leaves out, with its size where that is known."""
    turns = motor.freedom == "axle"
    if variation > 0.0 and turns:
        yield f"the torque is the mean over a turn, over which the steady rotation differs by up to {variation:.1%}"
    elif variation > 0.0:
        yield (
            "the waves are those at the slider's first place; within a wavelength about it the steady motion differs "
            f"by up to {variation:.1%}"
        )
    else:
        yield "the waves are the same at every place"
    together = [name for name in motor.drives if " and " in name]
    if together:
        names = ", ".join(together)
        yield f"ratio and phase of sources of one frequency are those of the scene: {names} have one input"
    moved = _start_error(driven, motor, rise)
    what = f"{moved[1][2]:.1e} rad/s" if turns else f"{np.hypot(*moved[1][:2]):.1e} m/s"
    what += f" and {moved[1][2]:.1e} rad/s" if motor.freedom == "xy yaw" else ""
    yield (
        "the heights follow the waves at once: the bounce of a sudden start, which changes the rates after "
        f"{1e3 * moved[0]:.2g} ms by {what} at the largest level, is not included"
    )
    creep = motor.parameters[index.CREEP]
    yield f"below {creep:.1e} m/s friction grows with the speed: a slider that it holds creeps, and rings not"
    if rise > 0.0:
        yield f"the waves of all drives follow them as 1 - exp(-t/{rise:.3g} s)"
    if driven.scene.wave is None:
        yield "the stator's mean temperature is not computed, and does not act on the motion"
