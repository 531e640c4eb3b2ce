"""Punches and heights through a scene: the run answers as the contact package does, and what cannot be is refused."""

import pytest

import contact
from studies import Scene, run, sweep
from studies.model.wave_to_contact import contact_slider

THREE = {"contacts": ["-5 mm", "0 mm", "5 mm"]}


def test_a_run_on_punches_is_that_of_the_contact_package():
    scene = Scene.load("twente-contact").replace(
        slider={"shape": "punch", "radius": "2 um"}, wave={"normal_amplitude": "5 nm"}
    )
    point = run(scene).points[0]
    block, wave = scene.slider, scene.wave
    slider = contact.Slider(
        radius=2e-6, mass=block.mass, preload=block.preload_force, load=0.0, law="elastic", reciprocal=False,
        friction_coefficient=block.friction_coefficient, effective_modulus=block.effective_modulus,
        tangential_modulus=block.tangential_modulus, stick_band=0.0, contact_damping=0.0,
        normal_damping=block.damping.normal, tangential_damping=block.damping.tangential, shape="punch",
    )  # fmt: skip
    orbit = contact.Orbit(frequency=wave.frequency, normal=5e-9, tangential=-5e-9j * wave.tangential_ratio)
    expected = contact.steady(slider, orbit, tolerance=1e-6).velocity
    assert abs(point["velocity_m_per_s"]) == pytest.approx(abs(expected), rel=1e-6)
    assert abs(expected) > 1e-3


@pytest.mark.parametrize("part", [1e-3, 1e-5])
def test_a_level_just_beside_the_threshold_is_on_its_side(part):
    """A part below it the slider rests with that margin; a part above it moves, and the sweep says the same."""
    scene = Scene.load("twente-contact")
    threshold = run(scene).summary["threshold_amplitude_m"]
    levels = [threshold * (1 - part), threshold * (1 + part)]
    below, above = run(scene.replace(wave={"normal_amplitude": levels})).points
    assert (below["velocity_m_per_s"], below["regime"]) == (0.0, "stick")
    assert (above["velocity_m_per_s"] > 0.0, above["regime"]) == (True, "slip")
    for point, sign in ((below, 1), (above, -1)):
        assert point["stick_margin"] == pytest.approx(sign * part, rel=2 * part, abs=0)
    rows = sweep(scene, {"wave.normal_amplitude": levels}).columns()
    assert [velocity > 0.0 for velocity in rows["velocity_m_per_s"]] == [False, True]


def test_a_contact_that_hangs_in_the_air_changes_nothing(small):
    motor = small.replace(drive={"voltage": "120 V"})
    three = run(motor.replace(slider={"contacts": ["-1 mm", "0 mm", "1 mm"], "heights": ["0 nm", "-1 um", "1 nm"]}))
    two = run(motor.replace(slider={"contacts": ["-1 mm", "1 mm"], "heights": ["0 nm", "1 nm"]}))
    velocity = two.points[0]["velocity_m_per_s"]
    assert three.points[0]["velocity_m_per_s"] == pytest.approx(velocity, rel=1e-6)
    assert abs(velocity) > 1e-3


def test_heights_go_to_the_contacts_in_their_order():
    scene = Scene.load("twente").replace(slider=THREE | {"heights": ["0 nm", "-3 nm", "2 nm"], "preload": "1 mN"})
    assert contact_slider(scene.slider).heights == (0.0, -3e-9, 2e-9)
