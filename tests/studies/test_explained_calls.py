"""``--explain`` of the commands of many runs: their numbers, and that nothing is computed."""

import pytest

from studies import Scene
from studies.__main__ import main
from studies.record import Record
from studies.record.point import Point


@pytest.fixture
def said(monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)

    def computed(*_, **__):
        pytest.fail("something was computed")

    for solver in ("fem.rayleigh", "fem.layered_waves", "fem.driven_wave", "fem.frequency_band", "contact.steady"):
        monkeypatch.setattr(solver, computed)

    def call(*words):
        assert main([*words, "--explain"]) == 0
        assert not (tmp_path / "results").exists()
        return capsys.readouterr().out

    return call


def entries(text):
    """Return the labelled lines before the plan of one run."""
    head = text.partition("one run of it:")[0].splitlines()
    return {line[:16].strip(): line[16:] for line in head if line[:16].strip()}


def test_sweep_counts_points_and_stators(said):
    axes = ["--over", "slider.preload=1 mN:3 mN:3", "--over", "stator.thickness=5 mm:3 mm:4"]
    text = said("sweep", "twente", "--voltage", "20,40", *axes)
    found = entries(text)
    assert found["points"] == "24: slider.preload (3) x stator.thickness (4) x drive.voltage (2)"
    assert found["stators"] == "4, one for each value of stator.thickness"
    assert "two discretisations" in text
    alone = entries(said("sweep", "twente", "--voltage", "20,40", *axes[:2]))
    assert alone["stators"] == "1"
    seconds = [float(each["expected time"].split()[0]) for each in (found, alone)]
    assert seconds[0] == pytest.approx(4 * seconds[1], rel=0.1)


def test_searches_say_which_numbers_solve_the_stator_again(said, tmp_path):
    over = ["--over", "slider.preload=1 mN:3 mN", "transducer.0.finger_pairs=4:12"]
    found = entries(said("design", "twente", "--maximise", "velocity", *over))
    assert found["evaluations"].startswith("120 in each search")
    assert found["stator"] == "solved at each evaluation, for transducer.0.finger_pairs"
    assert entries(said("design", "twente", "--maximise", "velocity", *over[:2]))["stator"] == "solved once"
    (tmp_path / "v.csv").write_text("voltage_V,velocity_m_per_s\n20,-0.02\n40,-0.05\n")
    fitted = entries(said("fit", "twente", "--data", "v.csv", "--free", "slider.friction_coefficient=0.05:0.2"))
    assert fitted["varied"] == "slider.friction_coefficient"
    assert fitted["evaluations"].startswith("of 2 measured values, 2 or more")
    assert fitted["stator"] == "solved once"
    contact = entries(said("fit", "twente-contact", "--data", "v.csv", "--free", "slider.mass=1e-4:1e-3"))
    assert contact["stator"] == "none"


@pytest.fixture
def run_folder(tmp_path):
    """A run on a stator as its directory, without its field."""
    scene = Scene.load("twente").replace(drive={"voltage": [20.0]})
    point = Point(voltage_V=20.0, velocity_m_per_s=-0.02, relative_error=1e-3, tangential_amplitude_m=1e-9)
    folder = tmp_path / "kept"
    Record(scene=scene, tolerance=1e-3, points=(point,), seconds={"total": 1.0}).save(folder)
    return str(folder)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("check", "twente"), {"checks": "keys, units"}),
        (("check", "twente", "--set", "transducer.0.period=auto"), {"searches": "1, for the period"}),
        (("new", "--frequency", "2.2 MHz", "--material", "PZT-8"), {"sizes": "a motor of 2.2 MHz on PZT-8"}),
        (("compare", "RUN", "RUN"), {"solves": "nothing"}),
        (("wave", "LiNbO3", "128YX"), {"half-space": "LiNbO3, without a mesh"}),
        (("wave", "LiNbO3", "128YX", "--temperature", "20:80:7"), {"temperatures": "7, a wave"}),
        (("wave", "Si", "--layer", "SiO2, 1 um", "--layer", "AlN, 0.2 lambda"), {"layers": "SiO2, 1 um; AlN"}),
        (("wave", "PZT-8", "--plot", "axes.png"), {"picture": "the crystal axes"}),
        (
            ("view", "RUN", "--screenshot", "wave.png"),
            {"shows": "field", "stator": "solved again", "files": "wave.png"},
        ),
        (("view", "RUN", "--show", "contact"), {"contact": "followed through one cycle"}),
        (("export", "twente", "--format", "gds"), {"contents": "layout of the transducers"}),
        (("export", "twente", "--format", "fmu"), {"contents": "stator over a band"}),
        (("export", "twente", "--format", "csv", "--scan", "x"), {"contents": "motion at the surface"}),
        (("export", "twente", "--format", "touchstone"), {"contents": "admittances"}),
    ],
)
def test_every_command_that_computes_explains_itself(words, expected, said, run_folder):
    text = said(*(run_folder if word == "RUN" else word for word in words))
    assert text.startswith(f"sawmotor {words[0]}: nothing has been computed\n")
    found = entries(text)
    assert float(found["expected time"].split()[0]) > 0.0
    assert found["expected time"].endswith("within a factor of 3")
    for name, beginning in expected.items():
        assert found[name].startswith(beginning)


def test_a_motor_for_simulators_takes_longer_than_a_scan_and_a_scan_longer_than_a_mask(said):
    formats = [("fmu",), ("csv", "--scan", "x"), ("gds",)]
    found = [entries(said("export", "twente", "--format", *words))["expected time"] for words in formats]
    times = [float(each.split()[0]) * (60.0 if each.split()[1] == "min" else 1.0) for each in found]
    assert times[0] > times[1] > times[2]


def test_an_explained_wave_refuses_what_the_wave_would(capsys):
    for words, rule in (
        (("PZT-9",), "material must be in the catalogue"),
        (("Si", "--layer", "SiO2"), "--layer must be"),
        (("Si", "--temperature", "20:x:2"), "--temperature"),
        (("Si", "--temperature", "20", "--plot", "x.png"), "--plot must be absent with --temperature"),
    ):
        assert main(["wave", *words, "--explain"]) == 2
        assert rule in capsys.readouterr().err


def test_datasheet_and_study_tell_their_contents(said):
    assert "load lines" in entries(said("datasheet", "twente"))["contents"]
    text = said("study", "stroke", "twente")
    assert "Fresnel fringes" in text
    assert "within a factor of 3" in text
