"""The oracle of a finite beam against closed forms."""

import numpy as np

from tests.oracles.fem_plate_beam import plate_beam


def test_membrane_from_a_line_of_charge():
    """Response 1 / (k^2 - k_0^2): from a point, i.e. a short strip, a Hankel function; from a long one a plane wave."""
    from scipy.special import hankel2

    k = 2000.0 * (1 - 0.02j)

    def response(wavenumbers):
        scalar = 1.0 / (wavenumbers**2 - k**2)
        return np.stack([wavenumbers * scalar, scalar], axis=1)

    point = np.array([[0.02, 0.004]])
    short = 1e-5
    found = plate_beam(response, 2000.0, np.zeros(1), np.ones(1), short, point)[:, 0] / short
    distance = float(np.hypot(*point[0]))
    scalar = -0.25j * hankel2(0, k * distance)
    slope = -0.25j * -k * hankel2(1, k * distance) * 1j  # u = i grad of the scalar, as k_x stands for i d/dx
    expected = np.array([slope * 0.02 / distance, slope * 0.004 / distance, scalar])
    np.testing.assert_allclose(found, expected, rtol=1e-5)
    wide = plate_beam(response, 2000.0, np.zeros(1), np.ones(1), 0.16, np.array([[0.02, 0.0]]))[:, 0]
    plane = -0.5j / k * np.exp(-1j * k * 0.02)
    np.testing.assert_allclose(wide, [k * plane, 0.0, plane], atol=3e-3 * abs(k * plane))
