"""Sensitivity of the motor to its parameters: elasticities of velocity, limits, thrust, efficiency and start-up time.

Method: d ln(answer) / d ln(parameter) for every positive parameter of the resolved scene (a preload of "weight"
follows the mass, and is a number itself), at the largest voltage or amplitude. The derivatives are extrapolated
differences, each with its error; the step is the fifth root of the accuracy of the answer. The origin of a position is
arbitrary: its sensitivity is stated per micrometre and per wavelength, that of an angle per degree. Of a slider on
pillars, velocity, thrust and efficiency are known. For balls, the elasticities of the velocity are also computed by the
implicit function theorem in the averaged equilibrium. Start-up times are those of the averaged motion, because a
difference of two exact starts would take 100 times as long. The study also states the change of the answer for 1 % more
and 1 % less of the parameter. Near a resonance, or where the phase of a wave changes, these differ from the elasticity
and from each other, and the study says so. Parameters of the stator take six solutions each, with an accuracy of 1e-2.
Expected: both methods agree to a few (f_n/f)^2; the elasticities satisfy the scaling law of the contact, preload + E* -
friction coefficient = 0; a common change of all parameters without effect changes nothing. Run time: 10 s; for twente
with its stator 90 s of one processor.
"""

import csv
import io
from collections.abc import Iterator

import numpy as np

import contact
from studies.inverse.elasticity import (
    SIDE,
    answers_at,
    answers_of_slider,
    both_sides,
    elasticities,
    numbers,
    wavelength,
)
from studies.inverse.prediction import MeasurementPredictor
from studies.model.pillars import layout
from studies.record.plots import COLOURS, finished
from studies.record.quantities import quantity
from studies.report.explanation import plan
from studies.scene import Scene
from studies.scene.keys import coordinate
from studies.study_list import Answered, Finding, Panel, StudyRecord, judged, of_record, refuse_freedom, study

QUICK = {"outcomes": ("velocity",)}
NO_EFFECT = 1e-4  # elasticity below which a number is said to have none
COLUMNS = ("key", "elasticity", "error", "change_for_1_percent_more", "change_for_1_percent_less")
# of coordinates, for which those of COLUMNS but the key are empty
COORDINATE_COLUMNS = (
    "unit", "change_per_unit", "error_per_unit", "change_for_1_unit_more", "change_for_1_unit_less",
    "change_per_wavelength",
)  # fmt: skip
NAMED, MAX_DRAWN = 4, 14  # numbers in the answer's line, and in the picture
BENDS = 0.2  # difference of both sides, over the larger, from which an answer counts as nonlinear
SILENT_STEP = 0.02  # by which the numbers without effect are changed together
AGREEMENT = 1e-2  # of both methods, over the largest elasticity
# Evaluations for a number, and for a number of the stator: for the elasticity, and with 1 % more and less
MOVES, STATOR_MOVES = 8, 6
# CPU seconds of an evaluation with balls, with pillars, with each pillar, and of the rest of the study (one x86_64 core
# of 2026)
BALLS_SECONDS, PILLARS_SECONDS, PILLAR_SECONDS, OTHER_SECONDS = 0.1, 0.2, 1e-4, 4.0


@study("twente-contact")
def run(scene: Scene, *, outcomes: str | tuple[str, ...] | None = None, tolerance: float = 1e-2) -> Answered:
    """Return the elasticities of a motor.

    Parameters
    ----------
    outcomes : str or tuple of str, optional
        Of velocity, threshold, release, thrust, efficiency and start-up time; by default all that the slider has.
    tolerance : float
        Of the velocity, for the stator.
    """
    if scene.slider is None:
        scene.refuse("slider", "is missing: this study needs a slider")
    predictor = MeasurementPredictor(scene, tolerance=tolerance)
    level = max(predictor.contact({}).scene.levels)
    outcomes = answers_of_slider(predictor) if outcomes is None else outcomes
    outcomes = (outcomes,) if isinstance(outcomes, str) else outcomes
    if predictor.scene({}).planar and set(outcomes) != {"velocity"}:
        refuse_freedom(predictor.scene({}))
    slopes = elasticities(predictor, outcomes, level)
    changes = both_sides(predictor, tuple(name for name, by_key in slopes.items() if by_key), level)
    title, findings, panels = predictor.scenes.table.get("title", ""), [], []
    for name, by_key in slopes.items():
        findings += without_effect(predictor, name, by_key, level)
        sides = changes.get(name, {})
        order = sorted((key for key in by_key if not coordinate(key)), key=lambda key: -abs(by_key[key][0]))
        columns = zip(*((key, *by_key[key], *sides[key]) for key in order), strict=True)
        data = dict.fromkeys(COLUMNS, ()) | dict(zip(COLUMNS, columns, strict=False))
        data["coordinates"] = _of_coordinates(predictor, by_key, sides)
        bends = [[key, *side] for key, side in sides.items() if _bends(*side)]
        panels.append(
            Panel(name=name.replace(" ", "_").replace("-", "_"), title=f"{title}: {name}",
                  data=data | {"bends": bends, "level": level, "outcome": name})
        )  # fmt: skip
    if "velocity" in slopes and not predictor.one_by_one:
        findings += _checks(predictor, slopes["velocity"], level)
    return panels, findings, [line for panel in panels for line in _in_words(panel.data)]


