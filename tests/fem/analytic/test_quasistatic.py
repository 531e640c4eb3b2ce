"""The quasi-static estimate.  Oracles: closed forms of electrostatics, published permittivities, the driven stator."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.special import ellipk

from fem.analytic.half_space import automatic_period
from fem.analytic.quasistatic import (
    charge_transform,
    end_excess,
    strip_charges,
    surface_permittivity,
    transducer_estimate,
)
from fem.geometry import Transducer
from fem.materials import VACUUM_PERMITTIVITY, anisotropic, material, rotated
from fem.solve.driven_stator import driven_wave
from tests.fem.stators import FREQUENCY, comb, cut, lossless, plate
from tests.frozen import frozen
from tests.oracles import fem_finger_ends


def test_without_coupling_the_permittivity_is_the_geometric_mean():
    """sqrt(eps_11 eps_33 - eps_13^2), the vacuum's beside it."""
    table = material("steel").stiffness
    coupling = np.zeros((3, 6))
    coupling[2, 2] = 1e-7
    permittivity = [[30.0, 0.0, 7.0], [0.0, 11.0, 0.0], [7.0, 0.0, 20.0]]
    solid = anisotropic(name="weak", stiffness=table, coupling=coupling, permittivity=permittivity, density=5e3)
    expected = np.sqrt(30.0 * 20.0 - 49.0) * VACUUM_PERMITTIVITY
    assert surface_permittivity(solid, "open") == pytest.approx(expected, rel=1e-10)
    assert surface_permittivity(solid) == pytest.approx(expected + VACUUM_PERMITTIVITY, rel=1e-10)


@pytest.mark.parametrize(
    ("name", "orientation", "published"),
    [("LiNbO3 (Warner)", "YZ", 46.0), ("LiNbO3 (Kovacs)", "128YX", 56.0), ("quartz (Bechmann)", "ST-X", 5.5)],
)
def test_permittivity_of_known_cuts(name, orientation, published):
    """Morgan (2007), table 4.1: two digits, other sets of constants."""
    solid = rotated(material(name), orientation)
    assert surface_permittivity(solid) / VACUUM_PERMITTIVITY == pytest.approx(published, rel=0.03)


def test_permittivity_where_only_u_y_couples():
    """Poled along y: without traction u_y = -e15 phi / c44, so eps11 + e15^2 / c44."""
    ceramic = material("PZT-4")
    turned = rotated(ceramic, (0.0, 90.0, 0.0))
    expected = ceramic.permittivity[0, 0] + ceramic.coupling[0, 4] ** 2 / ceramic.stiffness[3, 3]
    assert surface_permittivity(turned, "open") == pytest.approx(expected, rel=1e-10)


def test_strips_as_wide_as_the_gaps_have_simple_charges():
    """4 / (pi (1 - 4 n^2))."""
    n = np.arange(12)
    np.testing.assert_allclose(strip_charges(11, 0.5), 4 / np.pi / (1 - 4 * n**2), rtol=1e-9)


@pytest.mark.parametrize("metallisation", [0.2, 0.5, 0.83])
def test_alternating_strips_have_the_capacitance_of_conformal_mapping(metallisation):
    """As eps K(k) / K'(k) per pair with k = sin(pi m / 2); the row's ends weigh 1 / N."""
    k = np.sin(np.pi * metallisation / 2) ** 2
    expected = ellipk(k) / ellipk(1 - k)
    solid = cut("PZT-8", "Z")
    found = []
    for pairs in (20, 40):
        row = Transducer(
            name="a", center=1.0, finger_pairs=pairs, period=1e-3, metallisation=metallisation, aperture=0.03
        )
        found.append(transducer_estimate(solid, row).capacitance / (0.03 * surface_permittivity(solid)))
    assert found[1] - found[0] == pytest.approx(20 * expected, rel=1e-4)  # the ends' part falls as 1 / N^2


@pytest.mark.parametrize("metallisation", [0.2, 0.5, 0.83])
def test_transform_is_that_of_the_charge_between_the_edges(metallisation):
    """Its sigma ~ 1 / sqrt(cos theta - cos pi m), theta = 2 pi x / p, on alternating strips (Mehler and Dirichlet)."""
    t = np.pi * (np.arange(4000) + 0.5) / 4000
    theta = np.pi * metallisation * np.cos(t)  # the square roots at the edges taken out
    density = np.sin(t) / np.sqrt(np.cos(theta) - np.cos(np.pi * metallisation))
    moments = [np.sum(density * np.cos((n + 0.5) * theta)) for n in range(4)]
    ratios = charge_transform(np.pi * (2 * np.arange(4) + 1), metallisation)
    np.testing.assert_allclose(ratios / ratios[0], np.array(moments) / moments[0], atol=1e-6)


