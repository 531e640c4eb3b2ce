"""The published silicon sliders in the model: closed forms, and that the bands hold what independent programs found."""

import math

import pytest

from studies.papers import published_motors, published_sliders


def test_the_crest_and_the_power_are_closed_forms():
    assert published_sliders.crest_speed(4.7e-9, 9.6e6) == pytest.approx(0.2526, rel=3e-3)
    # |U|^2 omega w/(4 Gamma), Gamma of the half-space
    assert published_sliders.wave_power(9e-3) == pytest.approx(
        (40e-9) ** 2 * 2 * math.pi * 10e6 * 9e-3 / 4 / 2.5078e-12, rel=4e-3
    )


def test_the_wave_fades_under_a_long_slider():
    # Independent programs: 80 % after 5 mm at half the stall
    short, long = published_sliders.rear_amplitude(5e-3), published_sliders.rear_amplitude(10e-3)
    assert short == pytest.approx(0.80, abs=0.02)
    assert 0.4 < long < 0.7 * 1.0


def test_the_mass_decides_about_a_step():
    light, heavy = (published_sliders.shigematsu_step(mass, cycles=25, amplitude=20e-9) for mass in (1e-3, 20e-3))
    assert heavy < 2e-9 < light
    # at constant traction the way goes as 1/m, the slide after it too
    assert light / heavy == pytest.approx(20.0, rel=1e-6)


def test_the_devices_have_their_rows():
    record = published_motors.run(motors=published_motors.MOTORS[5:])
    assert [finding.confirmed for finding in record.findings] == [True] * 5
