r"""Derivative of the averaged steady velocity with respect to a parameter, by the implicit function theorem.

A family of motors s -> (slider, orbits) depends on a parameter s. The velocity v of first-order averaging satisfies

    F(s, v) = <sum Q>(s, v) - R_t v - load = 0,

where <sum Q> is taken at the height that balances the preload. Hence

    dv/ds = -(dF/ds)/(dF/dv).

Both partial derivatives are central differences of fourth order, so that no equilibrium is solved again. The error with
respect to the full periodic motion is O((f_n/f)^2), as for the averaged velocity.
"""

from collections.abc import Callable

from contact.answers.load_and_stall import mean_traction
from contact.averaged.steady_sweep import mean_motion
from contact.exceptions import ConvergenceError
from contact.passing_wave import Surface, crest_direction
from contact.slider import Slider

# Of v (relative) and of s, for differences of fourth order of forces that are accurate to 1e-11. The longer the step,
# the more contacts begin to stick within it. With 2e-3, 50 pillars are 0.2 % off, 50 balls in two of six draws 0.1 and
# 0.3 % (`tests/contact/test_derivatives.py`), and a ball near its threshold loses all digits; with 2e-4 or a quarter of
# it none of 24 draws is more than 2e-6 off.
STEP = 2e-4


def velocity_derivative(family: Callable[[float], tuple[Slider, Surface]], *, step: float = STEP) -> float:
    """Return dv/ds at s = 0 of the averaged steady velocity, m/s; 0 where the slider is held.

    Parameters
    ----------
    family : callable
        Takes s and returns (slider, orbits); s = 0 gives the motor itself.
    step : float
        Step of s for the differences at fixed velocity.

    Raises
    ------
    ConvergenceError
        If the slider is at its threshold, where dF/dv vanishes, or if averaging does not apply.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from contact import Orbit
    >>> slider = Slider(radius=1e-3, mass=8.9e-5, preload=8.7e-4, load=0.0, friction_coefficient=0.08,
    ...                 effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False,
    ...                 stick_band=0.0, contact_damping=0.0, normal_damping=0.5, tangential_damping=1e-4)
    >>> orbit = Orbit(frequency=2.2e6, normal=1e-8, tangential=-7e-9j)
    >>> slope = velocity_derivative(lambda s: (replace(slider, friction_coefficient=0.08 * (1 + s)), orbit))
    >>> round(slope, 4)  # more friction, a little less velocity
    -0.0071
    """
    slider, orbits = family(0.0)
    mean = mean_motion(slider, orbits)
    if mean.held:
        return 0.0
    v, load_sign = mean.first_order, mean.load_sign * crest_direction(orbits)

    def residual(s, velocity):
        """Return F(s, v), the mean tangential force less damper and load."""
        slider, orbits = family(s)
        drag = slider.tangential_damping * velocity + load_sign * slider.load
        return float(mean_traction(slider, orbits, [velocity])[0]) - drag

    by_velocity = _slope(lambda x: residual(0.0, v + x), STEP * abs(v))
    if by_velocity == 0.0:
        raise ConvergenceError("not applicable", "the equilibrium is not regular: the slider is at its threshold")
    return float(-_slope(lambda s: residual(s, v), step) / by_velocity)


def _slope(function, step) -> float:
    """Return the derivative at 0 by a central difference of fourth order."""
    one, two = (function(k * step) - function(-k * step) for k in (1, 2))
    return (8.0 * one - two) / (12.0 * step)
