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
    record = published_motors.run(motors=published_motors.MOTORS[5:-2])
    data = record.panels[0].data
    confirmed = dict(zip(data["quantity"], [finding.confirmed for finding in record.findings], strict=True))
    # no texture moves the face by 10 nm along the wave: contradicted, and said so
    assert [quantity for quantity, found in confirmed.items() if not found] == ["tangential motion of the face"]


def test_the_motion_of_the_face_is_that_of_independent_programs():
    """9.61 MHz, 20 nm, 15 N: about 3.6 nm with a scatter of 10 nm and 9.7 nm with 80 nm."""
    even, rough = (
        published_sliders.face_normal({"friction": 0.18, "scatter": scatter, "number": 1e4})
        for scatter in (10e-9, 80e-9)
    )
    assert even == pytest.approx(3.6e-9, rel=0.07)
    assert rough == pytest.approx(9.7e-9, rel=0.01)
    # of a pillar that never leaves the surface: k_n u_z over the stiffness of silicon under its foot
    E, nu = 162e9, 0.22
    assert rough < 1.8e6 * 20e-9 * (1 - nu**2) / (2 * 10e-6 * E)


def test_the_texture_is_fitted_to_the_motion_of_the_face():
    case = {"face": 9.75e-9, "friction": 0.18, "number": 1e4, "preload": 30.0, "amplitude": 40e-9}
    scatter = published_sliders.fitted_scatter(9.75e-9, 0.18, 1e4)
    assert 60e-9 < scatter < 120e-9
    assert published_sliders.face_normal(case | {"scatter": scatter}) == pytest.approx(9.75e-9, rel=1e-3)
    assert 0.1 < published_sliders.textured_speed(case) < published_sliders.crest_speed(40e-9, 10e6)
    assert 0.1 < published_sliders.textured_stall(case) < 0.18 * 30.0
