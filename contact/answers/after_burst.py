"""Motion of a slider after a burst: while the surface rings down, and then on the surface at rest.

During the ring-down the slider is followed with fixed time steps, afterwards event by event with segments as long as
the contact resonance allows.
"""

from typing import NamedTuple

import numpy as np

from contact.answers.rest_motion import silence
from contact.answers.ring_down import ring_down
from contact.codes import Recorded
from contact.envelope import Envelope
from contact.events.motion import Motion
from contact.slider import Slider
from contact.stepping.along_track import Followed, Scaled


class Series(NamedTuple):
    """Part of a trajectory: times in s, velocities and positions scaled, arrays (k,)."""

    time: np.ndarray
    velocity: np.ndarray
    position: np.ndarray


class Afterwards(NamedTuple):
    """The motion after a burst.

    `parts` have their times from the end of the burst; `rang` is the duration of the ring-down in s; `along` is the
    motion on a track during it, None without a track or a ring-down. `at_rest` is the motion on the surface at rest;
    None if the surface does not come to rest in time, or the slider comes to an end of the track before.
    """

    parts: tuple[Series, ...] = ()
    rang: float = 0.0
    along: Followed | None = None
    at_rest: Motion | None = None


def follow_after(
    slider: Slider,
    motion: Motion,
    span: float,
    fading: Envelope | None,
    samples: float,
    track: Scaled | None,
    driven: Followed | None,
) -> Afterwards:
    """Return the motion in the time `span` (s) after a burst, with about so many samples.

    Parameters
    ----------
    motion : Motion
        At the end of the burst; the ring-down changes it.
    fading : Envelope or None
        Factor on the orbits after the burst; None: the surface is at rest at once.
    track, driven
        The track of the burst, and the motion along it during the burst; None without one.
    """
    parts: tuple[Series, ...] = ()
    rang, along, start = 0.0, None, driven.place if driven is not None else 0.0
    if fading is not None:
        count = max(2, round(samples / 2.0))
        times, record, *ways = ring_down(slider, motion, fading, longest=span, samples=count, track=track, start=start)
        along = ways[0] if ways else None
        if times.size:
            rang = float(times[-1])
            parts = (Series(times, record[:, Recorded.VELOCITY], record[:, Recorded.POSITION]),)
    if span <= rang or any(each is not None and each.ended for each in (driven, along)):
        return Afterwards(parts, rang, along)
    return _on_surface_at_rest(motion, span - rang, max(2, round(samples)), Afterwards(parts, rang, along))


def _on_surface_at_rest(motion, span, count, rung):
    """Return the motion `rung` continued on the surface at rest, for a time in s with so many samples."""
    problem, at_rest = motion.problem, silence(motion)
    times = np.arange(1, count + 1) * (span / count)
    phases = times * problem.omega
    approach, *_, velocity = at_rest.move(0.0, problem.omega * span * (1.0 + 1e-12), phases)[:, 0].T
    # the surface is at rest at zero, so that the approach of the first contact is its height less z_s
    part = Series(rung.rang + times, velocity, problem.paths.height[0] - approach)
    return rung._replace(parts=(*rung.parts, part), at_rest=at_rest)
