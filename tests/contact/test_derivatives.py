"""The implicit derivative against Richardson extrapolation of the solved velocity, on generic numbers."""

from dataclasses import replace

import numpy as np
import pytest

from contact import Orbit, Slider, mean_motion, velocity_derivative

SLIDER = Slider(
    radius=0.83e-3, mass=0.11e-3, preload=1.3e-3, load=2e-5, friction_coefficient=0.11, effective_modulus=71e9,
    tangential_modulus=15e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0,
    normal_damping=0.4, tangential_damping=1.7e-4,
)  # fmt: skip


def richardson(function, step=1e-2):
    """Return the derivative at 0 of sixth order."""
    one, two, four = ((function(step / k) - function(-step / k)) / (2.0 * step / k) for k in (1, 2, 4))
    return (64.0 * four - 20.0 * two + one) / 45.0


@pytest.mark.parametrize("phase", [1j, -1j])
@pytest.mark.parametrize(
    "key", ["friction_coefficient", "preload", "tangential_modulus", "tangential_damping", "load", "radius"]
)
def test_it_is_the_slope_of_the_first_order_velocity(key, phase):
    orbit = Orbit(frequency=2.4e6, normal=6e-9, tangential=4.4e-9 * phase * np.exp(0.1j))

    def family(s):
        return replace(SLIDER, **{key: getattr(SLIDER, key) * np.exp(s)}), orbit

    expected = richardson(lambda s: mean_motion(*family(s)).first_order)
    assert velocity_derivative(family) == pytest.approx(expected, rel=1e-6)


def test_contacts_at_different_places_and_a_turned_phase():
    """The relative phase of both displacements changes, under two balls that do not move alike."""

    def family(s):
        turn = np.exp(1j * s)
        one = Orbit(frequency=2.4e6, normal=6e-9, tangential=-4.4e-9j * turn)
        return SLIDER, (one, one.scaled(0.9 * np.exp(1.3j)))

    expected = richardson(lambda s: mean_motion(*family(s)).first_order)
    assert velocity_derivative(family) == pytest.approx(expected, rel=1e-6)


def test_a_slider_that_is_held_does_not_answer():
    orbit = Orbit(frequency=2.4e6, normal=1e-10, tangential=-0.7e-10j)
    assert velocity_derivative(lambda s: (SLIDER, orbit)) == 0.0
