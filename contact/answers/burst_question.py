"""What a method of a burst is asked: slider, orbits, length, tolerance, and which instants it returns and compares."""

import math
from typing import NamedTuple

import numpy as np

from contact.averaged.burst import COMPARED
from contact.codes import At, Recorded
from contact.envelope import Envelope
from contact.error_estimate import reference_speed
from contact.orbit import Orbits
from contact.problem import Problem
from contact.slider import Slider
from contact.stepping.along_track import Scaled


class Burst(NamedTuple):
    """A burst from rest that returns a sample every `stride` cycles."""

    slider: Slider
    orbits: Orbits
    problem: Problem
    cycles: int
    stride: int
    tolerance: float
    envelope: Envelope | None
    track: Scaled | None = None  # None: the slider remains where it is

    @property
    def duration(self) -> float:
        """Length of the burst, s."""
        return 2.0 * math.pi * self.cycles / self.problem.omega

    @property
    def cycles_per_compared_sample(self) -> int:
        """Number of cycles between two compared samples, a divisor of `stride`."""
        return largest_divisor(self.stride, max(1, self.cycles // (2 * COMPARED)))

    @property
    def compared_per_returned_sample(self) -> int:
        """Number of compared samples for each returned one."""
        return self.stride // self.cycles_per_compared_sample

    def allowed(self, velocity: float) -> float:
        """Return the allowed error of a velocity, both scaled."""
        return self.tolerance * self.reference(velocity)

    def reference(self, velocity: float = 0.0) -> float:
        """Return the reference speed for a velocity, both scaled."""
        return reference_speed(velocity * self.problem.speed, self.orbits) / self.problem.speed


def compared_velocities(record, state):
    """Return the velocities in the second half of a burst and at its end."""
    return np.append(record[len(record) // 2 :, Recorded.VELOCITY], state[At.VELOCITY])


def largest_divisor(number, most):
    """Return the largest divisor of a number that is at most `most`."""
    return next(d for d in range(min(number, most), 0, -1) if number % d == 0)
