"""Which further measurement would narrow which number most.

Each candidate adds its Fisher information, from derivatives at the best fit, to that of the data
(`Problem.information`), where the ranges are a weak prior of numbers that the data leave open.  A candidate without
standard deviations of its own has the typical relative deviation of the data.  A burst is planned at the slider's
position, on a wave that is steady from its start: ring-up and travel take seconds for each derivative.  On the motor
``twente`` a burst of 0.34 s along the field leaves 1.7 % of the friction coefficient open, at one position 2.1 %.
"""

import logging
from dataclasses import dataclass

import numpy as np

from studies.inverse.free_parameters import AMPLITUDE_FACTOR, AMPLITUDE_PER_VOLT
from studies.inverse.least_squares import Problem, standard_deviations
from studies.lab.measurement import FIELD, Measurement
from studies.progress import counted
from studies.record.prefixes import si
from studies.record.quantities import quantity

LOGGER = logging.getLogger(__name__)

FREQUENCY_ERROR, AMPLITUDE_ERROR, WEIGHED = 0.01, 0.02, 0.01  # relative: of a ring-down, a vibrometer, a balance
USELESS = 0.99  # of the standard deviation: a measurement that leaves more than this is not named
WEIGHABLE = ("slider.preload", "slider.mass", "slider.radius")
INSTANTS = 40  # of a burst
SPREAD = 12  # levels of a velocity curve


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """A further measurement and the number that it narrows most."""

    name: str  # what to measure
    key: str  # the number that it narrows most
    before: float  # standard deviation of that number, relative (of a number that may be zero: in its unit)
    after: float  # the same with the measurement


def candidates(problem: Problem) -> list[Measurement]:
    """Return possible measurements; most leave their standard deviations to `ranked`."""
    predictor, data = problem.predictor, {each.quantity: each for each in reversed(problem.measurements)}
    scene_level = predictor.scene({}).level_column
    moving = [each for each in problem.measurements if each.quantity not in FIELD]
    base = data.get("velocity", moving[0] if moving else Measurement(name="", quantity="none", level_key=scene_level))
    levels = base.levels or tuple(sorted(predictor.contact(base.settings).scene.levels))[-1 if moving else 0 :]
    top, planned = max(levels), []
    spread = tuple(np.linspace(min(levels), top, SPREAD)) if len(levels) > 1 else levels
    if not moving and predictor.slider:
        planned.append(Measurement(name=f"slider velocity at {SPREAD} levels", quantity="velocity",
                                   level_key=scene_level, levels=spread))  # fmt: skip

    def add(name, quantity="velocity", *, at=(top,), settings=base.settings, **fields):
        fields = {"level_key": base.level_key if base.levels else scene_level} | fields
        planned.append(Measurement(
            name=name, quantity=quantity, systematic=base.systematic, levels=at, settings=settings, **fields
        ))  # fmt: skip

    if base.quantity not in ("amplitude", "none"):
        preload = float(base.settings.get("slider.preload") or predictor.value("slider.preload") or 0.0)
        for size in (0.5 * preload, 2.0 * preload):
            settings = base.settings | {"slider.preload": size}
            add(f"velocity at a preload of {si(size, 'N', 3)}", at=spread, settings=settings)
        add("velocity up to twice the level", at=tuple(np.linspace(top, 2 * top, 6)))
        # a burst in the plane is not predicted
        if "burst" not in data and base.quantity != "position" and not predictor.scene({}).planar:
            start = [p.start(predictor.value(p.key)) for p in problem.parameters]
            driven = predictor.contact(problem.scene_numbers(start) | base.settings)
            rise = driven.moving_slider.mass / driven.slider.least_friction(driven.contacts)
            length = 3.0 * float(np.max(np.abs(base.values))) * rise
            settings = base.settings | {"wave.burst" if predictor.prescribed_wave else "drive.burst": length}
            time = tuple(np.linspace(0.02, 1.0, INSTANTS) * length)
            add(f"v(t) of a burst of {length:.2g} s", "burst", settings=settings, time=time)
    if predictor.slider:
        add("frequency of the tangential ring-down", "ring-down frequency", at=(), deviations=(FREQUENCY_ERROR,))
    sizes = (AMPLITUDE_FACTOR, AMPLITUDE_PER_VOLT)
    if any(p.key in sizes or problem.needs_stator(p) for p in problem.parameters):
        add("surface amplitude under the slider (vibrometer)", "amplitude", deviations=(AMPLITUDE_ERROR,),
            level_key=quantity.voltage_V.column)  # fmt: skip
    return planned


def ranked(problem: Problem, best: np.ndarray, information: np.ndarray) -> list[Candidate]:
    """Return the candidates that narrow a number, each with the one that it narrows most, the most useful first.

    ``information``: Fisher information of the data and the ranges, over x.
    """
    relative = [np.array(each.deviations) / (np.max(np.abs(each.values)) or 1e-300) for each in problem.measurements]
    typical = float(np.median(np.concatenate(relative)))
    planned = counted(LOGGER, "next measurements", candidates(problem))
    jacobians = {each.name: _jacobian(problem, best, each, typical) for each in planned}
    for k, parameter in enumerate(problem.parameters):
        if parameter.key in WEIGHABLE:
            deviation = WEIGHED * (1.0 if parameter.logarithmic else parameter.outer(best[k]) or 1.0)
            jacobians[f"{parameter.key} itself, to {100 * WEIGHED:g} %"] = np.eye(1, len(best), k) / deviation
    before, useful = standard_deviations(information), []
    for name, jacobian in jacobians.items():
        if jacobian is None:
            continue
        after = standard_deviations(information + jacobian.T @ jacobian)
        k = int(np.argmin((after / before)[: len(problem.parameters)]))
        if after[k] < USELESS * before[k]:
            key = problem.parameters[k].key
            useful.append(Candidate(name=name, key=key, before=float(before[k]), after=float(after[k])))
    return sorted(useful, key=lambda each: each.after / each.before)


def _jacobian(problem: Problem, best: np.ndarray, planned: Measurement, typical: float) -> np.ndarray | None:
    """Return d(prediction)/dx over its standard deviation, (n, p); None where there is no prediction.

    ``typical``: relative standard deviation of a measurement that has none of its own.
    """
    centre = problem.predictions([best], (planned,), travelling=False)[0][0]
    relative = typical if planned.deviations is None else planned.deviations[0]
    deviation = relative * np.maximum(np.abs(centre), 0.1 * np.max(np.abs(centre)))
    if not np.all(np.isfinite(centre)) or np.max(deviation) == 0.0:
        return None

    def predicted(xs):
        return [each[0] / deviation for each in problem.predictions(xs, (planned,), travelling=False)]

    own = problem.derivatives(predicted, best, range(len(problem.parameters)))
    jacobian = np.pad(own, ((0, 0), (0, len(best) - own.shape[1])))  # systematic errors belong to the data alone
    return jacobian if np.all(np.isfinite(jacobian)) else None
