"""Whether a light slider that starts from rest comes to the motion in the plane that repeats, which shooting finds.

A slider whose contacts resonate near or above the frequency of the waves has several steady motions, which differ in
how it bounces; which of them it takes depends on the start. From its height at rest it is followed event by event until
the mean velocity of two stretches of cycles agrees. It begins with the velocity of the motion that repeats: friction
hardly acts on the bounce, and to come to that velocity takes far longer.
"""

import math

import numpy as np

from contact.plane.disc_contacts import Total
from contact.plane.full_motion import FullMotion, followed_from_rest
from contact.plane.plane_equations import Body
from contact.plane.plane_waves import SurfaceWaves
from contact.slider import Slider

HOW = (4, 1e-2)  # nodes and tolerance of a segment: velocities to less than 1e-3 (`bursts.EXACT`)
STRETCH = 40  # least number of cycles whose mean velocity is taken
MOST = 1500  # cycles after which a motion that has not settled is left
SETTLED = 1e-4  # change of the mean from one stretch to the next, over the reference speed, at which it is taken
SAME = 1e-3  # of the reference speed: two means that differ by less belong to the same motion


def mean_from_rest(
    slider: Slider, waves: SurfaceWaves, rates: np.ndarray, period: float, reference: float, arm: float
) -> tuple[np.ndarray, float, float]:  # fmt: skip
    """Return the mean rates that a slider from its height at rest settles to, and how much the last ones differ.

    Parameters
    ----------
    rates : (3,) array
        (v_x, v_y, yaw rate) at the start, m/s and rad/s; 0 for what is not free.
    period : float
        After which the waves repeat, s.
    reference : float
        Speed to which errors refer, m/s.
    arm : float
        By which a yaw rate becomes a speed, m.

    Returns
    -------
    means : (3,) array
        As `rates`, those of the last stretch of whole periods.
    change : float
        Speed by which they differ from those of the stretch before, m/s.
    turn : float
        Angle by which the slider turns in a stretch, rad, while the waves under its contacts stay: relative
        differences of this size say nothing.

    Raises
    ------
    ConvergenceError
        If a segment of the motion is not solved.
    """

    def follow(motion):
        motion.state.p[1:] = rates / np.array([motion.units.speed, motion.units.speed, motion.units.omega])
        return _followed(motion, period, reference, arm)

    return followed_from_rest(follow, slider, waves, HOW, rise=0.0, stop=math.inf)


def _followed(motion, period, reference, arm):
    cycle = period * motion.units.omega
    periods = math.ceil(STRETCH * 2.0 * math.pi / cycle)
    before, change = np.full(3, np.inf), np.inf
    rates, turn = before, 0.0
    for _ in range(max(2, math.ceil(MOST * 2.0 * math.pi / (periods * cycle)))):
        motion, way = followed_in_place(motion, periods * cycle)
        rates, turn = way / (periods * period), abs(float(way[2]))
        change = speed_of(rates - before, arm)
        if change <= SETTLED * reference:
            break
        before = rates
    return rates, change, turn


def followed_in_place(motion: FullMotion, length: float) -> tuple[FullMotion, np.ndarray]:
    """Return the motion after a length of phase, turned back to its yaw, and its way in it (3,), m and rad.

    The waves under each contact are those of the start, and so is the yaw: turned contacts would meet others.
    """
    before = motion.place
    motion.follow(length + motion.state.total[Total.PHASE])
    way = (motion.place - before) * [motion.units.length, motion.units.length, 1.0]
    motion = motion.restarted()
    turn, motion.state.q[Body.YAW] = motion.state.q[Body.YAW], 0.0
    motion.from_place[Body.YAW] -= turn
    return motion, way


def speed_of(rates: np.ndarray, arm: float) -> float:
    """Return the size of rates (v_x, v_y, yaw rate), m/s."""
    return float(np.linalg.norm(rates * [1.0, 1.0, arm]))
