"""How a motor in a position loop goes to a target and back: time, overshoot, error at rest, bursts, energy.

Method: the motor of a scene (``twente-contact`` when none is named) followed through every cycle of the wave
(`studies.motor.followed_motor`), a sensor with resolution, noise and delay, a controller with a period (`--controller
two_phase`, dead_zone_pi, burst_length or FILE.py:FUNCTION), two drives that push either way where the scene has them;
from rest to `--target "10 um"` and back.  The same drive is then given to the motor followed in steps twice as long,
which is the error of the positions, and to the averaged motor, which `sawmotor export` writes for simulators.  A slider
that has stopped rings in its contacts, and the next burst begins with the velocity of the ring at that instant.  The
averaged motor follows the ring, but its error of some 0.1 um/s at a stop changes amplitude and frequency of the ring
enough to lose the phase within some 10 ms.  From then on its velocity is wrong by up to twice that of the ring (22 um/s
for ``twente``), and so its position by up to 44 nm in each millisecond in which the slider slides.
`--loop KEY=VALUE` sets what surrounds the motor and the controller's numbers: resolution, noise, delay, period, force,
force_at, preload, limit, hold, seed.  A second panel shows what bursts of a few cycles leave: within one elastic
deformation of the contacts the slider comes back when the wave has gone.  Step-to-step scatter follows from the
tolerances of [uncertain].  Expected: it comes to rest within 2 nm, and steps are those of `contact.step`.  Run time:
about 20 s, and twice the stator's.
"""

import math
from dataclasses import fields, replace

import numpy as np

import contact
from studies.chain.steps import Steps
from studies.export.averaged_motor import AveragedMotor, averaged_motor, ring_speed
from studies.motor.controllers import MotorNumbers, controller
from studies.motor.followed_motor import STEPS, FollowedMotor
from studies.motor.position_loop import BANDS, Loop, Move, moved, replayed
from studies.record.plots import COLOURS, curve, finished
from studies.refusal import SceneError
from studies.scene import Scene
from studies.scene.override import parts_of, toml_value
from studies.scene.quantity import si_value
from studies.study import Answered, Panel, driven_contact, judged, of_record, study

QUICK = {"cycles": (8, 25, 100)}
CYCLES = (2, 4, 8, 12, 16, 25, 36, 50, 72, 100, 150, 200)
USUAL = 1e-5  # m, the target of one that names none
GOOD = 2e-9  # m, the error at rest that is asked for
EXACT = 1e-10  # m, the error of the positions that is asked for
UNITS = {
    "resolution": "m", "noise": "m", "delay": "s", "period": "s", "force": "N", "force_at": "s", "preload": "N",
    "limit": "s", "hold": "s", "seed": "", "coarse": "m", "tolerance": "m", "single": "m", "settle": "s",
}  # fmt: skip
DRAWS = 24  # motors of the tolerances' scatter
SCATTER_CYCLES = 100


