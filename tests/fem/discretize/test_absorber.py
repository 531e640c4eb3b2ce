"""Which layer stands for the half-space, that no guided mode grows in it, and what becomes of it at finer levels."""

import numpy as np
import pytest

from fem.analytic.half_space import rayleigh
from fem.discretize.absorber import DEPTHS, MATCHED_LAYER, absorber, absorber_kind, backwardness
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.discretize.mesh_refinement import LEVELS, level_gain
from fem.discretize.stability import largest_growth, layer_growth
from fem.eigenproblem import companion_modes
from fem.materials import anisotropic, fields, rotated
from fem.materials.christoffel import slowest_wavelength, slowness_sheets, stretch_absorbs
from fem.materials.medium import medium
from fem.solve.driven_stator import motion_difference, solve_driven
from tests.fem.stators import FREQUENCY, comb, cut, lossless, plate, wave_of

LITHIUM_NIOBATE = lossless("LiNbO3 (Kovacs)", "128YX")


def growth(solid, layer, order):
    return layer_growth(solid, medium(solid, fields(solid), lossy=False), layer, order)


def layers(solid, order, level):
    return absorber(solid, medium(solid, fields(solid), lossy=False), order, level)


def matched(solid):
    body = medium(solid, fields(solid), lossy=False)
    return [(height, stretch, body) for height, stretch in MATCHED_LAYER[::-1]]


@pytest.mark.parametrize(
    ("name", "orientation", "kind"),
    [
        ("PZT-8", "Z", "matched"),
        ("PZT-5H", "X", "matched"),
        ("LiNbO3 (Kovacs)", "YZ", "matched"),
        ("quartz (Bechmann)", "ST-X", "matched"),
        ("LiNbO3 (Warner)", "128YX", "selective"),
        ("LiNbO3 (Ogi)", "128YX", "selective"),
        ("LiNbO3 (Kovacs)", "Z", "selective"),
        ("LiNbO3 (Kovacs)", (10.0, 38.0, 0.0), "selective"),
        ("quartz (Bechmann)", "Z", "selective"),
    ],
)
def test_kind_follows_the_slowness_surface(name, orientation, kind):
    assert absorber_kind(cut(name, orientation)) == kind


def test_backward_waves_of_128yx():
    """The sheet of u_z alone is concave at the axis, by the published 0.019 (Kovacs' constants)."""
    assert not stretch_absorbs(LITHIUM_NIOBATE)
    sheets = slowness_sheets(LITHIUM_NIOBATE)
    (concave,) = [sheet for sheet in sheets if sheet.backwardness]
    assert concave.backwardness == pytest.approx(0.0193, abs=2e-4)
    assert abs(concave.polarisation[fields(LITHIUM_NIOBATE).index("uz")]) > 0.99
    assert backwardness(cut("quartz (Bechmann)", "Z")) == pytest.approx(0.0603, abs=2e-4)


@pytest.mark.parametrize("level", [0, 1, 2, 3, pytest.param(4, marks=pytest.mark.slow)])
def test_no_mode_grows_over_the_selective_layer(level):
    """In rad per wavelength, where the surface wave has 6.4; the matched layer lets one grow by 0.1."""
    order = LEVELS[level].order
    assert growth(LITHIUM_NIOBATE, layers(LITHIUM_NIOBATE, order, level), order) < 1e-5
    assert growth(LITHIUM_NIOBATE, matched(LITHIUM_NIOBATE), order) > 0.05


def test_matched_layer_has_a_static_element_from_level_three_on():
    solid = lossless("PZT-5A", "Z")
    assert [len(layers(solid, 6, level)) for level in range(6)] == [5, 5, 5, 6, 6, 6]
    assert growth(solid, layers(solid, 8, 3), 8) < 1e-5


def test_selective_layer_deepens_with_the_level():
    depths = [sum(height for height, _, _ in layers(LITHIUM_NIOBATE, 7, level)) for level in range(5)]
    assert depths == pytest.approx([each.selective for each in DEPTHS[:5]])


def test_gain_is_low_where_the_layer_decides():
    """Z quartz is backward by 0.06: there two depths differ by 1e-3 and the next ones not by much less."""
    strong = plate(cut("quartz (Bechmann)", "Z"), bottom="absorbing")
    assert level_gain(strong) < 2 < level_gain(plate(LITHIUM_NIOBATE, bottom="absorbing"))
    assert level_gain(plate(cut("quartz (Bechmann)", "Z"))) > 2


