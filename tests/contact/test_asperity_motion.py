"""A heavy slider on rough balls, a stop for each asperity: independent values, equal contacts, limits and refusals."""

import numpy as np
import pytest

from contact import (
    Asperities,
    ConvergenceError,
    InputError,
    Orbit,
    RoughBalls,
    Roughness,
    asperity_motion,
    mean_motion,
    steady,
)
from tests.contact.motors import slider

FREQUENCY, RATIO = 2.2e6, 0.67
HEIGHTS = np.array([0.0, -1.0, -1.5, -2.0, -3.0, -4.0]) * 1e-9


def orbit(amplitude):
    return Orbit(frequency=FREQUENCY, normal=amplitude, tangential=-1j * RATIO * amplitude)


def body(**given):
    return slider(**{"preload": 0.87309e-3, "tangential_damping": 0.0, "load": 0.0} | given)


def apart(heights):
    """Asperities of 10 um so far from each other that none feels another one."""
    x = 1e-2 * np.arange(heights.size)
    return Asperities(x=x, y=0.0 * x, heights=heights + x**2 / 2e-3, radius=10e-6)


@pytest.mark.parametrize(("amplitude", "velocity"), [(3e-9, 0.00833662), (8e-9, 0.04655272)])
def test_six_asperities_without_interaction(amplitude, velocity):
    """Velocities by an independent program; to the same, balls of 10 um at these heights."""
    found = asperity_motion(body(), apart(HEIGHTS), orbit(amplitude), tolerance=1e-5)
    assert found.status == "ok"
    assert found.value == pytest.approx(velocity, rel=1e-4)
    balls = mean_motion(body(radius=10e-6, heights=tuple(HEIGHTS)), (orbit(amplitude),) * 6)
    assert float(balls.first_order) == pytest.approx(velocity, abs=6e-9)  # the digits that are printed
    assert found.value == pytest.approx(float(balls.first_order), rel=1e-4)  # 1 cm apart they displace each other
    assert asperity_motion(body(), apart(HEIGHTS[::-1]), orbit(amplitude), tolerance=1e-5).value == pytest.approx(
        found.value, rel=1e-9
    )


def test_mirrored_wave_drives_the_other_way():
    sample = Roughness(rms=3e-9).drawn(1, 5e-6)
    forward, back = (asperity_motion(body(), sample, each) for each in (orbit(5e-9), orbit(5e-9).mirrored()))
    assert forward.value == pytest.approx(-back.value, rel=1e-9)
    assert forward.value > 0.01


def test_stated_error_holds_against_many_steps():
    sample = Roughness(rms=3e-9).drawn(2, 5e-6)
    coarse, fine = (asperity_motion(body(), sample, orbit(3e-9), tolerance=each) for each in (3e-3, 1e-5))
    assert fine.error < coarse.error
    assert abs(coarse.value - fine.value) <= 2 * coarse.error + fine.error


def test_samples_of_three_nanometres_as_in_the_table_of_an_independent_program():
    """An independent program, 5 to 8 balls: at a wave of 5 nm 0.90 to 1.02 of the smooth ball, median 0.95."""
    smooth = float(mean_motion(body(), orbit(5e-9)).velocity)
    ratios = [
        asperity_motion(body(), Roughness(rms=3e-9).drawn(seed, 5e-6), orbit(5e-9), tolerance=3e-3).value / smooth
        for seed in range(5)
    ]
    assert np.median(ratios) == pytest.approx(0.95, abs=0.06)
    assert 0.82 < min(ratios) < max(ratios) < 1.05


