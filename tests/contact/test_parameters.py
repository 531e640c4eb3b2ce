"""Refusals: each names the parameter, the rule, the value and the unit."""

import math
import re
from dataclasses import replace
from functools import partial

import pytest

from contact import Orbit, burst, contact_history, steady
from contact.orbit import as_orbits
from tests.contact.motors import orbit, slider


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("radius", -1e-6, "slider.radius must be positive and finite, got -1e-06 m"),
        ("mass", 0.0, "slider.mass must be positive and finite, got 0.0 kg"),
        ("mass", math.nan, "slider.mass must be positive and finite, got nan kg"),
        ("preload", -1e-3, "slider.preload must be zero or positive, and finite, got -0.001 N"),
        ("load", math.inf, "slider.load must be zero or positive, and finite, got inf N"),
        ("effective_modulus", "stiff", "slider.effective_modulus must be positive and finite, got 'stiff' Pa"),
        ("tangential_modulus", [1.0], "slider.tangential_modulus must be positive and finite, got [1.0] Pa"),
        ("friction_coefficient", -0.1, "slider.friction_coefficient must be zero or positive, and finite, got -0.1"),
        ("stick_band", -1.0, "slider.stick_band must be zero or positive, and finite, got -1.0 m/s"),
        ("contact_damping", True, "slider.contact_damping must be zero or positive, and finite, got True s/m"),
        ("law", "plastic", "slider.law must be one of 'elastic', 'hysteretic', got 'plastic'"),
        ("reciprocal", 1, "slider.reciprocal must be true or false, got 1"),
    ],
)
def test_a_slider_refuses_what_is_not_physical(name, value, sentence):
    with pytest.raises(ValueError, match="^" + re.escape(sentence) + "$"):
        slider(**{name: value})


@pytest.mark.parametrize(
    "name", ["load", "preload", "friction_coefficient", "normal_damping", "tangential_damping", "contact_damping"]
)
def test_zero_is_allowed_where_it_means_absence(name):
    assert getattr(slider(**{name: 0}), name) == 0.0


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"frequency": 0.0}, "orbit.frequency must be positive and finite, got 0.0 Hz"),
        ({"normal": complex(math.nan, 0)}, "orbit.normal must be a finite complex number, got (nan+0j) m"),
        ({"tangential": "far"}, "orbit.tangential must be a finite complex number, got 'far' m"),
    ],
)
def test_an_orbit_refuses_what_is_not_finite(changed, sentence):
    with pytest.raises(ValueError, match=re.escape(sentence)):
        Orbit(**({"frequency": 2.2e6, "normal": 1e-9, "tangential": 1e-9} | changed))


def test_contacts_share_one_frequency_and_there_is_at_least_one():
    with pytest.raises(ValueError, match="at least one Orbit"):
        as_orbits(())
    with pytest.raises(ValueError, match="share one frequency"):
        as_orbits((orbit(1e-9), orbit(1e-9, frequency=1e6)))
    with pytest.raises(ValueError, match="objects of type Orbit"):
        as_orbits((1e-9,))


def test_a_stick_band_with_the_hysteretic_law_is_refused():
    with pytest.raises(ValueError, match="stick_band must be 0"):
        slider(law="hysteretic", stick_band=1e-4)


def test_calls_refuse_a_tolerance_of_zero_and_an_unknown_method():
    with pytest.raises(ValueError, match=re.escape("tolerance must be positive and finite, got 0")):
        steady(slider(), orbit(3e-9), tolerance=0)
    with pytest.raises(ValueError, match="method must be one of"):
        steady(slider(), orbit(3e-9), tolerance=1e-6, method="guess")
    with pytest.raises(ValueError, match="samples must be a whole number of at least 2, got 1"):
        burst(slider(), orbit(3e-9), duration=1e-5, after=0.0, tolerance=1e-6, samples=1)
    with pytest.raises(ValueError, match="stage must be one of"):
        contact_history(slider(), orbit(3e-9), stage="end", skip=0, cycles=1, points_per_cycle=8)


def test_a_refusal_names_key_rule_and_value():
    import pickle

    from contact import InputError

    with pytest.raises(InputError) as caught:
        slider(mass=-2e-3)
    error = pickle.loads(pickle.dumps(caught.value))
    assert (error.key, error.value) == ("slider.mass", -2e-3)
    assert error.rule == "must be positive and finite, got -0.002 kg"
    assert str(error) == f"slider.mass {error.rule}"


def test_stiffnesses_need_the_shape_that_their_unit_depends_on():
    sentence = 'slider.shape is required with slider.normal_stiffness, in N/m^1.5 of a "sphere" and N/m of a "punch"'
    own = {"normal_stiffness": 1.8e6, "tangential_stiffness": 1.52e6, "radius": None}
    for make in (slider, partial(replace, slider())):
        with pytest.raises(ValueError, match=re.escape(sentence)):
            make(**own)
        assert make(**own, shape="sphere").stiffness_unit == 1.8e6
    assert replace(slider(), preload=1e-3).shape == "sphere"
    with pytest.raises(ValueError, match="shape is required"):
        replace(replace(slider(), preload=1e-3), **own)
