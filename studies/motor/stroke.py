"""How fast the slider runs at every position on the stator.

Method: the steady velocity of the slider of a scene (``twente`` by default) is computed at places between the driven
transducer and the next transducer, piece or end of the stator, as many in each half wavelength, the period of a
standing wave, as its range needs. At each place, the surface motion under each ball (of the finite aperture if it is
known) gives the steady velocity at up to three voltages of the scene. The figure shows the mean and the range over half
a wavelength. A dashed line shows a slider that starts at the position of the scene and travels through the field, with
its bounce; because of its mass it follows the mean. Expected: Fresnel fringes of the aperture. Run time: about 20 s.
"""

import logging
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

import contact
from studies.model.wave_to_contact import scaled
from studies.record.plots import COLOURS, curve, family, finished, lines
from studies.record.quantities import quantity
from studies.scene import Scene
from studies.solve.averaged_states import averaged_states
from studies.solve.stroke_speed import slider_range
from studies.solve.travel import WaveAlong
from studies.study_list import Answered, Panel, driven_contact, judged, of_record, study

LOGGER = logging.getLogger(__name__)

QUICK = {"count": 10, "duration": 2e-3}
LINES = 3
WITHIN = (16, 32, 64)  # places in half a wavelength, until the ends of the range agree to RANGE
RANGE = 0.01  # of the largest velocity
CLEAR = 0.5  # least distance from the fingers in wavelengths
UNKNOWN_TOLERANCE = 1e-3  # of the velocity at places to which averaging does not apply
PATH_TOLERANCE = 2e-3  # of the velocity of the travelling slider
NO_PATH = np.zeros(0)


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
    along, center = WaveAlong.under(driven.model, motion), resolved_scene.slider.center[0]
    if along is None:
        resolved_scene.refuse("slider.position", "must leave the slider a way along x: it stands at the end of it")
    LOGGER.info("stroke: the field along the stator")
    places = _Places.along(along, slider_range(driven.model, CLEAR * along.wavelength), center, count)
    velocities, paths, speeds, said = {}, {}, {}, []
    for level in driven.spread(1.05, LINES):
        name = driven.scene.named(level)
        LOGGER.info(f"stroke: {name}")
        velocities[name] = places.velocities(along, slider, level)
        paths[name], speeds[name], sentence = _path(driven, along, level, duration)
        said += [(f"path, {name}", sentence)] if sentence else []
    ((velocity_at_center, *_),) = averaged_states([(slider, along.orbits([0.0])[0], 0.0, level)])
    balls = np.array([x for x, _ in resolved_scene.slider.contact_positions])[:, None]
    size = places.statistics(lambda shifts: np.abs(along.track.at(shifts)[1]).mean(axis=0))
    section = places.statistics(lambda shifts: np.abs(motion.wave.motion(balls + shifts)[1]).mean(axis=0))
    by_speed = {key: (each.slowest, each.fastest) for key, each in velocities.items()}
    panels = (
        Panel(name="velocity", title=f"{resolved_scene.title}: velocity along the stator", data=dict(
            position_m=places.positions,
            velocity_m_per_s={key: each.mean for key, each in velocities.items()},
            lowest_m_per_s={key: each.lowest for key, each in velocities.items()},
            highest_m_per_s={key: each.highest for key, each in velocities.items()},
            slowest_m_per_s={key: each for key, (each, _) in by_speed.items()},
            fastest_m_per_s={key: each for key, (_, each) in by_speed.items()},
            path_m={key: center + each for key, each in paths.items()}, path_velocity_m_per_s=speeds,
            start_m=center, places_in_half_a_wavelength={k: each.within for k, each in velocities.items()},
        )),
        Panel(name="amplitude", title=f"{resolved_scene.title}: amplitude along the stator", data={
            "position_m": places.positions, "amplitude_m_per_V": size.mean,
            "smallest_m_per_V": size.lowest, "largest_m_per_V": size.highest,
            "section_m_per_V": section.mean, "finite_aperture": motion.beam is not None,
        }),
    )  # fmt: skip
    expected = contact.steady(slider, driven.at(level), tolerance=0.1 * tolerance).velocity
    findings = [
        judged("At the position in the scene, the velocity is that of the run.",
               "relative difference of the steady velocities", abs(velocity_at_center / expected - 1), high=2e-3),
    ]  # fmt: skip
    if speeds[name].size:
        largest = max(np.abs(velocities[name].fastest).max(), abs(velocity_at_center))
        findings.append(
            judged("A travelling slider is nowhere faster than the largest steady velocity.",
                   "its largest speed over the largest steady speed", abs(speeds[name]).max() / largest, high=1.001,
                   expected="up to 1"),
        )  # fmt: skip
    return panels, tuple(findings), said


@dataclass(frozen=True, kw_only=True)
class _Statistics:
    """Mean, ends and values of smallest and largest size within half a wavelength about each position."""

    mean: np.ndarray
    lowest: np.ndarray
    highest: np.ndarray
    slowest: np.ndarray
    fastest: np.ndarray
    within: int  # places in half a wavelength


