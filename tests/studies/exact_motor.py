"""A motor followed event by event through every cycle of the wave, with the interface of the averaged motor's state.

The reference for `studies.motor.position_loop`.  The wave is at full size from the first cycle of a drive and gone
after its last, as that of a given [wave]: a motor whose wave grows is refused (`contact.step` follows its bursts, in
fixed steps).  Without a wave the motion goes on in segments as long as the contact's resonance allows.  30 to 130 us of
computing per cycle.
"""

import numpy as np

from contact.answers.methods import rest, rest_problem, silence
from contact.drive import towards_plus
from contact.events.energy import Sum
from studies.export.averaged_motor import AveragedMotor

NODES, TRUNCATION = 12, 1e-10
STILL = 1e-12  # m, of the wave whose scaled problem serves for a surface at rest


class ExactMotor:
    """State of a motor on its wave; ``advance`` moves it on by whole cycles, what is left over is owed."""

    def __init__(self, motor: AveragedMotor):
        if any(drive.response is not None for drive in motor.drives):
            raise ValueError("the exact motor takes a wave that is at full size at once")
        self.motor, self.time, self.position = motor, 0.0, 0.0
        self.slider, self.omega = motor.slider, motor.drives[0].orbits[0].omega
        self.contacts = len(motor.drives[0].orbits)
        depth = self.slider.rest_approach(self.contacts)
        # SI, in the axes of the stator: z_s, z_s', v, deformations
        self.state = np.array([-depth, 0.0, 0.0, *self.slider.rest_deformations(self.contacts)])
        self.owed, self.driven_cycles = 0.0, 0

    @property
    def velocity(self) -> float:
        """Of the slider along +x, m/s."""
        return float(self.state[2])

    @property
    def deformation(self) -> float:
        """Mean of the contacts, m."""
        return float(np.mean(self.state[3:]))

    def advance(
        self, duration: float, level: float, *, force: float = 0.0, preload: float | None = None
    ) -> None:
        """Move on by a duration in s; without external forces, the preload that of the scene."""
        if force or preload is not None:
            raise ValueError("the exact motor takes no external force and the scene's preload")
        left, cycle = self.owed + duration, 2.0 * np.pi / self.omega
        if level == 0.0:
            if left > 0.0:
                self._still(left)
                left = 0.0
        else:
            count = max(0, round(left / cycle))
            if count:
                self._cycles(int(level < 0.0), abs(level), count)
            left -= count * cycle
        self.owed = left

    def _motion(self, drive: int, level: float):
        """Return the event-driven motion at phase 0 where the state stands, the direction and the scaled problem."""
        orbits = tuple(each.scaled(level) for each in self.motor.drives[drive].orbits)
        side, driven = towards_plus(orbits)
        problem = rest_problem(self.slider, driven)
        motion = rest(self.slider, driven, problem, nodes=NODES, truncation=TRUNCATION)
        length, speed = problem.length, problem.speed
        z, climb, v, *x = self.state
        motion.place(z / length, climb / speed, side * v / speed, side * np.array(x) / length)
        return motion, side, problem

    def _keep(self, motion, side, problem) -> None:
        z, climb, v = motion.state[:3]
        length, speed = problem.length, problem.speed
        self.state = np.array(
            [z * length, climb * speed, side * v * speed, *(side * motion.state[3:] * length)]
        )

    def _cycles(self, drive: int, level: float, count: int) -> None:
        motion, side, problem = self._motion(drive, level)
        motion.begin()
        motion.turn(count)
        self.position += side * float(motion.sums[Sum.DISPLACEMENT]) * problem.length
        self._keep(motion, side, problem)
        self.time += count * 2.0 * np.pi / self.omega
        self.driven_cycles += count

    def _still(self, duration: float) -> None:
        motion, side, problem = self._motion(0, STILL / self.motor.drives[0].amplitude)
        quiet = silence(motion)
        quiet.move(0.0, duration * problem.omega, np.empty(0))
        self.position += side * float(quiet.sums[Sum.DISPLACEMENT]) * problem.length
        self._keep(quiet, side, problem)
        self.time += duration