@study("twente-contact")
def run(
    scene: Scene,
    *,
    target: str | float | None = None,
    controller: str = "two_phase",
    loop: list[str] | None = None,
    cycles: tuple[int, ...] = CYCLES,
    progress=None,
) -> Answered:
    """Return the moves to a target and back, and the steps of short bursts.

    Parameters
    ----------
    target : str or float, optional
        Where to go, m from the start; 10 um the way of the first drive when absent.
    controller : str
        A name of `studies.motor.controllers.CONTROLLERS`, or ``FILE.py:FUNCTION``.
    loop : list of str
        ``KEY=VALUE`` of the loop or of the controller.
    cycles : tuple of int
        Lengths of the bursts whose steps are shown.
    """
    surroundings, control = read_loop(loop or [], controller)
    way = None
    if target is not None:
        way = si_value("--target", toml_value(target) if isinstance(target, str) else target, "m")
        if way == 0.0:
            raise SceneError("--target", "must not be 0: that is where the slider stands")
        refuse_beyond(scene, way)
    motor = averaged_motor(scene, progress=progress)
    numbers, direction = motor_numbers(motor)
    if way is None:
        way = USUAL * direction
        refuse_beyond(scene, way)
    if len(motor.drives) == 1 and way * direction < 0.0:
        raise SceneError(
            "--target", f"must be {'negative' if way > 0 else 'positive'}: one transducer drives one way"
        )
    progress("positioning: the way there and back")
    state = FollowedMotor(motor, preload=surroundings.preload)
    powers = (*(drive.power for drive in motor.drives), 0.0)
    given = {
        "powers": powers[:2],
        "direction": direction,
        "frequency": motor.drives[0].orbits[0].frequency,
        "one_way": len(motor.drives) == 1,
    }
    ways = {"there": moved(state, way, control(), numbers, surroundings, **given)}
    if len(motor.drives) == 2:
        again = replace(surroundings, seed=surroundings.seed + 1)
        ways["back"] = moved(state, 0.0, control(), numbers, again, **given)
    coarse = FollowedMotor(motor, preload=surroundings.preload, steps=STEPS // 2)
    apart = [
        _apart(ways, replayed(other, tuple(ways.values()), surroundings))
        for other in (coarse, motor.start(preload=surroundings.preload))
    ]
    progress("positioning: steps of short bursts")
    steps = _steps(scene, motor, cycles, progress)
    scatter = _scatter(scene, motor, progress)
    panels = [_panel(motor, ways), *_steps_panel(motor, steps)]
    findings = [_finding(motor, name, move) for name, move in ways.items()]
    findings.append(judged(
        "The positions are those of the motor followed in steps twice as long.",
        "largest difference on the way, m", apart[0][0], high=EXACT,
    ))  # fmt: skip
    findings.append(judged(
        "The averaged motor makes the steps of the contact followed through every cycle.",
        "largest difference of a step, m", steps["difference"], high=math.inf, holds=None,
        expected="0.3 nm for a wave that fades, up to two elastic deformations for one that stops at once",
    ))  # fmt: skip
    return panels, findings, _answer(motor, ways, apart, steps, scatter)


def _apart(ways: dict[str, Move], others: list[np.ndarray]) -> tuple[float, float]:
    """Return how far another motor under the same drive is beside the moves, m: at most, and in the end."""
    largest = max(
        float(np.max(np.abs(move.position - other)))
        for move, other in zip(ways.values(), others, strict=True)
    )
    return largest, abs(float(list(ways.values())[-1].position[-1] - others[-1][-1]))


def read_loop(settings: list[str], name: str):
    """Return the `Loop` of texts KEY=VALUE and a maker of the controller with what is its own.

    Raises
    ------
    SceneError
        If a key is neither the loop's nor the controller's, or a value is out of range.
    """
    known = {each.name for each in fields(Loop)}
    given: dict = {}
    own: dict = {}
    for text in settings:
        key, value = parts_of("--loop", text, "KEY=VALUE")
        number = si_value(f"--loop {key}", toml_value(value), UNITS.get(key, ""))
        if key not in ("force", "proportional", "integral") and number < 0.0:
            raise SceneError(f"--loop {key}", f"must be zero or positive, got {value}")
        if key in ("period", "limit", "preload", "readings", "gain") and not number > 0.0:
            raise SceneError(f"--loop {key}", f"must be positive, got {value}")
        (given if key in known else own)[key] = int(number) if key == "seed" else number
    controller(name, own)  # refused before anything is computed
    return Loop(**given), lambda: controller(name, own)


def refuse_beyond(scene: Scene, way: float) -> None:
    """Refuse a target at which a ball would leave the stator or stand on fingers.

    Raises
    ------
    SceneError
        Naming the way that there is.
    """
    if scene.stator is None or scene.slider is None:
        return
    from studies.chain import resolve

    chosen = resolve.resolved(scene)
    places = [x for x, _ in chosen.slider.places]
    low, high = -min(places), chosen.stator.length - max(places)
    for each in chosen.transducer if not chosen.crossed else ():
        half = each.half_length
        if each.place[0] < min(places):
            low = max(low, each.place[0] + half - min(places))
        elif each.place[0] > max(places):
            high = min(high, each.place[0] - half - max(places))
    if not low < way < high:
        rule = f"must keep the slider on the free surface, {low:.4g} to {high:.4g} m from its place"
        raise SceneError("--target", f"{rule}, got {way:.4g} m")


def motor_numbers(motor: AveragedMotor) -> tuple[MotorNumbers, float]:
    """Return what a controller knows of a motor, and the sign of its velocity under the first drive."""
    slider, drive, level = motor.slider, motor.drives[0], motor.levels[-1]
    orbits = tuple(orbit.scaled(level) for orbit in drive.orbits)
    push = float(contact.mean_traction(replace(slider, load=0.0), orbits, np.zeros(1))[0])
    dead = float(contact.threshold_factor(slider, drive.orbits))
    if push == 0.0 or dead >= level:
        raise SceneError(
            "drive.voltage", f"must reach above the threshold, {dead:.4g} {motor.unit}, got {level:.4g}"
        )
    steady = abs(float(contact.mean_motion(slider, orbits).velocity))
    numbers = MotorNumbers(
        level=level, dead_zone=dead, acceleration=abs(push) / slider.mass,
        braking=slider.friction_coefficient * slider.preload / slider.mass, delay=drive.settling,
        speed_per_level=steady / (level - dead),
    )  # fmt: skip
    return numbers, math.copysign(1.0, push)


def _steps(scene: Scene, motor: AveragedMotor, cycles, progress) -> dict:
    """Return the steps of short bursts at the largest level: the farthest place, and where the slider stayed."""
    driven = driven_contact(scene, progress=progress)
    bursts = Steps.of(driven, progress=progress)
    level, frequency, drive = motor.levels[-1], motor.drives[0].orbits[0].frequency, motor.drives[0]
    lasting = 0.0 if drive.response is None else drive.response_step * len(drive.response)
    exact = [bursts.step(level, number) for number in cycles]
    reached, stayed = [], []
    for number in cycles:
        state = motor.start()
        state.advance(number / frequency, level)
        farthest, step = 0.0, 2e-6
        for _ in range(math.ceil((lasting + 2e-4) / step)):
            state.advance(step, 0.0)
            farthest = max(farthest, state.position, -state.position, key=abs)
        state.advance(0.02, 0.0)
        reached.append(math.copysign(farthest, exact[-1].displacement))
        stayed.append(state.position + state.deformation)
    truth = np.array([each.displacement for each in exact])
    z = motor.slider.rest_approach(len(drive.orbits))
    return {
        "cycles": np.array(cycles), "exact_m": truth, "averaged_m": np.array(stayed), "farthest_m": np.array(reached),
        "ring_m": np.array([each.ring for each in exact]), "elastic_m": motor.slider.limit_slope * z,
        "difference": float(np.max(np.abs(np.array(stayed) - truth))),
    }  # fmt: skip


def _scatter(scene: Scene, motor: AveragedMotor, progress) -> tuple[float, float] | None:
    """Return mean and standard deviation of a burst's step over motors within the tolerances of [uncertain]."""
    if scene.uncertain is None:
        return None
    from studies.chain.predictor import Predictor
    from studies.chain.resolve import resolved
    from studies.chain.solved_stator import of_stator
    from studies.scene.keys import LEVELS, tolerances

    progress("positioning: scatter by the tolerances")
    bands = [each for each in tolerances(resolved(scene)) if each.key in LEVELS or not of_stator(each.key)]
    if not bands:
        return None
    predictor = Predictor(resolved(replace(scene, uncertain=None)).to_table(), tolerance=1e-2, steps=1)
    random, steps = np.random.default_rng(0), []
    for _ in range(DRAWS):
        # half widths of 95 %; what changes from step to step is taken to be as large as what is not known
        drawn = {each.key: each.value + each.half_width / 1.96 * random.standard_normal() for each in bands}
        level = motor.levels[-1] * next((value for key, value in drawn.items() if key in LEVELS), 1.0)
        driven = predictor.contact({key: value for key, value in drawn.items() if key not in LEVELS})
        steps.append(contact.step(driven.slider, driven.at(level), cycles=SCATTER_CYCLES).displacement)
    return float(np.mean(steps)), float(np.std(steps, ddof=1))


def _panel(motor: AveragedMotor, ways: dict[str, Move]) -> Panel:
    data: dict = {}
    begin = 0.0
    for name, move in ways.items():
        data |= {f"{name}_time_s": begin + move.time, f"{name}_position_m": move.position,
                 f"{name}_level": move.level, f"{name}_target_m": move.target}  # fmt: skip
        begin += move.time[-1]
    return Panel(name="positioning", title=f"{motor.title}: to the target and back", data=data)


def _steps_panel(motor: AveragedMotor, steps: dict) -> list[Panel]:
    data = {key: value for key, value in steps.items() if key != "difference"}
    level = f"{motor.levels[-1]:.4g} V" if motor.unit == "V" else f"{motor.levels[-1] * 1e9:.4g} nm"
    return [Panel(name="single_steps", title=f"{motor.title}: bursts of a few cycles at {level}", data=data)]


def _finding(motor: AveragedMotor, name: str, move: Move):
    return judged(
        f"The slider comes to rest at the target, {name}.", "mean error at rest, m", abs(move.error_at_rest), high=GOOD,
        holds=None if not move.settled and abs(move.error_at_rest) < GOOD else True,
        remark="" if move.settled else "the controller was not satisfied within the limit",
    )  # fmt: skip


def _answer(
    motor: AveragedMotor, ways: dict[str, Move], apart, steps: dict, scatter
) -> list[tuple[str, str]]:
    rows = []
    for name, move in ways.items():
        times = ", ".join(
            f"{band * 1e9:g} nm "
            + ("never" if math.isnan(move.within[band]) else f"after {move.within[band] * 1e3:.4g} ms")
            for band in BANDS
        )
        counts = ", ".join(f"{number} {phase}" for phase, number in move.bursts.items()) or "none"
        rows += [
            (name, f"{move.start * 1e6:.6g} to {move.target * 1e6:.6g} um: within {times}"),
            ("", f"overshoot {move.overshoot * 1e9:.3g} nm, error at rest {move.error_at_rest * 1e9:+.3g} nm, ring "
                 f"{move.ring * 1e9:.3g} nm"),
            ("", f"drives: {counts}; {move.cycles:.0f} cycles"
                 + (f", {move.energy * 1e3:.4g} mJ" if move.energy else "")),
        ]  # fmt: skip
    (error, _), (largest, left) = apart
    speed = ring_speed(motor.slider, len(motor.drives[0].orbits))
    rows += [
        ("error", f"of the positions: at most {error * 1e9:.2g} nm, from steps twice as long"),
        ("averaging", f"the averaged motor under the same drive is at most {largest * 1e9:.2g} nm beside these,"),
        ("", f"{left * 1e9:.2g} nm in the end: it loses the phase of a ring of at most {speed * 1e6:.2g} um/s"),
    ]  # fmt: skip
    inside = np.flatnonzero(np.abs(steps["exact_m"]) < steps["elastic_m"])
    rows.append(("elastic", f"the contacts give way by {steps['elastic_m'] * 1e9:.3g} nm before they slip"))
    if inside.size:
        k = int(inside[-1])
        rows.append(("", f"{steps['cycles'][k]} cycles move the slider by {steps['farthest_m'][k] * 1e9:+.3g} nm at "
                         f"most, and leave it at {steps['exact_m'][k] * 1e9:+.3g} nm: it comes back"))  # fmt: skip
    rows.append(
        (
            "",
            f"its steps differ by at most {steps['difference'] * 1e9:.2g} nm from those of the exact contact",
        )
    )
    if scatter is not None:
        mean, deviation = scatter
        rows.append(
            (
                "scatter",
                f"{SCATTER_CYCLES} cycles: {mean * 1e9:.4g} +- {deviation * 1e9:.3g} nm by [uncertain]",
            )
        )
    return rows


@of_record
def figure(record: Panel, ax):
    """Draw the way there and back with what is left of it beside the target, or the steps of short bursts."""
    data = record.data
    if record.name == "single_steps":
        curve(ax, data["cycles"], data["exact_m"] * 1e9, "-", "line", "stays, followed through every cycle")
        curve(ax, data["cycles"], data["averaged_m"] * 1e9, "o", "slip", "stays, averaged motor", size=4.0)
        curve(ax, data["cycles"], data["farthest_m"] * 1e9, "--", "stick", "farthest on the way")
        ax.axhspan(-data["elastic_m"] * 1e9, data["elastic_m"] * 1e9, color=COLOURS["stick"], alpha=0.2, linewidth=0,
                   label="elastic deformation of the contacts")  # fmt: skip
        ax.set_yscale("symlog", linthresh=1.0)
        return finished(ax, "cycles of the drive", "step (nm)", record.title, columns=2)
    for name, colour in (("there", "slip"), ("back", "stick")):
        if f"{name}_time_s" in data:
            at, target = data[f"{name}_time_s"] * 1e3, data[f"{name}_target_m"] * 1e9
            curve(
                ax,
                at,
                data[f"{name}_position_m"] * 1e9 - target,
                "-",
                colour,
                f"{name}, to {target / 1e3:g} um",
            )
    ax.axhspan(-2.0, 2.0, color=COLOURS["line"], alpha=0.15, linewidth=0, label="2 nm")
    ax.set_yscale("symlog", linthresh=2.0)
    return finished(ax, "time (ms)", "position less the target (nm)", record.title, columns=3)
