"""Bands of frequencies against the full solution at frequencies where nothing was fitted."""

from dataclasses import replace

import numpy as np
import pytest

from fem.discretize.refinement import LEVELS
from fem.geometry import Stator, Transducer
from fem.materials import material, rotated
from fem.results.evaluation import surface_of
from fem.results.solution import solve_driven
from fem.solve.band_setup import frequency_band
from fem.solve.harmonic import motion_difference
from fem.solve.reduction import BandProblem, project, solve_at_nodes

PLACES = np.array([0.011])
CASES = {
    "PZT absorbing": ("PZT-8", "Z", "absorbing", 2.15e6, 1e-3),
    "PZT free": ("PZT-8", "Z", "free", 2.15e6, 1e-3),
    "PZT clamped": ("PZT-8", "Z", "clamped", 2.15e6, 1e-3),
    "YZ absorbing": ("LiNbO3 (Warner)", "YZ", "absorbing", 3.4e6, 1e-3),
}


def made(case):
    name, cut, ends, middle, period = CASES[case]
    block = Stator(solid=rotated(material(name), cut), length=0.02, thickness=2e-3, ends=ends)
    first = Transducer(name="a", center=5e-3, finger_pairs=3, period=period, metallisation=0.5, aperture=0.02)
    pair = (first, replace(first, name="b", center=0.0165, finger_pairs=2, pattern="+-o-"))
    return block, pair, middle


@pytest.mark.parametrize("case", CASES)
def test_band_follows_the_full_solution(case):
    """Reduced and interpolated against solved afresh on the same discretisation, within the tolerance."""
    block, pair, middle = made(case)
    low, high = 0.97 * middle, 1.03 * middle
    problem = BandProblem(
        stator=block, transducers=pair, limits=(low, high), drive="a", tolerance=1e-3, places=PLACES
    )
    model = project(problem, solve_at_nodes(problem, LEVELS[1]), 5e-6)
    assert model.section.size < 0.8 * model.section.full.size
    for frequency in (low, 0.993 * middle, 1.017 * middle, high):
        full = solve_driven(block, pair, frequency=frequency, drive="a", resolution=LEVELS[1])
        reduced = model.solution(frequency, "a")
        assert reduced.circuit.admittance == pytest.approx(full.circuit.admittance, rel=3e-4)
        motion = surface_of(reduced).motion(PLACES)
        assert motion_difference(motion, surface_of(full).motion(PLACES)) < 1e-3


def test_band_reports_its_error():
    """The error is that of the level, from a finer and a coarser one, plus that of the reduction: neither zero."""
    block, pair, middle = made("PZT absorbing")
    band = frequency_band(block, pair, lowest=0.98 * middle, highest=1.02 * middle, drive="a", tolerance=0.05)
    wave = band.wave(middle, "a")
    assert 0 < band.relative_error <= 0.06
    assert wave.relative_error == band.relative_error
    assert wave.seconds < band.seconds


@pytest.mark.parametrize(
    ("low", "high", "message"),
    [(2e6, 1e6, "lower to a higher"), (0.0, 1e6, "lower to a higher"), (1e6, 3e6, "must not be wider")],
)
def test_impossible_bands_are_refused(low, high, message):
    block, pair, _ = made("PZT absorbing")
    with pytest.raises(ValueError, match=message):
        frequency_band(block, pair, lowest=low, highest=high, drive="a", tolerance=0.05)


def test_frequency_outside_the_band_is_refused():
    block, pair, middle = made("PZT absorbing")
    band = frequency_band(block, pair, lowest=0.98 * middle, highest=1.02 * middle, drive="a", tolerance=0.05)
    with pytest.raises(ValueError, match="must lie in the band"):
        band.wave(1.1 * middle, "a")
