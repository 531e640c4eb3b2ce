"""The command: exit codes, what goes to stdout and stderr, what is written, what is imported."""

import builtins
import io
import json
import shlex
import subprocess
import sys
from importlib import import_module

import pytest

from studies.__main__ import main
from studies.command.parser import COMMANDS, parser
from studies.command.scene_argument import read_tolerance
from studies.record import Record
from studies.refusal import SceneError
from studies.results import MANIFEST
from studies.scene import Scene, shipped_scenes

CONTACT = ["run", "twente-contact", "--set", "wave.normal_amplitude=[0, 3e-9]"]


@pytest.fixture
def call(monkeypatch, capsys, tmp_path):
    """Run the command in an empty directory; give its exit code, stdout and stderr."""
    monkeypatch.chdir(tmp_path)

    def called(*words):
        monkeypatch.setattr(sys, "argv", ["sawmotor", *words])
        status = main()
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return called


def without_balls(text):
    """Text without the warning that balls are computed smooth."""
    return "".join(line for line in text.splitlines(True) if "the balls are computed smooth" not in line)


def one_sentence(text):
    text = without_balls(text)
    return text.startswith("sawmotor: ") and text.count("\n") == 1


def a_sentence_each(text):
    return all(line.startswith("sawmotor: ") for line in text.splitlines())


def test_a_run_prints_its_answer_and_leaves_its_files(call, tmp_path):
    status, out, err = call(*CONTACT, "--no-plot")
    assert status == 0
    assert "sawmotor:" not in without_balls(err)  # progress alone, where the machine is slow
    assert all(word in out for word in ("velocity (mm/s)", "threshold", "release", "relative error", "left out"))
    names = sorted(path.name for path in (tmp_path / "results" / "twente-contact").iterdir())
    assert names == [MANIFEST, "run.json", "scene.toml", "velocity.csv"]


def test_warnings_about_a_scene_come_before_its_run_and_once(call):
    status, _, err = call("run", "rayleigh", "--set", "stator.length=2", "--set", "drive.frequency=1e-12", "--no-plot")
    assert status == 3
    lines = [line for line in err.splitlines() if line.startswith("sawmotor: ")]
    assert lines[0] == "sawmotor: warning: stator.length is 2 m: a number without a unit is in m"
    assert not lines[1].startswith("sawmotor: warning")  # the reason why the run has no answer
    status, _, err = call("run", "rayleigh", "--set", "stator.length=2", "--no-plot")
    assert status == 0
    assert err.count("a number without a unit is in m") == 1


def test_only_what_resembles_is_suggested(call):
    assert "did you mean" not in call("help", "nonsense")[2]
    assert "nearest" not in call("wave", "nosuch")[2]
    assert "the nearest known one is 'PZT-8'" in call("wave", "PTZ8")[2]


def test_a_run_says_what_it_replaced_and_leaves_other_files(call, tmp_path):
    call(*CONTACT, "--no-plot", "--out", "here")
    (tmp_path / "here" / "notes.md").write_text("mine")
    status, _, err = call(*CONTACT, "--no-plot", "--out", "here")
    assert status == 0
    assert all(word in err for word in ("replaced", "run.json", "velocity.csv", "left as they were", "notes.md"))
    assert (tmp_path / "here" / "notes.md").read_text() == "mine"


def test_scenes_of_one_name_do_not_replace_each_other(call, tmp_path):
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        text = shipped_scenes()["twente-contact"].read_text().splitlines()
        scene = [f'title = "{folder}"' if line.startswith("title") else line for line in text]
        (tmp_path / folder / "motor.toml").write_text("\n".join(scene))
    assert call("run", "a/motor.toml", "--no-plot")[0] == 0
    status, out, err = call("run", "b/motor.toml", "--no-plot")
    assert (status, out) == (2, "")
    assert one_sentence(err)
    assert "a/motor.toml" in err
    assert json.loads((tmp_path / "results/motor/run.json").read_text())["title"] == "a"
    assert call("run", "b/motor.toml", "--no-plot", "--out", "results/motor")[0] == 0


def test_a_run_and_a_study_of_one_name_have_directories_of_their_own(call, tmp_path, monkeypatch):
    from studies.study_list import StudyRecord

    record = StudyRecord(name="rayleigh", panels=(), findings=(), seconds=0.0)
    monkeypatch.setattr("studies.evidence.rayleigh.run", lambda: record)
    assert call("study", "rayleigh")[0] == 0
    assert call("run", "rayleigh", "--no-plot")[0] == 0
    assert {path.name for path in (tmp_path / "results").iterdir()} == {"rayleigh", "rayleigh-study"}


