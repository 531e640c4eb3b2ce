r"""Velocity of a heavy slider on rough balls: each asperity of a sample slips on its own, of first order.

The force of asperity j is a function P_j(z) of the ball's approach, in which all of them take part (`Asperities`). By
Ciavarella's and Jaeger's theorem it carries, where the ball's surface has moved by x_j along the wave since it touched,

    Q_j = mu (P_j(z) - P_j(z - |x_j|/c)) sign x_j,    |x_j| <= c (z - z_j),    c = mu E/(4 G),

z_j the approach at which it touches first, and x_j follows the surface in stick, dx_j/dphi = (u_x' - v)/omega. One stop
for the ball as a whole (`law.elastic` with the sum of the forces) forgets which asperities have slipped. Of many fine
asperities the row of stops becomes the hysteretic law. The mean approach h follows from <sum P_j> = F, and v from
<sum Q_j> = load + R_t v. The cycle is followed in equal steps of phase, and the error is that of two numbers of steps.
"""

import math

import numpy as np

from contact import parameter_check
from contact.choice import Answer
from contact.error_estimate import reference_speed, richardson
from contact.exceptions import ConvergenceError
from contact.law.rough import Asperities
from contact.orbit import Orbit
from contact.roots import bracketed
from contact.slider import Slider

APPROACHES = 64  # of the ball, at which the forces are solved
STEPS = 192  # of phase, of the coarser cycle
CYCLES = 24  # at most, until the deformations repeat
REPEATS = 1e-9  # change of the deformations from one cycle to the next over the largest, at which they repeat
CLOSE = 1e-7  # of the velocity over its range


class _Ball:
    """Forces of the asperities as functions of the ball's approach.

    Parameters
    ----------
    z : ndarray, shape (k,)
        Rising approaches of the ball.
    approaches : ndarray, shape (k, n)
        Of the asperities.
    stiffness : float
        (4/3) E sqrt(beta).
    """

    def __init__(self, z: np.ndarray, approaches: np.ndarray, stiffness: float):
        from scipy.interpolate import CubicSpline  # of the rough contact alone

        self.z, self.stiffness, self.spline = z, stiffness, CubicSpline(z, approaches)
        # the approaches at which they touch first: those below are linear in z up to there
        touching = np.maximum((approaches > 0.0).argmax(axis=0), 1)
        column = np.arange(approaches.shape[1])
        low, high = approaches[touching - 1, column], approaches[touching, column]
        share = np.clip(-low / np.where(high > low, high - low, 1.0), 0.0, 1.0)
        self.touch = z[touching - 1] + share * (z[touching] - z[touching - 1])

    def forces(self, z: np.ndarray) -> np.ndarray:
        """Return P_j at approaches of shape (steps, 1), or of each asperity, (steps, n)."""
        z = np.broadcast_to(z, (len(z), self.touch.size))
        cell = np.clip(np.searchsorted(self.z, z, side="right") - 1, 0, self.z.size - 2)
        column = np.arange(self.touch.size)
        above, u = z - self.z[cell], 0.0
        for power in range(4):
            u = u * above + self.spline.c[power, cell, column]
        return np.where(z > self.touch, self.stiffness * np.maximum(u, 0.0) ** 1.5, 0.0)


