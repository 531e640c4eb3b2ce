"""Studies: each is listed, runs through its command and draws; what they must find is found."""

import json
from inspect import signature
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from studies.__main__ import main
from studies.refusal import SceneError
from studies.results import MANIFEST
from studies.scene import Scene
from studies.scene.toml import document
from studies.study_list import ALIASES, STUDIES, Finding, Panel, StudyRecord, draw_study, module, question, run_study


def test_every_study_says_question_method_expectation_and_run_time():
    for name in STUDIES:
        text = " ".join(module(name).__doc__.split())
        assert question(name).endswith(".")
        assert all(word in text for word in ("Method:", "Expected:", "Run time:"))
        assert callable(module(name).run)
        assert callable(getattr(module(name), "figure", None) or module(name).draw)


def test_the_list_names_every_study(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["sawmotor", "study"])
    assert main() == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(STUDIES)


SLOW = {"gallery"}  # half a minute of pictures; test_gallery.py runs it too
NAMES = [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in STUDIES]


@pytest.mark.parametrize("name", NAMES)
def test_a_study_runs_through_its_command(studied, name):
    done = studied(name)
    assert "a defect of sawmotor" not in done.err
    assert done.status == 0, done.err
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
    assert bool(contradicted) is ("checks are contradicted" in done.err)
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


@pytest.fixture(scope="module")
def seed(studied):
    done = studied("seed_figures")
    return done.folder, done.out, done.record


def test_all_figures_of_the_seed_are_drawn(seed):
    folder, _, _ = seed
    names = {f"fig_{name}.png" for name in ("2", "5a", "5b", "6a", "6b", "7a", "7b")}
    assert {path.name for path in folder.iterdir()} == names | {"study.json", MANIFEST}


def test_the_paper_is_borne_out_but_for_the_damping_of_figure_7b(seed):
    _, text, record = seed
    contradicted = [finding for finding in record["findings"] if not finding["confirmed"]]
    assert len(record["findings"]) == 15
    assert [finding["statement"] for finding in contradicted] == ['Section IV: "A damped oscillation will occur."']
    assert text.count(": confirmed") == 14


def test_the_numbers_of_the_seed_figures_are_those_of_the_closed_forms(seed):
    _, _, record = seed
    found = {finding["quantity"]: finding["found"] for finding in record["findings"]}
    assert found["frequency of the ring (Hz)"] == pytest.approx(6581, rel=2e-3)  # design.md
    release = found["release amplitude (nm); 1 % below slip, 1 % above intermittent"]
    # design.md; the full motion parts from the surface (f_n/f)^2 = 1.6e-5 earlier than the averaged one
    assert 4.17258 - release == pytest.approx(6.3e-5, abs=1e-5)


def test_the_elements_give_the_wave_of_the_half_space(studied):
    findings = studied("rayleigh").record["findings"]
    assert [finding["confirmed"] for finding in findings] == [True] * 4
    (panel,) = (each for name, each in studied("rayleigh").record["panels"].items() if "convergence" in name)
    assert panel["relative_error"][1] < 1e-12 < 1e-8 < panel["relative_error"][0]


def test_a_study_of_a_scene_takes_one_and_leaves_its_run(tmp_path):
    record = run_study("voltage_to_velocity", "twente-contact", tmp_path)
    draw_study("voltage_to_velocity", record, tmp_path)
    assert "threshold" in str(record)
    files = {path.name for path in tmp_path.iterdir()}
    assert files == {"run.json", "scene.toml", "velocity.csv", "voltage_to_velocity.png"}


@pytest.mark.parametrize(
    ("name", "scene", "words"), [("rayliegh", None, "did you mean rayleigh"), ("rayleigh", "twente", "takes none")]
)
def test_a_study_that_cannot_be_is_refused(tmp_path, name, scene, words):
    with pytest.raises(SceneError, match=words):
        run_study(name, scene, tmp_path)


def test_a_finding_reads_as_a_sentence_with_its_verdict():
    finding = Finding(statement="It moves.", quantity="v (m/s)", expected="> 0", found=-1.0, confirmed=False)
    assert str(finding) == "It moves.\n    v (m/s): -1, expected > 0: contradicted"


@pytest.fixture(scope="module")
def cells(studied):
    return studied("cell_parameters")


def test_the_cells_are_as_expected(cells):
    assert [finding["confirmed"] for finding in cells.record["findings"]] == [True] * 5


