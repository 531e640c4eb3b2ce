"""The datasheet of a motor: the quantities that a motion engineer needs, with unit, condition and error.

All rows hold at the rated level and without a load, unless their condition says otherwise: the run behind them has
``slider.load`` = 0, and the load of the scene has a row of its own. On a stator the speed is the mean over the stroke;
every other row holds at the slider's position. The rated level is the largest voltage (or the
largest amplitude of a scene with a [wave]) that moves the slider. Errors are numerical: those
of stator and contact, propagated to each quantity. The inputs of the scene, such as the friction coefficient, are taken
as exact.
"""

import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import contact
from studies.model.resolve import resolved
from studies.model.wave_to_contact import Contact
from studies.progress import counted, reported_to
from studies.record import Record
from studies.record.blocks import HeatBlock
from studies.record.point import Point
from studies.record.prefixes import si
from studies.record.quantities import quantity
from studies.record.text import leaving, sentences
from studies.refusal import RunError
from studies.report.datasheet_rows import Row
from studies.runs import run
from studies.scene import Scene
from studies.solve.burst_steps import Steps
from studies.solve.predictor import Predictor
from studies.solve.ripple import Known
from studies.solve.slider_burst import QUASI_STATIC
from studies.solve.solved_stator import contact_of_run
from studies.solve.stroke_speed import StrokeSpeed, slider_range, stroke_speed

if TYPE_CHECKING:
    from contact.answers.burst_motion import Trajectory

LOGGER = logging.getLogger(__name__)
LOADS = 13  # number of loads of a load line
LINES = (0.5, 0.75, 1.0)  # fractions of the rated level; the nearest levels of the scene get a load line
STEPS = (1e-9, 1e-8, 1e-7)  # smallest displacements of the steps, m
FULL_WAVE = "wave at full size from the first cycle"
SETTLED = 0.9  # fraction of the steady velocity that ends the start
BURST_RATIO = 8.0  # burst duration over the time in which the full friction force would reach the steady velocity
CONTACT_TOLERANCE = 1e-4
# relative error of the frequency of the strongest wave, computed on a coarse mesh (fem/solve/best_frequency.py)
FREQUENCY_ERROR = 5e-4

GROUPS = {
    "speed": "Speed",
    "force": "Force",
    "positioning": "Positioning",
    "power": "Power and efficiency",
    "resonance": "Resonance",
}


@dataclass(frozen=True, kw_only=True, repr=False)
class Datasheet:
    """The datasheet of a motor and the computed motions behind it."""

    record: Record  # of the underlying run
    driven: Contact
    rated: float  # V of the source, or amplitude in m for a scene with a [wave]
    rows: tuple[Row, ...]
    lines: dict  # by level: contact.LoadLine of one computed ball
    balls: float  # number of balls that one computed ball represents
    # Start from rest at the rated level and the stop after it; None in the plane, whose rows state both
    start_stop: "Trajectory | Any" = None
    steps: tuple  # contact.Step of the shortest burst for each size in `STEPS`, None where there is none

    def __str__(self) -> str:
        """Return the datasheet as a table of text, as `sawmotor datasheet` prints it."""
        groups = {group: [row.texts() for row in self.rows if row.group == group] for group in GROUPS}
        name, value = (max(len(row[key]) for rows in groups.values() for row in rows) for key in ("name", "value"))
        lines = [f"{self.record.scene.title}: rated at {self.driven.scene.named(self.rated)} peak"]
        for group, rows in groups.items():
            lines += ["", GROUPS[group]]
            lines += [
                f"  {each['name']:<{name}}  {each['value']:>{value}}  {each['error']:<10}  {each['condition']}".rstrip()
                for each in rows
            ]
        if self.record.model_error:
            lines += ["", "Model error, apart from the errors above"]
            lines += [f"  {each}" for each in sentences(self.record)]
        return "\n".join(lines)

    def __repr__(self) -> str:
        """Return title, rated level and velocity on one line."""
        scene, speed = self.record.scene, self.rows[0]
        title, rated = scene.title or "untitled", scene.named(self.rated)
        return f"Datasheet({title!r}, {rated}, {speed.name} {si(speed.value, speed.unit, 4)})"

    def to_dict(self) -> dict:
        """Return the contents of datasheet.json: title, rated level, rows and model error."""
        level = self.record.level.removeprefix("normal_")
        rows = [{key: value for key, value in row._asdict().items() if value not in (None, "")} for row in self.rows]
        whole = {"title": self.record.scene.title, f"rated_{level}": self.rated, "rows": rows}
        return whole | (
            {"model_error": [each.to_dict() for each in self.record.model_error]} if self.record.model_error else {}
        )