def test_a_further_level_of_the_layer_alone_changes_little():
    """PZT-5A over the static element and 128YX: the layer's share of the error is far below the level's 7e-5."""
    for name, orientation, bound in (("PZT-5A", "Z", 5e-5), ("LiNbO3 (Kovacs)", "128YX", 5e-5)):
        stator = plate(cut(name, orientation, quality=300.0), length=9.0, thickness=2.0, bottom="absorbing")
        transducer = comb(stator, "a", 2.0, finger_pairs=2)
        near, far = (
            wave_of(
                solve_driven(
                    stator,
                    (transducer,),
                    frequency=FREQUENCY,
                    drive="a",
                    resolution=Resolution(order=7, edge_layers=0, absorber=depth),
                )
            )
            for depth in (2, 3)
        )
        change = motion_difference(near.motion([0.74 * stator.length]), far.motion([0.74 * stator.length]))
        assert 1e-7 < change < bound
        assert abs(near.admittance / far.admittance - 1) < bound


def test_loss_of_the_layer_is_counted_as_radiated_power():
    """Power into the electrodes of a lossless solid is what leaves by the ends and by the layer."""
    from fem.results.power_balance import power_balance

    stator = plate(LITHIUM_NIOBATE, length=9.0, thickness=2.0, bottom="absorbing")
    solution = solve_driven(
        stator,
        (comb(stator, "a", 2.0, finger_pairs=2),),
        frequency=FREQUENCY,
        drive="a",
        resolution=Resolution(order=6, edge_layers=1, absorber=1),
    )
    balance = power_balance(solution)
    assert abs(balance.residual) < 1e-8
    assert balance.dissipated > 0.01 * balance.input


def lateral_growth(solid, share: float) -> float:
    """Of the modes of a half-space at a share of the surface wave's wavenumber along y."""
    stator = plate(solid, thickness=np.inf)
    depth = discretise(
        stator,
        Resolution(order=7, edge_layers=0),
        wavelength=slowest_wavelength(stator.solid, FREQUENCY),
        surface_scale=np.inf,
        lateral=True,
        least_depth=0.5,
    )
    wavenumber = 2 * np.pi * FREQUENCY * depth.length_unit / rayleigh(stator.solid, "open").velocity
    second, first, adjoint, zeroth = depth.lateral_matrices(FREQUENCY, share * wavenumber)
    k, shapes = companion_modes(second, 1j * (first - adjoint), zeroth)
    assert abs(abs(k.real) / wavenumber - np.sqrt(1 - share**2)).min() < 0.03  # the surface wave is among them
    return largest_growth(k, shapes, first @ shapes - 1j * (second @ shapes) * k)


@pytest.mark.parametrize(("name", "share"), [("128YX", 0.1), ("128YX", 0.6), ("ST-X", 0.4)])
def test_no_mode_grows_at_a_lateral_wavenumber(name, share):
    """Over the layer of oblique waves; over the matched layer of ST-X quartz one grows by 6e-3."""
    solid = LITHIUM_NIOBATE if name == "128YX" else lossless("quartz (Bechmann)", "ST-X")
    assert lateral_growth(solid, share) < 1e-6


def test_a_strongly_concave_solid_has_a_viscous_layer():
    """A cubic solid of anisotropy 2 c44 / (c11 - c12) = 14: no loss keeps its modes from growing."""
    stiffness = np.zeros((6, 6))
    stiffness[:3, :3] = 80e9
    stiffness[range(3), range(3)] = 100e9
    stiffness[range(3, 6), range(3, 6)] = 70e9
    table = {"coupling": np.zeros((3, 6)), "permittivity": 10 * np.eye(3), "density": 5000.0}
    solid = rotated(anisotropic(name="cubic", stiffness=stiffness, **table), (45.0, 0.0, 0.0))
    assert absorber_kind(solid) == "viscous"
    assert level_gain(plate(solid, bottom="absorbing")) < 2
    below = layers(solid, 6, 2)
    assert [height for height, _, _ in below] == [1.0] * 8
    assert growth(solid, below, 6) < 1e-6
