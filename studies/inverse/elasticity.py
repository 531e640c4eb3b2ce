"""Elasticities of a motor's answers, d ln(answer) / d ln(number), and their changes for 1 % of each number.

The origin of a coordinate, such as a position, is arbitrary: its derivative is d ln(answer) / d(coordinate), and the
change is that for one micrometre (of an angle one degree).

The derivatives are extrapolated differences, each with its error; the step is the fifth root of the accuracy of the
answer.
"""

import logging
import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

import contact
from studies.inverse.prediction import MeasurementPredictor
from studies.model.resolve import build
from studies.progress import counted
from studies.record.quantities import quantity
from studies.refusal import RunError, refuse_outside
from studies.scene.keys import coordinate
from studies.scene.override import walk
from studies.solve.requested_quantities import ALSO, keywords

LOGGER = logging.getLogger(__name__)

# Accuracy of each answer: that of rounding, or the tolerance that it is solved to. Start-up times of `twente-contact`
# solved to 1e-5 and to 1e-6 differ by up to 8e-6; those of four balls at different places cost 100 times more at 1e-6.
ACCURACY = {"velocity": 1e-11, "threshold": 1e-13, "release": 1e-13, "thrust": 1e-11, "efficiency": 1e-8,
            "start-up time": 1e-5}  # fmt: skip
ANSWERS = {
    "velocity": quantity.velocity_m_per_s, "threshold": quantity.threshold_factor,
    "release": quantity.release_factor, "thrust": quantity.thrust_N, "efficiency": quantity.contact_efficiency,
    "start-up time": quantity.start_up_time_s,
}  # fmt: skip
STATOR_ACCURACY = 1e-9  # of a stator's answers against each other on the same mesh
STATOR_STEP, PHASE_STEP = 1e-3, 2e-4  # of the logarithms of its numbers
PHASED = ("thickness", "frequency")  # their change shifts the phase of a wave, and is amplified
LIMITS = ("threshold", "release")  # as factors on the level
SIDE = 0.01  # change of a number to either side, beside its elasticity; of a coordinate its unit
# Step of a coordinate, in wavelengths or degrees. Where the derivative is 0.6 per wavelength, steps of 1/5000 to 1/500
# wavelength give the same to 4e-10; the stated error is 1e-5 of it at 1/500
LENGTH_STEP, ANGLE_STEP = 2e-3, 0.05
USUAL_WAVELENGTH = 1e-3  # m, where a [wave] states none


# Quantities that are computed accurately enough for differences where velocities are solved one by one
SMOOTH = ("ripple", "thrust", "efficiency")


def numbers(predictor: MeasurementPredictor) -> list[str]:
    """Return the keys of a scene's coordinates and positive numbers that an answer may depend on.

    Entries of lists are left out.
    """
    left_out = (".burst", ".gravity", "stator.width", "normal_amplitude", "drive.voltage")
    table = {name: block for name, block in predictor.scenes.numbers.items() if name != "uncertain"}
    floats = ((key, value) for key, value in walk(table) if isinstance(value, float))
    positive = (key for key, value in floats if value > 0.0 or coordinate(key))
    return [key for key in positive if not key.endswith(left_out) and not key.rpartition(".")[2].isdigit()]


def answers_of_slider(predictor: MeasurementPredictor) -> tuple[str, ...]:
    """Return the names of the answers that the slider has."""
    known = SMOOTH if predictor.one_by_one else ALSO
    return tuple(name for name, each in ANSWERS.items() if {*keywords([each.column])} <= {*known})


def _together(predictor: MeasurementPredictor, outcomes: Sequence[str]) -> list[tuple[float, tuple[str, ...]]]:
    """Return pairs of an accuracy and the names of the answers that have it, which are computed together."""
    known = answers_of_slider(predictor)
    refuse_outside(outcomes, known, "outcomes", " for this slider")
    groups: dict[float, list[str]] = {}
    for name in outcomes:
        groups.setdefault(ACCURACY["velocity" if predictor.one_by_one else name], []).append(name)
    return [(accuracy, tuple(names)) for accuracy, names in groups.items()]


def _keys(predictor: MeasurementPredictor, names: Iterable[str]) -> list[str]:
    """Return the keys that answers may depend on; without the level for threshold and release, its factors."""
    return [*numbers(predictor), *([] if set(names) <= set(LIMITS) else ["level"])]


