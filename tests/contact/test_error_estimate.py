"""Error estimates by themselves: sequences of known convergence, Student's factor, limits."""

import numpy as np
import pytest
from scipy import stats

from contact import error_estimate as estimate
from contact.periodic.shooting import CycleJacobian


@pytest.mark.parametrize("order", [1, 2])
def test_two_runs_give_the_error_of_the_finer_one(order):
    # Oracle: answers whose error is exactly c h^p
    exact, c, coarse, fine = 0.7, -3.0, 1.0 / 24.0, 1.0 / 32.0
    runs = [exact + c * h**order for h in (coarse, fine)]
    stated = estimate.richardson(abs(runs[1] - runs[0]), coarse / fine, order)
    assert stated == pytest.approx(abs(runs[1] - exact), rel=1e-12)


def test_fixed_steps_converge_with_first_order_and_never_state_nothing():
    assert estimate.stepped_error(1e-3, 48, 24) == pytest.approx(1e-3)
    assert estimate.stepped_error(0.0, 48, 24, expected=1e-4) == pytest.approx(1e-6)


def test_two_event_driven_runs_that_agree_keep_truncation_and_rounding():
    run = {"truncation": 1e-9, "reference": 2.0, "cycles": 100, "segments": 9.0}
    moving = estimate.event_driven_error(0.0, **run, moves=True)
    assert moving == pytest.approx(3e-6 * 1e-9 * 2.0 + 1e-15 * 100 * 2.0 + 4e-16 * 30.0, rel=1e-9, abs=0.0)
    assert estimate.event_driven_error(1e-6, **run, moves=False) == pytest.approx(1e-6, rel=1e-6)


def test_an_optimistic_estimate_is_scaled_by_what_it_missed_in_the_first_cycles():
    assert estimate.calibrated_error(1e-4, 4e-5, 1e-5) == pytest.approx(1.5 * 1e-4 * 3.0 * 4.0)
    assert estimate.calibrated_error(1e-4, 1e-7, 1e-5) == pytest.approx(1.5e-4)  # never below the estimate
    assert estimate.calibrated_error(1e-4, 1e-7, 1e-5, least=0.5) == pytest.approx(0.75e-4)
    assert estimate.calibrated_error(1e-6, 5e-5, 1e-2) == pytest.approx(5e-5)  # nor below the true error there
    assert estimate.calibrated_error(1e-6, None, 0.0) == pytest.approx(5e-6)
    assert estimate.averaged_burst_error(1e-4, 4e-5, 1e-5) == pytest.approx(0.8 * 1e-4 * 5.0 * 4.0)
    assert estimate.averaged_burst_error(1e-4, 1e-7, 1e-5) == pytest.approx(0.8e-4)
    assert estimate.averaged_burst_error(1e-6, 5e-5, 1e-2) == pytest.approx(5e-5)


def test_two_averaged_runs_that_agree_keep_a_share_of_what_their_steps_were_chosen_for():
    assert estimate.averaged_steps_error(0.0, 1e-3) == pytest.approx(3e-6)
    assert estimate.averaged_steps_error(3e-4, 0.0) == pytest.approx(1e-4)


def test_the_error_of_batch_means_is_students():
    # Oracle: scipy.stats; symmetric halves have no drift
    half = np.random.default_rng(5).standard_normal(estimate.BATCHES // 2)
    means = np.append(half, half[::-1])
    low, high = stats.t.interval(0.95, means.size - 1, loc=np.mean(means), scale=stats.sem(means))
    error, spread, drift = estimate.batch_mean_error(means, 0.5)
    assert (spread, drift) == (pytest.approx(0.5 * (high - low), rel=1e-3), pytest.approx(0.0, abs=1e-15))
    assert error == pytest.approx(2.0 * spread)
    assert estimate.batch_mean_error(np.repeat([1.0, 3.0], means.size // 2), 1.0)[2] == 2.0


def test_cycles_amplify_rounding_by_the_multiplier():
    # Closed form: a diagonal cycle map with the multiplier m of the velocity
    jacobian, state = np.diag([0.0, 0.0, 0.99]), np.array([1.0, 1.0, 0.2])
    amplified = CycleJacobian(jacobian, np.eye(3)).amplification(2)
    assert estimate.shooting_rounding(amplified, state, 25) == pytest.approx(
        2.2e-16 * 5.0 * 0.2 / 0.01, rel=1e-9, abs=0.0
    )


def test_errors_of_averaging_grow_as_the_square_of_the_resonance_up_to_a_limit():
    for error, limit in (
        (lambda r: estimate.averaged_threshold_error(r, 0.0), 1.0),
        (estimate.averaged_stall_error, 1.0),
        (lambda r: estimate.larger_wave(r) - 1.0, 0.5),
    ):
        assert error(0.02) == pytest.approx(4.0 * error(0.01))
        assert error(10.0) == limit


def test_a_search_states_the_smaller_of_its_last_change_and_half_its_bracket():
    assert estimate.search_error(1e-3, 1.0, 1.5) == 1e-3
    assert estimate.search_error(1.0, 1.0, 1.5) == 0.25
    assert estimate.bounds_error(1.0, 1.25) == pytest.approx(0.25 + 1e-6)
