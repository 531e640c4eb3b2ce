"""The dispersion study: what it must find."""

import pytest

from studies.record.plots import saved
from studies.stator import dispersion


@pytest.fixture(scope="module")
def record():
    return dispersion.run("rayleigh", count=4)


def test_the_section_guides_the_half_space_s_wave(record):
    (finding,) = record.findings
    assert finding.confirmed
    assert finding.found < 1e-5


def test_the_fastest_growing_wavenumber_is_the_surface_wave_s(record, tmp_path):
    data = record.panels[0].data
    top = data["frequency_Hz"] == data["line_Hz"][-1]
    slowest = data["wavenumber_rad_per_m"][top].max()
    assert slowest == pytest.approx(data["line_rad_per_m"][-1], rel=1e-5)
    assert data["surface_share"][top].max() == pytest.approx(1.0, rel=1e-12)
    for panel in record.panels:
        saved(tmp_path / f"{panel.name}.png", lambda ax, panel=panel: dispersion.figure(panel, ax))
        assert (tmp_path / f"{panel.name}.png").stat().st_size > 5000
