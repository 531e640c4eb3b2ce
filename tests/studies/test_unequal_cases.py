"""Cases in which a wrong factor, side, unit or label shows: several balls, unequal ends, split fingers, other sizes.

Each of these tests has seen the error that it names, planted in the program.
"""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from studies import Scene, run
from studies.record.plots import new_figure
from studies.record.run_pictures import velocity
from studies.remarks.model_error import model_error
from studies.remarks.run_warnings import breakdown_voltage, warnings_of
from studies.solve.ring_up import RingUp
from studies.solve.surface_blocks import wave_block
from studies.solve.surface_motion import SurfaceMotion
from studies.view import movie
from studies.view.field_quantities import QUANTITIES, shade_of
from tests.studies.test_warnings import record


@pytest.fixture(scope="module")
def plane():
    """The seed's left transducer in the plane section, at 30 V."""
    chosen = Scene.load("twente-left").replace(drive={"voltage": ["30 V"]}, stator={"diffraction": False})
    return run(chosen, tolerance=0.05)


def test_three_balls_load_the_wave_threefold(plane):
    def load(found):
        rows = {each["effect"]: each["size"] for each in model_error(found)}
        return rows["load of the slider on the wave"], rows["radiation of a contact into the stator"]

    slider = plane.scene.slider
    several = replace(slider, contacts=(-0.004, 0.0, 0.005), preload=3 * slider.preload, mass=3 * slider.mass)
    one, three = load(plane), load(replace(plane, scene=replace(plane.scene, slider=several)))
    # The jumps of the balls, each at its own phase, add up.  Both sizes belong to the ball that the wave moves most:
    # here by 3 % more than the centre.
    assert three[0] == pytest.approx(3 * one[0], rel=0.04)
    assert three[1] == pytest.approx(one[1], rel=1e-12)


def test_power_beyond_each_transducer_is_that_of_the_wave_there():
    """The left transducer has three times the voltage of the right one, and they are 125 mm apart."""
    drive = {"transducer": None, "sources": {"left": 1, "right": 0.3}, "voltage": ["30 V"]}
    found = run(Scene.load("twente").replace(drive=drive, stator={"diffraction": False}), tolerance=0.05)
    wave, electrical = found.surface_wave, found.electrical
    left, right = (abs(wave.rayleigh_motion(x)[1]) for x in (9e-3, 151e-3))
    ratio = electrical["power_radiated_left_W_per_V2"] / electrical["power_radiated_right_W_per_V2"]
    assert left > 1.3 * right
    assert ratio == pytest.approx((left / right) ** 2, rel=0.1)  # the plate's other modes carry the rest


@pytest.mark.parametrize(("settings", "gaps"), [((), 2), (("transducer.0.split=true",), 4)])
def test_breakdown_counts_the_gaps_of_a_period(settings, gaps):
    """Fingers of half the width have gaps of half the width; period 0.987356 mm, metallisation 0.5."""
    high = record("twente", *settings, 'drive.voltage="3 kV"')
    gap = 0.5 * 0.987356e-3 / gaps
    said = next(each for each in warnings_of(high) if "breakdown voltage" in each)
    assert f"fingers {gap * 1e6:.3g} um apart" in said
    assert f"{breakdown_voltage(gap):.3g} V (Paschen's law)" in said


def test_breakdown_of_a_second_source_that_is_the_larger():
    one = record("twente", 'drive.voltage="400 V"')
    assert not any("Paschen" in each for each in warnings_of(one))
    circuit = one.surface_motion.circuit
    circuit.names, circuit.voltages = ("left", "right"), np.array([1.0, 4 + 3j])
    circuit.currents = np.zeros(2, complex)
    assert any(each.startswith("2e+03 V between fingers") for each in warnings_of(one))


def test_the_error_of_the_wave_is_that_of_the_worst_ball(plane):
    """Centre known to 1e-4, balls to 3e-4 and 7e-3."""
    slider = replace(plane.scene.slider, contacts=(-0.004, 0.005))
    scene = replace(plane.scene, slider=slider)
    (x, y), sizes = slider.center, (1e-4, 3e-4, 7e-3)
    places = [(x, y), *slider.contact_positions]
    known = {place: (np.array([1e-10j, 0, 1e-10]), size) for place, size in zip(places, sizes, strict=True)}
    motion = SurfaceMotion(wave=plane.surface_wave)
    motion.evaluated.update(known)
    assert wave_block(scene, motion, None)["relative_error"] == 7e-3
    assert motion.relative_error(places[:2]) == 3e-4


