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


@pytest.mark.parametrize(("count", "seed"), [(50, 2), (50, 3), (1, 0)])
def test_contacts_that_are_about_to_stick_within_a_longer_step(count, seed):
    """Fifty balls of which some begin to stick within 0.2 % of the velocity, and one ball near its threshold."""
    rng = np.random.default_rng([count, seed])
    preload = rng.uniform(0.2e-3, 3e-3) * count
    heights = rng.normal(scale=1e-9, size=count)
    body = replace(
        SLIDER, mass=1e-3 * count, preload=preload, load=0.015 * preload, friction_coefficient=0.15, heights=heights,
        radius=1e-3, effective_modulus=64e9, tangential_modulus=12e9, normal_damping=2.0 * count,
        tangential_damping=1e-4 * count,
    )  # fmt: skip
    sizes, turns = rng.uniform(1.5e-9, 8e-9, count), np.exp(2j * np.pi * rng.random(count))
    ratios = rng.uniform(0.6, 1.4, count)
    orbits = tuple(
        Orbit(frequency=2.2e6, normal=u_z, tangential=-0.7j * u_z * r)
        for u_z, r in zip(sizes * turns, ratios, strict=True)
    )

    def family(s):
        return replace(body, friction_coefficient=0.15 * (1.0 + s)), orbits

    ends = [float(mean_motion(*family(s)).first_order) for s in (-1e-5, 1e-5)]
    assert abs(ends[0]) > 1e-3
    assert velocity_derivative(family) == pytest.approx((ends[1] - ends[0]) / 2e-5, rel=1e-5)