def datasheet(
    scene: Scene | str | Path, *, tolerance: float = 1e-3, progress: Callable[[str], None] | None = None
) -> Datasheet:
    """Return the datasheet of a motor.

    Parameters
    ----------
    scene : Scene, path or name of a shipped scene
        A scene with a slider and either a driven stator or a [wave].
    tolerance : float
        Relative tolerance of the slider velocity, as for a run.
    progress : callable, optional
        Called with a few words about each step, as it is logged.

    Raises
    ------
    SceneError
        If the scene has no slider, or no level moves it.
    RunError
        If a quantity of the datasheet cannot be computed.
    """
    with reported_to(progress):
        scene = Scene.load(scene)
        if scene.slider is None:
            scene.refuse("slider", "is missing: a datasheet is of a whole motor")
        load = scene.slider.scalar_load
        record = run(_without_load(scene), tolerance=tolerance)
        if record.shortfall:
            raise RunError(record.shortfall)
        driven = contact_of_run(record)
        if scene.planar:
            moving = [point.level for point in record.points if point.regime != "stick"]
        else:
            moving = list(record.moving_levels if driven.passing else driven.above(1.0))
        if not moving:
            record.scene.refuse(record.scene.level_key, "must hold a value at which the slider moves")
        rated = moving[-1]
        if scene.planar:
            return _in_plane(record, driven, rated)
        levels = sorted({min(moving, key=lambda level: abs(level - part * rated)) for part in LINES})
        try:
            answer = _contact(driven, rated, levels)
        except contact.ConvergenceError as error:
            raise RunError(f"the datasheet is incomplete: {' '.join(str(error).split())}") from None
        line = answer["lines"][driven.scene.named(rated)]
        under_load, remarks = _under_load(record, rated, load)
        remarks += answer.pop("remarks", ())
        travel = None if record.scene.stator is None or driven.passing else _over_stroke(record, driven, rated)
        starts, remark = _start_distance(driven, rated, answer["start_stop"])
        remarks += remark
        rows = (
            *_speeds(record, driven, rated, under_load, travel),
            *answer.pop("rows"),
            *starts,
            *_powers(record, driven, rated, line, answer["balls"]),
            *answer.pop("powers", ()),
            *_resonances(record, driven),
        )
        record = replace(record, warnings=(*record.warnings, *remarks))
        return Datasheet(record=record, driven=driven, rated=rated, rows=rows, **answer)


def _in_plane(record: Record, driven: Contact, rated: float) -> Datasheet:
    """Return the datasheet of a slider in the plane."""
    from studies.report.plane_datasheet import plane_rows

    rows, remarks = plane_rows(record, driven, rated)
    rows += (Row("resonance", "drive frequency", float(record.scene.frequency), "Hz"), *_contact_resonances(driven))
    record = replace(record, warnings=(*record.warnings, *remarks))
    return Datasheet(record=record, driven=driven, rated=rated, rows=rows, lines={}, balls=1.0, steps=())


def _without_load(scene: Scene) -> Scene:
    """Return the scene whose run the datasheet describes: without a burst, and without a load and its tolerance."""
    scene = scene.with_source(burst=None)
    if scene.slider.planar:
        scene = replace(scene, slider=replace(scene.slider, torque=0.0, incline=None))
    if scene.slider.load == 0.0:
        return scene
    pairs = tuple(pair for pair in scene.uncertain or () if pair[0] != "slider.load")
    uncertain = pairs if any("." in key for key, _ in pairs) else None
    return replace(scene, slider=replace(scene.slider, load=0.0), uncertain=uncertain)


