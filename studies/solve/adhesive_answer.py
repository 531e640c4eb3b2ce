"""The answer at one level of a heavy slider on balls whose adhesion holds beyond the touch, and their limits.

Its error is that of the steps of a cycle; averaging of first order leaves out (f_n/f)^2 of the velocity, with the
resonance f_n of the bounce.
"""

from dataclasses import replace
from functools import lru_cache
from typing import Any

import contact
from studies.model.balls import slider_of
from studies.model.scene_errors import slider_keys
from studies.model.wave_to_contact import Contact
from studies.record.point import Point
from studies.record.status import Status
from studies.scene.slider_keys import Slider
from studies.solve.point_answer import PointAnswer
from studies.solve.refinement import SHARE
from studies.solve.velocity_error import held_height_error, judged, velocity_sensitivities


@lru_cache(16)  # of a sweep's points many have the same
def adhesive_balls(slider: Slider) -> Any:
    """Return the `contact.AdhesiveBalls` of a slider, one of ``slider.share`` equal parts."""
    block: Any = slider.adhesion
    separation = {} if block.separation is None else {"separation": block.separation}
    with slider_keys():
        own = replace(slider_of(slider), adhesion=None)
        return contact.AdhesiveBalls(own, work=block.work, model=block.model, **separation)


def adhesive_answer(driven: Contact, level: float, tolerance: float) -> PointAnswer:
    """Return the steady velocity at a level, and the power that closing and opening take."""
    if driven.scene.burst is not None:
        block: Any = driven.scene.slider.adhesion
        model = block.model
        rule = f'must be "DMT", "meniscus" or "JKR" with a burst: the answers of "{model}" are steady velocities'
        driven.scene.refuse("slider.adhesion.model", rule)
    orbits, goal, balls = driven.at(level), SHARE * tolerance, adhesive_balls(driven.scene.slider)
    if level == 0.0:
        point = Point(velocity_m_per_s=0.0, regime="stick", adhesion_power_W=0.0) | judged(tolerance, 0.0, 0.0)
        return PointAnswer(point=point, from_stator=0.0, from_contact=0.0)
    with slider_keys():
        state = balls.motion(orbits, tolerance=goal)
    velocity, speed = state.velocity.value, contact.reference_speed(state.velocity.value, orbits)

    def nearby(some):
        return balls.motion(some, tolerance=goal).velocity.value

    by_amplitude, by_orbit = velocity_sensitivities(velocity, orbits, driven.stator_error, nearby)
    from_stator = driven.stator_error * by_orbit
    from_contact = state.velocity.error / speed + held_height_error(balls.slider, orbits)
    point = Point(
        velocity_m_per_s=velocity, regime=state.regime, adhesion_power_W=state.lost_power * driven.scene.slider.share,
        amplitude_sensitivity=float(by_amplitude) if driven.stator_error > 0 else None,
    )  # fmt: skip
    point |= judged(
        tolerance, from_stator, from_contact, "" if state.velocity.status == Status.OK else state.velocity.why
    )
    return PointAnswer(point=point, from_stator=from_stator, from_contact=from_contact)


def adhesive_limits(driven: Contact) -> tuple[float, float]:
    """Return the factors on the orbits at which the slider starts to move and its first ball leaves the surface."""
    balls = adhesive_balls(driven.scene.slider)
    scale = 1e-9 / max(abs(each.normal) for each in driven.orbits)
    orbits = driven.at(scale)
    return scale * balls.threshold(orbits), scale * balls.release(orbits)
