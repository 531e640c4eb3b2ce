"""Waves of layers on a half-space against two independent programs, one solid in layers, and first-order perturbation.

The constants of the films define the test, not the materials (quoted from memory by the authors of the numbers).
"""

import numpy as np
import pytest

import fem
from fem.analytic.layered_wave import layered_waves, principal_wave, shorted_velocity
from fem.geometry import Bond, Layer
from fem.materials import VACUUM_PERMITTIVITY, Solid


def film(name, c11, c12, c13, c33, c44, *, rho, c66=None, e=(0.0, 0.0, 0.0), eps=(1.0, 1.0)):
    """A solid of class 6mm, or cubic with its own c66; GPa, C/m2 (e15, e31, e33), relative permittivity."""
    c = np.zeros((6, 6))
    c[:2, :2], c[:2, 2], c[2, :2] = c12, c13, c13
    np.fill_diagonal(c, (c11, c11, c33, c44, c44, 0.5 * (c11 - c12) if c66 is None else c66))
    coupling = np.zeros((3, 6))
    coupling[0, 4] = coupling[1, 3] = e[0]
    coupling[2, :2], coupling[2, 2] = e[1], e[2]
    return Solid(
        name=name, source="layers", stiffness=1e9 * c, coupling=coupling, density=rho,
        permittivity=VACUUM_PERMITTIVITY * np.diag([eps[0], eps[0], eps[1]]),
    )  # fmt: skip


AlN = film("AlN", 345, 125, 120, 395, 118, rho=3260, e=(-0.48, -0.58, 1.55), eps=(9.04, 10.73))
ZnO = film("ZnO", 209.7, 121.1, 105.1, 210.9, 42.47, rho=5680, e=(-0.48, -0.573, 1.32), eps=(8.55, 10.2))
SiO2 = film("SiO2", 78.5, 16.1, 16.1, 78.5, 31.2, rho=2203, eps=(3.78, 3.78))
Si = film("Si", 165.7, 63.9, 63.9, 165.7, 79.56, rho=2331, c66=79.56, eps=(11.7, 11.7))
diamond = film("diamond", 1079, 124, 124, 1079, 578, rho=3515, c66=578, eps=(5.67, 5.67))
gold = film("Au", 207, 150, 150, 207, 28.5, rho=19300)
LN128 = fem.rotated(fem.material("LiNbO3 (Kovacs)"), "128YX")
PZT8 = fem.rotated(fem.material("PZT-8"), "Z")


@pytest.mark.parametrize(
    ("layer", "substrate", "thickness", "free", "top", "interface", "ratio"),
    [
        (AlN, Si, 0.05, 5020.9091982, 5018.2799716, 5020.9090395, 0.5623512),
        (ZnO, SiO2, 0.05, 3216.1331415, 3213.4728325, 3216.1285284, 0.5115021),
        (ZnO, SiO2, 0.2, 2786.1001589, 2773.5044437, 2772.8866581, 0.5175810),
        (SiO2, LN128, 0.02, 3977.7044651, 3937.6891511, 3860.5297638, 0.9574686),
        (SiO2, LN128, 0.05, 3985.1587875, 3964.8669604, 3855.6808216, 1.0212900),
        (PZT8, Si, 0.05, 4043.4437288, 4041.3949703, 4042.3812149, 0.8747635),
        (PZT8, Si, 0.2, 3013.5458307, 2999.9018547, 3007.9173980, 0.6684665),
        (AlN, diamond, 0.2, 8877.9353431, 8872.5362429, 8872.9962727, 1.0567369),
        (gold, SiO2, 0.05, 2208.0099834, 2208.0099834, 2208.0099834, 0.7345707),
        (gold, SiO2, 0.2, 1513.1283786, 1513.1283786, 1513.1283786, 0.5079013),
    ],
)
def test_films_on_substrates(layer, substrate, thickness, free, top, interface, ratio):
    wave = principal_wave(layered_waves(substrate, [Layer(solid=layer, wavelengths=thickness)]))
    assert wave.velocity == pytest.approx(free, rel=1e-9)
    assert wave.surface_ratio == pytest.approx(ratio, rel=1e-6)
    assert shorted_velocity(wave, 0) == pytest.approx(top, rel=1e-9)
    assert shorted_velocity(wave, 1) == pytest.approx(interface, rel=1e-9)


@pytest.mark.parametrize(
    ("thickness", "velocity"),
    [
        (1.0, 2681.6922590), (3.0, 2681.1421608), (5.0, 2681.1416573786), (10.0, 2681.141657361),
        (20.0, 2681.141657361), (200.0, 2681.141657361),
    ],
)  # fmt: skip
def test_a_thick_film_is_a_half_space(thickness, velocity):
    wave = layered_waves(SiO2, [Layer(solid=ZnO, wavelengths=thickness)], number=1)[0]
    assert wave.velocity == pytest.approx(velocity, rel=5e-11)
    if thickness >= 10.0:
        assert wave.velocity == pytest.approx(fem.rayleigh(ZnO).velocity, rel=1e-12)


