"""A transducer's response to the finite aperture of its own charges."""

import numpy as np
import pytest
from scipy.special import hankel2

from fem.beam.charges import electrode_charges
from fem.beam.own_aperture import _between_mirrors, mode_change, static_change
from fem.beam.reception import aperture_coupling, with_apertures
from fem.condense.transducer import finger_ports
from tests.fem.stators import comb, cut, plate, solution

APERTURE = 4e-3
NODES, WEIGHTS = np.polynomial.legendre.leggauss(200)


def over_the_aperture(function) -> complex:
    """Mean over two apertures of a function of the distance across, graded towards 0."""
    t = (NODES + 1) / 2
    y = APERTURE * t**3
    return complex(np.sum(WEIGHTS * 3 * APERTURE * t**2 * (1 - y / APERTURE) * function(y)))


@pytest.mark.parametrize("k", [6300 - 1e-9j, 6300 - 30j, -5000 - 3j, -4000j, 3000 - 3000j])
def test_a_mode_is_a_double_integral_of_a_hankel_function(k):
    x = np.array([0.0, 0.3e-3, 2e-3, 6e-3])
    mean = [over_the_aperture(lambda y, x=each: k / 2 * hankel2(0, k * np.hypot(x, y))) for each in x]
    found = mode_change(np.array([k]), APERTURE, x)[0]
    np.testing.assert_allclose(found, mean - np.exp(-1j * k * x), atol=1e-7)
    if k.imag > -100:
        coupling = aperture_coupling(np.array([k]), APERTURE, APERTURE, x[-1])[0]
        assert found[-1] == pytest.approx((coupling - 1) * np.exp(-1j * k * x[-1]), rel=1e-5)


def test_many_distances_are_interpolated():
    k, x = np.array([6300 - 1j, -5000 - 3j, 900 - 4000j]), np.linspace(0.5e-3, 6e-3, 40)
    few = np.hstack([mode_change(k, APERTURE, each) for each in np.split(x, 4)])
    np.testing.assert_allclose(mode_change(k, APERTURE, x), few, atol=1e-11 * abs(few).max())


def test_the_static_pole_is_a_double_integral_of_a_logarithm():
    x = np.array([0.0, 0.3e-3, 2e-3, 6e-3])
    mean = [over_the_aperture(lambda y, x=each: np.log(np.hypot(x, y)) / np.pi).real for each in x]
    found, expected = static_change(APERTURE, x), mean - x
    np.testing.assert_allclose(found - found[0], expected - expected[0], atol=1e-9)


def test_mirrors_repeat_the_aperture():
    k, width = 6300.0 - 60j, 6e-3
    images = np.arange(-60, 61) * width
    x = 2e-3
    mean = sum(
        over_the_aperture(lambda y, at=side * each: k / 4 * hankel2(0, k * np.hypot(x, y - at)))
        for each in images
        for side in (1, -1)
    )
    found = _between_mirrors(k, APERTURE, np.array([x]), width, 16 * k.real)[0]
    assert found == pytest.approx(mean - np.exp(-1j * k * x), abs=1e-4 * abs(mean))


@pytest.fixture(scope="module")
def solved():
    stator = plate(cut("PZT-8", "Z", quality=60.0), length=12.0, thickness=1.3)
    one = comb(stator, "a", 6.0, finger_pairs=3, aperture=APERTURE, pattern="+-0o+-")
    return solution(stator, (one,), order=5, layers=1)


def test_fingers_on_their_electrodes_are_the_transducer(solved):
    """The potentials of the fingers of one electrode, made equal, give its superelement; left-out fingers have none."""
    (scatterer,), (transducer,) = solved.fields.network.scatterers, solved.fields.transducers
    row, (n, ports) = scatterer.superelement, (2 * scatterer.superelement.size, 4)
    fingers, dipoles = finger_ports(row, transducer.signs)
    assert len(fingers.matrix) == n + ports
    joined = np.zeros((n + ports, n + 2))
    joined[:n, :n] = np.eye(n)
    joined[n:, n:] = np.tile(np.eye(2), (2, 1))
    np.testing.assert_allclose(
        joined.T @ fingers.matrix @ joined, row.matrix, atol=1e-11 * abs(row.matrix).max()
    )
    sides = joined @ solved.sides(0)
    medium, unit = solved.fields.section.solid, solved.fields.section.length_unit
    charges = electrode_charges(solved, 0)
    middles = transducer.fingers[[0, 1, 4, 5]].mean(axis=1)
    moments = [
        np.sum((charges.charge * (charges.x - middle))[charges.finger == number])
        for number, middle in zip((1, 2, 4, 5), middles, strict=True)
    ]
    found = -(dipoles @ sides) * medium.stress_unit / medium.potential_unit * unit
    np.testing.assert_allclose(found, moments, atol=1e-9 * abs(np.array(moments)).max())


def test_charges_of_the_fingers_potentials_are_those_of_the_port(solved):
    fields = with_apertures(solved.fields)
    change = abs(fields.admittances / solved.fields.admittances - 1).item()
    assert 1e-3 < change < 0.2
    assert len(fields.sides[0]) == 2 * fields.section.size + 4
