"""Passbands with several maxima, bases of few vectors, and other answers of fem.solve at their limits."""

from dataclasses import replace

import numpy as np
import pytest

from fem import Stator, Transducer, best_period, driven_wave, material, p_matrix, rotated
from fem.discretize.mesh_refinement import LEVELS
from fem.exceptions import ConvergenceError
from fem.reduce.basis import bases_of, decomposed
from fem.solve.best_frequency import surface_power
from fem.solve.p_matrix_from_field import matrix_difference
from fem.waveguide.port_fields import stator_cascade

ROW = Transducer(name="t", center=0.05, finger_pairs=2, period=1e-3, metallisation=0.5, aperture=0.02)
CERAMIC, QUARTZ = (rotated(material(name), cut) for name, cut in (("PZT-8", "Z"), ("quartz (Bechmann)", "ST-X")))


def power_at(stator, row, frequency, period):
    length = (row.finger_pairs + 4) * period
    own = replace(row, period=period, center=length / 2, aperture=1.0)
    alone = replace(stator, length=length, ends="absorbing")
    return surface_power(stator_cascade(alone, (own,), frequency=frequency, resolution=LEVELS[0]).solved())


@pytest.mark.parametrize(
    ("solid", "thickness", "frequency", "given"),
    [
        (CERAMIC, 0.3e-3, 2.2e6, {"pattern": "+---"}),
        (CERAMIC, 1e-3, 2.2e6, {"pattern": "+-------", "finger_pairs": 4}),
        (QUARTZ, 1e-3, 10e6, {"finger_pairs": 40}),
    ],
    ids=["one finger of four", "one of eight", "two plate modes"],
)
def test_the_highest_of_several_maxima(solid, thickness, frequency, given):
    """Against a scan of the whole passband (the last: 29.1 uS at 0.3208 mm, 23.9 at the other maximum)."""
    stator, row = Stator(solid=solid, length=0.1, thickness=thickness, ends="free"), replace(ROW, **given)
    found = best_period(stator, row, frequency)
    spread = found * (1 + np.linspace(-1.2, 1.2, 13) / row.finger_pairs)
    scan = spread[spread > 0.5 * found]
    best = power_at(stator, row, frequency, found)
    assert best >= 0.995 * max(power_at(stator, row, frequency, float(period)) for period in scan)
    if row.finger_pairs == 40:
        assert found == pytest.approx(0.3210e-3, rel=1e-3)


def test_a_basis_keeps_no_rounding():
    """Singular values down to 1e-12 of the largest: squares would leave 1e-8 of noise above them."""
    rng = np.random.default_rng(0)
    size, values = 40, 10.0 ** -np.arange(0, 20)
    left, right = (np.linalg.qr(rng.normal(size=(count, 20)))[0] for count in (size, 90))
    seen = (left * values) @ right.T * (1 + 0.5j)
    gap, finger = bases_of(decomposed((seen, seen), [np.arange(size)]), size, 3e-11)
    assert gap.shape == finger.shape == (size, 11)
    assert abs(left[:, :11] - gap @ (gap.T @ left[:, :11])).max() < 1e-4


@pytest.fixture(scope="module")
def found():
    stator = Stator(solid=CERAMIC, length=1.0, thickness=6e-4, ends="absorbing")
    return p_matrix(stator, ROW, frequency=2.2e6, tolerance=0.3)


def test_a_short_circuit_is_the_scattering_itself(found):
    np.testing.assert_array_equal(found.loaded(0), found.scattering)
    np.testing.assert_allclose(found.loaded(1e-9), found.scattering, atol=1e-9)
    assert abs(found.loaded(np.inf) - found.scattering).max() > 1e-2


@pytest.mark.parametrize("part", ["admittance", "excitation", "scattering"])
def test_any_part_of_a_p_matrix_decides_its_error(found, part):
    changed = replace(found, **{part: getattr(found, part) * 1.02})
    scale = abs(found.scattering).max() if part == "scattering" else 1.0
    assert matrix_difference(found, changed)[0] == pytest.approx(0.02 * scale, rel=1e-6)


def test_a_wave_that_is_longer_than_the_stator():
    """A quarter of a metre at 10 kHz: the standing-wave ratio is that of the whole stator.  At 1 Hz: refused."""
    stator = Stator(solid=CERAMIC, length=0.04, thickness=3e-3, ends="absorbing")
    row = replace(ROW, center=8e-3, finger_pairs=5)
    wave = driven_wave(stator, (row,), frequency=1e4, drive="t", tolerance=5e-2)
    x = np.linspace(0.0, stator.length, 401)
    expected = abs(wave.motion(x)[1])
    assert wave.phase_velocity / wave.frequency > stator.length
    assert wave.standing_wave_ratio(0.02) >= expected.max() / expected.min() > 1e9  # a node, to rounding
    with pytest.raises(ConvergenceError, match="far smaller than a wavelength, a higher frequency"):
        driven_wave(stator, (row,), frequency=1.0, drive="t", tolerance=1e-3)
