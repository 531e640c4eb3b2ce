"""Amplitude of the wave at the slider against frequency, its bandwidth, and its group delay.

Method: u_z per volt under the slider of the scene (``twente-left`` by default; in the middle of a stator without a
slider) at 161 frequencies of a band, or at as many as resolve the ripple of returning waves: the whole motion and the
part of the surface mode, and the group delay -d(phase)/d(omega) of that part. They are compared with the quasi-static
estimate, including the loss on the path. Expected: if no waves return (otherwise nothing is judged), a maximum within a
factor of 2 of the estimate; a half-power bandwidth of 0.6 to 1.1 of f/N (0.886 f/N for sin x / x without the influence
of the path and the circuit); and in that band a median delay equal to the distance from the centre of the fingers over
the velocity of the Rayleigh wave. Run time: about 8 s.
"""

import logging

import numpy as np

import fem
from studies.model.model import Model
from studies.record.plots import curve, lines, shaded
from studies.record.quantities import quantity
from studies.record.run_pictures import draw_scan
from studies.scene import Scene
from studies.solve import passband
from studies.solve.spectrum import response
from studies.solve.surface_motion import solved_motion
from studies.stator.scan_panel import scan_answer, scan_file, scan_panel
from studies.study_list import Answered, Finding, Panel, judged, of_record, study

LOGGER = logging.getLogger(__name__)

QUICK = {"count": 9, "tolerance": 0.1}


@study("twente-left")
def run(scene: Scene, *, measured: str | None = None, count: int | None = None, tolerance: float = 1e-2) -> Answered:
    """Return amplitude and group delay against frequency.

    Parameters
    ----------
    measured : str, optional
        File of a vibrometer's scan over frequency, CSV or UFF; drawn over the prediction at its own frequencies.
    count : int, optional
        Number of frequencies; by default 161, or as many as resolve the ripple of returning waves.
    tolerance : float
        Relative, of the surface motion.
    """
    model = passband.driven_model(scene)
    resolved = model.scene
    scan = None if measured is None else scan_file(resolved, measured, "frequency")
    x, at = resolved.positions[0][0], passband.frequencies(model, count, 161)
    driven = resolved.driven_transducer
    prepared = response(model, at[0], at[-1], positions=(x,), tolerance=tolerance)
    LOGGER.info(f"stator: {len(at)} frequencies")
    waves = prepared.waves(at, model.drive)
    normal = np.array([each.motion(x)[1] for each in waves])
    covered = any(each.covered(x) for each in waves)
    surface = normal if covered else np.array([each.rayleigh_motion(x)[1] for each in waves])
    distance = abs(x - driven.center_xy[0])
    free = fem.free_wave(model.plain, frequency=float(np.median(at)), tolerance=1e-4)
    theory = passband.expected(model).normal(at) * np.exp(-free.attenuation * distance)
    travel_time = distance / free.velocity
    delay = passband.group_delay(at, surface, travel_time)
    band = np.array(half_power_band(at, abs(surface)))
    inside = (at >= band[0]) & (at <= band[1])
    remark = "other transducers or the ends send waves back, and the estimate has none"
    judgement = {"holds": None, "remark": remark} if passband.waves_return(resolved) else {}
    findings = (
        judged("The amplitude is that of charges that send a Rayleigh wave.",
               "largest surface-mode amplitude over the estimate's", abs(surface).max() / theory.max(), low=0.5, high=2,
               expected="between 0.5 and 2: the estimate includes no reflections and no bulk waves", **judgement),
        judged("N finger pairs pass a band of 0.886 f/N.", "width of half power, in f/N",
               np.ptp(band) / np.mean(band) * driven.finger_pairs, low=0.6, high=1.1, **judgement),
        judged("The group delay is that of a Rayleigh wave from the centre of the fingers.",
               f"median group delay in that band over {travel_time * 1e6:.4g} us",
               np.median(delay[inside]) * free.velocity / distance, low=0.9, high=1.1, expected="1, within 10 %",
               **judgement),
    )  # fmt: skip
    aperture, spreading = _aperture(model, x, tolerance)
    title = f"{resolved.title}: x = {x * 1e3:g} mm, plane section"
    error = max(each.relative_error for each in waves)
    panels = [
        Panel(name="amplitude", title=title, data=dict(
            frequency_Hz=at, normal_m_per_V=normal, surface_mode_m_per_V=surface, estimate_m_per_V=theory,
            half_power_Hz=band, relative_error=error,
        ) | aperture),
        Panel(name="group_delay", title=title, data=dict(
            frequency_Hz=at[inside], group_delay_s=delay[inside], way_s=travel_time,
        )),
    ]  # fmt: skip
    if scan is not None:
        panels.append(scan_panel(model, scan, tolerance=tolerance))
    return panels, findings + spreading, scan_answer(panels)


