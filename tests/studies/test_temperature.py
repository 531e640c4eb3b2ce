"""The temperature of a stator: constants at it in a run, the command ``wave --temperature``, bad input."""

import json
import sys

import pytest

from studies import Scene, run
from studies.__main__ import main
from studies.model import fem_objects
from studies.refusal import SceneError

CHIP = {
    "stator": {"material": "LiNbO3 (Kovacs)", "orientation": "128YX", "length": "8 mm", "thickness": "half-space",
               "width": "6 mm", "ends": "absorbing", "diffraction": False},
    "transducer": [{"name": "t", "center": "3 mm", "finger_pairs": 3, "period": "auto", "metallisation": 0.5,
                    "aperture": "4 mm"}],
    "drive": {"frequency": "10 MHz", "transducer": "t", "voltage": 10.0},
}  # fmt: skip
CERAMIC = {"material": "PZT-8", "orientation": "Z", "mechanical_quality": 1000.0}


def scene(**stator):
    return Scene.from_table("", CHIP | {"stator": CHIP["stator"] | stator})


def test_a_warm_run_is_slower_by_the_coefficient_of_the_frequency_and_keeps_its_fingers():
    cold, warm = run(scene(), tolerance=1e-2), run(scene(temperature="75 degC"), tolerance=1e-2)
    change = warm.wave["phase_velocity_m_per_s"] / cold.wave["phase_velocity_m_per_s"] - 1.0
    assert change == pytest.approx(-77.15e-6 * 50.0, rel=3e-3)  # bare surface without charge, as the row of `wave`
    assert warm.scene.transducer == cold.scene.transducer
    assert warm.scene.stator.temperature == 75.0
    again = run(warm.scene, tolerance=1e-2)
    assert again.electrical == warm.electrical
    assert run(scene(temperature=25.0), tolerance=1e-2).electrical["admittance_S"] == pytest.approx(
        cold.electrical["admittance_S"], rel=1e-12
    )


def test_the_coefficient_of_the_frequency_alone_shifts_the_frequency():
    """Velocity times 1 + TCF (T - 20 degC); the constants that carry no velocity stay."""
    stator = {"temperature_coefficient": "-40e-6 1/K", **CERAMIC}
    solid = fem_objects.solid(scene(temperature=120.0, **stator).stator)
    cold = fem_objects.solid(scene(**stator).stator)
    assert (cold.density / solid.density) ** 0.5 == pytest.approx(1 - 40e-4, rel=1e-12)
    assert solid.stiffness == pytest.approx(cold.stiffness, rel=1e-15)
    assert solid.mechanical_quality == 1000.0


def test_coefficients_of_a_user_are_those_of_the_catalogue(tmp_path):
    from fem import catalogue_text

    path = tmp_path / "mine.toml"
    path.write_text(catalogue_text("quartz (Bechmann)"))
    own = fem_objects.solid(scene(material=str(path), orientation="ST-X", temperature=60.0).stator)
    known = fem_objects.solid(scene(material="quartz", orientation="ST-X", temperature=60.0).stator)
    assert own.stiffness == pytest.approx(known.stiffness, rel=1e-12)
    assert own.density == pytest.approx(known.density, rel=1e-12)
    written = scene(material=str(path), orientation="ST-X", temperature=60.0)
    assert Scene.from_table("", written.to_table()) == written


BAD = [
    ({"temperature": "313 K"}, "stator.temperature must be a temperature.*write it in degC; 293.15 K are 20 degC"),
    ({"temperature": -300.0}, "stator.temperature must be above -273.15 degC, got -300"),
    ({"temperature": "warm"}, 'stator.temperature must be a temperature in degC.* or "steady"'),
    ({"temperature": 60.0, **CERAMIC}, "stator.temperature needs coefficients, and PZT-8 has none: give stator.temp"),
    ({"temperature": 9000.0}, "stator.temperature.stiffness must be positive definite"),
    ({"temperature": 5e5, "temperature_coefficient": -1e-4, **CERAMIC}, "no frequency is left at 500000 degC"),
]


@pytest.mark.parametrize(("stator", "words"), BAD)
def test_temperatures_that_cannot_be(stator, words):
    from studies.model.resolve import resolved

    with pytest.raises(SceneError, match=words):
        resolved(scene(**stator))


MATERIAL = {
    "name": "mine", "density": 2649.0, "crystal_class": "32", "units": {"stiffness": "GPa"},
    "constants": {"c11": 86.74, "c12": 6.99, "c13": 11.91, "c14": -17.91, "c33": 107.2, "c44": 57.94, "e11": 0.171,
                  "e14": -0.0406, "eps11": 4.4, "eps33": 4.6},
}  # fmt: skip


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"temperature": {"first": {"c55": 1e-4}}}, "material.temperature.first.c55 must be one of c11, .*, c66"),
        ({"temperature": {"reference": 298.0}}, "temperature.reference must be above -273.15 and below 250 degC"),
        ({"temperature": {"expansion": [1e-5]}}, "temperature.expansion must be three numbers"),
        ({"temperature": {}, "velocity_coefficient": 1e-5}, "velocity_coefficient must be absent beside temperature"),
    ],
)
def test_coefficients_that_cannot_be(changed, words):
    with pytest.raises(SceneError, match=words):
        scene(material=MATERIAL | changed)


@pytest.fixture
def wave(monkeypatch, capsys):
    """Call ``sawmotor wave``; give exit code, stdout and stderr."""

    def called(*words):
        monkeypatch.setattr(sys, "argv", ["sawmotor", "wave", *words])
        status = main()
        return status, *capsys.readouterr()

    return called


def test_the_command_wave_prints_a_row_for_each_temperature(wave):
    status, out, _ = wave("LiNbO3", "YZ", "--temperature", "20:80:3", "--surface", "metallised", "--json")
    assert status == 0
    rows = json.loads(out)["temperatures"]
    assert [row["temperature_degC"] for row in rows] == [20.0, 50.0, 80.0]
    between = (rows[2]["velocity_m_per_s"] - rows[0]["velocity_m_per_s"]) / rows[1]["velocity_m_per_s"]
    assert between == pytest.approx(60.0 * rows[1]["TCV_per_K"], rel=2e-3)
    assert rows[1]["TCF_per_K"] == pytest.approx(rows[1]["TCV_per_K"] - rows[1]["expansion_per_K"], rel=1e-6)
    change = (rows[2]["TCF_per_K"] - rows[0]["TCF_per_K"]) / 60.0
    assert 2 * rows[1]["second_TCF_per_K2"] - rows[1]["TCF_per_K"] ** 2 == pytest.approx(change, rel=2e-2)
    text = wave("LiNbO3", "YZ", "--temperature", "25")[1]
    assert "TCF ppm/K" in text
    assert "Smith and Welsh" in text


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["PZT-8", "--temperature", "25"], "temperature needs coefficients, and PZT-8 has none"),
        (["quartz", "--temperature", "300 K"], "write it in degC"),
        (["quartz", "--temperature", "25", "--layer", "SiO2, 1 um"], "--layer must be absent with --temperature"),
        (["quartz", "ST-X", "--orientation", "Z"], "--orientation must be absent"),
    ],
)
def test_temperatures_that_the_command_refuses(arguments, words, wave):
    status, _, err = wave(*arguments)
    assert status != 0
    assert words in err
