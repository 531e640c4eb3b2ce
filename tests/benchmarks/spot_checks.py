"""True over stated error of bursts whose error is seen in a part of their cycles: `event_driven_burst.SPOT_FACTOR`.

    python -m tests.benchmarks.spot_checks [DRAWS]

Draws: aimed at weak spots and around the seed (`tests.motors`), at most 3000 cycles.  Truth: the event-driven method at
20 nodes.  Prints each ratio above one, and the largest for each kind of draws, with and without the factor.
"""

import sys

import numpy as np

from contact import ConvergenceError
from contact.answers.burst_question import Burst
from contact.answers.event_driven_burst import SPOT_FACTOR, spot_checked
from contact.answers.rest_motion import rest, rest_problem
from contact.error_estimate import reference_speed
from contact.orbit import towards_plus
from tests.motors import aimed, around_the_seed

MAX_CYCLES, MAX_TURNED = 3000, 2e5
DRAWS = ("aimed", aimed), ("around the seed", around_the_seed)


def ratio(slider, orbits, cycles):
    """Return (true error over the stated one, stated error relative to the reference speed), None if not checked so."""
    _, driven = towards_plus(orbits)
    problem = rest_problem(slider, driven)
    if problem.segments * cycles > MAX_TURNED:
        return None
    request = Burst(slider, driven, problem, cycles, max(1, cycles // 2), 1e-6, None)
    try:
        finest = rest(slider, driven, problem, nodes=20, truncation=1e-13)
        finest.turn(cycles)
        found = spot_checked(request)
    except ConvergenceError:
        return None
    if found is None or found.error == 0.0:
        return None
    reference = reference_speed(finest.state[2] * problem.speed, driven) / problem.speed
    return abs(found.run[0].state[2] - finest.state[2]) / found.error, found.error / reference


if __name__ == "__main__":
    draws = int(sys.argv[1]) if len(sys.argv) > 1 else 60
    for kind, draw in DRAWS:
        ratios = []
        for number in range(draws):
            slider, orbits, *others = draw(number)
            found = ratio(slider, orbits, min(others[-2] if draw is aimed else others[-1], MAX_CYCLES))
            if found is not None:
                ratios.append(found[0])
                if found[0] > 1.0:
                    print(f"{kind} {number}: {found[0]:.2f} of a stated error of {found[1]:.1e}")
        print(
            f"{kind}: {len(ratios)} draws, largest ratio {max(ratios):.2f} (without the factor at "
            f"most {SPOT_FACTOR * max(ratios):.1f}), median {np.median(ratios):.3f}",
            flush=True,
        )
