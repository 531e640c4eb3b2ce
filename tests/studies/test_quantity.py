"""Quantities: pint is the oracle of the table of units; the texts of the contract are read exactly."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.refusal import SceneError
from studies.scene.quantity import DIMENSIONS, POWERS, si_value

SI = {"N s/m": "N*s/m", "kg/m^3": "kg/m^3"}


@pytest.fixture(scope="module")
def registry():
    import pint

    return pint.UnitRegistry()


@pytest.mark.parametrize(("unit", "name"), [(unit, name) for unit in POWERS for name in POWERS[unit]])
def test_every_unit_of_the_table_is_what_pint_says(registry, unit, name):
    oracle = registry.Quantity(1.0, name.replace("N s", "N*s")).to(SI.get(unit, unit)).magnitude
    assert si_value("key", f"1 {name}", unit) == pytest.approx(oracle, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("2.2 MHz", "Hz", 2.2e6),
        ("0.267 g", "kg", 0.267e-3),
        ("0.089 g", "kg", 8.9e-05),
        ("900 mm", "m", 0.9),
        ("64GPa", "Pa", 64e9),
        ("9.81 m/s^2", "m/s^2", 9.81),
        ("1e-4 N s/m", "N s/m", 1e-4),
        (" -6 mm ", "m", -0.006),
        (7, "m", 7.0),
    ],
)
def test_texts_are_read_to_the_nearest_float(text, unit, value):
    assert si_value("key", text, unit) == value


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        *[("1 inch", "m", 0.0254), ("1 kilogram*meter/second^2", "N", 1.0), ("1 micrometer", "m", 1e-6)],
        *[("5 1/s", "Hz", 5.0), ("5 1/ms", "Hz", 5e3), ("5 s^-1", "Hz", 5.0), ("2 1/S", "ohm", 2.0)],
        *[("1 g_0", "m/s^2", 9.80665), ("2 g0", "m/s^2", 19.6133), ("1 1/TPa", "1/Pa", 1e-12)],
        *[("1 rad", "deg", 57.29577951308232), ("3 mrad", "deg", 0.1718873385392470), ("0.25 turn", "deg", 90.0)],
        *[("90 \u00b0", "deg", 90.0), ("30 arcmin", "deg", 0.5), ("3 \u00c5", "m", 3e-10), ("3 \u212b", "m", 3e-10)],
        *[("5 \u00b5m", "m", 5e-6), ("5 \u03bcm", "m", 5e-6), ("5 \u03bcN", "N", 5e-6), ("5 \u03bcs", "s", 5e-6)],
        *[("50 \u03a9", "ohm", 50.0), ("50 \u2126", "ohm", 50.0), ("2 k\u2126", "ohm", 2e3)],
        *[("9.8 m/s\u00b2", "m/s^2", 9.8), ("9.8 m/s2", "m/s^2", 9.8), ("5 s\u207b\u00b9", "Hz", 5.0)],
        *[("3 kg/(m s^2)", "Pa", 3.0), ("3 N/mm2", "Pa", 3e6), ("3 mN\u00b7s/m", "N s/m", 3e-3)],
    ],
)
def test_other_units_are_left_to_pint(text, unit, value):
    assert si_value("key", text, unit) == pytest.approx(value, rel=1e-15)


@given(st.floats(1e-12, 1e12), st.sampled_from([(u, n) for u in POWERS for n in POWERS[u]]))
def test_a_number_with_a_unit_is_the_number_times_the_power_of_ten(number, unit_and_name):
    unit, name = unit_and_name
    expected = number * 10.0 ** POWERS[unit][name]
    assert si_value("key", f"{number!r} {name}", unit) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(
    ("value", "unit", "words"),
    [
        ("2 mm", "kg", ["slider.mass", "a mass", "kg", "'2 mm'", "a length"]),
        ("2 inch", "kg", ["another dimension", "a mass"]),
        ("3", "m", ["has no unit", "a length"]),
        ("3 flurbs", "m", ["'flurbs' is no known unit"]),
        ("2 rad/s", "Hz", ["counts angles"]),
        ("60 rpm", "Hz", ["counts angles"]),
        ("5 m*rad", "m", ["counts angles"]),
        ("5 percent", "deg", ["an angle", "'percent' is no angle"]),
        ("5 sr", "deg", ["is no angle"]),
        ("5 (m", "m", ["no known unit"]),
        ("5 1", "Hz", ["is no unit"]),
        ("5 m99", "m", ["is no unit"]),
        ("5 percent", "m", ["another dimension", "percent"]),
        ("nan m", "m", ["a length", "'nan m'"]),
        (float("nan"), "kg", ["finite", "nan kg"]),
        (float("inf"), "kg", ["finite", "inf kg"]),
        ("1e999 mm", "m", ["finite"]),
        (10**400, "m", ["finite"]),
        (True, "m", ["a length", "True"]),
        (None, "m", ["a length", "None"]),
        ([1.0], "m", ["a length", "[1.0]"]),
        ("0.08", "", ["a plain number", "'0.08'"]),
        ("1 m**99999999", "m", ["is no unit"]),
        ("1 m^9^9^9^9", "m", ["slider.mass"]),
        ("1 __import__('os')", "m", ["is no unit"]),
    ],
)
def test_what_is_no_quantity_is_refused_in_one_sentence(value, unit, words):
    with pytest.raises(SceneError) as refusal:
        si_value("slider.mass", value, unit)
    assert all(word in str(refusal.value) for word in ["slider.mass", *words])
    assert "\n" not in str(refusal.value)


@given(st.text(max_size=30), st.sampled_from(sorted(DIMENSIONS)))
def test_any_text_is_read_or_refused(text, unit):
    try:
        value = si_value("key", text, unit)
    except SceneError:
        return
    assert abs(value) < float("inf")
