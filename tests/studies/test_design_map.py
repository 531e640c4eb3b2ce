"""The design map: closed forms part it, its axes are any two quantities, and it is drawn with its units."""

import math
from dataclasses import replace

import numpy as np
import pytest

from contact import steady, threshold_factor
from studies.model.balls import prescribed_orbits
from studies.model.resolve import resolved
from studies.model.wave_to_contact import contact_slider, scaled
from studies.motor import design_map
from studies.record.plots import new_figure
from studies.refusal import SceneError
from studies.scene import Scene
from tests.studies.legible import assert_legible

OVER = {"wave.normal_amplitude": "0.5 nm:15 nm:7:log", "slider.radius": "0.5 mm:4 mm:4"}


@pytest.fixture(scope="module")
def record():
    return design_map.run(over=OVER)


def test_lines_of_the_closed_forms_part_the_map(record):
    assert [finding.confirmed for finding in record.findings] == [True] * 4
    assert [panel.name for panel in record.panels] == ["velocity", "thrust", "contact_efficiency"]
    factors = np.array(record.panels[0].data["threshold_factor"])
    assert factors.min() < 1.0 < factors.max()


def test_a_value_of_the_map_is_that_of_the_contact(record):
    scene = resolved(Scene.load("twente-contact"))
    data = {panel.name: panel.data for panel in record.panels}
    i, j = 2, 5
    slider = replace(contact_slider(scene.slider), radius=data["velocity"]["y"][i])
    orbits = scaled(prescribed_orbits(scene.wave), data["velocity"]["x"][j])
    assert data["velocity"]["value"][i][j] == pytest.approx(steady(slider, orbits, tolerance=1e-3).velocity, rel=1e-6)
    assert data["velocity"]["threshold_factor"][i][j] == pytest.approx(threshold_factor(slider, orbits), rel=1e-12)
    thrust = data["thrust"]["value"][i][j]
    assert steady(replace(slider, load=0.999 * thrust), orbits, tolerance=1e-3).velocity > 0.0
    assert steady(replace(slider, load=1.001 * thrust), orbits, tolerance=1e-3).velocity <= 0.0
    half = steady(replace(slider, load=0.5 * thrust), orbits, tolerance=1e-3)
    out = 0.5 * thrust * half.velocity
    assert data["contact_efficiency"]["value"][i][j] == pytest.approx(
        out / (half.ledger.wave * scene.wave.frequency), rel=1e-9
    )


def test_the_map_is_drawn_with_units_lines_and_the_scenes_own_point(record):
    for panel in reversed(record.panels):
        figure, ax = new_figure(7.0, 4.3)
        design_map.figure(panel, ax)
        assert_legible(figure)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("normal amplitude (nm)", "radius (mm)")
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "linear")
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert labels == ["threshold (theory)", "release (theory)", "the scene's own"]
    stars = next(line for line in ax.lines if line.get_label() == "the scene's own")
    assert set(stars.get_ydata()) == {1.0}
    assert 3.0 in [pytest.approx(each) for each in stars.get_xdata()]


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([0.0, 0.0, 0.3, 210.0], [0, 5, 10, 20, 50, 100, 200, 500]),
        ([-0.09, -0.001, 0.0, 0.0], [-0.1, -0.05, -0.02, -0.01, -0.005, -0.002, -0.001, 0]),
        ([10.0, 30.0, 50.0, 60.0], [10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60]),
    ],
)
def test_a_map_has_colours_of_their_own_over_two_decades(values, expected):
    assert design_map.contour_levels(np.array(values)) == pytest.approx(expected)


def test_a_point_without_an_answer_leaves_a_hole_and_a_remark():
    found = design_map.run(over={"wave.normal_amplitude": "3 nm,6 nm,9 nm", "slider.mass": "-1e-4,1e-4,2e-4"})
    assert found.panels[0].data["value"][0] == [None] * 3
    assert all(math.isfinite(each) for row in found.panels[0].data["value"][1:] for each in row)
    assert found.findings[0].remark == "3 of 9 points have no answer"


@pytest.mark.parametrize(
    ("over", "sentence"),
    [
        ({"slider.mass": "1e-4:2e-4:3"}, "twice"),
        ({"slider.law": "elastic,hysteretic", "slider.mass": "1e-4:2e-4:3"}, "numbers"),
        ({"slider.radius": "1e-3,2e-3", "slider.mass": "1e-4:2e-4:3"}, "three values"),
        ({"slider.radius": "3e-3,2e-3,1e-3", "slider.mass": "1e-4:2e-4:3"}, "rising"),
    ],
)
def test_axes_that_make_no_map_are_refused(over, sentence):
    with pytest.raises(SceneError, match=sentence):
        design_map.run(over=over)
