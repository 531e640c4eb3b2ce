"""Stored answers of slow oracles: tests compare with them, and a slow test compares them with the live oracles.

A function that evaluates an oracle for named cases is decorated by `frozen`; its answers stand in
``tests/data/MODULE.FUNCTION.npz``. This is the script that made these files, and makes them anew:

    python -m tests.frozen [MODULE ...]
"""

import sys
from collections.abc import Callable, Sequence
from functools import wraps
from importlib import import_module
from pathlib import Path

import numpy as np

DATA = Path(__file__).parent / "data"
MODULES = (
    "tests.contact.test_friction",
    "tests.contact.test_memory_motion",
    "tests.contact.test_ring_down",
    "tests.contact.test_steady",
    "tests.contact.test_track",
    "tests.contact.test_unequal_contacts",
    "tests.fem.analytic.test_quasistatic",
    "tests.fem.beam.test_strip_force",
    "tests.fem.discretize.test_half_space",
    "tests.fem.solve.test_near_force",
    "tests.fem.solve.test_vacuum",
    "tests.studies.test_waveform",
    "tests.validation.test_rough_balls",
)
SAME = 1e-7  # relative: rounding on another machine, in the integrals of the oracles


def frozen(cases: Sequence[tuple]) -> Callable[[Callable], Callable]:
    """Return the decorator of a function whose answers for some cases, numbers or arrays, are stored.

    ``cases``: the arguments, of words and numbers, by whose text an answer is found.
    """

    def decorated(oracle: Callable) -> Callable:
        file = DATA / f"{oracle.__module__.rpartition('.')[2]}.{oracle.__name__}.npz"

        @wraps(oracle)
        def stored(*arguments):
            answers = np.load(file)
            assert repr(arguments) in answers, f"{file.name} lacks {arguments}: python -m tests.frozen"
            return answers[repr(arguments)]

        stored.live, stored.cases, stored.file = oracle, tuple(cases), file
        return stored

    return decorated


def stored_in(module: str) -> list[Callable]:
    """Return the functions of a module whose answers are stored."""
    return [each for each in vars(import_module(module)).values() if hasattr(each, "live")]


if __name__ == "__main__":
    for name in sys.argv[1:] or MODULES:
        for each in stored_in(name):
            np.savez_compressed(each.file, **{repr(case): each.live(*case) for case in each.cases})
            print(f"wrote {each.file}")
