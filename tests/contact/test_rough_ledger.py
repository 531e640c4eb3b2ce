"""Energies of a cycle on rough balls: they balance, and are those of other programs."""

from dataclasses import replace

import numpy as np
import pytest

from contact import MeanField, RoughBalls, Roughness, rough_ledger, steady
from contact.averaged.asperity_motion import DRIVEN_BACK
from tests.contact.test_asperity_motion import HEIGHTS, apart, orbit
from tests.contact.test_memory_motion import MU, E, G, R, body, drawn_motor
from tests.contact.test_rough import six
from tests.oracles.contact_asperities import CoupledAsperities


def ledger_of(slider, balls, wave, tolerance=1e-5):
    rough = RoughBalls(slider, balls)
    motion = rough.motion(wave, tolerance=tolerance)
    return motion, rough_ledger(rough, wave, motion)


@pytest.mark.slow
@pytest.mark.parametrize("law", ["hysteretic", "elastic"])
@pytest.mark.parametrize("part", range(3))
def test_energies_of_drawn_motors_balance(law, part):
    for seed in range(8 * part, 8 * part + 8):
        slider, balls, wave = drawn_motor(seed)
        motion, energies = ledger_of(replace(slider, law=law), balls, wave, 1e-3)
        if motion.answer.value == 0.0:
            assert energies.wave == energies.spent == 0.0
            continue
        if energies.wave == 0.0:  # it moves within the error of its velocity only
            assert abs(motion.answer.value) <= 1e-3 * wave.omega * abs(wave.tangential)
            continue
        assert energies.relative_residual < 1e-10, seed
        assert energies.slip > 0.0
        assert (energies.leak != 0.0) == (law == "elastic")
        speed = abs(motion.answer.value)
        off = 3e-3 * max(speed, 0.1 * wave.omega * abs(wave.tangential))
        work = -slider.load * speed if DRIVEN_BACK in motion.answer.reasons else slider.load * speed
        assert energies.load * wave.frequency == pytest.approx(work, abs=slider.load * off)


@pytest.mark.parametrize("amplitude", [4e-9, 8e-9])
def test_memory_of_asperities_that_draw_each_other_along(amplitude):
    """Coupled asperities that are stepped through time: 2e-3, by their steps and springs."""
    wave = orbit(amplitude)
    motion, energies = ledger_of(body(), [six()], wave)
    sample, turn = six(), np.exp(2j * np.pi * np.arange(400) / 400)
    free = sample.heights - (sample.x**2 + sample.y**2) / (2 * R)
    z, surface = motion.heights[0] + (wave.normal * turn).real, (wave.tangential * turn).real
    other = CoupledAsperities(sample.x, sample.y, free, 10e-6, E, G, MU, deepest=z.max() + free.max(), springs=100)
    other.means(z, surface, motion.answer.value / wave.frequency, cycles=2)
    assert energies.wave == pytest.approx(other.work, rel=2e-3)
    assert energies.slip == pytest.approx(other.loss, rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "load", "amplitude"), [("elastic", 0.0, 3e-9), ("elastic", 8e-6, 8e-9), ("hysteretic", 8e-6, 8e-9)]
)
def test_asperities_apart_are_balls_of_the_event_driven_solver(law, load, amplitude):
    """It follows the slider's motion within a cycle: 2e-3 of the energies at most."""
    slider = body(law=law, load=load)
    _, energies = ledger_of(slider, [apart(HEIGHTS)], orbit(amplitude))
    balls = replace(slider, radius=10e-6, heights=tuple(HEIGHTS))
    expected = steady(balls, (orbit(amplitude),) * 6, tolerance=1e-5, method="exact").ledger
    assert energies.wave == pytest.approx(expected.wave, rel=2e-3)
    assert energies.slip == pytest.approx(expected.slip, rel=2e-3)
    assert energies.load == pytest.approx(expected.load, rel=2e-3)
    assert energies.leak == pytest.approx(expected.leak, abs=2e-3 * abs(expected.leak) + 1e-25)


@pytest.mark.parametrize("law", ["hysteretic", "elastic"])
def test_a_vanishing_roughness_has_the_energies_of_the_smooth_ball(law):
    slider = body(law=law)
    _, energies = ledger_of(slider, [MeanField(R, E, Roughness(rms=1e-13))], orbit(8e-9))
    expected = steady(slider, orbit(8e-9), tolerance=1e-6, method="exact").ledger
    assert energies.wave == pytest.approx(expected.wave_tangential, rel=2e-3)
    assert energies.slip == pytest.approx(expected.slip, rel=2e-3)
    assert energies.leak == pytest.approx(expected.leak, abs=1e-2 * abs(expected.leak) + 1e-25)


def test_one_stop_of_a_mean_field_leaks_as_the_tabulated_law_of_the_event_driven_solver():
    field = MeanField(R, E, Roughness(rms=3e-9))
    slider = body(law="elastic", load=3e-6)
    _, energies = ledger_of(slider, [field], orbit(8e-9))
    expected = steady(replace(slider, normal_law=field.tabulated()), orbit(8e-9), tolerance=1e-3).ledger
    for name in ("wave", "slip", "leak", "load"):
        assert getattr(energies, name) == pytest.approx(getattr(expected, name), rel=3e-3), name
