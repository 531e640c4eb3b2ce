"""A scene's source: power instead of voltage, its impedance and a matching network, and where the power goes."""

import tomllib

import numpy as np
import pytest

from studies import Scene, run
from studies.refusal import SceneError
from studies.scene import read_table
from studies.scene.resolved import resolved
from studies.scene.toml import document
from studies.sweep import sweep

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
    assert scene.drive.match == (
        (("series_L", 2.6e-6), ("Q", 80.0)),
        (("shunt_C", 1e-9),),
        (("series_R", 3.0),),
    )
    assert Scene.from_table("", tomllib.loads(document(scene.to_table()))) == scene


@pytest.mark.parametrize(
    ("drive", "words"),
    [
        ({"power": "1 W", "voltage": "5 V"}, r"drive\.voltage must be absent with drive\.power"),
        ({"power": "1 W", "source_impedance": 0}, r"drive\.power needs a drive\.source_impedance"),
        ({"power": "1 V"}, r"drive\.power.*a power"),
        ({}, r"drive\.voltage is required"),
        ({"voltage": 1, "match": "best"}, r"drive\.match must be \"none\", \"auto\" or a ladder"),
        ({"voltage": 1, "match": "auto", "source_impedance": [0, 9]}, r"drive\.match needs .* for \"auto\""),
        ({"voltage": 1, "match": [{"series_M": 1}]}, r"drive\.match\.0\.series_M is no element.*series_L"),
        ({"voltage": 1, "match": [{"series_L": "1 nF"}]}, r"drive\.match\.0\.series_L.*an inductance"),
        ({"voltage": 1, "match": [{"series_L": 1, "shunt_C": 1}]}, r"drive\.match\.0 must be a table of one"),
        ({"voltage": 1, "match": [{"shunt_R": 1, "Q": 3}]}, r"drive\.match\.0\.Q must be absent"),
        (
            {"voltage": 1, "match": "auto", "sources": {"left": 1, "right": 1}},
            r"drive\.match must be .* with several sources",
        ),
    ],
)
def test_impossible_sources_are_refused(drive, words):
    with pytest.raises(SceneError, match=words):
        motor(**drive)


def test_a_match_needs_a_transducer():
    table = read_table("rayleigh")
    table["drive"] |= {"match": LADDER}
    with pytest.raises(SceneError, match=r"drive\.match must be absent without a \[\[transducer\]\]"):
        Scene.from_table("", table)


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
        assert [len(element) for element in record.scene.drive.match] == [1, 1]
    assert record.points[0]["available_power_W"] == pytest.approx(1.0, rel=1e-14)
    assert record.points[0]["voltage_V"] == pytest.approx(20.0, rel=1e-14)


def test_a_matched_motor_is_the_motor_at_its_electrodes_voltage():
    """In three dimensions: motion, reported voltage and powers are of one circuit, which the power ledger closes."""
    matched = run(motor(power="1 W", match="auto"), tolerance=1e-2)
    assert matched.surface_motion.beam is not None
    each = matched.electrical
    section = matched.surface_wave.circuit.admittance
    assert (
        abs(each["admittance_S"] / section - 1) > 1e-5
    )  # a passive transducer receives a beam, not the plane wave
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

    from studies.report.answer import answer
    from studies.report.figures import velocity

    record = run(motor(power=["1 W", "4 W"], match="auto"), tolerance=1e-2)
    text = answer(record)
    assert "available (W)" in text
    (first, _), *_ = record.scene.drive.match[0]
    assert f"match           {first} " in text
    assert "delivered 100 %" in text
    ax = Figure().add_subplot()
    velocity(record, ax)
    ax.figure.canvas.draw()
    (upper,) = ax.child_axes
    assert upper.get_xlabel() == "available power (W)"
