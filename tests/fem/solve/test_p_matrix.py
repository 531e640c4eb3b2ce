"""P-matrices: reciprocity, power, loads, the cascade against the stator, a weak comb and a grating in closed form."""

from dataclasses import replace

import numpy as np
import pytest

from fem import Stator, Transducer, cascade_admittance, cell_parameters, material, p_matrix, rotated
from fem.discretize.mesh_refinement import LEVELS
from fem.solve.p_matrix_from_field import p_matrix_on_level
from fem.waveguide.port_fields import stator_cascade

ROW = Transducer(name="t", center=0.05, finger_pairs=3, period=1e-3, metallisation=0.5, aperture=20e-3)


def lone(stator, row, frequency, level=0, every_mode=False):
    """P-matrix on one discretisation."""
    length = (len(row.signs) + 4) * row.pitch
    alone, own = replace(stator, length=length, ends="absorbing"), replace(row, center=length / 2)
    return p_matrix_on_level(alone, own, frequency, LEVELS[level], every_mode=every_mode)


def plate(name, cut, *, quality=np.inf, loss=0.0, bottom="free", thickness=0.6e-3):
    solid = replace(rotated(material(name), cut), mechanical_quality=quality, dielectric_loss=loss)
    return Stator(solid=solid, length=0.1, thickness=thickness, bottom=bottom, ends="absorbing")


CASES = [
    (plate("PZT-8", "Z"), 2.2e6),
    (plate("PZT-8", "Z", bottom="grounded", quality=80.0, loss=0.02), 2.2e6),
    (plate("LiNbO3 (Kovacs)", "YZ", bottom="grounded"), 3.6e6),
    (plate("LiNbO3 (Kovacs)", "128YX", quality=50.0), 3.6e6),
]


@pytest.mark.parametrize(("stator", "frequency"), CASES)
def test_it_is_reciprocal_with_all_modes(stator, frequency):
    """S is symmetric and the current of arriving waves is -2 p^T a; the fingers have no mirror symmetry."""
    found = lone(stator, replace(ROW, pattern="+-0++-"), frequency, every_mode=True)
    assert len(found.wavenumbers) >= 2
    assert abs(found.scattering - found.scattering.T).max() < 1e-11
    assert abs(found.detection + 2 * found.excitation).max() < 1e-11 * abs(found.excitation).max()


@pytest.mark.parametrize(
    ("stator", "frequency"), [case for case in CASES if np.isinf(case[0].solid.mechanical_quality)]
)
@pytest.mark.parametrize("load", [0.0, 30.0 - 200.0j, np.inf])
def test_lossless_power_is_conserved(stator, frequency, load):
    """Any waves and voltage: |b|^2 = |a|^2 + Re V I*; a loaded transducer gives its load's power."""
    found = lone(stator, ROW, frequency, every_mode=True)
    rng = np.random.default_rng(3)
    size = len(found.excitation)
    a, volt = rng.normal(size=size) + 1j * rng.normal(size=size), 40.0 - 25.0j
    b = found.scattering @ a + found.excitation * volt
    current = found.detection @ a + found.admittance * volt
    assert np.sum(abs(b) ** 2) == pytest.approx(np.sum(abs(a) ** 2) + (volt * current.conjugate()).real, rel=1e-10)
    out = found.loaded(load) @ a if load else found.scattering @ a
    lost = 0.0
    if load and np.isfinite(load):
        volt = -(found.detection @ a) / (found.admittance + 1 / load)
        lost = abs(volt) ** 2 * (1 / load).real
    assert np.sum(abs(out) ** 2) + lost == pytest.approx(np.sum(abs(a) ** 2), rel=1e-10)
    if not load:
        assert np.sum(abs(found.excitation) ** 2) == pytest.approx(found.admittance.real, rel=1e-10)


def test_a_cascade_of_all_modes_is_the_stator():
    """Two unlike transducers five plate thicknesses apart: what is left out has decayed."""
    stator, frequency = CASES[1]
    left = replace(ROW, name="a", center=3e-3)
    right = replace(ROW, name="b", center=11e-3, finger_pairs=2, period=0.9e-3)
    whole = stator_cascade(
        replace(stator, length=14e-3), (left, right), frequency=frequency, resolution=LEVELS[1]
    ).solved()
    parts = [lone(stator, row, frequency, 1, True) for row in (left, right)]
    distance = right.center - left.center - (parts[0].length + parts[1].length) / 2
    found = cascade_admittance(parts, [distance])
    assert abs(found - whole.admittances).max() < 1e-3 * abs(whole.admittances).max()
    assert found[1, 0] == pytest.approx(whole.admittances[1, 0], rel=2e-2)


def test_the_surface_waves_of_two_like_faces_are_told_apart():
    """A thick plate: modes of one wavenumber to 1e-7, mixed at random; the surface carries one wave at every level."""
    coarse, fine = (lone(plate("PZT-8", "Z", thickness=5e-3), ROW, 2.2e6, level) for level in (0, 1))
    assert abs(fine.wavenumbers[1] / fine.wavenumbers[0] - 1) < 1e-6
    assert abs(fine.detection + 2 * fine.excitation).max() < 1e-10 * abs(fine.excitation).max()
    assert abs(fine.excitation[[1, 3]]).max() < 1e-5 * abs(fine.excitation[0])
    assert abs(fine.scattering - coarse.scattering).max() < 0.1
    assert abs(fine.excitation - coarse.excitation).max() < 0.1 * abs(fine.excitation[0])


