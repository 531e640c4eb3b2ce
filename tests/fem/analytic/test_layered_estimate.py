"""Estimate of a transducer on layers: one solid in layers, the static field of films, and the whole solution."""

import numpy as np
import pytest

import fem
from fem.materials import VACUUM_PERMITTIVITY as EPS0

KOVACS = fem.rotated(fem.material("LiNbO3 (Kovacs)"), "128YX")
SILICA, SILICON = (fem.rotated(fem.material(name), "Z") for name in ("fused silica", "silicon (cubic)"))
F = 10e6
COMB = fem.Transducer(name="a", center=3e-3, finger_pairs=5, period=390e-6, metallisation=0.5, aperture=5e-3)


def half_space(solid, *layers, plane=0):
    stack = tuple(fem.Layer(solid=each, thickness=thickness) for each, thickness in layers)
    rest = {"length": 8e-3, "thickness": np.inf, "ends": "absorbing", "above": "vacuum"}
    return fem.Stator(solid=solid, layers=stack, plane=plane, **rest)


def test_layers_of_one_solid_have_its_estimate():
    bare = fem.layered_estimate(half_space(KOVACS), COMB, F)
    layered = fem.layered_estimate(half_space(KOVACS, (KOVACS, 30e-6)), COMB, F)
    assert layered.velocity == pytest.approx(bare.velocity, rel=1e-9)
    assert layered.capacitance == pytest.approx(bare.capacitance, rel=1e-9)
    assert layered.conductance(F) == pytest.approx(bare.conductance(F), rel=1e-7)
    assert layered.normal(F) == pytest.approx(bare.normal(F), rel=1e-7)


def test_the_permittivity_of_a_film_is_that_of_its_static_field():
    """SiO2 on silicon: phi = cosh(k z) + a sinh(k z) in the film, matched by hand."""
    k, h = 2e4, 40e-6
    film, below = 3.78, 11.7
    matrix = np.array([  # film: A exp(kz) + B exp(-kz), z = 0 on top, substrate C exp(k(z + h))
        [film * np.exp(-k * h), -film * np.exp(k * h), -below], [np.exp(-k * h), np.exp(k * h), -1.0], [1.0, 1.0, 0.0],
    ])  # fmt: skip
    a, b, _ = np.linalg.solve(matrix, [0.0, 0.0, 1.0])
    expected = EPS0 * (film * (a - b) + 1.0)
    assert fem.plane_permittivity(half_space(SILICON, (SILICA, h)), k) == pytest.approx(expected, rel=1e-9)
    inside = EPS0 * (below + film * (1.0 + film * np.tanh(k * h)) / (film + np.tanh(k * h)))
    assert fem.plane_permittivity(half_space(SILICON, (SILICA, h), plane=1), k) == pytest.approx(inside, rel=1e-9)


@pytest.mark.parametrize("plane", [0, 1])
def test_the_whole_solution_is_near(plane):
    stator = half_space(KOVACS, (SILICA, 20e-6), plane=plane)
    estimate = fem.layered_estimate(stator, COMB, F)
    frequency = estimate.velocity / COMB.period
    wave = fem.driven_wave(stator, (COMB,), frequency=frequency, drive="a", tolerance=3e-2, places=(6e-3,))
    assert abs(wave.motion(6e-3)[1]) == pytest.approx(float(estimate.normal(frequency)), rel=0.1)
    assert wave.admittance.real == pytest.approx(float(estimate.conductance(frequency)), rel=0.15)