def elasticities(
    predictor: MeasurementPredictor, outcomes: Sequence[str], level: float
) -> dict[str, dict[str, tuple[float, float]]]:
    """Return {outcome: {key: (d ln outcome / d ln number, its error)}}, the level itself as "level".

    Of a coordinate it is d ln outcome / d(coordinate), per metre or degree.
    ``level``: voltage in V or normal amplitude in m.
    """
    slopes: dict[str, dict[str, tuple[float, float]]] = {name: {} for name in outcomes}
    for accuracy, names in _together(predictor, outcomes):
        centre = answers_at(predictor, names, level, [{}])[0]
        for key in counted(LOGGER, ", ".join(names), _keys(predictor, names) if np.any(centre > 0.0) else ()):
            moved = key != "level" and predictor.needs_stator(key)
            within = max(accuracy, STATOR_ACCURACY if moved else 0.0)
            step = within**0.2 if not moved else PHASE_STEP if key.endswith(PHASED) else STATOR_STEP
            if coordinate(key):
                step = (
                    ANGLE_STEP if key.endswith("angle") else LENGTH_STEP * (wavelength(predictor) or USUAL_WAVELENGTH)
                )
            widths = step / np.array([1.0, 2.0] if moved else [1.0, 2.0, 4.0])
            moves = np.concatenate([widths, -widths])
            moves = moves if coordinate(key) else np.exp(moves)
            values, errors = answers_at(predictor, names, level, [{key: move} for move in moves.tolist()])
            for name, column, start in zip(names, values.T, centre[0], strict=True):
                # no derivative without an answer, such as for a value that the scene refuses
                if start > 0.0 and np.all(column > 0.0):
                    error = within if name in LIMITS else max(within, *errors)
                    slopes[name][key] = _slope(np.log(column / start), widths, error)
    return slopes


def _slope(logarithms: np.ndarray, widths: np.ndarray, accuracy: float) -> tuple[float, float]:
    """Return the derivative and its error from values at +widths and -widths, each width half of the one before."""
    up, down = np.split(logarithms, 2)
    table = ((up - down) / (2.0 * widths)).tolist()
    for power in (4.0, 16.0)[: len(table) - 1]:  # Richardson extrapolation in the square of the step
        change = (table[-1] - table[-2]) / (power - 1.0)
        table = [(power * fine - coarse) / (power - 1.0) for coarse, fine in pairwise(table)]
    return float(table[0]), float(abs(change) + 8.0 * accuracy / widths[0])


def both_sides(
    predictor: MeasurementPredictor, outcomes: Sequence[str], level: float
) -> dict[str, dict[str, tuple[float | None, float | None]]]:
    """Return {outcome: {key: relative change for 1 % more and 1 % less of the number}}; None where it has none.

    Of a coordinate it is the change for one micrometre, or one degree, more and less.
    """
    sides: dict[str, dict[str, tuple[float | None, float | None]]] = {name: {} for name in outcomes}
    for _, names in _together(predictor, outcomes):
        keys = _keys(predictor, names)
        moves = [{key: move} for key in keys for move in _sides(key)]
        centre, *values = answers_at(predictor, names, level, [{}, *moves])[0]
        for name, start, column in zip(names, centre, np.transpose(values), strict=True):
            changes = [float(each / start - 1.0) if math.isfinite(each) else None for each in column]
            sides[name] = dict(zip(keys, zip(changes[0::2], changes[1::2], strict=True), strict=True))
    return sides


def _sides(key: str) -> tuple[float, float]:
    """Return what `answers_at` takes for a change of a number to either side."""
    unit = coordinate(key)
    return (1.0 + SIDE, 1.0 - SIDE) if unit is None else (unit[1], -unit[1])


def wavelength(predictor: MeasurementPredictor) -> float | None:
    """Return the length of the surface wave in m, that of a stator under a bare surface; None if a [wave] has none."""
    scene = predictor.scene({})
    if scene.stator is None:
        return scene.wave.wavelength if scene.wave else None
    return build(scene).wavelength


def answers_at(
    predictor: MeasurementPredictor, names: Sequence[str], level: float, many: list[dict[str, float]]
) -> tuple[np.ndarray, np.ndarray]:
    """Return answers for m sets of moves by key, (m, n), and the numerical errors of the velocities over |v|, (m,).

    A move is a factor, of a coordinate a shift in m or degrees.  "level" may be among the keys.  An answer is NaN where
    the scene refuses a value; an averaged state has no numerical error.  A stator that cannot be solved raises
    RunError, so that no number is left out unnoticed.
    """
    columns = [ANSWERS[name].column for name in names]
    level_key = predictor.scene({}).level_key
    changes = [
        {key: _moved(predictor, key, move) for key, move in moves.items() if key != "level"}
        | {level_key: level * moves.get("level", 1.0)}
        for moves in many
    ]
    answers = predictor.answers(changes, keywords(columns), tolerance=ACCURACY[names[0]], averaged=True)
    errors = np.zeros(len(answers))
    for k, answer in enumerate(answers):
        if not (answer.point.answered or answer.refused):
            raise RunError(answer.point.status)
        velocity = answer.point.velocity_m_per_s
        if not answer.averaged and answer.from_contact and velocity:
            orbits = predictor.contact(changes[k]).at(level)
            errors[k] = answer.from_contact * contact.reference_speed(velocity, orbits) / abs(velocity)
    return np.abs([[answer.point.get(column, math.nan) for column in columns] for answer in answers]), errors


def _moved(predictor: MeasurementPredictor, key: str, move: float) -> float:
    """Return the value of a key after a move as in `answers_at`."""
    value = float(predictor.value(key) or 0.0)
    return value * move if coordinate(key) is None else value + move
