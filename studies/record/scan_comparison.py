"""A vibrometer's scan beside the computed field: their difference in size, phase, ripple and position of the beam."""

import numpy as np

import fem
from studies.lab.scan import Scan
from studies.record.quantities import quantity

PER_WAVELENGTH = 6  # points of a line from which its standing-wave ratio is computed
INTERPOLATED = 10  # points from which on a complex wave is interpolated between them (`fem.standing_wave_ratio`)


def compared_scan(
    scan: Scan, predicted: np.ndarray, *, wavelength: float, source: float, place: float | None = None,
    ratio: float | None = None,
) -> dict:  # fmt: skip
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
    place : float, optional
        x in m within a wavelength of which the standing-wave ratios are stated, or the next one that the scan covers;
        by default the middle of the scan.
    ratio : float, optional
        Predicted standing-wave ratio at this place, where it is known from all of the field; otherwise both follow from
        the measured points.
    """
    values = scan.values if scan.is_complex else np.abs(scan.values)
    own = predicted if scan.is_complex else np.abs(predicted)
    weight = float(np.sum(np.abs(own) ** 2)) or 1e-300
    factor = complex(np.sum(np.conj(own) * values)) / weight
    points = dict(x_m=scan.x, y_m=scan.y, measured_m_per_V=values, predicted_m_per_V=predicted)
    if scan.frequency is not None:
        points |= dict(frequency_Hz=scan.frequency)
    block = {
        "file": scan.name, "quantity": f"scan of {scan.component} over {scan.kind}", "compared": len(values),
        "scan": points,
        "measured_over_predicted": abs(factor),
        "rms_deviation_relative": _rms(values - own) / _rms(own),
        "rms_deviation_of_shape": _rms(values - factor * own) / _rms(values),
    }  # fmt: skip
    if scan.is_complex:
        block["phase_of_measured_rad"] = float(np.angle(factor))
    block |= _ripple(scan, values, predicted, wavelength, (place, ratio))
    block |= _velocity(scan, values, predicted, wavelength, source)
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


def _ripple(scan: Scan, values, predicted, wavelength: float, known: tuple[float | None, float | None]) -> dict:
    """Return the standing-wave ratios of a line along x that resolves them; ``known``: place and ratio, as above."""
    if scan.kind != "x" or len(values) < 3 or np.ptp(scan.x) < wavelength / 2:
        return {}
    order, (place, ratio) = np.argsort(scan.x), known
    x = scan.x[order]
    if np.max(np.diff(x)) > wavelength / PER_WAVELENGTH * (1 + 1e-9):
        return {}
    reach = min(wavelength, np.ptp(x) / 2)
    middle = 0.5 * (x[0] + x[-1])
    at = middle if place is None else float(np.clip(place, x[0] + reach, max(x[-1] - reach, x[0] + reach)))
    inside = np.abs(x - at) <= reach * (1 + 1e-9)
    own = predicted if scan.is_complex else np.abs(predicted)
    measured, computed = (_standing_wave_ratio(x[inside], each[order][inside], wavelength) for each in (values, own))
    if ratio is not None and at == place:
        # what the points leave out of the pattern they leave out of both
        measured, computed = measured * ratio / computed, ratio
    return {
        "measured_standing_wave_ratio": float(measured), "predicted_standing_wave_ratio": float(computed),
        "standing_wave_ratio_at_m": at,
    }  # fmt: skip


def _standing_wave_ratio(x, values, wavelength: float) -> float:
    """Return the largest over the smallest amplitude along a line; without phases or with few points by two waves.

    The square of the amplitude of two opposite waves is a constant and a cosine of half the wavelength.
    """
    steps = np.diff(x)
    even = np.ptp(steps) < 1e-3 * np.max(steps) and np.max(steps) <= wavelength / INTERPOLATED * (1 + 1e-9)
    if np.iscomplexobj(values) and even:
        return fem.standing_wave_ratio(values)
    phase = 4.0 * np.pi / wavelength * x
    waves = np.stack([np.ones_like(x), np.cos(phase), np.sin(phase)], axis=1)
    (mean, *both), *_ = np.linalg.lstsq(waves, np.abs(values) ** 2, rcond=None)
    swing = float(np.hypot(*both))
    if swing < mean:
        return float(np.sqrt((mean + swing) / (mean - swing)))
    return float(np.max(np.abs(values)) / max(np.min(np.abs(values)), 1e-300))


def _velocity(scan: Scan, values, predicted, wavelength: float, source: float) -> dict:
    """Return the ratio of the wave velocities along a line in x with phases."""
    if scan.kind != "x" or len(values) < 3 or not scan.is_complex:
        return {}
    order = np.argsort(scan.x)
    distance = abs(scan.x - source)[order]
    phase = np.unwrap(np.angle(values[order] * np.conj(predicted[order])))
    slope = float(np.polyfit(distance, phase, 1, w=np.abs(predicted[order]))[0])
    # the predicted phase is -k times the distance: a slope s of the difference is a measured wavenumber k - s
    wavenumber = 2.0 * np.pi / wavelength
    return {"measured_wave_velocity_over_predicted": wavenumber / (wavenumber - slope)}


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
    share = quantity.rms_deviation_relative
    whole, shape = (share.with_unit(block[f"rms_deviation_{kind}"]) for kind in ("relative", "of_shape"))
    yield "", f"deviation {whole} rms; {shape} after a fit of size and phase"
    if "predicted_relative_error" in block:
        error = share.with_unit(block["predicted_relative_error"])
        yield "", f"numerical error of the prediction {error} rms"
    if "measured_standing_wave_ratio" in block:
        ratios = (block[f"{name}_standing_wave_ratio"] for name in ("measured", "predicted"))
        where = quantity.x_m.with_unit(block["standing_wave_ratio_at_m"])
        yield "", "standing-wave ratio {:.4g} measured, {:.4g} predicted".format(*ratios) + f", about x = {where}"
    if "measured_wave_velocity_over_predicted" in block:
        away = block["measured_wave_velocity_over_predicted"] - 1.0
        yield "", f"wave velocity {100 * away:+.3g} % of the predicted, by the phase along x"
    if "beam_center_measured_m" in block:
        centers = (quantity.y_m.with_unit(block[f"beam_center_{name}_m"]) for name in ("measured", "predicted"))
        yield "", "middle of the beam at y = {} measured, {} predicted".format(*centers)
    if "measured_maximum_at_Hz" in block:
        maxima = (quantity.frequency_Hz.with_unit(block[f"{name}_maximum_at_Hz"]) for name in ("measured", "predicted"))
        yield "", "largest at {} measured, {} predicted".format(*maxima)
    if "chi_square_per_point" in block:
        yield "", f"chi^2 per number {block['chi_square_per_point']:.3g}"
