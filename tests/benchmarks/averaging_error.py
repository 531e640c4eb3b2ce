r"""Stated against true error of averaged bursts, aimed at where averaging is weak; the truth is the event-exact method.

Random sliders with a strong Hunt-Crossley damper, with a load while they hop, without normal damping, and on several
contacts at different phases of the wave. Prints how many are further off than twice the error that they state, and
how many beyond the tolerance with status "ok", of the answers by averaging itself. `--share S` multiplies the two
shares of what second order leaves, `--checked C` sets the number of first cycles in which the exact method checks it,
and `--draws` takes the sliders of the families `aimed` or `around_the_seed` of `tests/motors.py` instead.

    python -m tests.benchmarks.averaging_error --number 100
    python -m tests.benchmarks.averaging_error --draws aimed --number 320
    python -m tests.benchmarks.averaging_error --draws calibration --number 200
"""

import argparse
from itertools import islice

import numpy as np

from contact import ConvergenceError, burst, error_estimate
from contact.answers import burst_methods
from contact.averaged import burst as averaged
from tests import motors

LONGEST = 6000  # cycles of a burst of `--draws`


def drawn(which: str, number: int):
    """Yield (slider, orbits, cycles, tolerance) of the tests' draws to which averaging applies."""
    for k in range(number):
        if which == "aimed":
            slider, orbits, method, cycles, tolerance = motors.aimed(k)
            tolerances = (tolerance,) if method == "averaged" else ()
        else:
            slider, orbits, cycles = motors.around_the_seed(k)
            tolerances = motors.TOLERANCES
        for tolerance in () if averaged.refusals(slider, orbits) else tolerances:
            yield slider, orbits, min(cycles, LONGEST), tolerance


def errors(slider, orbits, cycles, tolerance):
    """Return (true error, stated error, status) of the averaged burst, relative in the sense of `tolerance`.

    None if the exact method answers, because averaging misses the tolerance.
    """

    def run(method, allowed):
        duration = cycles / orbits[0].frequency
        return burst(slider, orbits, duration=duration, after=0.0, tolerance=allowed, samples=2, method=method)

    found = run("averaged", tolerance)
    if found.method != "averaged":
        return None
    exact = run("exact", 1e-8)
    reference = error_estimate.reference_speed(exact.velocity_at_burst_end, orbits)
    true = abs(found.velocity_at_burst_end - exact.velocity_at_burst_end) / reference
    return true, found.relative_error, found.status


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--number", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--share", type=float, default=1.0)
    parser.add_argument("--checked", type=int, default=burst_methods.CHECKED)
    parser.add_argument("--draws", choices=("own", "aimed", "calibration"), default="own")
    chosen = parser.parse_args()
    error_estimate.LEFT_OF_FIRST *= chosen.share
    error_estimate.LEFT_OF_RATIO *= chosen.share
    burst_methods.CHECKED = chosen.checked
    rows, refused, exact = [], 0, 0
    own = chosen.draws == "own"
    drawn_by_name = drawn(chosen.draws, chosen.number)
    hard = islice(motors.hard_to_average(chosen.seed, averaged.refusals), chosen.number)
    for scene in hard if own else drawn_by_name:
        try:
            found = errors(*scene)
        except ConvergenceError:
            refused += 1
            continue
        if found is None:
            exact += 1
            continue
        true, stated, status = found
        rows.append((true / stated, status == "ok", status == "ok" and true > scene[-1]))
    ratio, kept, beyond = np.array(rows).T
    print(
        f"{len(rows)} bursts, {refused} refused, {exact} by the exact method, {kept.sum():.0f} within the tolerance by "
        "their own estimate"
    )
    print(
        f"further off than twice the stated error: {np.sum(ratio > 2.0)}; "
        f"ok but beyond the tolerance: {beyond.sum():.0f}"
    )
    print(
        "true over stated, quantiles 0.5 0.9 0.95 1:", *(f"{q:.2f}" for q in np.quantile(ratio, (0.5, 0.9, 0.95, 1.0)))
    )


if __name__ == "__main__":
    main()
