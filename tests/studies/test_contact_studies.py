"""Studies of the contact: what they must find is found, and they draw."""

from dataclasses import replace

import numpy as np
import pytest

from studies import runs
from studies.model.resolve import build
from studies.model.wave_to_contact import Contact
from studies.motor import load_line, regime_map, step_planner
from studies.record.plots import new_figure
from studies.runs import run
from studies.scene import Scene
from studies.solve.solved_stator import contact_of_run
from studies.study_list import Panel, contact_of_study
from tests.studies.legible import assert_legible
from tests.studies.settings import SHORT, changed


@pytest.fixture(scope="module")
def motor():
    """A short motor on a stator, two balls at different places, and what a run says of it."""
    balls = 'slider.contacts=["0 mm", "0.35 mm"]'
    scene = changed("twente-left", *SHORT, "stator.diffraction=false", balls, "drive.voltage=[40, 80]")
    return scene, run(scene, tolerance=1e-3)


def test_the_contact_of_a_study_is_that_of_a_run_without_the_rest_of_the_run(motor, monkeypatch):
    scene, told = motor
    expected = contact_of_run(told)

    def refuse(*given, **options):
        raise AssertionError("a contact needs neither limits nor velocities nearby, bands, model errors or warnings")

    for name in ("slider_answer", "_with_ripple", "with_model_error", "warnings_of"):
        monkeypatch.setattr(runs, name, refuse)
    found = contact_of_study(scene)
    assert found.orbits == expected.orbits
    assert (found.amplitudes, found.stator_error) == (expected.amplitudes, expected.stator_error)
    assert found.record.electrical == told.electrical
    assert found.record.heat.mean_rise_K == told.heat.mean_rise_K


def test_regimes_of_a_motor_on_a_stator(motor):
    """Its operating points are the run's amplitudes; the closed forms part the regimes for two unequal balls too."""
    scene, told = motor
    record = regime_map.run(scene, amplitudes=8, preloads=5, checked=2)
    amplitudes = [point["normal_amplitude_m"] for point in told.points]
    np.testing.assert_allclose(record.panels[0].data["operating_amplitude_m"], amplitudes, rtol=1e-3)
    assert [finding.confirmed for finding in record.findings] == [True, True]


def test_load_line_of_a_motor_on_a_stator_starts_at_the_run_s_velocity(motor):
    scene, told = motor
    panel, _ = load_line.run(scene, points=3).panels
    assert list(panel.data["load_N"]) == ["40 V", "80 V"]
    for point, speeds in zip(told.points, panel.data["value"].values(), strict=True):
        assert abs(speeds[0]) == pytest.approx(abs(point["velocity_m_per_s"]), rel=2e-3)


def test_steps_of_a_motor_on_a_stator(motor):
    """The wave of the left transducer drives to -x; a step is drawn as a distance all the same."""
    scene = replace(motor[0], stator=replace(motor[0].stator, thickness=1e-3))
    record = step_planner.run(scene, cycles=(512, 1024), wanted=(2e-8,), lines=1)
    assert all(finding.confirmed for finding in record.findings)
    assert np.all(record.panels[0].data["distance_m"]["80 V"] > 0.0)


def test_regime_map_has_the_preload_of_the_slider():
    def data(contacts):
        scene = Scene.load("twente-contact").replace(slider={"contacts": contacts, "preload": "0.9 mN"})
        return regime_map.run(scene, amplitudes=8, preloads=3, checked=1).panels[0].data

    one, three = data(1), data(3)
    assert [each["operating_preload_N"] for each in (one, three)] == pytest.approx([0.9e-3, 0.9e-3], rel=1e-12)
    np.testing.assert_allclose(three["preload_N"], one["preload_N"], rtol=1e-12)
    # three balls share the load, and the release grows as its power of 2/3
    ratio = np.array(three["lines_m"]["release"]) / one["lines_m"]["release"]
    np.testing.assert_allclose(ratio, 3.0 ** (-2.0 / 3.0), rtol=1e-2)


def test_regime_map_lies_on_its_lines():
    record = regime_map.run(amplitudes=15, preloads=9, checked=4)
    assert [finding.confirmed for finding in record.findings] == [True, True]
    kinds = {kind for row in record.panels[0].data["kind"] for kind in row}
    assert kinds == set(regime_map.KINDS)
    ax = regime_map.figure(record.panels[0], new_figure(7.0, 4.3)[1])
    assert_legible(ax.figure)
    assert "nm" in ax.get_xlabel()
    assert "mN" in ax.get_ylabel()
    marks = [each for each in ax.lines if each.get_marker() not in ("", "None", None)]
    for each in marks:  # the outermost ones were cut by the frame
        x, _ = each.get_transform().transform(each.get_xydata()).T
        half = 0.5 * each.get_markersize() * ax.figure.dpi / 72.0
        assert ax.bbox.x0 <= x.min() - half
        assert x.max() + half <= ax.bbox.x1


