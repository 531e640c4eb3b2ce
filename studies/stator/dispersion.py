"""Guided modes of a section: wavenumber against frequency, for the modes of the plate and for the Rayleigh wave.

Method: the guided modes of the bare section of the scene (``rayleigh`` by default) that hardly decay, from a twelfth of
the drive frequency to a fifth above it, compared with the Rayleigh wave of the half-space. (A test of ``fem`` compares
the modes of a steel plate with the roots of the Rayleigh-Lamb equation.) Expected: at the drive frequency the surface
wave of the section has the velocity of the half-space to 1e-4 if the plate is at least 4 wavelengths thick; a thin
plate has no such wave. Of a stator with layers, the waves of these layers on a half-space instead, without a mesh,
against the thickness of all layers in wavelengths, from a fiftieth of the scene's to twice that: every bound wave by
its name, where it begins to be bound and from where on it leaks, its velocity, free and with an electrode at each
interface, and its coupling. Run time: about 5 s, with layers 10 s.
"""

import logging

import numpy as np

import fem
from studies.model.resolve import build
from studies.record.plots import curve, finished
from studies.record.quantities import quantity
from studies.scene import Scene
from studies.stator.layer_dispersion import draw_coupling, draw_velocity, of_layers
from studies.study_list import Answered, Panel, judged, of_record, study

LOGGER = logging.getLogger(__name__)

QUICK = {"count": 9}
LOWEST, HIGHEST = 1 / 12, 1.2  # of the drive frequency
DECAY = 0.01  # |Im k| over |Re k| below which a mode propagates
TOLERANCE = 1e-8  # of the modes' wavenumbers
LAYERED_SECONDS = 12.0  # of the waves of layers at 60 thicknesses
THICK = 4.0  # wavelengths: above it the faces' waves hardly split


def expected_seconds(scene: Scene) -> float | None:
    """Return the run time in s of a stator with layers, which needs no mesh; None without layers."""
    return LAYERED_SECONDS if scene.stator is not None and scene.stator.layer else None


@study("rayleigh")
def run(scene: Scene, *, over: dict | None = None, count: int = 60) -> Answered:
    """Return propagating wavenumbers against frequency, and the waves of the stator's layers against their thickness.

    Parameters
    ----------
    over : dict, optional
        "thickness": that of all layers together in wavelengths, START:STOP:N or a list.
    count : int
        Number of frequencies, and of thicknesses.
    """
    if scene.stator is None:
        scene.refuse("stator", "is missing: a prescribed wave has no section to guide it")
    model = build(scene)
    stator, drive = model.plain, model.scene.frequency
    layers = of_layers(scene, stator, over, count)
    if not stator.layers:
        frequencies = np.linspace(LOWEST, HIGHEST, count) * drive
        LOGGER.info(f"{count} frequencies of {scene.title}")
        at, wavenumbers, near = _propagating(stator, frequencies)
    half_space = fem.bound_wave(stator, drive).velocity
    free = fem.free_wave(stator, frequency=drive, tolerance=1e-6)
    thickness = stator.thickness * drive / half_space
    finding = judged(
        "The surface wave of a thick section is that of the half-space.",
        f"relative difference of velocities at {drive / 1e6:g} MHz, {thickness:.3g} wavelengths thick",
        abs(free.velocity / half_space - 1), high=1e-4,
        holds=True if stator.absorbs_below or thickness > THICK else None,
        expected=f"below 1e-4 from {THICK:g} wavelengths on",
    )  # fmt: skip
    if stator.layers:
        return layers.panels, (finding,), layers.answer
    panel = Panel(name="section", title=f"{scene.title}: {len(at)} propagating modes", data=dict(
        frequency_Hz=at, wavenumber_rad_per_m=wavenumbers, surface_share=near,
        line_Hz=frequencies, line_rad_per_m=2 * np.pi * frequencies / half_space,
    ))  # fmt: skip
    return (panel,), (finding,)


@of_record
def figure(record: Panel, ax):
    """Draw wavenumbers of the modes as points, the half-space's wave as a line; or the waves of the layers."""
    if record.name != "section":
        return {"layers": draw_velocity, "coupling": draw_coupling}[record.name](record, ax)
    data, across, up = record.data, quantity.frequency_Hz, quantity.wavenumber_rad_per_m
    at, wavenumbers = data.frequency_Hz * across.scale, data["wavenumber_rad_per_m"] * up.scale
    near = data["surface_share"] > 0.25
    curve(ax, at, wavenumbers, ".", "stick", "modes of the section")
    curve(ax, at[near], wavenumbers[near], ".", "slip", "near the surface", size=5.0)
    theory = data["line_Hz"] * across.scale, data["line_rad_per_m"] * up.scale
    curve(ax, *theory, "-", "line", "Rayleigh wave of the half-space (theory)")
    ax.set_ylim(bottom=0)
    return finished(ax, across.axis, up.axis, record.title)


def _propagating(stator, frequencies):
    """Return frequency (Hz), wavenumber (rad/m) and nearness to the surface (1: the nearest) of propagating modes."""
    modes_of_all = []
    for frequency in frequencies:
        modes = fem.guided_modes(stator, frequency=float(frequency), tolerance=TOLERANCE, propagating=True)
        k = modes.wavenumbers
        moving = np.flatnonzero(abs(k.imag) < DECAY * abs(k.real))
        near = modes.surface_share[moving] * frequency  # a surface wave's share is one over its depth
        modes_of_all += [(frequency, abs(k[i].real), s) for i, s in zip(moving, near, strict=True)]
    table = np.array(modes_of_all).reshape(-1, 3).T
    return table[0], table[1], table[2] / max(table[2].max(initial=0.0), 1e-300)
