"""The averaged motor of a scene: its drives, tables and errors.

The tables of mean forces are those of `force_grid`; the step response of the surface comes from
`studies.solve.ring_up`.
"""

import logging
import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

import contact
from studies.export import reduced_motor as model
from studies.export.force_grid import force_tables, mean_forces, packed
from studies.export.law_contact import LawContact
from studies.export.law_grid import BEYOND, MOST_PRELOAD, LawGrid
from studies.export.motor_model import RESPONSE_STEP, AveragedMotor, Drive
from studies.model.scene_errors import as_run_errors
from studies.model.wave_to_contact import Contact
from studies.scene import Scene
from studies.solve.ring_up import RingUp, switched
from studies.solve.velocity_error import held_height_error
from studies.study_list import driven_contact

LOGGER = logging.getLogger(__name__)

PROBES = 400  # random points at which the interpolation is compared with the exact mean
WAVE_PROBES, SPEED_PROBES = 100, 8  # of tables without a grid of the law: waves, whose means one call has at all speeds
KICK_CYCLES = 10  # after which the start of a sudden wave is over
TWO_MOTIONS = 200  # levels at which contacts that attract are asked for a second motion
SETTLED = 2e-4  # of the steady amplitude: from there on the wave counts as settled
MAX_RESPONSE = 20_000  # nodes; what rings longer is taken as settled there


def first_drive(scene: Scene, *, tolerance: float = 1e-3) -> Contact:
    """Return the contact with the scene's own drive, from which `averaged_motor` goes on.

    Raises
    ------
    SceneError, RunError
        If the scene has no slider, or the averaged motor does not take it.
    """
    rule = "must be absent: tables over two ratios do not hold heights that scatter or a wave that the slider loads"
    scene.refuse_pillars(rule)
    refuse_special_contacts(scene)
    driven = driven_contact(scene, tolerance=tolerance)
    if not driven.heavy:
        refuse_special_friction(driven)
    return driven


def refuse_special_contacts(scene: Scene) -> None:
    """Raise a SceneError for contacts of which the tables' two ratios do not hold."""
    taken = {"heights": "contacts of one height", "normal_law": "smooth contacts"}
    if scene.planar:
        taken |= {
            "roughness": "smooth balls, whose force is a power of the approach",
            "adhesion": "contacts without adhesion",
        }
    for key, what in taken.items():
        if scene.slider is not None and getattr(scene.slider, key):
            scene.refuse(f"slider.{key}", f"must be absent: the tables of the averaged motor take {what}")


def refuse_special_friction(driven: Contact) -> None:
    """Raise a SceneError for a friction that depends on more than the normal force."""
    if driven.slider.friction is not None:
        rule = "must be a number without a law of one's own: the tables of the averaged motor take one coefficient"
        driven.scene.refuse("slider.friction_coefficient", rule)


