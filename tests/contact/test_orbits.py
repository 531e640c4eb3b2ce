"""Orbits of many contacts as arrays: those of single contacts (property), to the last bit."""

import cmath
import math
import re

import numpy as np
import pytest

from contact import Orbit, Orbits, as_orbits, steady, steady_sweep
from contact.orbit import drive_direction, towards_plus
from tests.contact.motors import slider

RNG = np.random.default_rng(5)
U_Z, U_X, U_Y = (RNG.normal(size=(3, 17)) + 1j * RNG.normal(size=(3, 17))) * 1e-8
MANY = Orbits(frequency=2.2e6, normal=U_Z, tangential=U_X, lateral=U_Y)
LISTED = tuple(
    Orbit(frequency=2.2e6, normal=complex(z), tangential=complex(x), lateral=complex(y))
    for z, x, y in zip(U_Z, U_X, U_Y, strict=True)
)
FACTOR = 1.7 * cmath.exp(0.3j)


def test_the_sequence_of_an_orbits_is_that_of_its_orbit():
    assert tuple(MANY) == LISTED
    assert as_orbits(LISTED) == MANY
    assert hash(as_orbits(LISTED)) == hash(MANY)
    assert tuple(MANY[3:5]) == LISTED[3:5]
    assert as_orbits(MANY) is MANY
    assert as_orbits(LISTED[0]) == MANY[:1] != MANY[1:2]


@pytest.mark.parametrize("change", [lambda each: each.scaled(FACTOR), lambda each: each.mirrored()])
def test_a_change_of_all_orbits_is_that_of_each(change):
    assert tuple(change(MANY)) == tuple(map(change, LISTED))


def test_sizes_and_crests_are_those_of_each_orbit():
    speeds = [(1j * o.omega * o.tangential * o.normal.conjugate()).real / abs(o.normal) for o in LISTED]
    assert MANY.crest_velocities.tolist() == speeds
    assert drive_direction(MANY) == math.copysign(1.0, sum(speeds))
    assert MANY.peak_speed == max(o.omega * abs(o.tangential) for o in LISTED)
    assert MANY.reach == max(max(abs(o.normal), abs(o.tangential)) for o in LISTED)
    side, driven = towards_plus(MANY)
    assert drive_direction(driven) == 1.0
    assert tuple(driven) == (LISTED if side > 0 else tuple(MANY.mirrored()))
    still = Orbits(frequency=1e6, normal=[0.0], tangential=[0.0])
    assert still.still
    assert still.alike
    assert still.crest_velocities[0] == 0.0
    assert not MANY.still
    assert not MANY.alike


def test_unequal_waves_of_a_sweep_have_the_answer_of_each_alone():
    ball, right = slider(), Orbits(frequency=2.2e6, normal=[10e-9], tangential=[-7e-9j])
    waves = [right, right.mirrored(), right.scaled(0.01), right.mirrored().scaled(0.01)]
    swept = steady_sweep(
        [ball], waves, which=[(0, k) for k in range(4)], factors=np.ones(4), wave_errors=np.zeros(4), threads=1
    )
    assert swept.velocity.tolist() == [-v for v in swept.velocity[[1, 0, 3, 2]]]
    alone = steady(ball, right[0], tolerance=1e-3, method="averaged").velocity
    assert swept.velocity[0] == alone > 0.0


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"normal": [1e-9, math.nan]}, "orbit.normal must be a finite complex number, got (nan+0j) m"),
        ({"frequency": 0.0}, "orbit.frequency must be positive and finite, got 0.0 Hz"),
        ({"normal": [1e-9]}, "orbits must hold at least one orbit, with as many amplitudes u_x as u_z"),
        ({"lateral": [1e-9, math.inf]}, "orbit.lateral must be a finite complex number, got (inf+0j) m"),
    ],
)
def test_orbits_refuse_what_is_not_finite_or_of_another_number(changed, sentence):
    given = {"frequency": 2.2e6, "normal": [1e-9, 1e-9], "tangential": [1e-9, 1e-9]}
    with pytest.raises(ValueError, match=re.escape(sentence)):
        Orbits(**given | changed)
