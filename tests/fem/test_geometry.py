"""Where fingers lie and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fem.analytic.half_space import automatic_period, rayleigh
from fem.geometry import CLEARANCE, Stator, Transducer, outer_gaps
from fem.layout import check_layout
from tests.fem.stators import cut, lossless

SOLID = cut("PZT-8", "Z")
STATOR = Stator(solid=SOLID, length=0.16, thickness=5e-3, ends="free")
LEFT = Transducer(name="left", center=15e-3, finger_pairs=10, period=1e-3, metallisation=0.5, aperture=20e-3)


@given(
    center=st.floats(-1, 1), pairs=st.integers(1, 50), period=st.floats(1e-6, 1e-2), metallisation=st.floats(0.02, 0.98)
)
def test_fingers(center, pairs, period, metallisation):
    """Equal fingers half a period apart, symmetric about the centre; width over pitch is the metallisation."""
    comb = replace(LEFT, center=center, finger_pairs=pairs, period=period, metallisation=metallisation)
    fingers = comb.fingers
    middles = fingers.mean(axis=1)
    assert fingers.shape == (2 * pairs, 2)
    assert np.diff(middles) == pytest.approx(period / 2, rel=1e-9)
    assert np.diff(fingers, axis=1) == pytest.approx(metallisation * period / 2, rel=1e-9, abs=1e-15)
    assert middles.mean() == pytest.approx(center, abs=1e-9 * period + 1e-15)
    assert (fingers[0, 0], fingers[-1, 1]) == pytest.approx(comb.extent, abs=1e-9 * period + 1e-15)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"period": 0.0}, "'left'.period must be positive and finite, got 0.0 m"),
        ({"aperture": np.nan}, "'left'.aperture must be positive and finite, got nan m"),
        ({"center": np.inf}, "'left'.center must be finite, got inf m"),
        ({"finger_pairs": 0}, "'left'.finger_pairs must be an integer from 1 to 100000, got 0"),
        ({"finger_pairs": 2.5}, "'left'.finger_pairs must be an integer from 1 to 100000, got 2.5"),
        ({"finger_pairs": 2.0}, "'left'.finger_pairs must be an integer from 1 to 100000, got 2.0"),
        ({"metallisation": 1.0}, "'left'.metallisation must be between 0.001 and 0.999, got 1.0"),
        ({"metallisation": np.nan}, "'left'.metallisation must be between 0.001 and 0.999, got nan"),
        ({"termination": "closed"}, '\'left\'.termination must be "open" or "short" or a finite number'),
        (
            {"termination": complex(np.nan, 1)},
            "'left'.termination must be .* a finite number, real or complex, got \\(nan",
        ),
    ],
)
def test_transducers_that_are_none(changes, message):
    with pytest.raises(ValueError, match=message):
        replace(LEFT, **changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"length": -1.0}, r"stator.length must be positive and finite, got -1.0 m"),
        ({"length": np.inf}, r"stator.length must be positive and finite, got inf m"),
        ({"thickness": 0.0}, r"stator.thickness must be positive, got 0.0 m"),
        ({"thickness": np.nan}, r"stator.thickness must be positive, got nan m"),
        (
            {"bottom": "glued"},
            r"stator.bottom must be \"free\" or \"grounded\" or \"clamped\" or \"absorbing\", got 'glued'",
        ),
        ({"ends": "open"}, r"stator.ends must be \"absorbing\" or \"free\" or \"clamped\", got 'open'"),
        ({"above": "air"}, r"stator.above must be \"none\" or \"vacuum\", got 'air'"),
    ],
)
def test_stators_that_are_none(changes, message):
    with pytest.raises(ValueError, match=message):
        replace(STATOR, **changes)


def test_layout():
    check_layout(STATOR, (LEFT, replace(LEFT, name="right", center=0.145)))
    with pytest.raises(
        ValueError, match=r"'left'.center must keep the fingers on the stator, 0 to 160 mm, got fingers from"
    ):
        check_layout(STATOR, (replace(LEFT, center=4e-3),))
    with pytest.raises(ValueError, match=r"'left'.center must keep the fingers"):
        check_layout(STATOR, (replace(LEFT, center=0.158),))
    with pytest.raises(ValueError, match=r"off those of 'left': the former begin at .* mm, the latter end at 19"):
        check_layout(STATOR, (replace(LEFT, name="right", center=24e-3), LEFT))
    with pytest.raises(ValueError, match=r"transducer 'left'.name must differ from the others, got 'left' twice"):
        check_layout(STATOR, (LEFT, replace(LEFT, center=0.1)))


def test_outer_gaps_leave_room_for_the_neighbour():
    half = 0.125e-3
    near = replace(LEFT, name="near", center=LEFT.extent[1] + 0.1e-3 + LEFT.center - LEFT.extent[0])
    (alone,) = outer_gaps(STATOR, (LEFT,))
    assert alone == pytest.approx((half, half))
    first, second = outer_gaps(STATOR, (LEFT, near))
    assert first == pytest.approx((half, CLEARANCE * 0.1e-3))
    assert second == pytest.approx((CLEARANCE * 0.1e-3, half))
    assert first[1] + second[0] < 0.95 * 0.1e-3
    edge = replace(LEFT, center=LEFT.center - LEFT.extent[0] + 0.02e-3)
    assert outer_gaps(STATOR, (edge,))[0] == pytest.approx((CLEARANCE * 0.02e-3, half))


def test_automatic_period_lies_between_the_two_waves():
    solid = lossless("LiNbO3 (Kovacs)", "128YX")
    metal, vacuum = (rayleigh(solid, surface).velocity for surface in ("metallised", "vacuum"))
    assert automatic_period(solid, 1e8, 0.25) == pytest.approx((0.25 * metal + 0.75 * vacuum) / 1e8, rel=1e-12)


def test_a_refusal_names_key_rule_value_and_transducer():
    import pickle

    from fem import InputError

    right = {
        "name": "right",
        "center": 4e-3,
        "finger_pairs": 3,
        "period": 1e-3,
        "metallisation": 0.5,
        "aperture": -2e-3,
    }
    with pytest.raises(InputError) as caught:
        Transducer(**right)
    error = pickle.loads(pickle.dumps(caught.value))
    assert (error.key, error.owner, error.value) == ("transducer.aperture", "right", -2e-3)
    assert error.rule == "must be positive and finite, got -0.002 m"
    assert str(error) == f"transducer 'right'.aperture {error.rule}"
