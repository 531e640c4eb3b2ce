"""True over stated error of periodic motions: `error_estimate.AGREEMENT` and the levels of `periodic.shooting`.

    python -m tests.benchmarks.shooting_error [DRAWS]

Draws: one ball of every adhesion and law, 1e-5 to 100 kg. Truth: the same search at 20 nodes. A ratio counts where its
own last Newton step is a tenth of the difference; smaller differences are rounding of the truth. Prints each ratio
above one, and per level how many are above one and two, the median stated error, and the largest residual of energy.
"""

import math
import sys

import numpy as np

from contact import Adhesion, ConvergenceError
from contact.answers.ledger import ledger
from contact.averaged.event_equilibrium import balanced
from contact.orbit import as_orbits
from contact.periodic import shooting
from tests.contact.motors import orbit, slider

TRUTH = (20, 1e-13, 0.7, 1e-15)


def drawn(seed):
    """Return a slider of one ball and its orbit."""
    draw = np.random.default_rng(seed)

    def between(low, high):
        return float(np.exp(draw.uniform(math.log(low), math.log(high))))

    model = str(draw.choice(["none", "DMT", "JKR", "Maugis"]))
    work, separation, radius = between(1e-3, 0.1), between(1e-10, 2e-9), between(2e-4, 2e-3)
    preload, mass, amplitude, ratio = (
        between(3e-5, 3e-3),
        between(1e-5, 1e2),
        between(1e-9, 25e-9),
        draw.uniform(0.3, 1),
    )
    tangential, normal = between(1e-6, 1e-3), between(0.05, 2.0)
    load = 0.0 if draw.random() < 0.5 else draw.uniform(0.0, 0.03) * preload
    law = str(draw.choice(["elastic", "elastic", "hysteretic"])) if model == "none" else "elastic"
    reciprocal = bool(draw.random() < 0.3) and model == "none" and law == "elastic"
    adhesion = None
    if model != "none":
        adhesion = Adhesion(model=model, work=work, separation=separation if model == "Maugis" else None)
    body = slider(
        adhesion=adhesion, radius=radius, preload=preload, mass=mass,
        normal_damping=normal, tangential_damping=tangential, load=load, law=law, reciprocal=reciprocal,
    )  # fmt: skip
    return body, orbit(amplitude, ratio)


def levels(balance):
    """Return pairs of the finer and the coarser periodic motion by the name of their level."""
    fine = shooting.fine_periodic(balance)
    quick = shooting.quick_periodic(balance, 1e-3)
    return {"fine": (fine, shooting.coarse_periodic(balance, fine))} | ({"quick": quick} if quick else {})


if __name__ == "__main__":
    ratios, stated, residuals = ({"fine": [], "quick": []} for _ in range(3))
    for seed in range(int(sys.argv[1]) if len(sys.argv) > 1 else 400):
        body, wave = drawn(seed)
        try:
            balance = balanced(body, as_orbits([wave]))
            if balance.held:
                continue
            pairs = levels(balance)
            truth = shooting.search_at(TRUTH, balance, near=pairs["fine"][0])
        except ConvergenceError as failed:
            print(seed, failed)
            continue
        for name, (fine, coarse) in pairs.items():
            error, difference = abs(fine.speed - coarse.speed) + fine.unseen_error, abs(fine.speed - truth.speed)
            residuals[name].append(ledger(body, fine.motion).relative_residual)
            if residuals[name][-1] > 1e-10:
                print(f"{seed} {name} residual of energy {residuals[name][-1]:.1e}")
            stated[name].append(error / abs(fine.speed))
            if truth.step < 0.1 * difference or difference <= error:
                ratios[name].append(difference / error)
                if difference > error:
                    print(f"{seed} {name} {difference / error:.2g}")
    for name, each in ratios.items():
        above = [sum(ratio > most for ratio in each) for most in (1.0, 2.0)]
        print(
            f"{name}: {len(each)} motions, {above[0]} above 1, {above[1]} above 2; stated {np.median(stated[name]):.1e}"
            f" of v in the median; residual of energy at most {max(residuals[name]):.1e}"
        )
