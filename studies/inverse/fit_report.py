"""What a fit leaves: its answer as text, fit.json, the fitted scene with its intervals, and a picture."""

import math
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from studies.lab.measurement import Measurement
from studies.record.plots import COLOURS, finished, new_figure
from studies.record.quantities import quantity
from studies.record.text import labelled, table
from studies.report.intermediate import scaled_unit, si
from studies.results.content import write_json
from studies.scene.toml import document

if TYPE_CHECKING:
    from studies.inverse.result import Fit

QUANTITIES = {
    "velocity": quantity("velocity_m_per_s"),
    "burst": quantity("velocity_m_per_s"),
    "amplitude": quantity("normal_amplitude_m"),
    "ring-down frequency": quantity("ring_down_frequency_Hz"),
    "position": quantity("travelled_m"),
    "scan": quantity("surface_motion_m_per_V"),
    "network": quantity("scattering"),
}  # that are measured
SHOWN_CANDIDATES = 6
INFORMED = 2.0  # times narrower than its range, from which a measurement tells something of a number
DOUBTFUL = 0.01  # probability of the sum of squares below which the model does not explain the data

MANY = 100  # points from which on they are drawn smaller


def fit_answer(fit: "Fit") -> str:
    """Return what a fit prints."""
    rows = [["parameter", "value", "95 % from", "to", "unit"]]
    for each in fit.problem.parameters:
        value, ends = fit.values[each.key], fit.intervals[each.key]
        factor, unit = scaled_unit(value, each.unit)
        low, high = ends
        width = abs(value) if low is None or high is None else high - low
        digits = max(4, 3 + math.ceil(-math.log10(max(width / (abs(value) or 1.0), 1e-12))))  # show the interval
        texts = ("open" if end is None else f"{end * factor:.{digits}g}" for end in ends)
        rows.append([each.key, f"{value * factor:.{digits + 1}g}", *texts, unit])
    notes = [("goodness of fit", _goodness(fit))]
    notes += [("undetermined", each.sentence) for each in fit.directions]
    for rival in fit.rivals:
        at = ", ".join(f"{each.key} = {si(rival[each.key], each.unit, 4)}".rstrip() for each in fit.problem.parameters)
        notes.append(("also possible", f"{at}: another minimum that these data do not rule out"))
    for key, both in fit.ends.items():
        notes += [("open", f"{key} {way}: {end.because}") for way, end in zip(("below", "above"), both, strict=True)
                  if end is not None and not end.closed]  # fmt: skip
    for (i, one), (j, other) in combinations(enumerate(fit.values), 2):
        if abs(fit.correlation[i, j]) > 0.5:
            notes.append(("correlation", f"{one}, {other}: {fit.correlation[i, j]:+.3f}"))
    if len(fit.informs) > 1:
        for name, gains in fit.informs:
            known = [f"{key} ({gain:.3g} times narrower)" for key, gain in gains.items() if gain > INFORMED]
            notes.append(("informs", f"{name}: {', '.join(known) or 'none of the numbers'}"))
    if fit.candidates is None:
        notes.append(("measure next", "not computed: it would double the time of the fit (--next asks for it)"))
    for candidate in (fit.candidates or ())[:SHOWN_CANDIDATES]:
        gain = f"{candidate.key} from {100 * candidate.before:.3g} % to {100 * candidate.after:.3g} %"
        notes.append(("measure next", f"{candidate.name}: {gain}"))
    title = fit.problem.predictor.table.get("title", "") or "no title"
    return "\n".join([title, "", *table(rows), "", *labelled(notes)])


def _goodness(fit: "Fit") -> str:
    if fit.deviation is not None:
        measured = QUANTITIES[fit.problem.measurements[0].quantity]
        return (
            f"standard deviation from the residuals {fit.deviation * measured.scale:.3g} {measured.shown}: the data "
            "state none, so they cannot contradict the model"
        )
    text = f"chi^2 {fit.chi2:.4g} with {fit.degrees_of_freedom} degrees of freedom"
    if fit.probability is None:
        return text
    doubt = ": the model does not explain these data" if fit.probability < DOUBTFUL else ""
    return f"{text}, probability {fit.probability:.2g}{doubt}"


def write_fit(fit: "Fit", folder: Path) -> None:
    """Write fit.json and fitted.toml, the scene with the estimates, which runs."""
    write_json(folder / "fit.json", fit.to_dict())
    (folder / "fitted.toml").write_text(fitted_scene(fit), encoding="utf-8")