def _of_coordinates(predictor: MeasurementPredictor, slopes: dict, sides: dict) -> list[list]:
    """Return a row of the key and ``COORDINATE_COLUMNS`` for each coordinate, the most sensitive first."""
    rows = []
    for key, (slope, error) in slopes.items():
        unit = coordinate(key)
        if unit is not None:
            name, size = unit
            length = None if key.endswith("angle") else wavelength(predictor)
            row = [key, name, slope * size, error * size, *sides[key], None if length is None else slope * length]
            rows.append(row)
    return sorted(rows, key=lambda row: -abs(row[2]))


def expected_seconds(scene: Scene) -> float:
    """Return about how long the study takes for a scene, s: the stator's solutions, and the contact's answers."""
    predictor = MeasurementPredictor(scene)
    stator = plan(scene, tolerance=1e-2)["expected"]["stator_seconds"] if scene.transducer else 0.0
    keys = numbers(predictor)
    moved = sum(predictor.needs_stator(key) for key in keys)
    point = BALLS_SECONDS
    if predictor.one_by_one:
        point = PILLARS_SECONDS + PILLAR_SECONDS * layout(predictor.scene({}).slider).x.size
    return OTHER_SECONDS + STATOR_MOVES * moved * (stator + point) + MOVES * (len(keys) + 1 - moved) * point


def without_effect(predictor: MeasurementPredictor, outcome: str, slopes: dict, level: float) -> list[Finding]:
    """Return the finding on the numbers that have no effect: what happens if all of them change together."""
    known = ((key, value) for key, (value, _) in slopes.items() if key != "level" and not coordinate(key))
    silent = [key for key, value in known if abs(value) < NO_EFFECT]
    if not silent:
        return []
    (before, after), _ = answers_at(predictor, (outcome,), level, [{}, dict.fromkeys(silent, 1.0 + SILENT_STEP)])
    allowed = 1.5 * SILENT_STEP * NO_EFFECT * len(silent)
    change = abs(float(np.log(after[0] / before[0])))
    return [
        judged(f"Without effect on the {outcome}: {', '.join(silent)}.",
               f"relative change if all of them grow by {100 * SILENT_STEP:g} %", change, high=allowed,
               expected=f"below {allowed:.1g}")
    ]  # fmt: skip


def _checks(predictor: MeasurementPredictor, slopes: dict, level: float) -> list[Finding]:
    """Return the findings on the velocity: both methods agree, and the contact's scaling law holds."""
    worst = 0.0
    own_keys = [key for key in slopes if key.startswith("slider.") and not coordinate(key)]
    for key in (key for key in own_keys if not predictor.needs_stator(key)):
        own = predictor.value(key)

        def family(s, key=key, own=own):
            driven = predictor.contact({key: own * float(np.exp(s))})
            return driven.slider, driven.at(level)

        slider, orbits = family(0.0)
        implicit = contact.velocity_derivative(family) / contact.mean_motion(slider, orbits).velocity
        worst = max(worst, abs(implicit - slopes[key][0]))
    size = max(abs(value) for key, (value, _) in slopes.items() if not coordinate(key))
    findings = [
        judged("The implicit function theorem in the averaged equilibrium and differences of the corrected velocity "
               "agree.", "largest difference over the largest elasticity", worst / size, high=AGREEMENT),
    ]  # fmt: skip
    law = [f"slider.{key}" for key in ("preload", "effective_modulus", "friction_coefficient")]
    if set(law) <= set(slopes) and predictor.contact({}).scene.slider.load == 0.0:
        preload, modulus, friction = (slopes[key][0] for key in law)
        sentence = "Preload and modulus up, friction coefficient down by one factor change nothing."
        total = abs(preload + modulus - friction)
        findings.append(judged(sentence, "sum of the elasticities", total, high=1e-3, expected="0 to 1e-3"))
    return findings


