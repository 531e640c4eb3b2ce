"""The steady velocity and yaw rate of a slider in the plane alone, for fits, which ask for thousands of them.

A run adds errors, drift and stability, which cost eight further states and more (`plane_answer`). A fit compares with
measured values: it takes averaged states wherever their error allows the tolerance `PLANE_TOLERANCE`, and the full
motion, 30 times the time, elsewhere.
"""

import math
from typing import NamedTuple

import contact
from contact import plane
from studies.model.wave_to_contact import Contact
from studies.solve.plane_motor import PlaneMotor

# Tolerance of the velocity at least. With 1e-3 `twente-planar` would need the full motion (1.4 s a state, averaged 0.05
# s), from which its averaged velocities differ by 1e-4 to 4e-4
PLANE_TOLERANCE = 1e-2


class PlaneRates(NamedTuple):
    """Steady motion; NaN where there is none."""

    velocity: float  # m/s along x
    lateral_velocity: float  # m/s along y
    yaw_rate: float  # rad/s
    state: plane.PlaneState | None = None  # from which a search for a neighbour may begin


def plane_rates(driven: Contact, level: float, tolerance: float, near: PlaneRates | None = None) -> PlaneRates:
    """Return the steady motion at one level; ``near``: that of a motor that differs little."""
    if level == 0.0:
        return PlaneRates(0.0, 0.0, 0.0)
    starts = (None,) if near is None or near.state is None else (near.state, None)
    for start in starts:
        try:
            state = PlaneMotor.of(driven, level, max(tolerance, PLANE_TOLERANCE)).state(near=start)
        except contact.ConvergenceError:
            continue  # a start that is too far away may fail where the search's own does not
        along, across = (float(each) for each in state.velocity)
        return PlaneRates(along, across, float(state.yaw_rate), state)
    return PlaneRates(math.nan, math.nan, math.nan)