def asperity_motion(
    slider: Slider, sample: Asperities, orbit: Orbit, *, tolerance: float = 1e-3, load: float = 0.0
) -> Answer:
    """Return the steady velocity of a heavy slider on one rough ball.

    Parameters
    ----------
    slider : Slider
        Radius, moduli, friction coefficient, preload and tangential damping are used; elastic law.
    sample : Asperities
        Of the ball.
    orbit : Orbit
        Motion of the surface.
    tolerance : float
        Of the velocity over max(|v|, omega |u_x|/10), positive.
    load : float
        Force along -x, N.

    Returns
    -------
    Answer
        Velocity in m/s with its error; averaging of first order is not part of the error.

    Raises
    ------
    ConvergenceError
        With status "runaway" if friction does not balance the load.
    """
    parameter_check.positive("tolerance", tolerance, "")
    ball = _ball(slider, sample, orbit)
    height = _riding(ball, slider.preload, orbit)
    values: list[float] = []
    error = math.inf
    for doublings in range(6):
        values.append(_velocity(ball, slider, orbit, height, load, STEPS * 2**doublings))
        if len(values) > 1:
            error = richardson(abs(values[-1] - values[-2]), 2.0, 1)
            if error <= tolerance * reference_speed(values[-1], (orbit,)):
                break
    reasons = (f"cycle means of {sample.x.size} asperities, a stop each",)
    answer = Answer(value=values[-1], error=error, reasons=reasons)
    return answer.judged(tolerance, reference_speed(values[-1], (orbit,)) or 1.0)


def _ball(slider, sample, orbit) -> _Ball:
    """Return the asperities that can touch, from below the first contact to the deepest crest."""
    radius, modulus, rest = slider.radius, slider.effective_modulus, slider.rest_approach(1)
    free = sample.heights - (sample.x**2 + sample.y**2) / (2.0 * radius)
    lowest, wave = -float(free.max()), 2.0 * abs(orbit.normal)
    deepest = lowest + wave + rest
    while float(sample.forces(radius, modulus, deepest - wave).sum()) < slider.preload:
        deepest += 0.5 * rest
    z = lowest + (deepest - lowest) * np.linspace(0.0, 1.0, APPROACHES)
    near = free + deepest > 0.0
    approaches = np.array([sample.approaches(radius, modulus, each)[near] for each in z])
    return _Ball(z, approaches, sample.stiffness(modulus))


def _wave(orbit, steps):
    """Return u_x and u_z at equal phases of a cycle, m."""
    turn = np.exp(2j * np.pi * np.arange(steps) / steps)
    return (orbit.tangential * turn).real, (orbit.normal * turn).real


def _riding(ball: _Ball, preload: float, orbit) -> float:
    """Return the mean approach at which the mean force over the cycle is the preload."""
    _, u_z = _wave(orbit, 2 * STEPS)
    size = abs(orbit.normal)

    def left(height):
        return float(np.mean(ball.forces((height + u_z)[:, None]).sum(axis=1))) - preload

    return bracketed(left, ball.z[0] - size, ball.z[-1] - size, tolerance=1e-9 * (ball.z[-1] - ball.z[0]))


def _velocity(ball: _Ball, slider, orbit, height: float, load: float, steps: int) -> float:
    """Return the velocity at which no mean force is left, with so many steps of phase."""
    u_x, u_z = _wave(orbit, steps)
    z, c, friction = (height + u_z)[:, None], slider.limit_slope, slider.friction_coefficient
    limits, forces = c * np.maximum(z - ball.touch, 0.0), ball.forces(z)
    top = orbit.omega * (abs(orbit.tangential) + c * abs(orbit.normal))

    def left(v):
        """Return the force that is left at a velocity."""
        moved = np.diff(u_x, append=u_x[0]) - v * 2.0 * np.pi / (steps * orbit.omega)
        x, history = np.zeros(ball.touch.size), np.empty_like(limits)
        for _ in range(CYCLES):
            before = x
            for k in range(steps):
                history[k] = x = np.minimum(np.maximum(x, -limits[k]), limits[k])
                x = x + moved[k]
            if np.max(np.abs(x - before)) <= REPEATS * np.max(np.abs(history), initial=1e-300):
                break
        pull = np.sign(history) * (forces - ball.forces(z - np.abs(history) / c))
        return friction * float(np.mean(pull.sum(axis=1))) - load - slider.tangential_damping * v

    at_rest = left(0.0)
    if abs(at_rest) <= 1e-9 * friction * slider.preload:
        return 0.0
    way = math.copysign(1.0, at_rest)
    if left(way * top) * way > 0.0:
        raise ConvergenceError("runaway", "friction of the asperities cannot balance the load")
    return bracketed(left, 0.0, way * top, tolerance=CLOSE * top)
