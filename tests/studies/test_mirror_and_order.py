"""Answers of whole motors again in the mirror, and with contacts and transducers in another order.

Truth: a mirror image moves the other way with the same sizes; the order of contacts and transducers is a name alone.
The plates are of PZT poled along z, which the mirror x -> -x leaves as it is.
"""

import json
from functools import cache

import numpy as np
import pytest

from studies import Record, Scene, run
from studies.report.motor_datasheet import datasheet
from studies.solve.predictor import Predictor
from tests.seed_motor import SCENE_SLIDER

LENGTH = 12e-3
LEFT = {"name": "left", "center": 3e-3, "finger_pairs": 2, "period": 0.98e-3, "metallisation": 0.5, "aperture": 0.02}
RIGHT = LEFT | {"name": "right", "center": 9.5e-3, "finger_pairs": 1, "aperture": 0.02, "termination": "short"}
MOTOR = {
    "stator": {"material": "PZT-8", "length": LENGTH, "thickness": 0.7e-3, "width": 0.025, "ends": "absorbing",
               "diffraction": False},
    "transducer": [LEFT, RIGHT],
    "drive": {"frequency": 2.2e6, "transducer": "left", "voltage": [30.0, 60.0]},
    "slider": SCENE_SLIDER | {
        "position": 6.3e-3, "contacts": [-0.4e-3, 0.05e-3, 0.6e-3], "heights": [0.0, 2e-9, -1e-9],
    },
}  # fmt: skip
SIGNED = (
    "velocity_m_per_s", "velocity_at_burst_end_m_per_s", "displacement_m", "travel_m", "mean_velocity_m_per_s",
    "lowest_velocity_m_per_s", "highest_velocity_m_per_s",
)  # fmt: skip


def mirrored(table: dict) -> dict:
    """Return the scene seen from the other side, each transducer under its own name."""
    slider, contacts = table["slider"], table["slider"]["contacts"]
    turned = {"position": LENGTH - slider["position"]}
    if isinstance(contacts, list):
        turned["contacts"] = [-x for x in contacts]
    moved = [each | {"center": LENGTH - each["center"]} for each in table["transducer"]]
    return table | {"transducer": moved, "slider": slider | turned}


def reordered(table: dict) -> dict:
    """Return the scene with its contacts and its transducers in another order."""
    slider, order = table["slider"], (2, 0, 1)
    own = {key: [slider[key][k] for k in order] for key in ("contacts", "heights")}
    return table | {"transducer": table["transducer"][::-1], "slider": slider | own}


@cache
def record(turn: str, **drive) -> Record:
    table = MOTOR | {"drive": MOTOR["drive"] | drive}
    table = {"": dict, "mirrored": mirrored, "reordered": reordered}[turn](table)
    return run(Scene.from_table("", json.loads(json.dumps(table))), tolerance=3e-3)


def compared(here: dict, there: dict, sign: float, rel: float) -> None:
    """Compare all numbers of two blocks, those of `SIGNED` with a sign."""
    assert here.keys() == there.keys()
    low, high = "lowest_velocity_m_per_s", "highest_velocity_m_per_s"
    if sign < 0.0 and low in there:
        there = there | {low: there[high], high: there[low]}
    for key, value in here.items():
        if isinstance(value, dict):
            compared(value, there[key], sign, rel)
        elif isinstance(value, complex):  # of the wave: the phase of u_x against u_z is that of its direction
            assert abs(there[key]) == pytest.approx(abs(value), rel=rel), key
        elif isinstance(value, float) and "error" not in key and "residual" not in key:
            side = sign if key in SIGNED else 1.0
            if key == "face_delay_deg" and sign < 0.0:  # of a motion along x, which turns its sign
                assert abs(there[key] - value) == pytest.approx(180.0, rel=rel), key
                continue
            assert side * there[key] == pytest.approx(value, rel=rel, abs=1e-12), key


TURNS = pytest.mark.parametrize(("turn", "sign"), [("mirrored", -1.0), ("reordered", 1.0)])


@TURNS
def test_a_run_and_its_burst(turn, sign):
    """A burst begins where u_z of the first contact crosses zero: in another order a short one differs by 2e-3."""
    here, there = (record(each, burst=1e-4) for each in ("", turn))
    assert abs(here.velocity[-1]) > 1e-2
    for one, other in zip(here.points, there.points, strict=True):
        starts = [key for key in one if key.startswith("after_") or key in SIGNED[1:4]]
        compared(*({key: each[key] for key in each if key not in starts} for each in (one, other)), sign, 1e-6)
        burst = [{key: each[key] for key in starts if "gap" not in key} for each in (one, other)]
        compared(*burst, sign, 1e-6 if turn == "mirrored" else 5e-3)
    limits, ends = dict(there.summary), ("ripple_from_m", "ripple_to_m")
    if turn == "mirrored":  # the places of the range, from the other end
        limits |= {key: LENGTH - there.summary[other] for key, other in zip(ends, ends[::-1], strict=True)}
    compared(here.summary, limits, 1.0, 1e-6)
    ours, theirs = dict(here.electrical), dict(there.electrical)
    left, right = (f"power_radiated_{side}_W_per_V2" for side in ("left", "right"))
    assert ours[left] != pytest.approx(ours[right], rel=1e-2)
    if turn == "mirrored":  # what is sent to the left is sent to the right
        theirs |= {left: theirs[right], right: theirs[left]}
    compared(ours, theirs, 1.0, 1e-6)
    for (_, one), (_, other) in zip(here.trajectories, there.trajectories, strict=True):
        fastest = float(np.max(np.abs(one.velocity)))
        close = 1e-6 if turn == "mirrored" else 1e-2
        assert sign * other.velocity == pytest.approx(one.velocity, rel=0, abs=close * fastest)


@TURNS
def test_the_answers_of_sweeps_fits_and_designs(turn, sign):
    also = ("limits", "thrust", "efficiency", "start-up")
    points = [{"drive.voltage": 40.0}, {"drive.voltage": 60.0, "slider.load": 2e-5, "slider.mass": 1.2e-4}]
    here, there = (
        [answer.point for answer in Predictor.of_record(record(each, burst=1e-4)).answers(points, also)]
        for each in ("", turn)
    )
    for one, other in zip(here, there, strict=True):
        assert one["status"].split(":")[0] in ("ok", "above tolerance")
        assert min(one[key] for key in ("thrust_N", "contact_efficiency", "start_up_time_s")) > 0.0
        compared(one, other, sign, 2e-5)


def test_the_rows_of_a_datasheet():
    """All of them are sizes; its load lines too, and its start has a sign."""
    one_ball = {key: value for key, value in MOTOR["slider"].items() if key != "heights"} | {"contacts": [0.2e-3]}
    table = MOTOR | {"slider": one_ball | {"load": 1e-5}, "drive": MOTOR["drive"] | {"voltage": [60.0]}}
    here, there = (datasheet(Scene.from_table("", each), tolerance=1e-2) for each in (table, mirrored(table)))
    assert [each.name for each in here.rows] == [each.name for each in there.rows]
    for one, other in zip(here.rows, there.rows, strict=True):
        assert other.value == pytest.approx(one.value, rel=1e-6), one.name
    (line,), (turned_line,) = here.lines.values(), there.lines.values()
    assert turned_line.velocity == pytest.approx(line.velocity, rel=1e-4, abs=1e-9)
    ends = [each.start_stop.velocity_at_burst_end for each in (here, there)]
    assert ends[0] < 0.0
    assert ends[1] == pytest.approx(-ends[0], rel=1e-6)
