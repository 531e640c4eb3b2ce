"""Every registered study runs through its command on a small scene, leaves its numbers and draws its pictures."""

import json

import pytest
from matplotlib.figure import Figure

from studies.study import STUDIES, Panel, StudyRecord, module, question

SLOW = {"gallery"}  # half a minute of pictures; test_gallery.py runs it too
NAMES = [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in STUDIES]


@pytest.mark.parametrize("name", NAMES)
def test_a_study_runs_through_its_command(studied, name):
    done = studied(name)
    assert "a defect of sawmotor" not in done.err
    assert done.status == (1 if "contradicted" in done.err else 0), done.err
    assert done.out.splitlines()[-1] == f"results  {done.folder}"
    names = {path.name for path in done.folder.iterdir()}
    assert any(name.endswith(".png") for name in names)
    assert "pictures are missing" not in done.err
    if "run.json" in names:
        return
    record = done.record
    assert record["question"] == question(name)
    assert record["panels"]
    contradicted = [finding for finding in record["findings"] if finding["confirmed"] is False]
    assert bool(contradicted) is (done.status == 1)
    assert json.dumps(record, allow_nan=False)


def test_every_study_has_a_figure():
    assert [name for name in STUDIES if not callable(getattr(module(name), "figure", None))] == []


def test_every_study_has_a_small_version():
    assert [name for name in STUDIES if not getattr(module(name), "QUICK", None)] == []


def test_a_figure_takes_the_record_and_draws_the_panel_that_is_named():
    from studies.papers import seed_figures

    panels = tuple(
        Panel(
            name=name,
            title=name,
            data={"x": [0, 1], "left": {"v": [0.0, 1.0]}, "x_axis": "t (s)", "left_axis": "v (m/s)"},
        )
        for name in ("first", "second")
    )
    record = StudyRecord(name="seed_figures", panels=panels, findings=(), seconds=0.0)
    for options, title in (({}, "first"), ({"panel": "second"}, "second")):
        ax = seed_figures.figure(record, Figure().add_subplot(), **options)
        assert ax.get_title() == title
