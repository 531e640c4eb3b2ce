"""Studies of motors whose contacts are fast against the wave (f_n/f = 0.09), or whose bounce lives long."""

import json

import numpy as np
import pytest

from studies.motor import load_line, regime_map, step_planner
from studies.record.plots import new_figure
from studies.report.motor_datasheet import datasheet
from studies.scene import Scene
from tests.studies.legible import assert_legible

PAIR = {"effective_modulus": "64 GPa", "tangential_modulus": "12 GPa", "radius": "1 mm"}
LIGHT = {
    "title": "light",
    "wave": {"frequency": 756808.77, "normal_amplitude": "4 nm", "tangential_ratio": 0.7},
    "slider": PAIR | {"mass": "2 mg", "contacts": 1, "preload": "2 mN", "friction_coefficient": 0.15,
                      "damping": {"normal": 0.25678}},
}  # fmt: skip
LIVELY = {
    "title": "lively",
    "wave": {"frequency": "2.2 MHz", "normal_amplitude": "25 nm", "tangential_ratio": 0.7},
    "slider": PAIR | {"mass": "2 mg", "contacts": 2, "preload": "0.5 mN", "friction_coefficient": 0.3,
                      "damping": {"normal": "0.02 N s/m", "tangential": "1e-5 N s/m"}},
}  # fmt: skip


def scene(table):
    return Scene.from_table("", json.loads(json.dumps(table)))


def test_a_regime_map_marks_what_averaging_cannot_tell():
    record = regime_map.run(scene(LIGHT), amplitudes=36, preloads=28, checked=2)
    assert [finding.confirmed for finding in record.findings] == [True, True]
    data = record.panels[0].data
    kinds, speeds = np.array(data["kind"]), data["velocity_m_per_s"]
    unknown = np.argwhere(kinds == "unknown")
    assert 0 < len(unknown) < 0.02 * kinds.size
    assert all(speeds[i][j] is None for i, j in unknown)
    json.dumps(speeds, allow_nan=False)
    ax = regime_map.figure(record.panels[0], new_figure(7.0, 4.3)[1])
    marked = next(line for line in ax.get_lines() if line.get_label() == "unknown (averaged)")
    assert len(marked.get_xdata()) == len(unknown)
    assert_legible(ax.figure)


def test_a_bounce_that_lives_contradicts_no_motor():
    record = step_planner.run(scene(LIVELY), cycles=(128, 256, 512, 1024), wanted=(1e-8,), lines=1)
    assert all(finding.confirmed for finding in record.findings)
    assert not any("evenly" in finding.statement for finding in record.findings)


def test_the_datasheet_s_numbers_hold_within_their_errors():
    """Truths: bisections of an independent integrator (thrust) and of the exact motion (threshold and release)."""
    rows = {row.name: row for row in datasheet(scene(LIGHT)).rows}
    thrust = rows["blocked thrust"]
    assert thrust.value == pytest.approx(63.72e-6, abs=0.005e-6)
    assert thrust.error < 1e-3
    for name, truth in (("threshold", 2.2288625e-9 / 1.0044), ("release", 7.2507837e-9 / 1.0075)):
        assert rows[name].value == pytest.approx(truth, rel=5e-4)
        assert rows[name].error < 1e-5
    assert rows["load held on the wave"].value >= thrust.value
    (line, *_) = load_line.run(scene(LIGHT), points=3).panels
    assert line.data["blocked_thrust_N"]["4 nm"] == pytest.approx(thrust.value, rel=1e-12)


def test_a_load_line_says_that_a_point_misses_its_tolerance():
    undamped = LIGHT | {"slider": {key: value for key, value in LIGHT["slider"].items() if key != "damping"}}
    record = load_line.run(scene(undamped), points=3)
    assert "goes on bouncing" in record.findings[0].remark
    assert load_line.run(scene(LIGHT), points=3).findings[0].remark == ""
