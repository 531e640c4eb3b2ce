"""A stator at its own steady temperature: what its powers hold there, the branches, the folds, what is refused."""

from dataclasses import replace

import pytest

from studies import Scene, run
from studies.__main__ import main
from studies.model.model import Model
from studies.model.resolve import build, resolved
from studies.refusal import RunError, SceneError
from studies.scene.stator_keys import Cooling
from studies.scene.toml import document
from studies.solve.steady_temperature import steady_temperature

PLATE = {
    "stator": {"material": "PZT-8", "length": "12 mm", "thickness": "1 mm", "width": "12 mm", "diffraction": False,
               "temperature": "steady", "temperature_coefficient": -50e-6, "mechanical_quality": 400.0},
    "transducer": [{"name": "t", "center": "3 mm", "finger_pairs": 3, "period": "1 mm", "metallisation": 0.5,
                    "aperture": "8 mm"}],
    "drive": {"frequency": "2.2 MHz", "transducer": "t"},
}  # fmt: skip


def scene(voltage, ends, drive=(), **stator):
    table = PLATE | {"stator": PLATE["stator"] | {"ends": ends} | stator}
    return Scene.from_table("", table | {"drive": PLATE["drive"] | {"voltage": voltage} | dict(drive)})


def at(scene, temperature):
    return replace(scene, stator=replace(scene.stator, temperature=temperature))


@pytest.mark.parametrize("duty", [None, 0.25])
def test_between_absorbing_ends_the_fingers_are_as_warm_as_the_run(duty):
    cooled = {"cooling": {"ends_heat_stator": 1.0}}
    record = run(scene(60.0, "absorbing", {} if duty is None else {"duty": duty}, **cooled), tolerance=1e-2)
    rise = record.heat.fingers_rise_K
    assert rise > (20.0 if duty is None else 5.0)
    assert record.scene.stator.temperature - 20.0 == pytest.approx(rise, rel=1e-3)
    assert record.heat.steady_temperature_degC == record.scene.stator.temperature
    assert (record.heat.branch, record.heat.fold_frequencies_Hz) == ("only", None)
    assert "solved at its own steady temperature of" in str(record)
    assert run(record.scene, tolerance=1e-2).electrical == record.electrical


@pytest.fixture(scope="module")
def beyond():
    """A free-ended plate beyond its fold, at a frequency between the two folds of its first resonance."""
    reached = steady_temperature(build(scene(16.0, "free")), 1e-2)
    low, high = reached.folds[:2]
    middle = {"frequency": 0.5 * (low + high)}
    return low, high, scene(16.0, "free", middle)


def test_two_states_between_the_folds_hold_their_temperatures(beyond):
    """Each state by a run with the constants at its temperature, which knows nothing of the sampled response."""
    _, _, driven = beyond
    record = run(driven, tolerance=1e-2)
    block = record.heat
    assert block.foldover_number > 1.54
    assert block.branch == "cold"
    assert record.scene.stator.temperature - 20.0 == pytest.approx(block.mean_rise_K, rel=1e-3)
    (hot,) = block.other_temperatures_degC
    warmest = run(at(driven, hot), tolerance=1e-2).heat
    assert hot - 20.0 == pytest.approx(warmest.mean_rise_K, rel=2e-2)
    assert hot > record.scene.stator.temperature + 10.0
    assert "is stable too; folds at" in str(record)
    # the cold state is the first that a warming stator meets: below it the heat holds more than it is warm
    for share in (0.3, 0.9):
        rise = share * block.mean_rise_K
        assert run(at(driven, 20.0 + rise), tolerance=1e-2).heat.mean_rise_K > rise


def test_beyond_the_folds_there_is_one_state(beyond):
    low, high, driven = beyond
    width = high - low
    for frequency in (low - 0.3 * width, high + 0.3 * width):
        there = replace(driven, drive=replace(driven.drive, frequency=frequency))
        assert steady_temperature(build(there), 1e-2).others == ()


def test_at_rest_the_temperature_is_the_ambient_one():
    found = steady_temperature(build(scene(0.0, "absorbing", cooling=Cooling(ambient=31.0).to_table())), 1e-2)
    assert (found.temperature, found.residual) == (31.0, 0.0)


BAD = [
    ({"thickness": "half-space"}, {}, 'of "steady" needs a plate: a half-space never becomes steady'),
    ({}, {"burst": "1 ms"}, 'of "steady" needs drive.duty beside drive.burst'),
    ({"temperature_coefficient": None}, {}, "needs coefficients, and PZT-8 has none"),
    ({"material": "silicon (cubic)"}, {}, "needs a conductivity, and silicon"),
]


@pytest.mark.parametrize(("stator", "drive", "words"), BAD)
def test_a_steady_temperature_that_cannot_be(stator, drive, words):
    table = scene(10.0, "absorbing", drive).to_table()
    table["stator"] = {key: value for key, value in (table["stator"] | stator).items() if value is not None}
    with pytest.raises(SceneError, match=words):
        resolved(Scene.from_table("", table))


def test_too_much_heat_has_no_steady_temperature():
    with pytest.raises(RunError, match="there is no steady temperature up to 300 degC: lower the voltage"):
        run(scene(900.0, "free"), tolerance=1e-2)


def test_the_response_is_known_up_to_the_curie_temperature():
    """Resonances much narrower than the frequency falls by 280 K: 1.4 %, 40 widths."""
    found = steady_temperature(build(scene(1.0, "free", mechanical_quality=3000.0)), 1e-2)
    assert found.residual <= 1e-3 * max(found.temperature - 20.0, 1.0)


def test_other_answers_ask_for_a_number():

    with pytest.raises(SceneError, match=r"must be a number here: .steady. is found by sawmotor run"):
        _ = Model(scene(10.0, "absorbing")).stator


def test_the_command_runs_and_explains_a_stator_at_its_steady_temperature(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    written = document(scene(60.0, "absorbing", cooling={"ends_heat_stator": 1.0}).to_table())
    (tmp_path / "warm.toml").write_text(written)
    assert main(["run", "warm.toml", "--tolerance", "1e-2", "--no-plot"]) == 0
    assert "solved at its own steady temperature of" in capsys.readouterr().out
    assert main(["run", "warm.toml", "--explain"]) == 0
    motor = Scene.load("twente").replace(stator={"temperature": "steady", "temperature_coefficient": 17e-6})
    (tmp_path / "motor.toml").write_text(document(motor.to_table()))
    assert main(["check", "motor.toml"]) == 0
