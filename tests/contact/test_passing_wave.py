"""Sliders on a wave that they load, that tilt or have a soft backing: every question of `contact`, and its refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from contact import (
    ConvergenceError,
    Envelope,
    InputError,
    blocked_thrust,
    burst,
    contact_history,
    load_line,
    mean_forces,
    mean_motion,
    mean_traction,
    release,
    releases,
    stall,
    steady,
    step,
    threshold,
    velocity_derivative,
)
from contact.averaged.coupled_motion import CoupledSearch
from tests.contact.motors import orbit, slider
from tests.contact.test_pillars import grid, scatter, wave

BODY = grid(10, 5, heights=scatter(50, 8e-9, 8), mass=5e-3)
LOADED = wave(strip_width=0.25e-3, loading=True)
TOLERANCE = 1e-3


def test_the_load_line_is_that_of_single_states_up_to_the_stall():
    line = load_line(BODY, LOADED, points=4, tolerance=TOLERANCE)
    assert line.stall.value == stall(BODY, LOADED, tolerance=TOLERANCE).value == blocked_thrust(BODY, LOADED)[0]
    for load, velocity, power in zip(line.load[:-1], line.velocity, line.power, strict=False):
        alone = steady(replace(BODY, load=load), LOADED, tolerance=TOLERANCE)
        assert velocity == pytest.approx(-alone.velocity, rel=1e-9)
        assert power == pytest.approx(load * velocity, rel=1e-12)
        # what the wave pays: all its power that is lost
        rows = alone.loaded
        assert alone.ledger.wave * LOADED.frequency == pytest.approx(rows.wave_power_in - rows.wave_power_out, rel=1e-9)
    assert line.status == "ok"


def test_the_mean_motion_balances_load_and_traction():
    loaded = replace(BODY, load=5e-3)
    mean = mean_motion(loaded, LOADED)
    assert mean.velocity == pytest.approx(steady(loaded, LOADED, tolerance=TOLERANCE).velocity, rel=1e-12)
    # the wave drives towards -x, so that the load of +5 mN is carried by a traction of -5 mN
    assert mean_traction(BODY, LOADED, [mean.velocity])[0] == pytest.approx(-5e-3, rel=1e-8)
    assert mean.load_sign == 1.0  # it drives as its crests do
    assert mean.blocked_thrust == pytest.approx(blocked_thrust(BODY, LOADED)[0], rel=1e-9)


def test_the_derivative_of_the_velocity_is_that_of_its_differences():
    def family(s):
        return replace(BODY, friction_coefficient=0.18 * (1.0 + s), load=5e-3), LOADED

    high, low = (steady(*family(s), tolerance=TOLERANCE).velocity for s in (1e-4, -1e-4))
    assert velocity_derivative(family) == pytest.approx((high - low) / 2e-4, rel=1e-5)


def test_the_threshold_lies_between_a_held_and_a_moving_slider():
    factor = threshold(BODY, LOADED)
    below, above = (
        steady(BODY, LOADED.scaled(factor.value * size), tolerance=TOLERANCE).velocity for size in (0.9999, 1.0001)
    )
    assert (below, above != 0.0) == (0.0, True)
    assert 1e-6 < factor.error / factor.value < 1e-4


@pytest.mark.parametrize("load", [0.0, 5e-3])
def test_a_quasi_static_burst_takes_the_time_that_its_traction_gives(load):
    # Outside truth: t(v) = int m dv/(Q(v) - load) by adaptive quadrature, and an even slide to rest behind it
    body = replace(BODY, load=load)
    final = mean_motion(body, LOADED).velocity

    def slowness(velocity):
        return body.mass / (mean_traction(body, LOADED, [velocity])[0] + load)

    wanted = 0.5 * final
    duration, _ = quad(slowness, 0.0, wanted, epsrel=1e-7)
    found = burst(body, LOADED, duration=duration, after=2.0 * duration, tolerance=TOLERANCE, samples=90)
    assert found.method == "quasi-static"
    assert found.velocity_at_burst_end == pytest.approx(wanted, rel=3e-4)
    stop = body.mass * abs(found.velocity_at_burst_end) / (0.18 * body.preload + load)  # the load helps to stop it
    halfway = duration + 0.5 * stop
    after = found.time >= duration
    assert np.interp(halfway, found.time[after], found.velocity[after]) == pytest.approx(0.5 * wanted, rel=2e-2)


def test_a_burst_under_an_envelope_is_that_of_the_smaller_wave():
    half = Envelope(time=np.array([0.0]), amplitude=np.array([0.5]), phase=np.array([0.0]))
    options = {"duration": 5e-4, "after": 0.0, "tolerance": TOLERANCE, "samples": 10, "method": "quasi-static"}
    light = wave(strip_width=0.25e-3, loading=False)
    shaped, small = burst(BODY, light, envelope=half, **options), burst(BODY, light.scaled(0.5), **options)
    assert shaped.velocity_at_burst_end == pytest.approx(small.velocity_at_burst_end, rel=1e-4)


@pytest.mark.parametrize(
    ("question", "sentence"),
    [
        (lambda: steady(BODY, LOADED, tolerance=1e-3, method="exact"), "it loads the wave"),
        (lambda: burst(BODY, LOADED, duration=1e-4, after=0.0, tolerance=1e-3, samples=5, method="exact"), "loads the"),
        (lambda: burst(BODY, LOADED, duration=1e-4, after=(0.0, None), tolerance=1e-3, samples=5), None),
        (lambda: step(BODY, LOADED, cycles=3), "loads the wave"),
        (lambda: contact_history(BODY, LOADED, stage="steady", skip=0, cycles=1, points_per_cycle=9), "loads the wave"),
        (lambda: release(replace(BODY, backing="soft"), LOADED), "its backing is soft"),
    ],
)
def test_motions_within_a_cycle_are_refused_on_a_loaded_wave(question, sentence):
    if sentence is None:
        assert question().method == "quasi-static"
        return
    with pytest.raises(ConvergenceError, match=sentence):
        question()


@pytest.mark.parametrize(
    ("question", "sentence"),
    [
        (lambda: steady(replace(BODY, tilt="free"), orbit(3e-9), tolerance=1e-3), "slider.tilt must be .* PassingWave"),
        (
            lambda: burst(replace(BODY, mass=math.inf), LOADED, duration=1e-4, after=0.0, tolerance=1e-3, samples=5),
            "slider.mass must be finite",
        ),
        (lambda: steady(slider(law="hysteretic"), LOADED, tolerance=1e-3), 'slider.law must be "elastic"'),
        (lambda: steady(slider(preload=0.0), LOADED, tolerance=1e-3), "slider.preload must be positive"),
        (lambda: wave(loading="some"), 'wave.loading must be true, false or "harmonics"'),
    ],
)
def test_what_the_averaged_motion_does_not_know_is_refused(question, sentence):
    with pytest.raises(InputError, match=sentence):
        question()


def test_an_answer_of_each_contact_has_one_of_those_that_are_equal_and_in_one_row():
    """Four balls in two rows, of which two are equal: their answers are those of orbits given for each."""
    passing = wave(frequency=2.2e6, wavelength=1.8e-3, forward=6e-9, loading=False)
    balls = slider(x=[0.0, 2e-4, 0.0, 2e-4], y=[0.0, 0.0, 1e-4, 1e-4], heights=[0.0, 0.0, 0.0, 1e-10])
    balls = replace(balls, mass=4 * balls.mass, preload=4 * balls.preload)
    given = replace(balls, x=0.0, y=0.0), passing.orbits_at(balls.x)
    for surface in (given, (balls, passing)):
        forces = mean_forces(*surface, mean_motion(*surface))
        history = contact_history(*surface, stage="steady", skip=0, cycles=1, points_per_cycle=20)
        parted = [each.value for each in releases(*surface)]
        assert forces.normal.shape == (4,)
        assert forces.normal[0] == pytest.approx(forces.normal[2], rel=1e-12)
        assert forces.normal.sum() == pytest.approx(balls.preload, rel=1e-6)
        assert history.normal_force.shape[1] == len(parted) == 4
        np.testing.assert_allclose(history.normal_force[:, 0], history.normal_force[:, 2], rtol=1e-9)
        assert parted[0] == pytest.approx(parted[2], rel=1e-12)


@pytest.mark.parametrize("held", [{"tilt": "pitch", "preload_at": (1e-4, 0.0)}, {"backing": "soft"}, {}])
@pytest.mark.parametrize("loading", [False, True])
def test_the_traction_on_a_part_of_the_wave_is_that_on_a_smaller_wave(held, loading):
    """In a burst height, tilts and rows follow the wave: one search at several factors, and one of its own for each."""
    body, passing = replace(BODY, **held), replace(LOADED, loading=loading)
    search = CoupledSearch(body, passing)
    for factor in (1.0, 0.5, 0.0, 0.7):
        found = search.traction(-0.3, 0.0, factor)
        alone = CoupledSearch(body, passing.scaled(factor)).traction(-0.3, 0.0) if factor else 0.18 * body.preload
        assert found == pytest.approx(alone, rel=1e-10)
