"""Numbers of a motor from measured curves: estimates, intervals, and what the data do not determine.

Weighted least squares (`least_squares`), profile likelihood intervals (`profile`), undetermined directions by scaled
singular values (`directions`) and by profiles that stay open.  A number in an undetermined direction has no interval.
Source: Raue et al., Structural and practical identifiability analysis by exploiting the profile likelihood,
Bioinformatics 25 (2009) 1923.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fem.parameters import refuses
from studies.inverse.directions import Direction, direction, undetermined
from studies.inverse.fit_result import Fit
from studies.inverse.free_parameters import (
    AMPLITUDE_FACTOR,
    AMPLITUDE_PER_VOLT,
    Parameter,
    as_measurements,
    as_parameters,
)
from studies.inverse.least_squares import CLEARLY, Minimum, Problem, standard_deviations
from studies.inverse.next_measurement import ranked
from studies.inverse.prediction import MeasurementPredictor
from studies.inverse.profile import BetterMinimumError, End, allowed_excess, profile
from studies.inverse.ties import Ties, is_of_scene, refuse_names
from studies.lab.measurement import FIELD, Measurement
from studies.lab.measurement_csv import measured_scan
from studies.model.model import Model
from studies.progress import reported_to
from studies.refusal import RunError, SceneError, all_answers, refuse_if
from studies.scene import Scene
from studies.scene.keys import LEVELS
from studies.solve.scan_prediction import placed, refuse_other_range

FIRST_STEP = 1.96  # standard deviations to the expected end of an interval
MAX_ATTEMPTS = 4  # a profile may reach a lower minimum; the fit is then repeated about that one


def fit(
    scene: Scene | str | Path,
    measurements: Measurement | str | Path | list,
    parameters: list | dict,
    *,
    tolerance: float = 1e-3,
    next_measurements: bool | None = None,
    progress: Callable[[str], None] | None = None,
) -> Fit:
    """Fit free numbers of a scene to measurements.

    Parameters
    ----------
    scene : Scene, str or Path
        With a slider, and a [wave] or a driven stator.
    measurements : Measurement, path or list of them
        Measured curves, or the CSV files that hold them.
    parameters : list, dict or lmfit.Parameters
        `Parameter` objects or texts ``"slider.preload=1 mN:5 mN"``, or a dict of a key's range; one without ``vary``
        is held at its value, and one of lmfit's with ``expr`` follows the others.
    tolerance : float
        Of the velocity, for the stator.
    next_measurements : bool, optional
        Whether further measurements are ranked; by default not for a slider on pillars or in the plane, whose motions
        are solved one by one.
    progress : callable, optional
        Called with a few words about each step, as it is logged.

    Raises
    ------
    SceneError
        If a key is no free number of this scene, or the measurements do not fit together.
    RunError
        If the motor has no answer at the best fit.

    Examples
    --------
    >>> from studies import Measurement, fit
    >>> levels = (2e-9, 5e-9, 1e-8, 2e-8)
    >>> curve = Measurement(name="lab", quantity="velocity", level_key="normal_amplitude_m", levels=levels,
    ...                     values=(0.0058, 0.0280, 0.0693, 0.1520), deviations=(1e-3,) * 4)
    >>> result = fit("twente-contact", curve, {"wave.tangential_ratio": (0.3, 1.5)})
    >>> low, high = result.intervals["wave.tangential_ratio"]
    >>> low < 0.7 < high
    True
    >>> ratio = result.params["wave.tangential_ratio"]
    >>> ratio.vary, 0.69 < ratio.value < 0.71, 0 < ratio.stderr < 0.01
    (True, True, True)
    """
    with reported_to(progress):
        problem, fixed, estimated = prepared(scene, measurements, parameters, tolerance=tolerance)
        free = problem.parameters
        problem = replace(problem, measurements=_signed(problem))
        if next_measurements is None:
            next_measurements = not problem.predictor.costly
        degrees = problem.points - len(free)
        refuse_if(
            degrees < (1 if estimated else 0),
            "parameters",
            f"asks for {len(free)} numbers from {problem.points} measured values",
        )
        minima = problem.minima()
        for _ in range(MAX_ATTEMPTS):
            try:
                return replace(fit_about(problem, minima, degrees, estimated, next_measurements), fixed=fixed)
            except BetterMinimumError as better:
                minima = [problem.minimum(better.x), *minima]
        raise RunError(
            "the fit has several minima, none of which is clearly the lowest: narrow the ranges of the parameters"
        )


def prepared(
    scene: Scene | str | Path,
    measurements: Measurement | str | Path | list,
    parameters: list | dict,
    *,
    tolerance: float,
) -> tuple[Problem, tuple[Parameter, ...], bool]:
    """Return the problem of a fit, the parameters held at their values, and True if the deviations are estimated."""
    readers = (partial(Scene.load, scene), partial(as_measurements, measurements), partial(as_parameters, parameters))
    loaded, curves, free_and_fixed = all_answers(readers)
    predictor = MeasurementPredictor(loaded, tolerance=tolerance)
    free, fixed = (tuple(each for each in free_and_fixed if each.vary == vary) for vary in (True, False))
    for each in fixed:
        if each.value is None:
            raise SceneError(f"parameters {each.key}", "is held, and needs a value")
    ties = Ties(parameters)
    values = {each.key: each.value for each in fixed if is_of_scene(each.key)}
    curves = [replace(each, settings=values | each.settings) for each in curves]
    _refuse(predictor, curves, free)
    refuse_names(ties, free_and_fixed)
    curves = [_as_predicted(predictor, each) for each in curves]
    curves, estimated = _weighted(curves)
    problem = Problem(predictor=predictor, parameters=free, measurements=tuple(curves), ties=ties)
    return problem, fixed, estimated


def _as_predicted(predictor: MeasurementPredictor, measurement: Measurement) -> Measurement:
    """Return a scan as the displacements that are predicted: of its line at the drive's frequency, and in m per V."""
    if measurement.scan is None:
        return measurement
    settings = {key: value for key, value in measurement.settings.items() if "." in key}
    scan = measurement.scan.at_line(frequency := predictor.scene(settings).frequency, "measurements")
    if scan is measurement.scan and scan.motion == "displacement":
        return measurement
    displacements = measured_scan(scan.as_displacement(frequency), "measurements")
    return replace(displacements, systematic=measurement.systematic, settings=measurement.settings)


