"""The waves of a stator's layers on a half-space against the thickness of the layers, for the dispersion study."""

import logging
from typing import NamedTuple

import numpy as np

import fem
from studies.record.plots import PALETTE, curve, finished
from studies.record.quantities import quantity
from studies.refusal import SceneError
from studies.report.intermediate import si
from studies.scene import Scene
from studies.scene.numbers import Listed, Quantity
from studies.study_list import Panel

LOGGER = logging.getLogger(__name__)

RANGE = (0.02, 2.0)  # of the scene's own thickness
STYLES = ("-", "--", ":", "-.")


class Layers(NamedTuple):
    """Pictures and the answer in words of a stator's layers; empty without layers."""

    panels: tuple[Panel, ...] = ()
    answer: tuple[tuple[str, str], ...] = ()


def of_layers(scene: Scene, stator, over: dict | None, count: int) -> Layers:
    """Return the waves of a resolved scene's layers against their thickness.

    ``over``: values of "thickness" in wavelengths as a user types them; by default `RANGE` times the scene's own.
    """
    unknown = [key for key in over or {} if key != "thickness"]
    if unknown or (over and not stator.layers):
        rule = "must be thickness=START:STOP:N, in wavelengths" if stator.layers else "must be absent without layers"
        raise SceneError("--over", f"{rule}, got {(unknown or list(over or {}))[0]}")
    if not stator.layers:
        return Layers()
    frequency, surface = scene.frequency, stator.bare_surface
    wavelength = fem.bound_wave(stator, frequency).velocity / frequency
    own = sum(each.thickness for each in stator.layers) / wavelength
    total = np.linspace(RANGE[0] * own, RANGE[1] * own, count)
    if over:
        total = np.array(Listed(Quantity(""), ranged=True).read("--over thickness", over["thickness"]))
    # in wavelengths, so that every wave has the same layers at the same abscissa
    stack = [fem.Layer(solid=each.solid, bond=each.bond, wavelengths=each.thickness / wavelength / own)
             for each in stator.layers]  # fmt: skip
    LOGGER.info(f"{len(total)} thicknesses of the layers")
    branches = fem.wave_branches(stator.solid, stack, total, surface=surface, frequency=frequency)
    electric, planes = branches[0].waves[0].impedance.electric, range(len(stack) + 1)
    names = ["surface", *map(str, planes[1:])]
    rows, answer = [], []
    for branch in branches:
        for thickness, wave in zip(branch.factors, branch.waves, strict=True):
            row = {"wave": branch.name, "thickness_wavelengths": float(thickness)}
            row |= {quantity.velocity_m_per_s.column: wave.velocity, "surface_ratio": wave.surface_ratio}
            if electric and surface == "vacuum":
                shorted = fem.shorted_velocities(wave, planes)
                row |= {f"shorted_{name}_m_per_s": each for name, each in zip(names, shorted.tolist(), strict=True)}
                coupling = (2.0 * (wave.velocity - shorted) / wave.velocity).tolist()
                row |= {f"coupling_K2_{name}": each for name, each in zip(names, coupling, strict=True)}
            rows.append(row)
        answer.append((branch.name, _bound(branch, wavelength)))
    panels = [Panel.of_rows("layers", f"{scene.title}: waves of the layers", rows)]
    if electric and surface == "vacuum":
        panels.append(Panel.of_rows("coupling", f"{scene.title}: coupling of the waves", rows))
    return Layers(tuple(panels), tuple(answer))


def _bound(branch, wavelength: float) -> str:
    """Return where a wave is bound; ``wavelength`` of the scene, m."""
    first, last = branch.factors[[0, -1]]
    ends = []
    for word, value, otherwise in (("from", branch.begins, first), ("to", branch.ends, last)):
        at = f"{word} {otherwise:.4g}" if value is None else f"{word} {value:.4g}"
        ends.append(at if value is None else f"{at} ({si(value * wavelength, 'm')}), where it begins to leak,")
    slow, fast = (branch.waves[k].velocity for k in (0, -1))
    return f"bound {' '.join(ends).rstrip(',')} wavelengths of layers: {slow:.6g} to {fast:.6g} m/s"


def _branches(panel: Panel):
    """Yield the name and the rows of each wave."""
    rows = panel.rows()
    for name in dict.fromkeys(row["wave"] for row in rows):
        yield name, [row for row in rows if row["wave"] == name]


def draw_velocity(panel: Panel, ax):
    """Draw the velocities of all waves, free as lines and shorted at the surface as dashes."""
    up, across = quantity("panel.wave_velocity_m_per_s"), quantity("panel.thickness_wavelengths")
    for number, (name, rows) in enumerate(_branches(panel)):
        thickness = [row["thickness_wavelengths"] for row in rows]
        colour = PALETTE[number % len(PALETTE)]
        marks = {quantity.velocity_m_per_s.column: ("-", name), "shorted_surface_m_per_s": ("--", None)}
        for key, (style, label) in marks.items():
            if key in rows[0]:
                curve(ax, thickness, [row[key] * up.scale for row in rows], style, colour, label)
    return finished(ax, across.axis, up.axis, f"{panel.title}\ndashes: surface shorted")


def draw_coupling(panel: Panel, ax):
    """Draw the coupling of all waves with an electrode on the surface and at each interface."""
    up, across = quantity("panel.wave_coupling"), quantity("panel.thickness_wavelengths")
    for number, (name, rows) in enumerate(_branches(panel)):
        keys = [key for key in rows[0] if key.startswith("coupling_K2_")]
        for style, key in zip(STYLES, keys, strict=False):
            plane = key.removeprefix("coupling_K2_")
            where = "surface" if plane == "surface" else f"below {plane} layer{'s' * (plane != '1')}"
            values = [row[key] * up.scale for row in rows]
            thickness = [row["thickness_wavelengths"] for row in rows]
            curve(ax, thickness, values, style, PALETTE[number % len(PALETTE)], f"{name}, {where}")
    return finished(ax, across.axis, up.axis, panel.title, columns=3)
