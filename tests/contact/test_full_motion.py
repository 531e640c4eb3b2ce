"""Bursts and steps against an integrator written from the equations alone (`tests/oracles/contact_motion.py`)."""

import numpy as np
import pytest

from contact import Envelope, burst, step
from contact.error_estimate import reference_speed
from tests.contact.motors import orbit, slider
from tests.oracles.contact_motion import Motor
from tests.seed_motor import DAMPERS, MASS

SEED = DAMPERS | {"mass": MASS, "frequency": 2.2e6}


def motor(waves, **given):
    """Return the oracle's motor for `slider()` of the tests on orbits."""
    one = slider()
    mu = one.friction_coefficient
    return Motor(
        preload=one.preload, normal=tuple(o.normal for o in waves), tangential=tuple(o.tangential for o in waves),
        numbers=(mu, 1.0, 1.0, mu, 1.0, np.inf), **SEED | given,
    )  # fmt: skip


@pytest.mark.slow  # half a minute of compilation
@pytest.mark.parametrize("amplitude", [2e-9, 4e-9, 10e-9])
def test_an_exact_burst_is_that_of_the_oracle(amplitude):
    waves = (orbit(amplitude), orbit(0.8 * amplitude).scaled(np.exp(1.3j)))
    found = burst(slider(), waves, duration=200 / 2.2e6, after=0.0, tolerance=1e-9, samples=2, method="exact")
    _, rows, _ = motor(waves, per_cycle=240).run(200, every=200)
    reference = reference_speed(rows[-1, 0], waves)
    assert abs(found.velocity_at_burst_end - rows[-1, 0]) < 3e-9 * reference


@pytest.mark.slow
@pytest.mark.parametrize("number", range(4))
def test_envelopes_with_kinks_within_a_cycle_keep_their_errors(number):
    draw = np.random.default_rng([2028, number])
    time = np.sort(np.append(draw.uniform(0.0, 80 / 2.2e6, 4), [0.0, 80 / 2.2e6]))
    envelope = Envelope(time=time, amplitude=draw.uniform(0.0, 1.0, 6), phase=np.zeros(6))
    waves = (orbit(10e-9),)
    found = burst(slider(), waves, duration=80 / 2.2e6, after=0.0, tolerance=1e-3, samples=2, envelope=envelope)
    shape = {"times": tuple(time), "amplitude": tuple(envelope.amplitude), "phase": (0.0,) * 6}
    _, rows, _ = motor(waves, **shape).run(80, every=80)
    assert abs(found.velocity_at_burst_end - rows[-1, 0]) < 2.0 * found.answer.error
    travelled = step(slider(), waves, cycles=80, envelope=envelope)
    assert abs(travelled.during - rows[-1, 1]) < 2.0 * travelled.error