def averaged_motor(
    scene: str | Scene, *, tolerance: float = 1e-3, first: Contact | None = None,
) -> AveragedMotor:  # fmt: skip
    """Return the averaged motor of a scene with a slider, its stator solved with each of its drives.

    Parameters
    ----------
    scene
        A path, a shipped name or a scene.  The second drive is the only other transducer, if the scene has two and
        drives one of them; of a prescribed wave it is the same wave running in the other direction.
    tolerance : float
        Relative, of the slider velocity; the stator is solved to it.
    first : Contact, optional
        The `first_drive` of the scene, if it has been computed.

    Raises
    ------
    SceneError, RunError
        If the scene has no slider, its contacts differ in height, or averaging does not apply to it.
    """
    scene = Scene.load(scene)
    driven = first or first_drive(scene, tolerance=tolerance)
    law = LawContact.of(driven)
    slider, share = (driven.slider, driven.scene.slider.share) if law is None else (law.slider, law.share)
    left_out = ["the wave is that at the initial position of the slider: its variation along the way is not included"]
    if driven.scene.wave is None:
        left_out.append("the stator's mean temperature is stated, and does not act on the motion")
    drives = [_drive(driven, left_out)]
    for other in other_drives(scene):
        drives.append(_drive(driven_contact(other, tolerance=tolerance), left_out))
    if law is not None:
        drives = [replace(each, orbits=each.orbits * law.each) for each in drives]
    if driven.scene.wave is not None:
        opposite = tuple(orbit.mirrored() for orbit in drives[0].orbits)
        drives.append(replace(drives[0], name="wave from the other side", orbits=opposite, mirrored=True))
    if len(drives) == 2:
        left_out.append("where the waves of both drives overlap, only the larger one counts")
    left_out += ["below the threshold, sticking contacts have the stiffness of a surface at rest, also with a wave"]
    grid = None
    with as_run_errors():
        if law is None:
            steady = _steady(slider, drives[0], driven.levels)  # first: it refuses what averaging does not know
            LOGGER.info("tables of mean forces")
            tables: list = [None if drive.mirrored else force_tables(slider, drive) for drive in drives]
        else:
            LOGGER.info("tables of mean forces")
            steady = _law_steady(law, drives[0], between(driven.levels))
            largest = max(driven.levels) * max(drive.amplitude for drive in drives)
            grid = law.grid(len(drives[0].orbits), largest)
            tables = [None if drive.mirrored else grid.tables(slider, drive) for drive in drives]
    averaging = max((abs(second - first) / scale for _, second, first, scale in steady), default=0.0)
    parameters, flat = packed(slider, drives, tables, grid)
    motor = AveragedMotor(
        scene=driven.scene, slider=slider, share=share, drives=tuple(drives), levels=driven.levels,
        parameters=parameters, tables=flat, interpolation_error=(0.0, 0.0), averaging_error=averaging,
        velocity_error=0.0, left_out=(), law=law,
    )  # fmt: skip
    ring = f"a slider that has stopped rings in its contacts at up to {motor.ring_speed:.2g} m/s"
    left_out.append(
        f"{ring}; the phase of the ring is lost within about 10 ms, so that the velocity at the start of a later burst "
        "may be wrong by up to twice that"
    )
    if grid is not None:
        reach, most = driven.scene.named(BEYOND * max(driven.levels)), MOST_PRELOAD * motor.preload
        left_out.append(f"the tables reach up to a level of {reach} and a preload of {most:.4g} N")
    left_out += _two_motions(motor)
    if drives[0].response is None and grid is not None:
        left_out.append("how the sudden start of a wave depends on its phase")
    elif drives[0].response is None:
        kick = _kick(motor, [level for level, *_ in steady])
        left_out.append(
            f"the sudden start of a wave changes the velocity by up to {kick:.1e} m/s, depending on its phase: "
            "not included"
        )
    return replace(
        motor,
        left_out=tuple(dict.fromkeys(left_out)),
        interpolation_error=_interpolation_error(motor) if grid is None else _law_interpolation_error(motor, grid),
        velocity_error=_velocity_error(motor, steady),
    )


def other_drives(scene: Scene) -> list[Scene]:
    """Return the scene with its other transducer driven, where there is just one other."""
    if scene.wave is not None or scene.crossed or scene.drive.sources is not None or len(scene.transducer) != 2:
        return []
    name = scene.drive.transducer or scene.driven_transducer.name
    (other,) = (each for each in scene.transducer if each.name != name)
    return [replace(scene, drive=replace(scene.drive, transducer=other.name))] if other.has_two_electrodes else []


