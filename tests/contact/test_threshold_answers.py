"""Thresholds with their errors: infinite where nothing moves the slider; averaging's own error; mirror images."""

import math
from dataclasses import replace

import numpy as np
import pytest

from contact import Orbit, release, releases, steady, threshold, threshold_factor
from tests.contact.motors import slider

F = 2.2e6
LAWS = ({}, {"law": "hysteretic"}, {"reciprocal": True}, {"shape": "punch", "radius": 2e-6})


def orbit(normal, tangential, frequency=F):
    return Orbit(frequency=frequency, normal=normal, tangential=tangential)


NOTHING_MOVES = {
    "opposed": (orbit(1e-9, -0.7e-9j), orbit(1e-9, 0.7e-9j)),
    "opposed, a quarter of a cycle apart": (orbit(1e-9, -0.7e-9j), orbit(1e-9j, -0.7e-9)),
    "three, of which two oppose the first": (orbit(2e-9, 0), orbit(1e-9, -0.7e-9j), orbit(1e-9, 0.7e-9j)),
    "normal only": (orbit(1e-9, 0),),
    "tangential only": (orbit(0, 1e-9),),
    "two tangential": (orbit(0, 1e-9), orbit(0, 0.5e-9j)),
}


@pytest.mark.parametrize("changed", LAWS)
@pytest.mark.parametrize("name", NOTHING_MOVES)
def test_what_drives_both_ways_alike_never_moves_the_slider(name, changed):
    answer = threshold(slider(**changed), NOTHING_MOVES[name])
    assert (answer.value, answer.error, answer.status) == (math.inf, 0.0, "ok")
    # a quarter of a cycle apart the mirror image is no later instant of the same: there the climb ends
    assert "both ways" in answer.message or ("quarter" in name and "100 times" in answer.message)


def test_opposed_contacts_move_it_once_one_is_weaker_or_higher_or_it_is_loaded():
    first, second = NOTHING_MOVES["opposed"]
    body, weaker = slider(), (first, replace(second, tangential=0.6e-9j))
    for changed, wave in ((body, weaker), (slider(heights=(0.0, 3e-10)), (first, second))):
        factor = threshold_factor(changed, wave)
        assert math.isfinite(factor)
        moving = steady(changed, tuple(each.scaled(1.05 * factor) for each in wave), tolerance=1e-6)
        assert moving.velocity != 0.0
    assert threshold_factor(slider(load=3e-5), (first, second)) < threshold_factor(body, weaker)


def test_a_climb_without_end_ends():
    """A second contact that nothing moves holds the slider however strongly the first is driven, up to the climb."""
    held = (orbit(0.0, 1e-15), orbit(1e-12, -0.7e-12j))
    answer = threshold(slider(), held)
    assert answer.value > 0.0
    assert not math.isnan(answer.error)


@pytest.mark.parametrize("phases", [(0.0,), (0.0, 0.7), (0.0, 1.3, 2.9)])
@pytest.mark.parametrize("changed", [{}, {"shape": "punch", "radius": 3e-6}, {"load": 9e-5}])
def test_the_error_of_averaging_holds_against_the_full_motion(phases, changed):
    """Bisection of the exact steady motion at f_n/f = 0.2, where averaging errs by some per cent."""
    body = slider(
        mass=2e-6, preload=2e-3, friction_coefficient=0.15, normal_damping=0.25, tangential_damping=0.0, **changed
    )
    frequency = body.normal_resonance(len(phases)) / 0.2
    wave = tuple(orbit(4e-9, -2.8e-9j, frequency).scaled(np.exp(1j * phase)) for phase in phases)

    def full(factor):
        return steady(body, tuple(each.scaled(factor) for each in wave), tolerance=1e-6, method="exact")

    questions = ((threshold, lambda k: full(k).velocity != 0.0), (release, lambda k: full(k).statistics["release"] > 0))
    for question, beyond in questions:
        answer = question(body, wave)
        low, high = answer.value - 2.0 * answer.error, answer.value + 2.0 * answer.error
        assert not beyond(low)
        assert beyond(high)
        # and it is no larger than needed
        assert answer.error < 0.07 * answer.value


def test_a_mirrored_loaded_orbit_out_of_quadrature_has_the_same_threshold():
    """The load opposes the drive of either."""
    body = slider(load=2.5e-5)
    wave = orbit(1.5e-9, 0.9e-9 * np.exp(-1.1j))
    factor = threshold_factor(body, wave)
    assert threshold_factor(body, wave.mirrored()) == pytest.approx(factor, rel=1e-12)
    assert threshold_factor(body, wave.scaled(np.exp(0.4j))) == pytest.approx(factor, rel=1e-7)
    # the load opposes the motion: without it the slider starts later on this orbit
    assert abs(factor / threshold_factor(slider(), wave) - 1.0) > 0.05
    moving = steady(body, wave.scaled(1.01 * factor), tolerance=1e-6)
    still = steady(body, wave.scaled(0.99 * factor), tolerance=1e-6)
    assert (moving.velocity != 0.0, still.velocity) == (True, 0.0)