def _contact(driven: Contact, rated: float, levels: list[float]) -> dict:
    """Return load lines, start and stop, steps, and the rows on forces and positioning.

    A slider on a passing wave has no steps, because its bounce is not modelled.
    """
    options, named = {"points": LOADS, "tolerance": CONTACT_TOLERANCE}, driven.scene.named
    shown = counted(LOGGER, "load lines", levels)
    lines = {named(level): contact.load_line(driven.slider, driven.at(level), **options) for level in shown}
    LOGGER.info("start and stop")
    start_stop = _start_and_stop_motion(driven, rated)
    if driven.passing:
        return {"lines": lines, "start_stop": start_stop, "steps": (), "balls": 1.0} | _rows_on_passing_wave(
            driven, lines[named(rated)], start_stop
        )
    bursts = Steps.of(driven)
    steps, remarks = _steps(bursts, rated)
    balls = driven.scene.slider.share
    rows = (*_forces(driven, rated, lines[named(rated)], balls), *_positioning(bursts, rated, steps, start_stop))
    return {"lines": lines, "start_stop": start_stop, "steps": steps, "balls": balls, "rows": rows, "remarks": remarks}


def _steps(bursts: Steps, rated: float) -> tuple[tuple, tuple[str, ...]]:
    """Return the shortest step of each size in `STEPS`, None where there is none, and the remarks why."""
    steps: list = []
    remarks = []
    for size in counted(LOGGER, "steps", STEPS):
        try:
            steps.append(bursts.reaching(rated, size)[1])
        except contact.ConvergenceError as error:
            steps.append(None)
            remarks.append(f"the datasheet has no step of {si(size, 'm')}: {' '.join(str(error).split())}")
    return tuple(steps), tuple(remarks)


def _rows_on_passing_wave(driven: Contact, line, start_stop) -> dict:
    """Return the rows of a slider on a passing wave on forces, start and stop, and power."""
    slider = driven.moving_slider
    holding_force = slider.static_friction(driven.contacts)
    relative_error = 2.0 * driven.stator_error + CONTACT_TOLERANCE
    stall, held = (line.blocked_thrust, relative_error), (line.held_up_to, relative_error)
    rows = (*_force_rows(stall, held, holding_force, slider.mass), *_start_and_stop_rows(start_stop, ""))
    power = line.states[0].loaded.friction_power
    friction = Row("power", "friction power", power, "W", relative_error, "no load, all pillars")
    return {"rows": rows, "powers": (friction,)}


def _start_and_stop_motion(driven: Contact, rated: float) -> Any:
    """Return a burst from rest that reaches the steady velocity, and the stop after it."""
    slider, orbits = driven.moving_slider, driven.at(rated)
    acceleration = slider.least_friction(driven.contacts) / slider.mass
    steady = contact.steady(driven.slider, orbits, tolerance=CONTACT_TOLERANCE).velocity
    acceleration_time = abs(steady) / acceleration
    times = {"duration": BURST_RATIO * acceleration_time, "after": 2.0 * acceleration_time}
    method = QUASI_STATIC if driven.passing else "auto"
    return contact.burst(slider, orbits, **times, tolerance=1e-3, samples=4000, method=method)


def _over_stroke(record: Record, driven: Contact, rated: float) -> StrokeSpeed | None:
    """Return the velocity over the stroke at the rated level."""
    LOGGER.info("speed along the stroke")
    point = next(each for each in record.points if each.level == rated)
    known = Known(point.velocity_m_per_s, point.get("amplitude_sensitivity", 1.0))
    return stroke_speed(driven, record.surface_motion, rated, known, record.tolerance)


def _stroke_rows(point: Point, travel: StrokeSpeed, model: float | None) -> Iterator[Row]:
    """Yield the rows on the speed over the stroke, its range about the slider's position, and the stroke."""
    over, shown, place = travel.ripple, quantity.velocity_m_per_s, quantity.position_m
    condition = f"no load, steady; mean over place along the stroke ({shown.interval(over.lowest, over.highest)})"
    if over.mean_over_time is not None:
        condition += f"; {shown.with_unit(abs(over.mean_over_time))} in the mean over the time of a slow slider"
    if travel.missing:
        condition += f"; {travel.missing:.0%} of the places have no answer"
    yield Row("speed", "speed", abs(over.mean), "m/s", over.error / (abs(over.mean) or 1.0), condition, model)
    if point.mean_velocity_m_per_s:
        mean, low, high = point.mean_velocity_m_per_s, point.lowest_velocity_m_per_s, point.highest_velocity_m_per_s
        condition = f"within half a wavelength about the position: {shown.interval(low, high)}, mean {shown.text(mean)}"
        yield Row("speed", "ripple", (high - low) / abs(mean), "1", None, condition)
    low, high = travel.stroke
    condition = f"of the slider's centre, between fingers and ends: {place.interval(low, high)}"
    yield Row("speed", "stroke", high - low, "m", None, condition)


