r"""Stated against true error of bursts in fixed steps, whose first cycles the exact method checks.

Every level of `stepped_burst.STEPS` that applies to the families `aimed` and `around_the_seed` of `tests/motors.py`, in
bursts of 300 to 5000 cycles. The check has the first third, at most 1000 cycles. For each pair of `CALIBRATION` and
`LEAST_SHARE` it prints how many are further off than once and twice the stated error.

    python -m tests.benchmarks.stepped_error --draws aimed --number 400
    python -m tests.benchmarks.stepped_error --draws calibration --number 200

`--parts` tests the error of long bursts instead, which is seen in parts of them (`STEPPED_PARTS`), at
three tolerances in bursts of 3100 to 12 000 cycles, at most the given number of segments.
"""

import argparse
from itertools import product

import numpy as np

from contact import ConvergenceError, error_estimate
from contact.answers.burst_question import Burst
from contact.answers.rest_motion import rest, rest_problem
from contact.answers.stepped_burst import STEPS, WINDOW, stepped_refusals, steps_checked_in_parts
from contact.codes import Recorded
from contact.orbit import towards_plus
from contact.stepping.time_stepping import steps
from tests import motors

SHORTEST, LONGEST, LEVELS = 300, 5000, 6
MAX_SEGMENTS, PARTS_TOLERANCES = 3e6, (1e-3, 1e-4, 1e-6)
FACTORS = (2.0, 3.0, 4.0), (1.0, 0.5, 0.35, 0.25)


def compared(slider, orbits, cycles):
    """Yield (level, true error, estimate, largest true error and estimate in the first cycles), over the reference."""
    _, driven = towards_plus(orbits)
    problem = rest_problem(slider, driven)
    burst = Burst(slider, driven, problem, cycles, 1, 1e-4, None)
    levels = [k for k, (n, _) in enumerate(STEPS) if not stepped_refusals(slider, problem, n)][:LEVELS]
    exact = rest(slider, driven, problem, nodes=14, truncation=1e-11).turn(cycles, stride=1)
    exact, found = exact[:, Recorded.VELOCITY], {}
    for k in levels:
        motion = rest(slider, driven, problem, nodes=16, truncation=1e-12)
        found[k] = steps(problem, motion.state, cycles, STEPS[k][0])[:, Recorded.VELOCITY]
    reference, every = burst.reference(exact[-1]), max(1, cycles // 48)
    late = np.append(np.arange(cycles // 2, cycles, every), cycles - 1)
    first = np.arange(every - 1, min(WINDOW, cycles // 3), every)
    for k in levels[1:]:
        apart, off = np.abs(found[k] - found[k - 1]), np.abs(found[k] - exact)
        pair, expected = (STEPS[k][0], STEPS[k - 1][0]), STEPS[k][1] * reference
        whole = error_estimate.stepped_error(np.max(apart[late]), *pair, expected)
        stated = error_estimate.stepped_error(np.max(apart[first]), *pair)
        yield k, off[-1] / reference, whole / reference, np.max(off[first]) / reference, stated / reference


def in_parts(slider, orbits, cycles, number):
    """Yield (tolerance, true error over the stated one) of one long burst at three tolerances."""
    _, driven = towards_plus(orbits)
    problem = rest_problem(slider, driven)
    cycles = int(min(max(cycles, 3100), 9000) * np.random.default_rng(number).uniform(1.0, 1.33))
    if problem.segments * cycles > MAX_SEGMENTS or stepped_refusals(slider, problem, STEPS[1][0]):
        return
    exact = rest(slider, driven, problem, nodes=14, truncation=1e-11)
    exact.turn(cycles)
    for tolerance in PARTS_TOLERANCES:
        found = steps_checked_in_parts(Burst(slider, driven, problem, cycles, 1, tolerance, None))
        if found is not None and found.error > 0.0:
            yield tolerance, abs(found.run[0].state[2] - exact.state[2]) / found.error


def print_parts(draws, count):
    """Print the largest ratios of true and stated error of long bursts."""
    ratios = []
    for number in range(count):
        slider, orbits, *_, cycles = draw(draws, number)
        try:
            for tolerance, ratio in in_parts(slider, orbits, cycles, number):
                ratios.append(ratio)
                if ratio > 1.0:
                    print(f"{number}: {ratio:.2f} at a tolerance of {tolerance:g}")
        except ConvergenceError:
            continue
    print(f"{len(ratios)} answers, true over stated error: median {np.median(ratios):.2f}, largest {max(ratios):.2f}")


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", choices=("aimed", "calibration"), default="aimed")
    parser.add_argument("--number", type=int, default=400)
    parser.add_argument("--parts", action="store_true")
    chosen, rows = parser.parse_args(), []
    if chosen.parts:
        print_parts(chosen.draws, chosen.number)
        return
    for number in range(chosen.number):
        slider, orbits, *_, cycles = draw(chosen.draws, number)
        try:
            rows += compared(slider, orbits, min(cycles, LONGEST)) if cycles >= SHORTEST else []
        except ConvergenceError:
            continue
    print(f"{len(rows)} answers")
    for calibrated, share in product(*FACTORS):
        ratio = []
        for level, true, estimate, seen, stated in rows:
            least = share if level > 1 else 1.0
            error = error_estimate.calibrated_error(estimate, seen, stated, calibrated, least=least)
            ratio.append(true / max(error, 1e-13))
        ratio = np.array(ratio)
        print(
            f"CALIBRATION {calibrated:g}, LEAST_SHARE {share:g}: beyond once {np.sum(ratio > 1.0)}, twice "
            f"{np.sum(ratio > 2.0)}, median {np.median(ratio):.2g}, largest {np.max(ratio):.2f}"
        )


def draw(which, number):
    """Return (slider, orbits, cycles) of a draw."""
    if which == "calibration":
        return motors.around_the_seed(number)
    slider, orbits, _, cycles, _ = motors.aimed(number)
    return slider, orbits, cycles


if __name__ == "__main__":
    main()