def _drive(driven: Contact, left_out: list) -> Drive:
    if driven.scene.wave is not None:
        return Drive(name="wave", orbits=driven.orbits)
    record, (ringing, reason) = driven.record, switched(driven)
    if reason:
        left_out.append(f"the wave follows its drive at once, because {reason}")
    response, settling = (None, 0.0) if ringing is None else _step_response(ringing)
    warmth, thermal_time = _warmth(record)
    return Drive(
        name=driven.scene.driven_transducer.name, orbits=driven.orbits, response=response, settling=settling,
        power=float(record.electrical.power_W_per_V2), warmth=warmth, thermal_time=thermal_time,
        error=float(driven.stator_error),
    )  # fmt: skip


def _warmth(record) -> tuple[float, float]:
    """Return the steady mean rise in K per squared volt of a continuous drive, and its time constant in s, or zeros."""
    heat = record.heat
    if heat.mean_rise_K is None or heat.time_constant_s is None:
        return 0.0, 0.0
    return heat.mean_rise_K / (heat.duty or 1.0) / heat.voltage_V**2, heat.time_constant_s


def _step_response(ringing: RingUp) -> tuple[np.ndarray, float]:
    """Return the surface's amplitude over the steady one every `RESPONSE_STEP`, and the time in s to within 1 %."""
    settling = float(ringing.response.settling)
    longest = min(MAX_RESPONSE * RESPONSE_STEP, 20.0 * settling)
    envelope = ringing.lasting(2.0 * longest).envelope
    at = np.arange(0.0, longest, RESPONSE_STEP)
    factor = envelope.at(at)
    away = np.flatnonzero(abs(factor - 1.0) > SETTLED)
    nodes = min(int(away[-1]) + 3 if away.size else 2, len(at))
    factor = factor[: max(nodes, 2)]
    factor[-1] = 1.0
    return factor, settling


def _steady(slider, drive: Drive, levels) -> list[tuple[float, float, float, float]]:
    """Return (level, velocity of second order, of first order, max(|v|, omega |u_x|/10)) of each level that moves."""
    steady = []
    for level in levels:
        orbits = tuple(orbit.scaled(level) for orbit in drive.orbits)
        try:
            mean = contact.mean_motion(slider, orbits)
        except contact.ConvergenceError as error:
            if error.status != "near the threshold":
                raise
            continue  # at rest, or too slow to test the tables with
        scale = contact.reference_speed(float(mean.velocity), orbits)
        if not mean.held:
            steady.append((level, float(mean.velocity), float(mean.first_order), scale))
    return steady


def between(levels: tuple[float, ...]) -> list[float]:
    """Return the levels and the geometric means of neighbours, off the levels that a user has."""
    return sorted({*levels, *(math.sqrt(low * high) for low, high in pairwise(levels))})


def _law_steady(law: LawContact, drive: Drive, levels) -> list[tuple[float, float, float, float]]:
    """Return what `_steady` does of balls whose tables have depths: the second velocity has the error of averaging."""
    steady = []
    for level in levels:
        orbits = tuple(orbit.scaled(level) for orbit in drive.orbits)
        velocity = law.velocity(orbits)
        if velocity != 0.0:
            scale = contact.reference_speed(velocity, orbits)
            steady.append((level, velocity + scale * held_height_error(law.slider, orbits), velocity, scale))
    return steady


def _two_motions(motor: AveragedMotor) -> list[str]:
    """Return in words between which levels contacts that attract have two motions; empty if there are none."""
    p, tables, preload = motor.parameters, motor.tables, motor.slider.preload
    largest = motor.levels[-1]
    double = []
    for level in largest * np.linspace(0.0, 1.0, TWO_MOTIONS + 1)[1:]:
        size = level * motor.drives[0].amplitude
        closed, hops = (model.steady_approach(p, tables, 0, size, preload, k) for k in (0, 1))
        if closed - hops > 1e-6 * size:
            double.append(level)
    if not double:
        return []
    span = " to ".join(motor.scene.named(each) for each in (double[0], double[-1]))
    return [
        f"at {span} two motions exist, with contacts that stay closed, as in a run, and with contacts that open: "
        "which of them is reached depends on how the wave grows"
    ]