def test_error_of_a_ring_up_is_its_share_of_the_burst():
    """Error 0.02 of an envelope that settles in 30 us: all of it in a burst of 20 us, a quarter in one of 120 us."""
    time = np.linspace(0.0, 2e-4, 9)

    def error(duration):
        found = SimpleNamespace(
            normal=np.ones(9, complex), steady_normal=1.0, time=time, duration=duration, relative_error=0.02,
            settling=3e-5,
        )  # fmt: skip
        return RingUp.of(found).error

    assert error(2e-5) == pytest.approx(0.02, rel=1e-12)
    assert error(1.2e-4) == pytest.approx(0.005, rel=1e-12)


@pytest.mark.parametrize(("rate", "duration"), [(12.5, 80), (4.0, 250)])
def test_pictures_of_a_gif_last_as_long_as_the_rate_says(tmp_path, rate, duration):
    def image(number):
        return np.full((8, 10, 3), 40 * number, np.uint8)

    movie.save(image, 4, tmp_path / "a.gif", rate=rate)
    with Image.open(tmp_path / "a.gif") as found:
        assert found.n_frames == 4
        assert found.info["duration"] == duration


def test_colour_scale_of_energies():
    """2e-3 J/m^3 per V^2 are 2 mJ/m^3; strain energy has no negative values, power flow has."""
    energy = shade_of(QUANTITIES["strain_energy"], np.array([1e-3, 2e-3]), free=False)
    assert energy.label == "strain energy (mJ/m^3 per V^2)"
    assert energy.limits == (0.0, pytest.approx(2.0))
    power = shade_of(QUANTITIES["power_flow"], np.array([5.0, 30.0]), free=False)
    assert power.label == "power flow along x (W/m^2 per V^2)"
    assert power.limits == (pytest.approx(-30.0), pytest.approx(30.0))
    per_nm = shade_of(QUANTITIES["strain_energy"], np.array([3e18]), free=True)
    assert (per_nm.label, per_nm.scale_end) == ("strain energy (J/m^3 per nm^2)", pytest.approx(3.0))


def test_points_of_the_velocity_stand_under_their_own_label():
    chosen = Scene.load("twente-contact").replace(wave={"normal_amplitude": ["0.5 nm", "2 nm", "10 nm"]})
    found = run(chosen)
    _, ax = new_figure(5, 4)
    velocity(found, ax)
    for line in ax.lines:
        which = [point for point in found.points if point["regime"] == line.get_label()]
        if which:
            x, y = line.get_data()
            assert list(x) == pytest.approx([point["normal_amplitude_m"] * 1e9 for point in which])
            assert list(y) == pytest.approx([point["velocity_m_per_s"] * 1e3 for point in which])
    assert {point["regime"] for point in found.points} == {"stick", "slip", "intermittent"}
    assert ax.get_xlabel() == "normal amplitude (nm)"
    assert ax.get_ylabel() == "slider velocity (mm/s)"


def test_a_tolerance_of_the_power_is_half_of_one_of_the_voltage():
    """P = V^2 / (8 R): 4 % of power are 2 % of voltage, to first order."""
    matched = {"source_impedance": 50.0}

    def bands(level, size):
        drive = {"voltage": None} | matched | level
        found = run(
            Scene.load("twente-left").replace(drive=drive, stator={"diffraction": False}, uncertain=size),
            tolerance=0.05,
        )
        (point,) = found.points
        return point["velocity_low_m_per_s"], point["velocity_high_m_per_s"]

    power = 100.0**2 / 8 / 50.0
    by_power = bands({"power": [power]}, {"drive": {"power": "+- 4 %"}})
    by_voltage = bands({"voltage": ["100 V"]}, {"drive": {"voltage": "+- 2 %"}})
    width = by_voltage[1] - by_voltage[0]
    assert width > 0
    assert by_power == pytest.approx(by_voltage, abs=0.03 * width)
    assert not math.isclose(by_power[0], by_power[1])
