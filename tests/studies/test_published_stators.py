"""The study of published stators: its cascade of fingers and strips against the whole stator."""

import numpy as np
import pytest

import fem
from studies.papers import published_stators as study


def test_fingers_and_strips_are_those_of_the_whole_stator():
    """Share, admittance and motion from two P-matrices against the field of both on one plate, bulk waves included."""
    row = study.p_matrix_of(None, 1.0, 6, 2e-2)
    strips = study.p_matrix_of("o", 1.03, 12, 2e-2)
    case = study.one_sided(row, strips)[0]
    solid = fem.rotated(fem.material("LiNbO3 (Kovacs)"), "128YX")
    at = 3e-3 + strips.length + case["distance_m"] + row.length / 2
    stator = fem.Stator(solid=solid, length=at + 6e-3, thickness=study.THICKNESS, ends="absorbing")
    shared = {"metallisation": 0.5, "aperture": study.APERTURE}
    both = (
        fem.Transducer(name="strips", center=3e-3 + strips.length / 2, finger_pairs=12, period=412e-6,
                       pattern="o" * 24, **shared),
        fem.Transducer(name="row", center=at, finger_pairs=6, period=400e-6, **shared),
    )  # fmt: skip
    place = at + 4e-3
    wave = fem.driven_wave(stator, both, frequency=study.FREQUENCY, drive="row", tolerance=2e-2, places=(place,))
    assert wave.power.right / wave.circuit.power == pytest.approx(case["share"], rel=3e-2)
    assert wave.admittance.real == pytest.approx(1 / case["load_ohm"], rel=3e-2)
    assert abs(wave.rayleigh_motion(place)[1]) == pytest.approx(case["motion_m_per_V"], rel=3e-2)
    assert case["share"] > 1.1 * case["alone"]
    assert case["gain"] == pytest.approx(case["share"] / case["alone"], rel=1e-12)


def test_a_conjugate_load_takes_the_share_and_leaves_the_reflection():
    """A wave from the right on fingers with strips, all three coupled again by hand, electrodes loaded with 1/Y*."""
    row, strips = study.p_matrix_of(None, 1.0, 6, 0.3), study.p_matrix_of("o", 1.03, 12, 0.3)
    case = study.one_sided(row, strips)[1]
    load = complex(1 / case["load_ohm"], -_susceptance(row, strips, case["distance_m"]))
    far = len(row.wavenumbers)
    loaded = row.loaded(1 / load)
    back = np.exp(-2j * row.wavenumbers[0] * case["distance_m"]) * strips.scattering[far, far]
    to_left = loaded[0, far] / (1 - loaded[0, 0] * back)
    reflected = loaded[far, far] + loaded[far, 0] * back * to_left
    ratio = (1 + abs(reflected)) / (1 - abs(reflected))
    assert ratio == pytest.approx(case["standing_wave_ratio"], rel=1e-4)
    current = row.detection[far] + row.detection[0] * back * to_left  # per incoming amplitude, before its own voltage
    voltage = -current / (row.admittance + load)
    assert abs(voltage) ** 2 * load.real == pytest.approx(case["share"], rel=1e-3)


def _susceptance(row, strips, distance):
    far = len(row.wavenumbers)
    back = np.exp(-2j * row.wavenumbers[0] * distance) * strips.scattering[far, far]
    arriving = back * row.excitation[0] / (1 - row.scattering[0, 0] * back)
    return (row.admittance + row.detection[0] * arriving).imag


def test_the_pressed_plate_moves_as_stated_at_its_largest():
    """The driven wave of the plate integrated along the contact, with the stiffness that the study states."""
    finding = study.pressed_plate([2.6e-9, 5.2e-9])
    chip = fem.rotated(fem.material("LiNbO3 (Kovacs)"), "128YX")
    plate = fem.rotated(fem.material("sapphire"), "Z")
    k = [2 * np.pi * study.FREQUENCY / fem.rayleigh(each).velocity for each in (chip, plate)]
    x = np.linspace(0, 3e-3, 60001)
    pulled = fem.wave_compliance(plate) * finding.found * 5.2e-9 * np.exp(-1j * (k[0] - k[1]) * x)
    grown = np.concatenate([[0], np.cumsum((pulled[1:] + pulled[:-1]) / 2) * (x[1] - x[0])])
    assert abs(grown).max() == pytest.approx(4.7e-9, rel=1e-4)
    assert finding.confirmed is None
