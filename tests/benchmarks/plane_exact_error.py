"""True error of the exact motion in the plane over twice the stated one, for each row of its table of accuracies.

    python -m tests.benchmarks.plane_exact_error

Drawn sliders on three balls, 120 cycles, and drawn light sliders, 24 cycles, against the motion with 8 nodes. Printed
are the largest ratio, its seed and, over the speed, the error and the largest stated one.
"""

from dataclasses import replace

import numpy as np

from contact.error_estimate import speed_scale
from contact.plane.bursts import EXACT
from contact.plane.full_motion import motion_at_rest
from tests.contact.plane_motors import drawn, drawn_on_three_balls

REFERENCE = (8, 1e-8)
INSTANTS = 6


def rates_of(slider, waves, rise, how, cycles):
    """Return the rates in m/s at some instants; the yaw rate times the largest arm."""
    motion, rates = motion_at_rest(slider, waves, how, rise=rise, stop=1.0), []
    arm = float(np.max(np.hypot(slider.x, slider.y)))
    for k in range(INSTANTS):
        motion.follow((k + 1) * cycles / INSTANTS * 2.0 * np.pi)
        rates.append(motion.state.p[1:] * motion.units.speed * [1.0, 1.0, arm / motion.units.length])
    return np.array(rates)


def rows(draws, cycles):
    """Yield (level, ratio, seed, true error, stated error)."""
    for seed, (slider, waves, rise) in draws:
        true = rates_of(slider, waves, rise, REFERENCE, cycles)
        speed = max(speed_scale(float(np.linalg.norm(each)), waves.peak_speed) for each in true)
        for level, (fine, coarse, least) in EXACT.items():
            here, there = (rates_of(slider, waves, rise, how, cycles) for how in (fine, coarse))
            stated = np.linalg.norm(np.abs(here - there).max(axis=0)) / speed + least
            miss = np.linalg.norm(here[-1] - true[-1]) / speed
            yield level, miss / (2.0 * stated), seed, miss, stated


def light(seed):
    """Return a light drawn slider without a load, its waves and their rise time."""
    slider, waves = drawn(seed, mass=2e-7)
    return replace(slider, load=(0.0, 0.0)), waves, 3 / float(waves.frequencies[0])


def main() -> None:
    """Print both tables."""
    for name, draws, cycles in (
        ("three balls", ((seed, drawn_on_three_balls(seed)) for seed in range(40)), 120),
        ("light", ((seed, light(seed)) for seed in range(60)), 24),
    ):
        found = list(rows(draws, cycles))
        for level in EXACT:
            own = sorted((row for row in found if row[0] == level), key=lambda row: row[1])
            stated = max(row[4] for row in own)
            print(
                f"{name:12s} {level:.0e}: {own[-1][1]:.2f} of seed {own[-1][2]}, {own[-1][3]:.1e}; stated {stated:.1e}"
            )


if __name__ == "__main__":
    main()
