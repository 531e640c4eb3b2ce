"""Many problems at once: the states of the full motion, errors that are true, and answers that know no neighbours."""

import math

import numpy as np
import pytest

from contact import Orbit, blocked_thrust, mean_motion, steady, steady_sweep, threshold_factor
from contact.error_estimate import reference_speed
from studies.solve.velocity_error import velocity_sensitivities
from tests.contact.motors import orbit, slider

SLIDERS = [slider(preload=p, friction_coefficient=mu) for p in (3e-4, 2e-3) for mu in (0.05, 0.2)]
TILTED = (Orbit(frequency=2.2e6, normal=1.0, tangential=0.6 * np.exp(1.45j)),)
WAVES = [(orbit(1.0),), TILTED]
FACTORS = (0.4e-9, 1.1e-9, 3e-9, 14e-9)
ALL = [(s, w, f) for s in range(len(SLIDERS)) for w in range(2) for f in FACTORS]


def solved(problems=ALL, errors=(0.0, 2e-4), threads=1):
    return steady_sweep(
        SLIDERS,
        WAVES,
        which=[(s, w) for s, w, _ in problems],
        factors=[f for _, _, f in problems],
        wave_errors=errors,
        threads=threads,
    )


def test_states_are_those_of_the_full_motion():
    found = solved()
    for k in range(0, len(ALL), 3):
        s, w, factor = ALL[k]
        orbits = tuple(each.scaled(factor) for each in WAVES[w])
        full = steady(SLIDERS[s], orbits, tolerance=1e-3)
        reference = reference_speed(full.velocity, orbits)
        assert abs(found.velocity[k] - full.velocity) <= 2e-8 * reference
        assert found.regime[k] == full.regime


def test_errors_are_those_of_the_wave_carried_through_the_contact():
    found = solved()
    for k in range(0, len(ALL), 5):
        s, w, factor = ALL[k]
        orbits = tuple(each.scaled(factor) for each in WAVES[w])
        error = (0.0, 2e-4)[w]
        _, change = velocity_sensitivities(
            found.velocity[k], orbits, error, lambda some, s=s: mean_motion(SLIDERS[s], some).velocity
        )
        expected = error * change
        assert found.error_from_wave[k] == pytest.approx(expected, rel=1e-2, abs=1e-12)


def test_an_answer_knows_neither_its_neighbours_nor_the_threads():
    found, threaded = solved(), solved(threads=3)
    one_by_one = [solved([problem]) for problem in ALL]
    for name in ("velocity", "height", "relative_error", "error_from_wave", "blocked_thrust"):
        whole = getattr(found, name)
        assert np.array_equal(whole, getattr(threaded, name))
        assert np.array_equal(whole, [getattr(each, name)[0] for each in one_by_one])


def test_blocked_thrust_is_the_load_that_stalls():
    found = solved()
    moving = np.flatnonzero(~found.held)
    assert moving.size > 10
    for k in moving[::4]:
        s, w, factor = ALL[k]
        expected, _ = blocked_thrust(SLIDERS[s], tuple(each.scaled(factor) for each in WAVES[w]))
        assert found.blocked_thrust[k] == pytest.approx(expected, rel=1e-9)
    assert all(found.blocked_thrust[found.held] == 0.0)
    # the error of averaging, 3 (f_n/f)^2, as `stall` states it
    ratios = np.array([SLIDERS[s].normal_resonance(len(WAVES[w])) / WAVES[w][0].frequency for s, w, _ in ALL])
    assert found.blocked_thrust_error == pytest.approx(3.0 * ratios**2 * found.blocked_thrust, rel=1e-9)


def test_the_wave_that_runs_the_other_way_drives_the_other_way():
    mirrored = [tuple(each.mirrored() for each in orbits) for orbits in WAVES]
    which, factors = [(0, 0), (1, 1)], [3e-9, 3e-9]
    one = steady_sweep(SLIDERS, WAVES, which=which, factors=factors, wave_errors=(0.0, 0.0), threads=1)
    other = steady_sweep(SLIDERS, mirrored, which=which, factors=factors, wave_errors=(0.0, 0.0), threads=1)
    assert one.velocity[0] > 0.0
    assert np.array_equal(one.velocity, -other.velocity)


@pytest.mark.parametrize("changed", [{"law": "hysteretic"}, {"reciprocal": True}, {"mass": 1e-9}])
def test_what_it_does_not_know_it_leaves(changed):
    found = steady_sweep([slider(**changed)], WAVES[:1], which=[(0, 0)], factors=[3e-9], wave_errors=[0.0], threads=1)
    assert found.regime[0] == "unknown"
    assert math.isnan(found.velocity[0])


@pytest.mark.parametrize("below", [1e-4, 1e-5])
def test_what_is_close_to_the_threshold_may_be_wrong_by_what_lies_beyond_it(below):
    factor = threshold_factor(SLIDERS[3], WAVES[0]) * (1 - below)
    found = solved([(3, 0, factor)])
    orbits = tuple(each.scaled(factor) for each in WAVES[0])
    full = steady(SLIDERS[3], orbits, tolerance=1e-3)
    assert full.relative_error > 0.0
    assert found.relative_error[0] == pytest.approx(full.relative_error, rel=1e-9)
    assert abs(found.velocity[0] - full.velocity) <= found.relative_error[0] * reference_speed(0.0, orbits)
