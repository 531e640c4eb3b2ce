"""What was reached is recorded with its error where the tolerance is out of reach."""

import pytest

from fem import ConvergenceError
from fem.discretize import mesh_refinement
from fem.solve import driven_stator
from studies.record.point import Point
from studies.runs import run
from studies.scene import Scene, read_table
from studies.solve.point_answer import PointAnswer, SliderAnswer


@pytest.fixture
def two_levels(monkeypatch):
    monkeypatch.setattr(mesh_refinement, "LEVELS", mesh_refinement.LEVELS[:2])
    monkeypatch.setattr(mesh_refinement, "EXPECTED", mesh_refinement.EXPECTED[:2])


@pytest.fixture
def table():
    table = read_table("twente-left")
    table["stator"] |= {"length": "40 mm", "thickness": "1.5 mm"}
    table["transducer"][0] |= {"center": "6 mm", "finger_pairs": 3, "period": "0.98 mm"}
    table["drive"]["voltage"] = ["60 V"]
    table["slider"]["position"] = "25 mm"
    return table


def test_a_wave_out_of_reach_is_recorded_with_its_error(two_levels, table):
    del table["slider"]
    record = run(Scene.from_table("", table), tolerance=1e-3)
    assert record.error["relative"] > 1e-3
    assert f"error is {record.error['relative']:.1e}, 1.0e-03 was asked for" in record.shortfall
    fine = run(Scene.from_table("", table), tolerance=0.1)
    assert record.points[0]["normal_amplitude_m"] == fine.points[0]["normal_amplitude_m"]
    assert fine.shortfall == ""


def test_a_velocity_out_of_reach_is_recorded_with_its_error(two_levels, table):
    record = run(Scene.from_table("", table), tolerance=1e-3)
    assert record.points[0]["velocity_m_per_s"] < 0
    assert record.error["parts"]["stator"] > 1e-3
    assert "see error.parts" in record.shortfall
    assert record.electrical["power_W_per_V2"] > 0


def test_a_level_that_has_no_answer_leaves_the_one_below(monkeypatch, table):
    del table["slider"]
    solve = driven_stator.solve_driven

    def refused(*arguments, resolution, **rest):
        if resolution == mesh_refinement.LEVELS[2]:
            raise ConvergenceError("the guided modes leave a residual")
        return solve(*arguments, resolution=resolution, **rest)

    monkeypatch.setattr(driven_stator, "solve_driven", refused)
    record = run(Scene.from_table("", table), tolerance=1e-4)
    assert record.surface_wave.solution.fields.resolution == mesh_refinement.LEVELS[1]
    assert 1e-4 < record.error["relative"] < 0.1
    assert "was asked for" in record.shortfall


def test_a_larger_tolerance_is_advised_only_where_there_is_one():
    """A tolerance is below 1; an error of 390 % was answered with that advice too."""
    point = Point(voltage_V=40.0, velocity_m_per_s=0.1, relative_error=0.5, status="above tolerance")
    for size, advised in ((0.5, True), (3.9, False)):
        answer = SliderAnswer(answers=(PointAnswer(point=point, from_contact=size),))
        said = answer.shortfall(1e-2)
        assert f"error is {size:.1e}" in said
        assert ("larger tolerance" in said) == advised
