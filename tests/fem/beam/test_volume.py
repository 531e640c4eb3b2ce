"""The beam against a three-dimensional finite-element model of other code."""

from dataclasses import replace

import numpy as np
import pytest

from fem.beam.beam_of_section import surface_beam
from fem.beam.electrode_charges import electrode_charges
from fem.materials.christoffel import slowest_wavelength
from tests.fem.stators import FREQUENCY, comb, cut, plate, solution, wave_of
from tests.oracles.fem_plate_volume import comb_motion


def _over_the_section(solid, *, period: float, **given) -> np.ndarray:
    """u_x and u_z of the mesh with the charges of its own section, over those of the section, (2, points)."""
    given |= {"period": period, "frequency": FREQUENCY, "fingers": 6}
    plane, reactions = comb_motion(solid, aperture=np.inf, **given)
    return comb_motion(solid, aperture=4 * period, reactions=reactions, **given)[[0, 2]] / plane[[0, 2]]


@pytest.mark.slow
def test_three_dimensional_mesh_with_the_charges_of_the_section():
    """Three finger pairs of 4 wavelengths aperture, 3 wavelengths away, in a plate that guides one mode.

    With potentials instead of charges the mesh differs from the beam by 0.36 of the section's amplitude, and by 0.24 at
    6 wavelengths of aperture: this mode, near its cut-off and strongly coupled, makes the charges of the mesh vary by a
    third along the fingers, and the fingers' dipoles are as large as their charges.
    """
    solid, period, thickness = cut("PZT-8", "Z", quality=15.0), 2.575, 0.45  # one wavelength of the mode
    unit = slowest_wavelength(solid, FREQUENCY)
    points = np.array([[4.5, y] for y in (0.0, 0.5, 1.0, 1.5)]) * period * unit
    size = {"period": period * unit, "thickness": thickness * unit}
    mesh = _over_the_section(solid, points=points, per_period=3, **size)
    stator = plate(solid, length=40.0, thickness=thickness, bottom="clamped")
    one = comb(stator, "a", 16.0, finger_pairs=3, aperture=4 * period * unit, period=period)
    beam = surface_beam(wave_of(solution(stator, (one,), order=7, layers=2)))
    beam = replace(beam, charges=(electrode_charges(beam.wave.solution, 0),))
    section = beam.wave.motion(one.center + points[0, 0])
    found = beam.motion(one.center + points[:, 0], points[:, 1])[[0, 2]] / section[:, None]
    assert abs(found - mesh).max() < 0.03
    assert abs(found - 1).max() > 0.2


@pytest.mark.slow
def test_three_dimensional_mesh_between_free_faces():
    """The same comb in the middle of a plate of 8 wavelengths whose ends are free, one wavelength from a face."""
    solid, period, thickness = cut("PZT-8", "Z", quality=15.0), 2.575, 0.45
    unit = slowest_wavelength(solid, FREQUENCY)
    points = np.array([[3.0, y] for y in (0.0, 0.5, 1.0, 1.5)]) * period * unit
    size = {"period": period * unit, "thickness": thickness * unit}
    mesh = _over_the_section(solid, points=points, face=4 * period * unit, **size)
    stator = plate(solid, length=8 * period, thickness=thickness, bottom="clamped", ends="free")
    one = comb(stator, "a", 4 * period, finger_pairs=3, aperture=4 * period * unit, period=period)
    beam = surface_beam(wave_of(solution(stator, (one,), order=7, layers=2)))
    section = beam.wave.motion(one.center + points[0, 0])
    found = beam.motion(one.center + points[:, 0], points[:, 1])[[0, 2]] / section[:, None]
    assert abs(found - mesh).max() < 0.03
    assert abs(found - 1).max() > 0.2
    absorbing = replace(beam, faces=None).motion(one.center + points[:, 0], points[:, 1])[[0, 2]]
    assert abs(absorbing / section[:, None] - mesh).max() > 0.1
