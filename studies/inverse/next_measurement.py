"""Which next measurement would narrow which number most.

Each candidate adds its Fisher information, from derivatives at the best fit, to that of the data; the ranges stand for
a weak prior (a standard deviation of half the range), so that numbers the data leave open have a finite width to begin
with.  Candidates are measured as well as the data so far, the others as `candidates` says.
"""

from dataclasses import dataclass, replace

import numpy as np

from studies.inverse.data import Measurement
from studies.inverse.least_squares import Problem
from studies.inverse.parameters import AMPLITUDE_FACTOR, AMPLITUDE_PER_VOLT

FREQUENCY_ERROR, AMPLITUDE_ERROR, WEIGHED = 0.01, 0.02, 0.01
WEIGHABLE = ("slider.preload", "slider.mass", "slider.radius")
INSTANTS = 40


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """What a measurement would do."""

    name: str  # what to measure
    key: str  # the number that it narrows most
    before: float  # standard deviation of that number, relative (of a number that may be zero: in its unit)
    after: float  # standard deviation of that number, relative (of a number that may be zero: in its unit)

    @property
    def narrowing(self) -> float:
        """Factor on the standard deviation."""
        return self.after / self.before


def candidates(problem: Problem) -> list[Measurement]:
    """Return measurements to think of; empty deviations are to be those of the data."""
    curve = next((each for each in problem.measurements if each.quantity == "velocity"), None)
    burst = next((each for each in problem.measurements if each.quantity == "burst"), None)
    base = curve or problem.measurements[0]
    levels = base.levels or (max(problem.predictor.contact(base.settings).scene.levels),)
    top, found = max(levels), []
    preload = float(base.settings.get("slider.preload", problem.predictor.value("slider.preload")))
    spread = tuple(np.linspace(min(levels), top, 12)) if len(levels) > 1 else (top,)
    plain = replace(base, quantity="velocity", time=(), values=(), deviations=None)
    if base.quantity != "amplitude":
        for factor in (0.5, 2.0):
            settings = base.settings | {"slider.preload": factor * preload}
            name = f"velocity at a preload of {factor * preload * 1e3:.3g} mN"
            found.append(replace(plain, name=name, levels=spread, settings=settings))
        found.append(
            replace(plain, name="velocity up to twice the level", levels=tuple(np.linspace(top, 2 * top, 6)))
        )
        if burst is None:
            contact = problem.predictor.contact(problem.numbers(_middle(problem)) | base.settings)
            rise = contact.slider.mass / (contact.slider.friction_coefficient * contact.slider.preload)
            length = 3.0 * float(np.max(np.abs(_values(problem, curve)))) * rise
            key = "wave.burst" if problem.predictor.given_wave else "drive.burst"
            found.append(
                replace(plain, name=f"v(t) of a burst of {length:.2g} s", quantity="burst", levels=(top,),
                        time=tuple(np.linspace(0.02, 1.0, INSTANTS) * length), settings=base.settings | {key: length})
            )  # fmt: skip
    found.append(
        Measurement(name="frequency of the tangential ring-down", quantity="ring-down frequency",
                    deviations=(FREQUENCY_ERROR,), settings=base.settings)
    )  # fmt: skip
    if any(p.key in (AMPLITUDE_FACTOR, AMPLITUDE_PER_VOLT) or problem.predictor.needs_stator(p.key)
           for p in problem.parameters):  # fmt: skip
        amplitude = Measurement(name="surface amplitude under the slider (vibrometer)", quantity="amplitude",
                                level_key="voltage_V", levels=(top,), deviations=(AMPLITUDE_ERROR,),
                                settings=base.settings)  # fmt: skip
        found.append(amplitude)
    return found


def ranked(problem: Problem, best: np.ndarray, information: np.ndarray, spread: float) -> list[Candidate]:
    """Return the candidates, each with the number that it narrows most, the most useful first.

    ``information``: Fisher information of the data and the ranges, over x; ``spread``: relative standard deviation of
    a velocity in the data.
    """
    before = np.sqrt(np.diag(np.linalg.inv(information)))
    count, found = len(problem.parameters), []
    for each in candidates(problem):
        slopes = _slopes(problem, best, each, spread)
        if slopes is not None:
            found.append(_gain(problem, each.name, information, slopes, before))
    for k, parameter in enumerate(problem.parameters):
        if parameter.key in WEIGHABLE:
            row = np.zeros((1, len(best)))
            row[0, k] = 1.0 / WEIGHED / (1.0 if parameter.logarithmic else parameter.outer(best[k]) or 1.0)
            name = f"{parameter.key} itself, to {100 * WEIGHED:g} %"
            found.append(_gain(problem, name, information, row, before))
    return sorted((each for each in found if count), key=lambda each: each.narrowing)


def _gain(problem, name, information, slopes, before) -> Candidate:
    after = np.sqrt(np.diag(np.linalg.inv(information + slopes.T @ slopes)))
    k = int(np.argmin((after / before)[: len(problem.parameters)]))
    return Candidate(name=name, key=problem.parameters[k].key, before=float(before[k]), after=float(after[k]))


def _slopes(problem: Problem, best, imagined: Measurement, spread: float):
    """Return d(prediction)/dx over its standard deviation; None where there is no prediction."""
    centre = problem.predictions([best], (imagined,))[0][0]
    relative = spread if imagined.deviations is None else imagined.deviations[0]
    deviation = relative * np.maximum(np.abs(centre), 0.1 * np.max(np.abs(centre)))
    if not np.all(np.isfinite(centre)) or np.max(deviation) == 0.0:
        return None
    count = len(problem.parameters)
    slopes = np.zeros((len(centre), len(best)))

    def predicted(xs):
        return [found[0] / deviation for found in problem.predictions(xs, (imagined,))]

    slopes[:, :count] = problem.slopes(predicted, best, range(count))
    return slopes if np.all(np.isfinite(slopes)) else None


def _middle(problem: Problem):
    return [p.start(problem.predictor.value(p.key)) for p in problem.parameters]


def _values(problem: Problem, curve):
    return curve.values if curve is not None else problem.measurements[0].values
