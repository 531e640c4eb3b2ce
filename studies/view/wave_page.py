"""The wave field of a run as an animated HTML page with zoom, which needs no network and no installed software.

The page contains the nodal values of the field as compressed 16-bit integers and draws the deformed, coloured section
with WebGL 2 at any phase. For a beam that spreads in three dimensions, the page also contains a map of the surface.
"""

import base64
import gzip
import json
from functools import partial
from importlib.resources import files

import matplotlib
import numpy as np

from studies.record.plots import DPI, as_uri
from studies.report.beam_map import draw_surface_map, pixels
from studies.view import overlays
from studies.view.field_points import magnification, thinned
from studies.view.field_quantities import Shade, present, shade
from studies.view.run_field import RunField

SPACING = 1 / 30  # smallest distance of nodes, in wavelengths
MAX_INT16 = 32767
CYCLE = 2.5  # duration of one period of the wave on the page, s


def page(run: RunField, *, quantity: str, phase: float, factor: float | None, span: tuple[float, float] | None) -> str:
    """Return the page. Quantity, phase (rad), factor of the displacement and span (m) are the initial settings."""
    field = run.with_energies
    spacing = SPACING * run.wavelength
    columns = thinned(field.x, spacing, 0.0, run.length)
    depths = thinned(field.z, spacing, field.z[0], 0.0)
    selection = np.ix_(columns, depths)
    displacement = field.displacement[selection][..., [0, 2]]
    parts = {"x": field.x[columns].astype("<f4"), "z": field.z[depths].astype("<f4")}
    inside = np.ones(displacement.shape[:2]) if field.inside is None else field.inside[selection]
    parts["inside"] = inside.astype("u1")
    largest = float(abs(displacement).max()) or 1.0
    parts["moved"] = _short(np.ascontiguousarray(displacement).view(float), largest)  # u_x and u_z, real and imaginary
    quantities = []
    for name in present(run):
        shading = shade(run, name)
        mean, amplitude = (each[selection] for each in shading.parts(field))
        values = np.stack([mean, amplitude.real, amplitude.imag, np.zeros_like(mean)], axis=-1)
        scale = float(abs(values).max()) or 1.0
        parts[name] = _short(values, scale)
        quantities.append(_described(name, shading, scale))
    data, listed = _packed(parts)
    spans = _spans(run, span)
    meta = {
        "title": run.scene.title or "sawmotor",
        "drive": f"{field.frequency / 1e6:g} MHz, {run.drive}",
        "free": run.free,
        "nx": len(columns),
        "nz": len(depths),
        "arrays": listed,
        "moved_scale": largest,
        "factor": magnification(run) if factor is None else factor,
        "phase": phase % (2 * np.pi),
        "cycle": CYCLE,
        "quantities": quantities,
        "quantity": quantity,
        "spans": spans,
        "span": len(spans) - (2 if span is None else 1),
        "balls": [ball.x for ball in overlays.balls(run)],
        "crests": [ball.crest for ball in overlays.balls(run)],
        "ball_colour": overlays.BALL_COLOUR,
        "legend": [[each.label, each.colour] for each in overlays.electrodes(run)],
        "radius": run.radius,
        "fingers": _fingers(run),
        "axes": [list(axis) for axis in overlays.crystal_axes(run)],
        "axis_colour": overlays.AXIS_COLOUR,
    }
    text = json.dumps(meta, allow_nan=False).replace("</", "<\\/")
    template = (files("studies.view") / "wave_page.html").read_text(encoding="utf-8")
    return template.replace("@META@", text).replace("@DATA@", data).replace("@BEAM@", _beam(run))


def _beam(run: RunField) -> str:
    """Return HTML with a map of the beam and an explanation, or an empty string without a beam."""
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
    return np.round(values / largest * MAX_INT16).astype("<i2")


def _described(name: str, shading: Shade, scale: float) -> dict:
    table = matplotlib.colormaps[shading.colour_map](np.linspace(0.0, 1.0, 128), bytes=True)
    return {
        "name": name,
        "title": shading.quantity.title,
        "label": shading.label,
        "scale_end": shading.scale_end,
        "scale": scale,
        "signed": shading.quantity.signed,
        "harmonic": shading.quantity.harmonic,
        "table": table.tolist(),
    }


def _packed(parts: dict) -> tuple[str, list]:
    """Return the concatenated arrays, compressed and in base64, and a list of (name, type, size)."""
    description, raw = [], b""
    for name, values in parts.items():
        description.append([name, values.dtype.str[1:], int(values.size)])
        raw += values.tobytes()
        raw += b"\0" * (-len(raw) % 4)
    return base64.b64encode(gzip.compress(raw, 6, mtime=0)).decode(), description


def _spans(run: RunField, span) -> list[dict]:
    """Return name and ends (m) of the parts of the section that the buttons of the page show."""

    def about(name, middle, wavelengths):
        half = 0.5 * wavelengths * run.wavelength
        return {"name": name, "from": max(middle - half, 0.0), "to": min(middle + half, run.length)}

    name, focus = run.focus
    listed = [{"name": "whole", "from": 0.0, "to": run.length}]
    listed += [about(f"transducer {each.name}", run.in_section(each.center_xy), 14) for each in run.scene.transducer]
    listed += [about(name, focus, 14), about("one wavelength", focus, 1)]
    return listed + ([{"name": "selected span", "from": span[0], "to": span[1]}] if span is not None else [])


def _fingers(run: RunField) -> list[dict]:
    fingers = []
    for electrode in overlays.electrodes(run):
        for left, right in electrode.strips:
            points = [
                [x, *(part for value in run.surface(x) for part in (value.real, value.imag))]
                for x in (left, 0.5 * (left + right), right)
            ]
            fingers.append({"colour": electrode.colour, "points": points})
    return fingers