@pytest.mark.parametrize(("error", "expected"), [(OSError, 0), (ValueError, 70)])
def test_a_picture_that_fails_leaves_the_numbers(call, tmp_path, monkeypatch, error, expected):
    """What the machine cannot do is a note; any other error is a defect."""

    def broken(*_):
        raise error("no ink")

    monkeypatch.setattr("studies.report.drawing.Drawing.draw", broken)
    status, out, err = call(*CONTACT)
    assert status == expected
    assert ("velocity (mm/s)" in out) == (not expected)
    assert one_sentence(err)
    assert "no ink" in err
    names = {path.name for path in (tmp_path / "results" / "twente-contact").iterdir()}
    assert names == {MANIFEST, "run.json", "scene.toml", "velocity.csv"}


def test_an_interrupt_while_drawing_leaves_the_numbers(call, tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("studies.report.drawing.Drawing.draw", interrupted)
    status, _, err = call(*CONTACT)
    assert status == 130
    assert "the numbers are in" in err
    assert (tmp_path / "results" / "twente-contact" / "run.json").exists()


def test_files_of_the_working_directory_are_not_imported(call, tmp_path, monkeypatch):
    monkeypatch.delitem(sys.modules, "matplotlib.figure", raising=False)  # drawn by a process of its own
    for name in ("studies", "numpy", "pickle", "matplotlib"):
        (tmp_path / f"{name}.py").write_text("raise RuntimeError('imported from the working directory')")
    status, _, err = call(*CONTACT)
    assert status == 0
    assert "missing" not in err
    assert (tmp_path / "results" / "twente-contact" / "velocity.png").exists()


def test_a_contradicted_finding_is_a_warning_and_the_study_an_answer(call, monkeypatch):
    from studies.study_list import Finding, StudyRecord

    def record(confirmed):
        finding = Finding(statement="It holds.", quantity="ratio", expected="1", found=2.0, confirmed=confirmed)
        return StudyRecord(name="rayleigh", panels=(), findings=(finding,), seconds=0.0)

    for confirmed in (True, False):
        monkeypatch.setattr("studies.evidence.rayleigh.run", lambda held=confirmed: record(held))
        status, _, err = call("study", "rayleigh", "--out", str(confirmed))
        assert status == 0
        warned = "sawmotor: warning: 1 of 1 checks are contradicted: ratio is 2, expected 1\n" in err
        assert warned is not confirmed


def test_json_is_what_run_json_would_hold_and_writes_nothing(call, tmp_path):
    status, out, _ = call(*CONTACT, "--json")
    assert status == 0
    assert not list(tmp_path.iterdir())
    answer = json.loads(out)
    status, out, _ = call(*CONTACT, "--json", "--out", "here")
    kept = json.loads((tmp_path / "here" / "run.json").read_text())
    for one in (answer, kept, json.loads(out)):
        del one["seconds"]
    assert answer == kept == json.loads(json.dumps(kept))
    assert {"title", "scene", "wave", "points", "summary", "error", "left_out", "provenance"} <= answer.keys()
    assert answer.keys().isdisjoint({"electrical"})


def test_a_scene_that_is_left_runs_again_to_the_same_numbers(call, tmp_path):
    call(*CONTACT, "--no-plot", "--out", "first")
    status, _, _ = call("run", "first/scene.toml", "--no-plot", "--out", "second")
    assert status == 0
    first, second = (json.loads((tmp_path / n / "run.json").read_text()) for n in ("first", "second"))
    assert first["points"] == second["points"]
    assert first["scene"] == second["scene"]


@pytest.mark.parametrize(
    "words",
    [
        ["run", "nowhere"],
        ["run", "twente-contact", "--set", "slider.mas=1"],
        ["run", "twente-contact", "--set", "slider.mass=0"],
        ["run", "twente-contact", "--voltage", "5"],
        ["run", "twente", "--voltage", ""],
        ["run", "twente", "--voltage", "5:60"],
        ["run", "twente", "--field", "--json"],
        ["run", "rayleigh", "--field"],
        ["run", "twente", "--explain", "--tolerance", "x"],
        ["run", "twente-contact", "--tolerance", "0"],
        ["run", "twente-contact", "--tolerance", "tight"],
        ["run", "twente-contact", "--tolerance", "nan"],
        ["run", "twente-contact", "--fast"],
        ["run", "twente-contact", "--js"],
        ["walk"],
        ["sweep", "twente", "--over", "slider.preload=1:2"],
        ["sweep", "twente", "--over", "slider.preload"],
        ["sweep", "twente", "--over", "slider.prelod=1,2"],
        ["study", "rayleigh", "--tolerance", "1e-2"],
        ["export", "twente", "--format", "touchstone", "--out", "no/net.s2p"],
        ["wave", "PZT-9"],
        ["wave", "PZT-8", "--surface", "wet"],
        ["wave", "PZT-8", "--orientation", "1,2"],
        ["check", "twente", "--set", "transducer.1.center=15 mm"],
        ["check", "rayleigh", "--set", "slider={}"],
    ],
    ids=" ".join,
)
def test_bad_input_is_refused_in_one_sentence_with_code_2(call, tmp_path, words):
    status, out, err = call(*words)
    assert (status, out) == (2, "")
    assert a_sentence_each(err) if "slider={}" in words else one_sentence(err), err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["sweep", "twente-contact", "--also", "speed"], "--also must be of"),
        (["design", "twente-contact", "--over", "slider.mass=1:2", "--maximise", "noise"], "--maximise noise is none"),
        (["design", "twente-contact", "--maximise", "thrust"], "--over is required"),
        (["fit", "twente-contact", "--data", "no.csv", "--free", "slider.mass=1:2"], "--data 'no.csv' cannot be read"),
        (["materials", "PZT-9"], "material must be in the catalogue"),
        (
            ["fit", "twente-contact", "--free", "slider.mass=2:1"],
            "--free slider.mass must have LOW below HIGH, got 2 and 1 kg",
        ),
    ],
)
def test_what_a_python_function_refuses_is_said_of_the_option(call, words, sentence):
    status, out, err = call(*words)
    assert (status, out) == (2, "")
    assert err.startswith(f"sawmotor: {sentence}")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["design", "twente", "--maximize", "velocity"], "--maximize velocity; did you mean --maximise? (see"),
        (["study", "stability", "--quik"], "--quik; did you mean --quick? (see sawmotor study --help)"),
        (["run", "twente", "--otu=x"], "--otu=x; did you mean --out? (see sawmotor run --help)"),
        (["check", "twente", "--frobnicate"], "arguments: --frobnicate; an example: sawmotor check twente --set"),
        (["stduy"], "'view'); did you mean study? (see sawmotor --help)"),
    ],
)
def test_an_unknown_option_is_answered_with_the_nearest(call, words, sentence):
    status, out, err = call(*words)
    assert (status, out) == (2, "")
    assert sentence in err


