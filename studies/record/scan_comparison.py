"""A vibrometer's scan beside the computed field: their difference in size, phase, ripple and position of the beam."""

import numpy as np

from studies.lab.scan import Scan
from studies.record.quantities import quantity

PER_WAVELENGTH = 6  # points of a line from which its standing-wave ratio is computed


def compared_scan(scan: Scan, predicted: np.ndarray, *, wavelength: float, source: float) -> dict:
    """Return the block ``measured`` of run.json for a scan per volt and its prediction.

    Parameters
    ----------
    scan : Scan
        Displacements per volt.
    predicted : ndarray
        Complex, m per V.
    wavelength : float
        Of the surface wave, m.
    source : float
        x of the middle of the driven transducer, m.
    """
    values = scan.values if scan.is_complex else np.abs(scan.values)
    own = predicted if scan.is_complex else np.abs(predicted)
    weight = float(np.sum(np.abs(own) ** 2)) or 1e-300
    factor = complex(np.sum(np.conj(own) * values)) / weight
    points = {
        "x_m": scan.x, "y_m": scan.y, "measured_m_per_V": values, "predicted_m_per_V": predicted,
    }  # fmt: skip
    if scan.frequency is not None:
        points["frequency_Hz"] = scan.frequency
    block = {
        "file": scan.name, "quantity": f"scan of {scan.component} over {scan.kind}", "compared": len(values),
        "scan": points,
        "measured_over_predicted": abs(factor),
        "rms_deviation_relative": _rms(values - own) / _rms(own),
        "rms_deviation_of_shape": _rms(values - factor * own) / _rms(values),
    }  # fmt: skip
    if scan.is_complex:
        block["phase_of_measured_rad"] = float(np.angle(factor))
    block |= _along(scan, values, predicted, wavelength, source)
    if scan.kind in ("y", "x, y"):
        block |= {f"beam_center_{name}_m": _center(scan.y, each) for name, each in _pair(values, predicted)}
    if scan.frequency is not None and scan.kind == "frequency":
        block |= {f"{name}_maximum_at_Hz": float(scan.frequency[np.argmax(np.abs(each))])
                  for name, each in _pair(values, predicted)}  # fmt: skip
    if scan.remarks:
        block["remarks"] = list(scan.remarks)
    if scan.deviation is not None:
        ratios = np.abs(values - own) / scan.deviation
        count = 2.0 if scan.is_complex else 1.0
        block["chi_square_per_point"] = float(np.mean(ratios**2) / count)
    return block


def _rms(values) -> float:
    return float(np.sqrt(np.mean(np.abs(values) ** 2)))


def _pair(measured, predicted):
    return ("measured", measured), ("predicted", predicted)


def _along(scan: Scan, values, predicted, wavelength: float, source: float) -> dict:
    """Return the standing-wave ratios of a line along x that resolves them, and the ratio of the wave velocities."""
    if scan.kind != "x" or len(values) < 3:
        return {}
    columns, order = {}, np.argsort(scan.x)
    step = np.max(np.diff(scan.x[order]))
    if step <= wavelength / PER_WAVELENGTH and np.ptp(scan.x) >= wavelength / 2:
        for name, each in _pair(values, predicted):
            sizes, half = np.abs(each[order]), max(2, round(wavelength / 2 / step))
            # of each half wavelength, the period of the ripple: diffraction and loss change slowly
            ratios = [
                np.max(part) / max(np.min(part), 1e-300) for part in np.array_split(sizes, max(1, len(sizes) // half))
            ]
            columns[f"{name}_standing_wave_ratio"] = float(np.median(ratios))
    if scan.is_complex:
        distance = abs(scan.x - source)[order]
        phase = np.unwrap(np.angle(values[order] * np.conj(predicted[order])))
        slope = float(np.polyfit(distance, phase, 1, w=np.abs(predicted[order]))[0])
        # the predicted phase is -k times the distance: a slope s of the difference is a measured wavenumber k - s
        wavenumber = 2.0 * np.pi / wavelength
        columns["measured_wave_velocity_over_predicted"] = wavenumber / (wavenumber - slope)
    return columns


def _center(y, values) -> float:
    power = np.abs(values) ** 2
    return float(np.sum(y * power) / np.sum(power))


def scan_comparison(block: dict):
    """Yield name and text of the lines that a run prints of a scan's comparison."""
    points = f"{block['compared']} points of {block['file']}"
    yield "measured", f"{points}, a {block['quantity']}, compared at their positions"
    yield from (("", each) for each in block.get("remarks", ()))
    phase = block.get("phase_of_measured_rad")
    turned = "" if phase is None else f", phase {np.degrees(phase):+.3g} deg"
    yield "", f"measured / predicted {block['measured_over_predicted']:.4g}{turned}"
    share = quantity("rms_deviation_relative")
    whole, shape = (share.with_unit(block[f"rms_deviation_{kind}"]) for kind in ("relative", "of_shape"))
    yield "", f"deviation {whole} rms; {shape} after a fit of size and phase"
    if "predicted_relative_error" in block:
        error = share.with_unit(block["predicted_relative_error"])
        yield "", f"numerical error of the prediction {error} rms"
    if "measured_standing_wave_ratio" in block:
        ratios = (block[f"{name}_standing_wave_ratio"] for name in ("measured", "predicted"))
        yield "", "standing-wave ratio {:.4g} measured, {:.4g} predicted".format(*ratios)
    if "measured_wave_velocity_over_predicted" in block:
        away = block["measured_wave_velocity_over_predicted"] - 1.0
        yield "", f"wave velocity {100 * away:+.3g} % of the predicted, by the phase along x"
    if "beam_center_measured_m" in block:
        centers = (quantity("y_m").with_unit(block[f"beam_center_{name}_m"]) for name in ("measured", "predicted"))
        yield "", "middle of the beam at y = {} measured, {} predicted".format(*centers)
    if "measured_maximum_at_Hz" in block:
        maxima = (
            quantity("frequency_Hz").with_unit(block[f"{name}_maximum_at_Hz"]) for name in ("measured", "predicted")
        )
        yield "", "largest at {} measured, {} predicted".format(*maxima)
    if "chi_square_per_point" in block:
        yield "", f"chi^2 per number {block['chi_square_per_point']:.3g}"
