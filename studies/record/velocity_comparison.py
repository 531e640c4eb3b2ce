"""Measured velocities beside the predictions of a run, and which measurements a run can be compared with."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.parameters import refuses
from studies.lab.measurement import Measurement
from studies.record.quantities import quantity
from studies.refusal import SceneError, refuse_if

if TYPE_CHECKING:
    from studies.scene import Scene

OPTION = "--measured"
# quantities of a measurement that a run predicts at its levels, and the keywords that request them of a point
VELOCITIES: dict[str, tuple[str, ...]] = {"velocity": (), "mean velocity": ("ripple",)}


@refuses(SceneError)
def refuse_incomparable(scene: "Scene", measured: Measurement) -> Iterator[Any]:
    """Raise a SceneError if a run of the scene does not predict the measured quantity."""
    if measured.quantity == "scan":
        if scene.stator is None or not scene.transducer:
            yield OPTION, f"{measured.name!r} is a scan: it needs a scene with a driven stator"
        return
    if measured.quantity == "network":
        yield OPTION, f"{measured.name!r} is a network analyser's: sawmotor study network draws it"
    if scene.slider is None:
        yield OPTION, "needs a scene with a [slider]: there is no velocity to compare with"
    level = scene.level_column
    if measured.quantity in ("burst", "position"):
        if scene.planar:
            yield OPTION, f"{measured.name!r} holds a burst, which is compared with a slider along x alone"
        elif scene.burst is None:
            raise missing_burst(scene, measured)
        return
    if measured.quantity not in VELOCITIES:
        remedy = ": sawmotor fit compares it" if measured.quantity in ("lateral velocity", "yaw rate") else ""
        yield OPTION, f"must hold velocities against {level}, got a {measured.quantity}{remedy}"
    if measured.level_key != level:
        yield OPTION, f"must have the column {level} for this scene, got {measured.level_key}"


def missing_burst(scene: "Scene", measured: Measurement) -> SceneError:
    """Return the refusal of a measured burst by a scene without one."""
    setting = f'--set {scene.source.block}.burst="0.1 s"'
    return SceneError(OPTION, f"{measured.name!r} holds a burst: {setting} sets its duration")


def deviations(measured: np.ndarray, predicted: np.ndarray, unit: str) -> dict[str, float]:
    """Return the deviations of measured values from predicted ones, with keys that end in the ``unit`` of both.

    ``measured_over_predicted`` is the ratio by least squares; like the relative deviation, it is absent if all
    predictions are 0.
    """
    difference, largest = measured - predicted, float(np.max(np.abs(predicted)))
    rms = float(np.sqrt(np.mean(difference**2)))
    columns = {f"rms_deviation_{unit}": rms, f"mean_deviation_{unit}": float(np.mean(difference))}
    if largest > 0.0:
        columns["rms_deviation_relative"] = rms / largest
        columns["measured_over_predicted"] = float(np.sum(measured * predicted) / np.sum(predicted**2))
    return columns


def compared(measured: Measurement, predicted: list[float | None]) -> dict:
    """Return the block ``measured`` of run.json: the measured points, their predictions and the deviations.

    Speeds that were measured without a sign get the sign of the prediction.

    Parameters
    ----------
    measured : Measurement
        Velocities.
    predicted : list of float or None
        Velocity at each level of the measurement, m/s; None where the motor has no steady velocity.

    Raises
    ------
    SceneError
        If there is no level with both a measured and a predicted velocity.
    """
    answered = np.array([each is not None for each in predicted])
    refuse_if(not answered.any(), OPTION, "has nothing to be compared with: the motor has no velocity at its levels")
    expected = np.array([each or 0.0 for each in predicted])
    velocity = np.array(measured.values)
    unsigned = bool(np.all(velocity >= 0) and np.all(expected <= 0) and np.any(expected < 0))
    if unsigned:
        velocity = -velocity
    points = []
    for k, level in enumerate(measured.levels):
        point = {measured.level_key: float(level), quantity.velocity_m_per_s.column: float(velocity[k]) + 0.0}
        if measured.deviations is not None:
            point["error_m_per_s"] = measured.deviations[k]
        if answered[k]:
            point["predicted_m_per_s"] = float(expected[k])
        points.append(point)
    block: dict = {
        "file": measured.name,
        "points": points,
        "compared": int(answered.sum()),
        "of": "mean over half a wavelength" if measured.quantity == "mean velocity" else "at the position",
        "sign_of_prediction_given": unsigned,
        **deviations(velocity[answered], expected[answered], "m_per_s"),
    }
    if measured.deviations is not None:
        ratios = (velocity - expected)[answered] / np.array(measured.deviations)[answered]
        block["within_one_error"] = int(np.sum(abs(ratios) <= 1))
        block["chi_square_per_point"] = float(np.mean(ratios**2))
    if measured.remarks:
        block["remarks"] = list(measured.remarks)
    return block
