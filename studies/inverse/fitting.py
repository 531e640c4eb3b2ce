"""Numbers of a motor from measured curves: estimates, intervals that can be trusted, and what the data cannot tell.

Weighted least squares (`least_squares`), profile likelihood intervals (`profile`), undetermined directions by scaled
singular values (`directions`) and by profiles that stay open.  A number in an undetermined direction has no interval.
Source: Raue et al., Structural and practical identifiability analysis by exploiting the profile likelihood,
Bioinformatics 25 (2009) 1923.
"""

import logging
import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from studies.chain.scan_prediction import placed, refuse_other_range
from studies.inverse.directions import Direction, direction, undetermined
from studies.inverse.least_squares import CLEARLY, Problem, standard_deviations
from studies.inverse.next_measurement import ranked
from studies.inverse.parameters import AMPLITUDE_FACTOR, AMPLITUDE_PER_VOLT, Parameter, as_measurements, as_parameters
from studies.inverse.prediction import MeasurementPredictor
from studies.inverse.profile import BetterMinimumError, End, allowed_excess, profile
from studies.inverse.result import Fit
from studies.lab.measurement import FIELD, Measurement
from studies.progress import reported_to
from studies.refusal import RunError, SceneError, all_answers
from studies.scene import Scene

LOGGER = logging.getLogger(__name__)
FIRST_STEP = 1.96  # standard deviations to the expected end of an interval
MAX_ATTEMPTS = 4  # a profile may come to a better minimum, about which the fit is then made again


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
        `Parameter` objects or texts ``"slider.preload=1 mN:5 mN"``, or a dict of a key's range; one that does not
        ``vary`` is held at its value.
    tolerance : float
        Of the velocity, for the stator.
    next_measurements : bool, optional
        Whether further measurements are ranked; by default not for a slider on pillars, whose motions are solved one by
        one.
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
            next_measurements = not problem.predictor.one_by_one
        degrees = problem.points - len(free)
        if degrees < (1 if estimated else 0):
            raise SceneError("parameters", f"asks for {len(free)} numbers from {problem.points} measured values")
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
    """Return the problem of a fit, the parameters that are held, and whether the deviations are to be estimated."""
    readers = (partial(Scene.load, scene), partial(as_measurements, measurements), partial(as_parameters, parameters))
    loaded, curves, wanted = all_answers(readers)
    predictor = MeasurementPredictor(loaded, tolerance=tolerance)
    fixed = tuple(each for each in wanted if not each.vary)
    for each in fixed:
        if each.value is None:
            raise SceneError(f"parameters {each.key}", "is held, and needs a value")
    held = {each.key: each.value for each in fixed}
    curves = [replace(each, settings=held | each.settings) for each in curves]
    free = tuple(each for each in wanted if each.vary)
    _refuse(predictor, curves, free)
    curves, estimated = _weighted(curves)
    return Problem(predictor=predictor, parameters=free, measurements=tuple(curves)), fixed, estimated


def fit_about(problem: Any, minima: Any, degrees: int, estimated: bool, next_measurements: bool) -> Fit:
    """Return the fit about its least minimum: directions, profiles and, if asked for, next measurements.

    ``minima``: pairs (x, sum of squares), the least first, x as in `least_squares.Problem`; ``degrees``: of freedom;
    ``estimated``: True if the scatter of the measurements is estimated from the residuals.
    """
    if estimated:
        scale = math.sqrt(minima[0][1] / degrees) or 1e-9  # not 0 if the fit is exact
        problem = replace(problem, measurements=tuple(each.scattered(scale) for each in problem.measurements))
        minima = [(x, squares / scale**2) for x, squares in minima]
        if problem.systematic:  # what is known of them does not scale with the scatter
            minima = sorted((problem.minimum(x) for x, _ in minima), key=lambda each: each[1])
    (best, least), *others = minima
    slopes = problem.jacobian(best)
    directions = undetermined(slopes, problem.parameters, problem.half_width)
    best = _nearest(problem, best, least, directions)
    lost = {key for each in directions for key in each.components}
    information = problem.information(slopes)
    covariance = np.linalg.inv(information)
    allowed = allowed_excess(degrees if estimated else None)
    rivals = [(x, squares) for x, squares in others if squares - least < allowed]
    ends: dict[str, tuple[End | None, End | None]] = {}
    for j, parameter in enumerate(problem.parameters):
        problem.predictor.begin(f"fit: interval of {parameter.key}")
        step = FIRST_STEP * math.sqrt(covariance[j, j])
        if parameter.key in lost:
            ends[parameter.key] = (None, None)
            continue
        lower, upper = (_outermost(problem, [(best, least), *rivals], j, sign, step, allowed) for sign in (-1.0, 1.0))
        ends[parameter.key] = lower, upper
    directions += _open_directions(problem, best, ends, lost)
    candidates = None
    if next_measurements:
        problem.predictor.begin("fit: next measurements")
        candidates = tuple(ranked(problem, best, information))
    return Fit(
        problem=problem, inner=best, chi2=least, degrees_of_freedom=degrees, ends=ends,
        deviation=problem.measurements[0].deviations[0] if estimated else None,
        directions=tuple(directions), rivals=tuple(problem.numbers(x) for x, _ in rivals), covariance=covariance,
        candidates=candidates, informs=_informed(problem, slopes),
    )  # fmt: skip


