"""Prediction of a vibrometer's scan: the surface motion of a scene at its positions or frequencies, per volt."""

import logging
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from fem.parameters import refuses
from studies.lab.s_parameters import NetworkData
from studies.lab.scan import COMPONENTS, Scan
from studies.model.model import Model
from studies.record.quantities import quantity
from studies.refusal import SceneError, refuse_if
from studies.scene import Scene
from studies.solve import passband
from studies.solve.scattering import scattering_matrix
from studies.solve.spectrum import response
from studies.solve.surface_motion import SurfaceMotion, solved_motion

LOGGER = logging.getLogger(__name__)
DRAWN = 24  # points per wavelength of the line that is drawn
MOST_DRAWN = 4000
BETWEEN = 4  # of a scan over few frequencies, parts of the intervals between them
MOST_FREQUENCIES = 240  # that are drawn; of more the measured ones alone


def placed(scene: Scene, scan: Scan, option: str = "--measured") -> Scan:
    """Return the displacements of a scan at all its positions, on the stator of a resolved scene.

    Of a scan over positions and frequencies the line at the drive's frequency is taken.  A coordinate that the file
    leaves out is the slider's or, without a slider, that of the stator's middle.

    Raises
    ------
    SceneError
        If the scene drives no stator, a position lies beside it, or the scan was taken at another frequency.
    """
    refuse_if(
        scene.stator is None or not scene.transducer,
        option,
        f"{scan.name!r} is a vibrometer's scan: it needs a scene with a driven stator",
    )
    x, y = scene.positions[0]
    scan = scan.at_line(scene.frequency, option)
    complete = replace(scan, x=np.where(np.isnan(scan.x), x, scan.x), y=np.where(np.isnan(scan.y), y, scan.y))
    length, half = scene.stator.length, scene.stator.width / 2
    for name, values, low, high in (("x", complete.x, 0.0, length), ("y", complete.y, -half, half)):
        if np.min(values) < low or np.max(values) > high:
            here = quantity.x_m
            rule = f"{scan.name!r}: {name} must lie on the stator, {here.with_unit(low)} to {here.with_unit(high)}"
            found = f"{here.with_unit(np.min(values))} to {here.with_unit(np.max(values))}"
            raise SceneError(option, "; ".join((f"{rule}, got {found}", *scan.remarks)))
    if complete.frequency is not None and complete.kind != "frequency":
        taken = complete.frequency[0]
        rule = f"{scan.name!r} was taken at {taken:.7g} Hz, and the scene drives {scene.frequency:.7g} Hz"
        refuse_if(abs(taken / scene.frequency - 1.0) > scan.resolution, option, f"{rule}: set drive.frequency")
    return complete.as_displacement(scene.frequency)


def component_and_error(motion: SurfaceMotion, scan: Scan) -> tuple[np.ndarray, float]:
    """Return the component of a scan at its positions, complex, m per V, and its rms error over its rms size.

    The error of a place is relative to the larger of |u_x| and |u_z| there, and large where a beam has ended.
    """
    positions = _positions(scan)
    values = motion.at(positions)
    sizes = np.max(np.abs(values[[0, 2]]), axis=0)
    return values[COMPONENTS.index(scan.component)], _rms(motion.errors(positions) * sizes) / _rms(sizes)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _positions(scan: Scan) -> tuple[tuple[float, float], ...]:
    return tuple(zip(scan.x.tolist(), scan.y.tolist(), strict=True))


def over_frequency(model: Model, scan: Scan, *, tolerance: float) -> tuple[np.ndarray, float]:
    """Return the component of a scan at its frequencies, complex, m per V, of the plane section, and its error.

    Raises
    ------
    SceneError
        For u_y, which a section does not have, several positions or one beside the middle line.
    """
    x = float(scan.x[0])
    several = np.ptp(scan.x) > 0.0 or np.any(scan.y != 0.0)
    if scan.frequency is None or scan.component == "u_y" or several or model.scene.crossed:
        rule = "over frequency must be of u_x or u_z at one position on the middle line, without rotated transducers"
        raise SceneError("--measured", f"{scan.name!r} {rule}")
    at, number = np.unique(scan.frequency, return_inverse=True)
    alone = model.alone
    over_band = response(alone, at[0], at[-1], positions=(x,), tolerance=tolerance)
    LOGGER.info(f"stator: {len(at)} frequencies")
    waves = over_band.waves(at, alone.drive)
    component = "xz".index(scan.component[-1])
    motion = np.array([wave.motion(x)[component] for wave in waves])[number]
    return motion, float(max(wave.relative_error for wave in waves))