@dataclass(frozen=True, kw_only=True)
class _Places:
    """Positions along a stator, and displacements at which the contact is solved about them."""

    positions: np.ndarray  # of the slider's centre, m
    start: float  # first displacement, m
    window: float  # half a wavelength, m
    count: int  # coarsest steps, `WITHIN[0]` to a window, in the whole range
    first: np.ndarray  # number of the coarsest step at which the window about each position begins

    @classmethod
    def along(cls, along: WaveAlong, ends: tuple[float, float], center: float, count: int) -> "_Places":
        """Return about ``count`` positions between two ends in m, on the grid of the coarsest steps."""
        low, high = ends
        window = min(along.wavelength / 2, high - low)
        steps = int((high - low) / (window / WITHIN[0]) * (1 + 1e-9))
        first = np.unique(np.linspace(0, steps - WITHIN[0], count).round().astype(int))
        positions = low + window * (first / WITHIN[0] + 0.5)
        return cls(positions=positions, start=low - center, window=window, count=steps, first=first)

    def shifts(self, within: int) -> np.ndarray:
        """Return all displacements, ``within`` of them to half a wavelength, m."""
        return self.start + self.window / within * np.arange(self.count * within // WITHIN[0] + 1)

    def statistics(self, values, within: int = WITHIN[0]) -> _Statistics:
        """Return the statistics of a function of the displacements in m, or of its values there."""
        known = values(self.shifts(within)) if callable(values) else values
        windows = np.lib.stride_tricks.sliding_window_view(known, within + 1)[self.first * within // WITHIN[0]]
        size, rows = np.abs(windows), np.arange(len(windows))
        slowest, fastest = size.argmin(axis=1), size.argmax(axis=1)
        return _Statistics(
            mean=0.5 * (windows[:, :-1] + windows[:, 1:]).mean(axis=1), lowest=windows.min(axis=1),
            highest=windows.max(axis=1), slowest=windows[rows, slowest], fastest=windows[rows, fastest],
            within=within,
        )  # fmt: skip

    def velocities(self, along: WaveAlong, slider, level: float) -> _Statistics:
        """Return the statistics of the steady velocity at a level, with as many places as its range needs."""

        def known(within: int) -> _Statistics:
            return self.statistics(_steady(slider, along.orbits(self.shifts(within)), level), within)

        found = known(WITHIN[0])
        for within in WITHIN[1:]:
            last, found = found, known(within)
            moved = np.maximum(np.abs(found.lowest - last.lowest), np.abs(found.highest - last.highest))
            if moved.max() <= RANGE * np.abs(found.fastest).max():
                break
        return found


def _steady(slider, orbits: list[tuple], level: float) -> np.ndarray:
    """Return the steady velocity at each place; where averaging has no answer, that of the motion itself, m/s.

    A place without any answer gets that of its neighbours.
    """
    velocity = np.array([each for each, *_ in averaged_states([(slider, balls, 0.0, level) for balls in orbits])])
    for k in np.flatnonzero(np.isnan(velocity)):
        with suppress(contact.ConvergenceError):
            velocity[k] = contact.steady(slider, scaled(orbits[k], level), tolerance=UNKNOWN_TOLERANCE).velocity
    known = np.flatnonzero(np.isfinite(velocity))
    return np.interp(np.arange(velocity.size), known, velocity[known])


def _path(driven, along: WaveAlong, level: float, duration: float) -> tuple[np.ndarray, np.ndarray, str]:
    """Return displacement in m and velocity of a slider that starts at the scene's position, and how its way ends.

    Both are empty if its contact needs every event followed, which takes too long.
    """
    options = {"after": 0.0, "tolerance": PATH_TOLERANCE, "samples": 2000, "method": "stepped"}
    try:
        path = contact.burst(
            driven.slider, driven.at(level), duration=duration, track=along.track.scaled(level), **options
        )
    except contact.ConvergenceError as error:
        return NO_PATH, NO_PATH, f"no motion of a travelling slider: {error}"
    ended = f"ends after {path.time[-1]:.4g} s: {along.end(path.displacement[-1])}" if path.ended else ""
    return path.displacement, path.velocity, ended


@of_record
def figure(record: Panel, ax):
    """Draw velocity or amplitude against the position on the stator."""
    data, across, up = record.data, quantity.position_m, quantity.velocity_m_per_s
    x = data["position_m"] * across.scale
    band, label = {"alpha": 0.25, "linewidth": 0}, "range over half a wavelength"
    if "amplitude_m_per_V" in data:
        scale = quantity.normal_m_per_V.scale
        ends = (data[key] * scale for key in ("smallest_m_per_V", "largest_m_per_V"))
        ax.fill_between(x, *ends, color=COLOURS["slip"], label=label, **band)
        ax.set_ylim(0, 1.05 * scale * max(data[key].max() for key in ("largest_m_per_V", "section_m_per_V")))
        name = "finite aperture" if data["finite_aperture"] else "under the balls"
        curves = (("section_m_per_V", "--", "stick", "plane section"), ("amplitude_m_per_V", "-", "slip", name))
        return lines(ax, record, quantity.position_m, curves, quantity.normal_m_per_V)
    for name, velocity, colour in family(data.velocity_m_per_s):
        curve(ax, x, velocity * up.scale, "-", colour, f"{name}, steady")
        ends = (data[key][name] * up.scale for key in ("lowest_m_per_s", "highest_m_per_s"))
        ax.fill_between(x, *ends, color=COLOURS[colour], **band)
        path, velocity = data["path_m"][name], data["path_velocity_m_per_s"][name]
        curve(ax, path * across.scale, velocity * up.scale, "--", colour)
    ax.fill_between([], [], color=COLOURS["line"], label=label, **band)
    curve(ax, [], [], "--", "line", "starting at the scene's position")
    ax.plot([across.scale * data["start_m"]], [0.0], "o", color=COLOURS["line"], markersize=4.0, clip_on=False)
    return finished(ax, across.axis, up.axis, record.title)
