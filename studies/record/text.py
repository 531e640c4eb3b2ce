"""The answer of a run as text: a table of the points, then its errors and what the model neglects."""

import codecs
import csv
import io
import json
import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

from studies.record.blocks import ElectricalBlock, HeatBlock, SummaryBlock, UncertaintyBlock
from studies.record.quantities import quantity
from studies.scene.plane_keys import AXLE
from studies.scene.roughness_keys import STARTS

if TYPE_CHECKING:
    from studies.record import Record
    from studies.record.point import Point

COLUMNS = (
    "voltage_V", "available_power_W", "normal_amplitude_m", "tangential_amplitude_m", "velocity_m_per_s",
    "lateral_velocity_m_per_s", "yaw_rate_rad_per_s", "rotation_rpm", "torque_N_m", "mean_velocity_m_per_s",
    "mean_lateral_velocity_m_per_s", "mean_rotation_rpm", "lowest_velocity_m_per_s", "highest_velocity_m_per_s",
    "velocity_low_m_per_s",
    "velocity_high_m_per_s", "velocity_at_burst_end_m_per_s",
    "lateral_velocity_at_burst_end_m_per_s", "yaw_rate_at_burst_end_rad_per_s", "displacement_m",
    "lateral_displacement_m", "turn_rad", "path_length_m", "regime", "relative_error",
    "model_relative_error", "status",
)  # fmt: skip  # of a point, as it is printed
OF_CENTRE, OF_AXLE = ("velocity_m_per_s", "lateral_velocity_m_per_s"), ("path_length_m",)  # the first an axle holds
# In the plane a velocity below this times the surface's speed is printed as 0: symmetry makes it 0 but for rounding.
# The least error that is stated, 1e-9 of the speed, is 1000 times larger.
ROUNDING = 1e-12
PER_RPM = math.pi / 30.0  # rad/s
SHARES = {
    "delivered": "W_per_V2",
    "network": "network_W_per_V2",
    "solid": "solid_W_per_V2",
    "loads": "loads_W_per_V2",
    "to the left": "radiated_left_W_per_V2",
    "to the right": "radiated_right_W_per_V2",
}  # share of the available power as printed: its key in run.json after "power_"
LAST_RELEASE = "last_release_voltage_V", "last_release_amplitude_m"
LIMITS = ("threshold_voltage_V", "threshold_amplitude_m", "release_voltage_V", "release_amplitude_m")
ROWS_SHOWN = 30  # of the table in a notebook


def print_json(value: dict) -> None:
    """Print JSON on stdout, in letters that its encoding has."""
    ascii_only = codecs.lookup(sys.stdout.encoding or "ascii").name != "utf-8"
    print(json.dumps(value, indent=1, ensure_ascii=ascii_only, allow_nan=False))


def answer(record: "Record") -> str:
    """Return what a run prints on stdout."""
    lines = [record.scene.title or "no title", ""]
    if record.points:
        head, points = points_table(record)
        shown = [k for k, name in enumerate(head) if name != "status"]
        lines += [*table([[row[k] for k in shown] for row in (head, *points)]), ""]
    entries = found_entries(record)
    bound = f"asked for {record.tolerance:.1e}"
    if record.at_rest:
        error = record.wave.relative_error
        wave = "" if error is None else f"; the relative error of the wave under the slider is {error:.1e}"
        entries.append(("relative error", f"none: no point moves{wave}, {bound}"))
    elif record.error:
        parts = ", ".join(f"{name} {size:.1e}" for name, size in record.error.parts.items())
        model = f"; model {record.error.model:.1e} of u_z or velocity" if record.error.model is not None else ""
        entries.append(("relative error", f"{record.error.relative:.1e} ({parts}), {bound}{model}"))
    seconds = ", ".join(f"{name} {size:.2f}" for name, size in record.seconds.items() if name != "total")
    entries += [("model error", sentences(record)), ("seconds", f"{record.seconds['total']:.2f} ({seconds})")]
    if record.left_out:
        entries.append(("left out", f"{len(record.left_out)} effects: sawmotor run --explain lists them, run.json too"))
    return "\n".join([*lines, *labelled(entries)])


