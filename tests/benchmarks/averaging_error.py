r"""Stated against true error of averaged bursts, aimed at where averaging is weak; the truth is the event-exact method.

Random sliders with a strong Hunt-Crossley damper, with a load while they hop, without normal damping, and on several
contacts at different phases of the wave. Prints how many are further off than twice the error that they state, and
how many beyond the tolerance with status "ok". `--share S` multiplies the two shares of what second order leaves.

    python -m tests.benchmarks.averaging_error --number 100
"""

import argparse
import math

import numpy as np

from contact import ConvergenceError, Orbit, Slider, burst, error_estimate
from contact.averaged import burst as averaged

FREQUENCY = 2.2e6


def scenes(number: int, seed: int):
    """Yield (slider, orbits, cycles, tolerance) to which averaging applies."""
    rng = np.random.default_rng(seed)
    kept = 0
    while kept < number:
        kind = kept % 4
        mass, friction = 10 ** rng.uniform(-6, -4), rng.uniform(0.05, 0.3)
        preload = 10 ** rng.uniform(-4, -2.5)
        slider = Slider(
            radius=1e-3, mass=mass, preload=preload, friction_coefficient=friction,
            load=rng.uniform(0.3, 0.95) * friction * preload if kind == 1 else 0.0,
            effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0,
            contact_damping=10 ** rng.uniform(0, 2) if kind == 0 else 0.0,
            normal_damping=0.0 if kind == 2 and rng.random() < 0.4 else mass * 10 ** rng.uniform(2.5, 4.5),
            tangential_damping=mass * 10 ** rng.uniform(-1, 2.5),
        )  # fmt: skip
        normal = 10 ** rng.uniform(-9, -7.7)
        first = Orbit(frequency=FREQUENCY, normal=normal, tangential=-1j * rng.uniform(0.3, 1.2) * normal)
        angles = [0.0, *rng.uniform(0.0, 2.0 * np.pi, int(rng.integers(1, 3)))] if kind == 3 else [0.0]
        orbits = tuple(first.scaled(np.exp(1j * angle)) for angle in angles)
        cycles, tolerance = int(rng.integers(600, 5000)), 10 ** rng.uniform(-5, -3)
        if not averaged.refusals(slider, orbits):
            kept += 1
            yield slider, orbits, cycles, tolerance


def errors(slider, orbits, cycles, tolerance):
    """Return (true error, stated error, status) of the averaged burst, relative in the sense of `tolerance`."""

    def run(method, allowed):
        return burst(
            slider, orbits, duration=cycles / FREQUENCY, after=0.0, tolerance=allowed, samples=2, method=method
        )

    found, exact = run("averaged", tolerance), run("exact", 1e-7)
    reference = max(abs(exact.velocity_at_burst_end), 0.1 * 2.0 * math.pi * FREQUENCY * abs(orbits[0].tangential))
    true = abs(found.velocity_at_burst_end - exact.velocity_at_burst_end) / reference
    return true, found.relative_error, found.status


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--number", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--share", type=float, default=1.0)
    chosen = parser.parse_args()
    error_estimate.LEFT_OF_FIRST *= chosen.share
    error_estimate.LEFT_OF_RATIO *= chosen.share
    rows, refused = [], 0
    for scene in scenes(chosen.number, chosen.seed):
        try:
            true, stated, status = errors(*scene)
        except ConvergenceError:
            refused += 1
            continue
        rows.append((true / stated, status == "ok", status == "ok" and true > scene[-1]))
    ratio, kept, beyond = np.array(rows).T
    print(f"{len(rows)} bursts, {refused} refused, {kept.sum():.0f} within the tolerance by their own estimate")
    print(
        f"further off than twice the stated error: {np.sum(ratio > 2.0)}; "
        f"ok but beyond the tolerance: {beyond.sum():.0f}"
    )
    print(
        "true over stated, quantiles 0.5 0.9 0.95 1:", *(f"{q:.2f}" for q in np.quantile(ratio, (0.5, 0.9, 0.95, 1.0)))
    )


if __name__ == "__main__":
    main()
