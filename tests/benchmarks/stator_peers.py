"""The stator against its peers, error and time: prints its tables; with --reference, NGSolve's finest answer.

    python -m tests.benchmarks.stator_peers [--ends free|absorbing] [--curves NAME ...] [--reference]

Every contender runs alone in its process, one thread; times are CPU seconds
of one more frequency after set-up.  Errors of admittance and u_z at x = 80 mm, complex, against a reference that no
contender shares.
"""

import argparse
import os
import platform

import numpy as np

from tests.validation.attempt import attempted
from tests.validation.contenders import CURVES, missing
from tests.validation.stator_reference import DIRECT, ENDS, problem, reference, seconds_at

FINEST = (
    {"order": 10, "edge_layers": 5, "element_size": 0.7, "condense": True},
    {"order": 11, "edge_layers": 6, "element_size": 0.6, "condense": True},
)


def main(arguments: list[str] | None = None) -> None:
    """Print the tables asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ends", choices=ENDS, nargs="+", default=ENDS)
    parser.add_argument("--curves", choices=tuple(CURVES), nargs="+", default=tuple(CURVES))
    parser.add_argument("--reference", action="store_true")
    asked = parser.parse_args(arguments)
    print(f"{platform.machine()}, {os.cpu_count()} cores, one thread, CPU seconds, numpy {np.__version__}")
    if asked.reference:
        finest()
        return
    for ends in asked.ends:
        table(ends, tuple(asked.curves))


def table(ends: str, curves: tuple[str, ...]) -> None:
    """Print a row for each contender, and what NGSolve's time is over the band's at equal error."""
    posed = problem(ends)
    truth = reference(posed)
    print(f"\n{ends} ends\n")
    print("| method | setting | unknowns | error of u_z | error of Y | set-up, s | per frequency, s | peak, MB |")
    print("|---|---|---|---|---|---|---|---|")
    found: dict[str, list] = {}
    for curve in curves:
        if lacking := missing(curve):
            print(f"{curve} is left out: pip install {' '.join(lacking)}")
            continue
        for setting in CURVES[curve][1]:
            each = attempted(curve, posed, setting, repeats=0 if curve in DIRECT else 1)
            found.setdefault(curve, []).append(each)
            admittance, motion = each.errors(truth)
            print(
                f"| {curve} | {each.setting} | {each.unknowns} | {motion:.1e} | {admittance:.1e} "
                f"| {each.setup_seconds:.1f} | {each.seconds:.3g} | {each.peak_bytes / 1e6:.0f} |",
                flush=True,
            )
    if {"NGSolve", "band"} <= set(found):
        for error in (1e-3, 1e-4, 1e-5):
            peer, own = (seconds_at(found[name], truth, error) for name in ("NGSolve", "band"))
            print(f"equal error {error:g}: {peer:.2f} s against {1e3 * own:.1f} ms, {peer / own:.0f} times")


def finest() -> None:
    """Print NGSolve's finest answers for free ends and what is between them (8 GB, minutes)."""
    posed = problem("free")
    answers = []
    for setting in FINEST:
        each = attempted("NGSolve", posed, setting, repeats=0)
        answers.append(np.array([each.admittance, *each.motion]))
        print(each.setting, [complex(value) for value in answers[-1]])
    print("relative differences", abs(answers[1] / answers[0] - 1))


if __name__ == "__main__":
    main()