@pytest.mark.parametrize(
    "words",
    [["new", "my.toml"], ["new", "my.toml", "--frequency", "1 MHz", "--material", "PZT-8"], ["scenes", "twente"],
     ["schema", "my.json"], ["run", "twente", "twente-left"], ["view"], ["compare"]],
)  # fmt: skip
def test_words_too_many_and_too_few_are_answered_with_an_example(call, words):
    status, out, err = call(*words)
    assert (status, out) == (2, "")
    example = import_module(f"studies.command.{words[0]}").EXAMPLE
    assert err.endswith(f"; an example: {example} (see sawmotor {words[0]} --help)\n")


@pytest.mark.parametrize("name", COMMANDS)
def test_the_example_of_a_command_is_a_call_of_it(name):
    program, *words = shlex.split(import_module(f"studies.command.{name}").EXAMPLE.partition(" > ")[0])
    assert (program, words[0]) == ("sawmotor", name)
    arguments = parser().parse_args(words)
    assert arguments.call == name


@pytest.mark.parametrize(("text", "value"), [("5%", 0.05), ("0.5 %", 0.005), ("1e-3", 1e-3), (None, 1e-3)])
def test_a_tolerance_may_be_a_percentage(text, value):
    assert read_tolerance(text) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["0 %", "100%", "%", "five %", "-1 %"])
def test_a_tolerance_is_positive_and_below_one(text):
    with pytest.raises(SceneError, match=r"--tolerance must be"):
        read_tolerance(text)


