"""The picture of a fit: each measurement with the fitted curve, its predictive band and its residuals."""

from pathlib import Path

import numpy as np

from studies.inverse.result import QUANTITIES, Fit
from studies.lab.measurement import Measurement
from studies.record.plots import COLOURS, finished, new_figure
from studies.record.quantities import quantity

MANY = 100  # points from which on they are drawn smaller


def draw_fit(fit: Fit, path: Path) -> None:
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


def _draw(fit: Fit, measurement: Measurement, residuals, upper, lower) -> None:
    """Draw one measurement with band and curve into Axes, its residuals into others below."""
    at, along = measurement.levels, quantity(measurement.level_key or "normal_amplitude_m")
    data = measurement.network or measurement.scan
    if data is not None:
        by_frequency = measurement.scan is None or measurement.scan.kind == "frequency"
        at, along = measurement.coordinate, quantity("frequency_Hz" if by_frequency else "beam_position_m")
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
    finished(lower, along.axis, quantity("residual").axis, "", columns=0)
