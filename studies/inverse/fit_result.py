"""The result of a fit: estimates, intervals, undetermined directions, predictive band, as text and as files."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path

import numpy as np
from scipy.stats import chi2

from studies.inverse.directions import Direction
from studies.inverse.free_parameters import Parameter
from studies.inverse.least_squares import Problem
from studies.inverse.next_measurement import Candidate
from studies.inverse.profile import AT_END, End
from studies.lab.measurement import Measurement
from studies.record.prefixes import scaled_unit
from studies.record.quantities import quantity
from studies.record.text import labelled, table
from studies.results.content import write_json
from studies.scene import Scene
from studies.scene.keys import coordinate
from studies.scene.toml import document

# of a measurement, by its ``quantity``
QUANTITIES = {
    "velocity": quantity.velocity_m_per_s,
    "mean velocity": quantity.mean_velocity_m_per_s,
    "lateral velocity": quantity.lateral_velocity_m_per_s,
    "yaw rate": quantity.yaw_rate_rad_per_s,
    "burst": quantity.velocity_m_per_s,
    "amplitude": quantity.normal_amplitude_m,
    "ring-down frequency": quantity.ring_down_frequency_Hz,
    "position": quantity.travelled_m,
    "scan": quantity.surface_motion_m_per_V,
    "network": quantity.scattering,
}
SHOWN_CANDIDATES = 6
INFORMED = 2.0  # how many times a measurement must narrow a number to be said to inform about it
DOUBTFUL = 0.01  # probability of the sum of squares below which the model does not explain the data
DRAWS, GRID = 200, 40  # random motors of the predictive band; levels at which it is drawn


@dataclass(frozen=True, kw_only=True, repr=False)
class Fit:
    """Result of a fit."""

    problem: Problem
    inner: np.ndarray  # x at the minimum, as in `Problem`
    chi2: float  # sum of squared residuals
    degrees_of_freedom: int
    # standard deviation in SI units estimated from the residuals; None where the data state their own
    deviation: float | None
    # of the intervals by key; None where the number lies in an undetermined direction
    ends: dict[str, tuple[End | None, End | None]]
    directions: tuple[Direction, ...]  # undetermined
    # numbers at other minima that the data do not rule out; the intervals hold them
    rivals: tuple[dict[str, float], ...]
    covariance: np.ndarray  # of all x, the ranges as a weak prior
    candidates: tuple[Candidate, ...] | None = None  # next measurements, the most useful first; None: not computed
    # by measurement: how many times narrower than its range each number is by this measurement alone
    informs: tuple[tuple[str, dict[str, float]], ...] = ()
    fixed: tuple[Parameter, ...] = ()  # held at their values

    @property
    def values(self) -> dict[str, float]:
        """Estimates by key, SI units."""
        return self.problem.numbers(self.inner)

    best = values  # the name that scipy and lmfit use

    def __str__(self) -> str:
        """Return what `sawmotor fit` prints."""
        rows = [["parameter", "value", "95 % from", "to", "unit"]]
        for each in self.problem.parameters:
            value, (low, high) = self.values[each.key], self.intervals[each.key]
            factor, unit = scaled_unit(value, each.unit)
            width = abs(value) if low is None or high is None else high - low
            digits = max(4, 3 + math.ceil(-math.log10(max(width / (abs(value) or 1.0), 1e-12))))  # show the interval
            texts = ("open" if end is None else f"{end * factor:.{digits}g}" for end in (low, high))
            rows.append([each.key, f"{value * factor:.{digits + 1}g}", *texts, unit])
        title = self.problem.predictor.scenes.table.get("title", "") or "no title"
        return "\n".join([title, "", *table(rows), "", *labelled(self._notes())])

    def __repr__(self) -> str:
        """Return each estimate with its interval, and the goodness of fit, on one line."""
        parts = []
        for each in self.problem.parameters:
            value = self.values[each.key]
            factor, _ = scaled_unit(value, each.unit)
            low, high = ("open" if end is None else f"{end * factor:.4g}" for end in self.intervals[each.key])
            parts.append(f"{each.key} = {each.text(value)} ({low} to {high})")
        return f"Fit({', '.join([*parts, self._chi2_in_words])})"

    @property
    def _chi2_in_words(self) -> str:
        return f"chi^2 {self.chi2:.4g} with {self.degrees_of_freedom} degrees of freedom"

    @property
    def params(self) -> dict[str, Parameter]:
        """The parameters by key with estimate and standard error, those held at their values included; as in lmfit.

        The standard error is that of the linearised problem; None where the data do not determine the number.
        """
        undetermined = {key for each in self.directions for key in each.components}
        by_key = {}
        for each, deviation in zip(self.problem.parameters, self._standard_deviations.tolist(), strict=False):
            value = self.values[each.key]
            error = deviation * (value if each.logarithmic else 1.0)
            by_key[each.key] = replace(each, value=value, stderr=None if each.key in undetermined else error)
        return by_key | {each.key: each for each in (*self.fixed, *self.tied)}

    @property
    def tied(self) -> tuple[Parameter, ...]:
        """The numbers that follow the parameters by an expression, each with the standard error that results."""
        keys, problem = list(self.problem.ties.expressions), self.problem
        if not keys:
            return ()

        def followed(xs: list) -> np.ndarray:
            return np.array([[problem.numbers(x)[key] for key in keys] for x in xs])

        slopes = problem.derivatives(followed, self.inner, range(len(self.inner)))
        errors = np.sqrt(np.einsum("ij,jk,ik->i", slopes, self.covariance, slopes)).tolist()
        undetermined = {key for each in self.directions for key in each.components}
        open_keys = {each for key in undetermined for each in problem.ties.followers(key)}
        return tuple(
            Parameter(
                key=key, low=-math.inf, high=math.inf, value=self.values[key], vary=False,
                stderr=None if key in open_keys else error,
            )
            for key, error in zip(keys, errors, strict=True)
        )  # fmt: skip

    @property
    def _standard_deviations(self) -> np.ndarray:
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> np.ndarray:
        """Correlation matrix of the free numbers, the ranges as a weak prior."""
        deviations, count = self._standard_deviations, len(self.problem.parameters)
        return (self.covariance / np.outer(deviations, deviations))[:count, :count]

    @property
    def intervals(self) -> dict[str, tuple[float | None, float | None]]:
        """95 % intervals by key; None for an end that the data do not determine."""
        by_key = {}
        for k, p in enumerate(self.problem.parameters):
            low, high = (p.outer(end.x[k]) if end and end.closed else None for end in self.ends[p.key])
            by_key[p.key] = low, high
        return by_key

    @property
    def probability(self) -> float | None:
        """Probability of a larger sum of squares if model and standard deviations are right."""
        if self.deviation is not None or self.degrees_of_freedom < 1:
            return None
        return float(chi2.sf(self.chi2, self.degrees_of_freedom))

    def to_dict(self) -> dict:
        """Return what fit.json holds."""
        parameters = {}
        for key, interval in self.intervals.items():
            parameters[key] = {"value": self.values[key], "interval95": list(interval)}
            reasons = [end.because for end in self.ends[key] if end and not end.closed]
            if reasons:
                parameters[key]["open_because"] = reasons
        whole = {
            "parameters": parameters,
            "undetermined": [{"direction": each.components, "sentence": each.sentence} for each in self.directions],
            "chi2": self.chi2,
            "degrees_of_freedom": self.degrees_of_freedom,
            "correlation": self.correlation.tolist(),
            "tied": {
                each.key: {"value": each.value, "expression": self.problem.ties.expressions[each.key],
                           "standard_error": each.stderr}
                for each in self.tied
            },
            "informs": [{"measurement": name, "times_narrower": gains} for name, gains in self.informs],
        }  # fmt: skip
        if self.candidates is not None:
            whole["next_measurements"] = [
                {"measurement": each.name, "narrows": each.key} | self._narrowed(each) for each in self.candidates
            ]
        more = {"other_minima": list(self.rivals), "probability": self.probability,
                "estimated_standard_deviation": self.deviation}  # fmt: skip
        if not whole["tied"]:
            del whole["tied"]
        return whole | {key: value for key, value in more.items() if value not in (None, [])}

    def _narrowed(self, candidate: Candidate) -> dict[str, float]:
        """Return the standard deviation before and after a further measurement, by name.

        It is relative, or in the unit of a number that may be zero or is a coordinate, whose origin is arbitrary.
        """
        parameter = next(each for each in self.problem.parameters if each.key == candidate.key)
        relative, size = parameter.logarithmic, 1.0
        if relative and coordinate(candidate.key) is not None:
            relative, size = False, self.values[candidate.key]
        name = "relative_deviation" if relative else "deviation"
        return {f"{name}_before": size * candidate.before, f"{name}_after": size * candidate.after}

    def _notes(self) -> Iterator[tuple[str, str]]:
        """Yield the label and the text of each line below the table of the estimates."""
        yield "goodness of fit", self._goodness()
        if not self.problem.predictor.prescribed_wave:
            quantities = {each.quantity for each in self.problem.measurements}
            if "velocity" in quantities:
                yield "velocity", "predicted at the slider's position"
            if "mean velocity" in quantities:
                yield "mean velocity", "predicted as the mean over place within half a wavelength about the position"
        for each in self.tied:
            spread = "" if each.stderr is None else f", standard error {each.text(each.stderr)}"
            expression = self.problem.ties.expressions[each.key]
            yield "tied", f"{each.key} = {each.text(self.values[each.key])}{spread}: {expression}"
        for direction in self.directions:
            yield "undetermined", direction.sentence
        for rival in self.rivals:
            at = (f"{each.key} = {each.text(rival[each.key])}" for each in self.problem.parameters)
            yield "also possible", f"{', '.join(at)}: another minimum that these data do not rule out"
        for measurement in self.problem.measurements:
            data = measurement.network or measurement.scan
            for remark in measurement.remarks if data is None else data.remarks:
                yield "remark", f"{measurement.name}: {remark}"
        for each in self.problem.parameters:
            for remark in each.end_in_words(self.values[each.key], AT_END):
                yield "remark", remark
        for key, ends in self.ends.items():
            for side, end in zip(("below", "above"), ends, strict=True):
                if end and not end.closed:
                    yield "open", f"{key} {side}: {end.because}"
        for (i, one), (j, other) in combinations(enumerate(self.intervals), 2):
            if abs(self.correlation[i, j]) > 0.5:
                yield "correlation", f"{one}, {other}: {self.correlation[i, j]:+.3f}"
        for name, gains in self.informs if len(self.informs) > 1 else ():
            narrowed = [f"{key} ({gain:.3g} times narrower)" for key, gain in gains.items() if gain > INFORMED]
            yield "informs", f"{name}: {', '.join(narrowed) or 'none of the numbers'}"
        if self.candidates is None:
            yield "measure next", "not computed; --next does it, in about the time of the fit"
        for candidate in (self.candidates or ())[:SHOWN_CANDIDATES]:
            parameter = next(each for each in self.problem.parameters if each.key == candidate.key)
            before, after = (
                f"{100 * size:.3g} %" if name.startswith("relative") else parameter.text(size, 3)
                for name, size in self._narrowed(candidate).items()
            )
            yield "measure next", f"{candidate.name}: {candidate.key} from {before} to {after}"

    def _goodness(self) -> str:
        if self.deviation is not None:
            measured = QUANTITIES[self.problem.measurements[0].quantity]
            size = f"{self.deviation * measured.scale:.3g} {measured.shown}"
            return f"standard deviation from the residuals {size}; data without one cannot contradict the model"
        if self.probability is None:
            return self._chi2_in_words
        doubt = ": the model does not explain these data" if self.probability < DOUBTFUL else ""
        return f"{self._chi2_in_words}, probability {self.probability:.2g}{doubt}"

    def write(self, folder: Path) -> None:
        """Write fit.json and fitted.toml, the scene with the estimates, which runs, into a directory."""
        write_json(folder / "fit.json", self.to_dict())
        (folder / "fitted.toml").write_text(self._fitted_scene(), encoding="utf-8")

    def _fitted_scene(self) -> str:
        """Return the fitted scene as TOML, with an interval or a reason beside each fitted number."""
        names = ", ".join(each.name for each in self.problem.measurements)
        remarks, beside = [f"fitted to {names}; intervals of 95 % by profile likelihood, SI units"], {}
        for key, interval in self.intervals.items():
            low, high = ("open" if end is None else f"{end:.6g}" for end in interval)
            text = "not determined by the data" if interval == (None, None) else f"95 %: {low} to {high}"
            if "." in key:
                beside[key] = text
            else:
                remarks.append(f"{key} = {self.values[key]:.6g}, {text}; it is no key of a scene")
        for key, expression in self.problem.ties.expressions.items():
            beside[key] = f"tied: {expression}"
        remarks += [each.sentence for each in self.directions]
        return document(self.scene().to_table(), remarks=tuple(remarks), beside=beside)

    def scene(self) -> Scene:
        """Return the scene with those estimates that are keys of it."""
        of_scene = {key: value for key, value in self.values.items() if "." in key}
        return Scene.from_table("", self.problem.predictor.contact(of_scene).scene.to_table())

    def band(self, measurement: Measurement) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return (level or time, best, low, high) of a measurement's 95 % predictive band, without its noise.

        The percentiles of ``DRAWS`` normal draws of x about the best fit, cut to the ranges; where the stator, a burst
        or a slider on pillars or in the plane would be computed for each, 1.96 standard deviations of the linearised
        prediction.
        """
        problem, curve = self.problem, _drawn(measurement)
        slow = problem.predictor.costly or measurement.quantity not in ("velocity", "amplitude")
        slow = slow or any(map(problem.needs_stator, problem.parameters))
        count = len(self.inner) if slow else DRAWS
        problem.predictor.begin(f"fit: band of {measurement.name}", 1 + count)
        at = np.array(curve.coordinate)
        best = problem.predictions([self.inner], (curve,))[0][0]
        if slow:
            steps = np.linalg.cholesky(self.covariance).T
            moved = [np.clip(self.inner + step, problem.low, problem.high) for step in steps]
            shifts = [values - best for (values,) in problem.predictions(moved, (curve,))]
            width = 1.96 * np.sqrt(np.nansum(np.square(shifts), axis=0))
            return at, best, best - width, best + width
        draws = np.random.default_rng(0).multivariate_normal(self.inner, self.covariance, DRAWS)
        draws = np.clip(draws, problem.low, problem.high)
        values = np.array([values for (values,) in problem.predictions(draws, (curve,))])
        low, high = np.nanpercentile(values, [2.5, 97.5], axis=0)
        return at, best, low, high


def _drawn(measurement: Measurement) -> Measurement:
    """Return a measurement at the levels or instants at which its band is drawn."""
    if measurement.scan or measurement.network:
        return measurement
    if measurement.time:
        time = tuple(np.linspace(0.0, measurement.time[-1], 100)[1:])
        return replace(measurement, time=time, values=(), deviations=None)
    low, high = min(measurement.levels), max(measurement.levels)
    levels = tuple(np.linspace(low, high, GRID)) if high > low else (low,)
    return replace(measurement, levels=levels, values=(), deviations=None)
