"""``sawmotor new``: the file is the scene, its motor does what was asked for, and what cannot be is refused."""

import re
import tomllib

import numpy as np
import pytest

from studies import Scene, SceneError, run, sweep
from studies.__main__ import main
from studies.inverse.first_scene import ball_places, first_scene, hard_to_get
from studies.remarks.scene_warnings import scene_warnings
from studies.scene.quantity import si_value


@pytest.fixture(scope="module")
def ceramic():
    return first_scene("2.2 MHz", "PZT-8", speed="0.1 m/s")


def test_file_is_the_scene_and_every_rule_stands_beside_its_key(ceramic, tmp_path):
    file = tmp_path / "motor.toml"
    file.write_text(str(ceramic))
    assert Scene.load(file).to_table() == ceramic.scene.to_table()
    assert tomllib.loads(str(ceramic)) == ceramic.table
    for key, rule in ceramic.reasons.items():
        name = key.rpartition(".")[2]
        assert re.search(rf"^{name} = .*  # {re.escape(rule)}$", str(ceramic), re.MULTILINE), key


def test_the_file_says_what_was_wanted_and_how_the_voltage_follows_from_the_speed(ceramic):
    assert "# Wanted: 2.2 MHz on PZT-8, 0.1 m/s without a load.\n" in str(ceramic)
    assert "0.1 m/s is 0.5 of 2 pi f u_x, the speed of the wave's crests" in ceramic.reasons["drive.voltage"]


@pytest.mark.parametrize("material", ["127YX", "ST quartz"])
def test_an_unknown_cut_is_told_where_cuts_stand(material):
    with pytest.raises(SceneError, match='a cut stands behind its material, as in "LiNbO3 127YX"'):
        first_scene("10 MHz", material)


def test_sizes_by_hand(ceramic):
    # wavelength on PZT-8 at 2.2 MHz: 2181.9 m/s over it, 0.99178 mm; 10 pairs, 15 and 40 wavelengths beside them
    stator, (fingers,) = ceramic.table["stator"], ceramic.table["transducer"]
    assert (stator["thickness"], stator["width"], fingers["aperture"]) == ("4.96 mm", "32 mm", "20 mm")
    assert (fingers["center"], ceramic.table["slider"]["position"], stator["length"]) == (
        "19.8 mm",
        "64.5 mm",
        "129 mm",
    )


def test_motor_runs_at_the_wanted_speed(ceramic):
    volts = float(ceramic.reasons["drive.voltage"].split()[0])
    record = run(ceramic.scene.replace(drive={"voltage": volts}), tolerance=1e-2)
    assert record.exit_code == 0
    # the slider presses for half of the cycle at half of the crest's speed: a rule of thumb
    assert abs(record.velocity[0]) == pytest.approx(0.1, rel=0.3)
    # 0.1 m/s = half of omega r u_z, r = 0.671; the voltage is sized on the axis, 1 mm beside the first ball
    assert record.normal_amplitude[0] == pytest.approx(0.1 / (0.5 * 2 * 3.14159 * 2.2e6 * 0.671), rel=0.03)


def test_motor_has_about_the_wanted_thrust():
    motor = first_scene("10 MHz", "128YX", thrust="5 mN")
    volts = float(motor.reasons["drive.voltage"].split()[0])
    loads = {"slider.load": [0.0, 2.5e-3, 5.4e-3]}
    rows = sweep(motor.scene.replace(drive={"voltage": volts}), loads, tolerance=1e-2).to_dataframe()
    free, loaded, stalled = -rows["velocity_m_per_s"]
    assert free > loaded > 0.6 * free
    assert -0.2 * free < stalled < 0.2 * free
    assert len(motor.table["slider"]["contacts"]) > 3


def test_thrust_beyond_balls_is_that_of_pillars():
    motor = first_scene("10 MHz", "128YX", thrust="0.1 N")
    pillars = motor.table["slider"]["pillars"]
    # 0.1 N/(0.75 0.18) of preload on flat punches, 20 um 68 GPa 5 nm = 6.8 to 7.6 mN each: 98 to 109, in a square
    assert (pillars["rows"], pillars["columns"], pillars["diameter"]) == (10, 10, "20 um")
    # 0.4 of a wavelength of 0.3979 mm; a chip of (10 pitches)^2, 0.5 mm of silicon (2330 kg/m3)
    assert (pillars["pitch"], motor.table["slider"]["mass"]) == ("159 um", "0.00295 g")
    volts = float(motor.reasons["drive.voltage"].split()[0])
    driven = motor.scene.replace(drive={"voltage": volts})
    rows = sweep(driven, {"slider.load": [0.0, 0.1, 0.13]}, tolerance=1e-2).to_dataframe()
    free, wanted, beyond = -rows["velocity_m_per_s"]
    assert 0.1 * free < wanted < 0.3 * free
    assert not beyond > 0.0


