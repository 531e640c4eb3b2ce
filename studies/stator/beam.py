"""Spreading of the beam by the finite aperture: amplitude along its axis and across it, against the plane section.

Method: u_z of the scene (``twente`` by default) in three dimensions, from the charges of the section within the
aperture and the guided modes at every lateral wavenumber. It is computed on the axis from the driven transducer to its
neighbour or to the end of the stator, and across the beam at the slider, with absorbing ends. Lines show the section,
and the angular spectrum of the aperture on the slowness curve of the section's surface mode, with attenuation but
without the ripple of returning waves. If transducers are turned, those whose waves run closest to x are shown in their
own axes. Expected: Fresnel fringes with the ripple of the plate; a mean over the aperture of 0.8 to 1 of the section.
Run time: about 10 s, and 30 s in cuts that are not isotropic about z.
"""

import math
from dataclasses import replace

import numpy as np

import fem
from studies.model.fem_objects import free_span
from studies.record.plots import curve, finished
from studies.record.quantities import quantity
from studies.record.run_pictures import draw_scan
from studies.refusal import RunError
from studies.scene import Scene
from studies.solve import passband
from studies.solve.surface_motion import solved_motion
from studies.stator.scan_panel import scan_answer, scan_file, scan_panel
from studies.study_list import Answered, Panel, judged, of_record, study

QUICK = {"count": 25}
CLEAR = 0.6  # wavelengths from the fingers where the axis begins
FINE = 1500  # points of a line of the theory
RIPPLE = 16  # points over half a wavelength
STEEPEST, DIRECTIONS = 0.36, 16  # of the slowness curve: largest lateral over total wavenumber, and number of points


@study("twente")
def run(scene: Scene, *, measured: str | None = None, count: int = 400, tolerance: float = 1e-3) -> Answered:
    """Return the amplitude on the axis and across the beam.

    Parameters
    ----------
    measured : str, optional
        File of a vibrometer's scan along x, along y or over both, CSV or UFF; drawn over the beam at its own positions.
    count : int
        Number of points of each line.
    tolerance : float
        Relative, of the section's surface motion.
    """
    model = passband.driven_model(scene)
    whole = model.scene
    scan = None if measured is None else scan_file(whole, measured, "position")
    beside, slider_x = model.first_section(whole.positions[0])
    driven, block = beside.driven, beside.scene.stator
    section = beside.with_blocks(stator=replace(block, diffraction=False))
    try:
        wave = solved_motion(section, [(slider_x, 0.0)], tolerance=tolerance).wave
        beam = fem.surface_beam(wave, mirror_width=block.mirror_width)
        # on the slider's side of the driven transducer, up to the next one or the end
        edge, clear = driven.extent[slider_x >= driven.center], CLEAR * wave.phase_velocity / wave.frequency
        extents = [each.extent for each in beside.transducers]
        x = np.linspace(*free_span(extents, edge, block.length, clear), count)
        y = np.linspace(-0.75, 0.75, count) * driven.aperture
        axis, across = beam.motion(x), beam.motion(slider_x, y)
    except (fem.BeamError, fem.ConvergenceError) as error:
        raise RunError(f"the beam of this scene: {error}") from None
    fine_x, fine_y = np.linspace(x[0], x[-1], FINE), np.linspace(y[0], y[-1], FINE)
    # logarithm of the attenuated amplitude without ripple, linear in x
    decay = np.polynomial.Polynomial.fit(x, np.log(abs(wave.rayleigh_motion(x)[1])), 1)
    slowness, distance = _slowness(beam, wave), abs(slider_x - driven.center)

    def panel(name, title, along, at, motion, line_at, line, lateral) -> Panel:
        surface, away = np.exp(decay(line)), line - driven.center
        return Panel(name=name, title=title, data={
            "axis": along.axis, "at": at * along.scale, "beam_m_per_V": abs(motion[2]),
            "line_at": line_at * along.scale,
            "section_m_per_V": abs(wave.motion(line)[1]),
            "spectrum_m_per_V": surface * slowness.spectrum(driven.aperture, away, lateral),
        })  # fmt: skip

    panels = [
        panel("along", f"On the axis of {driven.name!r}", quantity.center_distance_m, x - driven.center, axis,
              fine_x - driven.center, fine_x, np.zeros(FINE)),
        panel("across", f"Across the beam, {distance * 1e3:.3g} mm from the transducer's centre", quantity.y_m, y,
              across, fine_y, np.full(FINE, slider_x), fine_y),
    ]  # fmt: skip
    section, mean = abs(wave.motion(slider_x)[1]), np.mean(across[2, abs(y) <= driven.aperture / 2])
    # over half a wavelength, in which echoes, which spread more than the wave, add to it once and subtract once
    near = slider_x + np.linspace(-0.25, 0.25, RIPPLE) * wave.phase_velocity / wave.frequency
    near = near[(near >= x[0]) & (near <= x[-1])] if x[0] <= slider_x <= x[-1] else np.array([slider_x])
    on_axis = np.sqrt(np.mean(abs(beam.motion(near)[2]) ** 2) / np.mean(abs(wave.motion(near)[1]) ** 2))
    expected = float(slowness.spectrum(driven.aperture, np.array([distance]), np.zeros(1))[0])
    angle = math.degrees(math.atan(slowness.steering))
    findings = (
        judged("Under the slider the amplitude is that of an aperture's near field.",
               "|u_z| on the axis over that of the plane section, rms over half a wavelength", on_axis,
               low=expected - 0.1, high=expected + 0.1, expected=f"{expected:.3f} +- 0.1, angular spectrum",
               remark=f"power-flow angle {angle:.3g} degrees, slowness curvature {slowness.curvature:.3g}"),
        judged("The beam keeps within the aperture.", "mean of u_z over the aperture over that of the plane section",
               abs(mean) / section, low=0.8, high=1.02),
        judged("The integral over the lateral wavenumber adds nothing to the section's error.",
               "estimated relative error under the slider", beam.relative_error(slider_x), high=2 * tolerance,
               expected="below twice the tolerance of the section"),
    )  # fmt: skip
    if scan is not None:
        panels.append(scan_panel(model, scan, tolerance=tolerance))
    return panels, findings, scan_answer(panels)


def _slowness(beam, wave) -> fem.Slowness:
    """Return the slowness curve of the surface wave that a beam consists of."""
    highest = STEEPEST * 2 * np.pi * wave.frequency / wave.phase_velocity
    lateral = highest * np.cos(np.pi * (np.arange(DIRECTIONS) + 0.5) / DIRECTIONS)
    return fem.Slowness.through(lateral, beam.surface_wavenumbers(lateral))


@of_record
def figure(record: Panel, ax):
    """Draw the beam as points, the angular spectrum as a line, and the section dashed."""
    data, up = record.data, quantity.normal_m_per_V
    if "scan" in data:
        return draw_scan(data, ax)
    for name, style, colour, label in (
        ("section", "--", "stick", "plane section"),
        ("spectrum", "-", "line", "angular spectrum"),
    ):
        curve(ax, data["line_at"], data[f"{name}_m_per_V"] * up.scale, style, colour, label)
    curve(ax, data["at"], data["beam_m_per_V"] * up.scale, "o", "slip", "finite aperture", size=2.0)
    return finished(ax, data["axis"], up.axis, record.title, columns=2)
