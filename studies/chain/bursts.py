"""The motion of a slider on balls during and after a burst: on the wave at its position, then with its travel.

The wave grows and decays as in `ring_up` if the method of solution accepts an envelope.  Otherwise it is steady from
the start of the burst to its end, where it stops.
"""

from dataclasses import replace

import numpy as np

import contact
from studies.chain.bridge import DrivenContact
from studies.chain.travel import MIN_TRAVEL, travelled, with_travel
from studies.refusal import SceneError
from studies.scene import Scene

SAMPLES = 2000  # instants of a stored trajectory; they do not affect the integration
STEADY_METHODS, BURST_METHODS = ("auto", "exact", "averaged"), ("auto", "exact", "stepped")
SHAPED_METHODS = ("auto", "stepped")  # burst methods that accept an envelope


def followed_burst(driven: DrivenContact, level: float, velocity: float, tolerance: float, after: float | None = None):
    """Return the trajectory of the slider during and after the burst, and the values of a point that its travel adds.

    ``velocity``: the steady one at this level.  The trajectory covers the time ``after`` (s) from the end of the burst.
    If this is None, it covers the stop of the slider and some periods of its tangential resonance.
    """
    trajectory = _burst_without_travel(driven, driven.at(level), velocity, tolerance, after)
    return (trajectory, {}) if driven.along is None else _along(driven, trajectory, level)


def _burst_without_travel(driven: DrivenContact, orbits: tuple, velocity: float, tolerance: float, after: float | None):
    """Return the trajectory of a slider that remains on the wave at its initial position."""
    slider, duration, ringing = driven.slider, driven.scene.burst, driven.ringing
    friction = slider.least_friction(len(orbits))
    stopping_time = abs(velocity) * slider.mass / friction if friction > 0 else 0.0
    ringing_time = 20 / slider.tangential_resonance(len(orbits)) if slider.preload > 0 else 0.0
    after = min(1.2 * stopping_time + ringing_time, 10 * duration) if after is None else after
    method = method_of(driven.scene, "a burst", BURST_METHODS)

    def followed(envelope=None, after=after):
        options = {"tolerance": tolerance, "samples": SAMPLES, "method": method, "envelope": envelope}
        return contact.burst(slider, orbits, duration=duration, after=after, **options)

    if ringing is None or ringing.envelope is None or method not in SHAPED_METHODS:
        return followed()
    ring_down = ringing.ring_down
    try:
        # `after` of `contact.burst`: the time, with the envelope of the ring-down
        faded = after if ring_down is None else (after + float(ring_down.time[-1]), ring_down)
        return followed(ringing.envelope, faded)
    except contact.ConvergenceError:
        if method != "auto":
            raise
        return followed()  # this motion needs the event-based solver, which accepts no envelope


def _along(driven: DrivenContact, trajectory, level: float):
    """Return the trajectory with the slider's travel along the wave field, and the additional values of the point.

    If the slider hardly moves, the trajectory is unchanged.
    """
    during = trajectory.time <= trajectory.duration * (1 + 1e-12)
    expected = float(np.trapezoid(trajectory.velocity[during], trajectory.time[during]))
    if driven.scene.slider.travel is None and abs(expected) <= MIN_TRAVEL * driven.along.wavelength:
        return trajectory, {}
    travel = travelled(driven.slider, driven.along, level, trajectory.duration, expected)
    if travel.ended:
        raise contact.ConvergenceError(
            "not applicable",
            f"a ball reaches the stator's end {travel.time[-1]:.3g} s after the start: shorten drive.burst, or set "
            "slider.travel = false for the velocity that the wave at the slider's position would give",
        )
    # assume that the relative error of averaging is the same for the change by travel as for the burst at one point
    speed = contact.reference_speed(trajectory.velocity_at_burst_end, trajectory.orbits)
    averaging_error = abs(travel.velocity_without_travel[-1] - trajectory.velocity_at_burst_end) / speed
    with_change = with_travel(trajectory, travel)
    error = trajectory.answer.error + travel.error + averaging_error * abs(travel.change)
    return replace(with_change, answer=replace(with_change.answer, error=error)), {
        "travel_m": float(travel.displacement[-1])
    }


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
