r"""Velocity of a heavy slider on balls with adhesion that hold on beyond z = 0, of first order.

A ball of Johnson, Kendall and Roberts (`law.adhesion`) closes at z = 0 and opens where dz/da = 0, at a negative
approach. A heavy slider prescribes z = h + u_z. Closed, the contact has the radius a(z) and with it the elastic,
repulsive part K delta^(3/2) of its force, delta = a^2/R, from which its slip limit c delta and its friction follow:

    Q = mu K (delta^(3/2) - (delta - |x|/c)^(3/2)) sign x,      |x| <= c delta                                  (1)

(`law.elastic`, with delta in the place of z). It closes without deformation; what its spring holds when it opens is
lost, and so is the work of the normal force around both branches, `AdhesiveSphere.loss`, in every hop. The mean
approach h follows from <P> = F; where a height without hops exists, a slider from rest keeps it. v follows from
<Q> = load + R_t v. Equal steps of theta, phi = phi_1 + (phi_2 - phi_1)(1 - cos theta)/2 between closing and opening,
take out the square root with which a(z) ends; the error is that against half as many steps.
"""

import math
from dataclasses import dataclass

import numpy as np

from contact import parameter_check
from contact.choice import Answer
from contact.error_estimate import reference_speed
from contact.exceptions import InputError
from contact.law.adhesion import AdhesiveSphere
from contact.orbit import Orbit
from contact.roots import bracketed
from contact.slider import Slider

STEPS = 512  # of a cycle, of the first answer
DOUBLINGS = 4  # at most
CLOSE = 1e-12  # of heights and velocities over their range
REPEATS = 1e-12  # change of a deformation from one cycle to the next over the largest, at which it repeats
CYCLES = 400  # at most until it repeats


@dataclass(frozen=True)
class AdhesiveMotion:
    """Steady motion of a heavy slider on adhesive balls.

    Attributes
    ----------
    velocity : Answer
        m/s, with the error of the steps.
    height : float
        Mean approach h, m.
    hops : bool
        Whether the balls leave the surface in every cycle.
    lost_power : float
        Power lost by closing and opening, W: of the normal force around both branches; 0 without hops.
    """

    velocity: Answer
    height: float
    hops: bool
    lost_power: float


@dataclass(frozen=True)
class _Cycle:
    """One cycle of a contact: phases of the nodes while it is closed, the weights of a mean, the radii."""

    phases: np.ndarray
    weights: np.ndarray
    radii: np.ndarray
    hops: bool


def _cycle(ball, h, size, steps):
    """Return the cycle at a mean approach, of z = h + size cos(phase); None where the contact never closes."""
    if h + size <= 0.0:
        return None
    lowest = ball.break_approach
    hops = h - size < lowest
    if hops:
        start, stop = -math.acos(-h / size), math.acos((lowest - h) / size)
        theta = np.linspace(0.0, math.pi, steps + 1)
        phases = start + 0.5 * (stop - start) * (1.0 - np.cos(theta))
        weights = 0.5 * (stop - start) * np.sin(theta) * (math.pi / steps) / (2.0 * math.pi)
    else:
        phases, weights = 2.0 * math.pi * np.arange(steps) / steps, np.full(steps, 1.0 / steps)
    z = np.maximum(h + size * np.cos(phases), lowest)
    return _Cycle(phases, weights, ball.radii_at(z), hops)


def _mean_pull(cycle, ball, c, travel):
    """Return the mean of Q/mu in N; `travel` is that of the surface past the slider, at the nodes and a cycle later."""
    delta = cycle.radii**2 / ball.radius
    limit, moved = c * delta, np.diff(travel)
    stiffness = 4.0 / 3.0 * ball.modulus * math.sqrt(ball.radius)
    x, forces = 0.0, np.zeros(delta.size)
    for _ in range(1 if cycle.hops else CYCLES):
        begin = x
        for k in range(delta.size):
            x += 0.0 if k == 0 and cycle.hops else moved[k - 1]
            x = min(max(x, -limit[k]), limit[k])
            forces[k] = math.copysign(delta[k] ** 1.5 - max(delta[k] - abs(x) / c, 0.0) ** 1.5, x)
        if abs(x - begin) <= REPEATS * limit.max():
            break
    return stiffness * float(cycle.weights @ forces)


