"""The motion of a slider during and after a burst: with its travel, or on the wave at its first position.

The wave grows and decays as in `ring_up` if the method of solution accepts an envelope.  Otherwise it is steady from
the start of the burst to its end, where it stops.
"""

import numpy as np

import contact
from studies.model.wave_to_contact import Contact
from studies.record.point import Point
from studies.record.waveform import Modulation, modulation
from studies.refusal import SceneError
from studies.scene import Scene

MIN_TRAVEL = 0.1  # wavelengths: a shorter travel is neglected
FAR = 2.0  # wavelengths: a slider that comes this far at its steady velocity is followed along the field at once
SAMPLES = 2000  # instants of a stored trajectory; they do not affect the integration
STEADY_METHODS, BURST_METHODS = ("auto", "exact", "averaged"), ("auto", "exact", "stepped")
QUASI_STATIC = "quasi-static"  # on a passing wave, where height and tilts follow the velocity at once
SHAPED_METHODS = ("auto", "stepped", QUASI_STATIC)  # burst methods that accept an envelope


def followed_burst(driven: Contact, level: float, velocity: float, tolerance: float, after: float | None = None):
    """Return the trajectory of the slider during and after the burst, and the values of a point that its travel adds.

    ``velocity``: the steady one at this level.  The trajectory covers the time ``after`` (s) from the end of the burst.
    If this is None, it covers the stop of the slider and some periods of its tangential resonance.  Where the slider
    comes to fingers, a piece or the stator's end, the trajectory stops.
    """
    orbits, along = driven.at(level), driven.along
    if along is None or level == 0.0:
        return _burst(driven, orbits, velocity, tolerance, after), Point()
    if driven.scene.slider.travel is None and abs(velocity) * driven.scene.burst <= FAR * along.wavelength:
        trajectory = _burst(driven, orbits, velocity, tolerance, after)
        if _travel(trajectory) <= MIN_TRAVEL * along.wavelength:
            return trajectory, Point()
    trajectory = _burst(driven, orbits, velocity, tolerance, after, along.track.scaled(level))
    during = trajectory.time <= trajectory.duration * (1 + 1e-12)
    end = float(trajectory.time[-1]) if trajectory.ended else None
    return trajectory, Point(travel_m=float(trajectory.displacement[during][-1]), way_ends_after_s=end)


def _travel(trajectory) -> float:
    """Return how far a slider comes in a burst that is followed at one place, m."""
    during = trajectory.time <= trajectory.duration * (1 + 1e-12)
    return abs(float(np.trapezoid(trajectory.velocity[during], trajectory.time[during])))


def _burst(
    driven: Contact, orbits: tuple, velocity: float, tolerance: float, after: float | None,
    track: contact.Track | None = None,
):  # fmt: skip
    """Return the trajectory of a slider on a track, or of one that remains on the wave at its initial position."""
    slider, duration, ringing = driven.moving_slider, driven.scene.burst, driven.ringing
    friction = slider.least_friction(driven.contacts)
    stopping_time = abs(velocity) * slider.mass / friction if friction > 0 else 0.0
    ringing_time = 20 / slider.tangential_resonance(driven.contacts) if slider.preload > 0 else 0.0
    after = min(1.2 * stopping_time + ringing_time, 10 * duration) if after is None else after
    method = QUASI_STATIC if driven.passing else method_of(driven.scene, "a burst", BURST_METHODS)

    def followed(envelope=None, after=after):
        options = {"tolerance": tolerance, "samples": SAMPLES, "method": method, "envelope": envelope, "track": track}
        return contact.burst(slider, orbits, duration=duration, after=after, **options)

    shaped = modulation(driven.scene)
    if shaped is not None:
        _refuse_unshaped(driven, method, shaped)
    if driven.solved is None and shaped is not None:
        return followed(shaped.envelope)
    if ringing is None or ringing.envelope is None or method not in SHAPED_METHODS:
        return followed()
    ring_down = None if driven.passing else ringing.ring_down
    try:
        # `after` of `contact.burst`: the time, with the envelope of the ring-down
        faded = after if ring_down is None else (after + float(ring_down.time[-1]), ring_down)
        return followed(ringing.envelope, faded)
    except contact.ConvergenceError:
        if method != "auto" or shaped is not None:
            raise
        return followed()  # this motion needs the event-based solver, which accepts no envelope


def _refuse_unshaped(driven: Contact, method: str, shaped: Modulation) -> None:
    """Raise a SceneError where the method of a burst cannot follow its waveform."""
    scene, key = driven.scene, f"{driven.scene.source.block}.waveform"
    if method not in SHAPED_METHODS:
        scene.refuse(key, f'needs slider.method "auto" or "stepped", got "{method}", which takes a steady wave')
    if driven.passing and shaped.turns:
        scene.refuse(key, "must keep phase and frequency with pillars that load the wave: their height follows at once")


def method_of(scene: Scene, what: str, available: tuple[str, ...]) -> str:
    """Return the solution method for a steady state or a burst; "auto" if the scene's exists only for the other one.

    `contact.choice` then selects the method that computes the answer.
    """
    method = scene.slider.method
    if method not in available:
        if scene.burst is None or method not in STEADY_METHODS + BURST_METHODS:
            names = " or ".join(f'"{name}"' for name in available)
            raise SceneError("slider.method", f"must be {names} for {what}, got {method!r}")
        return "auto"
    return method
