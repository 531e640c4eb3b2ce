"""Beams on half-spaces of lithium niobate: against Stroh's problem at every wave vector."""

from dataclasses import replace

import numpy as np
import pytest

import fem
from fem.beam.beam_of_section import surface_beam
from fem.discretize.mesh_refinement import LEVELS
from fem.solve.driven_stator import solve_driven
from tests.fem.stators import constants, wave_of
from tests.oracles.fem_half_space_field import HalfSpaceField

CUTS = {"128YX": ("LiNbO3 (Kovacs)", 10e6, 0.396e-3), "YZ": ("LiNbO3 (Warner)", 9.6e6, 0.363e-3)}


def beam_and_field(cut: str, pairs: int, aperture: float, x, y, highest=4.0):
    """A transducer of a half-space at 10 mm; the oracle's motion at places."""
    name, frequency, period = CUTS[cut]
    stator = fem.Stator(solid=fem.rotated(fem.material(name), cut), length=0.07, thickness=np.inf, ends="absorbing")
    one = fem.Transducer(name="a", center=0.01, finger_pairs=pairs, period=period, metallisation=0.5, aperture=aperture)
    solved = solve_driven(stator, (one,), frequency=frequency, drive="a", resolution=LEVELS[1])
    beam = surface_beam(wave_of(solved))
    beam = replace(beam, wave=replace(beam.wave, relative_error=1e-5))  # the oracle has its charges
    solid, charges = stator.solid, beam.charges[0]
    field = HalfSpaceField(**constants(solid), frequency=frequency)
    expected = field.motion(
        x - one.center,
        y,
        places=charges.x - one.center,
        charges=charges.charge,
        aperture=aperture,
        surface_wavenumber=2 * np.pi * frequency / beam.wave.phase_velocity,
        highest=highest,
    )
    return beam, expected


def errors(beam, expected, x, y) -> tuple[np.ndarray, np.ndarray]:
    """Of u_x, u_y and u_z over max(|u_x|, |u_z|), and the stated ones."""
    motion, stated = beam.motion_and_error(x, y)
    return abs(motion - expected) / abs(motion[[0, 2]]).max(axis=0), stated


@pytest.mark.slow
def test_beside_and_before_a_short_transducer():
    """Two pairs of 2 mm on YZ: all three components, at up to 45 degrees from the fingers' ends.

    The fast guard: test_half_space_beam.py, |u_z| at one place in 128YX.
    """
    x, y = np.array([0.0117, 0.012, 0.012]), np.array([0.3e-3, 0.0, 1.1e-3])
    beam, expected = beam_and_field("YZ", 2, 2e-3, x, y, highest=8.0)
    off, stated = errors(beam, expected, x, y)
    assert abs(expected[1]).max() > 0.02 * abs(expected).max()
    assert off.max() < 5e-5
    assert np.all(off.max(axis=0) < stated)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("cut", CUTS)
def test_nineteen_of_twenty_places(cut, seed):
    """Transducers drawn at random: 34 places each, 272 together."""
    rng = np.random.default_rng(100 + seed)
    pairs, aperture = int(rng.integers(3, 16)), rng.uniform(2e-3, 20e-3)
    x = 0.01 + rng.uniform((pairs / 2 + 2) * CUTS[cut][2], 15e-3, 34)
    y = rng.uniform(-0.7, 0.7, 34) * aperture
    beam, expected = beam_and_field(cut, pairs, aperture, x, y)
    off, stated = errors(beam, expected, x, y)
    assert np.mean(off.max(axis=0) < 2 * stated) >= 0.95
    assert np.median(off) < 2e-3
