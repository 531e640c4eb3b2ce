"""Static modes of a plate under vacuum, as slow as the vacuum is high, against their equation in closed form."""

import numpy as np
import pytest
from scipy.optimize import brentq

from fem.discretize.depth_mesh import discretise
from fem.discretize.mesh_refinement import LEVELS
from fem.discretize.vacuum import GROWTH, LAST_ALONG, plate_reach
from fem.waveguide.guided_modes import guided_modes
from tests.fem.stators import FREQUENCY, lossless, plate


@pytest.mark.parametrize("level", [2, 4])
@pytest.mark.parametrize(
    "solid",
    [lossless("PZT-5H", "Z"), lossless("LiNbO3 (Kovacs)", "128YX"), lossless("LiNbO3 (Kovacs)", (10.0, 25.0, 40.0))],
    ids=["ceramic", "mirror", "no mirror"],
)
def test_slowest_modes(solid, level):
    """D k^2 + k Y = 0 with k = -i kappa: D kappa + T(kappa) = 0, T the tangents of both parts of the vacuum.

    One eigensolve alone errs by 1.1e-6 on the ceramic at level 4, beyond the tolerance here.
    """
    stator = plate(solid, thickness=0.2, length=400.0, above="vacuum")
    depth = discretise(stator, LEVELS[level], wavelength=stator.length / 400, surface_scale=np.inf)
    modes = guided_modes(depth, FREQUENCY)
    height, reach = depth.breakpoints[-1], plate_reach(stator, depth.solid, depth.length_unit, stator.thickness)
    index = np.sqrt(LAST_ALONG)

    def equation(x):  # x = kappa times the height; free of poles
        below, last = x / GROWTH, x * (1 - 1 / GROWTH) * index
        top = np.sin(below) * np.cos(last) + index * np.cos(below) * np.sin(last)
        bottom = np.cos(below) * np.cos(last) - index * np.sin(below) * np.sin(last)
        return reach * x / height * bottom + top

    places = np.linspace(1e-3, 10.0, 1000)
    values = equation(places)
    roots = [brentq(equation, *places[i : i + 2], xtol=1e-14) for i in np.flatnonzero(values[1:] * values[:-1] < 0)]
    expected = np.array(roots[:2]) / height
    for wavenumbers, sign in ((modes.wavenumbers, -1), (modes.backwards, 1)):
        slowest = wavenumbers[np.argsort(abs(wavenumbers))][1:3]
        assert slowest.imag == pytest.approx(sign * expected, rel=1e-6)
        assert abs(slowest.real).max() < 1e-6 * expected[0]
