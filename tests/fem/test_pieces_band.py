"""Meshed pieces over a band of frequencies: rational interpolation against a condensation at each frequency."""

from dataclasses import replace

import numpy as np
import pytest

from fem.condense.interpolated_piece import PieceSample, rational_piece
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.materials.christoffel import slowest_wavelength
from fem.mesh.mesh_piece import MeshPiece
from fem.mesh.section_mesh import read_mesh
from fem.results.field_evaluation import surface_of
from fem.solve.band_solution import frequency_band
from fem.solve.driven_stator import solve_driven
from fem.waveguide.stator_meshes import StatorMeshes
from tests.fem.drawings import bevelled_end, rectangle
from tests.fem.stators import comb, cut, plate

COARSE = Resolution(order=5, edge_layers=0)


def _grooved(tmp_path, quality=200.0, **sides):
    stator = plate(cut("PZT-4", "Z", quality=quality), length=9.0, **sides)
    unit = stator.thickness / 0.8
    path = rectangle(tmp_path / "groove.msh", 0.9, 0.8, size=0.45, groove=(0.35, 0.2, 0.1))
    piece = MeshPiece(name="groove", mesh=read_mesh(path, unit), position=4.2 * unit)
    return replace(stator, pieces=(piece,))


@pytest.mark.parametrize("quality", [np.inf, 200.0])
def test_interpolation_through_the_resonances_of_the_clamped_piece(tmp_path, quality):
    """Three nodes over 12 %, on lines of few fields: the matrix between them, where without loss it has poles.

    A polynomial through the same nodes errs by more than the matrix.
    """
    stator = _grooved(tmp_path, quality)
    unit = slowest_wavelength(stator.solid, 2.4e6)
    section = discretise(stator, COARSE, wavelength=unit, surface_scale=np.inf)
    row = StatorMeshes(stator, section, COARSE, 2.4e6)
    (assembly,) = row.assemblies.values()
    line = np.polynomial.legendre.legvander(np.linspace(-1, 1, section.size), 5)
    frame = np.kron(np.eye(2), np.linalg.qr(line)[0])
    exact = {f: assembly.condensed(f) for f in (2.14e6, 2.16e6, 2.2e6, 2.27e6, 2.33e6, 2.38e6)}
    samples = [PieceSample.of(exact[f], frame) for f in (2.14e6, 2.27e6, 2.38e6)]
    step = 1e3
    slope = (assembly.condensed(2.14e6 + step).matrix - assembly.condensed(2.14e6 - step).matrix) / (
        16 * np.pi**2 * 2.14e6 * step
    )
    assert samples[0].inertia == pytest.approx(-frame.T @ slope @ frame, rel=1e-3, abs=1e-4 * abs(slope).max())
    reduced = rational_piece(exact[2.14e6], frame, 6, samples)
    for frequency, piece in exact.items():
        own, true = reduced.at(frequency).matrix, frame.T @ piece.matrix @ frame
        assert abs(own - own.T).max() == 0
        assert abs(own - true).max() < 2e-5 * abs(true).max()


@pytest.mark.parametrize("kind", ["groove", "end"])
def test_a_band_with_a_piece_is_each_frequency_alone(tmp_path, kind):
    """Motion and admittance of a band of 5 % against solutions of the same discretisation, within the stated error."""
    stator = _grooved(tmp_path)
    unit = stator.thickness / 0.8
    if kind == "end":
        path = bevelled_end(tmp_path / "end.msh", 0.7, 0.5, 0.8, size=0.35)
        end = MeshPiece(name="end", mesh=read_mesh(path, unit), position=8.3 * unit)
        stator = replace(stator, ends="free", pieces=(end,))
    row, place = (comb(stator, "a", 1.5, finger_pairs=2, metallisation=0.45),), 6.6 * unit
    low, high = 2.24e6, 2.36e6
    band = frequency_band(stator, row, lowest=low, highest=high, drive="a", tolerance=2e-2, places=(place,))
    assert band.relative_error < 2e-2
    assert band.model.pieces
    for frequency in (2.245e6, 2.281e6, 2.357e6):
        alone = solve_driven(stator, row, frequency=frequency, drive="a", resolution=band.model.resolution)
        wave, exact = band.wave(frequency, "a"), surface_of(alone).motion(np.array([place]))
        assert abs(wave.motion(np.array([place])) - exact).max() < band.relative_error * abs(exact).max()
        assert abs(wave.admittance / alone.circuit.admittance - 1) < band.admittance_error
    on_piece = (stator.pieces[0].extent[0] + 0.1 * unit,)
    assert abs(wave.motion(np.array(on_piece)) - surface_of(alone).motion(np.array(on_piece))).max() < (
        band.relative_error * abs(exact).max()
    )
