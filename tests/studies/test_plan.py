"""What ``--explain`` says beside what the run then does: sizes exact, time and memory within the factors it states."""

import json
import subprocess
import sys

import pytest

import fem
from studies.__main__ import main
from studies.report.explanation import COMPILE, MEMORY_WITHIN, TIME_WITHIN, explanation, plan
from studies.runs import run
from studies.scene import Scene, shipped_scenes
from tests.studies.settings import changed

TWO = 'drive.voltage=["10 V", "20 V"]'
WAVE = {"wave": {"frequency": "2.2 MHz", "normal_amplitude": ["5 nm", "10 nm"], "tangential_ratio": 0.67}}
BEAT = [{}, {"direction": 90, "frequency": "2.3 MHz"}]
SLIDER = {
    "radius": "1 mm", "mass": "0.089 g", "contacts": 1, "preload": "0.87309 mN", "friction_coefficient": 0.08,
    "effective_modulus": "64 GPa", "tangential_modulus": "12 GPa",
}  # fmt: skip
AMPLITUDES = 'wave.normal_amplitude=["2 nm", "5 nm"]'
SCENES = {
    "contact": ("twente-contact", 1e-3),
    "free wave": ("rayleigh", 1e-3),
    "stator": ("twente-left", 1e-3, TWO),
    "twente": ("twente", 1e-3),
    "twente finely": ("twente", 1e-5),
    "niobate": ("lithium-niobate-yz", 1e-3),
    "free wave finely": ("rayleigh", 1e-6),
    "coarsely": ("twente", 1e-2, TWO),
    "free ends": ("twente", 1e-3, TWO, "stator.ends=free"),
    "clamped ends": ("twente-left", 1e-3, TWO, "stator.ends=clamped"),
    "half-space": ("twente", 1e-3, TWO, "stator.thickness=half-space"),
    "thick": ("twente", 1e-3, TWO, "stator.thickness=10 mm"),
    "vacuum": ("twente", 1e-3, TWO, "stator.above=vacuum"),
    "poled along x": ("twente-left", 1e-3, TWO, "stator.orientation=X"),
    "narrow fingers": ("twente-left", 1e-3, TWO, "transducer.0.metallisation=0.3", "transducer.0.finger_pairs=14"),
    "lossless": ("lithium-niobate-yz", 1e-3, TWO, "stator.bottom=free"),
    "no slider": ("twente-left", 1e-3, TWO, "-slider"),
    "centre": ("twente-left", 1e-3, TWO, "transducer.0.period=0.98 mm", "drive.frequency=center"),
    "burst": ("twente-left", 1e-3, TWO, "drive.burst=0.03"),
    "short burst": ("twente-contact", 1e-3, AMPLITUDES, "wave.burst=1e-3"),
    "six grooves": ("reflector", 1e-3),
    "a groove finely": ("reflector", 1e-6, 'piece.0.position="26 mm"'),
    "long burst": ("twente-contact", 1e-3, AMPLITUDES, "wave.burst=0.03"),
}  # fmt: skip


@pytest.fixture(scope="module")
def compiled():
    """Have the kernels of the contact and the modules of Python on disk, which a plan does not count.

    The burst of a stator needs kernels of the growing wave, which a burst of a prescribed wave does not.
    """
    for name, tolerance, *settings in (SCENES[key] for key in ("contact", "short burst", "long burst", "burst")):
        words = [sys.executable, "-m", "tests.studies.predictions", name, str(tolerance), *settings]
        subprocess.run(words, capture_output=True, check=True)


@pytest.mark.slow
@pytest.mark.parametrize("words", SCENES.values(), ids=SCENES)
def test_a_plan_is_what_the_run_costs(words, compiled):
    """In a process of its own: sizes exactly, CPU time and memory within the factors."""
    name, tolerance, *settings = words
    command = [sys.executable, "-m", "tests.studies.predictions", name, str(tolerance), *settings]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    used, planned = json.loads(done.stdout), plan(changed(name, *settings), tolerance=tolerance)
    slowness = used["seconds"] / planned["expected"]["seconds"]
    assert 1 / TIME_WITHIN < slowness < TIME_WITHIN
    assert 1 / MEMORY_WITHIN < used["bytes"] / planned["expected"]["bytes"] < MEMORY_WITHIN
    # only the run knows whether the beam is good enough
    assert list(planned["left_out"]) == [each for each in used["left_out"] if "the beam's own error" not in each]
    if used["unknowns"] is not None:
        levels = [level for part in planned["parts"] for level in part.get("levels", ())]
        at_its_order = [level["unknowns"] for level in levels if level["order"] == used["order"]]
        assert at_its_order in ([], [used["unknowns"]])


@pytest.mark.parametrize("name", shipped_scenes())
def test_every_shipped_scene_is_explained(name):
    planned = plan(Scene.load(name), tolerance=1e-3)
    text = explanation(planned)
    assert all(word in text for word in ("expected time", "expected memory", "left out", "nothing has been"))
    assert json.loads(json.dumps(planned, allow_nan=False))["expected"]["seconds"] > 0
    assert max(map(len, text.splitlines())) <= 140


