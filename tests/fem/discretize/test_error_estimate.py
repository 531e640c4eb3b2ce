"""The loop over levels of discretisation, on sequences whose answers are known."""

import pytest

from fem.discretize.error_estimate import refine
from fem.exceptions import ConvergenceError


def refined(answers, tolerance, start=0):
    """A ConvergenceError stands for a level without an answer."""

    def at_level(answer):
        if isinstance(answer, Exception):
            raise answer
        return answer

    return refine(
        at_level,
        answers,
        start=start,
        differences=lambda fine, coarse: (abs(fine - coarse), 10 * abs(fine - coarse)),
        gain=5.0,
        tolerance=tolerance,
    )


def test_answer_before_the_differences_grow_is_kept():
    """The last level of a sequence towards 1 is off by 0.3: the one before is the answer, and the error covers both."""
    result = refined((1.5, 1.1, 1.02, 1.32), tolerance=1e-3)
    assert (result.answer, result.level) == (1.02, 2)
    assert result.errors == pytest.approx((0.3 / 4, 3.0 / 4))
    assert "(error 7.5e-02) than that from the one before (2.0e-02)" in result.obstacle


def test_a_growing_difference_does_not_end_the_refinement():
    result = refined((1.0, 1.01, 1.05, 1.0501), tolerance=1e-3)
    assert (result.answer, result.level, result.obstacle) == (1.0501, 3, "")
    assert result.errors[0] == pytest.approx(1e-4 / 4)


def test_falling_differences_end_at_the_last_level():
    result = refined((1.5, 1.1, 1.02, 1.004), tolerance=1e-6)
    assert (result.answer, result.level, result.obstacle) == (1.004, 3, "")


def test_a_level_without_an_answer_is_the_obstacle():
    result = refined((1.5, 1.1, ConvergenceError("too fine")), tolerance=1e-3)
    assert (result.answer, result.errors[0], result.obstacle) == (1.1, pytest.approx(0.1), "too fine")


def test_the_last_pair_of_levels_is_compared_with_the_level_before():
    result = refined((1.5, 1.1, 1.02, 1.32), tolerance=1e-6, start=2)
    assert (result.answer, result.level) == (1.02, 2)
    assert result.errors[0] == pytest.approx(0.3 / 4)
    assert refined((1.5, 1.1, 1.02, 1.004), tolerance=1e-6, start=2).answer == 1.004
