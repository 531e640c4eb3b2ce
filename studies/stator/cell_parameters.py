"""Effect of one period of fingers on the wave: velocity, stop bands, reflectivity, K2 and capacitance.

Method: the free and the metallised half-space and an infinite grating of fingers (`fem.cell_parameters`) for the solid,
period and metallisation of the driven transducer of the scene (``twente-left`` by default), and the Bloch waves of the
gratings around their stop bands. Expected: the shorted grating is slower than the open one, and both lie between the
metallised and the free wave; both stop bands share one edge if x -> -x is a symmetry; the reflectivities are within
20 % of those of strips of charge at weak coupling; the capacitance is that of conformal mapping to 1 %. Run time: about
10 s.

References, with the metallisation m and the electrostatic permittivity eps of the surface: the reflectivity of a strip
is (pi / 2) (dv / v) |P_1/2(c) / P_-1/2(c) - c| with c = -cos(pi m) if the strips are shorted and cos(pi m) if they are
open (Datta and Hunsinger 1980), P the Legendre functions; the capacitance per period and metre of aperture is
eps K(sin^2(pi m / 2)) / K(cos^2(pi m / 2)), K the complete elliptic integral of its parameter (Engan 1969).
"""

import logging

import numpy as np
from scipy.special import ellipk, eval_legendre

import fem
from studies.record.plots import COLOURS, curve, finished, legend_below, shaded
from studies.record.quantities import quantity
from studies.scene import Scene
from studies.solve import passband
from studies.study_list import Answered, Panel, judged, of_record, study

LOGGER = logging.getLogger(__name__)

QUICK = {"count": 8, "tolerance": 0.5}
REACH = 2.0  # widths of the stop bands shown on either side


@study("twente-left")
def run(scene: Scene, *, count: int = 61, tolerance: float = 1e-2) -> Answered:
    """Return the parameters of the cells and the Bloch waves of the gratings.

    Parameters
    ----------
    count : int
        Number of frequencies of the Bloch waves.
    tolerance : float
        Of the stop bands' edges, relative to their width.
    """
    model = passband.driven_model(scene)
    resolved, driven = model.scene, model.scene.driven_transducer
    if driven.cell != "plain":
        resolved.refuse(
            "transducer", f"{driven.name!r} must have the cell plain, got {driven.cell}: a grating of equal fingers"
        )
    solid, above, m = model.solid, resolved.stator.above, driven.metallisation
    period = driven.wavelength / (2 if driven.split else 1)  # of two fingers and two gaps
    LOGGER.info(f"gratings of {solid.name}")
    cell = fem.cell_parameters(solid, period=period, metallisation=m, above=above, tolerance=tolerance)
    LOGGER.info("Bloch waves")
    cells = fem.grating(solid, period=period, metallisation=m, above=above, resolution=fem.LEVELS[int(tolerance < 0.1)])
    bands, edges = {"shorted": cell.shorted, "open": cell.open}, (cell.shorted.lower, cell.open.upper)
    width = edges[1] - edges[0]
    at = np.linspace(edges[0] - REACH * width, edges[1] + REACH * width, count)
    data = dict(frequency_Hz=at)
    for name in bands:
        factors = np.array([cells.surface_factor(float(f), open_fingers=name == "open") for f in at])
        data |= {f"{name}_phase_rad": abs(np.angle(factors)), f"{name}_decay": -np.log(abs(factors))}
    slowing, cosine = 1 - cell.metallised_velocity / cell.free_velocity, np.cos(np.pi * m)
    strips = {  # reflectivity of strips of charge
        name: np.pi / 2 * slowing * abs(eval_legendre(0.5, c) / eval_legendre(-0.5, c) - c)
        for name, c in (("shorted", -cosine), ("open", cosine))
    }
    mapped_capacitance = fem.surface_permittivity(solid, "open" if above == "none" else "vacuum")
    mapped_capacitance *= ellipk(np.sin(np.pi * m / 2) ** 2) / ellipk(np.cos(np.pi * m / 2) ** 2)
    data |= dict(
        free_velocity_m_per_s=cell.free_velocity, metallised_velocity_m_per_s=cell.metallised_velocity,
        coupling_K2=cell.coupling, grating_coupling_K2=cell.grating_coupling,
        capacitance_F_per_m=cell.capacitance, relative_error=cell.relative_error,
    )  # fmt: skip
    for name, band in bands.items():
        data |= {f"{name}_lower_Hz": band.lower, f"{name}_upper_Hz": band.upper,
                 f"{name}_velocity_m_per_s": band.velocity, f"{name}_reflectivity": band.reflectivity}  # fmt: skip
    speeds = cell.metallised_velocity, cell.shorted.velocity, cell.open.velocity, cell.free_velocity
    findings = (
        judged("Fingers slow the wave, connected ones more: v_metallised < v_shorted < v_open < v_free.",
               "share of the metallised slowing that connected fingers reach",
               (speeds[3] - speeds[1]) / slowing / speeds[3], holds=speeds[0] < speeds[1] < speeds[2] < speeds[3],
               expected="between 0 and 1, and above that of separate fingers",
               remark=f"v = {', '.join(f'{each:.6g}' for each in speeds)} m/s; K2 = {100 * cell.coupling:.4g} %"),
        judged("A standing wave without charge on the fingers does not depend on their connection.",
               "distance of the common edge in both gratings, over the bands' width",
               abs(cell.shorted.upper - cell.open.lower) / width, high=1e-6,
               expected="below 1e-6 where x -> -x is a symmetry"),
        *(judged(f"A finger of the {name} grating reflects as a strip of charge.",
                 f"|r| of a finger, against {strips[name]:.4g}", band.reflectivity,
                 low=0.8 * strips[name], high=1.2 * strips[name], expected="within 20 %")
          for name, band in bands.items()),
        judged("The capacitance is that of conformal mapping.",
               f"pF per finger pair and mm, against {mapped_capacitance * 1e9:.4g}", cell.capacitance * 1e9,
               low=0.99e9 * mapped_capacitance, high=1.01e9 * mapped_capacitance, expected="within 1 %"),
    )  # fmt: skip
    title = f"{solid.name}, {solid.frame}: period {period * 1e3:.4g} mm, metallisation {m:g}"
    return (Panel(name="stop_bands", title=title, data=data),), findings


@of_record
def figure(record: Panel, ax):
    """Draw the Bloch waves' phase and decay per finger, with the stop bands."""
    data, across, decay = record.data, quantity.frequency_Hz, ax.twinx()
    at = data.frequency_Hz * across.scale
    for name, colour in (("shorted", "slip"), ("open", "intermittent")):
        curve(ax, at, data[f"{name}_phase_rad"], ".", colour, f"{name}: phase")
        curve(decay, at, data[f"{name}_decay"], "-", colour, f"{name}: decay")
        low, high = (data[f"{name}_{edge}_Hz"] * across.scale for edge in ("lower", "upper"))
        shaded(ax, low, high, f"{name}: stop band", colour=colour)
        height, label = data[f"{name}_reflectivity"], f"{name}: |r| of a finger"
        decay.axhline(height, color=COLOURS[colour], linestyle=":", linewidth=1, label=label)
    decay.set_ylabel(quantity.finger_decay.axis)
    decay.set_ylim(0, 1.6 * max(data["shorted_reflectivity"], data["open_reflectivity"]))
    finished(ax, across.axis, quantity.finger_phase_rad.axis, record.title)
    legend_below(ax, [each for side in (ax, decay) for each in side.get_legend_handles_labels()[0]])
    return ax