def test_load_slows_and_too_much_of_it_needs_a_damper():
    sample = apart(HEIGHTS)
    free, loaded = (asperity_motion(body(load=each), sample, orbit(8e-9)).value for each in (0.0, 2e-5))
    assert 0.0 < loaded < free
    # 20 uN of mu F = 70 uN, by the smooth equal balls
    balls = [
        float(mean_motion(body(radius=10e-6, heights=tuple(HEIGHTS), load=each), (orbit(8e-9),) * 6).first_order)
        for each in (0.0, 2e-5)
    ]
    assert loaded / free == pytest.approx(balls[1] / balls[0], rel=1e-3)
    # the load opposes the motion: also that of a wave from the other side
    other = asperity_motion(body(load=2e-5), sample, orbit(8e-9).mirrored()).value
    assert other == pytest.approx(-loaded, rel=1e-9)
    heavy = body(load=1e-3)
    with pytest.raises(ConvergenceError, match="friction cannot balance the load"):
        asperity_motion(heavy, sample, orbit(8e-9))
    damped = body(load=1e-3, tangential_damping=1e-3)  # full friction and the damper hold it
    assert asperity_motion(damped, sample, orbit(8e-9)).value == pytest.approx(
        (0.08 * 0.87309e-3 - 1e-3) / 1e-3, rel=1e-6
    )
    assert RoughBalls(body(load=1e-3), [sample]).threshold(orbit(8e-9), 1e-4, tolerance=1e-2) == 0.0


@pytest.mark.parametrize("law", ["elastic", "hysteretic"])
@pytest.mark.parametrize("amplitude", [1e-9, -3e-9])
def test_a_load_beyond_the_drive_moves_it_back(law, amplitude):
    """As the smooth balls of the asperities' radius do: forwards or at rest under a small load, back under 30 uN."""
    wave, found = Orbit(frequency=FREQUENCY, normal=abs(amplitude), tangential=-1j * RATIO * amplitude), []
    for load in (1e-6, 1e-5, 3e-5):
        balls = body(radius=10e-6, heights=tuple(HEIGHTS), load=load, law=law)
        expected = float(steady(balls, (wave,) * 6, tolerance=1e-5).velocity)
        motion = RoughBalls(body(load=load, law=law), [apart(HEIGHTS)]).motion(wave, tolerance=1e-4)
        found.append(np.sign(amplitude) * motion.answer.value)
        assert motion.answer.value == pytest.approx(expected, rel=1e-3, abs=1e-12)
        assert (motion.regime == "stick") == (expected == 0.0)
    assert found[0] >= 0.0 > found[-1]


def test_balls_with_samples_of_their_own_share_the_preload():
    """Equal balls are as one with its part of the preload; unequal ones lie between their own velocities."""
    one, other = (Roughness(rms=3e-9).drawn(seed, 5e-6) for seed in (1, 2))
    twice = body(preload=2 * 0.87309e-3)
    alone = [asperity_motion(body(), each, orbit(3e-9), tolerance=1e-4).value for each in (one, other)]
    equal = RoughBalls(twice, (one, one)).velocity(orbit(3e-9), tolerance=1e-4).value
    assert equal == pytest.approx(alone[0], rel=1e-6)
    mixed = RoughBalls(twice, (one, other)).velocity(orbit(3e-9), tolerance=1e-4).value
    assert min(alone) < mixed < max(alone)
    with pytest.raises(InputError, match="orbits must be one for each ball, 2, got 1"):
        RoughBalls(twice, (one, other)).velocity((orbit(3e-9),), tolerance=1e-4)


def test_an_answer_does_not_depend_on_the_amplitudes_before():
    rough = RoughBalls(body(), [Roughness(rms=3e-9).drawn(3, 6e-6)])
    first, _, again = (rough.velocity(orbit(each), tolerance=1e-3) for each in (3e-9, 7e-9, 3e-9))
    assert abs(first.value - again.value) <= first.error + again.error


def test_threshold_is_where_the_velocity_passes_the_speed():
    rough = RoughBalls(body(), [Roughness(rms=3e-9).drawn(4, 5e-6)])
    factor = rough.threshold(orbit(1e-9), 0.2e-3, tolerance=1e-2)
    assert rough.velocity(orbit(factor * 1e-9), tolerance=1e-3).value == pytest.approx(0.2e-3, rel=0.02)