def test_levels_are_those_that_the_run_solves():
    scene = changed("twente-left", 'drive.voltage=["9 V"]', "-slider")
    said = []
    record = run(scene, tolerance=1e-2, progress=said.append)
    solved = [text for text in said if text.startswith("stator, order")]
    planned = plan(scene, tolerance=1e-2)
    (part,) = planned["parts"]
    assert solved == [
        f"stator, {fem.Resolution(order=each['order'], edge_layers=each['edge_layers']).name}"
        for each in part["levels"]
    ]
    assert record.surface_wave.unknowns == part["levels"][-1]["unknowns"]
    assert planned["left_out"] == record.left_out


@pytest.mark.parametrize("name", ["twente-contact", "rayleigh"])
def test_what_a_plan_leaves_out_is_what_the_run_leaves_out(name):
    scene = Scene.load(name)
    assert plan(scene, tolerance=1e-2)["left_out"] == run(scene, tolerance=1e-2).left_out


def test_more_asked_for_costs_more():
    scene = changed("twente-left", TWO)
    plans = [plan(scene, tolerance=tolerance)["expected"] for tolerance in (1e-2, 1e-4, 1e-6)]
    assert plans[0]["bytes"] < plans[1]["bytes"] < plans[2]["bytes"]
    assert plans[0]["seconds"] < plans[1]["seconds"] < plans[2]["seconds"]
    burst = plan(changed("twente-left", TWO, "drive.burst=0.01"), tolerance=1e-2)
    assert burst["expected"]["seconds"] > plans[0]["seconds"]
    assert [part["name"] for part in burst["parts"]] == ["stator", "beam", "ring-up", "contact"]


def test_a_level_in_the_plane_costs_more_than_one_along_x_and_most_with_a_beat():
    """The plan of `twente-planar` said 2 s within a factor of 3, and its run took 17 s."""
    along, planar, beating = (
        plan(Scene.from_table("", WAVE | {"slider": SLIDER | {"freedom": freedom}} | wave), tolerance=1e-3)
        for freedom, wave in (("x", {}), ("xy", {}), ("xy", {"wave": WAVE["wave"] | {"sources": BEAT}}))
    )
    costs = [each["expected"]["seconds"] for each in (along, planar, beating)]
    assert costs[1] > costs[0] + 1.0
    assert costs[2] > costs[1] + 3.0


def test_kernels_that_are_not_there_are_counted(monkeypatch, tmp_path):
    import contact.jit.compiled

    monkeypatch.delenv("NUMBA_DISABLE_JIT", raising=False)
    scene = changed("twente-contact")
    folder = tmp_path / "kernels"
    folder.mkdir()
    monkeypatch.setattr(contact.jit.compiled, "cache_folder", lambda: str(folder))
    monkeypatch.setattr(contact.jit.compiled, "cache_folders", lambda: (str(folder),))
    cold = plan(scene, tolerance=1e-3)
    assert any("compiled first" in fact for fact in cold["parts"][0]["facts"])
    (folder / "cycle-turn-9.o").write_bytes(b"")
    warm = plan(scene, tolerance=1e-3)
    assert not any("compiled first" in fact for fact in warm["parts"][0]["facts"])
    assert cold["expected"]["seconds"] == pytest.approx(warm["expected"]["seconds"] + COMPILE, rel=1e-12, abs=0)


@pytest.mark.parametrize(("levels", "said"), [(1000, None), (30_000, "about 10 minutes"), (400_000, "about 2.2 hours")])
def test_a_run_of_more_than_a_minute_is_said_before_it_begins(levels, said):
    from studies.report.explanation import expected_seconds, long_wait

    chosen = Scene.load("twente-contact").replace(wave={"normal_amplitude": f"1 nm:20 nm:{levels}"})
    sentences = long_wait(expected_seconds(chosen, tolerance=1e-3))
    assert bool(sentences) == (said is not None)
    assert said is None or said in sentences[0]


@pytest.mark.parametrize(
    ("name", "band", "said"), [("force_response", "1.9:2.5:401", True), ("network", "1:3:2", False)]
)
def test_a_study_over_a_band_announces_its_time(name, band, said, monkeypatch, capsys, tmp_path):
    """Two forces at each frequency, with the stator's solution and its beam; an interpolated band is cheap."""
    from studies import study_list
    from studies.refusal import RunError

    def refused(*given, **options):
        raise RunError("here the study would begin")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(study_list, "run_study", refused)
    assert main(["study", name, "--band", band]) == 3
    one = plan(Scene.load("twente").replace(slider=None), tolerance=1e-3)["expected"]["stator_seconds"]
    minutes = round((5.0 + 2 * 402 * one) / 60.0)
    error = capsys.readouterr().err
    assert ("expected time" in error) == said
    assert not said or f"expected time: about {minutes} minutes, within a factor of 3" in error
