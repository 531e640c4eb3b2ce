"""A run as one self-contained page: the answer, pictures, intermediate numbers, ledger, limits, how to run it again.

Everything is inside the file: pictures are data, there is no script, and nothing is fetched.
"""

import os
import platform
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

from studies.record import Record
from studies.report import energies, figures
from studies.report.answer import points_table, sentences
from studies.report.intermediate import intermediate_numbers, si
from studies.report.limits import model_limits
from studies.results.content import provenance
from studies.scene.toml import document

__all__ = ["rendered", "report", "write_report"]

TEMPLATE = "report.html"
CAPTIONS = {
    "velocity": "Slider velocity; marks are computed, lines are closed forms.",
    "trajectory": "Velocity during the bursts and after them.",
    "surface": "Motion of the surface per volt; grey: transducers.",
    "errors": "Estimated error of each point, and what was asked for.",
}  # of `figures.pictures`


def write_report(record: Record, folder: Path) -> None:
    """Write ``report.html`` into a directory."""
    (folder / TEMPLATE).write_text(report(record), encoding="utf-8")


def rendered(template: str, **values) -> str:
    """Return a page from one of the templates."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"),
        autoescape=True,  # titles and names come from a scene's author
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    written = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    return environment.get_template(template).render(written=written, **values)


def report(record: Record) -> str:
    """Return the page of a record."""
    scene = record.scene
    columns, points = points_table(record, missing="\u2013")
    return rendered(
        TEMPLATE,
        title=scene.title or "A run of sawmotor",
        headline=_headline(record),
        columns=columns,
        points=points,
        pictures=_pictures(record),
        numbers=intermediate_numbers(record),
        balances=energies.balances(record),
        level=lambda value: si(value, "m" if scene.wave is not None else "V"),
        watt=lambda value: si(value, "W", 4),
        error=record.error,
        tolerance=record.tolerance,
        shortfall=record.shortfall,
        warnings=record.warnings,
        at_rest=record.at_rest,
        seconds=record.seconds,
        left_out=record.left_out,
        limits=(*model_limits(scene), *(f"Estimated model error - {each}." for each in sentences(record))),
        provenance=provenance() | {"machine": _machine()},
        scene=document(scene.to_table()),
    )


def _headline(record: Record) -> str:
    """Return the answer in a sentence."""
    wave, scene = record.wave, record.scene
    if not record.points:
        return f"The free wave runs at {si(wave['phase_velocity_m_per_s'], 'm/s', 8)}."
    unit = "m" if record.level == "normal_amplitude_m" else "V"
    if scene.slider is None:
        most = max(record.points, key=lambda point: point["normal_amplitude_m"])
        amplitude = si(most["normal_amplitude_m"], "m")
        return f"The surface moves by {amplitude} along its normal at {si(most[record.level], unit)}."
    known = [point for point in record.points if "velocity_m_per_s" in point]
    if not known:
        return "No point has an answer."
    fastest = max(known, key=lambda point: abs(point["velocity_m_per_s"]))
    if fastest["velocity_m_per_s"] == 0:
        return "The slider stays where it is at every point."
    speed = si(fastest["velocity_m_per_s"], "m/s")
    start = record.summary.get("threshold_voltage_V" if unit == "V" else "threshold_amplitude_m")
    moves = "" if start is None else f" It moves from {si(start, unit, 4)} on."
    return f"The slider runs at {speed} at {si(fastest[record.level], unit)}, {_way(record, fastest)}.{moves}"


def _way(record: Record, point: dict) -> str:
    towards = "+x" if point["velocity_m_per_s"] > 0 else "\u2212x"
    driven = next(
        (each for each in record.scene.transducer if each.name == record.scene.drive.transducer), None
    )
    if driven is None:
        return f"towards {towards}"
    to = (driven.place[0] - record.scene.slider.center[0]) * point["velocity_m_per_s"] > 0
    return f"{'towards' if to else 'away from'} the driven transducer ({towards})"


def _pictures(record: Record) -> list[dict]:
    drawn = figures.pictures(record)
    if len([point for point in record.points if point.get("relative_error")]) > 1:
        drawn["errors"] = partial(figures.errors, record)
    captions = CAPTIONS if record.scene.transducer else CAPTIONS | {"surface": "The wave against depth."}
    return [{"data": figures.as_uri(draw), "caption": captions[name]} for name, draw in drawn.items()]


def _machine() -> str:
    return f"{platform.machine()}, {os.cpu_count()} processors, {platform.system()}"
