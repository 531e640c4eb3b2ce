"""The picture of a fit: each measurement with the fitted curve, its predictive band and its residuals."""

from pathlib import Path

import numpy as np

from studies.inverse.fit_result import QUANTITIES, Fit
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
    scan, data, along = measurement.scan, measurement.network or measurement.scan, quantity.time_s
    if data is not None:
        by_frequency = scan is None or scan.kind == "frequency"
        along = quantity.frequency_Hz if by_frequency else quantity.beam_position_m
    elif not measurement.time:
        along = quantity(measurement.level_key) if measurement.level_key else quantity.normal_amplitude_m
    drawn = QUANTITIES[measurement.quantity]
    scale, factor = along.scale, drawn.scale
    x, best, low, high = fit.band(measurement)
    values, deviations = np.array([measurement.values, measurement.deviations])
    measured_x = np.array(measurement.coordinate)
    if scan is not None and scan.is_complex:  # a wave of many periods: its size is drawn
        half = len(x) // 2
        real, imaginary = best[:half], best[half:]
        best = np.hypot(real, imaginary)
        width = np.hypot(real * (high - low)[:half], imaginary * (high - low)[half:]) / np.maximum(best, 1e-300)
        x, low, high = x[:half], best - 0.5 * width, best + 0.5 * width
        measured_x, values, deviations = measured_x[:half], np.hypot(values[:half], values[half:]), deviations[:half]
    elif data is not None and len(x) > len(data.coordinate):  # a gap between the curves of real and imaginary parts
        starts = range(len(data.coordinate), len(x), len(data.coordinate))
        x, best, low, high = (np.insert(each.astype(float), starts, np.nan) for each in (x, best, low, high))
    if len(x) == 1:  # a band and a curve of one point would not be seen
        upper.errorbar(
            x * scale, best * factor, yerr=np.array([best - low, high - best]) * factor, fmt="D", color=COLOURS["slip"],
            markersize=5, capsize=6, label="best fit, 95 % of the fitted motors",
        )  # fmt: skip
    else:
        upper.fill_between(x * scale, low * factor, high * factor, color=COLOURS["slip"], alpha=0.25, linewidth=0,
                           label="95 % of the fitted motors")  # fmt: skip
        upper.plot(x * scale, best * factor, color=COLOURS["slip"], linewidth=1.2, label="best fit")
    size = 3.5 if len(measured_x) < MANY else 2.0
    upper.errorbar(
        measured_x * scale, values * factor, yerr=deviations * factor, fmt="o", color=COLOURS["line"], markersize=size,
        linewidth=0.8, capsize=size - 1.5, label="measured, 1 standard deviation",
    )  # fmt: skip
    fixed = [f"{key} = {value:g}" for key, value in measurement.settings.items() if isinstance(value, (int, float))]
    title = " ".join([measurement.name, *([f"({', '.join(fixed)})"] if fixed else [])])
    finished(upper, "", drawn.axis, title, columns=0)
    upper.legend(frameon=False, fontsize="small", loc="best")
    lower.axhspan(-2.0, 2.0, color=COLOURS["stick"], alpha=0.2, linewidth=0)
    lower.axhline(0.0, color=COLOURS["line"], linewidth=0.8)
    residual_x = np.array(measurement.coordinate) * scale
    lower.plot(residual_x, residuals, "o", color=COLOURS["line"], markersize=size)
    finished(lower, along.axis, quantity.residual.axis, "", columns=0)