def _aperture(model: Model, x: float, tolerance: float) -> tuple[dict, tuple[Finding, ...]]:
    """Return the amplitude of the finite aperture at the drive's frequency and its finding, if the beam spreads."""
    scene = model.scene
    if not model.diffracts:
        return {}, ()
    LOGGER.info("stator: the beam at the drive's frequency")
    at = (x, 0.0) if scene.slider is None else scene.slider.center
    motion = solved_motion(model, [at], tolerance=tolerance, slider=True)
    amplitude = abs(motion.at([at])[2, 0])
    finding = judged(
        "The finite aperture changes the amplitude at the slider.",
        f"|u_z| in three dimensions over that of the plane section at {scene.frequency / 1e6:.5g} MHz",
        amplitude / abs(motion.wave.motion(x)[1]), low=0.3, high=2,
        remark="all curves are of the plane section, where the wave does not spread",
    )  # fmt: skip
    return {"drive_frequency_Hz": scene.frequency, "finite_aperture_m_per_V": amplitude}, (finding,)


@of_record
def figure(record: Panel, ax):
    """Draw the amplitude with its estimate, or the group delay with that of the distance."""
    data = record.data
    if "scan" in data:
        return draw_scan(data, ax)
    if "group_delay_s" in data:
        theory = data["way_s"] * quantity.group_delay_s.scale
        ax.axhline(theory, color="black", linewidth=1, label="distance over velocity (theory)")
        delay = (("group_delay_s", "o", "slip", "surface mode"),)
        return lines(ax, record, quantity.frequency_Hz, delay, quantity.group_delay_s)
    curves = (
        ("normal_m_per_V", "-", "stick", "all modes"),
        ("surface_mode_m_per_V", "o", "slip", "surface mode"),
        ("estimate_m_per_V", "-", "line", "no reflections, no bulk waves (estimate)"),
    )
    across, up = quantity.frequency_Hz, quantity.normal_m_per_V
    low, high = data["half_power_Hz"] * across.scale
    shaded(ax, low, high, "half of the power")
    sizes = [abs(data[key]).max() for key, *_ in curves]
    if "finite_aperture_m_per_V" in data:
        sizes.append(data["finite_aperture_m_per_V"])
        at, label = data["drive_frequency_Hz"] * across.scale, "finite aperture, at the drive's frequency"
        curve(ax, [at], [sizes[-1] * up.scale], "D", "intermittent", label, size=6.0)
    ax.set_ylim(0, 1.05 * up.scale * max(sizes))
    return lines(ax, record, quantity.frequency_Hz, curves, quantity.normal_m_per_V, columns=2)


def half_power_band(at, size) -> tuple[float, float]:
    """Return the frequencies in Hz at which the amplitude first falls below its maximum over root 2 on either side."""
    peak = int(np.argmax(size))
    level = size[peak] / np.sqrt(2)
    edges = []
    for frequencies, falling in ((at[peak::-1], size[peak::-1]), (at[peak:], size[peak:])):
        below = np.flatnonzero(falling <= level)
        outer = int(below[0]) if below.size else len(falling) - 1
        inner = max(outer - 1, 0)
        share = np.interp(level, falling[[outer, inner]], [0.0, 1.0]) if falling[outer] < level else 0.0
        edges.append(float(frequencies[outer] + share * (frequencies[inner] - frequencies[outer])))
    return edges[0], edges[1]