def test_they_beat_along_the_stator():
    """Wavenumbers 3e-4 apart: what the top sends reaches the bottom in part; a cascade of all modes is the stator."""
    stator, frequency = plate("PZT-8", "Z", quality=200.0, loss=0.01, thickness=2e-3), 2.2e6
    left = replace(ROW, name="a", center=10e-3)
    right = replace(ROW, name="b", center=110e-3, finger_pairs=2, period=0.9e-3)
    stator = replace(stator, length=0.12)
    whole = stator_cascade(stator, (left, right), frequency=frequency, resolution=LEVELS[0]).solved().admittances
    parts = [lone(stator, row, frequency, 0, True) for row in (left, right)]
    distance = 0.1 - (parts[0].length + parts[1].length) / 2
    assert cascade_admittance(parts, [distance])[1, 0] == pytest.approx(whole[1, 0], rel=1e-9)


def test_a_weak_comb_is_sinc_squared_and_its_hilbert_partner():
    """A twentieth of the coupling of PZT: no reflections, and G0 sinc^2 X over the main lobe to 1 % of G0."""
    solid = rotated(material("PZT-8"), "Z")
    weak = tuple(tuple(0.05 * each for each in line) for line in solid.coupling)
    solid = replace(solid, coupling=weak, mechanical_quality=np.inf, dielectric_loss=0.0)
    stator, pairs = Stator(solid=solid, length=0.1, thickness=np.inf, ends="absorbing"), 60
    row = replace(ROW, finger_pairs=pairs)
    middle = 2.1526e6
    found = [lone(stator, row, middle * (1 + x / pairs)) for x in np.linspace(-0.9, 0.9, 7)]
    detuning = pairs * (np.array([each.wavenumbers[0].real for each in found]) * row.period - 2 * np.pi) / 2
    sinc = np.sinc(detuning / np.pi) ** 2
    part = np.array([np.sum(abs(each.excitation) ** 2) for each in found])
    largest = part[3] / sinc[3]
    assert part / largest == pytest.approx(sinc, abs=1e-2)
    partner = (np.sin(2 * detuning) - 2 * detuning) / (2 * detuning**2)
    rest = np.array([each.admittance.imag for each in found]) / largest - partner
    static = np.polyval(np.polyfit(detuning, rest, 1), detuning)  # the capacitance's part is a straight line
    assert rest == pytest.approx(static, abs=1e-2)
    assert max(abs(each.scattering[0, 0]) for each in found) < 1e-2


FEWER = 1.15  # connected strips: N of them exchange charge across N - 1 gaps, and the step in velocity reflects too


@pytest.fixture(scope="module")
def strips():
    """Bloch waves of open and connected strips on 128YX, and |S11| and |S21| of a number of them on a thick plate."""
    thick = plate("LiNbO3 (Kovacs)", "128YX", thickness=2e-3)
    cell = cell_parameters(replace(thick, thickness=np.inf).solid, period=0.4e-3, metallisation=0.5, tolerance=5e-2)

    def sizes(kind, number, frequency):
        row = replace(ROW, period=0.4e-3, finger_pairs=number // 2, pattern=kind * number)
        found = lone(thick, row, frequency, 1)
        return abs(found.scattering[0, [0, len(found.wavenumbers)]])

    return {"o": cell.open, "+": cell.shorted}, sizes


@pytest.mark.slow
@pytest.mark.parametrize("number", [20, 60])
def test_open_strips_reflect_as_coupled_modes(strips, number):
    """|S11| = tanh(N r) in mid-band."""
    cell, sizes = strips
    reflected, _ = sizes("o", number, cell["o"].middle)
    assert reflected == pytest.approx(np.tanh(number * cell["o"].reflectivity), rel=1e-2)


@pytest.mark.slow
def test_connected_strips_reflect_as_about_one_fewer(strips):
    """|S11 / S21| = sinh((N - c) r), c = 1.15: |S11| lies 6 % below tanh(N r) at 20 strips."""
    cell, sizes = strips
    r, numbers, found = cell["+"].reflectivity, (12, 40), []
    for number in numbers:
        reflected, passed = sizes("+", number, cell["+"].middle)
        found.append(np.arcsinh(reflected / passed))
    assert (found[1] - found[0]) / (numbers[1] - numbers[0]) == pytest.approx(r, rel=1e-2)
    assert numbers[0] - found[0] / r == pytest.approx(FEWER, abs=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "number", "fewer"), [("o", 200, 0.0), ("+", 120, FEWER)])
def test_the_stop_band_of_a_grating_is_that_of_coupled_modes(strips, kind, number, fewer):
    """Zeros of S11 at pi^2 D^2 = r^2 + (pi / N)^2 of the relative detuning D; without c 2 % off at 120 strips."""
    from scipy.optimize import minimize_scalar

    cell, sizes = strips
    r, middle = cell[kind].reflectivity, cell[kind].middle
    near = np.hypot(r / np.pi, 1 / (number - fewer))
    zeros = [
        minimize_scalar(
            lambda x, side=side: sizes(kind, number, middle * (1 + side * x))[0] ** 2,
            bounds=(0.94 * near, 1.06 * near),
            method="bounded",
            options={"xatol": 3e-6},
        )
        for side in (-1, 1)
    ]
    assert max(each.fun for each in zeros) < 1e-4
    apart = sum(each.x for each in zeros) / 2
    assert 2 * np.sqrt(apart**2 - 1 / (number - fewer) ** 2) == pytest.approx(2 * r / np.pi, rel=1e-2)


def test_the_error_is_that_of_a_finer_solution():
    stator, frequency = CASES[3]
    found = p_matrix(stator, ROW, frequency=frequency, tolerance=2e-2)
    fine = p_matrix(stator, ROW, frequency=frequency, tolerance=1e-4)
    assert 0 < found.relative_error <= 2e-2
    assert abs(found.scattering - fine.scattering).max() < 2 * found.relative_error
    assert found.length == pytest.approx(3e-3, rel=1e-9)
