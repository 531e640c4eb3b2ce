"""Tolerances of the tests: relative ones are relative, however small the expected values are (`tests/conftest.py`)."""

import pytest


@pytest.mark.parametrize(
    ("expected", "value"),
    [(1e-15, 1.1e-15), (1e-15j, 1.1e-15j), ([1e-15, 0.0], [1.1e-15, 0.0]), ({"u": 1e-15}, {"u": 1.1e-15})],
)
def test_no_absolute_tolerance_is_added_to_a_relative_one(expected, value):
    assert value != pytest.approx(expected)
    assert value != pytest.approx(expected, rel=1e-3)
    assert value == pytest.approx(expected, rel=0.2)
    assert value == pytest.approx(expected, abs=1e-12)


def test_an_expected_zero_has_the_usual_tolerance():
    assert pytest.approx(0.0) == 1e-13
    assert pytest.approx(0.0) != 1e-11
