"""The free wave of a section against the half-space and against its own loss."""

import numpy as np
import pytest

from fem.analytic.half_space import rayleigh
from fem.materials import isotropic
from fem.solve.guided import free_wave
from tests.fem.stators import FREQUENCY, cut, lossless, plate


@pytest.mark.parametrize(
    ("name", "orientation"),
    [
        ("PZT-8", "Z"),
        ("PZT-5H", "X"),
        pytest.param("LiNbO3 (Warner)", "YZ", marks=pytest.mark.slow),
        pytest.param("LiNbO3 (Kovacs)", "128YX", marks=pytest.mark.slow),
        pytest.param("quartz (Bechmann)", "ST-X", marks=pytest.mark.slow),
        ("steel", "Z"),
    ],
)
def test_thick_section_has_the_half_spaces_wave(name, orientation):
    """Velocity and ellipse of the half-space under D_n = 0; nothing comes back from below, nothing is lost."""
    solid = lossless(name, orientation)
    expected = rayleigh(solid, "open")
    stator = plate(solid, thickness=2.0, bottom="absorbing")
    wave = free_wave(stator, frequency=FREQUENCY, tolerance=1e-8)
    assert wave.velocity == pytest.approx(expected.velocity, rel=5e-8)
    assert wave.surface_ratio == pytest.approx(expected.surface_ratio, rel=1e-5)
    assert wave.relative_error <= 1e-8
    assert abs(wave.attenuation) < 1e-7 * 2 * np.pi * FREQUENCY / wave.velocity
    assert wave.depth[-1] == 0
    assert wave.profile[-1, 2] == pytest.approx(1, rel=1e-14)


def test_two_faces_split_the_wave():
    """Symmetric and antisymmetric: their mean is off by the square of a splitting that halves and halves again."""
    solid = lossless("PZT-8", "Z")
    expected = rayleigh(solid, "open").velocity
    off = [
        abs(free_wave(plate(solid, thickness=thick), frequency=FREQUENCY, tolerance=1e-10).velocity / expected - 1)
        for thick in (2.5, 3.0, 3.5)
    ]
    assert off[2] < off[1] / 2 < off[0] / 4
    assert off[2] < 1e-4


@pytest.mark.parametrize(("name", "orientation"), [("PZT-4", "Z"), ("LiNbO3 (Kovacs)", "128YX")])
def test_the_wave_of_unlike_faces_is_that_of_the_upper_one(name, orientation):
    """Vacuum above alone: the lower face's wave is 1e-5 (PZT-4) and 2.5e-4 (128YX) faster."""
    solid = lossless(name, orientation)
    stator = plate(solid, thickness=8.0, above="vacuum")
    wave = free_wave(stator, frequency=FREQUENCY, tolerance=1e-6)
    assert wave.velocity == pytest.approx(rayleigh(solid, "vacuum").velocity, rel=5e-7)


@pytest.mark.slow
def test_profile_decays_like_the_half_spaces():
    """Down to 1.5 wavelengths over an absorbing bottom; phi in volt per metre of u_z."""
    solid = lossless("LiNbO3 (Kovacs)", "128YX")
    wave = free_wave(plate(solid, thickness=4.0, bottom="absorbing"), frequency=FREQUENCY, tolerance=1e-9)
    half_space = rayleigh(solid, "open")
    near = wave.depth > -1.5 * half_space.velocity / FREQUENCY
    depth = -wave.depth[near] * FREQUENCY / half_space.velocity
    displacement, potential = half_space.profile(depth)
    assert np.abs(wave.profile[near, :3] - displacement).max() < 1e-5
    assert np.abs(wave.profile[near, 3] - potential).max() < 1e-5 * np.abs(potential).max()


def test_attenuation_is_the_losses():
    """An isotropic solid with one Q for all moduli: k (1 - i/2Q) to first order."""
    solid = isotropic(name="glass", youngs_modulus=7.31e10, poisson_ratio=0.2, density=2203.0, mechanical_quality=400.0)
    wave = free_wave(plate(solid, thickness=4.0), frequency=FREQUENCY, tolerance=1e-8)
    k = 2 * np.pi * FREQUENCY / wave.velocity
    assert wave.attenuation == pytest.approx(k / 800.0, rel=1e-4)


@pytest.mark.parametrize("thickness", [4.5, 5.0, 5.27, 8.0])
def test_the_profile_is_that_of_the_upper_face(thickness):
    """Both faces free, several wavelengths: the twin modes are one to rounding and come out mixed in any way."""
    solid = cut("PZT-8", "Z")
    wave = free_wave(plate(solid, thickness=thickness), frequency=FREQUENCY, tolerance=1e-3)
    lower = wave.depth < -2.5 * wave.velocity / FREQUENCY
    assert abs(wave.profile[lower, :3]).max() < 1e-3
    half_space = rayleigh(solid, "open")
    displacement, _ = half_space.profile(-wave.depth[~lower] * FREQUENCY / half_space.velocity)
    assert abs(wave.profile[~lower, :3] - displacement).max() < 2e-2
