"""Sensitivity of the motor to its parameters: elasticities of velocity, limits, thrust, efficiency and start-up time.

Method: d ln(answer) / d ln(parameter) for every positive parameter of the resolved scene (a preload of "weight" becomes
a force, which stays constant when the mass changes), at the largest voltage or amplitude. The derivatives are
extrapolated differences, each with its error; the step is the fifth root of the accuracy of the answer. The
elasticities of the velocity are also computed by the implicit function theorem in the averaged equilibrium. Start-up
times are those of the averaged motion, because a difference of two exact starts would take 100 times as long. The study
also states the change of the answer for 1 % more and 1 % less of the parameter. Near a resonance, or where the phase of
a wave changes, these differ from the elasticity and from each other, and the study says so. Parameters of the stator
take six solutions each, with an accuracy of 1e-2. Expected: both methods agree to a few (f_n/f)^2; the elasticities
satisfy the scaling law of the contact, preload + E* - friction coefficient = 0; a common change of all parameters
without effect changes nothing. Run time: 10 s; for twente with its stator 90 s of one processor.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise
from typing import Any

import numpy as np

import contact
from studies.inverse.prediction import MeasurementPredictor
from studies.record.plots import COLOURS, finished
from studies.refusal import RunError, SceneError
from studies.scene import Scene
from studies.study import Answered, Finding, Panel, StudyRecord, judged, of_record, study

QUICK = {"outcomes": ("velocity", "threshold")}
# accuracy of each answer: that of rounding, or the tolerance that it is solved to
ACCURACY = {"velocity": 1e-11, "threshold": 1e-13, "release": 1e-13, "thrust": 1e-11, "efficiency": 1e-8,
            "start-up time": 1e-6}  # fmt: skip
# column of each answer, and the word that asks for it
ANSWERS = {
    "velocity": ("velocity_m_per_s", ()), "threshold": ("threshold_factor", ("limits",)),
    "release": ("release_factor", ("limits",)), "thrust": ("thrust_N", ("thrust",)),
    "efficiency": ("contact_efficiency", ("efficiency",)), "start-up time": ("start_up_time_s", ("start-up",)),
}  # fmt: skip
STATOR_ACCURACY = 1e-9  # of a stator's answers against each other on the same mesh
STATOR_STEP, PHASE_STEP = 1e-3, 2e-4  # of the logarithms of its numbers
PHASED = ("center", "position", "thickness", "frequency")  # many wavelengths: a change is one of phase
NO_EFFECT = 1e-4  # elasticity below which a number is said to have none
LIMITS = ("threshold", "release")
COLUMNS = ("key", "elasticity", "error", "change_for_1_percent_more", "change_for_1_percent_less")
NAMED, MAX_DRAWN = 4, 14  # numbers in the answer's line, and in the picture
SIDE = 0.01  # change of a number to either side, beside its elasticity
BENDS = 0.2  # difference of both sides, over the larger, from which the study says that the answer bends
SILENT_STEP = 0.02  # by which the numbers without effect are changed together
AGREEMENT = 1e-2  # of both ways, of the largest elasticity


@study("twente-contact")
def run(
    scene: Scene, *, outcomes: tuple[str, ...] = tuple(ACCURACY), tolerance: float = 1e-2, progress=None
) -> Answered:
    """Return the elasticities of a motor.

    Parameters
    ----------
    outcomes : tuple of str
        Of velocity, threshold, release, thrust, efficiency and start-up time.
    tolerance : float
        Of the velocity, for the stator.
    """
    predictor = MeasurementPredictor(scene, tolerance=tolerance, progress=progress)
    level = max(predictor.contact({}).scene.levels)
    slopes = {name: elasticities(predictor, name, level, progress) for name in outcomes}
    title, findings, panels = predictor.table.get("title", ""), [], []
    for name, rows in slopes.items():
        findings += _without_effect(predictor, name, rows, level)
        keys = [*numbers(predictor), *(["level"] if name not in LIMITS else [])] if rows else []
        sides = both_sides(predictor, name, level, tuple(keys))
        order = [key for key, _ in sorted(rows.items(), key=lambda item: -abs(item[1][0]))]
        panels.append(
            Panel(name=name.replace(" ", "_").replace("-", "_"), title=f"{title}: {name}", data={
                "key": order, "elasticity": [rows[key][0] for key in order], "error": [rows[key][1] for key in order],
                "change_for_1_percent_more": [sides[key][0] for key in order],
                "change_for_1_percent_less": [sides[key][1] for key in order],
                "bends": [[key, *sides[key]] for key in keys if _bends(*sides[key])], "level": level, "outcome": name,
            })
        )  # fmt: skip
    if "velocity" in slopes:
        findings += _checks(predictor, slopes["velocity"], level)
    return panels, findings, [line for panel in panels for line in _in_words(panel.data)]


def numbers(predictor: MeasurementPredictor) -> list[str]:
    """Return the keys of a scene's positive numbers that an answer may depend on."""
    known = (".burst", ".gravity", "stator.width", "normal_amplitude", "drive.voltage")
    table = {name: block for name, block in predictor.table.items() if name != "uncertain"}
    return [key for key in _positive(table) if not key.endswith(known)]


