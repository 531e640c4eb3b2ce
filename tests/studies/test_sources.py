"""Several sources: how they are written, superposition, symmetry and the direction of the slider."""

import tomllib

import numpy as np
import pytest

from studies import run, sweep
from studies.scene import Scene, read_table
from studies.scene.toml import document


def motor(**drive):
    """Two equal transducers of two pairs on a short free block, the slider in its middle."""
    table = read_table("twente")
    table["stator"] |= {"length": "16 mm", "thickness": "1.5 mm", "ends": "free"}
    for transducer, center in zip(table["transducer"], ("3 mm", "13 mm"), strict=True):
        transducer |= {"center": center, "finger_pairs": 2, "period": "0.987 mm"}
    table["drive"] |= {"voltage": ["60 V"]} | drive
    table["slider"] |= {"position": "8 mm"}
    return Scene.from_table("", table)


@pytest.mark.parametrize(
    ("value", "amplitude"),
    [
        (2, 2.0),
        (-0.5, -0.5),
        ("0.5 at 90 deg", 0.5j),
        ("1 at 180 deg", -1.0),
        ("2 at -90deg", -2j),
        ("1 at 0.5 rad", np.exp(0.5j)),
        ("0.3 at 30 deg", 0.3 * np.exp(1j * np.pi / 6)),
        ([0.25, -1.5], 0.25 - 1.5j),
    ],
)
def test_an_amplitude_is_a_number_a_phasor_or_a_pair(value, amplitude):
    scene = motor(sources={"left": 1, "right": value})
    assert scene.drive.driven["right"] == pytest.approx(amplitude, rel=1e-15)
    assert Scene.from_table("", tomllib.loads(document(scene.to_table()))) == scene


def test_sources_count_where_a_transducer_is_named_too():
    scene = motor(transducer="left", sources={"left": 0, "right": 2})
    assert scene.drive.transducer == "right"
    assert motor(transducer="left").drive.driven == {"left": 1.0}


def wave(**sources):
    return run(motor(sources=sources).replace(slider=None), tolerance=0.05).surface_wave


def test_two_sources_at_once_are_the_sum_of_two_runs():
    """On one discretisation (the same tolerance); each run leaves the other transducer with a source of 0."""
    both = wave(left=1.0, right="0.5 at 90 deg")
    left, right = wave(left=1, right=0), wave(left=0, right=1)
    x = np.linspace(0.05, 0.95, 41) * both.length
    assert both.resolution == left.resolution == right.resolution
    summed = left.motion(x) + 0.5j * right.motion(x)
    assert abs(both.motion(x) - summed).max() < 1e-12 * abs(summed).max()
    taken = both.circuit.currents - (left.circuit.currents + 0.5j * right.circuit.currents)
    assert abs(taken).max() < 1e-12 * abs(both.circuit.currents).max()


def test_equal_sources_leave_a_slider_in_the_middle_at_rest():
    """The motion under it is a straight line; the fingers' order makes the right one's mirror image its opposite."""
    for sign in (1, -1):
        record = run(motor(sources={"left": 1, "right": sign}), tolerance=1e-2)
        normal, tangential = (abs(record.wave[key]) for key in ("normal_m_per_V", "tangential_m_per_V"))
        assert min(normal, tangential) < 1e-9 * max(normal, tangential)
        assert record.points[0]["velocity_m_per_s"] == 0


def test_the_slider_turns_round_with_the_stronger_source():
    """Exchanging both amplitudes mirrors the motor: the opposite velocity."""
    found = [run(motor(sources={"left": left, "right": right}), tolerance=1e-2) for left, right in ((1, 0.3), (0.3, 1))]
    one, other = (record.points[0]["velocity_m_per_s"] for record in found)
    assert one < 0
    assert other == pytest.approx(-one, rel=1e-6)
    ports = found[0].electrical["sources"]
    assert list(ports) == ["left", "right"]
    assert ports["right"]["voltage_per_volt"] == pytest.approx(0.3, rel=1e-14)
    power = sum(0.5 * (each["voltage_per_volt"] * np.conj(each["current_A_per_V"])).real for each in ports.values())
    assert found[0].electrical["power_W_per_V2"] == pytest.approx(power, rel=1e-12)


def test_the_power_of_a_sweep_is_that_of_all_sources():
    scene = motor(sources={"left": 1, "right": "0.5 at 90 deg"}).replace(slider=None)
    (power,) = sweep(scene, {}, tolerance=0.05).columns()["power_W"]
    electrical = run(scene, tolerance=0.05).electrical
    first, second = electrical["sources"].values()
    by_hand = 0.5 * sum(
        (each["voltage_per_volt"] * each["current_A_per_V"].conjugate()).real for each in (first, second)
    )
    assert power == pytest.approx(by_hand * 60.0**2, rel=1e-9)