def fit_about(problem: Problem, minima: list[Minimum], degrees: int, estimated: bool, next_measurements: bool) -> Fit:
    """Return the fit about the least of its minima, which is the first of them.

    ``degrees``: of freedom; ``estimated``: True if the scatter of the measurements is estimated from the residuals;
    ``next_measurements``: True ranks further measurements.
    """
    if estimated:
        scale = math.sqrt(minima[0][1] / degrees) or 1e-9  # not 0 if the fit is exact
        problem = replace(problem, measurements=tuple(each.scattered(scale) for each in problem.measurements))
        minima = [(x, squares / scale**2) for x, squares in minima]
        if problem.systematic:  # a systematic error does not scale with the scatter
            minima = sorted((problem.minimum(x) for x, _ in minima), key=lambda each: each[1])
    (best, least), *others = minima  # best: x, the parameters in the solver's variables, then the systematic errors
    jacobian = problem.jacobian(best)
    directions = undetermined(jacobian, problem.parameters, problem.half_width)
    best = _nearest(problem, best, least, directions)
    without_interval = {key for each in directions for key in each.components}
    information = problem.information(jacobian)
    covariance = np.linalg.inv(information)
    allowed = allowed_excess(degrees if estimated else None)
    rivals = [(x, squares) for x, squares in others if squares - least < allowed]
    ends: dict[str, tuple[End | None, End | None]] = {}
    for j, parameter in enumerate(problem.parameters):
        problem.predictor.begin(f"fit: interval of {parameter.key}")
        if parameter.key in without_interval:
            ends[parameter.key] = (None, None)
            continue
        step = FIRST_STEP * math.sqrt(covariance[j, j])
        lower, upper = (_outermost(problem, [(best, least), *rivals], j, sign, step, allowed) for sign in (-1.0, 1.0))
        ends[parameter.key] = lower, upper
    directions += _open_directions(problem, best, ends)
    candidates = None
    if next_measurements:
        problem.predictor.begin("fit: next measurements")
        candidates = tuple(ranked(problem, best, information))
    return Fit(
        problem=problem, inner=best, chi2=least, degrees_of_freedom=degrees, ends=ends,
        deviation=problem.measurements[0].deviations[0] if estimated else None,
        directions=tuple(directions), rivals=tuple(problem.numbers(x) for x, _ in rivals), covariance=covariance,
        candidates=candidates, informs=_informed(problem, jacobian),
    )  # fmt: skip


def _informed(problem: Problem, jacobian: np.ndarray) -> tuple[tuple[str, dict[str, float]], ...]:
    """Return, for each measurement, how many times it alone narrows each number: 1 if it tells nothing.

    That is half the width of the number's range over the standard deviation that this measurement would leave, with
    the range as a weak prior.
    """
    ends, informs = np.cumsum([len(each.values) for each in problem.measurements]), []
    for each, rows in zip(problem.measurements, np.split(jacobian, ends)[: len(ends)], strict=True):
        gains = problem.half_width / standard_deviations(problem.information(rows))
        informs.append((each.name, {p.key: float(gains[k]) for k, p in enumerate(problem.parameters)}))
    return tuple(informs)


def _outermost(problem: Problem, minima: list[Minimum], j: int, sign: float, step: float, allowed: float) -> End:
    """Return the end of the interval of parameter number j, downwards (``sign`` -1) or upwards (+1).

    Each minimum that the data do not rule out has its own interval: the outermost end is taken, or one that is open.
    """
    least = minima[0][1]
    profiles = [profile(problem, each, least, j, sign=sign, step=step, allowed=allowed) for each in minima]
    return min(profiles, key=lambda end: (end.closed, -sign * end.x[j]))