def _start_distance(driven: Contact, rated: float, motion: Any) -> tuple[tuple[Row, ...], tuple[str, ...]]:
    """Return the row on the distance of the start on a stator, and a remark if it does not fit in the stroke."""
    scene = driven.scene
    if scene.stator is None:
        return (), ()
    until, center = _start_time(motion), scene.slider.center[0]
    time = np.append(motion.time[motion.time < until], until)
    distance = float(np.trapezoid(np.interp(time, motion.time, motion.velocity), time))
    low, high = slider_range(driven.model)
    free = high - center if distance > 0.0 else center - low
    fits, room = abs(distance) <= free, f"{si(free, 'm', 3)} are free in this direction"
    condition = f"from rest to {SETTLED:.0%} of the speed; {room}: it {'fits' if fits else 'does not fit'}"
    row = Row("positioning", "start distance", abs(distance), "m", None, condition)
    remark = (
        f"a start from rest at {scene.named(rated)} takes {si(abs(distance), 'm', 3)}, and {room}, up to fingers or "
        "the stator's end: the slider does not reach its speed from slider.position"
    )
    return (row,), () if fits else (remark,)


def _speeds(
    record: Record, driven: Contact, rated: float, under_load: tuple[Row, ...], travel: StrokeSpeed | None
) -> Iterator[Row]:
    """Yield the rows on the velocity, without and with the load of the scene, the threshold and the release.

    ``travel``: over the stroke; None where the speed is that of the position.
    """
    point = next(each for each in record.points if each.level == rated)
    speed, error = abs(point.velocity_m_per_s), _velocity_error(record, point)
    scale, model = error / point.relative_error if error else 1.0, point.model_relative_error
    model = None if model is None else scale * model
    if travel is not None:
        yield from _stroke_rows(point, travel, model)
    elif point.mean_velocity_m_per_s is not None:  # pillars
        mean, low, high = point.mean_velocity_m_per_s, point.lowest_velocity_m_per_s, point.highest_velocity_m_per_s
        surface_speed = 2.0 * np.pi * float(record.scene.frequency) * point.tangential_amplitude_m
        mean_error = point.mean_velocity_relative_error * contact.speed_scale(mean, surface_speed) / abs(mean)
        within = f"within half a wavelength ({quantity.velocity_m_per_s.interval(low, high)})"
        yield Row("speed", "speed", abs(mean), "m/s", mean_error, f"no load, steady; mean over place {within}", model)
    rippled = travel is not None or point.mean_velocity_m_per_s is not None
    name, where = ("speed at the position", ", as all that follows") if rippled else ("speed", "")
    yield Row("speed", name, speed, "m/s", error, f"no load, steady{where}", model)
    yield from under_load
    unit = quantity(record.level).unit
    for name, event, factor_of in (
        ("threshold", "starts to move", contact.threshold),
        ("release", "leaves the surface in every cycle", contact.release),
    ):
        value, condition = record.limit(name), f"the slider {event}"
        if name == "release":
            condition = leaving(record.summary, event)
        if value is not None:
            factor = factor_of(driven.slider, driven.orbits)
            error = driven.stator_error + (factor.error / factor.value if factor.error else 0.0)
            yield Row("speed", name, value, unit, error, condition, record.error.model)


def _under_load(record: Record, rated: float, load: float) -> tuple[tuple[Row, ...], tuple[str, ...]]:
    """Return the row on the velocity under the load of the scene in N, or the remark why there is none.

    The velocity is positive in the direction of the motion without a load.
    """
    if load == 0.0:
        return (), ()
    (answer,) = Predictor.of_record(record).answers([{record.scene.level_key: rated, "slider.load": load}])
    name, stated = "speed under load", f"slider.load = {si(load, 'N')}"
    point = answer.point
    if not point.answered:
        return (), (f"the datasheet has no {name}, {stated}: {point.status}",)
    free = next(each for each in record.points if each.level == rated)
    velocity = point.velocity_m_per_s * float(np.sign(free.velocity_m_per_s)) + 0.0
    condition = f"under {stated}, steady"
    if velocity <= 0.0:
        condition += ": held" if velocity == 0.0 else ": dragged back"
    return (Row("speed", name, velocity, "m/s", _velocity_error(record, point) or None, condition),), ()


