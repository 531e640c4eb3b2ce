"""How fast the slider runs at every position on the stator.

Method: the slider of a scene (``twente`` by default) is placed at many positions between the driven transducer and the
next transducer or the end of the stator. Around each position, four points cover half a wavelength, the period of a
standing wave. At each point, the surface motion under each ball (of the finite aperture if it is known) gives the
steady velocity at up to three voltages of the scene. The figure shows the mean and the range over half a wavelength. A
dashed line shows a slider that starts at the position of the scene and travels through the field; because of its mass
it follows the mean. Expected: Fresnel fringes of the aperture. Run time: about 7 s.
"""

import logging

import numpy as np

import contact
from studies.chain.steady import averaged
from studies.chain.stroke_speed import slider_range
from studies.chain.travel import WaveAlong, travelled
from studies.record.plots import COLOURS, curve, family, finished, lines
from studies.record.quantities import quantity
from studies.scene import Scene
from studies.study import Answered, Panel, driven_contact, judged, of_record, study

LOGGER = logging.getLogger(__name__)

QUICK = {"count": 10, "duration": 2e-3}
LINES = 3
WITHIN = 4  # points over half a wavelength around each position
CLEAR = 0.5  # least distance from the fingers in wavelengths


@study("twente")
def run(scene: Scene, *, count: int = 240, duration: float = 0.3, tolerance: float = 1e-3) -> Answered:
    """Return amplitude and steady velocity against the position of the slider, and the motion of a travelling slider.

    Parameters
    ----------
    count : int
        Number of positions.
    duration : float
        Duration of the motion along the field, s.
    tolerance : float
        Of the slider velocity.
    """
    driven = driven_contact(scene, tolerance=tolerance)
    if driven.record is None:
        driven.scene.refuse("wave", "must be absent: along the wave of a [wave] all positions are alike")
    resolved_scene, slider, motion = driven.scene, driven.slider, driven.record.surface_motion
    along, center = WaveAlong.under(resolved_scene.slider, motion), resolved_scene.slider.center[0]
    low, high = slider_range(resolved_scene, CLEAR * along.wavelength)
    half_wavelength = along.wavelength / 2
    positions = np.linspace(low + half_wavelength / 2, high - half_wavelength / 2, count)
    ripple = half_wavelength * ((np.arange(WITHIN) + 0.5) / WITHIN - 0.5)
    shifts = np.append(np.add.outer(positions, ripple), center) - center
    LOGGER.info("stroke: the field along the stator")
    orbits = along.orbits(shifts)
    velocities, paths, speeds = {}, {}, {}
    for level in driven.spread(1.05, LINES):
        name = driven.scene.named(level)
        LOGGER.info(f"stroke: {name}")
        states = averaged([(slider, each, 0.0, level) for each in orbits])
        velocities[name] = np.array([velocity for velocity, *_ in states[:-1]]).reshape(count, WITHIN)
        velocity_at_center = float(states[-1][0])
        path = travelled(slider, along, level, duration, duration * velocity_at_center)
        paths[name], speeds[name] = center + path.displacement, path.velocity
    amplitude = np.reshape([np.mean([abs(each.normal) for each in balls]) for balls in orbits[:-1]], (count, WITHIN))
    balls = np.array([x for x, _ in resolved_scene.slider.contact_positions])
    section = [np.mean([abs(motion.wave.motion(x)[1]) for x in balls + shift]) for shift in shifts[:-1]]
    panels = (
        Panel(name="velocity", title=f"{resolved_scene.title}: velocity along the stator", data={
            "position_m": positions, "velocity_m_per_s": {key: each.mean(axis=1) for key, each in velocities.items()},
            "slowest_m_per_s": {key: each.min(axis=1) for key, each in velocities.items()},
            "fastest_m_per_s": {key: each.max(axis=1) for key, each in velocities.items()},
            "path_m": paths, "path_velocity_m_per_s": speeds,
        }),
        Panel(name="amplitude", title=f"{resolved_scene.title}: amplitude along the stator", data={
            "position_m": positions, "amplitude_m_per_V": amplitude.mean(axis=1),
            "smallest_m_per_V": amplitude.min(axis=1), "largest_m_per_V": amplitude.max(axis=1),
            "section_m_per_V": np.reshape(section, (count, WITHIN)).mean(axis=1),
            "finite_aperture": motion.beam is not None,
        }),
    )  # fmt: skip
    steady, expected = velocities[name], contact.steady(slider, driven.at(level), tolerance=0.1 * tolerance).velocity
    fastest = abs(steady[np.isfinite(steady)]).max()
    findings = (
        judged("At the position in the scene, the velocity is that of the run.",
               "relative difference of the steady velocities", abs(velocity_at_center / expected - 1), high=2e-3),
        judged("A travelling slider is nowhere faster than the largest steady velocity.",
               "its largest speed over the largest steady speed", abs(speeds[name]).max() / fastest, high=1.001,
               expected="up to 1"),
    )  # fmt: skip
    return panels, findings


@of_record
def figure(record: Panel, ax):
    """Draw velocity or amplitude against the position on the stator."""
    data, across, up = record.data, quantity("position_m"), quantity("velocity_m_per_s")
    x = data["position_m"] * across.scale
    band, label = {"alpha": 0.25, "linewidth": 0}, "range over half a wavelength"
    if "amplitude_m_per_V" in data:
        scale = quantity("normal_m_per_V").scale
        ends = (data[key] * scale for key in ("smallest_m_per_V", "largest_m_per_V"))
        ax.fill_between(x, *ends, color=COLOURS["slip"], label=label, **band)
        ax.set_ylim(0, 1.05 * scale * max(data[key].max() for key in ("largest_m_per_V", "section_m_per_V")))
        name = "finite aperture" if data["finite_aperture"] else "under the balls"
        curves = (("section_m_per_V", "--", "stick", "plane section"), ("amplitude_m_per_V", "-", "slip", name))
        return lines(ax, record, "position_m", curves, "normal_m_per_V")
    for name, velocity, colour in family(data["velocity_m_per_s"]):
        curve(ax, x, velocity * up.scale, "-", colour, f"{name}, steady")
        ends = (data[key][name] * up.scale for key in ("slowest_m_per_s", "fastest_m_per_s"))
        ax.fill_between(x, *ends, color=COLOURS[colour], **band)
        path, velocity = data["path_m"][name], data["path_velocity_m_per_s"][name]
        curve(ax, path * across.scale, velocity * up.scale, "--", "line")
    ax.fill_between([], [], color=COLOURS["line"], label=label, **band)
    curve(ax, [], [], "--", "line", "starting at the scene's position")
    return finished(ax, across.axis, up.axis, record.title)