def found_entries(record: "Record") -> list[tuple]:
    """Return name and lines of what a run found besides its points, such as thresholds, power and temperature."""
    entries: list[tuple] = [*_wave(record), *_ripple(record), *_limits(record), *_uncertainty(record.uncertainty)]
    return [*entries, *_heat(record.heat), *comparison(record.measured)]


def labelled(entries, width: int = 16) -> list[str]:
    """Return entries of a name and a line, or several lines, as lines of text with the names at the left.

    Examples
    --------
    >>> labelled([("velocity", "1 m/s"), ("left out", ["heat", "wear"])], 10)
    ['velocity  1 m/s', 'left out  heat', '          wear']
    """
    return [
        f"{name * (k == 0):<{width}}{line}".rstrip()
        for name, lines in entries
        for k, line in enumerate((lines,) if isinstance(lines, str) else lines)
    ]


def markdown(head: Iterable[str], rows: Iterable[Iterable[str]]) -> list[str]:
    """Return a table as lines of Markdown.

    Examples
    --------
    >>> markdown(["a", "b"], [["1", "2"]])
    ['| a | b |', '|---|---|', '| 1 | 2 |']
    """
    head, *body = (f"| {' | '.join(row)} |" for row in (head, *rows))
    return [head, "|" + "---|" * (head.count(" | ") + 1), *body]


def csv_text(rows: Sequence[dict]) -> str:
    """Return rows as CSV, None as an empty cell.

    Examples
    --------
    >>> csv_text([{"a": 1, "b": None}]).splitlines()
    ['a,b', '1,']
    """
    file = io.StringIO()
    writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return file.getvalue()


def table(rows: list[list[str]]) -> list[str]:
    """Return rows of text as aligned lines, numbers to the right."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return ["  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]


def points_table(record: "Record", missing: str = "-") -> tuple[list[str], list[list[str]]]:
    """Return the heads and the rows of a run's points; a quantity that no point has is left out."""
    left_out = OF_CENTRE if record.scene.planar and record.scene.slider.freedom == AXLE else OF_AXLE
    shown = [quantity(key) for key in COLUMNS if key not in left_out and any(key in point for point in record.points)]
    keys = [each.column for each in shown]
    rows = [
        [each.text(_printed(record, point, key)) if key in point else missing
         for each, key in zip(shown, keys, strict=True)]
        for point in record.points
    ]  # fmt: skip
    return [each.heading for each in shown], rows


def _printed(record: "Record", point: "Point", key: str):
    """Return a value of a point as it is printed: a velocity in the plane that is rounding is 0."""
    value = point[key]
    unit = quantity(key).unit
    if not record.scene.planar or unit not in ("m/s", "rad/s", "1/min"):
        return value
    amplitude = max(point.normal_amplitude_m or 0.0, point.tangential_amplitude_m or 0.0)
    speed = 2.0 * math.pi * record.scene.frequency * amplitude
    if unit == "m/s":
        return 0.0 if abs(value) < ROUNDING * speed else value
    arm = max(math.hypot(*each) for each in record.scene.slider.offsets)
    rate = value * PER_RPM if unit == "1/min" else value
    return 0.0 if abs(rate) * arm < ROUNDING * speed else value


def notebook_table(record: "Record", caption: str) -> str:
    """Return the points as a table in HTML, with a caption above and the warnings below."""

    def row(kind: str, cells: list[str]) -> str:
        return f"<tr>{''.join(f'<{kind}>{escape(cell)}</{kind}>' for cell in cells)}</tr>"

    heads, rows = points_table(record, missing="")
    body = "".join(row("td", cells) for cells in rows[:ROWS_SHOWN])
    more = f"<p>{len(rows) - ROWS_SHOWN} more</p>" if len(rows) > ROWS_SHOWN else ""
    notes = "".join(f"<li>{escape(note)}</li>" for note in record.warnings)
    return f"<p>{escape(caption)}</p><table>{row('th', heads)}{body}</table>{more}<ul>{notes}</ul>"


