"""The dispersion study: what it must find."""

import pytest

from studies.record.plots import saved
from studies.refusal import SceneError
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


def test_waves_of_layers_against_their_thickness(tmp_path):
    """layered.md, section 3: PZT-8 on silicon at 0.2 wavelengths."""
    record = dispersion.run("pzt-on-silicon", over={"thickness": "0.05:0.2:4"})
    assert [panel.name for panel in record.panels] == ["layers", "coupling"]
    rows = {(row["wave"], round(row["thickness_wavelengths"], 6)): row for row in record.panels[0].rows()}
    last = rows["Rayleigh", 0.2]
    assert last.velocity_m_per_s == pytest.approx(3013.5458307, rel=1e-9)
    assert last["shorted_surface_m_per_s"] == pytest.approx(2999.9018547, rel=1e-9)
    assert last["shorted_1_m_per_s"] == pytest.approx(3007.9173980, rel=1e-9)
    assert last["coupling_K2_surface"] == pytest.approx(0.00905, rel=1e-2)
    assert ("Sezawa", 0.1) in rows
    assert ("Sezawa", 0.05) not in rows
    answer = dict(record.answer)
    assert "begins to leak" in answer["Sezawa"]
    assert record.findings[0].confirmed
    for panel in record.panels:
        saved(tmp_path / f"{panel.name}.png", lambda ax, panel=panel: dispersion.figure(panel, ax))
        assert (tmp_path / f"{panel.name}.png").stat().st_size > 5000


def test_an_axis_that_is_no_thickness_is_refused():
    with pytest.raises(SceneError, match="must be thickness=START:STOP:N, in wavelengths, got"):
        dispersion.run("pzt-on-silicon", over={"stator.width": "1:2:3"})
    with pytest.raises(SceneError, match="must be absent without layers"):
        dispersion.run("rayleigh", over={"thickness": "0.1:0.2:3"})
