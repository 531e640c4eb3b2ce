"""The Rayleigh wave at a corner of 90 degrees and at a step: pieces of the stator as meshes against what is known.

A quarter space has no length, so that what its corner sends back and passes on depends on Poisson's ratio alone, also
where both moduli have the same loss; a lossy plate of a few wavelengths stands for it, since nothing comes back from
its bottom.  Truth: |R| and |T| of an independent program (reciprocity of the lossless corner, to 2e-5).  The literature
plots them against Poisson's ratio (Gautesen, J. Appl. Mech. 52 (1985) 664) and measures that about half of the power
stays in surface waves at 0.17 (de Bremaecker, Geophysics 23 (1958) 253; |R|^2 + |T|^2 = 0.54 here).
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.polynomial import legendre

from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.geometry import Stator
from fem.materials import isotropic
from fem.mesh.mesh_piece import MeshPiece
from fem.mesh.section_mesh import read_mesh
from fem.solve.p_matrix_from_field import waves_of
from fem.solve.piece_scattering import reflector
from fem.waveguide.guided_modes import guided_modes
from fem.waveguide.stator_meshes import condensed_pieces
from tests.fem.drawings import rectangle
from tests.oracles.fem_isotropic_rayleigh import profile, velocity_over_shear

REFLECTED_AND_PASSED = {
    0.0: (0.24001, 0.66509),
    0.17: (0.26810, 0.68436),
    0.25: (0.32135, 0.68375),
    1 / 3: (0.39592, 0.67397),
    0.4: (0.46618, 0.65920),
}
SOME_SLOW = [pytest.param(nu, marks=[pytest.mark.slow] * (nu != 0.25)) for nu in REFLECTED_AND_PASSED]
QUALITY = 2.5  # the wave loses a factor of 3 in a wavelength
FREQUENCY = 1e6


def quarter_space(tmp_path, poisson_ratio, *, width, depth, quality=QUALITY):
    """Stator that ends in a meshed corner, and the complex wavenumber of the Rayleigh wave; sizes in wavelengths."""
    solid = isotropic(
        name="s", youngs_modulus=70e9, poisson_ratio=poisson_ratio, density=2700.0, mechanical_quality=quality
    )
    speed = velocity_over_shear(poisson_ratio) * np.sqrt(solid.stiffness[3, 3] / solid.density)
    wavelength = speed / FREQUENCY
    path = rectangle(tmp_path / "corner.msh", width, depth, size=0.5, groups=("left", "bottom"))
    piece = MeshPiece(name="corner", mesh=read_mesh(path, wavelength), position=wavelength)
    stator = Stator(
        solid=solid, length=(1 + width) * wavelength, thickness=depth * wavelength, ends="free", pieces=(piece,)
    )
    return stator, 2 * np.pi / wavelength / np.sqrt(1 + 1j / quality)


@pytest.mark.parametrize("poisson_ratio", SOME_SLOW)
def test_the_corner_reflects_the_rayleigh_wave(tmp_path, poisson_ratio):
    stator, wavenumber = quarter_space(tmp_path, poisson_ratio, width=1.5, depth=7.0)
    found = reflector(stator, frequency=FREQUENCY, tolerance=1e-4)
    ((_, reflection),) = found.ends
    way = stator.pieces[0].extent[1] - stator.pieces[0].extent[0]
    at_corner = reflection * np.exp(2j * wavenumber * way)
    assert abs(at_corner) == pytest.approx(REFLECTED_AND_PASSED[poisson_ratio][0], abs=2e-5)


@pytest.mark.parametrize("poisson_ratio", REFLECTED_AND_PASSED)
def test_the_corner_of_a_lossless_half_space(tmp_path, poisson_ratio):
    """The wall goes on down through the absorbing layer, which takes up the wave on it: 1e-6 to 7e-6 from the truth."""
    stator, _ = quarter_space(tmp_path, poisson_ratio, width=1.0, depth=0.8, quality=np.inf)
    found = reflector(replace(stator, thickness=np.inf), frequency=FREQUENCY, tolerance=1e-4)
    ((_, reflection),) = found.ends
    assert abs(reflection) == pytest.approx(REFLECTED_AND_PASSED[poisson_ratio][0], abs=2e-5)


@pytest.mark.slow
def test_loss_common_to_both_moduli_does_not_change_the_corner(tmp_path):
    """Amplitude and phase: the waves of both directions are scaled alike, whatever the loss."""
    at_corner = []
    for quality, depth in ((2.5, 7.0), (5.0, 10.0)):
        stator, wavenumber = quarter_space(tmp_path, 0.25, width=1.5, depth=depth, quality=quality)
        ((_, reflection),) = reflector(stator, frequency=FREQUENCY, tolerance=1e-4).ends
        way = stator.pieces[0].extent[1] - stator.pieces[0].extent[0]
        at_corner.append(reflection * np.exp(2j * wavenumber * way))
    assert at_corner[1] == pytest.approx(at_corner[0], abs=1e-5)


def rayleigh_at_a_wall(poisson_ratio, wavenumber, inwards, down, way):
    """Rayleigh wave on a wall that faces +x: u (2, m) as x and z components, and its derivatives by x and z.

    ``inwards`` and ``down``: distances from the wall and from the corner; ``way``: +1 down the wall, -1 up.
    """

    @cache
    def shape(shift):
        return np.array(profile(poisson_ratio, wavenumber * (inwards + shift) / (2 * np.pi)))

    step = 1e-4 / abs(wavenumber)
    slope = (8 * (shape(step) - shape(-step)) - (shape(2 * step) - shape(-2 * step))) / (12 * step)
    turn = np.exp(-1j * way * wavenumber * down)

    def turned(along_and_out):
        return np.array([along_and_out[1], -way * along_and_out[0]]) * turn

    return turned(shape(0.0)), -turned(slope), 1j * way * wavenumber * turned(shape(0.0))


def reciprocity(solid, one, other):
    """Reciprocity of two fields (u, by x, by z) on a horizontal line, u . t(v) - v . t(u) with the traction t."""
    stiffness = solid.stiffness_lossy
    lame, shear = stiffness[0, 1], stiffness[4, 4]

    def traction(field):
        _, by_x, by_z = field
        return np.array([shear * (by_z[0] + by_x[1]), lame * by_x[0] + (lame + 2 * shear) * by_z[1]])

    return np.sum(one[0] * traction(other) - other[0] * traction(one), axis=0)


@pytest.mark.parametrize("poisson_ratio", SOME_SLOW)
def test_the_corner_passes_the_rayleigh_wave_down_the_wall(tmp_path, poisson_ratio):
    """The Rayleigh wave in the field on a line below is told from bulk waves by reciprocity with the one going up."""
    wide, down = 5.0, 2.0  # wavelengths
    stator, wavenumber = quarter_space(tmp_path, poisson_ratio, width=wide, depth=8.0, quality=4.0)
    unit = stator.pieces[0].position
    section = discretise(stator, Resolution(order=7, edge_layers=2), wavelength=unit, surface_scale=np.inf)
    modes = guided_modes(section, FREQUENCY)
    wall = condensed_pieces(stator, modes, Resolution(order=7, edge_layers=2)).ends[1]
    waves = waves_of(modes, modes.rayleigh, section.solid.stress_unit)
    arriving = waves.right[:, 0]
    sent = wall.reflection(modes, 1, waves.modes) @ arriving
    shapes = modes.right[:, waves.modes] @ arriving
    at_corner = (section.surface_rows @ shapes)[1] * np.exp(-1j * wavenumber * wide * unit)
    panels = np.linspace(0.0, wide, 41)
    points, weights = legendre.leggauss(8)
    inwards = (panels[:-1, None] + np.diff(panels)[:, None] * (points + 1) / 2).ravel()
    measure = (np.diff(panels)[:, None] * weights / 2).ravel()
    at = np.stack([wide - inwards, np.full(len(inwards), -down)], axis=1)
    values, by_x, by_z, inside = wall.recover(shapes + modes.left @ sent).at(at)
    assert inside.all()
    own = tuple(each[:, [0, 2]].T for each in (values, by_x / unit, by_z / unit))
    up, downwards = (rayleigh_at_a_wall(poisson_ratio, wavenumber, inwards * unit, down * unit, way) for way in (-1, 1))
    passed = (reciprocity(stator.solid, own, up) @ measure) / (reciprocity(stator.solid, downwards, up) @ measure)
    assert abs(passed / at_corner) == pytest.approx(REFLECTED_AND_PASSED[poisson_ratio][1], abs=5e-5)


# |R| of a step of a quarter of a Rayleigh wavelength at nu = 0.25, of the same independent program: down, up
STEP_HEIGHT, STEPS = 0.25, {"down": 0.28745, "up": 0.32848}
LOSSY = ((2.0, 6.0), (2.5, 7.0), (3.5, 9.0), (5.0, 12.0), (7.0, 16.0))  # quality, depth in wavelengths


@pytest.mark.slow
@pytest.mark.parametrize("way", STEPS)
def test_a_step_of_the_surface_reflects_the_rayleigh_wave(tmp_path, way):
    """A step has a length, so that loss counts: R at k (1 - i eta) for five eta, taken to eta = 0."""
    found = []
    for quality, depth in LOSSY:
        plain, wavenumber = quarter_space(tmp_path, 0.25, width=1.0, depth=1.0, quality=quality)
        wavelength = 2 * np.pi / wavenumber.real
        path = rectangle(tmp_path / "step.msh", 2.0, depth, size=0.5, groove=(1.0, 1.0, STEP_HEIGHT))
        mesh = read_mesh(path, wavelength)
        if way == "up":  # seen from behind, z = 0 on the lower surface
            mesh = replace(
                mesh,
                digest=f"up {quality}",
                points=np.array([2, STEP_HEIGHT]) * wavelength + mesh.points * np.array([-1, 1]),
                cells=tuple(replace(each, nodes=each.nodes[:, [0, 2, 1]]) for each in mesh.cells),
                lines=mesh.lines | {"left": mesh.lines["right"], "right": mesh.lines["left"]},
            )
        stator = Stator(
            solid=plain.solid,
            length=3 * wavelength,
            thickness=(depth - STEP_HEIGHT * (way == "up")) * wavelength,
            ends="absorbing",
            pieces=(MeshPiece(name="step", mesh=mesh, position=wavelength),),
        )
        ((_, reflection),) = reflector(stator, frequency=FREQUENCY, tolerance=1e-4).ends
        eta = -wavenumber.imag / wavenumber.real
        found.append((eta, reflection * np.exp(2j * wavenumber * wavelength)))
    etas, reflections = np.array(found).T
    lossless = np.polyfit(etas.real, reflections, len(found) - 1)[-1]
    assert abs(lossless) == pytest.approx(STEPS[way], abs=2e-4)
    assert abs(reflections[-1]) != pytest.approx(STEPS[way], abs=4e-3)