def _informed(problem: Problem, slopes: Any) -> tuple[tuple[str, dict[str, float]], ...]:
    """Return, for each measurement, how far it alone narrows each number.

    That is half the width of the number's range over the standard deviation that this measurement would leave.
    """
    ends, shares = np.cumsum([len(each.values) for each in problem.measurements]), []
    for each, rows in zip(problem.measurements, np.split(slopes, ends)[: len(ends)], strict=True):
        own = standard_deviations(problem.information(rows))
        gains = {p.key: float(problem.half_width[k] / own[k]) for k, p in enumerate(problem.parameters)}
        shares.append((each.name, gains))
    return tuple(shares)


def _outermost(problem: Any, minima: Any, j: int, sign: float, step: float, allowed: float) -> End:
    """Return the end of the interval of parameter number j, downwards (``sign`` -1) or upwards (+1).

    Each minimum that the data do not rule out has an end: the outermost counts, and before all others one at which the
    profile stays open.
    """
    least = minima[0][1]
    profiles = [profile(problem, each, least, j, sign=sign, step=step, allowed=allowed) for each in minima]
    return min(profiles, key=lambda end: (end.closed, -sign * end.x[j]))


def _nearest(problem: Problem, best: Any, least: Any, directions: Any) -> np.ndarray:
    """Return the minimum nearest to the scene's own values, along directions of no effect.

    The step towards the scene's values is projected on these directions. If it raises the sum of squares clearly, for
    instance because a range cuts it off, the minimum stays where it is.
    """
    without_effect = [
        [each.components.get(p.key, 0.0) for p in problem.parameters] for each in directions if each.exact
    ]
    if not without_effect:
        return best
    basis = np.linalg.qr(np.array(without_effect).T)[0]
    count, moved = len(problem.parameters), best.copy()  # behind the parameters: systematic errors of the measurements
    scene_values = [p.start(problem.predictor.value(p.key)) for p in problem.parameters]
    moved[:count] -= basis @ (basis.T @ (best[:count] - scene_values))
    moved = np.clip(moved, problem.low, problem.high)
    return moved if np.sum(problem.residuals([moved])[0] ** 2) <= least + CLEARLY * max(1.0, least) else best


def _open_directions(problem: Any, best: Any, ends: Any, lost: Any) -> list[Direction]:
    """Return the directions along which a profile went on to the end of a range without making an interval.

    Each parameter that is not in ``lost`` adds at most one, and none that combines the same parameters as another.
    """
    directions: list[Direction] = []
    stated = set(lost)
    for key, pair in ends.items():
        for end in pair:
            if end is None or end.closed or key in stated:
                continue
            moved = (end.x - best)[: len(problem.parameters)]
            if np.max(np.abs(moved)) > 0.0:
                open_direction = direction(moved, problem.parameters, exact=False)
                stated.add(key)
                if all(open_direction.components.keys() != each.components.keys() for each in directions):
                    directions.append(open_direction)
    return directions


def _refuse(predictor: MeasurementPredictor, measurements: Any, parameters: Any) -> None:
    """Refuse what this scene cannot be fitted to or by; one error carries the faults of all of them."""
    by_key = {each.key: each for each in parameters}

    def check_number() -> None:
        if not measurements:
            raise SceneError("measurements", "is required: a CSV file of measured points")
        if not parameters:
            raise SceneError("parameters", "is required: KEY=LOW:HIGH")

    def check_measurement(each: Measurement) -> None:
        if each.quantity not in FIELD and not predictor.slider:
            raise SceneError(
                f"measurements {each.name}", "needs a scene with a [slider]: without one there is no velocity"
            )
        if each.network is not None and not predictor.given_wave:
            refuse_other_range(predictor.scene({}), each.network, "measurements")
        if each.scan is not None:
            placed(predictor.scene({}), each.scan, "measurements")

    def check_parameter(key: str) -> None:
        if sum(each.key == key for each in parameters) > 1:
            raise SceneError(f"parameters {key}", "is given twice")
        if key == AMPLITUDE_FACTOR and predictor.given_wave:
            raise SceneError(f"parameters {key}", "needs a stator; with a given [wave] free amplitude_per_volt")
        if key == AMPLITUDE_PER_VOLT and not predictor.given_wave:
            raise SceneError(f"parameters {key}", "needs a given [wave]; with a stator free amplitude_factor")
        if "." in key:  # an end of the range that the scene refuses is refused by name
            for end in (by_key[key].low, by_key[key].high):
                predictor.scene({key: end})

    each_measurement = [partial(check_measurement, each) for each in measurements]
    all_answers([check_number, *each_measurement, *(partial(check_parameter, key) for key in by_key)])


def _weighted(measurements: Any) -> tuple[list[Measurement], bool]:
    """Return the measurements with deviations, and whether these are to be scaled by the residuals."""
    known = [each.deviations is not None for each in measurements]
    if all(known):
        return list(measurements), False
    if any(known) or len({each.quantity for each in measurements}) > 1:
        raise SceneError(
            "measurements", "must state standard deviations in every file, or in none and all of one quantity"
        )
    size = float(np.sqrt(np.mean(np.square(np.concatenate([each.values for each in measurements])))))
    if size == 0.0:
        raise SceneError("measurements", "holds nothing but zeros, and no standard deviations")
    alike = [replace(each, deviations=(1.0,) * len(each.values)) for each in measurements]
    return [each.scattered(0.01 * size) for each in alike], True


def _signed(problem: Problem) -> tuple[Measurement, ...]:
    """Return the measurements; speeds without a sign take the prediction's."""
    predicted, signed = problem.predictions(problem.starts()[:8]), []
    for k, each in enumerate(problem.measurements):
        total = np.nansum([values[k] for values in predicted])
        is_speed = each.quantity in ("velocity", "burst", "position") and min(each.values) >= 0.0
        reverse = is_speed and total < 0.0
        signed.append(replace(each, values=tuple(-value for value in each.values)) if reverse else each)
    return tuple(signed)
