"""Sliders on pillars against a reference written from the model alone (`tests/oracles/contact_pillars.py`)."""

import numpy as np
import pytest

from contact import PassingWave, Pillars, pillar_load_line, pillar_motion
from tests.oracles.contact_pillars import Slider as Reference

K_N, K_T, LENGTH, RATIO, FREQUENCY, GAMMA = 1.8e6, 1.52e6, 414.05e-6, 0.88995, 9.61e6, 2.5078e-12
DRAW = np.random.default_rng(42)


def scene(along, across, *, pitch=50e-6, scatter=0.0, force=3e-3, half_stall=False, wave=(), **given):
    """Return (pillars, wave, share of the stall) with `force` in N on each pillar and a strip of 50 um per column."""
    x, y = ((np.arange(n) - (n - 1) / 2) * p for n, p in ((along, pitch), (across, 50e-6)))
    number = along * across
    pillars = Pillars(
        x=np.repeat(x, across), y=np.tile(y, along), heights=DRAW.normal(0.0, scatter, number), normal_stiffness=K_N,
        tangential_stiffness=K_T, preload=force * number, **{"friction_coefficient": 0.18} | given,
    )  # fmt: skip
    usual = {"forward": 20e-9, "strip_width": 50e-6 * max(across, 10)}
    passing = PassingWave(frequency=FREQUENCY, wavelength=LENGTH, ratio=RATIO, compliance=GAMMA, **usual | dict(wave))
    return pillars, passing, 0.5 if half_stall else 0.0


SCENES = {
    "one": scene(1, 1),
    "two": scene(2, 1, pitch=230e-6, scatter=5e-9),
    "nine, free": scene(3, 3, pitch=170e-6, scatter=8e-9, tilt="free"),
    "a row, pitch": scene(30, 1, pitch=37e-6, scatter=10e-9, tilt="pitch"),
    "preload beside the centre": scene(20, 20, scatter=10e-9, tilt="free", preload_at=(5e-5, -8e-5)),
    "opposing waves": scene(20, 20, scatter=6e-9, wave={"backward": 8e-9 * np.exp(1.1j)}),
    "a larger wave from the right": scene(20, 20, wave={"forward": 7e-9, "backward": 20e-9 * np.exp(0.3j)}),
    "quarter waves": scene(40, 10, pitch=LENGTH / 4),
    "Bragg": scene(24, 10, pitch=LENGTH / 2),
    "Bragg with scatter": scene(24, 10, pitch=LENGTH / 2, scatter=10e-9),
    "nearly in phase": scene(12, 10, pitch=1.03 * LENGTH, scatter=3e-9),
    "half stall": scene(30, 30, scatter=10e-9, half_stall=True),
    "half stall above the surface": scene(
        20, 20, scatter=10e-9, half_stall=True, tilt="free", load_height=2e-4
    ),
    "curved": scene(30, 30, scatter=2e-9, curvature=0.02),
    "soft": scene(30, 30, scatter=10e-9, backing="soft"),
    "10 mN on each": scene(50, 40, scatter=10e-9, force=10e-3),
    "small wave": scene(50, 40, scatter=5e-9, force=0.25e-3, wave={"forward": 5e-9}),
    "low friction and a damper": scene(50, 40, scatter=10e-9, friction_coefficient=0.05, tangential_damping=0.05),
    "30 N": scene(100, 100),
    "100 N": scene(100, 100, force=10e-3),
    "30 N, free": scene(100, 100, scatter=10e-9, tilt="free"),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("loading", [False, True])
@pytest.mark.parametrize("name", SCENES)
def test_the_motion_is_that_of_the_reference(name, loading):
    """Oracle; 3 minutes of CPU for all, most of them for the last three."""
    pillars, wave, share = SCENES[name]
    load = share * pillar_load_line(pillars, wave, points=2, loading=loading).stall if share else 0.0
    found = pillar_motion(pillars, wave, load=load, loading=loading)
    other = Reference(
        x=pillars.x, y=pillars.y, heights=pillars.heights - 0.5 * pillars.curvature * (pillars.x**2 + pillars.y**2),
        k_n=K_N, k_t=K_T, mu=pillars.friction_coefficient, preload=pillars.preload, frequency=FREQUENCY,
        wavelength=LENGTH, ratio=RATIO, forward=wave.forward, backward=wave.backward, gamma=GAMMA * loading,
        width=wave.strip_width, tilt=pillars.tilt, preload_at=pillars.preload_at, load_height=pillars.load_height,
        load=found.load, damping=pillars.tangential_damping, soft=pillars.backing == "soft",
    )  # fmt: skip
    # the guess is off, so that the reference searches for itself
    guess = (1.01 * found.approach + 1e-11, *(0.99 * each for each in found.tilt), 1.02 * found.velocity + 1e-3)
    velocity = other.solve(guess)
    there = other.report()
    assert found.velocity == pytest.approx(velocity, rel=1e-10)
    assert found.normal_force == pytest.approx(there["normal"], abs=1e-9 * pillars.preload / pillars.number)
    assert found.friction_power == pytest.approx(there["friction"], rel=1e-9)
    left = there["right"] if abs(wave.forward) >= abs(wave.backward) else there["left"]
    entry = max(wave.forward, wave.backward, key=abs)
    assert abs(found.exit_over_entry - left / entry) < 1e-11
    assert found.share_in_contact == pytest.approx(there["touching"], abs=1e-12)
    assert abs(found.ledger_residual) < 1e-12
    if loading:
        spent = there["friction"] + there["thrust"] + pillars.tangential_damping * velocity**2
        assert there["in"] - there["out"] == pytest.approx(spent, abs=1e-12 * there["in"])


def test_the_reference_meets_the_published_speed():
    """Exact limit: 10^4 incommensurate flat pillars are one pillar."""
    one, wave, _ = SCENES["one"]
    other = Reference(
        x=np.zeros(1), y=np.zeros(1), heights=0.0, k_n=K_N, k_t=K_T, mu=0.18, preload=one.preload, frequency=FREQUENCY,
        wavelength=LENGTH, ratio=RATIO, forward=wave.forward,
    )  # fmt: skip
    assert other.solve((0.0, 0.0, 0.0, -0.9)) == pytest.approx(-0.92621972, abs=6e-9)
