"""NGSolve on meshed pieces: the stored references made anew by a coarser model, and the reflection of grooves."""

import numpy as np
import pytest

import fem
from tests.fem.drawings import rectangle
from tests.fem.piece_references import REFERENCES
from tests.fem.stators import cut
from tests.validation import ngsolve_reflection
from tests.validation.ngsolve_pieces import FREQUENCY, reference_of


@pytest.mark.slow
@pytest.mark.parametrize("case", REFERENCES)
def test_the_references_are_what_ngsolve_says(case):
    pytest.importorskip("ngsolve", reason="NGSolve is the optional extra `peers`")
    admittance, motion = reference_of(case, 9, 7, 0.5)
    stored, moved = REFERENCES[case]
    assert abs(admittance / stored - 1) < 5e-6
    assert np.abs(motion - moved).max() < 5e-6 * np.abs(moved).max()


@pytest.mark.slow
@pytest.mark.parametrize("case", ngsolve_reflection.CASES)
def test_reflection_of_the_surface_wave(tmp_path, case):
    """R and T at the grooves' outer edges, from NGSolve's motion alone: 3e-5 and 1.3e-4 apart for one groove."""
    pytest.importorskip("ngsolve", reason="NGSolve is the optional extra `peers`")
    k, scattered, residual = ngsolve_reflection.scattering(
        *ngsolve_reflection.sampled(case, order=7, layers=5, size=0.55)
    )
    assert residual < 1e-4
    grooves = [(0.3 + x, width, depth) for x, width, depth in ngsolve_reflection.CASES[case]]
    width = 0.6 + grooves[-1][0] + grooves[-1][1] - grooves[0][0]
    thickness = ngsolve_reflection.THICKNESS
    path = rectangle(tmp_path / "grooves.msh", width, thickness, size=0.25, groove=grooves)
    piece = fem.MeshPiece(name="grooves", mesh=fem.read_mesh(path, 1e-3), position=6e-3)
    stator = fem.Stator(
        solid=cut("PZT-4", "Z"), length=15e-3, thickness=thickness * 1e-3, ends="absorbing", pieces=(piece,)
    )
    row = fem.reflector(stator, frequency=FREQUENCY, tolerance=1e-5)
    surface = np.argmin(abs(k - 2 * np.pi / row.wavelength * 1e-3))
    to_the_edges = np.exp(2j * k[surface] * 0.3)
    assert scattered[surface, surface] == pytest.approx(row.reflection * to_the_edges, abs=4e-4)
    assert scattered[len(k) + surface, surface] == pytest.approx(row.transmission * to_the_edges, abs=4e-4)
