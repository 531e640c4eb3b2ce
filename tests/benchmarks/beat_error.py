"""Error of averaged motion on waves of several frequencies over (f_n/beat)^2: `contact.error_estimate.OF_BEAT`.

    python -m tests.benchmarks.beat_error [first seed] [number]

One ball in the plane on two or three waves of drawn sizes, directions, phases and frequencies, whose slowest beat is
2.2 to 20 times the contact resonance; against the full motion that repeats with the waves, by shooting. Prints a line
for each draw, and the largest and the median ratio.
"""

import math
import sys

import numpy as np

from contact import ConvergenceError
from contact.error_estimate import first_order_error, speed_scale
from contact.plane import SurfaceWaves, steady
from contact.plane.scaling import resonance_ratios
from tests.contact.plane_motors import ball

BASE = 2.2e6  # Hz
GRID = 10e3  # Hz: all frequencies are multiples, so that the waves have a common period of at most 220 cycles


def drawn(seed: int):
    """Return a slider and its waves."""
    rng = np.random.default_rng([seed, 20261129])
    count = int(rng.integers(2, 4))
    mass = float(10 ** rng.uniform(-4.5, -3.5))
    slider = ball(
        mass=mass, preload=9.81 * mass, normal_damping=mass * 10 ** rng.uniform(3.5, 4.5),
        friction_coefficient=float(rng.uniform(0.05, 0.3)), radius=float(10 ** rng.uniform(-3.3, -2.5)),
    )  # fmt: skip
    beat = float(slider.normal_resonance(1)) * 10 ** rng.uniform(math.log10(2.2), math.log10(20.0))
    beat = max(round(beat / GRID), 2) * GRID
    frequencies = BASE + beat * np.arange(count)
    u_z = 10 ** rng.uniform(-8.7, -8.0) * rng.uniform(0.4, 1.0, count) * np.exp(2j * np.pi * rng.random(count))
    along, beta = -1j * rng.uniform(0.4, 1.0, count) * u_z, rng.uniform(0.0, 2.0 * np.pi, count)
    amplitudes = np.stack([along * np.cos(beta), along * np.sin(beta), u_z], axis=-1)[:, None, :]
    return slider, SurfaceWaves(frequencies=frequencies, amplitudes=amplitudes)


def ratio(seed: int):
    """Return (deviation over the reference speed and (f_n/beat)^2, f_n/beat, frequencies, stated over true)."""
    slider, waves = drawn(seed)
    fast, of_beat = resonance_ratios(slider, waves)
    mean = steady(slider, waves, tolerance=1.0, method="averaged")
    if mean.held:
        raise ConvergenceError("held", "friction holds the slider")
    full = steady(slider, waves, tolerance=1e-4, method="exact")
    reference = speed_scale(full.speed, waves.peak_speed)
    miss = float(np.linalg.norm(mean.velocity - full.velocity)) / reference
    return miss / of_beat**2, of_beat, waves.frequencies.size, mean.relative_error / miss, first_order_error(fast)


def main(first: int = 0, number: int = 60) -> None:
    """Print the table."""
    found = []
    for seed in range(first, first + number):
        try:
            found.append(ratio(seed))
        except ConvergenceError as error:
            print(f"{seed:5d}  {error}")
            continue
        share, of_beat, count, stated, fast = found[-1]
        row = f"{seed:5d}  {count} waves  f_n/beat {of_beat:.3f}  error/(f_n/beat)^2 {share:8.4f}"
        print(f"{row}  stated/true {stated:8.2f}  first order {fast:.1e}", flush=True)
    shares, stated = (np.array([each[k] for each in found]) for k in (0, 3))
    print(f"{len(found)} draws: largest {shares.max():.3f}, median {np.median(shares):.4f}; stated/true least "
          f"{stated.min():.2f}, {np.sum(stated < 0.5)} beyond twice")  # fmt: skip


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
