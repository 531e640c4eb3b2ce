r"""The motion of a slider in the plane during and after the burst of a run, on the waves of its way.

As along x the burst begins where u_z of the first contact crosses zero upwards, and lasts a whole number of cycles; of
several frequencies those of the fastest.
The waves of a stator grow as 1 - exp(-t/tau) and fade likewise; tau is the time that the ring-up under the slider's
centre costs (`ring_up`), the integral of one minus its envelope: the impulse of a burst depends on that time to first
order. The slider is followed to rest; where a contact comes to fingers, a piece or an edge of the stator, the motion
ends.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import contact
import fem
from contact import plane
from studies.model.plane import StatorSurface
from studies.model.wave_to_contact import Contact
from studies.record.point import Point
from studies.record.waveform import modulation
from studies.scene.plane_keys import AXLE
from studies.solve.mapped_surface import travelled
from studies.solve.ring_up import RingUp
from studies.solve.slider_burst import method_of

SAMPLES = 200  # instants of the burst, and of the coast, in the record
METHODS = ("auto", "exact", "stepped", "averaged")
EVENTS = 20_000  # cycles of the fastest wave times contacts up to which `auto` follows burst and slide by events
RINGS = 20.0  # periods of the tangential resonance that are followed after a stop
# Error of a velocity by the envelope's shape, over tau over the duration: a sudden start that is delayed by tau, from
# which the slider bounces, changes it by -0.9 to 0.4 of that after 0.1 to 1 ms on `twente-planar`
SHAPE = 1.0


@dataclass(frozen=True, kw_only=True)
class Rise:
    """Growth of the waves of all sources at the slider, with what `studies.solve.ring_up.RingUp` has for readers."""

    rings: tuple[RingUp, ...]  # of each frequency
    duration: float  # s, of the burst
    shaped: tuple[float, ...] = ()  # frequencies in Hz of the rings, whose envelopes are those of a waveform

    @property
    def time(self) -> float:
        """Mean time constant of the rise, s; 0 where a ring-up was too long to be computed, and of a waveform."""
        known = [each.envelope for each in self.rings if each.envelope is not None]
        if len(known) < len(self.rings) or self.shaped:
            return 0.0
        return max(float(np.mean([np.trapezoid(1.0 - each.amplitude, each.time) for each in known])), 0.0)

    @property
    def error(self) -> float:
        """Relative error of the velocity at the end of the burst by the ring-up."""
        own = max(each.error for each in self.rings)
        return own + SHAPE * min(self.time / self.duration, 1.0)

    @property
    def envelopes(self) -> dict[str, dict[float, contact.Envelope]]:
        """The factors on the waves of each frequency of a waveform, as `contact.plane.burst` takes them."""
        return {
            name: {f: getattr(each, name) for f, each in zip(self.shaped, self.rings, strict=True)}
            for name in ("envelope", "ring_down")
        }

    @property
    def slowest(self) -> RingUp:
        """The ring-up that lasts longest."""
        return max(self.rings, key=lambda each: math.inf if each.response is None else each.response.settling)

    response = property(lambda self: self.slowest.response)
    sentence = property(lambda self: self.slowest.sentence)


def followed_in_plane(driven: Contact, slider: Any, level: float, speed: float, tolerance: float):
    """Return the `contact.plane.PlaneTrajectory` of a slider at a level, and the values of a point that it adds.

    ``speed``: in the steady state, m/s.
    """
    scene, rise = driven.scene, 0.0 if driven.ringing is None else driven.ringing.time
    shape = envelopes_of(driven)
    method = method_of(scene, "a burst", METHODS)
    after = _after(slider, speed, scene.burst)
    surface = plane.from_upward_zero(slider, travelled(driven, level))
    waves = surface.at(*plane.places(slider, (0.0, 0.0, 0.0)))
    fastest = max(waves.frequencies)
    duration = max(1, round(scene.burst * fastest)) / fastest
    cycles = (duration + after) * fastest * slider.count
    slow = plane.beats_slowly(slider, waves)
    if method == "averaged" or (method == "auto" and cycles > EVENTS and not slow and not shape):
        after = math.inf
    motion = plane.burst(
        slider, surface, duration=duration, after=after, tolerance=tolerance, samples=SAMPLES, method=method,
        rise_time=rise, **shape,
    )  # fmt: skip
    motion, end = on_free_surface(driven, slider, motion)
    sway = (0.0, 0.0) if end is not None else _sway(slider, motion)
    return motion, _values(scene.slider, motion, sway) | Point(way_ends_after_s=end)


def envelopes_of(driven: Contact) -> dict[str, Any]:
    """Return what `contact.plane.burst` takes of the waveform of a burst; empty of a rectangular one."""
    shaped = modulation(driven.scene)
    if shaped is None:
        return {}
    if driven.ringing is None:
        return {"envelope": shaped.envelope}
    return driven.ringing.envelopes


def _after(slider, speed: float, duration: float) -> float:
    """Return a time in which the slider stops after a burst, and rings out, s."""
    friction = slider.friction_coefficient * slider.preload
    stop = min(1.2 * speed * slider.mass / friction, 1.2 * duration)
    return stop + RINGS / slider.tangential_resonance(slider.count)


def _sway(slider, motion: plane.PlaneTrajectory) -> tuple[float, float]:
    """Return how far from the motion's end the slider may come to rest in its contacts' springs, m, and rad of yaw.

    Of a motion followed through its cycles half the range of the last part of the ring; the error of the averaged
    motion contains it.
    """
    if motion.stopped < math.inf:
        return 0.0, 0.0
    last = motion.time >= motion.time[-1] - 0.5 * RINGS / slider.tangential_resonance(slider.count)
    x, y, yaw = 0.5 * np.ptp(motion.pose[last], axis=0)
    return float(np.hypot(x, y)), float(yaw)


def on_free_surface(driven: Contact, slider, motion: plane.PlaneTrajectory):
    """Return the motion up to where a contact leaves the free surface of a stator, and the time at which it does."""
    if not isinstance(driven.surface, StatorSurface):
        return motion, None
    center = driven.surface.center
    free = [_free(driven, *np.add(plane.places(slider, pose), np.array(center)[:, None])) for pose in motion.pose]
    if all(free):
        return motion, None
    count = max(free.index(False), 1)
    rows = {name: getattr(motion, name)[:count] for name in ("time", "pose", "rates", "height")}
    return replace(motion, **rows, stopped=math.inf), float(motion.time[count - 1])


def _free(driven: Contact, x: np.ndarray, y: np.ndarray) -> bool:
    """Return whether places (x, y) in m on the stator all lie on its free surface."""
    stator, model = driven.scene.stator, driven.model
    half_width = math.inf if stator.width is None else 0.5 * stator.width
    if np.any((x < 0.0) | (x > stator.length) | (np.abs(y) > half_width)):
        return False
    if any(np.any((each.extent[0] <= x) & (x <= each.extent[1])) for each in model.pieces):
        return False
    places = list(zip(x.tolist(), y.tolist(), strict=True))
    return not any(fem.covers(each, place) for each in model.transducers for place in places)


def _values(block: Any, motion: plane.PlaneTrajectory, sway: tuple[float, float]) -> Point:
    """Return velocity at the burst's end and pose at the end of the motion, with its error; of an axle its turn.

    ``sway``: what the errors contain of the ring after the stop, m and rad.
    """
    at_end, (x, y, yaw) = motion.rates[motion.burst_end], motion.pose[-1]
    path, turn = np.concatenate([np.zeros((1, 3)), motion.pose]), Point()
    if block.turns:
        turn = Point(
            yaw_rate_at_burst_end_rad_per_s=float(at_end[2]), turn_rad=float(yaw),
            turn_error_rad=float(motion.pose_error[2]) + sway[1],
        )  # fmt: skip
    if block.freedom == AXLE:
        arm = max(math.dist(each, block.axis) for each in block.offsets)
        return turn | Point(path_length_m=float(arm * np.abs(np.diff(path[:, 2])).sum()), burst_method=motion.method)
    return turn | Point(
        velocity_at_burst_end_m_per_s=float(at_end[0]), lateral_velocity_at_burst_end_m_per_s=float(at_end[1]),
        displacement_m=float(x), lateral_displacement_m=float(y),
        displacement_error_m=float(np.hypot(*motion.pose_error[:2])) + sway[0],
        path_length_m=float(np.hypot(*np.diff(path[:, :2], axis=0).T).sum()), burst_method=motion.method,
    )  # fmt: skip
