"""A scene's source: power instead of voltage, its impedance and a matching network, recovery, and where power goes."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest

from studies import Scene, run
from studies.model.resolve import resolved
from studies.record.text import answer
from studies.refusal import SceneError
from studies.report.contents import contents
from studies.scene import read_table
from studies.scene.drive import Element
from studies.scene.toml import document
from studies.sweeps import sweep

LADDER = [{"series_L": "2.6 uH", "Q": 80}, {"shunt_C": "1 nF"}, {"series_R": 3}]


def motor(**drive) -> Scene:
    """Three pairs on a short lossy block, behind 50 ohm; two pairs loaded with 50 ohm receive."""
    table = read_table("twente")
    table["stator"] |= {"length": "16 mm", "thickness": "1.5 mm"}
    for transducer, center, pairs in zip(table["transducer"], ("4 mm", "13 mm"), (3, 2), strict=True):
        transducer |= {"center": center, "finger_pairs": pairs, "period": "0.98 mm"}
    table["transducer"][1]["termination"] = "50 ohm"
    table["slider"] |= {"position": "8.5 mm"}
    del table["drive"]["voltage"]
    table["drive"] |= {"source_impedance": "50 ohm"} | drive
    return Scene.from_table("", table)


def test_a_power_is_that_of_the_conjugate_matched_load():
    """V^2 / (8 R) for each source; the resolved scene and the one written say the same."""
    scene = motor(power=["1 W", "4 W"])
    assert scene.levels == pytest.approx((20.0, 40.0), rel=1e-15)
    assert resolved(scene).drive.voltage == scene.levels
    assert resolved(scene).drive.power is None
    assert Scene.from_table("", tomllib.loads(document(scene.to_table()))) == scene
    both = motor(power="1 W", sources={"left": 1, "right": "1 at 90 deg"}, source_impedance=[50, 20])
    assert both.levels == pytest.approx((200**0.5,), rel=1e-15)


def test_a_ladder_is_read_and_written():
    scene = motor(voltage="10 V", match=LADDER)
    assert scene.drive.match == (Element(series_L=2.6e-6, Q=80.0), Element(shunt_C=1e-9), Element(series_R=3.0))
    assert Scene.from_table("", tomllib.loads(document(scene.to_table()))) == scene


def test_a_check_states_the_available_power():
    """50 V behind 50 ohm: 2500 / (8 * 50) = 6.25 W."""
    assert dict(contents(resolved(motor(power=["1 W", "4 W"]))))["power"][0].startswith("1 W to 4 W,")
    assert dict(contents(resolved(motor(voltage="50 V"))))["power"][0].startswith("6.25 W,")
    assert "power" not in dict(contents(resolved(motor(voltage="50 V", source_impedance="0 ohm"))))


@pytest.mark.parametrize("match", ["none", "auto", LADDER])
def test_the_power_of_the_source_adds_up(match):
    """Source, network, solid, load and radiation are computed from different matrices."""
    record = run(motor(power="1 W", match=match).replace(slider=None), tolerance=3e-2)
    each = {key.removesuffix("_W_per_V2"): value for key, value in record.electrical.items()}
    available, delivered = each["power_available"], each["power"]
    assert available == pytest.approx(1 / 400, rel=1e-14)
    parts = ("solid", "loads", "radiated_left", "radiated_right")
    assert sum(each[f"power_{name}"] for name in parts) == pytest.approx(delivered, rel=1e-9)
    assert all(each[f"power_{name}"] > 0 for name in parts)
    # what goes through the source's voltage: the current is that of the whole circuit behind it
    given = each["power_source"] + each["power_network"] + delivered
    assert given <= 4 * available
    assert (each["power_network"] > 0) == (match == LADDER)
    if match == "auto":
        assert delivered >= 0.9999 * available
        assert [element.Q for element in record.scene.drive.match] == [None, None]
    assert record.points[0]["available_power_W"] == pytest.approx(1.0, rel=1e-14)
    assert record.points[0]["voltage_V"] == pytest.approx(20.0, rel=1e-14)


def test_a_matched_motor_is_the_motor_at_its_electrodes_voltage():
    """In three dimensions: motion, reported voltage and powers are of one circuit, which the power ledger closes."""
    matched = run(motor(power="1 W", match="auto"), tolerance=1e-2)
    assert matched.surface_motion.beam is not None
    each = matched.electrical
    section = matched.surface_wave.circuit.admittance
    assert abs(each["admittance_S"] / section - 1) > 1e-5  # a passive transducer receives a beam, not the plane wave
    parts = ("solid", "loads", "radiated_left", "radiated_right")
    ledger = sum(each[f"power_{name}_W_per_V2"] for name in parts)
    assert ledger == pytest.approx(each["power_W_per_V2"], rel=1e-9)
    assert each["power_W_per_V2"] >= 0.9999 * each["power_available_W_per_V2"]
    volts = 20.0 * abs(each["comb_voltage_per_volt"])
    bare = run(motor(voltage=volts, source_impedance=0), tolerance=1e-2)
    one, other = (record.points[0]["velocity_m_per_s"] for record in (matched, bare))
    assert one == pytest.approx(other, rel=1e-6)
    assert abs(one) > 1e-3


def test_a_sweep_over_power_is_the_runs():
    scene = motor(power="1 W", match=LADDER).replace(slider=None)
    found = sweep(scene, {"drive.power": [1.0, 4.0]}, tolerance=3e-2).columns()
    amplitudes = found["normal_amplitude_m"]
    assert amplitudes[1] == pytest.approx(2 * amplitudes[0], rel=1e-12)
    record = run(scene, tolerance=3e-2)
    assert amplitudes[0] == pytest.approx(record.points[0]["normal_amplitude_m"], rel=3e-2)
    assert np.all(np.array(found["power_W"]) > 0)


def test_the_answer_and_the_picture_show_the_power():
    from matplotlib.figure import Figure

    from studies.record.run_pictures import velocity
    from studies.record.text import answer

    record = run(motor(power=["1 W", "4 W"], match="auto"), tolerance=0.1)
    text = answer(record)
    assert "available (W)" in text
    first = record.scene.drive.match[0].name
    assert f"match           {first} " in text
    assert "delivered 100 %" in text
    ax = Figure().add_subplot()
    velocity(record, ax)
    ax.figure.canvas.draw()
    (upper,) = ax.child_axes
    assert upper.get_xlabel() == "available power (W)"


def recovering(**recovery) -> Scene:
    """The same without slider; what arrives at its second transducer is recovered."""
    table = motor(voltage="10 V").to_table()
    del table["slider"], table["transducer"][1]["termination"]
    table["drive"]["recovery"] = {"receiver": "right"} | recovery
    return Scene.from_table("", table)


@pytest.fixture(scope="module")
def recovered():
    return run(recovering(circulation=True), tolerance=3e-2)


def test_the_recovered_power_adds_up(recovered):
    each = {key.removesuffix("_W_per_V2"): value for key, value in recovered.electrical.items()}
    parts = ("power_solid", "power_loads", "power_radiated_left", "power_radiated_right")
    assert sum(each[name] for name in parts) == pytest.approx(each["power"], rel=1e-9)
    assert each["power_recovered"] == pytest.approx(each["power_loads"], rel=1e-9)
    assert each["power_net"] + each["power_recovered"] == pytest.approx(each["power"], rel=1e-12)
    assert 0 < each["recovery_ratio"] < 1
    text = answer(recovered)
    assert f"recovered       {100 * each['recovery_ratio']:.3g} % of the power" in text
    assert f"the source gives 1/{each['power'] / each['power_net']:.4g} of the power into the transducers" in text
    assert any("combiner is ideal" in line for line in recovered.left_out)


def test_a_matched_receiver_takes_more_than_others(recovered):
    load = complex(recovered.scene.drive.recovery.load)
    assert recovered.scene.transducer[1].termination == load
    for factor in (1.2, 0.8):
        other = run(recovering(load=[load.real * factor, load.imag]), tolerance=3e-2)
        assert other.electrical["power_recovered_W_per_V2"] < recovered.electrical["power_recovered_W_per_V2"]
    again = Scene.from_table("", tomllib.loads(document(recovered.scene.to_table())))
    assert resolved(again) == recovered.scene


def test_the_gain_is_that_of_a_ring_with_a_coupler(recovered):
    """Waves round a directional coupler that passes sqrt(gain) and the loop: nothing is dumped."""
    gain = recovered.electrical["recovery_ratio"]
    t = np.sqrt(gain)
    coupler = np.array([[t, 1j * np.sqrt(1 - gain)], [1j * np.sqrt(1 - gain), t]])  # (loop, source) -> (loop, dump)
    loop = 0.0
    for _ in range(400):
        loop, dumped = coupler @ [np.sqrt(gain) * loop, 1.0]
    assert abs(dumped) < 1e-9
    ratio = recovered.electrical["power_W_per_V2"] / recovered.electrical["power_net_W_per_V2"]
    assert abs(loop) ** 2 == pytest.approx(ratio, rel=1e-9)


def test_circulation_changes_the_source_not_the_motion(recovered):
    still = run(recovering(), tolerance=3e-2)
    assert "power_net_W_per_V2" not in still.electrical
    assert still.points[0] == recovered.points[0]


def test_the_efficiency_is_that_of_the_power_from_the_source():
    """With circulation the source supplies 1 - gain of what the transducers take; the slider gets the same."""
    efficiencies = {}
    for circulation in (False, True):
        table = motor(voltage="40 V").to_table()
        table["stator"]["diffraction"] = False
        del table["transducer"][1]["termination"]
        table["drive"]["recovery"] = {"receiver": "right", "efficiency": 0.9, "circulation": circulation}
        scene = Scene.from_table("", table)
        found = sweep(scene, {"slider.load": "0:1e-5 N:2"}, also=("efficiency",), tolerance=3e-2).columns()
        efficiencies[circulation] = found["motor_efficiency"][0]
        assert 0 < found["motor_efficiency"][0] < found["contact_efficiency"][0]
    gain = run(replace(scene, slider=None), tolerance=3e-2).electrical["recovery_ratio"]
    assert gain > 0.05
    # the run's place of least error, and with it its discretisation, is another: 1e-4 of the gain
    assert efficiencies[True] == pytest.approx(efficiencies[False] / (1 - gain), rel=1e-3)


def test_a_loop_of_gain_one_is_refused(recovered):
    limit = 1 / recovered.electrical["recovery_ratio"]
    with pytest.raises(SceneError, match=rf"efficiency must be below {limit:.4g} .*oscillates from 1 on"):
        run(recovering(circulation=True, efficiency=1.001 * limit), tolerance=3e-2)


def test_a_rectifier_is_its_resistance():
    scene = resolved(recovering(rectifier="100 ohm"))
    assert scene.transducer[1].termination == pytest.approx(800 / np.pi**2, rel=1e-14)
    assert scene.drive.recovery.rectifier == 100.0
    assert resolved(scene) == scene