def _positive(value: Any, path: str = "") -> Iterator[str]:
    if isinstance(value, float) and value > 0.0:
        yield path
    entries: Iterable = value.items() if isinstance(value, dict) else ()
    if isinstance(value, list) and value and isinstance(value[0], dict):
        entries = enumerate(value)
    for key, each in entries:
        yield from _positive(each, f"{path}.{key}" if path else key)


def elasticities(
    predictor: MeasurementPredictor, outcome: str, level: float, progress: Callable[[str], None] = print
) -> dict[str, tuple[float, float]]:
    """Return {key: (d ln outcome / d ln number, its error)}, the level itself as "level".

    ``level``: voltage in V or given normal amplitude in m.
    """
    if outcome not in ACCURACY:
        raise SceneError("outcomes", f"must be of {', '.join(ACCURACY)}, got {outcome!r}")
    slopes: dict[str, tuple[float, float]] = {}
    (centre,) = _answers(predictor, outcome, level, [{}])
    if not np.isfinite(centre) or centre == 0.0:
        return {}
    for key in [*numbers(predictor), *(["level"] if outcome not in LIMITS else [])]:
        progress(f"{outcome}: {key}")
        moved = key != "level" and predictor.needs_stator(key)
        accuracy = max(ACCURACY[outcome], STATOR_ACCURACY if moved else 0.0)
        step = accuracy**0.2 if not moved else PHASE_STEP if key.endswith(PHASED) else STATOR_STEP
        widths = step / np.array([1.0, 2.0] if moved else [1.0, 2.0, 4.0])
        factors = np.exp(np.concatenate([widths, -widths])).tolist()
        values = _answers(predictor, outcome, level, [{key: factor} for factor in factors]) / centre
        if not np.all(values > 0.0):  # no answer, such as for a value that the scene refuses
            continue
        up, down = np.split(np.log(values), 2)
        table = ((up - down) / (2.0 * widths)).tolist()
        for power in (4.0, 16.0)[: len(table) - 1]:  # Richardson extrapolation in the square of the step
            change = (table[-1] - table[-2]) / (power - 1.0)
            table = [(power * fine - coarse) / (power - 1.0) for coarse, fine in pairwise(table)]
        slopes[key] = (float(table[0]), float(abs(change) + 8.0 * accuracy / step))
    return slopes


def both_sides(
    predictor: MeasurementPredictor, outcome: str, level: float, keys: tuple[str, ...]
) -> dict[str, tuple[float | None, float | None]]:
    """Return {key: relative change of the answer for 1 % more and 1 % less of the number}; None where it has none."""
    moves = [{key: factor} for key in keys for factor in (1.0 + SIDE, 1.0 - SIDE)]
    centre, *values = _answers(predictor, outcome, level, [{}, *moves])
    changes = [float(each / centre - 1.0) if math.isfinite(each) else None for each in values]
    return dict(zip(keys, zip(changes[0::2], changes[1::2], strict=True), strict=True))


def _answers(predictor: MeasurementPredictor, outcome: str, level: float, many: list[dict[str, float]]) -> np.ndarray:
    """Return an answer for each set of factors by key, "level" among the keys; NaN where there is none.

    A stator that cannot be solved raises RunError: a number must not be missing in silence.
    """
    column, also = ANSWERS[outcome]
    level_key = "wave.normal_amplitude" if predictor.given_wave else "drive.voltage"
    changes = [
        {key: float(predictor.value(key) or 0.0) * factor for key, factor in factors.items() if key != "level"}
        | {level_key: level * factors.get("level", 1.0)}
        for factors in many
    ]
    rows = predictor.answers(changes, also, tolerance=ACCURACY[outcome], averaged=True)
    for row in rows:
        if "relative_error" not in row and not row.get("refused"):
            raise RunError(row["status"])
    return np.abs([row.get(column, math.nan) for row in rows])