def _velocity_error(record: Record, point: Point) -> float:
    """Return the error of a point's velocity over |v|; that of a point refers to max(|v|, omega |u_x| / 10)."""
    speed, omega = abs(point.velocity_m_per_s), 2.0 * np.pi * float(record.scene.frequency)
    if speed == 0.0:
        return 0.0
    return point.relative_error * contact.speed_scale(speed, omega * point.tangential_amplitude_m) / speed


def _forces(driven: Contact, rated: float, line: Any, balls: float) -> Iterator[Row]:
    """Yield the rows on forces; ``line`` is the load line of one ball that represents ``balls`` of them."""
    slider, stall = driven.slider, line.stall
    averaged, held = contact.blocked_thrust(slider, driven.at(rated))
    increased, _ = contact.blocked_thrust(slider, driven.at(rated * (1.0 + driven.stator_error)))
    friction = slider.static_friction(driven.contacts)
    error = held_error = abs(increased / averaged - 1.0) + stall.error / stall.value
    # a contact sticks at rest: `held` comes from averaging, whose error is estimated from that of the stall force
    if held > averaged * (1.0 + 1e-9):
        held_error += abs(stall.value / averaged - 1.0)
    held = balls * max(held, stall.value), held_error
    yield from _force_rows((balls * stall.value, error), held, balls * friction, balls * slider.mass)


def _force_rows(stall: tuple, held: tuple, holding: float, mass: float) -> Iterator[Row]:
    """Yield the rows on forces; ``stall`` and ``held`` are a force in N and its relative error."""
    for name, (value, error), unit, condition in (
        ("blocked thrust", stall, "N", "load at which the motor stalls"),
        ("load held on the wave", held, "N", "against the drive, at rest"),
        ("holding force", (holding, None), "N", "drive off: friction coefficient times preload"),
        ("largest acceleration", (holding / mass, None), "m/s\u00b2", "by friction: holding force over mass"),
    ):
        yield Row("force", name, value, unit, error, condition)


def _positioning(bursts: Steps, rated: float, steps: Any, start_stop: Any) -> Iterator[Row]:
    """Yield the rows on the steps of `STEPS`, the start and the stop."""
    frequency = bursts.driven.scene.frequency
    for size, step in zip(STEPS, steps, strict=True):
        if step is None:
            continue
        error = bursts.error(rated, step) + step.error / abs(step.displacement) or None
        name = f"{'smallest step' if size == STEPS[0] else 'step'} of {size * 1e9:g} nm or more"
        cycles = f"{step.cycles} cycle{'' if step.cycles == 1 else 's'}"
        condition = (
            f"a burst of {cycles}, {step.cycles / frequency * 1e6:.4g} \u00b5s; rests after "
            f"{step.stopping_time * 1e6:.3g} \u00b5s, then rings by {step.ring * 1e9:.2g} nm"
        )
        if bursts.sentence:
            condition += f"; {bursts.sentence if size == STEPS[0] or not bursts.reason else FULL_WAVE}"
        yield Row("positioning", name, abs(step.displacement), "m", error, condition)
    settles = f"; it takes {bursts.settling * 1e6:.3g} \u00b5s to settle" if bursts.settling else ""
    yield from _start_and_stop_rows(start_stop, settles)


def _start_and_stop_rows(start_stop: Any, settles: str) -> Iterator[Row]:
    """Yield the rows on start and stop; ``settles``: a remark on the time that the wave needs to settle."""
    time, speed = start_stop.time, abs(start_stop.velocity)
    final_speed = abs(start_stop.velocity_at_burst_end)
    grid, start_time = float(np.max(np.diff(time))), _start_time(start_stop)
    condition = f"from rest to {SETTLED:.0%} of the speed, wave at full size from the first cycle{settles}"
    yield Row("positioning", "start time", start_time, "s", grid / start_time, condition)
    # after the stop, the slider still rings on the contact springs at a small velocity
    slow = (time >= start_stop.duration) & (speed < 1e-2 * final_speed)
    stop_time = float(time[np.argmax(slow)] - start_stop.duration)
    condition = "from full speed to 1 % of it after the drive is off"
    yield Row("positioning", "stop time", stop_time, "s", grid / stop_time, condition)


