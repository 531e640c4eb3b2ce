"""A slider at rest under a wave that has not begun: contacts at different phases keep what the load deformed.

Truths of the rising wave: an event-driven Runge-Kutta integrator that shares no code with this package (1e-11).
"""

from dataclasses import replace

import numpy as np
import pytest

from contact import Envelope, Orbit, Slider, burst, step

F = 2.2e6
MU, PRELOAD = 0.17804397013372858, 0.0006682530715003658
PATHS = tuple(
    Orbit(frequency=F, normal=15e-9 * np.exp(1j * p), tangential=-0.7j * 15e-9 * np.exp(1j * p))
    for p in (0.0, -1.2, 2.5)
)
TIME = np.linspace(0, 400 / F, 60)


def body(load=0.8, **changed):
    return Slider(**{
        "radius": 1e-3, "mass": 7.2408898410268165e-06, "preload": PRELOAD, "load": load * MU * PRELOAD,
        "friction_coefficient": MU, "effective_modulus": 64e9, "tangential_modulus": 12e9, "law": "elastic",
        "reciprocal": False, "stick_band": 0.0, "contact_damping": 0.0, "normal_damping": 0.1549776107617017,
        "tangential_damping": 1e-4,
    } | changed)  # fmt: skip


def envelope(amplitude):
    return Envelope(time=TIME, amplitude=amplitude, phase=0 * TIME)


@pytest.mark.parametrize("changed", [{}, {"shape": "punch", "radius": 2e-6}, {"heights": (0.0, 4e-10, -3e-10)}])
def test_a_wave_of_amplitude_zero_moves_nothing(changed):
    none = envelope(0 * TIME)
    run = burst(body(**changed), PATHS, duration=50 / F, after=0.0, tolerance=1e-6, samples=50, envelope=none)
    assert abs(run.velocity).max() < 1e-15
    assert abs(step(body(**changed), PATHS, cycles=50, envelope=none).displacement) < 1e-20


def test_a_rising_wave_moves_a_loaded_slider_as_an_independent_integrator_says():
    rise = envelope(1 - np.exp(-TIME / (400 / F)))
    fine, run = (
        burst(body(), PATHS, duration=400 / F, after=0.0, tolerance=tolerance, samples=400, envelope=rise)
        for tolerance in (1e-8, 1e-6)
    )
    # `contact_motion` and `contact_stop` with the envelope at every instant; 2.8348782e-4 with one linear in each cycle
    assert fine.velocity_at_burst_end == pytest.approx(2.8348714e-4, rel=1e-6)
    assert run.velocity_at_burst_end == pytest.approx(2.8348714e-4, abs=run.answer.error)
    assert step(body(), PATHS, cycles=400, envelope=rise).during == pytest.approx(1.755e-9, rel=1e-3)


@pytest.mark.parametrize("phase", [-0.9, -1.2])
def test_a_contact_that_starts_at_its_slip_limit_and_sticks_is_followed_in_fixed_steps(phase):
    # at the start the surface falls under the second contact, whose deformation by the load is cut to its slip limit
    heavy = body(mass=2e-5, preload=4e-3, friction_coefficient=0.2, load=0.0, normal_damping=0.3)
    heavy = replace(heavy, load=4e-4)
    paths = tuple(PATHS[0].scaled(7.5 / 15.0 * np.exp(1j * each)) for each in (0.0, phase))
    exact, stepped = (
        burst(heavy, paths, duration=20 / F, after=0.0, tolerance=tolerance, samples=2, method=method)
        for tolerance, method in ((1e-8, "exact"), (1e-2, "stepped"))
    )
    assert stepped.method == "stepped"
    assert stepped.velocity_at_burst_end == pytest.approx(
        exact.velocity_at_burst_end, abs=1e-5 * abs(paths[0].tangential) * paths[0].omega / 10
    )
