"""True over stated error of bands of frequencies, on stators drawn for resonances and loose to tight tolerances.

    python -m tests.benchmarks.band_error [DRAWS] [FIRST]

Truth: a full solution two levels finer, at the ends of the band, at one frequency drawn and at the two where the motion
peaks, because resonances amplify errors. Prints one line for each draw and the number beyond once and twice.
"""

import sys
from contextlib import suppress

import numpy as np

from fem.discretize.mesh_refinement import LEVELS
from fem.exceptions import ConvergenceError
from fem.results.field_evaluation import surface_of
from fem.solve.band_solution import frequency_band
from fem.solve.driven_stator import motion_difference, solve_driven
from tests.fem.stators import FREQUENCY, comb, cut, plate

SOLIDS = ("PZT-8", "Z"), ("PZT-4", "Z"), ("LiNbO3 (Warner)", "128YX"), ("LiNbO3 (Warner)", "YZ")
SCANNED = 101  # frequencies at which the band itself is searched for its peaks


def drawn(number: int) -> tuple:
    """Return (stator, transducers, limits in Hz, tolerance, positions in m) of a draw."""
    draw = np.random.default_rng(7000 + number)
    name, orientation = SOLIDS[draw.integers(len(SOLIDS))]
    quality = float(10 ** draw.uniform(1.8, 3.7))
    length, ends = draw.uniform(6.0, 25.0), str(draw.choice(["free", "clamped", "absorbing"], p=[0.5, 0.25, 0.25]))
    stator = plate(
        cut(name, orientation, quality=quality, loss=1e-3),
        length=length, thickness=draw.uniform(0.5, 1.8), ends=ends,
    )  # fmt: skip
    period = draw.uniform(0.95, 1.1)
    row = [comb(stator, "a", 2.6, finger_pairs=int(draw.integers(1, 3)), period=period)]
    if length > 12 and draw.random() < 0.5:
        row.append(comb(stator, "b", length - 3.2, finger_pairs=2, period=period, pattern="+o-o"))
    half = draw.uniform(0.005, 0.08)
    limits = (1 - half) * FREQUENCY, (1 + half) * FREQUENCY
    place = draw.uniform(4.5, length - 5.2) if length > 12 else 0.8 * length
    at = np.array([place / length * stator.length])
    return stator, tuple(row), limits, float(10 ** draw.uniform(-4, -1.5)), at


def ratios(number: int):
    """Return (band, true over stated error of the motion, the same of the admittance); None without an answer."""
    stator, row, (low, high), tolerance, at = drawn(number)
    try:
        band = frequency_band(stator, row, lowest=low, highest=high, drive="a", tolerance=tolerance, places=tuple(at))
    except ConvergenceError as error:
        band = error.reached
        if not hasattr(band, "model"):
            return None
    scan = np.linspace(low, high, SCANNED)
    sizes = np.array([abs(wave.motion(at)).max() for wave in band.waves(scan, "a")])
    peaks = scan[np.argsort(sizes)[-1:]], scan[np.argsort(abs(np.gradient(sizes)))[-1:]]
    finer = LEVELS[min(LEVELS.index(band.model.resolution) + 2, len(LEVELS) - 1)]
    worst = np.zeros(2)
    for frequency in (low, high, np.random.default_rng(number).uniform(low, high), *map(float, np.hstack(peaks))):
        with suppress(ConvergenceError):
            full = solve_driven(stator, row, frequency=frequency, drive="a", resolution=finer)
            wave = band.wave(frequency, "a")
            motion = motion_difference(wave.motion(at), surface_of(full).motion(at))
            admittance = abs(wave.admittance / full.circuit.admittance - 1)
            worst = np.maximum(worst, [motion / band.relative_error, admittance / band.admittance_error])
    return band, *worst


def main() -> None:
    """Print the ratios."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    found = []
    for number in range(first, first + count):
        answer = ratios(number)
        if answer is None:
            print(f"{number}: no band")
            continue
        band, *both = answer
        stator, _, _, tolerance, _ = drawn(number)
        print(
            f"{number}: {stator.ends}, tolerance {tolerance:.1e}, stated {band.relative_error:.1e}, "
            f"true over stated {both[0]:.2f} (admittance {both[1]:.2f}), {band.model.resolution.name}",
            flush=True,
        )
        found.append(both)
    largest = np.max(found, axis=1)
    print(
        f"{len(found)} bands: beyond once {np.sum(largest > 1)}, twice {np.sum(largest > 2)}, median "
        f"{np.median(largest):.2f}, largest {np.max(largest):.2f}"
    )


if __name__ == "__main__":
    main()
