"""The study of the cells: its findings hold, its Bloch waves have the stop bands that it names."""

import numpy as np
import pytest


@pytest.fixture(scope="module")
def done(studied):
    return studied("cell_parameters")


def test_all_is_as_expected(done):
    assert [finding["confirmed"] for finding in done.record["findings"]] == [True] * 5


def test_the_wave_decays_in_its_stop_band_and_nowhere_else(done):
    (data,) = done.record["panels"].values()
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


def test_it_is_drawn(done):
    assert (done.folder / "stop_bands.png").stat().st_size > 10_000