def test_a_driven_comb_on_weakly_coupled_quartz():
    """Conductance, susceptance and amplitude of the driven stator, where fingers hardly reflect."""
    solid = lossless("quartz (Bechmann)", "ST-X")
    stator = plate(solid, length=30.0, thickness=2.0, bottom="absorbing", above="vacuum")
    row = replace(
        comb(stator, "a", 8.0, finger_pairs=6), period=automatic_period(solid, 1.03 * FREQUENCY, 0.4), metallisation=0.4
    )
    theory = transducer_estimate(solid, row)
    place = 0.75 * stator.length
    wave = driven_wave(stator, (row,), frequency=FREQUENCY, drive="a", tolerance=1e-2, places=(place,))
    assert wave.admittance.real == pytest.approx(theory.conductance(FREQUENCY), rel=0.03)
    assert wave.admittance.imag == pytest.approx(2 * np.pi * FREQUENCY * theory.capacitance, rel=0.02)
    assert abs(wave.rayleigh_motion(place)[1]) == pytest.approx(theory.normal(FREQUENCY), rel=0.03)


@pytest.mark.parametrize("pattern", ["+-+-+-+-", "++--++--", "+-0-+-+-", "-+-+0000"])
def test_capacitance_of_a_pattern_at_low_frequency(pattern):
    """The driven stator far below its passband; strips beyond the ends and left-out ones are not there: 8 %."""
    stator = plate(cut("PZT-8", "Z", loss=0.0), length=8.0, thickness=3.0)
    row = comb(stator, "a", 4.0, finger_pairs=4, pattern=pattern)
    low = 0.04 * FREQUENCY
    wave = driven_wave(stator, (row,), frequency=low, drive="a", tolerance=0.1)
    expected = 2 * np.pi * low * transducer_estimate(stator.solid, row, "open").capacitance
    assert wave.admittance.imag == pytest.approx(expected, rel=0.08)


def test_power_of_the_wave_is_what_the_source_gives():
    """G |V|^2 / 2 = two waves of omega eps |phi|^2 / (4 dv/v) per metre of aperture."""
    solid = rotated(material("LiNbO3 (Kovacs)"), "128YX")
    row = Transducer(name="a", center=1.0, finger_pairs=5, period=1e-4, metallisation=0.3, aperture=2e-3, split=True)
    theory = transducer_estimate(solid, row)
    at = np.array([3.7e7, 3.9e7, 4.05e7])
    potential = abs(theory.potential) * theory.normal(at)
    carried = 2 * np.pi * at * theory.permittivity * potential**2 / (4 * theory.velocity_change)
    np.testing.assert_allclose(theory.conductance(at) / 2, 2 * carried * row.aperture, rtol=1e-12)


@frozen([("PZT-8 Z",), ("LiNbO3 (Kovacs) 128YX",), ("LiNbO3 (Warner) YZ",)])
def exact_excess(name):
    """Excess length of the charge at the ends of fingers, in pitches."""
    table, orientation = name.rsplit(" ", 1)
    solid, degrees = lossless(table, orientation), np.linspace(0.0, 180.0, 19)
    values = [surface_permittivity(rotated(solid, (each, 0.0, 0.0))) for each in degrees[:-1]]
    permittivity = CubicSpline(np.radians(degrees), [*values, values[0]], bc_type="periodic")
    return fem_finger_ends.end_excess(
        lambda k_x, k_y: permittivity(np.arctan2(k_y, k_x)) * np.hypot(k_x, k_y), metallisation=0.5, length=6.0
    )


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("PZT-8 Z", marks=pytest.mark.slow),
        "LiNbO3 (Kovacs) 128YX",
        pytest.param("LiNbO3 (Warner) YZ", marks=pytest.mark.slow),
    ],
)
def test_static_ends_of_fingers(name):
    """Boundary elements in the plane, with the permittivity of every direction and the vacuum above."""
    assert end_excess(lossless(*name.rsplit(" ", 1))) == pytest.approx(float(exact_excess(name)), rel=0.15)
