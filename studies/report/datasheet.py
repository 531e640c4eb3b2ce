"""The numbers of a motor's datasheet: what a motion engineer asks of a motor, with unit, conditions and error.

Everything holds at the rated level, the largest voltage (or given amplitude) of the scene, without a load unless it
says so.  Errors are those of the computation: the stator's and the contact's, carried to each quantity.  The scene's
own numbers, friction above all, are taken as exact.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from studies.chain import run
from studies.chain.driven_contact import DrivenContact
from studies.record import Record
from studies.refusal import RunError
from studies.scene import Scene, resolved

__all__ = ["Datasheet", "Row", "datasheet"]

LOADS = 13  # of a load line
LINES = (0.5, 0.75, 1.0)  # of the rated level: the scene's nearest levels have a load line
STEPS = (1e-9, 1e-8, 1e-7)  # m
SETTLED = 0.9  # of the steady velocity: the slider has started
LONG = 8.0  # burst over the time in which friction alone would reach the steady velocity
CONTACT_TOLERANCE = 1e-4
CENTRE = 5e-4  # of the frequency of the strongest wave: a coarse discretisation (fem/solve/passband.py)


@dataclass(frozen=True, kw_only=True)
class Row:
    """One line of the datasheet.

    Attributes
    ----------
    group, name : str
        Where it stands and what it is.
    value : float
        In SI units.
    unit : str
    error : float or None
        Relative; None where the number is given by the scene or counted.
    condition : str
        What it holds for beyond the rated level.
    """

    group: str
    name: str
    value: float
    unit: str
    error: float | None = None
    condition: str = ""


@dataclass(frozen=True, kw_only=True)
class Datasheet:
    """A motor's datasheet.

    Attributes
    ----------
    record : Record
        Of the run behind it.
    driven : DrivenContact
    rated : float
        V of the source, or m of given amplitude.
    rows : tuple of Row
    lines : dict of str to contact.LoadLine
        By level; of one of the balls that are computed as one.
    balls : float
        How many balls such a load line stands for.
    start_stop : contact.Trajectory
        A burst from rest at the rated level, and the stop after it.
    steps : tuple of contact.Step
        The shortest bursts that move the slider by the sizes in `STEPS`.
    """

    record: Record
    driven: DrivenContact = field(repr=False)
    rated: float
    rows: tuple[Row, ...]
    lines: dict = field(repr=False)
    balls: float
    start_stop: object = field(repr=False)
    steps: tuple = field(repr=False)

    def to_dict(self) -> dict:
        """Return what datasheet.json holds: title, rated level, the rows and the model error."""
        level = "amplitude_m" if self.record.scene.wave is not None else "voltage_V"
        rows = [
            {key: value for key, value in vars(row).items() if value not in (None, "")} for row in self.rows
        ]
        whole = {"title": self.record.scene.title, f"rated_{level}": self.rated, "rows": rows}
        return whole | ({"model_error": self.record.model_error} if self.record.model_error else {})


def datasheet(
    scene: Scene, *, tolerance: float = 1e-3, progress: Callable[[str], None] | None = None
) -> Datasheet:
    """Return the datasheet of a motor.

    Parameters
    ----------
    scene : Scene
        With a slider and either a driven stator or a given wave.
    tolerance : float
        Of the slider velocity, as for a run.
    progress : callable, optional
        Told what is being done.

    Raises
    ------
    SceneError
        If the scene has no slider, or no level moves it.
    RunError
        If a number of the datasheet has no answer.
    """
    import contact

    say = progress or (lambda text: None)
    if scene.slider is None:
        scene.refuse("slider", "is missing: a datasheet is of a whole motor")
    block = "wave" if scene.wave is not None else "drive"
    record = run(
        replace(scene, **{block: replace(getattr(scene, block), burst=None)}),
        tolerance=tolerance,
        progress=say,
    )
    if record.shortfall:
        raise RunError(record.shortfall)
    driven = DrivenContact.of_run(record)
    moving = driven.above(1.0)
    rated = moving[-1]
    try:
        say("load lines")
        picked = sorted({min(moving, key=lambda level: abs(level - part * rated)) for part in LINES})
        lines = {
            driven.named(level): contact.load_line(
                driven.slider, driven.at(level), points=LOADS, tolerance=CONTACT_TOLERANCE
            )
            for level in picked
        }
        say("start and stop")
        start_stop = _start_stop(driven, rated)
        say("steps")
        steps = tuple(
            contact.cycles_for(driven.slider, driven.at(rated), displacement=size)[1] for size in STEPS
        )
    except contact.ConvergenceError as error:
        raise RunError(f"the datasheet is incomplete: {' '.join(str(error).split())}") from None
    balls = record.scene.slider.preload / driven.slider.preload
    line = lines[driven.named(rated)]
    rows = (
        *_speeds(record, driven, rated),
        *_forces(driven, rated, balls),
        *_positioning(driven, rated, steps, start_stop),
        *_powers(record, driven, rated, line, balls),
        *_resonances(record, driven, say),
    )
    return Datasheet(
        record=record,
        driven=driven,
        rated=rated,
        rows=rows,
        lines=lines,
        balls=balls,
        start_stop=start_stop,
        steps=steps,
    )


def _start_stop(driven: DrivenContact, rated: float):
    """Return a burst from rest that reaches the steady velocity, and the stop after it."""
    import contact

    slider, orbits = driven.slider, driven.at(rated)
    acceleration = slider.friction_coefficient * slider.preload / slider.mass
    steady = contact.steady(slider, orbits, tolerance=CONTACT_TOLERANCE).velocity
    least = abs(steady) / acceleration
    return contact.burst(
        slider, orbits, duration=LONG * least, after=2.0 * least, tolerance=1e-3, samples=4000
    )


def _speeds(record: Record, driven: DrivenContact, rated: float) -> list[Row]:
    point = next(each for each in record.points if each[record.level] == rated)
    # the point's error is stated over max(|v|, omega |u_x| / 10)
    omega = 2.0 * np.pi * record.scene.frequency
    velocity = point["velocity_m_per_s"]
    scale = max(abs(velocity), omega * point["tangential_amplitude_m"] / 10.0)
    unit, key = ("m", "amplitude_m") if record.scene.wave is not None else ("V", "voltage_V")
    rows = [Row(group="speed", name="speed", value=abs(velocity), unit="m/s",
                error=point["relative_error"] * scale / abs(velocity), condition="no load, steady")]  # fmt: skip
    for name, words in (("threshold", "starts to move"), ("release", "leaves the surface in every cycle")):
        if f"{name}_{key}" in record.summary:
            rows.append(Row(group="speed", name=name, value=record.summary[f"{name}_{key}"], unit=unit,
                            error=driven.stator_error, condition=f"the slider {words}"))  # fmt: skip
    return rows


def _forces(driven: DrivenContact, rated: float, balls: float) -> list[Row]:
    import contact

    slider = driven.slider
    stall, held = contact.blocked_thrust(slider, driven.at(rated))
    more, _ = contact.blocked_thrust(slider, driven.at(rated * (1.0 + driven.stator_error)))
    friction = slider.friction_coefficient * slider.preload
    return [
        Row(group="force", name="blocked thrust", value=balls * stall, unit="N",
            error=abs(more / stall - 1.0) + CONTACT_TOLERANCE, condition="load at which the motor stalls"),
        Row(group="force", name="load held on the wave", value=balls * held, unit="N",
            error=abs(more / stall - 1.0) + CONTACT_TOLERANCE, condition="against the drive, at rest"),
        Row(group="force", name="holding force", value=balls * friction, unit="N",
            condition="drive off: friction coefficient times preload"),
        Row(group="force", name="largest acceleration", value=friction / slider.mass, unit="m/s\u00b2",
            condition="that friction can give: holding force over mass"),
    ]  # fmt: skip


def _positioning(driven: DrivenContact, rated: float, steps, start_stop) -> list[Row]:
    import contact

    frequency, rows = driven.scene.frequency, []
    for size, step in zip(STEPS, steps, strict=True):
        again = contact.step(
            driven.slider, driven.at(rated * (1.0 + driven.stator_error)), cycles=step.cycles
        )
        name = "smallest step" if size == STEPS[0] else "step"
        cycles = f"{step.cycles} cycle{'' if step.cycles == 1 else 's'}"
        rows.append(
            Row(group="positioning", name=f"{name} of {size * 1e9:g} nm or more", value=abs(step.displacement),
                unit="m", error=abs(again.displacement / step.displacement - 1.0) if driven.stator_error else None,
                condition=f"a burst of {cycles}, {step.cycles / frequency * 1e6:.4g} \u00b5s; rests after "
                f"{step.stopping_time * 1e6:.3g} \u00b5s, then rings by {step.ring * 1e9:.2g} nm")
        )  # fmt: skip
    time, speed = start_stop.time, abs(start_stop.velocity)
    reached = time[np.argmax(speed >= SETTLED * abs(start_stop.velocity_at_burst_end))]
    # the slider has stopped when its velocity is that of its ring in the contact's spring
    after = time >= start_stop.duration
    slow = after & (speed < 1e-2 * abs(start_stop.velocity_at_burst_end))
    stopped = time[np.argmax(slow)] - start_stop.duration
    grid = float(np.max(np.diff(time)))
    rows += [
        Row(group="positioning", name="start time", value=float(reached), unit="s", error=grid / float(reached),
            condition=f"from rest to {SETTLED:.0%} of the speed, wave at full size from the first cycle"),
        Row(group="positioning", name="stop time", value=float(stopped), unit="s", error=grid / float(stopped),
            condition="from full speed to 1 % of it after the drive is off"),
    ]  # fmt: skip
    return rows


def _powers(record: Record, driven: DrivenContact, rated: float, line, balls: float) -> list[Row]:
    best = int(np.argmax(line.power))
    load, velocity = balls * float(line.load[best]), float(line.velocity[best])
    rows = [
        Row(group="power", name="largest mechanical power", value=balls * float(line.power[best]), unit="W",
            error=2.0 * driven.stator_error + CONTACT_TOLERANCE,
            condition=f"of {LOADS} loads: {load * 1e6:.4g} \u00b5N at {velocity * 1e3:.4g} mm/s"),
        Row(group="power", name="efficiency of the contact", value=float(np.max(line.efficiency)), unit="1",
            error=2.0 * driven.stator_error + CONTACT_TOLERANCE,
            condition="mechanical power over the power that the wave gives the balls, best load"),
    ]  # fmt: skip
    if not record.electrical:
        return rows
    electrical = record.electrical
    error, drawn = electrical["admittance_relative_error"], electrical["power_W_per_V2"] * rated**2
    current = (
        abs(complex(electrical["admittance_S"])) * abs(complex(electrical["comb_voltage_per_volt"])) * rated
    )
    return [
        Row(group="power", name="electrical power", value=drawn, unit="W", error=error, condition="mean, while driven"),
        Row(group="power", name="current", value=current, unit="A", error=error,
            condition="peak, into the driven transducer"),
        *rows,
        Row(group="power", name="efficiency of the motor", value=balls * float(line.power[best]) / drawn, unit="1",
            error=error + 2.0 * driven.stator_error + CONTACT_TOLERANCE,
            condition="largest mechanical power over electrical power"),
    ]  # fmt: skip


def _resonances(record: Record, driven: DrivenContact, say) -> list[Row]:
    scene, contacts = record.scene, len(driven.orbits)
    rows = [Row(group="resonance", name="drive frequency", value=scene.frequency, unit="Hz")]
    if scene.transducer:
        say("stator: looking for the strongest wave")
        best = resolved.resolved(replace(scene, drive=replace(scene.drive, frequency="center"))).frequency
        rows.append(Row(group="resonance", name="frequency of the strongest wave", value=best, unit="Hz", error=CENTRE,
                        condition="per volt, sent by the driven fingers alone"))  # fmt: skip
    return [
        *rows,
        Row(group="resonance", name="bounce of the slider", value=driven.slider.normal_resonance(contacts), unit="Hz",
            condition="on the contacts' normal springs, small motion about rest"),
        Row(group="resonance", name="tangential ring", value=driven.slider.tangential_resonance(contacts), unit="Hz",
            condition="on the contacts' tangential springs, small motion about rest"),
    ]  # fmt: skip
