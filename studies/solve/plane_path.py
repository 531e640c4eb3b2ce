"""The legs of a path in the plane: bursts one after the other, and the coast after the last one."""

import math
from dataclasses import dataclass

import numpy as np

from contact import plane


@dataclass(frozen=True, kw_only=True)
class Leg:
    """The motion in one burst, or in the coast after it, with its start."""

    name: str
    time: np.ndarray  # (k,) s
    pose: np.ndarray  # (k, 3): x, y and yaw, m and rad
    rates: np.ndarray  # (k, 3)
    error: float  # of the place at its end, m
    yaw_error: float  # of the yaw there, rad

    @property
    def end(self) -> tuple[np.ndarray, np.ndarray]:
        """Pose and rates at its end."""
        return self.pose[-1], self.rates[-1]


def legs_of(name: str, motion: plane.PlaneTrajectory, start: tuple | None = None, begin: float = 0.0) -> list[Leg]:
    """Return the burst of a motion, and the coast to the stop where it was followed so far.

    ``start``: pose and rates at its beginning, absent at rest; ``begin``: time of it, s.
    """
    first = np.zeros((2, 3)) if start is None else np.array(start)
    time_at, error = np.append(0.0, motion.time) + begin, float(np.hypot(*motion.pose_error[:2]))
    yaw_error = float(motion.pose_error[2])
    pose, rates = np.vstack([first[:1], motion.pose]), np.vstack([first[1:], motion.rates])
    end = motion.burst_end + 2
    parts = [(name, slice(0, end))]
    if motion.stopped < math.inf and end < len(time_at) + 1:
        parts.append(("coast", slice(end - 1, None)))
    errors = {"error": error, "yaw_error": yaw_error}
    return [Leg(name=each, time=time_at[k], pose=pose[k], rates=rates[k], **errors) for each, k in parts]
