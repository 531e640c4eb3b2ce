"""Weighted least squares of measurements over a few free numbers, with derivatives by differences.

Residuals are (measured - predicted) over the standard deviation.  A systematic error s of a measurement is one more
unknown b with the residual b / s; its predictions are multiplied by 1 + b.  `scipy.optimize.least_squares` searches
for the minimum from the best points of a Latin hypercube.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from studies.inverse.free_parameters import Parameter
from studies.inverse.prediction import MeasurementPredictor
from studies.inverse.ties import Ties, is_of_scene
from studies.lab.measurement import Measurement
from studies.refusal import RunError

STEP = 1e-4  # of the logarithm, or over the range: the difference errs by its square, a prediction by 1e-9
COSTLY_STEP = 1e-3  # the same to one side, where a prediction is costly and errs by 1e-7
STATOR_STEP = 1e-3  # a stator's answer is known to the predictor's tolerance only
SAMPLES, MAX_STARTS = 64, 8  # random starts; the best of them, from which a minimum is searched
SLOW_SAMPLES, MAX_SLOW_STARTS = 8, 3  # the same where a velocity is costly (`MeasurementPredictor.costly`)
BETWEEN = 9  # points on the line between two minima at which the sum of squares is evaluated
MAX_EVALUATIONS = 60  # of the residuals in one search for a minimum
CLEARLY = 1e-3  # relative difference of two sums of squares below which two minima count as equally good


Minimum = tuple[np.ndarray, float]  # x as in `Problem`, and the sum of squares there


def standard_deviations(information: np.ndarray) -> np.ndarray:
    """Return the standard deviation of each x, all others free, from a Fisher information."""
    return np.sqrt(np.diag(np.linalg.inv(information)))


@dataclass(frozen=True, kw_only=True)
class Problem:
    """The sum of squares as a function of x: the inner values of the parameters, then one b per systematic error."""

    predictor: MeasurementPredictor = field(repr=False)
    parameters: tuple[Parameter, ...]
    measurements: tuple[Measurement, ...]  # with standard deviations
    ties: Ties = field(default_factory=Ties, repr=False)  # numbers that follow the parameters

    @property
    def systematic(self) -> list[int]:
        """Indices of the measurements that have a systematic error."""
        return [k for k, each in enumerate(self.measurements) if each.systematic > 0.0]

    @property
    def low(self) -> np.ndarray:
        """Lower ends of x; those of b, -0.9 to 9, allow a factor 1 + b of 0.1 to 10."""
        return np.array([p.inner(p.low) for p in self.parameters] + [-0.9] * len(self.systematic))

    @property
    def high(self) -> np.ndarray:
        """Upper ends of x; see `low`."""
        return np.array([p.inner(p.high) for p in self.parameters] + [9.0] * len(self.systematic))

    @property
    def half_width(self) -> np.ndarray:
        """Half the range of each x; of a systematic error its standard deviation."""
        ranges = (self.high - self.low)[: len(self.parameters)]
        return np.concatenate([0.5 * ranges, [self.measurements[k].systematic for k in self.systematic]])

    @property
    def points(self) -> int:
        """Number of measured values."""
        return sum(len(each.values) for each in self.measurements)

    def numbers(self, x) -> dict[str, float]:
        """Return the values of the parameters, and of the numbers that follow them, by key."""
        free = {p.key: p.outer(value) for p, value in zip(self.parameters, x, strict=False)}
        return free | self.ties(free)

    def scene_numbers(self, x) -> dict[str, float]:
        """Return `numbers` without names that stand in expressions only."""
        return {key: value for key, value in self.numbers(x).items() if is_of_scene(key) or not self.ties.uses(key)}

    def needs_stator(self, parameter: Parameter) -> bool:
        """Return whether a change of a parameter, or of what follows it, requires a new solution of the stator."""
        return any(map(self.predictor.needs_stator, [parameter.key, *self.ties.followers(parameter.key)]))

    def predictions(self, xs, measurements=None, *, travelling: bool = True) -> list[list[np.ndarray]]:
        """Return, for each x, the predictions of measurements, by default the problem's; no systematic errors.

        ``travelling``: as for `MeasurementPredictor.predict`.
        """
        measurements = measurements or self.measurements
        questions = [(each, self.scene_numbers(x)) for x in xs for each in measurements]
        flat = self.predictor.predict(questions, travelling=travelling)
        return [flat[k : k + len(measurements)] for k in range(0, len(flat), len(measurements))]

    def residuals(self, xs) -> np.ndarray:
        """Return the residuals at each x, (m, n); a point without a prediction counts as one at rest."""
        residuals = []
        for x, predicted in zip(xs, self.predictions(xs), strict=True):
            b = dict(zip(self.systematic, x[len(self.parameters) :], strict=True))
            parts = [
                (np.array(each.values) - np.nan_to_num(values) * (1.0 + b.get(k, 0.0))) / np.array(each.deviations)
                for k, (each, values) in enumerate(zip(self.measurements, predicted, strict=True))
            ]
            parts += [[error / self.measurements[k].systematic] for k, error in b.items()]
            residuals.append(np.concatenate(parts))
        return np.array(residuals)

    def jacobian(self, x, free=None) -> np.ndarray:
        """Return the derivatives of the residuals by the components ``free`` of x, by default all, (n, p)."""
        return self.derivatives(self.residuals, x, range(len(x)) if free is None else free)

    def derivatives(self, function, x, free) -> np.ndarray:
        """Return the derivatives by components of x, (n, p), of a function that maps m vectors x to (m, n)."""
        if self.predictor.costly:
            return self._forward(function, np.array(x, float), free)
        points, all_weights = [], []
        for j in free:
            places, weights = self._difference(j, float(x[j]))
            for place in places:
                moved = np.array(x, float)
                moved[j] = place
                points.append(moved)
            all_weights.append(weights)
        values, ends = function(points), np.cumsum([len(each) for each in all_weights])
        each_values = np.split(values, ends[:-1])
        return np.array([weights @ own for weights, own in zip(all_weights, each_values, strict=True)]).T

    def _difference(self, j: int, value: float) -> tuple[np.ndarray, np.ndarray]:
        """Return values of component j, and the weights that give the derivative at one value of it.

        Of the only number that needs a new stator they are three neighbours of a fixed grid, through which a parabola
        is laid: the same stators serve all steps of a search within two of its steps.
        """
        step, low, high = self._step(j), self.low[j], self.high[j]
        alone = j < len(self.parameters) and sum(map(self.needs_stator, self.parameters)) == 1
        first, last = math.ceil(low / step) + 1, math.floor(high / step) - 1
        if alone and self.needs_stator(self.parameters[j]) and first <= last:
            number = min(max(round(value / step), first), last)
            offset = value / step - number
            places = step * np.arange(number - 1, number + 2)
            return places, np.array([offset - 0.5, -2.0 * offset, offset + 0.5]) / step
        places = np.array([max(value - step, low), min(value + step, high)])
        return places, np.array([-1.0, 1.0]) / (places[1] - places[0])

    def _forward(self, function, x: np.ndarray, free) -> np.ndarray:
        """Return derivatives by differences to one side: the predictor has kept the values at x itself."""
        moved, widths = [], []
        for j in free:
            other = x.copy()
            step = COSTLY_STEP / STEP * self._step(j)
            other[j] += step if x[j] + step <= self.high[j] else -step
            moved.append(other)
            widths.append(other[j] - x[j])
        here, *values = function([x, *moved])
        return np.array([(value - here) / width for value, width in zip(values, widths, strict=True)]).T

    def information(self, jacobian: np.ndarray) -> np.ndarray:
        """Return the Fisher information over x of residuals with a Jacobian; the ranges are a weak prior.

        The prior of each x has a standard deviation of half its range, that of a systematic error its own.
        """
        return jacobian.T @ jacobian + np.diag(self.half_width**-2.0)

    def minimum(self, start, fixed: int | None = None) -> Minimum:
        """Return (x, sum of squares) of the minimum reached from a start, with a component ``fixed`` or none."""
        free = [j for j in range(len(start)) if j != fixed]
        whole = np.array(start, float)
        if not free:
            return whole, float(np.sum(self.residuals([whole])[0] ** 2))

        def at(part):
            x = whole.copy()
            x[free] = part
            return x

        low, high = self.low[free], self.high[free]
        inside = np.clip(whole[free], low + 1e-9 * (high - low), high - 1e-9 * (high - low))
        solution = least_squares(
            lambda part: self.residuals([at(part)])[0], inside, lambda part: self.jacobian(at(part), free),
            bounds=(low, high), x_scale=self.half_width[free], xtol=1e-7, ftol=1e-7, gtol=1e-9,
            max_nfev=MAX_EVALUATIONS,
        )  # fmt: skip
        return at(solution.x), 2.0 * float(solution.cost)

    def minima(self) -> list[Minimum]:
        """Return (x, sum of squares) of the distinct minima reached from several starts, the least first."""
        starts = self.starts()
        self.predictor.begin(f"fit: {len(starts)} starting points", len(starts) * len(self.measurements))
        squares = np.sum(self.residuals(starts) ** 2, axis=1)
        self.predictor.begin("fit: least squares")
        solutions = [self.minimum(starts[0])]
        max_starts = MAX_SLOW_STARTS if self.predictor.costly else MAX_STARTS
        for k in [k for k in np.argsort(squares)[:max_starts] if k > 0]:
            if not all(self._separated(starts[k], other, squares[k]) for other, _ in solutions):
                continue  # in the valley of a known minimum
            x, least = self.minimum(starts[k])
            same = [n for n, (other, size) in enumerate(solutions) if not self._separated(x, other, max(least, size))]
            worse = [n for n in same if least < solutions[n][1] - CLEARLY * max(1.0, least)]
            solutions = [each for n, each in enumerate(solutions) if n not in worse]
            if not same or worse:
                solutions.append((x, least))
        solutions.sort(key=lambda each: each[1])
        if any(np.isnan(values).any() for values in self.predictions([solutions[0][0]])[0]):
            raise RunError("the motor has no steady motion at some measured point of the best fit")
        return solutions

    def _separated(self, one, other, highest: float) -> bool:
        """Return whether the sum of squares exceeds ``highest`` between two points, so that they lie in two valleys."""
        if np.max(np.abs(one - other) / self.half_width) < 1e-3:
            return False
        shares = np.linspace(0.0, 1.0, BETWEEN + 2)[1:-1]
        squares = np.sum(self.residuals([one + share * (other - one) for share in shares]) ** 2, axis=1)
        return bool(np.max(squares) > highest + 0.1)

    def starts(self) -> list[np.ndarray]:
        """Return the starts of the search: the scene's own values, then a Latin hypercube if predictions are cheap."""
        own = [p.start(self.predictor.value(p.key) if p.value is None else p.value) for p in self.parameters]
        count, b = len(self.parameters), [0.0] * len(self.systematic)
        starts = [np.array([*own, *b])]
        slow = any(map(self.needs_stator, self.parameters))
        if slow or any(each.quantity == "burst" for each in self.measurements):
            return starts
        samples = SLOW_SAMPLES if self.predictor.costly else SAMPLES
        for shares in qmc.LatinHypercube(count, rng=np.random.default_rng(0)).random(samples):
            starts.append(np.array([*(self.low[:count] + shares * (self.high - self.low)[:count]), *b]))
        return starts

    def _step(self, j: int) -> float:
        if j >= len(self.parameters):
            return STEP
        parameter = self.parameters[j]
        step = STATOR_STEP if self.needs_stator(parameter) else STEP
        return step if parameter.logarithmic else step * (parameter.high - parameter.low)
