"""The driven stator's error against run time, level by level, and a band of frequencies: prints its tables.

    python tests/benchmarks/stator.py

The seed's stator (160 x 5 mm, two transducers of 10 finger pairs, 2.2 MHz), absorbing and free ends, one thread.  The
error is that of the surface motion 65 mm from the driven transducer's centre and of the admittance, against the finest
level; times are medians of three, CPU of one thread.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import platform
import statistics
import time
from dataclasses import replace

import numpy as np

from fem.discretize.mesh_refinement import LEVELS
from fem.geometry import Stator, Transducer
from fem.materials import material
from fem.results.field_evaluation import surface_of
from fem.solve.band_solution import frequency_band
from fem.solve.driven_stator import motion_difference, solve_driven

FREQUENCY, PLACE = 2.2e6, np.array([0.08])
STATOR = Stator(solid=material("PZT-8"), length=0.16, thickness=5e-3, ends="absorbing")
LEFT = Transducer(name="left", center=0.015, finger_pairs=10, period=0.983e-3, metallisation=0.5, aperture=0.02)
TRANSDUCERS = (LEFT, replace(LEFT, name="right", center=0.145))


def timed(work, repeats: int = 3):
    """Result and median CPU time in s of some work."""
    times = []
    for _ in range(repeats):
        begun = time.process_time()
        result = work()
        times.append(time.process_time() - begun)
    return result, statistics.median(times)


def levels(stator: Stator) -> None:
    """Print a row for each level but the finest, which is the reference."""
    rows = []
    for resolution in LEVELS:
        solution, seconds = timed(
            lambda resolution=resolution: solve_driven(
                stator, TRANSDUCERS, frequency=FREQUENCY, drive="left", resolution=resolution
            ),
            1 if resolution is LEVELS[-1] else 3,
        )
        motion = surface_of(solution).motion(PLACE)
        rows.append((resolution, motion, solution, seconds))
    _, exact, reference, _ = rows[-1]
    print(f"\n{stator.ends} ends\n")
    print("| order | edge layers | unknowns | error of u | error of Y | seconds |")
    print("|---|---|---|---|---|---|")
    for resolution, motion, solution, seconds in rows[:-1]:
        error = motion_difference(motion, exact)
        admittance = abs(solution.circuit.admittance / reference.circuit.admittance - 1)
        print(
            f"| {resolution.order} | {resolution.edge_layers} | {solution.fields.unknowns} | {error:.1e} "
            f"| {admittance:.1e} | {seconds:.2f} |"
        )


def bands(stator: Stator) -> None:
    """Print set-up time, size and time per frequency of a 2.1 to 2.3 MHz band at 1e-3."""
    made, setup = timed(
        lambda: frequency_band(
            stator, TRANSDUCERS, lowest=2.1e6, highest=2.3e6, drive="left", tolerance=1e-3, places=(0.08,)
        ),
        1,
    )
    sweep = np.linspace(2.1e6, 2.3e6, 21)
    _, seconds = timed(lambda: [made.wave(float(frequency), "left") for frequency in sweep])
    print(
        f"| {stator.ends} | {made.model.section.full.size} | {made.model.section.size} | {made.relative_error:.1e} "
        f"| {made.admittance_error:.1e} | {setup:.1f} | {1e3 * seconds / len(sweep):.0f} |"
    )


def main() -> None:
    """Print both tables."""
    print(f"{platform.machine()}, {os.cpu_count()} cores, one thread, numpy {np.__version__}")
    stators = (STATOR, replace(STATOR, ends="free"))
    for stator in stators:
        levels(stator)
    print("\n| ends | unknowns of a line | reduced | error of u | error of Y | set-up, s | per frequency, ms |")
    print("|---|---|---|---|---|---|---|")
    for stator in stators:
        bands(stator)


if __name__ == "__main__":
    main()
