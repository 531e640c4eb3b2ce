"""The averaged motor of a scene whose slider moves in the plane, or turns: its numbers, their errors, what is left out.

The waves are those at the slider's first place, the torque of a rotor is the mean over a turn. How much the steady
motion differs from there within a wavelength, or over the turn, is measured and stated, and refused above
`MAX_VARIATION`: of sources of one frequency, a fraction of a wavelength decides the direction.
"""

import logging
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

import contact
from contact import plane
from studies.export.averaged_motor import refuse_special_contacts, refuse_special_friction
from studies.export.planar_body import Body
from studies.export.planar_contacts import packed_contacts
from studies.export.planar_motor import PlanarMotor
from studies.export.planar_tables import BEYOND, Forces, Grid, packed, tables_of
from studies.export.reduced_plane import plane_index as index
from studies.export.reduced_plane.plane_cycle import force_on_waves
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

TOLERANCE = 1e-2  # of the steady states with which the motor is compared, at least: averaged ones
PROBES = 100  # random points at which a rotor's tables are compared with the exact means
WAVE_PROBES, VELOCITY_PROBES = 12, 8  # random levels and velocities at each, the same of contacts
# Levels of two drives over those of the scene at which the steady motion is compared, besides those themselves
MIXTURES = ((1.0, 0.0), (0.0, 1.0), (1.0, 0.35), (0.35, 1.0), (0.5, 0.5))
HALF = ((0.5,),)  # the same of one drive
# Forces over friction under which it is compared too, at these levels and at parts of them
LOADED, SMALL = (0.4, 0.85), 0.35
# Stated error of the steady motion over the largest at the compared ones. At 130 drawn levels and forces of three
# motors (unequal levels, 0.9 to 1.4 of the threshold, up to 0.9 of friction) the true one was up to 0.46 of that
MARGIN = 2.0
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
        Of a rotor: number of nodes of tau, phi, speed and angle; by default those of `planar_tables`.

    Raises
    ------
    SceneError, RunError
        If the tables do not hold what the scene asks for, or the motion depends on the place.
    """
    scene = Scene.load(scene)
    refuse_special_contacts(scene)
    if scene.slider is not None and scene.slider.method == "auto":
        # its motion is that of averaged forces: nothing of the exact one is needed
        scene = replace(scene, slider=replace(scene.slider, method="averaged"))
    driven = driven_contact(scene, tolerance=tolerance, planar=True)
    refuse_special_friction(driven)
    surfaces, levels = _surfaces_of_frequencies(driven), driven.levels
    if len(surfaces) > 2:
        key = "wave.sources" if driven.scene.wave is not None else "drive.source_frequencies"
        rule = f"must hold at most two frequencies here, one for each input of the motor, got {len(surfaces)}"
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
        rise = _rise(driven)
        fast = max(min(FAST_STEP, rise / RISE_STEPS), 1e-7) if rise > 0.0 else FAST_STEP
        speed = PlaneMotor.of(driven, levels[-1], tolerance).waves.peak_speed
        numbers = {"creep": CREEP * speed, "steps": (MAX_STEP, fast), "rise": rise}
        forces: Forces | None = None
        limits: tuple[float, ...] = ()
        if body.freedom == "axle":
            LOGGER.info("tables of mean forces")
            forces = Forces(body)
            size = BEYOND * levels[-1] * sum(forces.amplitudes)
            limits = tuple(size / each for each in forces.amplitudes)
            grid = Grid.of(forces, forces.tau(size), nodes)
            p, flat = packed(body, forces, grid, tables_of(forces, grid), **numbers)
        else:
            p, flat = packed_contacts(body, **numbers)
        motor = PlanarMotor(
            scene=driven.scene, body=body, drives=tuple(surfaces), parameters=p, tables=flat,
            load=_load(driven, levels[-1], tolerance), limits=limits,
        )  # fmt: skip
        LOGGER.info("errors of the mean forces and of the steady motion")
        velocity, averaging = _steady_errors(driven, motor, tolerance)
        error = _force_error(motor, levels[-1]) if forces is None else _table_error(motor, forces)
        return replace(
            motor, force_error=error, velocity_error=velocity, averaging_error=averaging,
            left_out=tuple(_left_out(driven, motor, variation, rise)),
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
    return acting_load(PlaneMotor.of(driven, level, max(tolerance, TOLERANCE)).slider, driven.scene.slider.share)


def acting_load(slider: contact.Slider, share: int) -> tuple[float, float, float]:
    """Return the load of one of so many equal parts of a slider as it acts on the slider: N, N, N m."""
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


def _force_error(motor: PlanarMotor, level: float) -> tuple[float, float]:
    """Return the largest error of g of contacts at random levels and velocities above the creep, and a quantile.

    The 95 % quantile.
    """
    random, errors, p, body = np.random.default_rng(1), [], motor.parameters, motor.body
    state, n, slider = np.zeros(motor.state_size), body.slider.count, body.slider
    for number in range(WAVE_PROBES):
        levels = level * random.uniform(0.02, BEYOND, len(motor.drives))
        if number % 4 == 0:
            levels[number % 8 // 4 :: 2][1:] = 0.0  # one wave alone
        waves = body.waves_at(levels)
        fastest = 2.0 * np.pi * waves.frequencies[:, None] * np.abs(waves.amplitudes[..., :2]).max(axis=1)
        reach = 1.2 * np.linalg.norm(fastest.max(axis=0)) * random.uniform(-1.0, 1.0, (VELOCITY_PROBES, n, 2))
        velocities = reach * random.uniform(size=(VELOCITY_PROBES, n, 1))
        exact = plane.contact_forces(slider, waves, velocities).forces / (slider.friction_coefficient * slider.preload)
        for k, element in np.ndindex(VELOCITY_PROBES, n):
            inputs = *(*map(float, levels), 0.0)[:2], *map(float, velocities[k, element]), motor.preload
            force_on_waves(p, motor.tables, state, element, *inputs)
            errors.append(float(np.hypot(*(state[index.FOUND : index.FOUND + 2] - exact[k, element]))))
    return max(errors), float(np.quantile(errors, 0.95))


def _table_error(motor: PlanarMotor, forces: Forces) -> tuple[float, float]:
    """Return the largest error of a rotor's g at random points above the creep, and its 95 % quantile."""
    random, errors, p = np.random.default_rng(1), [], motor.parameters
    state, count = np.zeros(motor.state_size), len(motor.body.places)
    for _ in range(PROBES):
        tau, phi = random.uniform(0.05, 1.0) * p[index.MAX_TAU], random.uniform() * (len(motor.drives) - 1)
        u, angle = random.uniform(0.0, 0.98), np.pi * (random.uniform(0.0, 2.0 * np.pi) > np.pi)
        s = forces.size(tau)
        speed = max(u**2 / (1.0 - u**2) * forces.speed * s, 2.0 * p[index.CREEP])
        exact, _ = forces.at(tau, phi, np.array([speed / (forces.speed * s)]), np.array([angle]))
        set_wave(p, state, (1.0 - phi) * s, phi * s, motor.preload)
        for element in range(count):
            element_force(p, motor.tables, state, element, speed * np.cos(angle), speed * np.sin(angle), s)
            errors.append(float(np.hypot(*(state[index.FOUND : index.FOUND + 2] - exact[0, element]))))
    return max(errors), float(np.quantile(errors, 0.95))


