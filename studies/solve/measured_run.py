"""Comparison of a run with measured velocities, a vibrometer's scan or the trace of a burst, at the measured points."""

import logging
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from studies.lab.encoder import aligned, travelled_distance
from studies.lab.measurement import Measurement
from studies.lab.scan import Scan
from studies.model.model import Model, model_of
from studies.record import Record
from studies.record.scan_comparison import compared_scan
from studies.record.velocity_comparison import VELOCITIES, compared, deviations, missing_burst
from studies.refusal import SceneError
from studies.solve.predictor import Predictor
from studies.solve.scan_prediction import component_and_error, drawn_line, over_frequency, placed

LOGGER = logging.getLogger(__name__)


def measured_block(record: Record, measured: Measurement) -> dict:
    """Return the block ``measured`` of a run: for velocities, a scan, or velocity or position over a burst's time.

    Raises
    ------
    SceneError
        If nothing can be compared: the motor has no velocity at the levels, the scan does not lie on the stator, or
        the run has no burst at the trace's level.
    """
    if measured.quantity in VELOCITIES:
        LOGGER.info("velocities at the measured levels")
        return compared(measured, _velocities_at(record, measured.levels, VELOCITIES[measured.quantity]))
    if measured.scan is None:
        return _trace(record, measured)
    scene, model = record.scene, model_of(record.scene)
    scan = placed(scene, measured.scan)
    LOGGER.info("the field at the measured points")

    def predict(some: Scan):
        if some.kind == "frequency":
            return over_frequency(model, some, tolerance=max(record.tolerance, 1e-3))
        return component_and_error(record.surface_motion, some)

    ratio = None
    if scan.kind == "x" and scan.component.endswith("z") and scan.y[0] == scene.positions[0][1]:
        ratio = record.wave.standing_wave_ratio
    return scan_block(model, scan, predict, ratio)


def _velocities_at(record: Record, levels: tuple[float, ...], also: tuple[str, ...]) -> list[float | None]:
    """Return the steady velocities in m/s of a run at some levels (V or m), None where the motor has none.

    Velocities at levels of the run are taken from its points. The others are computed with the same solution of the
    stator. ``also``: keywords of the answers, with ripple for the mean over place; the mean of a run without ripple is
    the velocity itself.
    """
    answers: dict = {point.level: point for point in record.points}
    missing = [level for level in dict.fromkeys(levels) if level not in answers]
    if missing:
        changes = [{record.scene.level_key: level} for level in missing]
        found = Predictor.of_record(record).answers(changes, also)
        answers |= {level: answer.point for level, answer in zip(missing, found, strict=True)}
    points = [answers[level] for level in levels]
    means = [each.mean_velocity_m_per_s if also else None for each in points]
    return [each.velocity_m_per_s if mean is None else mean for each, mean in zip(points, means, strict=True)]


def scan_block(model: Model, scan: Scan, predict: Callable, ratio: float | None = None) -> dict:
    """Return the comparison of a placed scan with its prediction and the estimated relative error of that.

    ``predict``: takes a placed scan and returns the motion at its points, m per V, and its relative error; ``ratio``:
    the predicted standing-wave ratio about the scene's position, where it is that of the scan's component and line.
    """
    wavelength = model.wavelength
    source, (place, _) = model.scene.driven_transducer.center_xy[0], model.scene.positions[0]
    line = drawn_line(scan, wavelength)
    if line is not None and scan.kind == "frequency":  # one band of frequencies for both
        together = np.append(np.asarray(scan.frequency), np.asarray(line.frequency))
        count, x, y = scan.x.size, np.append(scan.x, line.x), np.append(scan.y, line.y)
        both = replace(scan, x=x, y=y, frequency=together, values=0j * together, deviation=None)
        motion, error = predict(both)
        predicted, drawn = motion[:count], motion[count:]
    else:
        predicted, error = predict(scan)
        drawn = None if line is None else predict(line)[0]
    block = compared_scan(scan, predicted, wavelength=wavelength, source=source, place=place, ratio=ratio)
    if line is not None:
        block["line"] = dict(x_m=line.x, y_m=line.y, predicted_m_per_V=drawn)
        if scan.kind == "frequency":
            block["line"] |= dict(frequency_Hz=line.frequency)
    return block | {"predicted_relative_error": error}


def _trace(record: Record, measured: Measurement) -> dict:
    """Return the comparison of a trace with the trajectory at its level, shifted in time for the best agreement."""
    if not record.trajectories:
        raise missing_burst(record.scene, measured)
    levels = [level for level, _ in record.trajectories]
    measured_level = measured.levels[0] if measured.levels else levels[-1]
    paths = [path for level, path in record.trajectories if math.isclose(level, measured_level, rel_tol=1e-9)]
    if not paths:
        listed = ", ".join(f"{level:.6g}" for level in levels)
        raise SceneError("--measured", f"{measured.name!r} was taken at {measured_level:.6g}, and the run has {listed}")
    path = paths[0]
    time, values = np.array(measured.time), np.array(measured.values)
    curve = path.velocity if measured.quantity == "burst" else travelled_distance(path.time, path.velocity)
    unsigned = bool(np.all(values >= 0.0) and np.mean(curve) < 0.0)
    values = -values if unsigned else values
    offset = aligned(time, values, path.time, curve)
    predicted = np.interp(time - offset, path.time, curve)
    unit = "m_per_s" if measured.quantity == "burst" else "m"
    return {
        "file": measured.name, "quantity": f"{measured.quantity} over time", "compared": len(time),
        "sign_of_prediction_given": unsigned, "time_offset_s": offset,
        "trace": {"time_s": time, f"measured_{unit}": values, f"predicted_{unit}": predicted},
        **deviations(values, predicted, unit),
    }  # fmt: skip
