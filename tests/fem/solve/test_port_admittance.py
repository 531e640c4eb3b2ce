"""The admittance matrix of the ports: reciprocal, passive, the circuit's, the band's, and scikit-rf's S-parameters."""

import sys

import numpy as np
import pytest

from fem import ConvergenceError, Drive, PortAdmittance, driven_wave, port_admittance
from tests.fem.stators import FREQUENCY, comb, cut, plate

STATOR = plate(cut("PZT-8", "Z", quality=200.0), length=8.0, thickness=0.7, bottom="grounded")
ROW = (
    comb(STATOR, "a", 1.7, finger_pairs=2),
    comb(STATOR, "mirror", 4.0, pattern="++"),
    comb(STATOR, "b", 6.2, period=0.9),
)


@pytest.fixture(scope="module")
def one():
    return port_admittance(STATOR, ROW, frequency=FREQUENCY, tolerance=1e-2)


def test_it_is_reciprocal_and_passive(one):
    y = one.matrix
    assert one.names == ("a", "b")
    assert abs(y[0, 1] - y[1, 0]) < 1e-11 * abs(y[0, 1])
    assert np.linalg.eigvalsh((y + y.conj().T) / 2)[0] > 0
    assert 0 < one.relative_error <= 1e-2


def test_a_driven_stator_is_its_circuit(one):
    """Two sources behind an impedance: V = (1 + z Y)^-1 S, to the error of both."""
    sources, z = {"a": 1.0, "b": 0.5j}, 40.0 - 10.0j
    wave = driven_wave(STATOR, ROW, frequency=FREQUENCY, drive=Drive(sources=sources, impedance=z), tolerance=1e-2)
    voltages = np.linalg.solve(np.eye(2) + z * one.matrix, list(sources.values()))
    assert wave.circuit.voltages == pytest.approx(voltages, rel=2e-2)


def test_over_a_band_it_is_what_it_is_at_each_frequency(one):
    frequencies = np.linspace(0.985, 1.015, 4).reshape(2, 2) * FREQUENCY
    row = (ROW[0], ROW[2])
    band = port_admittance(STATOR, row, frequency=frequencies, tolerance=2e-2)
    assert band.matrix.shape == (2, 2, 2, 2)
    single = port_admittance(STATOR, row, frequency=frequencies[1, 0], tolerance=2e-3)
    size = abs(single.matrix).max()
    assert abs(band.matrix[1, 0] - single.matrix).max() < 2 * band.relative_error * size


def test_a_band_that_misses_the_tolerance_of_its_motion_may_have_admittances_that_meet_theirs(monkeypatch):
    """A quartz resonator with 80 fingers at 1e-2: the motion is known to 1.05e-2, the admittances to 1.4e-4."""
    module, at = sys.modules["fem.solve.port_admittance"], np.linspace(0.985, 1.015, 3) * FREQUENCY
    solved = module.frequency_band

    def missed(*arguments, **keywords):
        raise ConvergenceError("the motion misses", reached=solved(*arguments, **keywords))

    row = (ROW[0], ROW[2])
    expected = port_admittance(STATOR, row, frequency=at, tolerance=2e-2)
    monkeypatch.setattr(module, "frequency_band", missed)
    found = port_admittance(STATOR, row, frequency=at, tolerance=2e-2)
    np.testing.assert_array_equal(found.matrix, expected.matrix)
    assert found.relative_error == expected.relative_error <= 2e-2


def test_scattering_of_an_impedance_in_series():
    """S11 = Z / (Z + 2 Z0), S21 = 2 Z0 / (Z + 2 Z0) (Pozar, example 4.4); of a passive stator none exceeds 1."""
    z, z0 = 30.0 + 80.0j, 50.0
    series = PortAdmittance(
        names=("a", "b"), frequency=np.array(1e6), matrix=np.array([[1, -1], [-1, 1]]) / z, relative_error=0.0
    )
    expected = np.array([[z, 2 * z0], [2 * z0, z]]) / (z + 2 * z0)
    assert series.scattering(z0) == pytest.approx(expected, rel=1e-13)


def test_scattering_of_a_passive_stator_returns_no_power(one):
    assert np.linalg.svd(one.scattering(50.0), compute_uv=False)[0] < 1


def test_a_stator_without_ports_is_refused():
    with pytest.raises(ValueError, match="transducer must have two electrodes"):
        port_admittance(STATOR, (ROW[1],), frequency=FREQUENCY, tolerance=1e-2)