def _in_words(data: dict) -> Iterator[tuple[str, str]]:
    """Yield lines with the largest elasticities of an answer, and with the numbers in which it is nonlinear."""
    largest = [f"{key} {value:+.3g}" for key, value, *_ in _rows(data)[:NAMED] if abs(value) >= NO_EFFECT]
    yield data["outcome"], f"% for 1 % of {', '.join(largest) or 'any number: none'}"
    units = {}
    for key, unit, slope, _, _, _, per_wavelength in data["coordinates"][:NAMED]:
        share = "" if per_wavelength is None else f" ({per_wavelength:+.3g} times its size per wavelength)"
        yield "", f"{100 * slope:+.3g} % for 1 {unit} of {key}{share}"
        units[key] = f"1 {unit}"
    for key, more, less in data["bends"]:
        unit = units.get(key, "1 %")
        yield "", f"bends with {key}: {100 * more:+.3g} % for {unit} more, {100 * less:+.3g} % for {unit} less"


def _bends(more: float | None, less: float | None) -> bool:
    """Return whether the changes for 1 % more and for 1 % less of a number differ in size."""
    if more is None or less is None:
        return False
    return abs(more + less) > max(BENDS * max(abs(more), abs(less)), NO_EFFECT * SIDE)


def _rows(data: dict) -> list[tuple]:
    """Return the rows of a panel's ``COLUMNS``, one for each number."""
    return list(zip(*(data[name] for name in COLUMNS), strict=True))


def tables(record: StudyRecord) -> dict[str, str]:
    """Return sensitivity.csv."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("outcome", *COLUMNS, *COORDINATE_COLUMNS))
    for panel in record.panels:
        outcome = panel.data["outcome"]
        writer.writerows((outcome, *row, *[""] * len(COORDINATE_COLUMNS)) for row in _rows(panel.data))
        for key, *row in panel.data["coordinates"]:
            writer.writerow((outcome, key, *[""] * (len(COLUMNS) - 1), *row))
    return {"sensitivity.csv": text.getvalue()}


@of_record
def figure(record: Panel, ax):
    """Draw what 1 % more and 1 % less of each number make of one answer, and its elasticity, the largest on top."""
    rows = [(key, value, error, *sides) for key, value, error, *sides in _rows(record.data) if abs(value) >= NO_EFFECT]
    coordinates = [
        (f"{key}, 1 {unit}", 100 * slope, 100 * error, more, less)
        for key, unit, slope, error, more, less, _ in record.data["coordinates"]
    ]
    rows = sorted([*rows, *coordinates], key=lambda row: -abs(row[1]))[:MAX_DRAWN]
    more_and_less = (("slip", "1 %, 1 um or 1 deg more", 1), ("intermittent", "1 %, 1 um or 1 deg less", -1))
    for side, (colour, label, sign) in enumerate(more_and_less):
        changes = [100 * (row[3 + side] or 0.0) for row in rows]
        positions = [k - sign * 0.18 for k in range(len(rows))]
        label = label if coordinates else label.replace(", 1 um or 1 deg", "")
        ax.barh(positions, changes, color=COLOURS[colour], height=0.34, label=label)
    style = {"fmt": "D", "markersize": 4, "color": COLOURS["line"], "label": "first order"}
    ax.errorbar([row[1] for row in rows], range(len(rows)), xerr=[row[2] for row in rows], **style)
    ax.set_yticks(range(len(rows)), [row[0] for row in rows], fontsize="small")
    ax.invert_yaxis()
    ax.axvline(0.0, color=COLOURS["line"], linewidth=0.8)
    return finished(ax, f"change of the {record.data['outcome']} ({quantity.change.shown})", "", record.title)
