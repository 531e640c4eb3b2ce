"""Endless gratings.  Oracles: closed forms of weak coupling, conformal mapping, finite reflectors, the half-space."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipk, eval_legendre

from fem.analytic.half_space import coupling, rayleigh
from fem.analytic.quasistatic import surface_permittivity
from fem.condense.transducer import Condensation, finger_cell
from fem.discretize.mesh_refinement import LEVELS
from fem.solve.driven_stator import solve_driven
from fem.solve.periodic_cell import cell_parameters
from fem.waveguide.grating import StopBand, grating
from tests.fem.stators import comb, lossless, plate, wave_of

PERIOD = 1e-3


def cells(name, orientation, *, metallisation=0.4, level=1, above="none"):
    solid = lossless(name, orientation)
    return grating(solid, period=PERIOD, metallisation=metallisation, above=above, resolution=LEVELS[level])


@pytest.fixture(scope="module")
def niobate():
    made = cells("LiNbO3 (Warner)", "YZ", level=0)
    return made, [made.stop_band(open_fingers=each) for each in (False, True)]


def test_interpolated_cells_are_the_condensed_ones(niobate):
    made, _ = niobate
    frequency = 1.017 * made.middle
    exact = finger_cell(Condensation(made.section, frequency), made.shape, made.resolution).matrix
    fast = made.cell(frequency, open_fingers=False).matrix
    assert abs(fast - exact).max() < 1e-9 * abs(exact).max()


def test_a_standing_wave_without_charge_does_not_see_whether_fingers_are_connected(niobate):
    """One edge is common to both gratings (x -> -x is a symmetry); connected fingers make the wave slower."""
    _, (shorted, separate) = niobate
    assert shorted.upper == pytest.approx(separate.lower, rel=1e-9)
    assert shorted.lower < shorted.upper < separate.upper


def test_at_the_edges_fields_change_sign_from_cell_to_cell(niobate):
    made, bands = niobate
    for each, band in zip((False, True), bands, strict=True):
        for edge in (band.lower, band.upper):
            matrix = made.edge_matrix((2 * np.pi * edge) ** 2, open_fingers=each)
            values = np.linalg.svd(matrix, compute_uv=False)
            aside = made.edge_matrix((2 * np.pi * edge * 1.001) ** 2, open_fingers=each)
            assert values[-1] < 1e-3 * np.linalg.svd(aside, compute_uv=False)[-1]


def test_inside_the_band_the_wave_decays_by_the_reflectivity(niobate):
    """At the middle |lambda| = exp(-|r|) to second order; outside |lambda| = 1, and k p from the coupled modes."""
    made, bands = niobate
    for each, band in zip((False, True), bands, strict=True):
        middle = made.surface_factor(band.middle, open_fingers=each)
        assert -np.log(abs(middle)) == pytest.approx(band.reflectivity, rel=2e-2)
        assert middle.real < 0
        below = band.middle - 1.5 * (band.upper - band.lower)
        factor = made.surface_factor(below, open_fingers=each)
        assert abs(factor) == pytest.approx(1.0, abs=1e-6)
        detuning = np.pi * (below / band.middle - 1)
        expected = np.pi - np.sqrt(detuning**2 - band.reflectivity**2)
        assert -np.angle(factor) == pytest.approx(expected, abs=0.03 * abs(detuning))


@pytest.mark.parametrize("metallisation", [0.3, pytest.param(0.65, marks=pytest.mark.slow)])
def test_weakly_coupled_fingers_reflect_as_strips_of_charge(metallisation):
    """Datta and Hunsinger (1980): |r| = (pi / 2) (dv / v) |P_1/2(c) / P_-1/2(c) - c|, c = -+cos(pi m)."""
    made = cells("quartz (Bechmann)", "ST-X", metallisation=metallisation)
    solid = lossless("quartz (Bechmann)", "ST-X")
    change = 1 - rayleigh(solid, "metallised").velocity / rayleigh(solid, "open").velocity
    for each, c in ((False, -np.cos(np.pi * metallisation)), (True, np.cos(np.pi * metallisation))):
        expected = np.pi / 2 * change * abs(eval_legendre(0.5, c) / eval_legendre(-0.5, c) - c)
        assert made.stop_band(open_fingers=each).reflectivity == pytest.approx(expected, rel=2e-2)


def test_capacitance_is_that_of_conformal_mapping():
    permittivity = surface_permittivity(lossless("PZT-8", "Z"), "open")
    for metallisation in (0.25, 0.6):
        made = cells("PZT-8", "Z", metallisation=metallisation)
        k = np.sin(np.pi * metallisation / 2) ** 2
        expected = permittivity * ellipk(k) / ellipk(1 - k)
        assert made.capacitance() == pytest.approx(expected, rel=4e-3)  # the level's own error


@pytest.mark.slow
def test_narrow_fingers_leave_the_free_wave_and_wide_ones_the_metallised():
    solid = lossless("PZT-8", "Z")
    free, metal = (rayleigh(solid, surface).velocity for surface in ("open", "metallised"))
    shares = []
    for metallisation in (0.02, 0.98):
        made = cells("PZT-8", "Z", metallisation=metallisation, level=0)
        shorted, separate = (made.stop_band(open_fingers=each) for each in (False, True))
        shares.append([(free - band.velocity) / (free - metal) for band in (shorted, separate)])
    assert shares[0][1] < 0.05  # open narrow strips
    assert shares[1][0] > 0.95  # connected wide ones
    assert shares[0][1] < shares[0][0] < shares[1][0]


def test_vacuum_above_slows_the_wave():
    none = cells("PZT-4", "Z", level=0).stop_band(open_fingers=True)
    vacuum = cells("PZT-4", "Z", level=0, above="vacuum").stop_band(open_fingers=True)
    solid = lossless("PZT-4", "Z")
    most = 1 - rayleigh(solid, "vacuum").velocity / rayleigh(solid, "open").velocity
    assert 0.2 * most < 1 - vacuum.velocity / none.velocity < most


@pytest.mark.parametrize("sign", [pytest.param("o", marks=pytest.mark.slow), "+"])
def test_a_finite_reflector_sends_back_tanh_of_its_fingers(sign):
    """|R| = tanh(N |r|) at the middle of the stop band (coupled modes), but for the end fingers: 8 % of 24."""
    solid = lossless("LiNbO3 (Kovacs)", "128YX")
    made = cells("LiNbO3 (Kovacs)", "128YX", metallisation=0.5, level=0)
    band = made.stop_band(open_fingers=sign == "o")
    stator = plate(solid, length=60.0, bottom="absorbing", thickness=2.0, frequency=band.middle)
    sender = replace(comb(stator, "a", 5.0, frequency=band.middle, finger_pairs=2), period=PERIOD)
    mirror = replace(comb(stator, "b", 35.0, frequency=band.middle, finger_pairs=12, pattern=24 * sign), period=PERIOD)
    solution = solve_driven(stator, (sender, mirror), frequency=band.middle, drive="a", resolution=LEVELS[0])
    between = wave_of(solution).pieces[2]
    mode = between.rayleigh[0]
    returned = abs(between.left[mode] / between.right[mode])
    assert returned == pytest.approx(np.tanh(24 * band.reflectivity), rel=0.08)


@pytest.mark.slow
def test_the_error_of_the_edges_holds_against_a_finer_answer():
    solid = lossless("PZT-8", "Z")
    rough = cell_parameters(solid, period=PERIOD, metallisation=0.5, tolerance=0.02)
    made = cells("PZT-8", "Z", metallisation=0.5, level=3)
    fine = [made.stop_band(open_fingers=each) for each in (False, True)]
    width = max(band.upper - band.lower for band in fine)
    off = max(abs(rough.shorted.lower - fine[0].lower), abs(rough.open.upper - fine[1].upper)) / width
    assert 0.05 * rough.relative_error < off < 2 * rough.relative_error
    assert rough.coupling == pytest.approx(
        2 * (1 - rayleigh(solid, "metallised").velocity / rayleigh(solid, "open").velocity), rel=1e-12
    )
    assert rough.coupling == pytest.approx(coupling(solid), rel=2e-2)  # of the vacuum
    assert 0 < rough.grating_coupling < rough.coupling


def test_cell_parameters_have_the_numbers_of_their_stop_bands_and_the_error_of_two_levels(monkeypatch):
    """Edges known at each level: a finer level divides their error by six at least, so a fifth of the step is left."""
    steps = {LEVELS[0]: 4e-3, LEVELS[1]: 1e-3, LEVELS[2]: 0.0}
    solved = []

    class Known:
        def __init__(self, *given, resolution, **options):
            self.step = steps[resolution]
            solved.append(resolution)

        def stop_band(self, open_fingers):
            lower, upper = (1.0e6, 1.02e6) if open_fingers else (0.99e6, 1.0e6)
            return StopBand(lower=lower, upper=upper + self.step * 0.02e6, pitch=PERIOD)

        def capacitance(self):
            return 3e-10

    monkeypatch.setattr("fem.solve.periodic_cell.grating", Known)
    solid = lossless("PZT-8", "Z")
    found = cell_parameters(solid, period=PERIOD, metallisation=0.5, tolerance=3e-4)
    assert tuple(solved) == LEVELS[:3]
    assert found.relative_error == pytest.approx(1e-3 / 5, rel=1e-6)  # over the wider band's 20 kHz
    assert found.capacitance == 3e-10
    assert (found.shorted.velocity, found.open.velocity) == pytest.approx((1990.0, 2020.0), rel=1e-12)
    assert found.grating_coupling == pytest.approx(2 * 30 / 2020, rel=1e-12)
    free, metal = (rayleigh(solid, surface).velocity for surface in ("open", "metallised"))
    assert found.coupling == pytest.approx(2 * (1 - metal / free), rel=1e-12)


def test_a_stop_band_s_numbers_are_of_its_edges():
    band = StopBand(lower=0.97e6, upper=1.03e6, pitch=1e-3)
    assert (band.middle, band.velocity) == (1e6, 2e3)
    assert band.reflectivity == pytest.approx(np.pi * 0.03, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "period", "metallisation", "words"),
    [
        ("steel", 1e-3, 0.5, "solid must be piezoelectric under a grating of fingers, and steel is not"),
        ("PZT-8", -1.0, 0.5, r"period must be positive and finite, got -1\.0 m"),
        ("PZT-8", 1e-3, 1.0, r"metallisation must be between 0.001 and 0.999, got 1\.0"),
    ],
)
def test_what_is_no_grating_is_refused(name, period, metallisation, words):
    with pytest.raises(ValueError, match=words):
        grating(lossless(name, "Z"), period=period, metallisation=metallisation, above="none", resolution=LEVELS[0])
