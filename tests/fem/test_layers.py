"""Stators with layers: against the impedance recursion of analytic/layered.py, the direct solve, and one solid.

The recursion (free waves) and the sparse direct solve (fingers at any interface) share no mesh and no condensation with
the section.
"""

from dataclasses import replace

import numpy as np
import pytest

import fem
from fem.discretize.element_sizes import Resolution
from fem.results.power_balance import power_balance
from tests.fem.direct import direct_solution
from tests.fem.stators import FREQUENCY, lossless, solution, wave_of

KOVACS = lossless("LiNbO3 (Kovacs)", "128YX")
SILICA, SILICON, ALN, PZT = (
    lossless(name, "Z") for name in ("fused silica", "silicon (cubic)", "AlN (Tsubouchi)", "PZT-8")
)
GOLD, EPOXY = lossless("gold", "Z"), lossless("epoxy", "Z")
F = 10e6


def layer(solid, thickness, bond=None):
    return fem.Layer(solid=solid, thickness=thickness, bond=bond)


STACKS = {
    "SiO2 on 128YX": (KOVACS, [layer(SILICA, 20e-6)]),
    "LN on SiO2 on Si": (SILICON, [layer(SILICA, 70e-6), layer(KOVACS, 100e-6)]),
    "AlN on Si, thin": (SILICON, [layer(ALN, 1e-6)]),
    "PZT on Si": (SILICON, [layer(PZT, 60e-6)]),
    "thick PZT on silica": (SILICA, [layer(PZT, 220e-6)]),
    "PZT on gold on Si": (SILICON, [layer(GOLD, 2e-6), layer(PZT, 60e-6)]),
    "gold on 128YX": (KOVACS, [layer(GOLD, 3e-6)]),
    "YZ LN on Si": (SILICON, [layer(lossless("LiNbO3 (Kovacs)", "YZ"), 100e-6)]),
    "X-poled PZT on silica": (SILICA, [layer(lossless("PZT-8", "X"), 100e-6)]),
    "bonded LN on Si": (SILICON, [layer(KOVACS, 100e-6, fem.Bond(normal=1e15, tangential=3e14))]),
}


def half_space(substrate, layers, **rest) -> fem.Stator:
    whole = {"length": 3e-3, "thickness": np.inf, "ends": "absorbing", "above": "vacuum"} | rest
    return fem.Stator(solid=substrate, layers=tuple(layers), **whole)


@pytest.mark.parametrize("stack", STACKS)
@pytest.mark.parametrize("above", ["vacuum", "none"])
def test_free_wave_is_that_of_the_recursion(stack, above):
    """Velocity and surface ratio; the error stated is not exceeded."""
    stator = half_space(*STACKS[stack], above=above)
    expected = fem.bound_wave(stator, F)
    wave = fem.free_wave(stator, frequency=F, tolerance=1e-6)
    error = abs(wave.velocity / expected.velocity - 1)
    assert error < max(wave.relative_error, 3e-8)
    assert error < 1e-7
    assert wave.surface_ratio == pytest.approx(expected.surface_ratio, rel=2e-6)


def pair_of(stator, unit):
    left = fem.Transducer(name="a", center=0.9 * unit, period=unit, finger_pairs=1, metallisation=0.5, aperture=0.02)
    return left, replace(left, name="b", center=2.4 * unit, period=0.8 * unit, metallisation=0.4)


@pytest.mark.parametrize("plane", [0, 1, 2])
def test_structured_and_direct_solve_agree(plane):
    """Fingers on the surface and at either interface of a silica and a PZT film on a plate of 128YX."""
    unit = fem.slowest_wavelength(PZT, FREQUENCY)
    stator = fem.Stator(
        solid=KOVACS, length=3.2 * unit, thickness=0.3 * unit, ends="absorbing", plane=plane,
        layers=(layer(PZT, 0.07 * unit), layer(SILICA, 0.03 * unit)),
    )  # fmt: skip
    resolution = Resolution(order=5, edge_layers=1)
    pair = pair_of(stator, unit)
    ours = solution(stator, pair, order=5, layers=1)
    direct = direct_solution(
        stator, pair, frequency=FREQUENCY, resolution=resolution, wavelength=stator.slowest_wavelength(FREQUENCY),
        segment_size=0.25, segment_layers=1,
    )  # fmt: skip
    own = ours.fields.admittances
    assert np.abs(own - direct.admittances).max() < 1e-9 * np.abs(own).max()
    covered = np.array([each.center for each in pair])
    moved, reference = wave_of(ours).motion(covered), direct.surface(covered) @ ours.circuit.voltages
    assert abs(moved - reference).max() < 1e-7 * abs(reference).max()


def test_equal_layers_are_one_solid():
    """A film of the substrate's own solid; only the elements differ, by less than the error of the level."""
    one = fem.Transducer(name="a", center=0.6e-3, finger_pairs=1, period=0.39e-3, metallisation=0.5, aperture=5e-3)

    def answer(layers):
        drive = {"frequency": F, "drive": "a", "tolerance": 1e-3, "places": (2e-3,)}
        wave = fem.driven_wave(half_space(KOVACS, layers), (one,), **drive)
        return np.append(wave.motion(2e-3), wave.admittance)

    assert answer([layer(KOVACS, 7e-6)]) == pytest.approx(answer([]), rel=1e-5)


