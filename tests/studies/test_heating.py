"""The study of heating: its files, the velocity when hot, and what it refuses."""

from dataclasses import replace

import numpy as np
import pytest

from studies import Scene
from studies.motor import heating
from studies.refusal import SceneError

MOTOR = {
    "stator": {"material": "PZT-8", "length": "20 mm", "thickness": "2 mm", "width": "12 mm", "ends": "absorbing",
               "diffraction": False, "cooling": {"ends_heat_stator": 1.0}},
    "transducer": [{"name": "t", "center": "5 mm", "finger_pairs": 4, "period": "1 mm", "metallisation": 0.5,
                    "aperture": "8 mm"}],
    "drive": {"frequency": "2.2 MHz", "transducer": "t", "voltage": [20.0, 60.0]},
    "slider": {"position": "14 mm", "contacts": 1, "radius": "1 mm", "mass": "0.089 g", "preload": "2 mN",
               "ball": "steel", "friction_coefficient": 0.2, "damping": {"normal": "0.5 N s/m"}},
}  # fmt: skip


def scene(**stator):
    return Scene.from_table("", MOTOR | {"stator": MOTOR["stator"] | stator})


@pytest.fixture(scope="module")
def warmed():
    return heating.run(scene(temperature_coefficient=-40e-6), tolerance=1e-2)


def test_the_temperature_of_the_file_is_that_of_the_picture(warmed):
    assert [each.name for each in warmed.panels] == ["temperature", "duty", "passband", "velocity"]
    assert all(each.confirmed for each in warmed.findings)
    head, *rows = heating.tables(warmed)["temperature.csv"].splitlines()
    names, numbers = head.split(","), np.array([list(map(float, row.split(","))) for row in rows])
    assert (names[0], names[-1], len(names)) == ("x_m", "steady_K", 8)
    data = warmed.panel("temperature").data
    for name, values in data["rise_K"].items():
        assert numbers[:, names.index(f"{name.replace(' ', '_')}_K")] == pytest.approx(values, rel=1e-12)
    after = numbers[:, 3:]
    assert (np.diff(after, axis=1) > 0.0).all()  # warmer at every later time, everywhere
    # of the slowest mode alone 1 - 1/e would be left after one time constant; the others are ahead of it
    assert 1 - np.exp(-1.0) < after[:, -2].mean() / after[:, -1].mean() < 0.66
    duty = warmed.panel("duty").data
    assert duty["rise_K"][-1] == pytest.approx(after[:, -1].max(), rel=1e-3)
    assert duty["limit_K"] == 130.0


def test_the_passband_falls_and_the_slider_slows_down_when_hot(warmed):
    band, speed = warmed.panel("passband").data, warmed.panel("velocity").data
    peaks = [band["frequency_Hz"][np.argmax(abs(band[key]))] for key in ("normal_m_per_V", "warm_m_per_V")]
    hottest = dict(warmed.answer)["velocity"]
    cold, hot = speed["velocity_m_per_s"].values()
    assert peaks[1] <= peaks[0]
    assert abs(band["warm_m_per_V"] - band["normal_m_per_V"]).max() > 1e-4 * abs(band["normal_m_per_V"]).max()
    assert cold[-1] > 0.0
    assert 0.0 < abs(hot[-1] / cold[-1] - 1.0) < 0.05
    assert "degC" in hottest


def test_times_need_a_heat_capacity_and_temperatures_a_conductivity():
    with pytest.raises(SceneError, match=r"stator.thickness must be a length: a half-space never becomes steady"):
        heating.run(scene(thickness="half-space"), tolerance=0.1)
    with pytest.raises(SceneError, match=r"stator.material needs a conductivity"):
        heating.run(scene(material="LiTaO3", orientation="YZ"), tolerance=0.1)
    unpowered = scene()
    with pytest.raises(SceneError, match=r"drive.voltage must have a level above 0"):
        heating.run(replace(unpowered, drive=replace(unpowered.drive, voltage=(0.0,))), tolerance=0.1)


def test_a_time_asked_of_a_solid_without_heat_capacity(tmp_path):
    import fem

    text = fem.catalogue_text("PZT-8").replace('name = "PZT-8"', 'name = "my ceramic"')
    path = tmp_path / "mine.toml"
    path.write_text("\n".join(line for line in text.splitlines() if not line.startswith("heat_capacity")))
    words = (
        r'stator.material.heat_capacity must be given: the solid "my ceramic" has none; its steady temperature needs'
    )
    with pytest.raises(SceneError, match=words):
        heating.run(scene(material=str(path)), times=(10.0,), tolerance=0.1)
    record = heating.run(scene(material=str(path)), tolerance=0.1)
    assert list(record.panel("temperature").data["rise_K"]) == ["steady"]
    assert "stator.temperature_coefficient is not given" in dict(record.answer)["effect"]