def test_an_export_says_at_once_that_its_directory_cannot_be_written(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("studies.command.export.exported", None)
    (tmp_path / "mine").write_text("mine")
    assert main(["export", "twente", "--format", "uff", "--out", str(tmp_path / "mine")]) == 2
    assert "a file of that name exists" in capsys.readouterr().err


def test_a_fault_of_the_layout_names_file_line_key_and_unit(tmp_path, capsys):
    file = tmp_path / "motor.toml"
    file.write_text(shipped_scenes()["twente"].read_text().replace('"145 mm"', '"20 mm"'))
    (line,) = (k for k, text in enumerate(file.read_text().splitlines(), 1) if text == 'center = "20 mm"')
    assert main(["run", str(file)]) == 2
    said = f"{file}, line {line}: transducer.1.center must keep the fingers of 'right' off those of 'left'"
    assert said in capsys.readouterr().err


def test_a_directory_that_cannot_be_written_is_code_2(call, tmp_path):
    (tmp_path / "taken").write_text("")
    status, out, err = call(*CONTACT, "--out", "taken")
    assert (status, out) == (2, "")
    assert one_sentence(err)
    assert (tmp_path / "taken").read_text() == ""


def test_a_run_without_an_answer_says_why_with_code_3(call):
    words = ["--set", "slider.load=1", "--set", "slider.damping.tangential=0"]
    status, out, err = call(*CONTACT, *words, "--json")
    assert status == 3
    warning, refusal = without_balls(err).splitlines()  # the load, before the run; then why there is no answer
    assert warning.startswith("sawmotor: warning: slider.load, 1 N, exceeds the friction")
    assert refusal.startswith("sawmotor: ")
    assert "runaway" in json.loads(out)["points"][1]["status"]


def test_a_run_with_some_answers_is_code_1():
    answered, failed = {"relative_error": 1e-4, "status": "ok"}, {"status": "no answer: runaway: it has no bound"}
    given = {"scene": Scene.load("twente-contact"), "tolerance": 1e-3}
    assert Record(**given, points=(answered, answered)).exit_code == 0
    assert Record(**given, points=(answered, failed), shortfall="1 of 2 points").exit_code == 1
    assert Record(**given, points=(failed, failed), shortfall="2 of 2 points").exit_code == 3


def test_an_interrupted_run_leaves_nothing(call, monkeypatch, tmp_path):
    import studies.runs

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(studies.runs, "run", interrupted)
    status, _, err = call(*CONTACT)
    assert status == 130
    assert "interrupted" in err
    assert not list(tmp_path.iterdir())


def test_a_defect_leaves_its_traceback_in_a_file_that_is_named(call, monkeypatch, tmp_path):
    import studies.runs

    monkeypatch.delenv("SAWMOTOR_TRACEBACK", raising=False)
    monkeypatch.setattr(studies.runs, "run", lambda *_, **__: 1 / 0)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    status, _, err = call(*CONTACT)
    assert status == 70
    assert one_sentence(err)
    assert "ZeroDivisionError" in err
    (file,) = tmp_path.glob("sawmotor-defect-*.txt")
    assert err.rstrip().endswith(str(file))
    text = file.read_text()
    assert text.startswith("sawmotor run twente-contact")
    assert text.rstrip().endswith("ZeroDivisionError: division by zero")


def test_the_version_is_that_of_the_package(call):
    from importlib.metadata import version

    assert call("--version") == (0, f"sawmotor {version('sawmotor')}\n", "")


def test_a_check_of_one_voltage_speaks_of_one(call):
    assert "voltage     7 V\n" in call("check", "twente", "--voltage", "7")[1]


def test_scenes_and_check(call):
    status, out, _ = call("scenes")
    assert status == 0
    assert all(name in out for name in ("twente ", "twente-contact", "twente-left", "rayleigh", "lithium"))
    status, out, _ = call("check", "twente", "--set", "slider.mass=1e-4", "--voltage", "5:60:12")
    assert status == 0
    assert all(word in out for word in ("PZT-8", "0.1 g", "12 values", "left", "2.2 MHz"))


def test_the_wave_of_a_material(call):
    status, out, _ = call("wave", "LiNbO3 (Kovacs)", "--orientation", "128YX", "--json")
    answer = json.loads(out)
    assert status == 0
    assert answer["velocity_m_per_s"] == pytest.approx(3979, abs=1)  # materials.md
    assert 0.053 < answer["coupling_K2"] < 0.055
    assert "Kovacs" in answer["material"]["source"]
    again = json.loads(call("wave", "LiNbO3 (Kovacs)", "--orientation", "0,38,0", "--surface", "free", "--json")[1])
    assert again["velocity_m_per_s"] == answer["velocity_m_per_s"]
    other = ("--orientation", "0,-38,0", "--euler-convention", "sawsim", "--surface", "free", "--json")
    theirs = call("wave", "LiNbO3", *other)
    assert json.loads(theirs[1])["velocity_m_per_s"] == again["velocity_m_per_s"]
    assert "coupling_K2" not in json.loads(call("wave", "steel", "--json")[1])
    assert "retrograde" in call("wave", "PZT-8")[1]


def test_help_names_every_call(call):
    status, out, _ = call("--help")
    assert status == 0
    assert all(word in out for word in ("run", "wave", "study", "sweep", "view", "scenes", "check"))
    assert call()[0] == 0


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_prints_its_help(call, name):
    status, out, _ = call(name, "--help")
    assert status == 0
    assert out.startswith(f"usage: sawmotor {name}")


HEAVY = ("skfem", "numba", "pyvista", "matplotlib", "pint", "rich", "dask")
IMPORTS = """
import sys
{what}
print(sorted({{name.split('.')[0] for name in sys.modules}} & set({names!r})))
"""
RUN = """
import contextlib, io
from studies.__main__ import main
sys.argv = ["sawmotor", {words}]
with contextlib.redirect_stdout(io.StringIO()):
    assert main() == 0
"""


def imported(what, names=(*HEAVY, "numpy", "scipy", "meshio")):
    script = IMPORTS.format(what=what, names=names)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return eval(done.stdout.strip().splitlines()[-1])


def run_of(*words):
    return RUN.format(words=", ".join(map(repr, words)))


def test_importing_studies_imports_nothing_heavy():
    assert imported("import studies") == []
    assert imported("import studies.__main__, studies.command.parser; studies.command.parser.parser()") == []
    assert imported("import studies.solve.contact_at_level") == ["numpy"]


def test_a_contact_scene_imports_no_field_solver():
    found = imported(run_of("run", "twente-contact", "--set", "wave.normal_amplitude=3 nm", "--json"))
    assert set(found).isdisjoint({"skfem", "meshio", "pyvista", "matplotlib", "pint", "rich"})


def test_a_stator_scene_imports_no_contact_solver():
    found = imported(run_of("run", "rayleigh", "--json"))
    assert set(found).isdisjoint({"numba", "pyvista", "matplotlib", "pint", "scipy"})


def test_a_run_from_voltage_to_velocity_spares_scipy():
    # its import would take about a tenth of the run
    assert "scipy" not in imported(run_of("run", "twente", "--voltage", "70", "--json"))


def test_a_closed_pipe_is_no_traceback():
    script = f"{sys.executable} -m studies scenes | true"
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True)
    assert done.stderr == ""


