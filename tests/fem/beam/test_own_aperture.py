"""A transducer's response to the finite aperture of its own charges."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.special import hankel2

from fem.beam import own_aperture, point_potential
from fem.beam.electrode_charges import electrode_charges
from fem.beam.line_source import LineSource
from fem.beam.own_aperture import STEPS, finger_coupling, finger_pairs, mirrored_mode_mean, sheet_lengths
from fem.beam.point_potential import StripPotential
from fem.beam.reception import aperture_coupling, with_apertures
from fem.condense.transducer import finger_ports
from fem.geometry import Transducer
from tests.fem.stators import comb, cut, plate, solution

APERTURE = 4e-3
NODES, WEIGHTS = np.polynomial.legendre.leggauss(200)


def over_the_aperture(function) -> complex:
    """Mean over two apertures of a function of the distance across, graded towards 0."""
    t = (NODES + 1) / 2
    y = APERTURE * t**3
    return complex(np.sum(WEIGHTS * 3 * APERTURE * t**2 * (1 - y / APERTURE) * function(y)))


def one_mode(k: complex, potential: complex = 1.0, slope: complex = 0.0) -> LineSource:
    return modes([k], [potential], slope)


def modes(wavenumbers, potentials, slope: complex = 0.0) -> LineSource:
    none = np.zeros(len(wavenumbers))
    return LineSource(
        surface=np.ones(len(none), dtype=bool),
        wavenumbers=np.array(wavenumbers),
        amplitudes=none,
        tangential=none,
        normal=none,
        shear=none,
        potential=np.array(potentials),
        static=0.0,
        slope=slope,
    )


@pytest.mark.parametrize("k", [6300 - 1e-9j, 6300 - 30j, -5000 - 3j, -4000j, 3000 - 3000j])
def test_a_mode_is_a_double_integral_of_a_hankel_function(k):
    x = np.array([0.0, 0.3e-3, 2e-3, 6e-3])
    mean = [over_the_aperture(lambda y, x=each: k / 2 * hankel2(0, k * np.hypot(x, y))) for each in x]
    found = StripPotential(one_mode(k), x, APERTURE)(np.array([0.01e-3, 1e-3, APERTURE]))[-1] / APERTURE
    np.testing.assert_allclose(found, mean, atol=1e-7)
    if k.imag > -100:
        coupling = aperture_coupling(np.array([k]), APERTURE, APERTURE, x[-1])[0]
        assert found[-1] == pytest.approx(coupling * np.exp(-1j * k * x[-1]), rel=1e-5)


def test_the_static_pole_is_a_double_integral_of_a_logarithm():
    x = np.array([0.0, 0.3e-3, 2e-3, 6e-3])
    mean = [over_the_aperture(lambda y, x=each: np.log(np.hypot(x, y)) / np.pi).real for each in x]
    source = one_mode(6300 - 1j, potential=0.0, slope=1.0)
    found = StripPotential(source, x, APERTURE)(np.array([APERTURE]))[0] / APERTURE
    np.testing.assert_allclose(found, mean, atol=1e-8)


def test_wide_strips_take_the_path_of_steepest_descent(monkeypatch):
    """Sixty wavelengths, three modes and the pole at 0: both ways, at all lengths."""
    source = modes([6300 - 1j, 900 - 4000j, -5000 - 3j], [1.0, 0.4j, -0.3], slope=0.7e3)
    x, lengths = np.array([0.0, 0.3e-3, 2e-3, 9e-3]), np.array([0.2e-3, 3e-3, 55e-3, 58e-3, 60e-3])
    table = StripPotential(source, x, lengths[-1])
    direct = table(lengths)
    monkeypatch.setattr(point_potential, "MAX_PANELS", 0)
    found = StripPotential(source, x, lengths[-1])(lengths)
    np.testing.assert_allclose(found, direct, rtol=1e-6)
    assert abs(found[2:] - direct[2:]).max() > 0


def test_sheets_of_unequal_lengths():
    """Two lines of 4 and 2.4 mm, a distance apart: the integral over both, less the section's."""
    k, lengths = 6300.0 - 60j, np.array([APERTURE, 2.4e-3])
    one = Transducer(name="t", center=0.0, finger_pairs=1, period=1e-3, metallisation=1e-3, aperture=APERTURE)
    found = finger_coupling(one_mode(k), one, lengths)
    nodes, weights = np.polynomial.legendre.leggauss(120)
    (y, at), (u, v) = ([length / 2 * each for length in lengths] for each in (nodes, weights))
    kernel = k / 2 * hankel2(0, k * np.hypot(one.pitch, np.subtract.outer(y, at)))
    expected = u @ kernel @ v - 2.4e-3 * np.exp(-1j * k * one.pitch)
    for pair in ((0, 1), (1, 0)):
        assert found.charges[pair][[0, 2]] == pytest.approx([expected, expected], rel=1e-5)