def _steady_errors(driven: Contact, motor: PlanarMotor, tolerance: float) -> tuple[float, float]:
    """Return the error of the steady motion, from differences to averaged ones, and that of averaging, relative.

    Of a rotor from their mean over a turn.
    """
    worst, averaging = 0.0, 0.0
    for level in driven.levels:
        there = PlaneMotor.of(driven, level, max(tolerance, TOLERANCE))
        for levels, slider in _compared(motor, there, level):
            try:
                states = _states(driven, motor, replace(there, slider=slider), levels)
            except contact.ConvergenceError as error:
                if error.status != "near the threshold":
                    raise
                continue  # at rest, or too slow to compare with
            exact = np.mean([[*each.velocity, each.yaw_rate] for each in states], axis=0)
            rates = replace(motor, load=acting_load(slider, motor.body.share)).steady(*levels)
            speed = contact_speed(slider, exact[:2], exact[2])
            reference = contact.speed_scale(speed, motor.body.waves_at(levels).peak_speed)
            worst = max(worst, contact_speed(slider, rates[:2] - exact[:2], rates[2] - exact[2]) / reference)
            averaging = max(averaging, *(each.relative_error for each in states))
    return MARGIN * worst, averaging


def _compared(motor: PlanarMotor, there: PlaneMotor, level: float):
    """Yield levels of the drives and a slider with its load, at which steady motions are compared.

    A rotor only at a level of the scene, under its load.
    """
    count = len(motor.drives)
    yield np.full(count, level), there.slider
    if motor.freedom == "axle":
        return
    for each in MIXTURES if count > 1 else HALF:
        yield level * np.array(each), there.slider
    for part, force, towards in product((1.0, SMALL), LOADED, ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))):
        size = force * there.slider.friction_coefficient * there.slider.preload
        load = size * towards[0], size * towards[1]
        yield np.full(count, part * level), replace(there.slider, load=load, torque=0.0)


def _states(driven: Contact, motor: PlanarMotor, there: PlaneMotor, levels: np.ndarray) -> list[plane.PlaneState]:
    """Return the steady state at levels of the drives, of a rotor those over a turn."""
    if motor.freedom == "axle":
        return states_nearby(driven, there)
    return [there.state(motor.body.waves_at(levels))]


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


def _start_in_words(driven: Contact, motor: PlanarMotor, rise: float) -> str:
    """Return what the motor leaves out of a start."""
    try:
        time, moved = _start_error(driven, motor, rise)
    except contact.ConvergenceError as error:
        return f"the bounce of a sudden start is not included, and its size is not known ({error})"
    what = f"{moved[2]:.1e} rad/s" if motor.freedom == "axle" else f"{np.hypot(*moved[:2]):.1e} m/s"
    what += f" and {moved[2]:.1e} rad/s" if motor.freedom == "xy yaw" else ""
    changes = f"which changes the rates after {1e3 * time:.2g} ms by {what} at the largest level"
    return f"the bounce of a sudden start, {changes}, is not included"


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
    yield f"the heights follow the waves at once: {_start_in_words(driven, motor, rise)}"
    creep = motor.parameters[index.CREEP]
    yield f"below {creep:.1e} m/s friction grows with the speed: a slider that it holds creeps, and rings not"
    if rise > 0.0:
        yield f"the waves of all drives follow them as 1 - exp(-t/{rise:.3g} s)"
    if driven.scene.wave is None:
        yield "the stator's mean temperature is not computed, and does not act on the motion"