def _nearest(problem: Problem, best: np.ndarray, least: float, directions: list[Direction]) -> np.ndarray:
    """Return the minimum nearest to the scene's own values, along directions of no effect.

    The step towards the scene's values is projected on these directions. If it raises the sum of squares clearly, for
    instance because a range cuts it off, the minimum stays where it is.
    """
    exact = [[each.components.get(p.key, 0.0) for p in problem.parameters] for each in directions if each.exact]
    if not exact:
        return best
    basis = np.linalg.qr(np.array(exact).T)[0]
    count, moved = len(problem.parameters), best.copy()  # behind the parameters: systematic errors of the measurements
    scene_values = [p.start(problem.predictor.value(p.key)) for p in problem.parameters]
    moved[:count] -= basis @ (basis.T @ (best[:count] - scene_values))
    moved = np.clip(moved, problem.low, problem.high)
    return moved if np.sum(problem.residuals([moved])[0] ** 2) <= least + CLEARLY * max(1.0, least) else best


def _open_directions(
    problem: Problem, best: np.ndarray, ends: dict[str, tuple[End | None, End | None]]
) -> list[Direction]:
    """Return the directions in which a profile reached the end of a range and stayed open.

    Each parameter adds at most one, and none that combines the same parameters as another.
    """
    directions: dict[frozenset[str], Direction] = {}
    for pair in ends.values():
        changes = [(end.x - best)[: len(problem.parameters)] for end in pair if end is not None and not end.closed]
        for change in [each for each in changes if np.any(each)][:1]:
            open_direction = direction(change, problem.parameters, exact=False)
            directions.setdefault(frozenset(open_direction.components), open_direction)
    return list(directions.values())


def _refuse(
    predictor: MeasurementPredictor, measurements: list[Measurement], parameters: tuple[Parameter, ...]
) -> None:
    """Raise one error with all reasons why these parameters of this scene cannot be fitted to these measurements."""
    by_key = {each.key: each for each in parameters}

    @refuses(SceneError)
    def check_number() -> Iterator[Any]:
        if not measurements:
            yield "measurements", "is required: a CSV file of measured points"
        if not parameters:
            yield "parameters", "is required: KEY=LOW:HIGH"

    @refuses(SceneError)
    def check_measurement(each: Measurement) -> Iterator[Any]:
        if each.quantity not in FIELD and not predictor.slider:
            yield f"measurements {each.name}", "needs a scene with a [slider], which moves"
        if each.network is not None and not predictor.prescribed_wave:
            refuse_other_range(Model(predictor.scene({})), each.network, "measurements")
        if each.scan is not None:
            placed(predictor.scene({}), each.scan, "measurements")

    @refuses(SceneError)
    def check_parameter(key: str) -> Iterator[Any]:
        if sum(each.key == key for each in parameters) > 1:
            yield f"parameters {key}", "is given twice"
        if key in LEVELS:
            yield f"parameters {key}", "follows from each measured point and cannot be free"
        if key == AMPLITUDE_FACTOR and predictor.prescribed_wave:
            yield f"parameters {key}", "needs a [stator]; of a scene with a [wave] free amplitude_per_volt"
        if key == AMPLITUDE_PER_VOLT and not predictor.prescribed_wave:
            yield f"parameters {key}", "needs a [wave]; of a scene with a [stator] free amplitude_factor"
        if "." in key:  # both ends of the range must be values that the scene allows
            for end in (by_key[key].low, by_key[key].high):
                predictor.scene({key: end})

    each_measurement = [partial(check_measurement, each) for each in measurements]
    all_answers([check_number, *each_measurement, *(partial(check_parameter, key) for key in by_key)])


def _weighted(measurements: list[Measurement]) -> tuple[list[Measurement], bool]:
    """Return the measurements with standard deviations, and True if the residuals determine their common factor."""
    known = [each.deviations is not None for each in measurements]
    if all(known):
        return measurements, False
    refuse_if(
        any(known) or len({each.quantity for each in measurements}) > 1,
        "measurements",
        "must state standard deviations in every file, or in none and all of one quantity",
    )
    size = float(np.sqrt(np.mean(np.square(np.concatenate([each.values for each in measurements])))))
    refuse_if(size == 0.0, "measurements", "holds nothing but zeros, and no standard deviations")
    return [replace(each, deviations=(0.01 * size,) * len(each.values)) for each in measurements], True


def _signed(problem: Problem) -> tuple[Measurement, ...]:
    """Return the measurements; speeds without a sign take that of the predicted velocity."""
    # the sign is that of the sum over up to eight starting points
    predicted, signed = problem.predictions(problem.starts()[:8]), []
    for k, each in enumerate(problem.measurements):
        is_speed = each.quantity in ("velocity", "mean velocity", "burst", "position") and min(each.values) >= 0.0
        reverse = is_speed and np.nansum([values[k] for values in predicted]) < 0.0
        signed.append(replace(each, values=tuple(-value for value in each.values)) if reverse else each)
    return tuple(signed)