def _start_time(motion: Any) -> float:
    """Return the time in s from rest to the share ``SETTLED`` of the final velocity."""
    return float(motion.time[np.argmax(abs(motion.velocity) >= SETTLED * abs(motion.velocity_at_burst_end))])


def _powers(record: Record, driven: Contact, rated: float, line: Any, balls: float) -> Iterator[Row]:
    """Yield the rows on powers and efficiencies at the load of the largest mechanical power."""
    best = int(np.argmax(line.power))
    error = 2.0 * driven.stator_error + float(np.max(line.relative_error)) + CONTACT_TOLERANCE
    power, electrical_power = balls * float(line.power[best]), 0.0
    electrical = record.electrical
    if electrical:
        electrical_error = electrical.admittance_relative_error
        electrical_power = electrical.power_W_per_V2 * rated**2
        current = rated * abs(electrical.admittance_S * electrical.comb_voltage_per_volt)
        yield Row("power", "electrical power", electrical_power, "W", electrical_error, "mean, while driven")
        yield Row("power", "current", current, "A", electrical_error, "peak, into the driven transducer")
    best_load = f"{si(balls * line.load[best], 'N', 4)} at {abs(line.velocity[best]) * 1e3:.4g} mm/s"
    yield Row("power", "largest mechanical power", power, "W", error, f"of {LOADS} loads: {best_load}")
    condition = "mechanical power over the power that the wave gives the contacts, best load"
    yield Row("power", "efficiency of the contact", float(np.max(line.efficiency)), "1", error, condition)
    if electrical:
        circulates = electrical.power_net_W_per_V2 is not None
        supplied = (electrical.power_net_W_per_V2 if circulates else electrical.power_W_per_V2) * rated**2
        efficiency, error = power / supplied, electrical_error + error
        condition = f"largest mechanical power over {'net power of the source' if circulates else 'electrical power'}"
        yield Row("power", "efficiency of the motor", efficiency, "1", error, condition)
    yield from _heat_limits(record.heat)


def _heat_limits(block: HeatBlock) -> Iterator[Row]:
    """Yield the rows on what the heat of the stator allows; their numbers hold to the band of the air's coefficient."""
    curie = "the hottest place stays below half the Curie temperature"
    if block.mean_rise_K is not None:
        band = f"{block.highest_rise_low_K:.3g} to {block.highest_rise_high_K:.3g} K with the air's coefficient"
        yield Row("power", "rise of the hottest place", block.highest_rise_K, "K", None, f"steady, {band}")
    if block.continuous_limit_voltage_V is not None:
        yield Row("power", "largest continuous voltage", block.continuous_limit_voltage_V, "V", None, curie)
        yield Row("power", "largest duty", block.duty_limit, "1", None, f"at {block.voltage_V:g} V, {curie}")
    if block.pulsed_limit_voltage_V is not None:
        yield Row(
            "power", "largest pulsed voltage", block.pulsed_limit_voltage_V, "V", None, "10 K in the first second"
        )


def _resonances(record: Record, driven: Contact) -> Iterator[Row]:
    """Yield the rows on the drive's frequency and the resonances of the slider on its contacts."""
    scene = record.scene
    yield Row("resonance", "drive frequency", float(scene.frequency), "Hz")
    if scene.transducer:
        LOGGER.info("stator: search for the strongest wave")
        best = resolved(replace(scene, drive=replace(scene.drive, frequency="center"))).frequency
        condition = "per volt, sent by the driven fingers alone"
        yield Row("resonance", "frequency of the strongest wave", float(best), "Hz", FREQUENCY_ERROR, condition)
    yield from _contact_resonances(driven)


def _contact_resonances(driven: Contact) -> Iterator[Row]:
    contacts, slider = driven.contacts, driven.moving_slider
    for name, frequency, springs in (
        ("bounce of the slider", slider.normal_resonance(contacts), "normal"),
        ("tangential ring", slider.tangential_resonance(contacts), "tangential"),
    ):
        condition = f"on the contacts' {springs} springs, small motion about rest"
        yield Row("resonance", name, frequency, "Hz", condition=condition)
