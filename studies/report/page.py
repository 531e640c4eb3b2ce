"""HTML report of a run: answer, pictures, intermediate numbers, energy ledger, limits, and the scene to repeat the run.

The page is self-contained: pictures are embedded as data URIs, and there are no scripts and no external resources.
"""

import logging
import math
import os
import platform
from collections.abc import Iterable
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

from studies.progress import counted
from studies.record import Record, plots, run_pictures
from studies.record.prefixes import si
from studies.record.text import found_entries, percent, points_table
from studies.report import energies, run_drawings
from studies.report.intermediate import intermediate_numbers
from studies.report.scene_text import scene_text
from studies.results.content import provenance

LOGGER = logging.getLogger(__name__)
TEMPLATE = "report.html"
CAPTIONS = {
    "layout": "The surface from above.",
    "section_field": "The wave in the section, from the surface down.",
    "beam": "Amplitude over the surface; white: apertures, points: contacts.",
    "load_line": "Speed against the load of the whole slider, at the largest level of the drive.",
    "velocity": "Slider velocity; marks are computed, lines are closed forms.",
    "trajectory": "Velocity during the bursts and after them.",
    "surface": "Motion of the surface per volt; grey: transducers.",
    "measured": "Measured values over computed ones.",
    "slider_wave": "Amplitude and phase of the waves under the slider.",
    "pressure": "Mean normal force on each pillar.",
    "power": "Power that the waves under the slider lose, to friction and to work against the load, and what remains.",
    "errors": "Estimated error of each point, and the tolerance.",
}  # of `run_pictures.pictures`


def rendered(template: str, **values) -> str:
    """Return the page that results from a template and its values."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"),
        autoescape=True,  # escape titles and names, which come from the author of the scene
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals |= {"si": si, "percent": percent}
    written = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    return environment.get_template(template).render(written=written, **values)


def picture_page(title: str, pictures: Iterable[tuple[str, str]]) -> str:
    """Return an HTML page of pictures, each a data URI and its caption."""
    shown = [{"data": data, "caption": caption} for data, caption in pictures]
    return rendered("pictures.html", title=title, pictures=shown)


def report(record: Record, written: dict | None = None) -> str:
    """Return the HTML page of a record; ``written``: the table of its file, whose units stand beside the numbers."""
    scene = record.scene
    columns, points = points_table(record, missing="\u2013")
    points, remarks = _short_statuses(record, columns, points)
    return rendered(
        TEMPLATE,
        title=scene.title or "A run of sawmotor",
        record=record,
        fastest=_fastest(record),
        columns=columns,
        points=points,
        remarks=remarks,
        pictures=_pictures(record),
        numbers=intermediate_numbers(record),
        balances=energies.balances(record),
        provenance=provenance() | {"machine": _machine()},
        found=[(name, [lines] if isinstance(lines, str) else lines) for name, lines in found_entries(record)],
        scene=scene_text(scene, written),
    )


def _fastest(record: Record):
    """Return the point with the largest speed, of a rotor of its rotation; None without an answer."""
    known = [point for point in record.points if point.velocity_m_per_s is not None]
    axle = record.scene.slider is not None and record.scene.slider.axis is not None

    def speed(point) -> float:
        across = point.lateral_velocity_m_per_s or 0.0
        return abs(point.rotation_rpm) if axle else math.hypot(point.velocity_m_per_s, across)

    return max(known, key=speed, default=None)


def _short_statuses(record: Record, columns: list[str], rows: list[list[str]]) -> tuple[list, list[str]]:
    """Return the rows with the kinds of their statuses, and one sentence for each kind that is not ok."""
    if "status" not in columns:
        return rows, []
    at = columns.index("status")
    reasons: dict[str, list[str]] = {}
    for point, row in zip(record.points, rows, strict=True):
        kind, colon, reason = row[at].partition(": ")
        if colon:
            reasons.setdefault(kind, []).append(f"{record.scene.named(point.level)}: {reason}")
    short = [[cell.partition(": ")[0] if k == at else cell for k, cell in enumerate(row)] for row in rows]
    remarks = []
    for kind, several in reasons.items():
        more = f" ({len(several) - 1} more in run.json)" if len(several) > 1 else ""
        remarks.append(f"{kind}, at {several[0]}{more}")
    return short, remarks


def _pictures(record: Record) -> list[dict]:
    drawn = run_drawings.drawings(record)
    drawn = {name: drawn.pop(name) for name in ("layout",) if name in drawn} | run_pictures.pictures(record) | drawn
    if len([point for point in record.points if point.relative_error]) > 1:
        drawn["errors"] = partial(run_pictures.errors, record)
    captions = CAPTIONS if record.scene.transducer else CAPTIONS | {"surface": "Motion of the wave over depth."}
    shown = counted(LOGGER, "pictures of the report", list(drawn.items()))
    return [{"data": plots.as_uri(draw), "caption": captions[name]} for name, draw in shown]


def _machine() -> str:
    return f"{platform.machine()}, {os.cpu_count()} processors, {platform.system()}"