def test_a_slider_sticks_while_some_of_its_balls_slip(monkeypatch):
    """Balls on unlike orbits slip one after the other; the threshold is where the slider starts."""
    driven = Contact.prescribed(build(Scene.load("twente-contact")))
    unlike = replace(driven, orbits=(driven.orbits[0], driven.orbits[0].scaled(0.5)))
    monkeypatch.setattr(regime_map, "driven_contact", lambda scene, **options: unlike)
    assert regime_map.run(amplitudes=24, preloads=3, checked=1).findings[0].confirmed


def test_load_line_stalls_and_is_below_one():
    record = load_line.run(points=5)
    assert all(finding.confirmed for finding in record.findings)
    assert [panel.name for panel in record.panels] == ["load_line", "efficiency"]
    ax = load_line.figure(record.panels[0], new_figure(7.0, 4.3)[1])
    assert_legible(ax.figure)
    assert len(ax.get_lines()) == 4
    assert ax.get_xlabel() == "load (µN)"
    stalls = record.panels[0].data["blocked_thrust_N"]
    said = dict(record.answer)["blocked thrust"]
    assert [float(each.split()[0]) for each in said.split(", ")] == pytest.approx(
        [1e6 * stall for stall in stalls.values()], rel=1e-3
    )


def test_a_load_line_s_axis_has_the_unit_of_its_loads():
    data = {"load_N": {"100 V": [0.0, 1.2]}, "value": {"100 V": [0.8, 0.0]}, "axis": "", "factor": 1.0}
    ax = load_line.figure(Panel(name="load_line", title="", data=data), new_figure(7.0, 4.3)[1])
    assert (ax.get_xlabel(), ax.get_lines()[0].get_xdata()[-1]) == ("load (N)", 1.2)


def test_steps_are_planned_and_grow_as_the_square_of_the_cycles():
    record = step_planner.run(cycles=(64, 512, 1024, 2048), wanted=(2e-9, 2e-8), lines=1)
    assert [finding.confirmed for finding in record.findings] == [True, True, True]
    assert [panel.name for panel in record.panels] == ["step_planner", "stopping"]
    (plans,) = record.panels[0].data["planned_cycles"].values()
    assert plans == sorted(plans)
    ax = step_planner.figure(record.panels[0], new_figure(7.0, 4.3)[1])
    assert_legible(ax.figure)
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    assert len([line for line in ax.get_lines() if len(line.get_xdata())]) == 2
    assert "planned for 2, 20 nm" in [text.get_text() for text in ax.get_legend().get_texts()]


@pytest.mark.parametrize(("degrees", "size", "plan"), [(90, 3e-11, "0.03 nm in 1 cycle"), (300, 1e-8, "10 nm in ")])
def test_a_step_of_one_cycle_is_planned_and_what_goes_back_is_drawn(monkeypatch, degrees, size, plan):
    """Two balls on unlike phases: the first cycles strain their springs along the motor's way or against it."""
    driven = Contact.prescribed(build(Scene.load("twente-contact")))
    (orbit,) = driven.orbits
    unlike = replace(driven, orbits=(orbit, orbit.scaled(complex(np.exp(1j * np.deg2rad(degrees))))))
    monkeypatch.setattr(step_planner, "driven_contact", lambda scene, **options: unlike)
    monkeypatch.setattr(Contact, "spread", lambda self, factor, count: [1e-8])
    record = step_planner.run(cycles=(8, 256), wanted=(size,), lines=1)
    assert record.findings[0].confirmed
    assert f"amplitude 10 nm: {plan}" in record.findings[0].remark
    ax = step_planner.figure(record, new_figure(7.0, 4.3)[1])
    curve, *_ = ax.get_lines()
    ((cycles,),) = record.panels[0].data["planned_cycles"].values()
    assert sorted([8, cycles, 256]) == list(curve.get_xdata())
    assert min(curve.get_ydata()) > 0.0
    back = "against the motor's direction" in [text.get_text() for text in ax.get_legend().get_texts()]
    assert back == (degrees == 300)
