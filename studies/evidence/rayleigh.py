"""Whether the finite elements give the Rayleigh wave of the half-space, and at what cost.

Method: the free wave of a lossless plate of eight wavelengths, whose two like faces guide the half-space's wave up to a
splitting that decays exponentially with the thickness, for tolerances from 1e-2 to 1e-10, against the half-space
without a mesh (partial waves): velocity, surface ratio, profile with depth, unknowns and CPU time (best of three).
Expected: at most twice the stated error; nine digits within 500 unknowns; the profile to the square root of that, as
the theory of a symmetric eigenproblem has it.  Run time: about 20 s.
"""

import logging
import math
import time
from dataclasses import replace

import numpy as np

import fem
from studies.record.plots import COLOURS, curve, finished
from studies.record.quantities import quantity
from studies.record.values import Columns
from studies.study_list import Answered, Finding, Panel, judged, of_record, study

LOGGER = logging.getLogger(__name__)

CUTS = (("PZT-4", "Z"), ("LiNbO3 (Warner)", "128YX"))
TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
FREQUENCY = 2.2e6
THICKNESS, SHOWN = 8.0, 2.0  # wavelengths: of the plate, and down to which the profiles are compared
FLOOR = 1e-12  # rounding: below it nothing converges any more
REPEATS = 3
QUICK = {"cuts": CUTS[:1], "tolerances": (1e-2, 1e-8), "repeats": 1}


@study()
def run(
    *, cuts: tuple[tuple[str, str], ...] = CUTS, tolerances: tuple[float, ...] = TOLERANCES, repeats: int = REPEATS,
) -> Answered:  # fmt: skip
    """Return velocity errors, unknowns and times at every tolerance, and the profile at the tightest.

    Parameters
    ----------
    cuts : tuple of (str, str)
        Materials and orientations.
    tolerances : tuple of float
        Of the velocity, from loose to tight.
    repeats : int
        Of each solution; the shortest time counts.
    """
    panels, findings = [], []
    for material, orientation in cuts:
        solid = fem.rotated(fem.material(material), orientation)
        solid = replace(solid, mechanical_quality=math.inf, dielectric_loss=0.0)
        exact = fem.rayleigh(solid, "open")
        thickness = THICKNESS * exact.velocity / FREQUENCY
        plate = fem.Stator(solid=solid, length=1.0, thickness=thickness, ends="absorbing")
        title = f"{material}, {orientation}"
        rows = []
        for tolerance in tolerances:
            LOGGER.info(f"{title}: tolerance {tolerance:g}")
            wave, seconds = _timed(plate, tolerance, repeats)
            rows.append(Columns(
                tolerance=tolerance, order=wave.order, unknowns=wave.unknowns, seconds=seconds,
                relative_error=abs(wave.velocity / exact.velocity - 1), stated=wave.relative_error,
            ))  # fmt: skip
        name = material.split()[0].replace("-", "_")
        panels.append(Panel.of_rows(f"convergence_{name}", title, rows))
        depth = -wave.depth * FREQUENCY / exact.velocity
        near = depth <= SHOWN
        meshed, analytic = wave.profile[near, :3], exact.profile(depth[near])[0]
        data = {"depth_wavelengths": depth[near], "half_space": analytic, "finite_elements": meshed}
        panels.append(Panel(name=f"profile_{name}", title=title, data=data))
        findings += _findings(title, rows, wave, exact, float(np.abs(meshed - analytic).max()))
    return panels, findings


def _timed(plate, tolerance: float, repeats: int):
    """Return the wave and the shortest of a few CPU times in s."""
    times = []
    for _ in range(repeats):
        start_time = time.process_time()
        wave = fem.free_wave(plate, frequency=FREQUENCY, tolerance=tolerance)
        times.append(time.process_time() - start_time)
    return wave, min(times)


def _findings(title: str, rows: list[Columns], wave, exact, apart: float) -> list[Finding]:
    ratio = abs(wave.surface_ratio / exact.surface_ratio - 1)
    return [
        judged(
            f"The true error is at most twice the stated one ({title}).",
            "true error of the velocity over the stated one, worst",
            max(max(row.relative_error - FLOOR, 0.0) / row.stated for row in rows), high=2.0,
        ),
        judged(
            f"500 unknowns give the velocity to nine digits ({title}).",
            "smallest relative error of the velocity within 500 unknowns",
            min(row.relative_error for row in rows if row.unknowns <= 500), high=1e-9,
        ),
        judged(
            f"The profile with depth is that of the half-space ({title}).",
            "largest difference over u_z at the surface, tightest tolerance", apart, high=1e-6,
        ),
        judged(
            f"The surface ratio is that of the half-space ({title}).", "relative difference of |u_x/u_z|",
            ratio, high=1e-9,
        ),
    ]  # fmt: skip


@of_record
def figure(record: Panel, ax):
    """Draw true and stated error against CPU time, or the profile with depth."""
    table = record.data
    if "half_space" in table:
        depth = table["depth_wavelengths"]
        for axis, name, colour in ((0, "Im u_x", "intermittent"), (2, "Re u_z", "slip")):
            exact, meshed = (table[key][:, axis] for key in ("half_space", "finite_elements"))
            exact, meshed = (exact.imag, meshed.imag) if axis == 0 else (exact.real, meshed.real)
            curve(ax, depth, exact, "-", colour, f"{name}, half-space")
            curve(ax, depth, meshed, "o", colour, f"{name}, finite elements")
        return finished(ax, quantity.depth_wavelengths.axis, quantity.relative_displacement.axis, record.title)
    true = [max(error, 1e-16) for error in table.relative_error]
    curve(ax, table["seconds"], true, "o-", "slip", "true", size=4.0)
    ax.plot(table["seconds"], table["stated"], "o", color=COLOURS["slip"], markerfacecolor="none", label="stated")
    for x, y, unknowns in zip(table["seconds"], true, table["unknowns"], strict=True):
        ax.annotate(str(unknowns), (x, y), fontsize="x-small")
    ax.set(xscale="log", yscale="log")
    across = f"{quantity.cpu_time_s.axis}; beside the points: unknowns (1)"
    return finished(ax, across, "relative error of the velocity (1)", record.title)