def test_a_slow_film_on_a_fast_substrate_has_the_error_stated():
    """Diamond, whose wavelength is 4.3 times that of ZnO; the film has little wave and much static field."""
    stator = half_space(lossless("diamond", "Z"), [layer(lossless("ZnO (Bateman)", "Z"), 60e-6)])
    one = fem.Transducer(name="a", center=1e-3, finger_pairs=1, period=0.833e-3, metallisation=0.5, aperture=5e-3)
    x = np.array([2.2e-3])
    answers = [
        wave_of(solution(stator, (one,), frequency=F, order=order, layers=edges, absorber=level)).motion(x)
        for order, edges, level in ((7, 2, 2), (8, 3, 3))
    ]
    assert abs(answers[0] - answers[1]).max() < 8e-5 * abs(answers[1]).max()


def test_substrate_and_absorber_are_as_deep_as_without_a_film():
    from fem.discretize.depth_mesh import discretise

    diamond, zno = lossless("diamond", "Z"), lossless("ZnO (Bateman)", "Z")
    depths = []
    for layers in ([], [layer(zno, 60e-6)]):
        stator = half_space(diamond, layers)
        resolution = Resolution(order=5, edge_layers=0)
        unit = stator.slowest_wavelength(F)
        section = discretise(stator, resolution, wavelength=unit, surface_scale=np.inf)
        ends = section.breakpoints * unit
        static = 0.5 * fem.slowest_wavelength(diamond, F) if layers else 0.0  # one more element, see absorber.py
        depths.append([ends[section.bottom // 5] + stator.coating, ends[0] + stator.coating + static])
    assert depths[1] == pytest.approx(depths[0], rel=1e-12)


def test_matrices_of_equal_layers_are_those_of_one_solid():
    """On the same elements, to rounding."""
    from fem.discretize.depth_mesh import discretise

    unit = fem.slowest_wavelength(KOVACS, F)
    stator = half_space(KOVACS, [layer(KOVACS, 0.03 * unit), layer(KOVACS, 0.05 * unit)])
    section = discretise(stator, Resolution(order=5, edge_layers=1), wavelength=unit, surface_scale=0.1 * unit)
    inside = slice(section.bottom // section.order, section.surface // section.order)
    media = list(section.media)
    media[inside] = [media[inside][0]] * len(media[inside])
    one = replace(section, media=tuple(media))
    assert len({id(each) for each in section.media[inside]}) == 3
    for layered, single in zip(section.matrices(F), one.matrices(F), strict=True):
        assert abs(layered - single).max() < 1e-12 * abs(single).max()


@pytest.mark.parametrize("stack", ["SiO2 on 128YX", "PZT on gold on Si", "bonded LN on Si"])
def test_power_is_balanced_and_transfer_reciprocal(stack):
    substrate, layers = STACKS[stack]
    lossy = [replace(each, solid=replace(each.solid, mechanical_quality=400.0)) for each in layers]
    plane = 1 if stack == "SiO2 on 128YX" else 0
    stator = half_space(substrate, lossy, plane=plane)
    one = fem.Transducer(name="a", center=0.7e-3, finger_pairs=1, period=0.37e-3, metallisation=0.5, aperture=5e-3)
    pair = one, replace(one, name="b", center=1.9e-3, metallisation=0.4)
    ours = solution(stator, pair, frequency=F, order=5, layers=1)
    balance = power_balance(ours)
    assert abs(balance.residual) < 1e-11
    assert balance.solid > 1e-3 * balance.input
    admittances = ours.fields.admittances
    assert abs(admittances[0, 1] - admittances[1, 0]) < 1e-10 * abs(admittances[0, 1])


@pytest.mark.parametrize(("film", "floats"), [(PZT, True), (GOLD, False)])
def test_the_potential_floats_unless_a_metal_holds_it(film, floats):
    """Also above a bond, whose element has nodes without a potential."""
    from fem.discretize.depth_mesh import discretise

    layers = (layer(film, 1e-4, fem.Bond(normal=1e15, tangential=1e15)), layer(PZT, 1e-4))
    stator = fem.Stator(solid=SILICA, length=1e-3, thickness=3e-4, ends="absorbing", layers=layers)
    unit = stator.slowest_wavelength(F)
    section = discretise(stator, Resolution(order=5, edge_layers=1), wavelength=unit, surface_scale=0.1 * unit)
    assert section.floating_potential is floats


def test_energy_of_a_free_wave_in_layers():
    """Power through the depth is the energy times the group velocity: two routes to one number, bond and film too."""
    substrate, layers = STACKS["bonded LN on Si"]
    stator = half_space(substrate, layers)
    powers, energies, slow = [], [], []
    for frequency in (F, F * (1 + 1e-3), F * (1 - 1e-3)):
        wave = fem.free_wave(stator, frequency=frequency, tolerance=1e-6)
        field = fem.free_field(wave, span=(0.0, 4e-4), energies=True)
        densities, ends = field.densities, wave.depth[:: wave.order]
        weights = np.zeros(len(wave.depth))
        lumped = fem.reference_matrices(wave.order).mass.sum(axis=1)
        for element, height in enumerate(np.diff(ends)):
            weights[element * wave.order : (element + 1) * wave.order + 1] += height * lumped
        inside = np.array([solid is not None for solid in wave.solids])
        assert inside.sum() == len(inside) - 1
        densest = np.interp(wave.depth, [-1e-4 - 1e-9, -1e-4], [substrate.density, KOVACS.density])
        kinetic = 0.25 * densest * (2 * np.pi * frequency) ** 2 * np.sum(abs(wave.profile[:, :3]) ** 2, axis=1)
        powers.append(weights @ densities.power_flow[0, :, 0])
        energies.append(weights @ kinetic * 2)  # as much potential energy as kinetic energy
        slow.append(2 * np.pi * frequency / wave.velocity)
    group = 2 * np.pi * 2e-3 * F / (slow[1] - slow[2])
    assert powers[0] / energies[0] == pytest.approx(group, rel=3e-3)


def test_what_a_stator_with_layers_cannot_be():
    film = layer(SILICA, 1e-6)
    with pytest.raises(fem.InputError, match=r'transducer\.plane must be "surface" or the number of layers .* 1 to 1'):
        half_space(KOVACS, [film], plane=2)
    with pytest.raises(fem.InputError, match=r'transducer\.plane must be "surface" or absent without layers'):
        half_space(KOVACS, [], plane=1)
    with pytest.raises(fem.InputError, match=r"layer\.0\.thickness must be a length in m"):
        half_space(KOVACS, [fem.Layer(solid=SILICA, wavelengths=0.1)])
    stator = half_space(SILICON, [layer(PZT, 6e-5), layer(GOLD, 1e-6)])
    one = fem.Transducer(name="a", center=1e-3, finger_pairs=1, period=0.3e-3, metallisation=0.5, aperture=5e-3)
    with pytest.raises(fem.InputError, match=r"must not touch a metal layer.*gold"):
        fem.driven_wave(stator, (one,), frequency=F, drive="a", tolerance=1e-2)
    with pytest.raises(fem.InputError, match=r"must not touch a metal layer.*gold"):
        fem.driven_wave(replace(stator, plane=1), (one,), frequency=F, drive="a", tolerance=1e-2)


@pytest.mark.parametrize("plane", [0, 1])
def test_a_film_adds_few_unknowns(plane):
    """The CPU time of a driven wave grows as their third power: at most 1.5 times that of the bare half-space."""
    from fem.discretize.depth_mesh import discretise

    sizes = []
    for layers in ([], [layer(SILICA, 20e-6)]):
        stator = half_space(KOVACS, layers, plane=plane if layers else 0)
        resolution = Resolution(order=7, edge_layers=2)
        unit = stator.slowest_wavelength(F)
        sizes.append(discretise(stator, resolution, wavelength=unit, surface_scale=0.12 * unit).size)
    assert sizes[1] < 1.5 ** (1 / 3) * sizes[0]


def test_a_thick_film_is_its_own_half_space():
    """ZnO of 10 wavelengths on silica; 200 wavelengths would take hours, and are refused with what to do instead."""
    zno = lossless("ZnO (Bateman)", "Z")
    half = fem.rayleigh(zno)
    wavelength = half.velocity / F
    wave = fem.free_wave(half_space(SILICA, [layer(zno, 10 * wavelength)]), frequency=F, tolerance=1e-6)
    assert wave.velocity == pytest.approx(half.velocity, rel=max(2e-8, wave.relative_error))
    assert wave.surface_ratio == pytest.approx(half.surface_ratio, rel=1e-6)
    with pytest.raises(fem.ConvergenceError, match="make the thick one the material of the stator"):
        fem.free_wave(half_space(SILICA, [layer(zno, 200 * wavelength)]), frequency=F, tolerance=1e-6)


@pytest.mark.parametrize("thickness", [1e-6, 1e-4])
def test_a_thin_film_shifts_the_velocity_of_the_section(thickness):
    """AlN on silicon, one element however thin; rounding in it moves v by 1e-14 over the thickness in wavelengths."""
    wavelength = fem.rayleigh(SILICON).velocity / F
    bare, thin = half_space(SILICON, []), half_space(SILICON, [layer(ALN, thickness * wavelength)])
    expected = fem.bound_wave(thin, F).velocity / fem.bound_wave(bare, F).velocity - 1.0
    velocities = [fem.free_wave(each, frequency=F, tolerance=1e-6).velocity for each in (thin, bare)]
    assert velocities[0] / velocities[1] - 1.0 == pytest.approx(expected, abs=2e-8)
