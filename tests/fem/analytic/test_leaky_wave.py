"""Leaky waves: against the section's matched and selective layers, which share no formula, and published velocities."""

import numpy as np
import pytest

import fem
from fem.discretize.depth_mesh import discretise
from fem.waveguide.guided_modes import guided_modes

KOVACS = fem.material("LiNbO3 (Kovacs)")
ALN = fem.rotated(fem.material("AlN (Tsubouchi)"), "Z")
F = 10e6


@pytest.mark.parametrize(
    ("cut", "thickness", "level"), [("64YX", None, 4), ("128YX", 60e-6, 3)], ids=["bare 64YX", "AlN on 128YX"]
)
def test_velocity_and_attenuation_are_those_of_the_section_s_mode(cut, thickness, level):
    solid = fem.rotated(KOVACS, cut)
    layers = () if thickness is None else (fem.Layer(solid=ALN, thickness=thickness),)
    wave = fem.leaky_waves(solid, layers, frequency=F)[0]
    stator = fem.Stator(solid=solid, length=5e-3, thickness=np.inf, ends="absorbing", above="vacuum", layers=layers)
    resolution = fem.Resolution(order=7, edge_layers=0, absorber=level)
    unit = stator.slowest_wavelength(F)
    section = discretise(stator, resolution, wavelength=unit, surface_scale=np.inf)
    k = guided_modes(section, F).wavenumbers / unit
    ours = 2 * np.pi * F / wave.velocity * (1 - 1j * wave.attenuation)
    theirs = k[np.argmin(abs(k - ours))]
    assert ours.real == pytest.approx(theirs.real, rel=1e-7)
    assert ours.imag == pytest.approx(theirs.imag, abs=1e-7 * theirs.real)


@pytest.mark.parametrize(("surface", "velocity"), [("vacuum", 4742.0), ("metallised", 4474.0)])
def test_the_leaky_wave_of_64yx_has_the_published_velocity(surface, velocity):
    """Warner's constants; Yamanouchi and Takeuchi, IEEE Ultrasonics Symp. 1990: 4742 m/s, K2 11.3 %."""
    solid = fem.rotated(fem.material("LiNbO3 (Warner)"), "64YX")
    assert fem.leaky_waves(solid, surface=surface)[0].velocity == pytest.approx(velocity, abs=1.0)


def test_a_bound_wave_goes_on_as_a_leaky_one():
    """AlN on 128YX on either side of the thickness at which its velocity is the limit, 0.00566 wavelengths."""
    solid, rates = fem.rotated(KOVACS, "128YX"), []
    velocities = []
    for thickness in (0.00560, 0.00564, 0.00568, 0.00572):
        layer = [fem.Layer(solid=ALN, wavelengths=thickness)]
        if thickness < 0.00566:
            velocities.append(fem.layered_waves(solid, layer)[0].velocity)
            continue
        (wave,) = fem.leaky_waves(solid, layer)
        velocities.append(wave.velocity)
        rates.append(wave.attenuation)
    steps = np.diff(velocities)
    assert np.all(abs(steps - steps.mean()) < 0.4 * steps.mean())
    assert min(rates) > 0.0


def test_where_no_wave_leaks_little_it_is_said():
    with pytest.raises(fem.ConvergenceError, match=r"no leaky wave from 2425\.4 m/s"):
        fem.leaky_waves(fem.material("PZT-8"), [fem.Layer(solid=fem.material("silicon"), wavelengths=1.0)])
