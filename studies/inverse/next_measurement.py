"""Which further measurement would narrow which number most.

Each candidate adds its Fisher information, from derivatives at the best fit, to that of the data
(`Problem.information`), in which numbers that the data leave open have a finite width to begin with.  Candidates are
measured as well as the data so far, the others as `candidates` says.
"""

from dataclasses import dataclass, replace

import numpy as np

from studies.inverse.least_squares import Problem, standard_deviations
from studies.inverse.parameters import AMPLITUDE_FACTOR, AMPLITUDE_PER_VOLT
from studies.lab.measurement import FIELD, Measurement
from studies.report.intermediate import si

FREQUENCY_ERROR, AMPLITUDE_ERROR, WEIGHED = 0.01, 0.02, 0.01
USELESS = 0.99  # of the standard deviation: a measurement that leaves more than this is not named
WEIGHABLE = ("slider.preload", "slider.mass", "slider.radius")
INSTANTS = 40


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """A further measurement and the number that it narrows most."""

    name: str  # what to measure
    key: str  # the number that it narrows most
    before: float  # standard deviation of that number, relative (of a number that may be zero: in its unit)
    after: float  # the same with the measurement


def candidates(problem: Problem) -> list[Measurement]:
    """Return possible measurements; those without deviations get those of the data."""
    predictor, own = problem.predictor, {each.quantity: each for each in reversed(problem.measurements)}
    own_levels = predictor.scene({}).level_column
    moving = [each for each in problem.measurements if each.quantity not in FIELD]
    base = own.get("velocity", moving[0] if moving else Measurement(name="", quantity="none", level_key=own_levels))
    levels = base.levels or tuple(sorted(predictor.contact(base.settings).scene.levels))[-1 if moving else 0 :]
    top, imagined = max(levels), []
    if not moving and predictor.slider:
        spread = tuple(np.linspace(min(levels), top, 12)) if len(levels) > 1 else levels
        imagined.append(Measurement(name="slider velocity at 12 levels", quantity="velocity", level_key=own_levels,
                                 levels=spread))  # fmt: skip

    def think(name, quantity="velocity", at=(top,), settings=base.settings, **changes):
        level_key = base.level_key if base.levels else own_levels
        plain = Measurement(name="", quantity=quantity, level_key=level_key, systematic=base.systematic)
        imagined.append(replace(plain, name=name, levels=at, settings=settings, **changes))

    if base.quantity not in ("amplitude", "none"):
        preload = float(base.settings.get("slider.preload") or predictor.value("slider.preload") or 0.0)
        spread = tuple(np.linspace(min(levels), top, 12)) if len(levels) > 1 else (top,)
        for size in (0.5 * preload, 2.0 * preload):
            settings = base.settings | {"slider.preload": size}
            think(f"velocity at a preload of {si(size, 'N', 3)}", at=spread, settings=settings)
        think("velocity up to twice the level", at=tuple(np.linspace(top, 2 * top, 6)))
        if "burst" not in own and base.quantity != "position":
            start = [p.start(predictor.value(p.key)) for p in problem.parameters]
            driven = predictor.contact(problem.numbers(start) | base.settings)
            rise = driven.slider.mass / driven.slider.least_friction(len(driven.orbits))
            length = 3.0 * float(np.max(np.abs(base.values))) * rise
            settings = base.settings | {"wave.burst" if predictor.given_wave else "drive.burst": length}
            time = tuple(np.linspace(0.02, 1.0, INSTANTS) * length)
            think(f"v(t) of a burst of {length:.2g} s", "burst", settings=settings, time=time)
    if predictor.slider:
        think("frequency of the tangential ring-down", "ring-down frequency", at=(), deviations=(FREQUENCY_ERROR,))
    sizes = (AMPLITUDE_FACTOR, AMPLITUDE_PER_VOLT)
    if any(p.key in sizes or predictor.needs_stator(p.key) for p in problem.parameters):
        think("surface amplitude under the slider (vibrometer)", "amplitude", deviations=(AMPLITUDE_ERROR,),
              level_key="voltage_V")  # fmt: skip
    return imagined


def ranked(problem: Problem, best: np.ndarray, information: np.ndarray) -> list[Candidate]:
    """Return the candidates that narrow a number, each with the one that it narrows most, the most useful first.

    ``information``: Fisher information of the data and the ranges, over x.
    """
    shares = [np.array(each.deviations) / (np.max(np.abs(each.values)) or 1e-300) for each in problem.measurements]
    spread = float(np.median(np.concatenate(shares)))  # typical relative deviation in the data
    before, gains = standard_deviations(information), []
    for each in candidates(problem):
        slopes = _slopes(problem, best, each, spread)
        if slopes is not None:
            gains.append(_gain(problem, each.name, information, slopes, before))
    for k, parameter in enumerate(problem.parameters):
        if parameter.key in WEIGHABLE:
            row = np.zeros((1, len(best)))
            row[0, k] = 1.0 / WEIGHED / (1.0 if parameter.logarithmic else parameter.outer(best[k]) or 1.0)
            name = f"{parameter.key} itself, to {100 * WEIGHED:g} %"
            gains.append(_gain(problem, name, information, row, before))
    useful = [each for each in gains if each.after < USELESS * each.before]
    return sorted(useful, key=lambda each: each.after / each.before)


def _gain(problem, name, information, slopes, before) -> Candidate:
    after = standard_deviations(information + slopes.T @ slopes)
    k = int(np.argmin((after / before)[: len(problem.parameters)]))
    return Candidate(name=name, key=problem.parameters[k].key, before=float(before[k]), after=float(after[k]))


def _slopes(problem: Problem, best, imagined: Measurement, spread: float):
    """Return d(prediction)/dx over its standard deviation; None where there is no prediction."""
    centre = problem.predictions([best], (imagined,))[0][0]
    relative = spread if imagined.deviations is None else imagined.deviations[0]
    deviation = relative * np.maximum(np.abs(centre), 0.1 * np.max(np.abs(centre)))
    if not np.all(np.isfinite(centre)) or np.max(deviation) == 0.0:
        return None

    def predicted(xs):
        return [each[0] / deviation for each in problem.predictions(xs, (imagined,))]

    own = problem.slopes(predicted, best, range(len(problem.parameters)))
    slopes = np.pad(own, ((0, 0), (0, len(best) - own.shape[1])))  # systematic errors are of the data alone
    return slopes if np.all(np.isfinite(slopes)) else None