@pytest.mark.parametrize("phase", [-1.9, -1.1, -0.2, 0.05, 0.6, 1.1, 2.0])
@pytest.mark.parametrize("load", [1e-5, 3e-5])
def test_a_loaded_slider_starts_where_the_steady_state_does_out_of_quadrature(phase, load):
    """Also on orbits that drive against their crests: the load's direction is that of `steady`."""
    body, wave = slider(load=load), orbit(1e-9, 0.8e-9 * np.exp(1j * phase))
    answer = threshold(body, wave)

    def moves(factor):
        return steady(body, wave.scaled(factor), tolerance=1e-2, method="averaged").velocity != 0.0

    assert not any(moves(share * answer.value) for share in (0.3, 0.5, 0.7, 0.9))
    low, high = 0.95 * answer.value, 1.05 * answer.value
    while high - low > 1e-4 * answer.value:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if moves(middle) else (middle, high)
    assert high == pytest.approx(answer.value, rel=1e-3)  # f_n/f = 0.02


@pytest.mark.parametrize("changed", [{}, {"shape": "punch", "radius": 3e-6}, {"load": 9e-5}, {"contact_damping": 1e-6}])
def test_one_contact_parts_and_slips_where_the_full_motion_does(changed):
    """To 2e-6 of the factor, where first-order averaging errs by some per cent."""
    body = slider(
        mass=2e-6, preload=2e-3, friction_coefficient=0.15, normal_damping=0.25, tangential_damping=0.0, **changed
    )  # fmt: skip
    wave = orbit(4e-9, -2.8e-9j, body.normal_resonance(1) / 0.2)
    for question, event in ((threshold, "stick_to_slip"), (release, "release")):
        answer = question(body, wave)
        assert answer.error < 3e-6 * answer.value
        below, above = (
            steady(body, wave.scaled(answer.value * (1.0 + side * 4e-6)), tolerance=1e-6, method="exact")
            for side in (-1.0, 1.0)
        )
        assert below.statistics[event] == 0
        assert above.statistics[event] > 0


UNEQUAL = {
    "heights": (slider(heights=(0.0, -1e-9, -0.4e-9)), (orbit(1e-9, -0.7e-9j),) * 3),
    "orbits": (slider(), (orbit(1e-9, -0.7e-9j), orbit(0.6e-9j, -0.5e-9))),
    "both": (slider(heights=(0.0, 0.5e-9)), (orbit(1e-9, -0.7e-9j), orbit(0.8e-9, -0.7e-9j))),
}


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("name", UNEQUAL)
def test_each_contact_leaves_the_surface_above_its_own_factor(name, side, order):
    body, wave = UNEQUAL[name]
    wave = tuple(replace(each, tangential=side * each.tangential) for each in wave)[::order]
    body = replace(body, heights=body.heights[::order])
    found = [each.value for each in releases(body, wave)]
    assert min(found) == release(body, wave).value
    assert max(found) > 1.05 * min(found)
    for number in range(len(wave) + 1):
        # between two of them, so many contacts leave once per cycle
        ends = [0.8 * min(found), *sorted(found), 1.2 * max(found)]
        factor = 0.5 * (ends[number] + ends[number + 1])
        moving = steady(body, tuple(each.scaled(factor) for each in wave), tolerance=1e-6, method="exact")
        assert moving.statistics["release"] == number, (number, factor)


def test_contacts_in_the_air_have_no_release():
    body, wave = slider(heights=(0.0, -300e-9)), (orbit(1e-9, -0.7e-9j),) * 2
    first, second = releases(body, wave)
    assert second is None
    assert first == release(body, wave)
    assert all(math.isinf(each.value) for each in releases(slider(), (orbit(0, 1e-9),) * 2))


def test_a_load_may_move_a_slider_within_a_narrow_range_of_amplitudes():
    """Two unequal balls are held below 0.396, move up to 1.05 times that, and are held again up to 1.1 times."""
    loaded = slider(preload=3.6e-4, load=3.35e-6, friction_coefficient=0.178, heights=(0.0, -6.1e-10))
    first = orbit(1e-9 * np.exp(2.0499j), 0.9896e-9 * np.exp(-2.5156j))
    second = orbit(1e-9 * np.exp(2.8830j), 0.5919e-9 * np.exp(2.4311j))

    def speed(factor):
        waves = [each.scaled(factor) for each in (first, second)]
        return steady(loaded, waves, tolerance=1e-6, method="exact").velocity

    found = threshold_factor(loaded, (first, second))
    assert [speed(share * found) > 5e-6 for share in (0.98, 1.02, 1.09, 1.12)] == [False, True, False, True]
