"""The calibration counts what it says it counts; random scenes are scenes, and the same ones each time."""

from types import SimpleNamespace

import pytest

from studies.chain import run
from studies.evidence import calibration, random_scene
from studies.evidence.calibration import Checked
from studies.refusal import RunError


@pytest.fixture
def unlevelled(monkeypatch):
    monkeypatch.setattr(random_scene, "_levelled", lambda scene: scene)


def test_a_number_always_gives_the_same_scene(unlevelled):
    drawn = [random_scene.drawn(5, index) for index in range(12)]
    assert [random_scene.drawn(5, index) for index in range(12)] == drawn
    assert random_scene.drawn(6, 0) != drawn[0]
    assert {kind for _, kind, _ in drawn} == {"motor", "wave", "contact", "free"}
    assert all((scene.slider is not None) == (kind in ("motor", "contact")) for scene, kind, _ in drawn)


def test_levels_lie_about_the_threshold():
    index = next(n for n in range(99) if random_scene.np.random.default_rng([3, n]).uniform() > 0.75)
    scene, kind, _ = random_scene.drawn(3, index)
    assert kind == "contact"
    threshold = run(scene, tolerance=1e-3).summary["threshold_amplitude_m"]
    ratios = [level / threshold for level in scene.levels]
    assert ratios == pytest.approx(random_scene.LEVELS, rel=1e-9, abs=0)


def checked(index, true, estimate):
    return Checked(index=index, kind="motor", tolerance=1e-2, true=true, estimate=estimate)


def test_the_promise_is_kept_by_scenes_within_twice_their_estimate():
    rows = [checked(n, 1.9e-3, 1e-3) for n in range(95)] + [checked(n, 2.1e-3, 1e-3) for n in range(5)]
    promise, typical = calibration._findings(1, rows, [])
    assert promise.confirmed
    assert promise.found == 95
    assert "2.1" in promise.remark
    assert typical.found == pytest.approx(1 / 1.9, rel=1e-12, abs=0)
    promise, _ = calibration._findings(1, [*rows[1:], checked(0, 2.1e-3, 1e-3)], [])
    assert not promise.confirmed


def test_an_estimate_of_nothing_is_broken_by_any_error():
    assert checked(0, 1e-9, 0.0).ratio == float("inf")
    assert checked(0, 0.0, 0.0).ratio == 0.0


def record(velocity, estimate):
    point = {"velocity_m_per_s": velocity, "tangential_amplitude_m": 1e-9, "relative_error": estimate}
    return SimpleNamespace(points=(point,), wave={"frequency_Hz": 1e6})


def test_an_error_is_relative_to_the_larger_of_velocity_and_a_tenth_of_the_surface():
    speed = 2 * 3.141592653589793 * 1e6 * 1e-9 / 10
    ((true, estimate),) = calibration._pairs(record(1.1e-5, 0.2), record(1e-5, 0.0))
    assert (true, estimate) == (pytest.approx(1e-6 / speed, rel=1e-9, abs=0), 0.2)
    ((true, _),) = calibration._pairs(record(1.1, 0.2), record(1.0, 0.0))
    assert true == pytest.approx(0.1, rel=1e-9, abs=0)


def test_a_refusal_is_no_scene(monkeypatch):
    def refused(seed, index):
        raise RunError("never moves")

    monkeypatch.setattr(random_scene, "drawn", refused)
    assert calibration.calibrated(1, 2).refusal == "never moves"
