"""The dispersion study.  Limits of Rayleigh-Lamb in closed form; what the study must find."""

import numpy as np
import pytest

from studies import SceneError
from studies.report.figures import saved
from studies.stator import dispersion

LONGITUDINAL, SHEAR, THICKNESS = 5900.0, 3100.0, 0.7e-3
STRETCHING = 2 * SHEAR * np.sqrt(1 - (SHEAR / LONGITUDINAL) ** 2)


def roots(frequency):
    return dispersion.rayleigh_lamb(frequency, THICKNESS, LONGITUDINAL, SHEAR)


def test_long_waves_stretch_and_bend_a_thin_plate():
    frequency = 2e3
    omega = 2 * np.pi * frequency
    stretched, bent = roots(frequency)
    assert stretched == pytest.approx(omega / STRETCHING, rel=1e-5)
    assert bent == pytest.approx(np.sqrt(omega * np.sqrt(12) / (STRETCHING * THICKNESS)), rel=2e-3)


def test_short_waves_are_the_rayleigh_wave_of_either_face():
    """4 sqrt(1 - a) sqrt(1 - b) = (2 - b)^2."""
    frequency = 40e6
    found = roots(frequency)[-2:]
    b = (2 * np.pi * frequency / found / SHEAR) ** 2
    a = b * (SHEAR / LONGITUDINAL) ** 2
    np.testing.assert_allclose(4 * np.sqrt(1 - a) * np.sqrt(1 - b), (2 - b) ** 2, rtol=1e-7)


def test_modes_begin_where_bulk_waves_fit_between_the_faces():
    """Thickness resonances: odd and even halves of the shear and the longitudinal wavelength."""
    cutoffs = [SHEAR / (2 * THICKNESS), LONGITUDINAL / (2 * THICKNESS)]
    for cutoff in cutoffs[:1]:  # the longitudinal one's branch begins backwards
        assert len(roots(1.002 * cutoff)) == len(roots(0.998 * cutoff)) + 1


@pytest.fixture(scope="module")
def record():
    return dispersion.run("rayleigh", count=4)


def test_the_section_guides_the_half_space_s_wave_and_steel_obeys_rayleigh_lamb(record):
    assert [finding.confirmed for finding in record.findings] == [True] * 3
    assert record.findings[0].found < 1e-5
    assert record.findings[2].found < 5e-10


def test_the_fastest_growing_wavenumber_is_the_surface_wave_s(record, tmp_path):
    data = record.panels[0].data
    top = data["frequency_Hz"] == data["line_Hz"][-1]
    slowest = data["wavenumber_rad_per_m"][top].max()
    assert slowest == pytest.approx(data["line_rad_per_m"][-1], rel=1e-5)
    assert data["surface_share"][top].max() == pytest.approx(1.0, rel=1e-12)
    for panel in record.panels:
        saved(tmp_path / f"{panel.name}.png", lambda ax, panel=panel: dispersion.figure(panel, ax))
        assert (tmp_path / f"{panel.name}.png").stat().st_size > 5000


def test_without_a_section_there_is_nothing_to_ask():
    with pytest.raises(SceneError, match="stator is missing: a given wave has no section"):
        dispersion.run("twente-contact")
