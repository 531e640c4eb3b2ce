"""The stored references of meshed pieces against a coarser NGSolve model made anew."""

import numpy as np
import pytest

from tests.fem.piece_references import REFERENCES
from tests.validation.ngsolve_pieces import reference_of


@pytest.mark.slow
@pytest.mark.parametrize("case", REFERENCES)
def test_the_references_are_what_ngsolve_says(case):
    pytest.importorskip("ngsolve", reason="NGSolve is the optional extra `peers`")
    admittance, motion = reference_of(case, 9, 7, 0.5)
    stored, moved = REFERENCES[case]
    assert abs(admittance / stored - 1) < 5e-6
    assert np.abs(motion - moved).max() < 5e-6 * np.abs(moved).max()