def test_fingers_of_unequal_widths():
    """Mean of D over two fingers, of charges and dipoles: against the double integral with many points on each."""
    k, lengths = 6300.0 - 60j, np.array([APERTURE])
    one = Transducer(
        name="t", center=0.0, finger_pairs=1, period=1e-3, metallisation=0.5, aperture=APERTURE, cell="DART"
    )
    found, pairs = finger_coupling(one_mode(k), one, lengths), finger_pairs(one)
    middles, halves = one.fingers.mean(axis=1), np.ptp(one.fingers, axis=1) / 2
    s = np.cos(np.pi * (np.arange(24) + 0.5) / 24)
    for i, j in ((2, 0), (0, 2), (2, 1)):
        x = abs(np.subtract.outer(middles[i] + halves[i] * s, middles[j] + halves[j] * s))
        change = StripPotential(one_mode(k), x.ravel(), APERTURE)(lengths)[0].reshape(x.shape)
        change = change - APERTURE * np.exp(-1j * k * x)
        dipole = 2 / 24 * s / np.array(halves)[[i, j], None]  # x / sum x^2
        kind = pairs.kind[i, j]
        assert found.charges[0, 0, kind] == pytest.approx(change.mean(), rel=1e-5)
        assert found.mixed[0, 0, kind] == pytest.approx(change.mean(axis=0) @ dipole[1], rel=1e-3)
        assert found.moments[0, 0, kind] == pytest.approx(dipole[0] @ change @ dipole[1], rel=1e-2)
    assert found.charges[0, 0, pairs.kind[2, 0]] == found.charges[0, 0, pairs.kind[0, 2]]
    assert found.polarisability == pytest.approx([each.item() for each in map(partial(own_dipole, k), halves)])
    assert found.polarisability[2] != pytest.approx(9 * found.polarisability[0], rel=1e-3)


def own_dipole(k: complex, half: float) -> np.ndarray:
    """Equation (2) of the module for one mode."""
    return np.array(-half / (2 * (-1j * k * np.exp(-1j * k * half))))


def test_few_kinds_of_pairs_unless_all_distances_differ():
    row = Transducer(name="t", center=0.0, finger_pairs=6, period=1e-3, metallisation=0.5, aperture=APERTURE)
    for own, kinds in (({}, 23), ({"chirp": 1e-11}, 23), ({"chirp": 0.2}, 12 * 11 + 12), ({"cell": "DART"}, 8 * 11)):
        pairs = finger_pairs(replace(row, **own))
        assert len(pairs.offset) == kinds, own
        middles = replace(row, **own).fingers.mean(axis=1)
        np.testing.assert_allclose(pairs.offset[pairs.kind], np.subtract.outer(middles, middles), atol=1e-11)


@pytest.mark.parametrize("kind", [{"chirp": 0.1}, {"cell": "DART", "chirp": -0.2}])
def test_interpolation_between_the_distances_of_uneven_fingers(kind, monkeypatch):
    """D at the nodes of panels against D at every distance, without and with mirrors."""
    source = modes([6300 - 1j, 900 - 4000j, -5000 - 3j], [1.0, 0.4j, -0.3], slope=0.7e3)
    row = Transducer(name="t", center=0.0, finger_pairs=8, period=1e-3, metallisation=0.5, aperture=APERTURE, **kind)
    lengths = sheet_lengths(row)
    for mirror_width in (None, 7e-3):
        found = finger_coupling(source, row, lengths, mirror_width)
        monkeypatch.setattr(own_aperture, "FEWER_NODES", 10**6)
        every = finger_coupling(source, row, lengths, mirror_width)
        monkeypatch.undo()
        assert abs(found.charges - every.charges).max() > 0.0
        for one, other in zip(found[:3], every[:3], strict=True):
            # the arbitrary zero of the potential of a floating section is another
            difference = one - other - (one - other)[0, 0, 0] * np.outer(lengths, lengths)[..., None] / lengths[0] ** 2
            assert abs(difference).max() < 1e-8 * abs(other).max()


def test_lengths_of_sheets():
    """Finer steps where the fingers are few; nothing shorter than a fifth of the aperture."""
    one = Transducer(name="t", center=0.0, finger_pairs=5, period=1e-3, metallisation=0.5, aperture=2e-2)
    found = sheet_lengths(one)
    assert found[0] == one.aperture
    assert np.all(np.diff(found) < 0)
    np.testing.assert_allclose((one.aperture - found[1:]) / 2 / one.period, STEPS[0])
    assert sheet_lengths(replace(one, aperture=2e-3))[-1] > 0.4e-3
    assert len(sheet_lengths(one, 2)) == 4
    assert len(sheet_lengths(replace(one, finger_pairs=300))) == 2
    assert len(sheet_lengths(replace(one, finger_pairs=2000))) == 1


def test_mirrors_repeat_the_aperture():
    k, width = 6300.0 - 60j, 6e-3
    images = np.arange(-60, 61) * width
    x = 2e-3
    mean = sum(
        over_the_aperture(lambda y, at=side * each: k / 4 * hankel2(0, k * np.hypot(x, y - at)))
        for each in images
        for side in (1, -1)
    )
    found = mirrored_mode_mean(k, APERTURE, np.array([x]), width, 16 * k.real)[0]
    assert found == pytest.approx(mean - np.exp(-1j * k * x), abs=1e-4 * abs(mean))


@pytest.fixture(scope="module")
def solved():
    stator = plate(cut("PZT-8", "Z", quality=60.0), length=12.0, thickness=1.3)
    one = comb(stator, "a", 6.0, finger_pairs=3, aperture=APERTURE, pattern="+-0o+-")
    return solution(stator, (one,), order=5, layers=1)


def test_fingers_on_their_electrodes_are_the_transducer(solved):
    """The potentials of the fingers of one electrode, made equal, give its superelement; left-out fingers have none."""
    (scatterer,), (transducer,) = solved.fields.network.scatterers, solved.fields.transducers
    row, (n, ports) = scatterer.piece, (2 * scatterer.piece.size, 4)
    fingers, dipoles = finger_ports(row, transducer.signs)
    assert len(fingers.matrix) == n + ports
    joined = np.zeros((n + ports, n + 2))
    joined[:n, :n] = np.eye(n)
    joined[n:, n:] = np.tile(np.eye(2), (2, 1))
    np.testing.assert_allclose(joined.T @ fingers.matrix @ joined, row.matrix, atol=1e-11 * abs(row.matrix).max())
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