@pytest.mark.parametrize("words", [[], ["--json"]])
def test_a_terminal_without_the_letters_gets_their_numbers(monkeypatch, tmp_path, words):
    monkeypatch.chdir(tmp_path)
    narrow = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", narrow)
    assert main([*CONTACT, "--set", "title=5 \u00b5m", *words, "--no-plot"]) == 0
    text = narrow.buffer.getvalue().decode("ascii")
    if words:
        assert json.loads(text)["title"] == "5 \u00b5m"
    else:
        assert text.startswith("5 \\xb5m")


def test_an_interrupt_of_the_first_imports_is_a_sentence(call, monkeypatch):
    original = builtins.__import__

    def interrupted(name, *arguments, **options):
        if name == "studies.refusal":
            raise KeyboardInterrupt
        return original(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", interrupted)
    status, out, err = call("scenes")
    monkeypatch.undo()
    assert (status, out) == (130, "")
    assert err == "sawmotor: interrupted, nothing was written\n"


@pytest.mark.parametrize(
    "call", [["run", "twente-contact"], ["sweep", "twente-contact", "--over", "slider.mass=1e-4:2e-4:2"]]
)
def test_an_empty_name_of_the_results_is_refused(call, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*call, "--out", ""]) == 2
    assert "--out must be the name of a directory or file, got ''" in capsys.readouterr().err
    assert not any(tmp_path.iterdir())


def test_a_page_that_cannot_be_rendered_is_a_defect_and_the_numbers_stay(call, monkeypatch, tmp_path):
    import studies.report.page

    monkeypatch.delenv("SAWMOTOR_TRACEBACK", raising=False)
    monkeypatch.setattr(studies.report.page, "report", lambda record: record.no_such_field)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    status, _, err = call(*CONTACT, "--no-plot", "--report", "--out", str(tmp_path / "run"))
    assert status == 70
    assert f"the numbers are in {tmp_path / 'run'}" in err
    assert (tmp_path / "run" / "run.json").is_file()
    assert not (tmp_path / "run" / "report.html").exists()