def adhesive_motion(
    slider: Slider, orbit: Orbit, *, work: float, model: str = "JKR", tolerance: float = 1e-5
) -> AdhesiveMotion:
    """Return the steady motion of a heavy slider on equal balls with adhesion.

    Parameters
    ----------
    slider : Slider
        Radius, moduli, friction coefficient, preload, load and tangential damping of one ball are used. The load
        opposes the motion of the unloaded slider.
    orbit : Orbit
        Of the surface under the balls.
    work : float
        Work of adhesion w, J/m^2, positive.
    model : str
        "JKR" or "DMT".
    tolerance : float
        Of the velocity, relative to it or to omega |u_x|/10 where that is larger.

    Examples
    --------
    >>> ball = Slider(radius=1e-3, mass=0.089e-3, preload=0.87309e-3, load=0.0, friction_coefficient=0.08,
    ...     effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0,
    ...     contact_damping=0.0, normal_damping=0.5, tangential_damping=0.0)
    >>> motion = adhesive_motion(ball, Orbit(frequency=2.2e6, normal=10e-9, tangential=-6.7e-9j), work=0.05)
    >>> print(f"{motion.hops}, {1e6 * motion.lost_power:.2f} uW lost in hops")
    True, 0.66 uW lost in hops
    """
    parameter_check.positive("tolerance", tolerance, "")
    slider.refuse_other_laws(", on balls with adhesion")
    if slider.shape != "sphere" or slider.radius is None or slider.count > 1 or slider.normal_law is not None:
        raise InputError("slider", "must be one smooth ball with a radius, on balls with adhesion")
    parameter_check.positive("slider.preload", slider.preload, "N")
    parameter_check.positive("slider.friction_coefficient", slider.friction_coefficient, "")
    ball = AdhesiveSphere(radius=slider.radius, modulus=slider.effective_modulus, work=work, model=model)
    size, omega = abs(orbit.normal), orbit.omega
    parameter_check.positive("orbit.normal", size, "m")
    turned = orbit.tangential * abs(orbit.normal) / orbit.normal  # counted from the crest of u_z
    reference = reference_speed(0.0, (orbit,))
    values: list[float] = []
    error = math.inf
    for doubling in range(DOUBLINGS + 1):
        steps = STEPS * 2**doubling
        height, cycle = _riding(ball, slider.preload, size, steps)
        values.append(_velocity(slider, ball, cycle, turned, omega, size))
        if doubling:
            error = abs(values[-1] - values[-2])
            if error <= tolerance * max(abs(values[-1]), reference):
                break
    answer = Answer(value=values[-1], error=error, reasons=(f"cycle means of first order, model {model}",))
    lost = ball.loss * orbit.frequency if cycle.hops else 0.0
    judged = answer.judged(tolerance, max(abs(values[-1]), reference) or 1.0)
    return AdhesiveMotion(judged, height, cycle.hops, lost)


def _riding(ball, preload, size, steps):
    """Return the mean approach at which the mean force is the preload, and its cycle."""

    def left(h):
        cycle = _cycle(ball, h, size, steps)
        return -preload if cycle is None else float(cycle.weights @ ball.force(cycle.radii)) - preload

    closed = ball.break_approach + size * (1.0 + 1e-12)
    if left(closed) <= 0.0:
        high = closed + float(ball.approach(ball.radius_under(preload))) - ball.break_approach + size
        low = closed
    else:
        low, high = -size, ball.break_approach + size * (1.0 - 1e-12)
    height = bracketed(left, low, high, tolerance=CLOSE * (abs(high) + size))
    return height, _cycle(ball, height, size, steps)


def _velocity(slider, ball, cycle, tangential, omega, size):
    """Return the velocity at which no mean force is left."""
    c, mu = slider.limit_slope, slider.friction_coefficient
    again = [] if cycle.hops else [cycle.phases[0] + 2.0 * math.pi]
    phases = np.append(cycle.phases, again)
    u_x = (tangential * np.exp(1j * phases)).real
    deepest = float(cycle.radii.max()) ** 2 / ball.radius
    top = omega * (abs(tangential) + c * (size + deepest))
    load = 0.0

    def left(v):
        pull = _mean_pull(cycle, ball, c, u_x - v * phases / omega)
        return mu * pull - load - slider.tangential_damping * v

    drive = left(0.0)
    way, load = math.copysign(1.0, drive), math.copysign(slider.load, drive)
    if abs(drive) - slider.load <= 1e-9 * mu * slider.preload:
        return 0.0
    return bracketed(left, 0.0, way * top, tolerance=CLOSE * top)