def predicted_scan(model: Model, scan: Scan, *, tolerance: float) -> np.ndarray:
    """Return the motion of a resolved scene at the points of a placed scan, complex, m per V."""
    return scan_and_error(model, scan, tolerance=tolerance)[0]


def scan_and_error(model: Model, scan: Scan, *, tolerance: float) -> tuple[np.ndarray, float]:
    """Return the motion at the points of a placed scan, m per V, and its estimated relative error, rms."""
    if scan.kind == "frequency":
        return over_frequency(model, scan, tolerance=tolerance)
    # solved for one position: all others, also off the axis, are evaluated from the same solution
    first = _positions(scan)[:1]
    motion = solved_motion(model.alone, first, tolerance=tolerance, slider=True, missed=True)
    return component_and_error(motion, scan)


def drawn_line(scan: Scan, wavelength: float) -> Scan | None:
    """Return the places or frequencies of a line through a placed scan, close enough to draw the motion; m, Hz.

    Of a scan over an area it is the row, with one y and three points or more, that is nearest to the middle; None if
    there is none.
    """
    x, y, frequency = scan.x, scan.y, scan.frequency
    if scan.kind == "frequency":
        at = np.unique(np.asarray(frequency))
        if BETWEEN * at.size <= MOST_FREQUENCIES:
            at = np.unique(np.interp(np.arange(BETWEEN * (at.size - 1) + 1) / BETWEEN, np.arange(at.size), at))
        count, x, y, frequency = at.size, np.full(at.size, x[0]), np.full(at.size, y[0]), at
    else:
        if scan.kind == "x, y":
            rows, counts = np.unique(y, return_counts=True)
            if not np.any(counts >= 3):
                return None
            rows = rows[counts >= 3]
            row = rows[np.argmin(np.abs(rows - 0.5 * (y.min() + y.max())))]
            x, y = x[y == row], y[y == row]
        across = x if scan.kind != "y" else y
        count = int(min(max(2, np.ceil(np.ptp(across) / wavelength * DRAWN) + 1), MOST_DRAWN))
        ends = np.linspace(across.min(), across.max(), count)
        x, y = (ends, np.full(count, y[0])) if scan.kind != "y" else (np.full(count, x[0]), ends)
        frequency = None if frequency is None else np.full(count, frequency[0])
    return replace(scan, x=x, y=y, frequency=frequency, values=np.zeros(count, complex), deviation=None)


def at_other_velocity(model: Model, scan: Scan, motion: np.ndarray, factor: float) -> np.ndarray:
    """Return a motion along x with the velocity of the surface wave multiplied by a factor.

    The phase lag per distance from the middle of the driven transducer increases by omega/v (1/factor - 1). Amplitudes
    and the phases of reflected waves do not change, which holds for absorbing ends and factors near 1.
    """
    if factor == 1.0:
        return motion
    frequency = model.scene.frequency if scan.frequency is None else scan.frequency
    velocity = model.wave_velocity(float(np.median(frequency)))
    distance = abs(scan.x - model.scene.driven_transducer.center_xy[0])
    return motion * np.exp(-2j * np.pi * frequency / velocity * (1.0 / factor - 1.0) * distance)


def network_prediction(model: Model, data: NetworkData, *, tolerance: float) -> np.ndarray:
    """Return the S-parameters (n, ports, ports) of the transducers with two electrodes at the n frequencies of a file.

    Raises
    ------
    SceneError
        If the file has another number of ports, or its frequencies lie outside the driven transducer's passband.
    """
    names = [each.name for each in model.scene.transducer if each.has_two_electrodes]
    if data.ports != len(names):
        hint = ": port=N behind the file takes one of them" if len(names) == 1 else ""
        rule = f"{data.name!r} has {data.ports} ports, and the scene {len(names)} transducers with two electrodes{hint}"
        raise SceneError("--data", rule)
    refuse_other_range(model, data, "--data")
    return scattering_matrix(model, data.frequency, data.reference, tolerance)[2]


@refuses(SceneError)
def refuse_other_range(model: Model, data: NetworkData, option: str) -> Iterator[Any]:
    """Refuse a file whose frequencies do not overlap the passband of the driven transducer."""
    band = passband.frequencies(model, 2)
    if data.frequency[-1] < band[0] or data.frequency[0] > band[-1]:
        own = f"{data.frequency[0] / 1e6:.5g} to {data.frequency[-1] / 1e6:.5g} MHz"
        rule = f"{data.name!r} must meet the passband, {band[0] / 1e6:.5g} to {band[-1] / 1e6:.5g} MHz, got {own}"
        yield option, rule
