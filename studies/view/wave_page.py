"""The wave field of a run as one HTML page: it moves, colours, zooms, and needs no network and nothing installed.

The page carries the field's nodes (16-bit parts of the largest value, compressed) and draws them by WebGL 2: deformed
and coloured at any phase.  A wave that spreads in three dimensions is shown from above too.
"""

import base64
import gzip
import json
from functools import partial
from importlib.resources import files

import matplotlib
import numpy as np

from studies.record.plots import DPI, as_uri
from studies.report.surface_map import draw_surface_map, pixels
from studies.view import description
from studies.view.quantities import Shade, present, shade
from studies.view.run_field import RunField
from studies.view.section import magnification, thinned

SPACING = 1 / 30  # wavelengths
SHORT = 32767
CYCLE = 2.5  # s that one period of the wave takes


def page(
    run: RunField, *, quantity: str, phase: float, factor: float | None, span: tuple[float, float] | None
) -> str:
    """Return the page; quantity, phase (rad), factor of the displacement and span (m) are those shown at first."""
    field = run.with_energies
    spacing = SPACING * run.wavelength
    lines = thinned(field.x, spacing, 0.0, run.length)
    rows = thinned(field.z, spacing, field.z[0], 0.0)
    kept = np.ix_(lines, rows)
    moved = field.displacement[kept][..., [0, 2]]
    parts = {"x": field.x[lines].astype("<f4"), "z": field.z[rows].astype("<f4")}
    inside = np.ones(moved.shape[:2]) if field.inside is None else field.inside[kept]
    parts["inside"] = inside.astype("u1")
    largest = float(abs(moved).max()) or 1.0
    parts["moved"] = _short(np.stack([moved[..., k].real if part == 0 else moved[..., k].imag
                                      for k in (0, 1) for part in (0, 1)], axis=-1), largest)  # fmt: skip
    known = []
    for name in present(run):
        shading = shade(run, name)
        mean, amplitude = (each[kept] for each in shading.parts(field))
        values = np.stack([mean, amplitude.real, amplitude.imag, np.zeros_like(mean)], axis=-1)
        scale = float(abs(values).max()) or 1.0
        parts[name] = _short(values, scale)
        known.append(_described(name, shading, scale))
    packed, listed = _packed(parts)
    places = _places(run, span)
    meta = {
        "title": run.scene.title or "sawmotor",
        "drive": f"{field.frequency / 1e6:g} MHz, {run.drive}",
        "free": run.free,
        "nx": len(lines),
        "nz": len(rows),
        "arrays": listed,
        "moved_scale": largest,
        "factor": magnification(run) if factor is None else factor,
        "phase": phase % (2 * np.pi),
        "cycle": CYCLE,
        "quantities": known,
        "quantity": quantity,
        "places": places,
        "place": len(places) - (2 if span is None else 1),
        "balls": [ball.place for ball in description.balls(run)],
        "crests": [ball.crest for ball in description.balls(run)],
        "ball_colour": description.BALL_COLOUR,
        "legend": [[each.label, each.colour] for each in description.electrodes(run)],
        "radius": run.radius,
        "fingers": _fingers(run),
        "axes": [list(axis) for axis in description.crystal_axes(run)],
        "axis_colour": description.AXIS_COLOUR,
    }
    text = json.dumps(meta, allow_nan=False).replace("</", "<\\/")
    template = (files("studies.view") / "wave_page.html").read_text(encoding="utf-8")
    return template.replace("@META@", text).replace("@DATA@", packed).replace("@BEAM@", _beam(run))


def _beam(run: RunField) -> str:
    """Return the picture of a beam from above, and what the moving field is beside it; nothing without one."""
    if run.beam is None:
        return ""
    draw = partial(draw_surface_map, run.beam, run.scene)
    width, height = pixels(run.scene.stator)
    uri = as_uri(draw, size=(width / DPI, height / DPI), kind="png")
    return (
        "<p>The moving field is that of the plane section, which does not spread; over the whole surface the finite "
        f'apertures give:</p>\n<img alt="size of u_z over the surface" src="{uri}" style="max-width: 100%">'
    )


def _short(values: np.ndarray, largest: float) -> np.ndarray:
    return np.round(values / largest * SHORT).astype("<i2")


def _described(name: str, shading: Shade, scale: float) -> dict:
    table = matplotlib.colormaps[shading.colour_map](np.linspace(0.0, 1.0, 128), bytes=True)
    return {
        "name": name,
        "title": shading.quantity.title,
        "label": shading.label,
        "reach": shading.reach,
        "scale": scale,
        "signed": shading.quantity.signed,
        "turns": shading.quantity.turns,
        "table": table.tolist(),
    }


def _packed(parts: dict) -> tuple[str, list]:
    """Return arrays end to end, compressed, as base64, and what they are."""
    listed, raw = [], b""
    for name, values in parts.items():
        listed.append([name, values.dtype.str[1:], int(values.size)])
        raw += values.tobytes()
        raw += b"\0" * (-len(raw) % 4)
    return base64.b64encode(gzip.compress(raw, 6, mtime=0)).decode(), listed


def _places(run: RunField, span) -> list[dict]:
    def about(name, place, wavelengths):
        half = 0.5 * wavelengths * run.wavelength
        return {"name": name, "from": max(place - half, 0.0), "to": min(place + half, run.length)}

    name, focus = run.focus
    listed = [{"name": "whole", "from": 0.0, "to": run.length}]
    listed += [
        about(f"transducer {each.name}", run.in_section(each.place), 14) for each in run.scene.transducer
    ]
    listed += [about(name, focus, 14), about("one wavelength", focus, 1)]
    return listed + ([{"name": "chosen", "from": span[0], "to": span[1]}] if span is not None else [])


def _fingers(run: RunField) -> list[dict]:
    listed = []
    for electrode in description.electrodes(run):
        for left, right in electrode.strips:
            points = [
                [x, *(part for value in run.surface(x) for part in (value.real, value.imag))]
                for x in (left, 0.5 * (left + right), right)
            ]
            listed.append({"colour": electrode.colour, "points": points})
    return listed
