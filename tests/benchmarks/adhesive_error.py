"""Stated and true error of the averaged velocity of drawn adhesive balls.

    python -m tests.benchmarks.adhesive_error [SEED [COUNT]]

For JKR and Maugis each it prints how many of COUNT drawn balls (40, SEED 47) hold their stated error and twice it, and
the worst three, with the true error over the stated one. The true velocity is that of 131 072 steps. `SAFETY` of
`contact.averaged.adhesive_motion` was set on other draws, so that these are held out: of seed 47, 39
of 40 (JKR) and 40 of 40 (Maugis) were within, and the worst had 1.77 times its stated error.
"""

import math
import sys

import numpy as np

from contact import AdhesiveBalls, ConvergenceError, InputError, Orbit
from tests.contact.motors import slider


def drawn(rng, model: str):
    """Return balls, their orbits and a tolerance."""
    count = int(rng.choice([1, 1, 1, 2, 3]))
    modulus, radius, mu = 10 ** rng.uniform(10.3, 11.3), 10 ** rng.uniform(-4, -2.3), 10 ** rng.uniform(-1.5, -0.4)
    work = 10 ** rng.uniform(-2.3, -0.5)
    pull_off = 1.5 * math.pi * work * radius
    preload = count * pull_off * 10 ** rng.uniform(-0.7, 1.3)
    body = slider(
        radius=radius, effective_modulus=modulus, tangential_modulus=modulus * rng.uniform(0.15, 0.3), mass=math.inf,
        friction_coefficient=mu, preload=preload, normal_damping=0.0,
        load=float(rng.choice([0.0, 0.0, 0.3])) * rng.uniform() * mu * preload,
        tangential_damping=float(rng.choice([0.0, 1.0])) * mu * preload * 10 ** rng.uniform(-2, 1),
    )  # fmt: skip
    own = {"separation": 10 ** rng.uniform(-9.7, -8.5)} if model == "Maugis" else {}
    balls = AdhesiveBalls(body, work=work, model=model, **own)
    ratio, phase = rng.uniform(0.3, 1.2), rng.uniform(-1.0, 1.0)
    unlike = [1.0, *(rng.uniform(0.5, 1.0, count - 1) * np.exp(1j * rng.uniform(-2, 2, count - 1)))]
    frequency = 10 ** rng.uniform(5.0, 7.0)
    unit = [
        Orbit(frequency=frequency, normal=1e-9 * each, tangential=-1e-9j * each * ratio * np.exp(1j * phase))
        for each in unlike
    ]
    factor = balls.release(unit) * 10 ** rng.uniform(-0.5, 0.7)
    return balls, tuple(each.scaled(factor) for each in unit), 10 ** rng.uniform(-5, -2)


def true_velocity(balls, orbits) -> float:
    """Return the velocity of the finest steps."""
    return balls.motion(orbits, tolerance=1e-14).velocity.value


def main(seed: int = 47, count: int = 40) -> None:
    """Print the table."""
    for model in ("JKR", "Maugis"):
        rng, found = np.random.default_rng(seed), []
        while len(found) < count:
            try:
                balls, orbits, tolerance = drawn(rng, model)
                velocity = balls.motion(orbits, tolerance=tolerance).velocity
            except (InputError, ConvergenceError) as refused:
                print("refused:", refused)
                continue
            error, rounding = abs(velocity.value - true_velocity(balls, orbits)), 1e-12 * abs(velocity.value)
            share = max(error - rounding, 0.0) / velocity.error if velocity.error else float(error > rounding) * 1e9
            found.append((share, tolerance, len(orbits), velocity.value))
            print(model, len(found), found[-1], flush=True)
        shares = np.array([each[0] for each in found])
        print(
            f"{model}: {np.sum(shares <= 1)} of {count} within, {np.sum(shares <= 2)} within twice", sorted(found)[-3:]
        )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