def _kick(motor: AveragedMotor, levels) -> float:
    """Return how far the motor is from the exact contact after the first cycles of a sudden wave, m/s."""
    worst = 0.0
    for level in {*levels[:1], *levels[-1:]}:
        orbits = motor.orbits_at(level)
        duration = KICK_CYCLES / orbits[0].frequency
        truth = contact.burst(
            motor.slider, orbits, duration=duration, after=0.0, tolerance=1e-6, samples=2, method="exact"
        )
        state = motor.start(force=motor.load)
        state.advance(duration, level, force=motor.load)
        worst = max(worst, abs(truth.velocity_at_burst_end - state.velocity))
    return worst


def _velocity_error(motor: AveragedMotor, steady) -> float:
    """Return the largest relative change of the first-order velocities of `_steady` by interpolation in the tables."""
    p, worst = motor.parameters, 0.0
    for level, _, first, scale in steady:
        size = level * motor.drives[0].amplitude
        height = model.steady_approach(p, motor.tables, 0, size, motor.slider.preload, 0)
        load_on = model.mean_load(p, motor.tables, 0, height, size)
        nearby = first + 1e-4 * scale * np.array([-1.0, 0.0, 1.0])
        low, here, high = (
            model.slip_force(p, motor.tables, 0, height, size, load_on, v) - motor.slider.tangential_damping * v
            for v in nearby
        )
        load = -float(np.copysign(motor.slider.load, first)) if motor.slider.load else 0.0
        worst = max(worst, abs((here + load) / (high - low)) * 2e-4)
    return worst


def _law_interpolation_error(motor: AveragedMotor, grid: LawGrid) -> tuple[float, float]:
    """Return the largest error of the mean tangential force over mu preload, and its 99 % quantile.

    At random waves and preloads within the reach of the tables, at the approaches at which a slider rides there.
    """
    random, errors, p = np.random.default_rng(1), [], motor.parameters
    largest = max(motor.levels) * max(drive.amplitude for drive in motor.drives)
    friction = motor.slider.friction_coefficient * motor.slider.preload
    for number, drive in enumerate(motor.drives):
        if drive.mirrored:
            continue
        for _ in range(PROBES):
            size, root = random.uniform(0.02, BEYOND) * largest, random.uniform(0.0, 1.0)
            preload = motor.slider.preload * MOST_PRELOAD ** random.uniform(-1.0, 1.0)
            height = model.steady_approach(p, motor.tables, number, size, preload, 0)
            found = grid.at(motor.slider, drive, height, size, np.array([root]))
            if found is None:
                continue
            load, speed = (
                model.mean_load(p, motor.tables, number, height, size),
                root**2 * drive.saturation(motor.slider),
            )
            for side, sign in ((0, -1.0), (1, 1.0)):
                q = model.friction_force(p, motor.tables, number, height, size, load, side, sign * speed * size)
                exact = motor.slider.friction_coefficient * found[0] * found[2][side, 0]
                errors.append(abs(q - exact) / friction)
    return float(max(errors)), float(np.quantile(errors, 0.99))


def _interpolation_error(motor: AveragedMotor) -> tuple[float, float]:
    """Return the largest error of g at random points between the nodes, and its 99 % quantile."""
    random, errors = np.random.default_rng(1), []
    for number, drive in enumerate(motor.drives):
        if drive.mirrored:  # has the table of the first
            continue
        for _ in range(WAVE_PROBES):
            tau, sizes = random.uniform(0.05, 0.9), random.uniform(0.0, 1.0, SPEED_PROBES)
            _, exact = mean_forces(motor.slider, drive, tau, sizes)
            for (side, k), force in np.ndenumerate(exact):
                interpolated = model.traction_share(motor.parameters, motor.tables, number, tau, side, sizes[k])
                errors.append(abs(interpolated - force))
    return float(max(errors)), float(np.quantile(errors, 0.99))