def _wave(record: "Record"):
    """Yield name and text of the wave: free, or under the slider with the electrical side."""
    wave, electrical = record.wave, record.electrical
    if not record.points:
        for key in ("phase_velocity_m_per_s", "surface_ratio", "attenuation_per_m"):
            yield quantity(key).head, _stated(wave, key)
    if not electrical:
        return
    size = abs(wave.normal_m_per_V)
    where = "under the first contact" if record.scene.planar else "at the slider's position"
    amplitude = f"{quantity.normal_m_per_V.with_unit(size)} {where}"
    ratio = f"standing-wave ratio {wave.standing_wave_ratio:.3g}"
    yield "wave", f"{amplitude}, {_stated(wave, 'phase_velocity_m_per_s')}, {ratio}"
    if wave.section_normal_m_per_V is not None:
        change = abs(wave.section_normal_m_per_V) / size - 1
        yield "diffraction", f"the plane section would give {percent(change)} {where}"
    yield "admittance", _stated(electrical, "admittance_S")
    yield from _source(electrical, record.scene.drive)


def _heat(block: HeatBlock):
    """Yield where the power goes at the largest level, and how warm a continuous drive makes the stator."""
    if not block:
        return
    named = (("into the left end", "left_end"), ("into the right end", "right_end"), ("dielectric loss", "dielectric"),
             ("lost in the solid along the beam", "along_beam"), ("into loads", "loads"))  # fmt: skip
    power = quantity("heat.power_W")
    shares = [f"{power.with_unit(block[f'power_{key}_W'])} {name}" for name, key in named
              if block[f"power_{key}_W"] > 1e-4 * block.power_W]  # fmt: skip
    yield "power", f"{power.with_unit(block.power_W)} at {block.voltage_V:g} V: {', '.join(shares)}"
    how = "a continuous drive" if block.duty is None else f"a drive with a duty of {100 * block.duty:.3g} %"
    if block.burst_rise_K is not None:
        burst = f"one burst warms the stator by {block.burst_rise_K:.2g} K; drive.duty gives the heat of many"
        yield "temperature", burst
    if block.highest_rise_K is None:
        return
    rise = quantity("heat.highest_rise_K")

    def banded(key: str) -> str:
        low, high = (rise.text(block[f"{key}_rise{side}_K"]) for side in ("_low", "_high"))
        return f"+{rise.with_unit(block[f'{key}_rise_K'])} ({low} to {high})"

    places = [("slider", "slider"), ("fingers", "fingers"), ("left end", "left_end"), ("right end", "right_end")]
    rises = ", ".join(f"{name} {banded(key)}" for name, key in places if f"{key}_rise_K" in block)
    lines = [f"steady: {rises}"]
    if block.heating_rate_K_per_s is not None:
        rate, settling = f"{block.heating_rate_K_per_s:.2g} K/s", f"{block.time_constant_s:.3g} s"
        lines.insert(0, f"{how} warms the stator by {rate} at first, with a time constant of {settling}")
    if block.steady_temperature_degC is not None:
        lines.append(_steady(block))
    if block.continuous_limit_voltage_V is not None:
        most = quantity("heat.continuous_limit_voltage_V").with_unit(block.continuous_limit_voltage_V)
        share = f"; at {block.voltage_V:g} V a duty of {100 * block.duty_limit:.3g} %" if block.duty_limit < 1.0 else ""
        lines.append(f"below half its Curie temperature: up to {most} continuous{share}")
    if block.frequency_drift is not None:
        drift = f"{1e6 * block.frequency_drift:.3g} ppm of the frequency"
        factor = f"amplitude of the transducer x {block.warm_amplitude_factor:.4f}"
        more = "" if block.foldover_number is None else f", foldover number {block.foldover_number:.2g}"
        lines.append(f"{drift}, {factor} at a fixed frequency{more}")
    yield "temperature", lines


