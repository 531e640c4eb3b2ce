"""A transducer with the reflections of its fingers.  Oracles: an ODE solver, the meshed grating, the driven stator."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.special import eval_legendre

import fem
from fem.analytic.coupled_modes import leaving, relative_amplitude, stop_band_edges
from fem.discretize.mesh_refinement import LEVELS
from fem.waveguide.grating import grating


@pytest.mark.parametrize(("detuning", "coupling"), [(3.0, -1.0), (-0.5, -1.0), (0.3, -2.0), (1e-9, -1e-9), (-2, -2)])
def test_the_equations_of_coupled_modes(detuning, coupling):
    system = np.zeros((3, 3), dtype=complex)
    system[:2] = 1j * np.array([[-detuning, coupling, 1.0], [-coupling, detuning, -1.0]])
    across = expm(system)
    left = -across[1, 2] / across[1, 1]  # S(0), from R(0) = S(L) = 0
    assert leaving(np.array([float(detuning)]), coupling)[0] == pytest.approx(abs(left), rel=1e-9)


@pytest.mark.parametrize("metallisation", [0.001, 0.1, 0.35, 0.5, 0.77, 0.999])
def test_the_edges_of_the_stop_band_by_legendre_functions(metallisation):
    cos = np.cos(np.pi * metallisation)
    even = (1 + cos) / 2 + eval_legendre(0.5, -cos) / eval_legendre(-0.5, -cos)  # Oracle: scipy's
    assert stop_band_edges(metallisation) == pytest.approx(((1 - cos) / 2, even), rel=5e-12)


@pytest.mark.parametrize("metallisation", [0.3, *(pytest.param(each, marks=pytest.mark.slow) for each in (0.5, 0.7))])
def test_the_stop_band_is_that_of_a_meshed_grating(metallisation):
    """The closed form is of first order in dv/v, 2.4 % here."""
    solid = fem.rotated(fem.material("LiNbO3 (Warner)"), "YZ")
    free, metallised = (fem.rayleigh(solid, each).velocity for each in ("open", "metallised"))
    cells = grating(solid, period=1e-3, metallisation=metallisation, above="none", resolution=LEVELS[0])
    band = cells.stop_band(open_fingers=False)
    found = [(free - edge * 1e-3) / (free - metallised) for edge in (band.upper, band.lower)]
    assert found == pytest.approx(stop_band_edges(metallisation), abs=0.04)


def test_the_frequency_and_the_height_of_the_largest_wave_are_those_of_the_driven_stator():
    solid = fem.rotated(fem.material("LiNbO3 (Warner)"), "YZ")
    stator = fem.Stator(solid=solid, length=20e-3, thickness=1e-3, bottom="absorbing", ends="absorbing", above="none")
    transducer = fem.Transducer(
        name="a", center=4.5e-3, finger_pairs=20, period=0.3445754e-3, metallisation=0.5, aperture=5e-3,
        termination="open", pattern=None, split=False,
    )  # fmt: skip
    frequencies = np.linspace(9.3e6, 10.7e6, 1401)
    estimate = relative_amplitude(solid, transducer, frequencies, surface="open")
    best = frequencies[np.argmax(estimate)]
    assert best == pytest.approx(9.81e6, rel=2e-3)

    def meshed(frequency):
        solution = fem.solve_driven(stator, (transducer,), frequency=frequency, drive="a", resolution=fem.LEVELS[0])
        return abs(fem.surface_of(solution).rayleigh_motion(13e-3)[1])

    peak, middle = (meshed(frequency) for frequency in (best, 10e6))
    sizes = np.interp([best, 10e6], frequencies, estimate)
    assert middle / peak == pytest.approx(sizes[1] / sizes[0], rel=0.06)
