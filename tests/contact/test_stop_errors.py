"""One stop of a mean field: its rest and its stated errors against its tabulated force, solved between events."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from contact import MeanField, Orbit, RoughBalls, Roughness, steady
from tests.contact.test_asperity_motion import orbit
from tests.contact.test_memory_motion import MU, PRELOAD, E, R, body

BOUNCES = 3.0  # of the squared ratio of resonance and frequency: what a held height leaves out, as runs state it


@cache
def surface(rms):
    """The mean field, and its force as a normal law of the solvers that follow the slider."""
    field = MeanField(R, E, Roughness(rms=rms))
    return field, field.tabulated()


def errors(rms, wave, tolerance=1e-3, **given):
    """True and stated error over the reference speed, and the motion by both ways."""
    field, law = surface(rms)
    slider = body(law="elastic", **given)
    found = RoughBalls(slider, [field], 12e-9).motion(wave, tolerance=tolerance)
    expected = steady(replace(slider, normal_law=law), wave, tolerance=1e-5)
    reference = max(abs(float(expected.velocity)), wave.omega * abs(wave.tangential) / 10)
    stated = found.answer.error / reference + BOUNCES * (slider.normal_resonance(1) / wave.frequency) ** 2
    return abs(found.answer.value - float(expected.velocity)) / reference, stated, found, expected


@pytest.mark.parametrize("amplitude", [0.5e-9, 1.5e-9, 2.0e-9, 2.5e-9])
def test_it_rests_below_its_threshold(amplitude):
    """It came to 8e-7 m/s by steps of phase; the solver between events has no motion there either."""
    _, _, found, expected = errors(3e-9, orbit(amplitude))
    assert (found.answer.value, found.regime) == (0.0, "stick")
    assert (float(expected.velocity), expected.regime) == (0.0, "stick")


def test_stated_errors_near_the_threshold():
    """Where few nanometres of amplitude lie above rest the velocity is most sensitive to the force."""
    for amplitude in (2.95e-9, 3e-9, 3.5e-9, 5e-9, 8e-9):
        true, stated, _, _ = errors(3e-9, orbit(amplitude))
        assert true <= 2 * stated
        assert stated < 1e-4


@pytest.mark.parametrize("rms", [0.3e-9, 1e-9, 2e-9, 3e-9, 5e-9])
def test_stated_errors_of_drawn_motors(rms):
    """Forwards, at rest, and back where the load exceeds the drive, as in 8 of these hundred; no error beyond twice."""
    chance = np.random.default_rng(int(rms * 1e10))
    for _ in range(20):
        normal, lag = 10 ** chance.uniform(-9.2, -7.9), chance.uniform(-1.0, 1.0) - np.pi / 2
        wave = Orbit(
            frequency=2.2e6, normal=normal, tangential=normal * 10 ** chance.uniform(-0.5, 0.5) * np.exp(1j * lag)
        )
        load = chance.uniform(0.0, 0.2) * MU * PRELOAD * (chance.random() < 0.4)
        true, stated, found, expected = errors(rms, wave, load=load, tangential_damping=10 ** chance.uniform(-5, -3))
        assert true <= 2 * stated
        assert (found.regime == "stick") == (expected.regime == "stick")