def _steady(block: HeatBlock) -> str:
    """Return the temperature at which the run is solved, its branch and the folds."""
    degrees, hertz = quantity("heat.steady_temperature_degC"), quantity("wave.frequency_Hz")
    text = f"solved at its own steady temperature of {degrees.with_unit(block.steady_temperature_degC)}"
    if block.branch == "cold":
        others = ", ".join(degrees.with_unit(each) for each in block.other_temperatures_degC)
        text += f", to which a cold start comes; {others} is stable too"
    if block.fold_frequencies_Hz:
        folds = ", ".join(hertz.with_unit(each) for each in block.fold_frequencies_Hz)
        text += f"; folds at {folds} (foldover number {block.foldover_number:.3g})"
    return text


def _ripple(record: "Record"):
    """Yield name and text of the velocity's range over half a wavelength, and which velocity is which."""
    summary = record.summary
    if summary.velocity_ripple is None:
        return
    where = quantity.ripple_to_m.interval(summary.ripple_from_m, summary.ripple_to_m)
    size = quantity.velocity_ripple.with_unit(summary.velocity_ripple)
    errors = [point.mean_velocity_relative_error for point in record.points if point.mean_velocity_m_per_s is not None]
    if not errors:
        if record.at_rest:
            return
        yield "ripple", f"the velocity differs by {size} at most within half a wavelength, {where}: below the tolerance"
        return
    yield "ripple", f"velocity: at the slider's position; mean (over place), lowest and highest: within {where}, half a"
    yield (
        "",
        f"wavelength of a partly standing wave (range up to {size} of the mean, or of a tenth of the surface's speed;",
    )
    yield "", f"relative error up to {max(errors):.1e})"


def _source(electrical: ElectricalBlock, drive):
    """Yield name and text of the matching network, the shares of the available power, and the recovered power."""
    if drive.match != "none":
        parts = [str(each) for each in drive.match]
        yield "match", ", ".join(parts) + " (from the source to the transducer)"
    available = electrical.power_available_W_per_V2
    if available is not None:
        share = quantity.power_share
        shares = (f"{name} {share.with_unit(electrical[f'power_{key}'] / available)}" for name, key in SHARES.items())
        yield "power", f"of the available: {', '.join(shares)}"
        yield "electrodes", f"{abs(electrical.comb_voltage_per_volt):.4g} V per V of the source"
    ratio = electrical.recovery_ratio
    if ratio is not None:
        load = complex(drive.recovery.load)
        recovered = f"{quantity.power_share.with_unit(ratio)} of the power into the transducers"
        yield "recovered", f"{recovered}, in {load.real:.4g} {load.imag:+.4g}i ohm"
    if electrical.power_net_W_per_V2 is not None:
        less = electrical.power_W_per_V2 / electrical.power_net_W_per_V2
        gives = f"the source gives 1/{less:.4g} of the power into the transducers"
        yield "circulation", f"{gives}; gain of the loop {ratio:.4g}, stable below 1"


def _uncertainty(block: UncertaintyBlock):
    """Yield name and text of the method of the bands, and of the effect of each tolerance at the highest level."""
    if not block:
        return
    method = "linear, tolerances added in quadrature"
    if block.samples is not None:
        method = f"percentiles of {block.samples} samples (Latin hypercube)"
    yield "uncertainty", f"bands of 95 %: {method}"
    for key, count in (block.bent or {}).items():
        at = f" at {count} points" if count else ""
        nonlinear = f"the answer is nonlinear within the tolerance of {key}{at}"
        yield "", f"{nonlinear}: the band includes its middle and its ends;"
        yield "", 'uncertain.method = "sampled" is more accurate'
    widths, velocity = block.velocity_half_width_m_per_s or {}, quantity.velocity_m_per_s
    for key, size in block.tolerances.items():
        effect = f": +- {velocity.with_unit(widths[key])} at the highest level" if key in widths else ""
        yield "", f"{key} +- {size:.4g}{effect}"
    for limit in map(quantity, LIMITS):
        if limit.column in block:
            yield "", f"{limit.head} {limit.interval(*block[limit.column])}"


def percent(change: float) -> str:
    """Return a relative change in percent, to two digits.

    Examples
    --------
    >>> percent(1.283), percent(-0.0066)
    ('+130 %', '-0.66 %')
    """
    return f"{float(f'{100 * change:.2g}'):+g} %"  # 130, not 1.3e+02