def _without_effect(predictor: MeasurementPredictor, outcome: str, rows: dict, level: float) -> list[Finding]:
    """Return which numbers have no effect, and what happens if all of them are changed together."""
    silent = [key for key, (value, _) in rows.items() if abs(value) < NO_EFFECT and key != "level"]
    if not silent:
        return []
    before, after = _answers(predictor, outcome, level, [{}, dict.fromkeys(silent, 1.0 + SILENT_STEP)])
    allowed = 1.5 * SILENT_STEP * NO_EFFECT * len(silent)
    change = abs(float(np.log(after / before)))
    return [
        judged(f"Without effect on the {outcome}: {', '.join(silent)}.",
                       f"relative change if all of them grow by {100 * SILENT_STEP:g} %", change, high=allowed,
                       expected=f"below {allowed:.1g}")
    ]  # fmt: skip


def _checks(predictor: MeasurementPredictor, rows: dict, level: float) -> list[Finding]:
    """Return what must hold: both ways agree, and the contact's scaling law."""
    worst = 0.0
    for key in (key for key in rows if key.startswith("slider.") and not predictor.needs_stator(key)):
        own = predictor.value(key)

        def family(s, key=key, own=own):
            driven = predictor.contact({key: own * float(np.exp(s))})
            return driven.slider, driven.at(level)

        slider, orbits = family(0.0)
        implicit = contact.velocity_derivative(family) / contact.mean_motion(slider, orbits).velocity
        worst = max(worst, abs(implicit - rows[key][0]))
    size = max(abs(value) for value, _ in rows.values())
    findings = [
        judged("The implicit function theorem in the averaged equilibrium and differences of the corrected "
                       "velocity agree.", "largest difference over the largest elasticity", worst / size,
                       high=AGREEMENT),
    ]  # fmt: skip
    law = [f"slider.{key}" for key in ("preload", "effective_modulus", "friction_coefficient")]
    if set(law) <= set(rows) and predictor.contact({}).scene.slider.load == 0.0:
        preload, modulus, friction = (rows[key][0] for key in law)
        total = preload + modulus - friction
        sentence = "Preload and modulus up, friction coefficient down by one factor change nothing."
        findings.append(judged(sentence, "sum of the elasticities", abs(total), high=1e-3, expected="0 to 1e-3"))
    return findings


def _in_words(data: dict) -> Iterator[tuple[str, str]]:
    """Yield what matters most to an answer, in % for 1 % of the number, and where both sides disagree."""
    rows = list(zip(*(data[name] for name in COLUMNS), strict=True))
    most = [f"{key} {value:+.3g}" for key, value, *_ in rows[:NAMED] if abs(value) >= NO_EFFECT]
    yield data["outcome"], f"% for 1 % of {', '.join(most) or 'any number: none'}"
    for key, more, less in data["bends"]:
        yield "", f"bends with {key}: {100 * more:+.3g} % for 1 % more, {100 * less:+.3g} % for 1 % less"


def _bends(more: float | None, less: float | None) -> bool:
    """Return whether 1 % more and 1 % less of a number do not make opposite changes of one size."""
    if more is None or less is None:
        return False
    return abs(more + less) > max(BENDS * max(abs(more), abs(less)), NO_EFFECT * SIDE)


def _cell(value: float | None) -> str:
    return "" if value is None else repr(value)


def tables(record: StudyRecord) -> dict[str, str]:
    """Return sensitivity.csv."""
    lines = ["outcome,key,elasticity,error,change_for_1_percent_more,change_for_1_percent_less"]
    for panel in record.panels:
        data = panel.data
        lines += [
            f"{data['outcome']},{key},{value!r},{error!r},{_cell(more)},{_cell(less)}"
            for key, value, error, more, less in zip(*(data[name] for name in COLUMNS), strict=True)
        ]
    return {"sensitivity.csv": "\n".join(lines) + "\n"}


@of_record
def figure(record: Panel, ax):
    """Draw what 1 % more and 1 % less of each number make of one answer, and its elasticity, the largest on top."""
    rows = [row for row in zip(*(record.data[name] for name in COLUMNS), strict=True) if abs(row[1]) >= NO_EFFECT]
    rows = rows[:MAX_DRAWN]
    for side, (colour, label, sign) in enumerate((("slip", "1 % more", 1), ("intermittent", "1 % less", -1))):
        changes = [100 * (row[3 + side] or 0.0) for row in rows]
        places = [k - sign * 0.18 for k in range(len(rows))]
        ax.barh(places, changes, color=COLOURS[colour], height=0.34, label=label)
    style = {"fmt": "D", "markersize": 4, "color": COLOURS["line"], "label": "elasticity"}
    ax.errorbar([row[1] for row in rows], range(len(rows)), xerr=[row[2] for row in rows], **style)
    ax.set_yticks(range(len(rows)), [row[0] for row in rows], fontsize="small")
    ax.invert_yaxis()
    ax.axvline(0.0, color=COLOURS["line"], linewidth=0.8)
    return finished(ax, f"change of the {record.data['outcome']} (%)", "", record.title)
