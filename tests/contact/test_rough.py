"""Rough spheres: mean field and samples of asperities against the values of independent programs and exact limits."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import make_interp_spline
from scipy.optimize import brentq
from scipy.stats import norm

from contact import InputError
from contact.law.asperities import Asperities, RoughBall
from contact.law.rough import MeanField, Roughness, disc_displacement, johnson_number, pressure_tails, tail

R, E, PRELOAD = 1e-3, 64e9, 0.87309e-3  # m, Pa, N: the ball of Feenstra and Breedveld
HERTZ = {"approach": 4.71296e-9, "stiffness": 2.7788e5, "pressure": 88.452e6}
# rms nm, asperity radius um; approach of the mean planes nm, stiffness and pressure in the middle over Hertz's: by a
# program of its own with 320 rings
TABLE = [
    (0.03, 10, 4.8018, 0.99301, 0.9778),
    (0.3, 10, 5.0338, 0.96209, 0.8918),
    (3, 10, 4.2130, 0.75919, 0.5390),
    (3, 2, 2.8208, 0.79408, 0.5857),
    (10, 10, -2.9761, 0.48336, 0.2811),
    (30, 10, -34.932, 0.23964, 0.1258),
]
# x, y in um and heights less the sphere's in nm of six asperities of 10 um; approach in nm, forces of all with and
# without interaction, N
SIX = np.array([(0, 0, 0), (0.6, 0, -1), (-0.4, 0.5, -1.5), (0.1, -0.8, -2), (-0.9, -0.3, -3), (0.8, 0.7, -4)])
FORCES = [
    (2, 3.0531563e-5, 3.5686234e-5),
    (5, 1.9065424e-4, 2.9655740e-4),
    (10, 6.3808235e-4, 1.1882576e-3),
    (20, 1.7854930e-3, 3.9449057e-3),
]


def six():
    x, y = SIX[:, :2].T * 1e-6
    return Asperities(x=x, y=y, heights=SIX[:, 2] * 1e-9 + (x**2 + y**2) / (2 * R), radius=10e-6)


@pytest.mark.parametrize(("rms", "beta", "approach", "stiffness", "pressure"), TABLE)
def test_mean_field_of_a_ball(rms, beta, approach, stiffness, pressure):
    ball = MeanField(R, E, Roughness(rms=rms * 1e-9, asperity_radius=beta * 1e-6))
    z = ball.approach(PRELOAD)
    field = ball.at(z)
    assert field.force == pytest.approx(PRELOAD, rel=1e-9)
    assert z * 1e9 == pytest.approx(approach, rel=2e-4)
    assert field.stiffness / HERTZ["stiffness"] == pytest.approx(stiffness, rel=2e-4)
    middle = np.polyfit(field.r[:4] ** 2, field.pressure[:4], 2)[-1]  # rings have mean pressures
    assert middle / HERTZ["pressure"] == pytest.approx(pressure, rel=2e-4, abs=5e-5)  # half the last digit


@pytest.mark.parametrize("rms", [1e-11, 1e-12, 1e-13, 1e-15])
def test_the_mean_field_of_a_vanishing_roughness_is_hertz(rms):
    """The mean planes approach by what crushes the asperities, ~ rms^(2/3), beyond Hertz; 160 rings err by 3e-5."""
    ball = MeanField(R, E, Roughness(rms=rms))
    for force in (0.1 * PRELOAD, PRELOAD, 10 * PRELOAD):
        hertz = (0.75 * force / E / np.sqrt(R)) ** (2 / 3)
        # t of the largest pressure where all asperities touch, p = (4/3) E eta sqrt(beta) (-t sigma)^(3/2)
        largest = 1.5 * force / (np.pi * R * hertz)
        crushed = (largest * np.sqrt(10e-6) * rms / (4 / 3 * E * 0.05)) ** (2 / 3)
        assert ball.approach(force) == pytest.approx(hertz, rel=5e-5, abs=crushed)
        assert ball.at(hertz).force == pytest.approx(force, rel=2e-4 + 1.5 * crushed / hertz)
        if rms == 1e-15:
            assert ball.at(hertz).force == pytest.approx(force, rel=2e-4)


def test_pressures_from_the_table_of_tails():
    t = np.linspace(-20.0, 8.0, 1001)
    pressure, fall = pressure_tails(t)
    assert pressure == pytest.approx(tail(1.5, t), rel=1e-6)
    assert fall == pytest.approx(1.5 * tail(0.5, t), rel=1e-6)


@pytest.mark.parametrize("rms", [3e-9, 0.03e-9])
def test_table_of_the_mean_field_is_its_force(rms):
    """Between the solved approaches, of the second table, by fields of their own."""
    ball, deepest = MeanField(R, E, Roughness(rms=rms)), 30e-9
    table = ball.force_table(deepest, 1)
    rows = np.linspace(0.02, 0.99, 15) * (table.force.shape[1] - 1)
    for row in rows.astype(int):
        field = ball.at(float(table.start[0] + row * table.spacing[0]))
        largest = table.force[0, -1]
        assert table.force[0, row] == pytest.approx(field.force, rel=5e-5, abs=1e-7 * largest)
        assert table.rate[0, row] / table.spacing[0] == pytest.approx(field.stiffness, rel=5e-4, abs=1e-3)


def test_table_of_a_sample_is_its_force():
    sample, deepest = Roughness(rms=3e-9).drawn(2, 5e-6), 20e-9
    table = sample.ball(R, E, deepest).force_table(deepest, 1)
    for row in range(5, table.force.shape[1], 101):
        z = float(table.start[0] + row * table.spacing[0])
        forces = [sample.forces(R, E, z + shift).sum() for shift in (-1e-13, 0.0, 1e-13)]
        assert table.force[0, row] == pytest.approx(forces[1], rel=1e-4, abs=1e-6 * table.force[0, -1])
        assert table.rate[0, row] / table.spacing[0] == pytest.approx((forces[2] - forces[0]) / 2e-13, rel=5e-3)


def test_stiffness_of_the_mean_field_is_the_derivative_of_its_force():
    ball = MeanField(R, E, Roughness(rms=3e-9), rings=80)
    # at one outermost radius, so that the rings are the same ones
    step, z = 1e-13, 4e-9
    rise = (ball.at(z + step).force - ball.at(z - step).force) / (2 * step)
    assert ball.at(z).stiffness == pytest.approx(rise, rel=1e-4)


def test_without_roughness_the_mean_field_is_hertz():
    # the approach of the mean planes differs by the standoff of the few highest asperities: compare forces of pressures
    ball = MeanField(R, E, Roughness(rms=0.003e-9))
    field = ball.at(ball.approach(PRELOAD))
    r, p = field.r, field.pressure
    a = (0.75 * PRELOAD * R / E) ** (1 / 3)
    hertz = 1.5 * PRELOAD / (np.pi * a**2) * np.sqrt(np.maximum(1 - (r / a) ** 2, 0))
    inner = r < 0.7 * a
    assert p[inner] == pytest.approx(hertz[inner], rel=6e-3)
    assert field.stiffness == pytest.approx(2 * a * E, rel=2e-3)


def test_tails_are_the_integrals_of_the_normal_density():
    for power in (-0.5, 0.5, 1.5):
        for t in (-40.0, -13.0, -11.0, -1.0, 0.0, 2.0, 6.0):
            # over the height above t, in units of its scale
            width = 1.0 / max(t, 1.0)
            upper = max(-t, 0.0) / width + 40
            # x = s - t = y^2 w takes the root out
            exact, _ = quad(
                lambda y, t=t, n=power, w=width: 2 * y * w * (w * y * y) ** n * norm.pdf(t + w * y * y),
                0,
                np.sqrt(upper),
                points=[np.sqrt(max(-t, 1.0))],
                limit=400,
                epsabs=0,
            )
            assert tail(power, np.array([t]))[0] == pytest.approx(exact, rel=2e-8), (power, t)


def test_displacement_of_a_disc():
    # over p/E: 2 a in the middle, 4 a/pi at the edge; far away that of a force
    assert disc_displacement(2.0, 0.0) == pytest.approx(4.0, rel=1e-12)
    assert disc_displacement(2.0, 2.0) == pytest.approx(8.0 / np.pi, rel=1e-12)
    assert disc_displacement(1.0, 1e3) == pytest.approx(1e-3, rel=1e-6)


@pytest.mark.parametrize(("z", "coupled", "alone"), FORCES)
def test_six_asperities(z, coupled, alone):
    sample = six()
    assert sample.forces(R, E, z * 1e-9).sum() == pytest.approx(coupled, rel=1e-7)
    each = [
        Asperities(x=[x], y=[y], heights=[h], radius=10e-6)
        for x, y, h in zip(sample.x, sample.y, sample.heights, strict=True)
    ]
    assert sum(one.forces(R, E, z * 1e-9)[0] for one in each) == pytest.approx(alone, rel=1e-7)


def test_forces_of_a_sample_follow_from_its_approaches_in_any_order():
    sample, z = Roughness(rms=3e-9).drawn(5, 4e-6), 5e-9
    P = sample.forces(R, E, z)
    distance = np.hypot(sample.x[:, None] - sample.x, sample.y[:, None] - sample.y)
    np.fill_diagonal(distance, np.inf)
    # balance written by hand, the asperities that do not touch included
    u = z + sample.heights - (sample.x**2 + sample.y**2) / (2 * R) - (1 / distance) @ P / (np.pi * E)
    assert P == pytest.approx(4 / 3 * E * np.sqrt(10e-6) * np.maximum(u, 0) ** 1.5, rel=1e-9, abs=1e-18)
    assert (P > 0).sum() > 5
    ball = RoughBall(sample, R, E, z)
    state = ball.at(z)
    assert state.approaches == pytest.approx(u[ball.near], abs=1e-20)
    # rates against a difference of two approaches between which none begins to touch
    step = 1e-15
    rates = (ball.at(z + step).approaches - ball.at(z - step).approaches) / (2 * step)
    assert state.rates == pytest.approx(rates, rel=1e-4, abs=1e-4)
    order = np.random.default_rng(1).permutation(P.size)
    turned = Asperities(x=-sample.y[order], y=sample.x[order], heights=sample.heights[order], radius=10e-6)
    assert turned.forces(R, E, z) == pytest.approx(P[order], rel=1e-9, abs=1e-18)


def merged_force(u, beta, d):
    """Force of an asperity that becomes a punch at a radius of pi/4 of the distance of its neighbour."""
    a = np.sqrt(beta * u)
    b = np.pi / 4 * d
    if a <= b:
        return 4 / 3 * E * a**3 / beta
    return 4 / 3 * E * b**3 / beta + 2 * E * b * (u - b**2 / beta)


def test_asperities_that_meet_carry_on_as_punches():
    """Two equal ones 0.2 um apart: u + P/(pi E d) = z, with P(u) written by hand."""
    beta, d, z = 10e-6, 0.2e-6, 20e-9
    pair = Asperities(x=[-d / 2, d / 2], y=[0, 0], heights=[0, 0], radius=beta)
    free = z - (d / 2) ** 2 / (2 * R)
    u = brentq(lambda u: u + merged_force(u, beta, d) / (np.pi * E * d) - free, 0, free, xtol=1e-22)
    assert np.sqrt(beta * u) > np.pi / 4 * d  # they have met
    assert pair.forces(R, E, z) == pytest.approx(merged_force(u, beta, d), rel=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_asperities_that_all_merge_have_one_solution_and_act_as_the_smooth_ball(seed):
    """Far deeper than the heights, the sum over the grid of asperities is the compliance of a half-space: Hertz."""
    sample, z = Roughness(rms=0.3e-9).drawn(seed, 7e-6), 30e-9
    P = sample.forces(R, E, z)
    u = z + sample.heights - (sample.x**2 + sample.y**2) / (2 * R)
    distance = np.hypot(sample.x[:, None] - sample.x, sample.y[:, None] - sample.y)
    np.fill_diagonal(distance, np.inf)
    u -= (1 / distance) @ P / (np.pi * E)
    expected = [merged_force(each, 10e-6, d) if each > 0 else 0.0 for each, d in zip(u, distance.min(1), strict=True)]
    assert P == pytest.approx(np.array(expected), rel=1e-7, abs=1e-16)
    assert np.mean(P > 0) > 0.5
    assert P.sum() == pytest.approx(4 / 3 * E * np.sqrt(R) * z**1.5, rel=0.02)


def test_a_radius_for_each_asperity():
    """Far apart, each is Hertz with its own radius."""
    x, radius, z = np.array([0.0, 1e-3]), np.array([2e-6, 8e-6]), 3e-9
    sample = Asperities(x=x, y=0 * x, heights=x**2 / (2 * R), radius=radius)
    assert sample.forces(R, E, z) == pytest.approx(4 / 3 * E * np.sqrt(radius) * z**1.5, rel=1e-3)


def test_number_of_asperities_in_contact():
    # an independent program: with 20 nm and 10 um 3 asperities carry the ball
    ball = MeanField(R, E, Roughness(rms=20e-9))
    assert round(ball.at(ball.approach(PRELOAD)).touching) == 3
    assert johnson_number(3e-9, HERTZ["approach"]) == pytest.approx(0.6365, rel=1e-4)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"rms": 0.0}, "roughness.rms must be positive and finite, got 0"),
        ({"rms": 3e-9, "asperity_radius": -1e-6}, "roughness.asperity_radius must be positive"),
        ({"rms": 3e-9, "density": np.nan}, "roughness.density must be"),
    ],
)
def test_refusals(given, sentence):
    with pytest.raises(InputError, match=sentence):
        Roughness(**given)


def test_a_sample_with_unequal_lists_is_refused():
    with pytest.raises(InputError, match=r"asperities\.heights must be a list with one value for each asperity"):
        Asperities(x=[0.0, 1e-6], y=[0.0, 0.0], heights=[0.0], radius=1e-6)


def test_two_asperities_at_one_place_are_refused():
    with pytest.raises(
        InputError, match=r"asperities\.x must not hold two asperities at one place, as that of number 1"
    ):
        Asperities(x=[0.0, 0.0], y=[0.0, 0.0], heights=[0.0, 1e-9], radius=1e-6)


def test_a_larger_sample_begins_with_the_smaller_one():
    rough = Roughness(rms=3e-9)
    small, large = (rough.drawn(3, reach) for reach in (4e-6, 8e-6))
    n = len(small)
    assert large.x[:n] == pytest.approx(small.x, abs=0)
    assert large.heights[:n] == pytest.approx(small.heights, abs=0)
    # a Poisson number of mean eta pi r^2 = 335, and the heights' standard deviation
    assert len(large) == pytest.approx(rough.density * np.pi * 64e-12, rel=0.15)
    assert large.heights.std() == pytest.approx(3e-9, rel=0.15)
    assert np.hypot(large.x, large.y)[n:].min() > np.hypot(small.x, small.y).max()
    # no direction is preferred
    assert abs(np.mean(large.x)) < 4 * 4e-6 / np.sqrt(len(large))


def test_dense_asperities_find_random_places():
    rough = Roughness(rms=3e-9, density=1e13)  # eta beta sigma = 0.3: discs of the usual spacing would not fit
    sample = rough.drawn(1, 3e-6)
    assert len(sample) > 200
    assert sample.nearest.min() == pytest.approx(rough.spacing, rel=0.05)
    assert sample.nearest.min() >= rough.spacing


def test_a_field_as_one_ball():
    """The approach of a smooth ball with its force, and the rate against a difference."""
    field, deepest, z = MeanField(R, E, Roughness(rms=3e-9)), 20e-9, 4.213e-9
    ball = field.ball(R, E, deepest)
    assert ball.carries(0.999 * PRELOAD, z)
    assert not ball.carries(1.001 * PRELOAD, z)
    rows = ball.rows(deepest, 1)
    u = rows.approaches[:, 0]
    assert 4 / 3 * E * np.sqrt(R) * np.interp(z, rows.z, u) ** 1.5 == pytest.approx(PRELOAD, rel=1e-4)
    assert (rows.z[0], u[0]) == (field.lowest(R), 0.0)
    # the rates against the spline through the approaches, from the first row on
    expected = make_interp_spline(rows.z, u, k=5).derivative()(rows.z)
    assert rows.rates[:, 0] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("rms", [0.03e-9, 0.3e-9, 3e-9])
def test_the_tabulated_law_reaches_the_crests_of_large_waves(rms):
    """It once went on as a straight line beyond 25 standard deviations: 5e-4 of the force with 0.3 nm at 10 nm."""
    field = MeanField(R, E, Roughness(rms=rms))
    law = field.tabulated().law(1.0)
    for z in (5e-9, 12e-9, 40e-9):
        assert float(law.force(1.0, z - field.lowest(R), law)) == pytest.approx(field.at(z).force, rel=1e-6)
