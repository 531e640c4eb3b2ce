"""How a motor in a position loop moves to a target and back: time, overshoot, error at rest, bursts, energy.

Method: the motor of a scene (``twente-contact`` by default) is computed through every cycle of the wave
(`studies.motor.followed_motor`). A sensor with resolution, noise and delay and a controller with a period
(`--controller two_phase`, dead_zone_pi, burst_length or FILE.py:FUNCTION) move it from rest to `--target "10 um"` and
back, with two drives if the scene has two. The error of the positions follows from the same drive with half as many
steps per cycle. The same drive is also applied to the averaged motor, which `sawmotor export` writes for simulators.

After a stop, the slider rings in its contacts, and the next burst begins with the velocity of the ring at that instant.
The averaged motor loses the phase of the ring within about 10 ms: from then on its velocity can be wrong by up to twice
that of the ring (22 um/s for ``twente``), and its position by up to 44 nm per millisecond of sliding.

`--loop KEY=VALUE` sets the loop (resolution, noise, delay, period, force, force_at, preload, limit, hold, seed) and the
parameters of the controller. A second panel shows the steps of bursts of a few cycles: within one elastic deformation
of the contacts, the slider moves back when the wave has decayed. The scatter between steps follows from the tolerances
in [uncertain].

A slider in the plane makes steps along x and y by bursts of its sources instead; the part that goes across and the turn
are stated with their errors, and `--target` is the size of a step along each axis (`studies.motor.plane_positioning`).
Expected: rest within 2 nm of the target, and the steps of `contact.step`. Run time: about 20 s, plus twice the time of
the stator; in the plane two minutes.
"""

import logging
import math
from collections.abc import Iterator
from dataclasses import fields, replace
from typing import Any

import numpy as np

import contact
from fem.parameters import refuses
from studies.export.averaged_motor import averaged_motor, first_drive, other_drives
from studies.export.law_contact import LawContact
from studies.export.motor_model import AveragedMotor, push
from studies.model.resolve import build
from studies.model.wave_to_contact import Contact
from studies.motor.controllers import MotorNumbers, controller
from studies.motor.followed_motor import STEPS, FollowedMotor
from studies.motor.position_loop import Drives, Loop, Move, moved, replayed
from studies.motor.short_bursts import short_bursts, step_scatter, steps_in_words
from studies.record.plots import COLOURS, curve, finished, symmetric_logarithmic
from studies.record.quantities import quantity
from studies.refusal import SceneError, refuse_if
from studies.scene import Scene
from studies.scene.numbers import Quantity
from studies.scene.override import parts_of, toml_value
from studies.solve.stroke_speed import slider_range
from studies.study_list import Answered, Finding, Panel, driven_contact, judged, of_record, study

LOGGER = logging.getLogger(__name__)

QUICK = {"cycles": (8, 25, 100)}
CYCLES = (2, 4, 8, 12, 16, 25, 36, 50, 72, 100, 150, 200)
DEFAULT_TARGET = 1e-5  # m
PLANE_TOLERANCE = 1e-2  # of the steps in the plane, at least
MAX_REST_ERROR = 2e-9  # m, for the error at rest to be confirmed
MAX_POSITION_ERROR = 1e-10  # m, of the positions that are computed
LENGTH, TIME, GAIN = Quantity("m", zero=True), Quantity("s", zero=True), Quantity(negative=True)
RULES = {  # of the loop's and the controllers' numbers; others are zero or positive, without a unit
    "resolution": LENGTH, "noise": LENGTH, "coarse": LENGTH, "tolerance": LENGTH, "single": LENGTH, "delay": TIME,
    "force_at": TIME, "hold": TIME, "settle": TIME, "period": Quantity("s"), "limit": Quantity("s"),
    "preload": Quantity("N"), "force": Quantity("N", negative=True), "proportional": GAIN, "integral": GAIN,
    "readings": Quantity(), "gain": Quantity(),
}  # fmt: skip


