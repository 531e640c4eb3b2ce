"""Errors of stators whose waves come back to an absorbing bottom: against much finer answers."""

from dataclasses import replace

import numpy as np
import pytest

import fem
from fem.discretize.mesh_refinement import GAIN, LEVELS, RESONANT_GAIN, level_gain
from tests.fem.stators import cut, lossless, solution, wave_of

# Stators as tests.validation.random_scene draws them: number 51 of seed 20261128 is the first one's kind.
KINDS = {
    "YZ, free": ("LiNbO3 (Warner)", "YZ", "free"),
    "YZ, clamped": ("LiNbO3 (Warner)", "YZ", "clamped"),
    "128YX, free": ("LiNbO3 (Kovacs)", "128YX", "free"),
    "ST-X, free": ("quartz (Bechmann)", "ST-X", "free"),
}


def stator_of(material, orientation, ends, *, frequency=3e6):
    solid = lossless(material, orientation)
    wavelength = fem.rayleigh(solid, "open").velocity / frequency
    stator = fem.Stator(
        solid=solid, length=26.3 * wavelength, thickness=1.7 * wavelength, bottom="absorbing", ends=ends
    )
    comb = fem.Transducer(
        name="left", center=6.1 * wavelength, finger_pairs=4, period=1.01 * wavelength, metallisation=0.45,
        aperture=20 * wavelength,
    )  # fmt: skip
    return stator, comb, wavelength


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_the_error_between_reflecting_ends_is_the_one_stated(kind):
    stator, comb, wavelength = stator_of(*KINDS[kind])
    x = wavelength * np.array([12.1, 15.3, 18.7, 18.9])

    def motion(level: int) -> np.ndarray:
        own = LEVELS[level]
        options = {"order": own.order, "layers": own.edge_layers, "absorber": own.absorber}
        return wave_of(solution(stator, (comb,), frequency=3e6, drive="left", **options)).motion(x)

    coarse, fine, finest = (motion(level) for level in (1, 2, 4))
    size = abs(finest).max()
    stated = abs(fine - coarse).max() / size / (level_gain(stator) - 1)
    assert abs(fine - finest).max() / size < 2 * stated


def test_where_the_gain_is_that_of_a_resonance():
    for material, orientation, _ in KINDS.values():
        stator, *_ = stator_of(material, orientation, "free")
        assert level_gain(stator) == RESONANT_GAIN
        assert level_gain(replace(stator, ends="absorbing")) == GAIN
        assert level_gain(replace(stator, bottom="free")) == GAIN
    for material in ("PZT-8", "PZT-5H"):  # matched, and selective with much loss
        stator, *_ = stator_of(material, "Z", "free")
        assert level_gain(replace(stator, solid=cut(material, "Z"))) == GAIN