def test_command_writes_a_new_file_only(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    call = ["new", "--frequency", "10 MHz", "--material", "128YX", "--out", "mine.toml"]
    assert main(call) == 0
    assert capsys.readouterr().out == "wrote mine.toml: sawmotor run mine.toml\n"
    assert main(["check", "mine.toml"]) == 0
    assert "warning" not in capsys.readouterr().err
    before = (tmp_path / "mine.toml").read_text()
    assert 'orientation = "128YX"' in before
    assert main(call) == 2
    assert capsys.readouterr().err.splitlines()[-1] == "sawmotor: --out 'mine.toml' exists already, and is not replaced"
    assert (tmp_path / "mine.toml").read_text() == before


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        # 3901.5 m/s: 152.5 wavelengths of 1 m at most, fingers of a quarter of a wavelength of 0.3 um at least
        (["--frequency", "1 kHz"], "--frequency must be at least 0.597 MHz on LiNbO3 (Kovacs), got 0.001 MHz"),
        (["--frequency", "100 GHz"], "--frequency must be at most 3320 MHz on LiNbO3 (Kovacs), got 100000 MHz"),
        (["--frequency", "10 MHz", "--speed", "-1"], "--speed must be positive, got '-1'"),
    ],
)
def test_what_cannot_be_made_is_refused(words, sentence, capsys):
    assert main(["new", "--material", "128YX", *words]) == 2
    assert capsys.readouterr().err.startswith(f"sawmotor: {sentence}")


def test_sizes_that_are_hard_to_get_are_said():
    usual, long = "longer than usual blocks and wafers of 150 mm", {"radius": "1 mm"}
    assert any(usual in line for line in hard_to_get(0.2, long))
    assert list(hard_to_get(0.149, long)) == []
    (line,) = hard_to_get(0.1, {"radius": "0.05 mm"})
    assert line.startswith("Balls of 50 um are smaller than bearing balls")


def test_balls_stand_about_the_centre_and_their_weight_is_the_preload(ceramic):
    slider = ceramic.scene.slider
    places = np.array(slider.offsets)[:, :2]
    assert places.shape == (3, 2)
    np.testing.assert_allclose(places.mean(axis=0), 0.0, atol=1e-5)
    # beside each other 3 radii, along the wave an odd number of quarters of 0.99178 mm
    np.testing.assert_allclose(places[:, 1], [-1.5e-3, 1.5e-3, 0.0])
    assert (places[2, 0] - places[0, 0]) / 0.99178e-3 == pytest.approx(13 / 4, abs=0.02)
    assert slider.preload_force == slider.mass * slider.gravity
    assert list(scene_warnings(ceramic.scene)) == []


@pytest.mark.parametrize("balls", [3, 4, 5, 7, 12, 29])
def test_places_of_balls(balls):
    places = np.array([[si_value("x", each, "m") for each in pair] for pair in ball_places(balls, 3, 2e-3, 1.5e-3)])
    apart = np.linalg.norm(places[:, None] - places, axis=-1) + np.eye(balls)
    assert (len(places), apart.min() >= 1.5e-3 * (1 - 1e-9)) == (balls, True)
    np.testing.assert_allclose(places.mean(axis=0), 0.0, atol=5e-5)
    assert np.ptp(places[:, 1]) <= 3e-3


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"frequency": "10"}, "--frequency must be a frequency, .* got '10', which has no unit"),
        ({"material": "steel"}, "--material must be piezoelectric, and steel is not in this orientation"),
        ({"material": "unobtainium"}, r"--material must be in the catalogue \(.*\), got 'unobtainium'"),
        ({"speed": "-1 m/s"}, "--speed must be positive"),
        ({"thrust": "5 V"}, "--thrust must be a force"),
        (
            {"thrust": "100 N"},
            r"--thrust must be at most 12 N here, got 100 N: \d+ x \d+ pillars .*, of which 100 x 100 fit on the beam",
        ),
    ],
)
def test_refusals(given, sentence):
    with pytest.raises(SceneError, match=sentence):
        first_scene(**{"frequency": "10 MHz", "material": "128YX"} | given)
