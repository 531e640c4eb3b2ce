"""The oracle of static finger ends: its convergence, and the stretched plane of an anisotropic dielectric."""

import numpy as np
import pytest

from tests.oracles.fem_finger_ends import end_excess


def dielectric(ratio):
    """Permittivity times |k| whose value along y is ``ratio`` times that along x."""
    return lambda k_x, k_y: np.hypot(k_x, ratio * k_y)


@pytest.mark.slow
def test_more_functions_along_and_longer_fingers():
    short = end_excess(dielectric(1.0), metallisation=0.5, length=4.0, along=20)
    finer = end_excess(dielectric(1.0), metallisation=0.5, length=4.0, along=40)
    longer = end_excess(dielectric(1.0), metallisation=0.5, length=8.0, along=40)
    assert finer == pytest.approx(short, rel=0.01)
    assert longer == pytest.approx(finer, rel=0.01)


@pytest.mark.slow
def test_a_stretched_plane_is_isotropic():
    found, plain = (end_excess(dielectric(each), metallisation=0.4, length=6.0) for each in (1.6, 1.0))
    assert found == pytest.approx(1.6 * plain, rel=0.01)