def test_a_thin_film_shifts_the_velocity_by_its_thickness():
    bare = fem.rayleigh(Si).velocity
    for thickness, slope in ((1e-6, 1.57659), (1e-4, 1.57240)):
        wave = principal_wave(layered_waves(Si, [Layer(solid=AlN, wavelengths=thickness)]))
        assert (wave.velocity / bare - 1.0) / thickness == pytest.approx(slope, rel=1e-5)


@pytest.mark.parametrize("surface", ["vacuum", "open", "metallised"])
@pytest.mark.parametrize("solid", [LN128, PZT8])
def test_layers_of_one_solid_are_its_half_space(solid, surface):
    bare = fem.rayleigh(solid, surface)
    wave = principal_wave(
        layered_waves(solid, [Layer(solid=solid, wavelengths=w) for w in (0.7, 0.3)], surface=surface)
    )
    assert wave.velocity == pytest.approx(bare.velocity, rel=1e-12)
    depth = [0.0, 0.1, 0.3, 0.5, 1.0, 1.5]
    for found, expected in zip(wave.profile(depth), bare.profile(depth), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-11 * abs(expected).max())


def test_all_waves_are_found_and_named():
    """PZT-8 on Si, half a wavelength; the Rayleigh wave of the film's own surface is the slowest."""
    waves = layered_waves(Si, [Layer(solid=PZT8, wavelengths=0.5)])
    assert [each.name for each in waves][:3] == ["Rayleigh", "Sezawa", "sagittal 3"]
    assert waves[0].velocity == pytest.approx(2312, rel=3e-4)
    coating = layered_waves(LN128, [Layer(solid=SiO2, wavelengths=0.05)])
    assert [each.name for each in coating] == ["Rayleigh", "Love"]


def test_no_wave_of_a_thick_slow_layer_is_missed():
    """Three wavelengths of gold: the second wave is the layer's first shear resonance, k h sqrt(v^2/c_s^2 - 1) = pi."""
    gold = fem.material("gold")
    waves = layered_waves(Si, [Layer(solid=gold, wavelengths=3.0)])
    shear = np.sqrt(gold.stiffness[3, 3] / gold.density)
    assert waves[1].velocity == pytest.approx(shear * np.sqrt(1.0 + 1.0 / 6.0**2), rel=0.01)  # 1505 m/s was given


@pytest.mark.parametrize(
    ("substrate", "layer", "thickness", "frequency"),
    [
        (LN128, "gold", 1e-7, 1e7),
        (LN128, "aluminium", 1e-7, 1e8),
        (Si, "epoxy", 1e-5, 1e8),
        (PZT8, "fused silica", 5e-6, 1e7),
    ],
)
def test_waves_at_a_frequency_are_those_at_their_wavelengths(substrate, layer, thickness, frequency):
    """At a frequency the impedance may rise with v, at a wavenumber it falls; 100 nm of gold never ended."""
    solid = fem.material(layer)
    waves = layered_waves(substrate, [Layer(solid=solid, thickness=thickness)], frequency=frequency)
    for number, wave in enumerate(waves):
        same = layered_waves(substrate, [Layer(solid=solid, wavelengths=thickness * frequency / wave.velocity)])
        assert same[number].velocity == pytest.approx(wave.velocity, rel=1e-9)


def test_a_love_wave_is_its_closed_form():
    """tan(k h b) = mu_s q/(mu b) with b^2 = v^2/c^2 - 1 and q^2 = 1 - v^2/c_s^2; found where u_y is coupled at all."""
    thickness, turned = 0.4, fem.rotated(fem.material("LiNbO3 (Kovacs)"), "128YX")
    waves = layered_waves(Si, [Layer(solid=SiO2, wavelengths=thickness), Layer(solid=turned, wavelengths=1e-7)])
    (love,) = [each for each in waves if each.name == "Love"]
    b = np.sqrt(love.velocity**2 * 2203 / 31.2e9 - 1.0)
    q = np.sqrt(1.0 - love.velocity**2 * 2331 / 79.56e9)
    assert np.tan(2 * np.pi * thickness * b) == pytest.approx(79.56 * q / (31.2 * b), rel=1e-4)


def test_fields_and_tractions_are_continuous_through_interfaces():
    layers = [
        Layer(solid=SiO2, wavelengths=0.1),
        Layer(solid=LN128, wavelengths=0.3),
        Layer(solid=AlN, wavelengths=0.02),
    ]
    wave = principal_wave(layered_waves(Si, layers))
    for depth in (0.02, 0.32, 0.42):
        for part in wave.profile([depth - 1e-9, depth + 1e-9]):
            above, below = part
            np.testing.assert_allclose(above, below, atol=1e-7 * abs(part).max())