def fitted_scene(fit: "Fit") -> str:
    """Return the fitted scene as TOML, with an interval or a reason beside each fitted number."""
    names = ", ".join(each.name for each in fit.problem.measurements)
    remarks, beside = [f"fitted to {names}; intervals of 95 % by profile likelihood, SI units"], {}
    for key, (low, high) in fit.intervals.items():
        ends = ["open" if end is None else f"{end:.6g}" for end in (low, high)]
        text = f"95 %: {ends[0]} to {ends[1]}"
        if low is None and high is None:
            text = "not determined by the data"
        if "." in key:
            beside[key] = text
        else:
            remarks.append(f"{key} = {fit.values[key]:.6g}, {text}; it is no key of a scene")
    remarks += [each.sentence for each in fit.directions]
    return document(fit.scene().to_table(), remarks=tuple(remarks), beside=beside)


def draw_fit(fit: "Fit", path: Path) -> None:
    """Draw each measurement with the fitted curve, its band and its residuals into a PNG file."""
    problem, count = fit.problem, len(fit.problem.measurements)
    figure, axes = new_figure(
        6.4 * count, 6.0, rows=2, columns=count, squeeze=False, height_ratios=(2.5, 1.0), sharex="col"
    )
    ends = np.cumsum([len(each.values) for each in problem.measurements])
    residuals = np.split(problem.residuals([fit.inner])[0], ends)  # those of systematic errors come last
    for k, measurement in enumerate(problem.measurements):
        _draw(fit, measurement, residuals[k], axes[0, k], axes[1, k])
    figure.savefig(path, dpi=150)


def _draw(fit: "Fit", measurement: Measurement, residuals, upper, lower) -> None:
    """Draw one measurement with band and curve into Axes, its residuals into others below."""
    at, along = measurement.levels, quantity(measurement.level_key or "normal_amplitude_m")
    data = measurement.network or measurement.scan
    if data is not None:
        by_frequency = measurement.scan is None or measurement.scan.kind == "frequency"
        at, along = measurement.coordinate, quantity("frequency_Hz" if by_frequency else "place_m")
    if measurement.time:
        at, along = measurement.time, quantity("time_s")
    scale, drawn = along.scale, QUANTITIES[measurement.quantity]
    factor = drawn.scale
    where, best, low, high = fit.band(measurement)
    values, scatter = np.array([measurement.values, measurement.deviations])
    seen = np.array(at)
    if measurement.scan is not None and measurement.scan.is_complex:  # a wave of many periods: its size is drawn
        half = len(where) // 2
        real, imaginary = best[:half], best[half:]
        best = np.hypot(real, imaginary)
        spread = np.hypot(real * (high - low)[:half], imaginary * (high - low)[half:]) / np.maximum(best, 1e-300)
        where, low, high = where[:half], best - 0.5 * spread, best + 0.5 * spread
        seen, values, scatter = seen[:half], np.hypot(values[:half], values[half:]), scatter[:half]
    elif data is not None:  # real and imaginary parts lie on one axis: a line each
        half = len(where) // len(data.coordinate)
        where, best, low, high = (np.insert(each.astype(float), [len(each) // half] if half > 1 else [], np.nan)
                                  for each in (where, best, low, high))  # fmt: skip
    if len(where) == 1:  # a band and a curve of one point would not be seen
        half_widths = np.array([best - low, high - best]) * factor
        upper.errorbar(
            where * scale, best * factor, yerr=half_widths, fmt="D", color=COLOURS["slip"], markersize=5, capsize=6,
            label="best fit, 95 % of the fitted motors",
        )  # fmt: skip
    else:
        upper.fill_between(where * scale, low * factor, high * factor, color=COLOURS["slip"], alpha=0.25, linewidth=0,
                           label="95 % of the fitted motors")  # fmt: skip
        upper.plot(where * scale, best * factor, color=COLOURS["slip"], linewidth=1.2, label="best fit")
    size = 3.5 if len(seen) < MANY else 2.0
    upper.errorbar(
        seen * scale, values * factor, yerr=scatter * factor, fmt="o", color=COLOURS["line"], markersize=size,
        linewidth=0.8, capsize=size - 1.5, label="measured, 1 standard deviation",
    )  # fmt: skip
    fixed = [f"{key} = {value:g}" for key, value in measurement.settings.items() if isinstance(value, (int, float))]
    title = " ".join([measurement.name, *([f"({', '.join(fixed)})"] if fixed else [])])
    finished(upper, "", drawn.axis, title, columns=0)
    upper.legend(frameon=False, fontsize="small", loc="best")
    lower.axhspan(-2.0, 2.0, color=COLOURS["stick"], alpha=0.2, linewidth=0)
    lower.axhline(0.0, color=COLOURS["line"], linewidth=0.8)
    lower.plot(np.array(at) * scale, residuals, "o", color=COLOURS["line"], markersize=size)
    finished(lower, along.axis, "residual (std. deviations)", "", columns=0)
