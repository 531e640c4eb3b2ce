r"""Derivative of the averaged steady velocity along a change of slider and wave, by the implicit function theorem.

Height h and velocity v satisfy F_1 = <sum P> - preload = 0 and F_2 = <sum Q> - R_t v - load = 0 (first-order
averaging). Along a family of motors s -> (slider, orbits)

    d(h, v)/ds = -(dF/d(h, v))^-1 dF/ds,

where every derivative of F is taken at a fixed height and velocity: no equilibrium is solved again. F comes from the
event-driven solver (`equilibrium.traction`), the derivatives from central differences of fourth order. Against the full
periodic motion the derivative errs by O((f_n/f)^2), as the averaged velocity does.
"""

import math
from collections.abc import Callable

import numpy as np

from contact.convergence import ConvergenceError
from contact.drive import towards_plus
from contact.orbit import Orbit, as_orbits
from contact.slider import Slider

STEP = 2e-3  # relative, of h and v; in s: forces are known to 1e-11


def velocity_derivative(
    family: Callable[[float], tuple[Slider, Orbit | tuple[Orbit, ...]]], *, step: float = STEP
) -> float:
    """Return dv/ds at s = 0 of the averaged steady velocity, m/s; 0 where the slider is held.

    Parameters
    ----------
    family : callable
        s to (slider, orbits); s = 0 is the motor itself.
    step : float
        Of s, for the differences at fixed height and velocity.

    Raises
    ------
    ConvergenceError
        If the equilibrium is not regular: at the threshold, or where averaging does not apply.

    Examples
    --------
    >>> from dataclasses import replace
    >>> slider = Slider(radius=1e-3, mass=8.9e-5, preload=8.7e-4, load=0.0, friction_coefficient=0.08,
    ...                 effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False,
    ...                 stick_band=0.0, contact_damping=0.0, normal_damping=0.5, tangential_damping=1e-4)
    >>> orbit = Orbit(frequency=2.2e6, normal=1e-8, tangential=-7e-9j)
    >>> slope = velocity_derivative(lambda s: (replace(slider, friction_coefficient=0.08 * (1 + s)), orbit))
    >>> round(slope, 4)  # more friction, a little less velocity
    -0.0071
    """
    from contact.solve.equilibrium import balanced

    slider, orbits = family(0.0)
    side, driven = towards_plus(as_orbits(orbits))
    found = balanced(slider, driven)
    if found.held:
        return 0.0
    base = np.array([found.height * found.problem.length, found.speed * found.problem.speed])
    sign = found.load_sign

    def force(s, h, v):
        changed, orbits = family(s)
        listed = as_orbits(orbits)
        return _forces(
            changed, listed if side > 0 else tuple(orbit.mirrored() for orbit in listed), h, v, sign
        )

    by_state = np.column_stack([
        _slope(lambda x: force(0.0, base[0] + x, base[1]), STEP * max(abs(base[0]), 0.1 * found.problem.length)),
        _slope(lambda x: force(0.0, base[0], base[1] + x), STEP * abs(base[1])),
    ])  # fmt: skip
    by_s = _slope(lambda x: force(x, *base), step)
    if not abs(np.linalg.det(by_state)) > 0.0:
        raise ConvergenceError(
            "not applicable", "the equilibrium is not regular: the slider is at its threshold"
        )
    return -side * float(np.linalg.solve(by_state, by_s)[1])


def _forces(slider, orbits, height, velocity, sign) -> np.ndarray:
    """Return F_1 and F_2 in N at a height in m and a velocity in m/s."""
    from contact.problem import scaled
    from contact.solve.energy import SUPPORT
    from contact.solve.equilibrium import traction, trough
    from contact.solve.event_driven import TALLY

    problem = scaled(slider, orbits, direction=sign, start=trough(orbits))
    mean, motion = traction(
        problem, height / problem.length, velocity / problem.speed, 0.0, np.zeros(TALLY, np.int64)
    )
    unit = slider.mass * problem.omega**2 * problem.length
    support = float(motion.sums[SUPPORT]) / (2.0 * math.pi) * unit - slider.preload
    return np.array([support, mean * unit - slider.tangential_damping * velocity - sign * slider.load])


def _slope(function, step) -> np.ndarray:
    """Return the derivative at 0, of fourth order."""
    one, two = (function(k * step) - function(-k * step) for k in (1, 2))
    return (8.0 * one - two) / (12.0 * step)