def test_a_thickness_in_metres_needs_a_frequency_and_gives_the_same():
    relative = principal_wave(layered_waves(Si, [Layer(solid=AlN, wavelengths=0.05)]))
    frequency = 100e6
    wavelength = relative.velocity / frequency
    absolute = principal_wave(layered_waves(Si, [Layer(solid=AlN, thickness=0.05 * wavelength)], frequency=frequency))
    assert absolute.velocity == pytest.approx(relative.velocity, rel=1e-12)
    assert absolute.thickness == pytest.approx(0.05, rel=1e-12)
    with pytest.raises(fem.InputError, match="frequency is missing"):
        layered_waves(Si, [Layer(solid=AlN, thickness=1e-6)])


def test_a_bond_lies_between_a_perfect_joint_and_a_free_film():
    """A stiff bond is none; a soft one slows the wave; its compliance adds like a thin layer of the same stiffness."""

    def velocity(bond):
        layer = Layer(solid=LN128, wavelengths=0.3, bond=bond)
        return principal_wave(layered_waves(Si, [layer], frequency=10e6)).velocity

    perfect = velocity(None)
    assert velocity(Bond(normal=1e30, tangential=1e30)) == pytest.approx(perfect, rel=1e-12)
    soft = Bond(normal=1e14, tangential=3e13)
    assert velocity(soft) < perfect
    # a layer that is much thinner than the wavelength and soft: stiffness per area c33/h and c44/h
    h = 1e-9
    glue = film("glue", 1.5, 0.9, 0.9, 1.5, 0.3, rho=1.0)
    layers = [Layer(solid=glue, thickness=h), Layer(solid=LN128, wavelengths=0.3)]
    thin = principal_wave(layered_waves(Si, layers, frequency=10e6)).velocity
    assert velocity(Bond(normal=1.5e9 / h, tangential=0.3e9 / h)) - perfect == pytest.approx(thin - perfect, rel=2e-2)


def test_a_coating_that_is_too_fast_leaks():
    with pytest.raises(fem.ConvergenceError, match=r"AlN on LiNbO3 .* 4030.8 m/s: it leaks"):
        layered_waves(LN128, [Layer(solid=AlN, thickness=2.4e-6)], frequency=9.6e6)


@pytest.mark.parametrize(
    ("options", "words"),
    [({"shorted": 2}, "shorted must be the number of layers above"), ({"surface": "wet"}, "surface must be one of")],
)
def test_conditions_that_do_not_exist_are_refused(options, words):
    with pytest.raises(fem.InputError, match=words):
        layered_waves(Si, [Layer(solid=AlN, wavelengths=0.1)], **options)


@pytest.mark.parametrize(
    ("numbers", "words"), [({}, "either"), ({"thickness": -1.0}, "layer.thickness must be positive")]
)
def test_layers_that_cannot_be_are_refused(numbers, words):
    with pytest.raises(fem.InputError, match=words):
        Layer(solid=AlN, **numbers)


@pytest.mark.parametrize(
    ("film", "substrate", "slope"),
    [(AlN, LN128, 2.393), (SiO2, LN128, -0.0465), (gold, LN128, -7.401), (AlN, PZT8, 3.558)],
)
def test_first_order_shift_by_a_film(film, substrate, slope):
    """layered.md, section 4, whose formula leaves out u_y."""
    stator = fem.Stator(solid=substrate, length=0.01, thickness=np.inf, ends="absorbing", above="vacuum")
    wavelength = fem.rayleigh(substrate).velocity / 10e6
    assert fem.film_shift(stator, film, 1e-4 * wavelength, 10e6) / 1e-4 == pytest.approx(slope, rel=6e-3)


def test_first_order_shift_by_a_film_at_an_interface():
    """Gold between SiO2 and silicon, against the recursion; the tractions there, which it leaves out, make 7 %."""
    metal = fem.Layer(solid=gold, thickness=1e-9)
    top = fem.Layer(solid=SiO2, thickness=20e-6)
    free = principal_wave(layered_waves(Si, [top], frequency=10e6)).velocity
    moved = principal_wave(layered_waves(Si, [metal, top], frequency=10e6)).velocity
    rest = {"length": 0.01, "thickness": np.inf, "ends": "absorbing", "above": "vacuum"}
    stator = fem.Stator(solid=Si, layers=(top,), plane=1, **rest)
    assert fem.film_shift(stator, metal.solid, 1e-9, 10e6) == pytest.approx(moved / free - 1.0, rel=0.1)
