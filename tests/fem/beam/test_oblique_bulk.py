"""What the surface wave alone leaves out of a beam on lithium niobate: against the whole response of the half-space."""

from dataclasses import replace

import numpy as np
import pytest

import fem
from fem.beam.surface_beam import surface_beam
from fem.discretize.refinement import LEVELS
from fem.solve.harmonic import solve_driven
from tests.fem.stators import wave_of
from tests.oracles.fem_half_space_field import HalfSpaceField

CUTS = {"128YX": ("LiNbO3 (Kovacs)", 10e6, 0.396e-3), "YZ": ("LiNbO3 (Warner)", 9.6e6, 0.363e-3)}


def beam_and_field(cut: str, pairs: int, aperture: float, x, y):
    """A transducer of a half-space at 10 mm; the oracle's motion at places."""
    name, frequency, period = CUTS[cut]
    stator = fem.Stator(
        solid=fem.rotated(fem.material(name), cut), length=0.07, thickness=np.inf, ends="absorbing"
    )
    one = fem.Transducer(
        name="a", center=0.01, finger_pairs=pairs, period=period, metallisation=0.5, aperture=aperture
    )
    solved = solve_driven(stator, (one,), frequency=frequency, drive="a", resolution=LEVELS[2])
    beam = surface_beam(wave_of(solved))
    beam = replace(beam, wave=replace(beam.wave, relative_error=1e-4))
    solid, (places, charges) = stator.solid, beam.charges[0].sheets(aperture, 0.0)[0].lumps
    field = HalfSpaceField(
        stiffness=solid.stiffness_lossy,
        coupling=solid.coupling,
        permittivity=solid.permittivity_lossy,
        density=solid.density,
        frequency=frequency,
    )
    expected = field.motion(
        x - one.center,
        y,
        places=places - one.center,
        charges=charges,
        aperture=aperture,
        surface_wavenumber=2 * np.pi * frequency / beam.wave.phase_velocity,
    )
    return beam, expected


def test_a_place_near_the_edge_of_a_beam():
    """Ten pairs of 5 mm on 128YX, 5 mm away: |u_z| is 7.198e-11 m/V (an independent program)."""
    x, y = np.array([0.015, 0.015]), np.array([-2e-3, 0.0])
    beam, expected = beam_and_field("128YX", 10, 5e-3, x, y)
    assert abs(expected[2, 0]) == pytest.approx(7.198e-11, rel=3e-3)
    motion = beam.motion(x, y)
    assert abs(motion - expected)[[0, 2]].max() < 5e-3 * abs(expected).max()


@pytest.mark.slow
@pytest.mark.parametrize(("cut", "pairs", "aperture"), [("YZ", 10, 12e-3), ("YZ", 5, 2e-3)])
def test_nineteen_of_twenty_places(cut, pairs, aperture):
    rng = np.random.default_rng(pairs)
    x = 0.01 + rng.uniform((pairs / 2 + 1.5) * CUTS[cut][2], 9e-3, 40)
    y = rng.uniform(-0.6, 0.6, 40) * aperture
    beam, expected = beam_and_field(cut, pairs, aperture, x, y)
    motion, stated = beam.motion_and_error(x, y)
    size = abs(motion[[0, 2]]).max(axis=0)
    off = abs(motion - expected) / size
    assert np.mean(off[[0, 2]].max(axis=0) < 2 * stated) >= 0.9
    assert np.mean(off[1] < 2 * (stated + beam.lateral_error(x, y))) >= 0.95
    assert np.median(stated) < 4 * np.median(off[[0, 2]].max(axis=0)) + 0.02
