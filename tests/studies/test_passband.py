"""Studies of a passband: a short motor's admittance and response against single runs, definitions and the estimate."""

from dataclasses import replace

import numpy as np
import pytest

from studies.record.plots import saved
from studies.runs import run
from studies.solve import passband
from studies.stator import admittance, frequency_response
from studies.study_list import StudyRecord, judged
from tests.studies.settings import changed


@pytest.fixture(scope="module")
def chip():
    settings = [
        "stator.length=30 mm",
        "stator.thickness=2 mm",
        "transducer.0.center=7 mm",
        "transducer.0.period=0.98 mm",
        "transducer.0.finger_pairs=6",
        "slider.position=20 mm",
        "drive.voltage=60",
    ]
    return changed("twente-left", *settings)


def drawn(chosen, panel, tmp_path):
    """Labels of a panel's picture."""
    labels = []

    def draw(ax):
        chosen.figure(panel, ax)
        labels.extend([ax.get_xlabel(), ax.get_ylabel()])
        assert len(ax.lines) >= 2

    saved(tmp_path / "panel.png", draw)
    assert (tmp_path / "panel.png").stat().st_size > 5000
    return labels


@pytest.fixture(scope="module")
def electrical(chip):
    return admittance.run(chip, count=5, tolerance=3e-2)


def test_the_admittance_is_that_of_a_single_run(chip, electrical):
    data = electrical.panels[0].data
    at = float(data["frequency_Hz"][3])
    fixed = replace(passband.driven_model(chip).scene, slider=None)  # with the period of the scene's own frequency
    record = run(replace(fixed, drive=replace(fixed.drive, frequency=at)), tolerance=3e-2)
    found = data["conductance_S"][3] + 1j * data["susceptance_S"][3]
    assert found == pytest.approx(record.electrical["admittance_S"], rel=2e-2)


def test_the_findings_on_the_admittance_are_the_panel_s(electrical, tmp_path):
    data = electrical.panels[0].data
    smallest, ratio, edge, error = electrical.findings
    assert smallest.found == data["conductance_S"].min()
    assert ratio.found == data["conductance_S"].max() / data["estimated_conductance_S"].max()
    assert edge.found == pytest.approx(
        np.mean(data["susceptance_S"][[0, -1]] / data["capacitive_susceptance_S"][[0, -1]]), rel=1e-12
    )
    assert error.found == data["relative_error"]
    assert all(finding.confirmed for finding in electrical.findings)
    assert drawn(admittance, electrical.panels[0], tmp_path) == ["frequency (MHz)", "admittance (mS)"]


def test_the_range_is_three_bandwidths(chip):
    at = passband.frequencies(passband.driven_model(chip), 5)
    assert at[2] == pytest.approx(chip.frequency, rel=1e-12)
    assert at[-1] - at[0] == pytest.approx(3 * at[2] / 6, rel=1e-12)


def test_the_frequencies_resolve_the_ripple_of_waves_that_return():
    """Waves that run along the stator and back make a ripple of v / (2 L): four frequencies in each."""
    both, alone = (passband.driven_model(name) for name in ("twente", "twente-left"))
    assert (passband.waves_return(both.scene), passband.waves_return(alone.scene)) == (True, False)
    ripple = 2181.92 / (2 * both.stator.length)
    assert np.diff(passband.frequencies(both, None, 81)).max() <= ripple / 4
    assert len(passband.frequencies(alone, None, 81)) == 81


def test_what_does_not_apply_is_told_and_not_judged():
    away = judged("A statement.", "a number", 3.0, low=0.0, high=1.0, holds=None)
    assert away.confirmed is None
    assert str(away).endswith("between 0 and 1: not judged")
    assert StudyRecord(name="admittance", panels=(), findings=(away,), seconds=0.0).remark == ""


@pytest.fixture(scope="module")
def motion(chip):
    return frequency_response.run(chip, count=17, tolerance=3e-2)


def test_the_response_is_the_estimate_s_within_a_factor_of_two(motion):
    assert all(finding.confirmed for finding in motion.findings)
    width, delay = motion.findings[1:3]
    assert 0.7 < width.found < 1.0
    assert delay.found == pytest.approx(1.0, abs=0.05)


def test_the_response_is_drawn(motion, tmp_path):
    amplitude, delay = motion.panels
    labels = drawn(frequency_response, amplitude, tmp_path)
    assert labels == ["frequency (MHz)", "normal amplitude per volt, peak (nm/V)"]
    assert drawn(frequency_response, delay, tmp_path)[1] == "group delay (us)"
    data = amplitude.data
    section = np.interp(data["drive_frequency_Hz"], data["frequency_Hz"], abs(data["normal_m_per_V"]))
    assert data["finite_aperture_m_per_V"] == pytest.approx(motion.findings[-1].found * section, rel=0.15)


def test_half_power_of_a_known_lobe():
    """1 / (1 + x^2)^(1/2) falls to 1 / sqrt 2 at x = 1; at a range's end it is the end."""
    at = np.linspace(-3.0, 2.5, 2201)
    low, high = frequency_response.half_power_band(at, 1 / np.sqrt(1 + at**2))
    assert (low, high) == pytest.approx((-1.0, 1.0), rel=1e-5)
    cut = at[at < 0.5]
    assert frequency_response.half_power_band(cut, 1 / np.sqrt(1 + cut**2))[1] == cut[-1]


def test_the_range_is_about_the_drive_s_frequency_within_the_main_lobe(chip):
    model = passband.driven_model(chip)
    scene = model.scene
    middle = 2181.92 / scene.transducer[0].period  # v of PZT-8 with D_n = 0; the main lobe is 1/6 of it to either side
    for frequency, center in ((0.9 * middle, 0.9 * middle), (0.7 * middle, middle)):
        moved = model.with_blocks(drive=replace(scene.drive, frequency=frequency))
        assert passband.frequencies(moved, 5)[2] == pytest.approx(center, rel=5e-3)