def sentences(record: "Record") -> tuple[str, ...]:
    """Return a line for every effect above the tolerance, and one that names those below it."""
    lines, small = [], []
    for each in record.model_error:
        if each.unit is not None:
            lines.append(f"{each.effect}: up to {each.size:.2g} {each.unit}, {each.quantity}")
        elif abs(each.size) < record.tolerance:
            small.append(each.effect)
        else:
            lines.append(f"{each.effect}: {percent(each.size)} of {each.quantity}")
    return tuple(lines + ([f"below the tolerance: {', '.join(small)}"] if small else []))


def comparison(block: dict):
    """Yield name and text of the lines that a run prints of a comparison with measurements."""
    if not block:
        return
    if "scan" in block:
        from studies.record.scan_comparison import scan_comparison  # with the reader of scans, 4 ms

        yield from scan_comparison(block)
        return
    if "trace" in block:
        yield "measured", f"{block['compared']} instants of {block['file']} compared, {block['quantity']}"
        if "measured_over_predicted" not in block:
            yield "", "no motion is predicted"
            return
        yield "", f"deviation {_stated(block, 'rms_deviation_relative')} rms of the largest predicted"
        start = quantity.time_s.with_unit(block["time_offset_s"])
        yield "", f"measured / predicted {block['measured_over_predicted']:.4g}, begins at {start}"
        return
    of = f", with the prediction {block['of']}" if "of" in block else ""
    yield "measured", f"{block['compared']} of {len(block['points'])} points of {block['file']} compared{of}"
    rms, mean = (_stated(block, f"{kind}_deviation_m_per_s") for kind in ("rms", "mean"))
    relative = "rms_deviation_relative"
    share = f" ({_stated(block, relative)} of the largest predicted)" if relative in block else ""
    yield "", f"deviation {rms} rms{share}, mean {mean}"
    if "measured_over_predicted" in block:
        ratio = abs(block["measured_over_predicted"])
        doubt = "; is the file in m/s?" if any(0.3 < ratio / power < 3 for power in (1e-3, 1e3)) else ""
        yield "", f"measured / predicted {block['measured_over_predicted']:.3g} (least squares){doubt}"
    if "within_one_error" in block:
        within = f"{block['within_one_error']} of {block['compared']} within their error"
        yield "", f"{within}, chi^2 per point {block['chi_square_per_point']:.3g}"
    if block["sign_of_prediction_given"]:
        yield "", "measured without a sign: the predicted direction is assumed"
    yield from (("", each) for each in block.get("remarks", ()))


def _stated(block: Mapping, key: str) -> str:
    return quantity(key).with_unit(block[key])


def _limits(record: "Record"):
    """Yield name and text of threshold and release."""
    summary, slider = record.summary, record.scene.slider
    starts = "starts to move" if slider is None or slider.roughness is None else f"runs at {1e3 * STARTS:g} mm/s"
    for name, motion in (("threshold", starts), ("release", "leaves the surface in every cycle")):
        levels = [_stated(summary, key) for key in LIMITS if key in summary and quantity(key).head == name]
        if name == "threshold" and summary.threshold_amplitude_m == 0.0:
            if slider.scalar_load > 0.0:
                yield name, "none: the load exceeds friction and moves the slider without a wave"
            else:
                lacking = "friction" if slider.preload_force > 0.0 else "a preload"
                yield name, f"none: without {lacking} the wave does not move the slider"
        elif levels:
            who = leaving(summary, motion) if name == "release" else f"the slider {motion}"
            yield name, f"{', '.join(levels)}: {who}"


def leaving(summary: SummaryBlock, motion: str) -> str:
    """Return in words what begins at the release: of the slider, or of the first of several contacts and of the last.

    ``motion``: what it does.
    """
    if summary.first_released_contact is None:
        return f"the slider {motion}"
    first = f"contact {summary.first_released_contact}, the first of {summary.touching_contacts}, {motion}"
    if summary.last_released_contact is None:
        return f"{first}; one or more never do"
    last = [_stated(summary, key) for key in LAST_RELEASE if key in summary]
    return f"{first}; contact {summary.last_released_contact} is the last, from {', '.join(last)} on"
