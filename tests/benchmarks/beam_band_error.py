"""True over stated error of bands of beams, some of them prepared a second time on a finer section.

    python -m tests.benchmarks.beam_band_error [DRAWS] [FIRST]

Draw 0 is the seed's stator from 1.9 to 2.5 MHz at 1e-2; the others are drawn stators of two ceramics, every second one
with long transducers and a wide band.  Truth: the beam of a full solution one level finer, at the ends of the band, at
one frequency drawn and at two where the motion peaks and changes fastest.  Prints one line for each draw, with the
number of bands of the section that were prepared, and the number of draws beyond once and twice.  About 7 CPU s for
each draw.
"""

import sys
from contextlib import suppress
from unittest.mock import patch

import numpy as np

from fem.beam.beam_of_section import surface_beam
from fem.discretize.mesh_refinement import LEVELS
from fem.exceptions import ConvergenceError
from fem.results.driven_answer import surface_wave
from fem.solve import beam_band as of_beams
from fem.solve.beam_band import beam_differences
from fem.solve.driven_stator import solve_driven
from tests.fem.stators import FREQUENCY, comb, cut, plate
from tests.validation.stator_reference import problem

SCANNED = 41  # frequencies at which the band itself is searched for its peaks


def drawn(number: int) -> tuple:
    """Return (stator, transducers, limits in Hz, tolerance, place (x, y) in m) of a draw."""
    if number == 0:
        posed = problem("absorbing")
        return posed.stator, posed.transducers, (1.9e6, 2.5e6), 1e-2, (posed.place, 0.0)
    draw = np.random.default_rng(8000 + number)
    aimed = number % 2 == 1  # long transducers and wide bands, whose beams miss the tolerance at first
    length, ends = 10 ** draw.uniform(1.8 if aimed else 1.0, 2.2), str(draw.choice(["absorbing", "free"], p=[0.8, 0.2]))
    solid = cut(str(draw.choice(["PZT-8", "PZT-4"])), "Z", quality=float(10 ** draw.uniform(1.7, 3.0)))
    stator = plate(solid, length=length, thickness=draw.uniform(0.6, 1.8), ends=ends)
    aperture, pairs = float(draw.uniform(3e-3, 8e-3)), int(draw.integers(6, 14) if aimed else draw.integers(1, 4))
    row = [comb(stator, "a", 1.0 + pairs, finger_pairs=pairs, aperture=aperture)]
    if length > 5 * pairs and draw.random() < 0.5:
        row.append(comb(stator, "b", length - 1.5 - pairs, finger_pairs=pairs, pattern="+-" * pairs, aperture=aperture))
    half = draw.uniform(0.1, 0.14) if aimed else draw.uniform(0.04, 0.14)
    first = 2.0 * pairs + 1.5
    last = max(first, length - 1.0 - first * (len(row) == 2))
    place = draw.uniform(first, last) / length * stator.length, float(draw.uniform(0.0, 0.4) * aperture)
    tolerance = float(10 ** (draw.uniform(-2.3, -1.7) if aimed else draw.uniform(-3, -1.5)))
    return stator, tuple(row), ((1 - half) * FREQUENCY, (1 + half) * FREQUENCY), tolerance, place


def ratios(number: int):
    """Return (band, sections prepared, true over stated error of motion, of admittance); None without an answer."""
    stator, row, (low, high), tolerance, place = drawn(number)
    drive = row[0].name
    options = {"drive": drive, "tolerance": tolerance, "places": (place,)}
    with patch.object(of_beams, "frequency_band", wraps=of_beams.frequency_band) as sections:
        try:
            band = of_beams.beam_band(stator, row, lowest=low, highest=high, **options)
        except ConvergenceError as error:
            band = error.reached
            if not isinstance(band, of_beams.BeamBand):
                return None
    scan = np.linspace(low, high, SCANNED)
    sizes = np.array([abs(band.beam(float(frequency), drive).motion(*place)).max() for frequency in scan])
    peaks = scan[np.argsort(sizes)[-1:]], scan[np.argsort(abs(np.gradient(sizes)))[-1:]]
    finer = LEVELS[min(LEVELS.index(band.band.model.resolution) + 1, len(LEVELS) - 1)]
    worst = np.zeros(2)
    for frequency in (low, high, np.random.default_rng(number).uniform(low, high), *map(float, np.hstack(peaks))):
        with suppress(ConvergenceError):
            solution = solve_driven(stator, row, frequency=frequency, drive=drive, resolution=finer)
            truth = surface_beam(surface_wave(solution, relative_error=0.0, admittance_error=0.0))
            beam = band.beam(frequency, drive)
            motion, admittance = beam_differences(truth, beam, np.array([place]).T)
            stated = float(beam.relative_error(*place)), beam.wave.admittance_error
            worst = np.maximum(worst, np.divide((motion, admittance), stated))
    return band, sections.call_count, *worst


def main() -> None:
    """Print the ratios."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    found = []
    for number in range(first, first + count):
        answer = ratios(number)
        if answer is None:
            print(f"{number}: no band", flush=True)
            continue
        band, prepared, *both = answer
        stator, _, (low, high), tolerance, _ = drawn(number)
        print(
            f"{number}: {stator.ends}, {low / 1e6:.3g} to {high / 1e6:.3g} MHz, tolerance {tolerance:.1e}, stated "
            f"{band.band.relative_error:.1e} and {band.relative_error:.1e} by the reduction, true over stated "
            f"{both[0]:.2f} (admittance {both[1]:.2f}), {band.band.model.resolution.name}, prepared {prepared} times",
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
