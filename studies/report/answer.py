"""The answer of a run as text: a table of the points, then what it is worth and what was left out."""

import codecs
import json
import sys

from studies.record import Record
from studies.report.measured import comparison_lines
from studies.scene.match import ELEMENTS

__all__ = ["answer", "notebook_table", "points_table", "print_json", "table"]

COLUMNS = (
    ("voltage (V)", "voltage_V", lambda value: f"{value:g}"),
    ("available (W)", "available_power_W", lambda value: f"{value:.4g}"),
    ("u_z (nm)", "normal_amplitude_m", lambda value: f"{value * 1e9:.4g}"),
    ("u_x (nm)", "tangential_amplitude_m", lambda value: f"{value * 1e9:.4g}"),
    ("velocity (mm/s)", "velocity_m_per_s", lambda value: f"{value * 1e3:.5g}"),
    ("95 % from", "velocity_low_m_per_s", lambda value: f"{value * 1e3:.5g}"),
    ("to (mm/s)", "velocity_high_m_per_s", lambda value: f"{value * 1e3:.5g}"),
    ("at burst end (mm/s)", "velocity_at_burst_end_m_per_s", lambda value: f"{value * 1e3:.5g}"),
    ("regime", "regime", str),
    ("rel. error", "relative_error", lambda value: f"{value:.1e}"),
    ("status", "status", str),
)  # of a point: its head, its key in run.json, and how it is written

ROWS_SHOWN = 30  # of the table in a notebook


def print_json(value: dict) -> None:
    """Print JSON on stdout, in letters that its encoding has."""
    ascii_only = codecs.lookup(sys.stdout.encoding or "ascii").name != "utf-8"
    print(json.dumps(value, indent=1, ensure_ascii=ascii_only, allow_nan=False))


def answer(record: Record) -> str:
    """Return what a run prints on stdout."""
    lines = [record.scene.title or "no title", ""]
    if record.points:
        head, rows = points_table(record)
        shown = [k for k, name in enumerate(head) if name != "status"]
        lines += [*table([[row[k] for k in shown] for row in (head, *rows)]), ""]
    else:
        lines += _free_wave(record.wave)
    lines += _wave(record)
    lines += _limits(record)
    if record.uncertainty:
        lines += _uncertainty(record.uncertainty)
    if record.measured:
        lines += comparison_lines(record.measured)
    if record.at_rest:
        known = record.wave.get("relative_error")
        wave = "" if known is None else f"; the wave under the slider is known to {known:.1e}"
        lines.append(f"relative error  none: no point moves{wave}, asked for {record.tolerance:.1e}")
    elif record.error:
        parts = ", ".join(f"{name} {size:.1e}" for name, size in record.error["parts"].items())
        asked = f"asked for {record.tolerance:.1e}"
        lines.append(f"relative error  {record.error['relative']:.1e} ({parts}), {asked}")
    if record.model_error:
        lines.append("model error     " + "\n                ".join(sentences(record)))
    seconds = ", ".join(f"{name} {size:.2f}" for name, size in record.seconds.items() if name != "total")
    lines.append(f"seconds         {record.seconds['total']:.2f} ({seconds})")
    lines.append("left out        " + "\n                ".join(record.left_out))
    return "\n".join(lines)


def table(rows: list[list[str]]) -> list[str]:
    """Return rows of text as aligned lines, numbers to the right."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return [
        "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]


def points_table(record: Record, missing: str = "-") -> tuple[list[str], list[list[str]]]:
    """Return heads and rows of a run's points; what no point has is no column."""
    shown = [column for column in COLUMNS if any(column[1] in point for point in record.points)]
    rows = [
        [text(point[key]) if key in point else missing for _, key, text in shown] for point in record.points
    ]
    return [name for name, _, _ in shown], rows


def notebook_table(record: Record, caption: str) -> str:
    """Return the points as a table in HTML, with a caption above and the warnings below."""
    from html import escape

    def row(kind: str, cells: list[str]) -> str:
        return f"<tr>{''.join(f'<{kind}>{escape(cell)}</{kind}>' for cell in cells)}</tr>"

    heads, rows = points_table(record, missing="")
    body = "".join(row("td", cells) for cells in rows[:ROWS_SHOWN])
    more = f"<p>{len(rows) - ROWS_SHOWN} more</p>" if len(rows) > ROWS_SHOWN else ""
    notes = "".join(f"<li>{escape(note)}</li>" for note in record.warnings)
    return f"<p>{escape(caption)}</p><table>{row('th', heads)}{body}</table>{more}<ul>{notes}</ul>"


def _free_wave(wave: dict) -> list[str]:
    return [
        f"velocity        {wave['phase_velocity_m_per_s']:.8g} m/s",
        f"surface ratio   {wave['surface_ratio']:.6g} (|u_x/u_z|)",
        f"attenuation     {wave['attenuation_per_m']:.4g} 1/m",
    ]