@study("twente-contact")
def run(
    scene: Scene, *, target: str | float | None = None, controller: str = "two_phase", loop: list[str] | None = None,
    cycles: tuple[int, ...] = CYCLES, tolerance: float = 1e-3,
) -> Answered:  # fmt: skip
    """Return the moves to a target and back, and the steps of short bursts.

    Parameters
    ----------
    target : str or float, optional
        Displacement of the target in m; by default 10 um in the direction of the first drive.
    controller : str
        A name of `studies.motor.controllers.CONTROLLERS`, or ``FILE.py:FUNCTION``.
    loop : list of str
        ``KEY=VALUE`` of the loop or of the controller.
    cycles : tuple of int
        Lengths of the bursts whose steps are shown.
    tolerance : float
        Of the slider velocity, for the stator.
    """
    settings, make_controller = read_loop(loop or [], controller)
    if scene.planar:
        for option, given in (("--loop", loop), ("--controller", controller != "two_phase")):
            if given:
                raise SceneError(option, "must be absent with a slider in the plane, whose steps are without a sensor")
        return _in_plane(scene, target, tolerance)
    distance = None if target is None else _read_target(target, scene)
    first = first_drive(scene, tolerance=tolerance)
    if first.heavy:
        first.slider  # noqa: B018  refused here: samples with stops, and adhesion that is not followed in time
    one_way = scene.wave is None and not other_drives(scene)
    direction = math.copysign(1.0, _push(first))
    if distance is None:
        distance = DEFAULT_TARGET * direction
        refuse_beyond(scene, distance)
    elif one_way and distance * direction < 0.0:
        sign, there = ("negative", "-10 um") if distance > 0.0 else ("positive", "10 um")
        rule = f'must be {sign}, such as "{there}": one transducer drives the slider that way alone'
        raise SceneError("--target", f"{rule}, got {distance * 1e6:.4g} um")
    motor = averaged_motor(scene, tolerance=tolerance, first=first)
    numbers = motor_numbers(motor)
    reach = numbers.speed_per_level * (numbers.level - numbers.dead_zone) * settings.limit
    if target is not None and abs(distance) > reach:
        rule = f"must be within {reach * 1e3:.4g} mm, which the motor travels at full speed in the time limit"
        got = f"of {settings.limit:g} s (--loop limit=...), got {distance * 1e3:.4g} mm"
        raise SceneError("--target", f"{rule} {got}")
    LOGGER.info("positioning: the way there and back")
    state = FollowedMotor(motor, preload=settings.preload)
    drives = Drives(
        powers=(motor.drives[0].power, 0.0 if one_way else motor.drives[1].power), direction=direction, one_way=one_way,
        frequency=motor.drives[0].orbits[0].frequency,
    )  # fmt: skip
    moves = {"there": moved(state, distance, make_controller(), numbers, settings, drives)}
    if not one_way:
        next_seed = replace(settings, seed=settings.seed + 1)
        moves["back"] = moved(state, 0.0, make_controller(), numbers, next_seed, drives)
    coarse = FollowedMotor(motor, preload=settings.preload, steps=STEPS // 2)
    error, _ = _difference(moves, coarse, settings)
    averaging = _difference(moves, motor.start(preload=settings.preload), settings)
    LOGGER.info("positioning: steps of short bursts")
    steps = short_bursts(first, motor, cycles)
    scatter = step_scatter(scene, motor)
    difference = steps.pop("difference")
    answer = [line for name, move in moves.items() for line in _move_in_words(name, move)]
    answer += _errors_in_words(motor, error, averaging)
    answer += steps_in_words(steps, difference, scatter)
    return _panels(motor, moves, steps), _findings(moves, error, difference), answer


def _in_plane(scene: Scene, target: str | float | None, tolerance: float) -> Answered:
    """Return the steps of a slider in the plane along its axes."""
    from studies.motor.plane_positioning import plane_positioning

    size = DEFAULT_TARGET if target is None else toml_value(target) if isinstance(target, str) else target
    distance = Quantity("m").read("--target", size)
    tolerance = max(tolerance, PLANE_TOLERANCE)
    driven = driven_contact(scene, tolerance=tolerance, planar=True)
    if driven.scene.slider.axis is not None:
        driven.scene.refuse("slider.axis", "must be absent: a slider on an axle has no steps along x and y")
    return plane_positioning(driven, distance, tolerance)


def _findings(moves: dict[str, Move], error: float, difference: float) -> list[Finding]:
    """Return the findings on rest at the target, the error of the positions and the difference of the steps, m."""
    return [
        *(judged(f"The slider comes to rest at the target ({name}).", "mean error at rest, m",
                 abs(move.error_at_rest), high=MAX_REST_ERROR,
                 holds=None if not move.settled and abs(move.error_at_rest) < MAX_REST_ERROR else True,
                 remark="" if move.settled else "the controller did not settle within the time limit")
          for name, move in moves.items()),
        judged("The positions agree with a computation with half as many steps per cycle.",
               "largest difference, m", error, high=MAX_POSITION_ERROR),
        judged("The averaged motor makes the same steps as the exact contact.",
               "largest difference of a step, m", difference, holds=None,
               expected="0.3 nm for a wave that fades, up to two elastic deformations for one that stops at once"),
    ]  # fmt: skip


def _difference(moves: dict[str, Move], other, loop: Loop) -> tuple[float, float]:
    """Return the largest and the last distance in m of another motor under the same drive from the moves."""
    positions = replayed(other, tuple(moves.values()), loop)
    differences = [abs(move.position - each) for move, each in zip(moves.values(), positions, strict=True)]
    return float(max(np.max(each) for each in differences)), float(differences[-1][-1])


def read_loop(settings: list[str], name: str):
    """Return the `Loop` that texts KEY=VALUE describe, and a function that makes the controller with its settings.

    Raises
    ------
    SceneError
        If a key is neither the loop's nor the controller's, or a value is out of range.
    """
    loop_settings: dict = {}
    controller_settings: dict = {}
    loop_keys = {each.name for each in fields(Loop)}
    for text in settings:
        key, value = parts_of("--loop", text, "KEY=VALUE")
        number = RULES.get(key, Quantity(zero=True)).read(f"--loop {key}", toml_value(value))
        (loop_settings if key in loop_keys else controller_settings)[key] = int(number) if key == "seed" else number
    controller(name, controller_settings)  # check the settings before any computation
    return Loop(**loop_settings), lambda: controller(name, controller_settings)


def _read_target(target: str | float, scene: Scene) -> float:
    """Return the displacement of a target in m; a SceneError for one that the slider cannot be moved to."""
    displacement = toml_value(target) if isinstance(target, str) else target
    distance = Quantity("m", negative=True).read("--target", displacement)
    refuse_if(distance == 0.0, "--target", "must not be 0: that is the position of the slider")
    refuse_beyond(scene, distance)
    return distance


@refuses(SceneError)
def refuse_beyond(scene: Scene, distance: float) -> Iterator[Any]:
    """Raise a SceneError, with the allowed distances, if a ball at the target would leave the free surface."""
    if scene.stator is None or scene.slider is None:
        return
    model = build(scene)
    low, high = (end - model.scene.slider.center[0] for end in slider_range(model))
    if not low < distance < high:
        rule = f"must keep the slider on the free surface, {low * 1e3:.4g} to {high * 1e3:.4g} mm from its position"
        yield "--target", f"{rule}, got {distance * 1e3:.4g} mm"


def _push(first: Contact) -> float:
    """Return the mean force in N of the largest wave along +x on a slider at rest, or a number of its sign."""
    law = LawContact.of(first)
    if law is None:
        return push(first.slider, first.at(max(first.levels)))
    return law.velocity(tuple(first.at(max(first.levels))) * law.each)


def motor_numbers(motor: AveragedMotor) -> MotorNumbers:
    """Return the motor parameters of a controller."""
    slider, drive, level, law = motor.slider, motor.drives[0], motor.levels[-1], motor.law
    orbits = motor.orbits_at(level)
    force = motor.direction
    dead_zone_level = float(contact.threshold_factor(slider, drive.orbits)) if law is None else law.threshold
    if force == 0.0 or dead_zone_level >= level:
        threshold, got = (motor.scene.named(each) for each in (dead_zone_level, level))
        motor.scene.refuse(motor.scene.level_key, f"must reach above the threshold, {threshold}, got {got}")
    steady = abs(float(contact.mean_motion(slider, orbits).velocity) if law is None else law.velocity(orbits))
    return MotorNumbers(
        level=level, dead_zone=dead_zone_level, acceleration=abs(force) / slider.mass,
        braking=slider.friction_coefficient * slider.preload / slider.mass, delay=drive.settling,
        speed_per_level=steady / (level - dead_zone_level),
    )  # fmt: skip


def _panels(motor: AveragedMotor, moves: dict[str, Move], steps: dict) -> list[Panel]:
    """Return a panel of the successive moves over time, and a panel of the steps of short bursts."""
    data: dict = {}
    start_time = 0.0
    for name, move in moves.items():
        data |= {f"{name}_time_s": start_time + move.time, f"{name}_position_m": move.position,
                 f"{name}_level": move.level, f"{name}_target_m": move.target}  # fmt: skip
        start_time += move.time[-1]
    level = motor.scene.named(motor.levels[-1])
    return [
        Panel(name="positioning", title=f"{motor.title}: to the target and back", data=data),
        Panel(name="single_steps", title=f"{motor.title}: bursts of a few cycles at {level}", data=steps),
    ]


def _move_in_words(name: str, move: Move) -> Iterator[tuple[str, str]]:
    """Yield label and text of each line on a move: settling times, overshoot, error at rest, drive."""
    times = ", ".join(
        f"{band * 1e9:g} nm " + ("never" if math.isnan(time) else f"after {time * 1e3:.4g} ms")
        for band, time in move.within.items()
    )
    yield name, f"{move.start * 1e6:.6g} to {move.target * 1e6:.6g} um: within {times}"
    rest = f"error at rest {move.error_at_rest * 1e9:+.3g} nm, ring {move.ring * 1e9:.3g} nm"
    yield "", f"overshoot {move.overshoot * 1e9:.3g} nm, {rest}"
    counts = ", ".join(f"{number} {phase}" for phase, number in move.bursts.items()) or "none"
    energy = f", {move.energy * 1e3:.4g} mJ" if move.energy else ""
    yield "", f"drives: {counts}; {move.cycles:.0f} cycles{energy}"


def _errors_in_words(motor: AveragedMotor, error: float, averaging: tuple[float, float]) -> list[tuple[str, str]]:
    """Return label and text of each line on the error of the positions and on the averaged motor."""
    largest, last = averaging
    return [
        ("error", f"of the positions: at most {error * 1e9:.2g} nm (difference from half as many steps per cycle)"),
        ("averaging", f"the averaged motor under the same drive differs by at most {largest * 1e9:.2g} nm,"),
        (
            "",
            f"{last * 1e9:.2g} nm at the end: it loses the phase of a ring of up to {motor.ring_speed * 1e6:.2g} um/s",
        ),
    ]


@of_record
def figure(record: Panel, ax):
    """Draw the remaining distance to the target for both moves, or the steps of short bursts."""
    if record.name.endswith("_in_plane"):
        from studies.motor.plane_positioning import draw

        return draw(record, ax)
    data = record.data
    if record.name == "single_steps":
        across, up = quantity.drive_cycles, quantity.burst_step_m
        for key, style, colour, label, size in (
            ("exact_m", "-", "line", "stays, followed through every cycle", 3.0),
            ("averaged_m", "o", "slip", "stays, averaged motor", 4.0),
            ("farthest_m", "--", "stick", "farthest on the way", 3.0),
        ):
            curve(ax, data["cycles"], data[key] * up.scale, style, colour, label, size=size)
        elastic, label = data["elastic_m"] * up.scale, "elastic deformation of the contacts"
        ax.axhspan(-elastic, elastic, color=COLOURS["stick"], alpha=0.2, linewidth=0, label=label)
        symmetric_logarithmic(ax.yaxis, 1.0)
        return finished(ax, across.axis, up.axis, record.title, columns=2)
    across, up = quantity.time_s, quantity.target_offset_m
    for name, colour in (("there", "slip"), ("back", "stick")):
        if f"{name}_time_s" in data:
            target, position = data[f"{name}_target_m"], data[f"{name}_position_m"]
            offset, label = (position - target) * up.scale, f"{name}, to {target * 1e6:g} um"
            curve(ax, data[f"{name}_time_s"] * across.scale, offset, "-", colour, label)
    ax.axhspan(-2.0, 2.0, color=COLOURS["line"], alpha=0.15, linewidth=0, label="2 nm")
    symmetric_logarithmic(ax.yaxis, 2.0)
    return finished(ax, across.axis, up.axis, record.title, columns=3)