def test_the_wave_decays_in_its_stop_band_and_nowhere_else(cells):
    (data,) = cells.record["panels"].values()
    data = {key: np.array(value) for key, value in data.items()}
    at = data["frequency_Hz"]
    for name in ("shorted", "open"):
        edge = 0.1 * (data[f"{name}_upper_Hz"] - data[f"{name}_lower_Hz"])
        inside = (at > data[f"{name}_lower_Hz"] + edge) & (at < data[f"{name}_upper_Hz"] - edge)
        outside = (at < data[f"{name}_lower_Hz"] - edge) | (at > data[f"{name}_upper_Hz"] + edge)
        assert inside.any()
        assert data[f"{name}_decay"][inside].min() > 0.3 * data[f"{name}_reflectivity"]
        assert data[f"{name}_decay"][outside].max() < 1e-3 * data[f"{name}_reflectivity"]
        np.testing.assert_allclose(data[f"{name}_phase_rad"][inside], np.pi, atol=1e-5)
        assert data[f"{name}_phase_rad"][outside].max() < np.pi - 1e-4


def test_the_stop_bands_are_drawn(cells):
    assert (cells.folder / "stop_bands.png").stat().st_size > 10_000


def test_the_slider_of_the_stroke_travels_from_its_place_as_far_as_its_speed_says(studied, small):
    panels = studied("stroke").record["panels"]
    (moved,) = (each for name, each in panels.items() if name.endswith("velocity"))
    half = moved["position_m"][1] - moved["position_m"][0]
    for name, path in moved["path_m"].items():
        speed = moved["path_velocity_m_per_s"][name]
        assert path[0] == pytest.approx(small.slider.center[0], rel=1e-12)
        time = 2e-3 / (len(path) - 1)  # of the small version, in equal steps
        # speeds are those at the ends of cycles, which differ from their means by the motion within a cycle
        assert path[-1] - path[0] == pytest.approx(time * np.trapezoid(speed), rel=3e-4)
        assert abs(path[-1] - path[0]) < half  # so that a position has one sign of the speed
        low, mean, high, slowest, fastest = (
            np.array(moved[f"{key}_m_per_s"][name]) for key in ("lowest", "velocity", "highest", "slowest", "fastest")
        )
        assert np.all(low <= mean)
        assert np.all(mean <= high)
        assert np.all(mean < 0.0)  # the wave runs to +x: the fastest is the lowest of the negative velocities
        np.testing.assert_array_equal(fastest, low)
        np.testing.assert_array_equal(slowest, high)


def test_error_against_time_has_three_parts_whose_errors_are_stated(studied):
    record = studied("error_vs_time").record
    assert list(record["panels"]) == [f"error_vs_time_{part}" for part in ("chain", "stator", "contact")]
    contact = record["panels"]["error_vs_time_contact"]
    rows = dict(zip(contact["curve"], contact["true_relative_error"], strict=True))
    assert set(rows) == {"burst, exact", "burst, stepped", "burst, averaged", "steady, exact", "steady, averaged"}
    assert max(rows.values()) < 1e-3
    assert rows["burst, stepped"] > 1e-9  # not the same computation as the converged answer
    assert [finding["confirmed"] for finding in record["findings"]] == [True] * 3


@pytest.mark.parametrize("name", sorted(ALIASES))
def test_a_study_answers_to_its_former_name(name):
    assert module(name) is module(ALIASES[name])


def test_what_the_contact_cannot_answer_is_no_defect_of_the_program(tmp_path, capsys):
    """Without friction no step is planned."""
    file = tmp_path / "smooth.toml"
    file.write_text(document(Scene.load("twente-contact").replace(slider={"friction_coefficient": 0.0}).to_table()))
    assert main(["study", "step_planner", str(file), "--quick", "--out", str(tmp_path / "out")]) == 3
    assert "defect" not in (said := capsys.readouterr().err)
    assert "runaway" in said


def test_the_help_names_the_studies_of_a_scene_that_take_no_tolerance(capsys):
    assert main(["study", "--help"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    taken = {name: signature(module(name).run).parameters for name in STUDIES}
    without = [name for name, own in taken.items() if "scene" in own and "tolerance" not in own]
    assert f"all take it but {', '.join(without[:-1])} and {without[-1]}" in said


def test_a_tolerance_is_the_stator_s_and_the_contact_s():
    """A coarser one changes the load line by less than itself."""
    fine, loose = (
        module("load_line").run("twente-contact", points=3, tolerance=each).panels[0].data["value"]["20 nm"]
        for each in (1e-4, 1e-1)
    )
    assert list(fine) != list(loose)
    assert fine == pytest.approx(loose, rel=0.1)


def test_an_option_that_a_study_does_not_take_is_refused_with_those_that_it_takes():
    with pytest.raises(SceneError, match="--band is not taken by the study load_line, which takes --tolerance"):
        run_study("load_line", None, Path(), options={"band": "1:2:3"})