def _wave(record: Record) -> list[str]:
    if not record.electrical:
        return []
    wave, electrical = record.wave, record.electrical
    admittance = electrical["admittance_S"]
    section = wave.get("section_normal_m_per_V")
    change = 0.0 if section is None else 100 * (abs(section) / abs(wave["normal_m_per_V"]) - 1)
    spreading = (
        []
        if section is None
        else [f"diffraction     the plane section would give {change:+.2g} % at the slider's place"]
    )
    return [
        f"wave            {abs(wave['normal_m_per_V']) * 1e9:.4g} nm per V at the slider's place, "
        f"{wave['phase_velocity_m_per_s']:.6g} m/s, standing-wave ratio {wave['standing_wave_ratio']:.3g}",
        *spreading,
        f"admittance      {admittance.real * 1e3:.4g} + {admittance.imag * 1e3:.4g}i mS",
        *_source(record),
    ]


def _source(record: Record) -> list[str]:
    """Return the network's elements and where the available power goes, for a source with an impedance."""
    electrical, match, lines = record.electrical, record.scene.drive.match, []
    if match != "none":
        parts = [f"{name} {size:.4g} {ELEMENTS[name]}" for (name, size), *_ in match]
        lines.append("match           " + ", ".join(parts) + " (from the source to the transducer)")
    available = electrical.get("power_available_W_per_V2")
    if available is not None:
        shares = {
            "delivered": "power_W_per_V2",
            "network": "power_network_W_per_V2",
            "solid": "power_solid_W_per_V2",
            "loads": "power_loads_W_per_V2",
            "to the left": "power_radiated_left_W_per_V2",
            "to the right": "power_radiated_right_W_per_V2",
        }
        text = ", ".join(f"{name} {100 * electrical[key] / available:.3g} %" for name, key in shares.items())
        lines.append(f"power           of the available: {text}")
        lines.append(f"electrodes      {abs(electrical['comb_voltage_per_volt']):.4g} V per V of the source")
    if "recovery_ratio" in electrical:
        kept = f"{100 * electrical['recovery_ratio']:.3g} % of the power into the transducers"
        load = complex(record.scene.drive.recovery.load)
        lines.append(f"recovered       {kept}, in {load.real:.4g} {load.imag:+.4g}i ohm")
    if "power_net_W_per_V2" in electrical:
        less, gain = (
            electrical["power_W_per_V2"] / electrical["power_net_W_per_V2"],
            electrical["recovery_ratio"],
        )
        lines.append(
            f"circulation     the source gives 1/{less:.4g} of it; gain of the loop {gain:.4g}, stable below 1"
        )
    return lines


def _uncertainty(block: dict) -> list[str]:
    """Return how the bands were made, and what each tolerance makes of the velocity at the highest level."""
    made = "linear, tolerances added in quadrature"
    if "samples" in block:
        made = f"percentiles of {block['samples']} samples (Latin hypercube)"
    lines, widths = [f"uncertainty     bands of 95 %: {made}"], block.get("velocity_half_width_m_per_s", {})
    for key, size in block["tolerances"].items():
        effect = f": +- {widths[key] * 1e3:.3g} mm/s at the highest level" if key in widths else ""
        lines.append(f"                {key} +- {size:.4g}{effect}")
    for name in ("threshold", "release"):
        for key, factor, unit in ((f"{name}_voltage_V", 1.0, "V"), (f"{name}_amplitude_m", 1e9, "nm")):
            if key in block:
                low, high = (end * factor for end in block[key])
                lines.append(f"                {name} {low:.4g} to {high:.4g} {unit}")
    return lines


def sentences(record: Record) -> tuple[str, ...]:
    """Return a line for every effect above the tolerance, and one that names those below it."""
    lines, small = [], []
    for each in record.model_error:
        if " in W" in each["quantity"]:
            lines.append(f"{each['effect']}: {each['size']:.2g} W")
        elif abs(each["size"]) < record.tolerance:
            small.append(each["effect"])
        else:
            lines.append(f"{each['effect']}: {100 * each['size']:+.2g} % of {each['quantity']}")
    return tuple(lines + ([f"below the tolerance: {', '.join(small)}"] if small else []))


def _limits(record: Record) -> list[str]:
    lines = []
    for name in ("threshold", "release"):
        amplitude = record.summary.get(f"{name}_amplitude_m")
        if amplitude is None:
            continue
        voltage = record.summary.get(f"{name}_voltage_V")
        at = "" if voltage is None else f"{voltage:.4g} V, "
        lines.append(f"{name:<15} {at}{amplitude * 1e9:.4g} nm")
    return lines
