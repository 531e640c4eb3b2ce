"""Studies: each lists, runs, draws and is written; what they must find is found."""

import pytest

from studies.__main__ import main
from studies.refusal import SceneError
from studies.results import MANIFEST
from studies.study import STUDIES, Finding, draw_study, module, question, run_study


def quiet(text):
    return None


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
    assert [finding["statement"] for finding in contradicted] == [
        'Section IV: "A damped oscillation will occur."'
    ]
    assert text.count(": confirmed") == 14


def test_the_numbers_of_the_seed_figures_are_those_of_the_closed_forms(seed):
    _, _, record = seed
    found = {finding["quantity"]: finding["found"] for finding in record["findings"]}
    assert found["frequency of the ring (Hz)"] == pytest.approx(6581, rel=2e-3)  # design.md
    release = found["release amplitude (nm); 1 % below slip, 1 % above intermittent"]
    assert release == pytest.approx(4.17258, rel=1e-5)  # design.md


def test_the_cell_gives_the_half_space_on_both_surfaces(studied):
    findings = studied("rayleigh").record["findings"]
    assert {finding["statement"].split("(")[1] for finding in findings} == {"open).", "metallised)."}
    best = [finding for finding in findings if "nine digits" in finding["statement"]]
    assert all(finding["found"] < 1e-9 for finding in best)
    shapes = [each for each in findings if "profile" in each["statement"] or "ratio" in each["statement"]]
    assert len(shapes) == 4
    assert all(finding["found"] < 1e-6 for finding in shapes)


def test_orders_are_measured_on_the_two_finest_meshes():
    from studies.evidence import rayleigh as chosen

    table = {"order": [2, 2, 2], "columns": [1, 2, 4], "relative_error": [1.0, 1e-3, 1e-3 / 16]}
    (finding,) = chosen._orders(table, "open")
    assert finding.found == pytest.approx(4.0, rel=1e-12)
    assert finding.confirmed
    table["relative_error"][-1] = 1e-3 / 8
    assert not chosen._orders(table, "open")[0].confirmed


def test_a_study_of_a_scene_takes_one_and_leaves_its_run(tmp_path):
    record = run_study("voltage_to_velocity", "twente-contact", tmp_path, progress=quiet)
    draw_study("voltage_to_velocity", record, tmp_path, progress=quiet)
    assert "threshold" in str(record)
    files = {path.name for path in tmp_path.iterdir()}
    assert files == {"run.json", "scene.toml", "velocity.csv", "voltage_to_velocity.png"}


@pytest.mark.parametrize(
    ("name", "scene", "words"),
    [
        ("rayliegh", None, "did you mean rayleigh"),
        ("rayleigh", "twente", "takes none"),
        ("voltage_to_velocity", "rayleigh", "slider is missing"),
    ],
)
def test_a_study_that_cannot_be_is_refused(tmp_path, name, scene, words):
    with pytest.raises(SceneError, match=words):
        run_study(name, scene, tmp_path, progress=quiet)


def test_a_finding_reads_as_a_sentence_with_its_verdict():
    finding = Finding(statement="It moves.", quantity="v (m/s)", expected="> 0", found=-1.0, confirmed=False)
    assert str(finding) == "It moves.\n    v (m/s): -1, expected > 0: contradicted"
