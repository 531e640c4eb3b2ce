"""Guided modes at a lateral wavenumber: against rotated axes, the half-space without a mesh and published slowness.

Truth: isotropy in the plane of a ceramic poled along its normal; the Stroh solution of the solid rotated about its
normal (no mesh, no k_y in it); slowness curvatures from the half-space and from the literature.
"""

from dataclasses import replace

import numpy as np
import pytest

import fem
from fem.analytic.half_space import rayleigh
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.exceptions import ConvergenceError
from fem.geometry import Stator
from fem.materials import rotated
from fem.materials.christoffel import slowest_wavelength
from fem.solve.guided import guided_modes
from fem.waveguide.guided_modes import guided_modes as modes_of_section
from fem.waveguide.guided_modes import power
from tests.fem.stators import FREQUENCY, cut, lossless, plate

CUTS = {
    "PZT-8 Z": lossless("PZT-8", "Z"),
    "PZT-4 X": cut("PZT-4", "X"),
    "YZ": lossless("LiNbO3 (Warner)", "YZ"),
    "128YX": lossless("LiNbO3 (Kovacs)", "128YX"),
    "ST-X": lossless("quartz (Bechmann)", "ST-X"),
    "no symmetry": cut("LiNbO3 (Ogi)", (17.0, 31.0, 49.0), quality=300.0),
    "steel": cut("steel", "Z", quality=500.0),
    "X-cut quartz": lossless("quartz (Bechmann)", (90.0, 90.0, 30.0)),  # a twofold axis along the normal
}


def line(solid, *, order=8, thickness=0.8, **rest):
    stator = plate(solid, thickness=thickness, **rest)
    return discretise(
        stator,
        Resolution(order=order, edge_layers=0),
        wavelength=slowest_wavelength(solid, FREQUENCY),
        surface_scale=np.inf,
        lateral=True,
    )


def discretise_finely(stator):
    unit = slowest_wavelength(stator.solid, FREQUENCY)
    return discretise(stator, Resolution(order=14, edge_layers=0), wavelength=unit, surface_scale=np.inf)


@pytest.mark.parametrize("quality", [np.inf, 1000.0])
def test_modes_of_a_ceramic_poled_along_the_normal_are_those_at_zero_rotated(quality):
    """k_x^2 + k_y^2 = k^2 for propagating and evanescent modes, sagittal ones and shear-horizontal ones alike."""
    depth = line(cut("PZT-8", "Z", quality=quality, loss=0.0))
    straight = modes_of_section(depth, FREQUENCY).wavenumbers
    lateral = 2.1
    oblique = modes_of_section(depth, FREQUENCY, lateral).wavenumbers ** 2 + lateral**2
    slow = straight[abs(straight) < 30]
    assert len(slow) > 20
    for square in slow**2:
        nearest = oblique[np.argmin(abs(oblique - square))]
        assert abs(nearest - square) < 1e-10 * (abs(square) + lateral**2)


@pytest.mark.parametrize("name", CUTS)
def test_matrices_of_the_segment_have_the_symmetries_of_reciprocity_and_energy(name):
    """K(k_y)^T = K(-k_y); Hermitian without loss; complex symmetric and real where y -> -y is a symmetry."""
    depth = line(CUTS[name])
    _, first, adjoint, zeroth = depth.lateral_matrices(FREQUENCY, 1.7)
    _, first_back, adjoint_back, zeroth_back = depth.lateral_matrices(FREQUENCY, -1.7)
    size = abs(zeroth).max()
    if depth.solid.mirror_y is None:
        assert abs(adjoint - first_back.T).max() < 1e-14 * abs(first).max()
        assert abs(zeroth.T - zeroth_back).max() < 1e-14 * size
        assert np.iscomplexobj(first)
    else:
        assert abs(adjoint - first.T).max() < 1e-14 * abs(first).max()
        assert abs(zeroth.T - zeroth).max() < 1e-14 * size
        assert np.iscomplexobj(first) == (name in ("PZT-4 X", "steel"))
    if name in ("PZT-8 Z", "YZ", "128YX", "ST-X"):
        assert abs(zeroth - zeroth.conj().T).max() < 1e-14 * size
        assert abs(adjoint - first.conj().T).max() < 1e-14 * abs(first).max()
    assert abs(first_back - first).max() > 1e-3 * abs(first).max()
    assert not np.array_equal(adjoint_back, adjoint)


@pytest.mark.parametrize("name", CUTS)
def test_zero_lateral_wavenumber_is_the_limit(name):
    """The surface wave at a small k_y moves by O(k_y^2) or, without symmetry, O(k_y): nothing jumps at zero."""
    depth = line(CUTS[name])
    straight, near = (modes_of_section(depth, FREQUENCY, lateral) for lateral in (0.0, 1e-5))
    surface = straight.wavenumbers[straight.rayleigh[0]]
    assert abs(near.wavenumbers - surface).min() < 2e-5 * abs(surface)


@pytest.mark.parametrize("name", CUTS)
def test_modes_solve_the_quadratic_eigenvalue_problem(name):
    """Residual of [k^2 K2 + i k (K1 - K1t) + K0 - omega^2 M] v for slow modes of both directions."""
    depth = line(CUTS[name])
    modes = modes_of_section(depth, FREQUENCY, 1.7)
    second, first, adjoint, zeroth = depth.lateral_matrices(FREQUENCY, 1.7)
    for wavenumbers, shapes in ((modes.wavenumbers, modes.right), (modes.backwards, modes.left)):
        slow = abs(wavenumbers) < 15
        k, v = wavenumbers[slow], shapes[:, slow]
        residual = (second @ v) * k**2 + 1j * ((first - adjoint) @ v) * k + zeroth @ v
        assert abs(residual).max() < 1e-8 * abs(zeroth).max()
        assert slow.sum() > 8


def test_all_modes_of_the_answer_are_known_and_turn_with_the_axes():
    """A thick plate of z-poled ceramic at 75 degrees: the surface wave is recognised, every mode is one at k_y = 0."""
    stator = plate(CUTS["PZT-8 Z"], thickness=2.6)
    straight = guided_modes(stator, frequency=FREQUENCY, tolerance=1e-4)
    lateral = abs(straight.surface_wavenumber) * np.sin(np.radians(75))
    oblique = guided_modes(stator, frequency=FREQUENCY, lateral_wavenumber=lateral, tolerance=1e-4)
    assert oblique.surface_angle == pytest.approx(np.radians(75), rel=1e-4)
    assert oblique.surface_velocity == pytest.approx(straight.surface_velocity, rel=1e-4)
    assert len(straight.surface) == len(oblique.surface)
    assert 10 < len(oblique.wavenumbers) < 0.5 * oblique.unknowns
    squares = oblique.wavenumbers**2 + lateral**2
    for square in straight.wavenumbers[straight.wavenumbers != 0] ** 2:
        if abs(square) < (20 * lateral) ** 2:
            assert abs(squares - square).min() < 1e-3 * (abs(square) + lateral**2)
    assert np.all(oblique.wavenumbers.imag < 1e-6 * lateral)
    assert np.all(np.diff(oblique.wavenumbers.imag) <= 1e-6 * lateral)
    assert abs(oblique.shapes[..., :3]).max(axis=(1, 2)) == pytest.approx(np.ones(len(squares)), rel=1e-12)


def test_modes_that_travel_carry_power_and_do_not_exchange_it():
    """Without loss the power matrix of the travelling modes is diagonal, here in a cut without any mirror plane."""
    solid = lossless("LiNbO3 (Ogi)", (17.0, 31.0, 49.0))
    modes = modes_of_section(line(solid, order=10), FREQUENCY, 1.3)
    travels = np.flatnonzero(abs(modes.wavenumbers.imag) < 1e-9)
    assert len(travels) >= 3
    u, f = modes.right[:, travels], modes.right_flux[:, travels]
    carried = power(u, f, FREQUENCY)
    assert carried.min() > 0
    exchanged = abs(u.conj().T @ f - f.conj().T @ u) * np.pi * FREQUENCY / 2
    scale = np.sqrt(np.outer(carried, carried))
    assert (abs(exchanged - np.diag(np.diag(exchanged))) / scale).max() < 1e-7
    assert np.diag(exchanged) == pytest.approx(carried, rel=1e-7)


@pytest.mark.slow  # tests/fem/beam/test_cut_source.py has modes at lateral wavenumbers against rotated axes
@pytest.mark.parametrize("name", ["YZ", "128YX"])
@pytest.mark.parametrize("degrees", [17.0])
def test_surface_wave_at_an_angle_is_the_one_of_the_rotated_half_space(name, degrees):
    solid, angle = CUTS[name], np.radians(degrees)
    truth = rayleigh(rotated(solid, (degrees, 0.0, 0.0)), "open")
    wavenumber = 2 * np.pi * FREQUENCY / truth.velocity
    stator = plate(solid, thickness=3.0 if name == "YZ" else 6.0, bottom="absorbing")
    tolerance = 1e-6 if name == "YZ" else 1e-5
    found = guided_modes(
        stator, frequency=FREQUENCY, lateral_wavenumber=wavenumber * np.sin(angle), tolerance=tolerance
    )
    assert found.surface_wavenumber.real == pytest.approx(wavenumber * np.cos(angle), rel=1e-6)
    assert abs(found.surface_wavenumber.imag) < 1e-6 * wavenumber
    assert found.relative_error <= tolerance
    assert found.surface_angle == pytest.approx(angle, rel=1e-5)
    assert found.surface_velocity == pytest.approx(truth.velocity, rel=1e-6)
    # the orbit at the surface: the truth's components lie along and across the wave vector
    at_top = found.shapes[found.surface[0], -1, :3]
    assert found.depth[-1] == 0
    along = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]) @ at_top[:2]
    assert along / at_top[2] == pytest.approx(truth.displacement[:2], rel=2e-4, abs=2e-5)


def curvature(solid) -> float:
    """Slowness curvature d(power-flow angle)/d(angle) at k_y = 0 from k_x(k_y), where k_x is even in k_y.

    k_x = k - (1 + gamma) k_y^2 / (2 k) + O(k_y^4): with two values of k_y the fourth order is eliminated.
    """
    depth = line(solid, order=6, thickness=2.0, bottom="absorbing", above="vacuum")
    lateral = np.array([0.0, 0.015, 0.03]) * 2 * np.pi
    along = []
    for each in lateral:
        modes = modes_of_section(depth, FREQUENCY, each)
        along.append(modes.wavenumbers[modes.rayleigh[0]].real)
    drops = 2 * (along[0] - np.array(along[1:])) * along[0] / lateral[1:] ** 2
    return float(drops[0] + (drops[0] - drops[1]) / 3 - 1)


def half_space_curvature(solid) -> float:
    """The same from the velocity v(theta) without a mesh: v''/v at theta = 0, where v' = 0."""
    step = 0.8
    middle, near, far = (rayleigh(rotated(solid, (factor * step, 0.0, 0.0)), "vacuum").velocity for factor in (0, 1, 2))
    second = (2 * (near - middle) * 16 - 2 * (far - middle)) / 12
    return float(second / middle / np.radians(step) ** 2)


PUBLISHED = {  # slowness curvature of a free surface
    "quartz (Bechmann)": ("ST-X", 0.378, 0.005),
    "LiNbO3 (Warner)": ("YZ", -1.10, 0.02),
    "LiNbO3 (Kovacs)": ("YZ", -0.80, 0.02),
    "PZT-8": ("Z", 0.0, 1e-5),
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * name.startswith("LiNbO3")) for name in PUBLISHED]
)
def test_slowness_curvature(name):
    orientation, published, margin = PUBLISHED[name]
    solid = lossless(name, orientation)
    gamma = curvature(solid)
    assert gamma == pytest.approx(published, abs=margin)
    assert gamma == pytest.approx(half_space_curvature(solid), abs=1e-3)


def test_the_clamped_plate_has_evanescent_lateral_fields_too():
    """k_y beyond the slowest bulk wave: no mode propagates along x, and that is said."""
    solid = CUTS["PZT-8 Z"]
    stator = plate(solid, thickness=0.8)
    beyond = 1.5 * 2 * np.pi / slowest_wavelength(solid, FREQUENCY)
    with pytest.raises(ConvergenceError, match="no mode of this section propagates"):
        guided_modes(stator, frequency=FREQUENCY, lateral_wavenumber=beyond, tolerance=1e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"tolerance": 0.0}, r"tolerance must be positive and finite, got 0\.0"),
        ({"frequency": -1.0}, r"frequency must be positive and finite, got -1\.0 Hz"),
        ({"lateral_wavenumber": np.nan}, r"lateral_wavenumber must be finite, got nan rad/m"),
    ],
)
def test_refusals(change, message):
    stator = plate(CUTS["PZT-8 Z"])
    with pytest.raises(ValueError, match=message):
        fem.guided_modes(stator, **({"frequency": FREQUENCY, "tolerance": 1e-3} | change))


def test_all_propagating_modes_to_a_tolerance():
    """On request every mode that runs along the section is as good as the surface wave, which stands out in share."""
    stator = plate(CUTS["PZT-8 Z"], thickness=1.5)
    modes = fem.guided_modes(stator, frequency=FREQUENCY, tolerance=1e-3, propagating=True)
    exact = modes_of_section(discretise_finely(stator), FREQUENCY)
    running = exact.wavenumbers[exact.propagating] / exact.section.length_unit
    missed = [abs(modes.wavenumbers - k).min() / running.real.max() for k in running]
    assert max(missed) <= modes.relative_error <= 1e-3
    assert np.argmax(modes.surface_share[: len(running)]) in modes.surface


def test_radiation_impedance_at_a_lateral_wavenumber():
    """The impedance gives the flux of every mode where y -> -y is a symmetry; refused with the reason elsewhere."""
    modes = modes_of_section(line(CUTS["YZ"], order=6), FREQUENCY, 1.1)
    slow = abs(modes.wavenumbers) < 20
    error = modes.right_impedance @ modes.right - modes.right_flux
    assert abs(error[:, slow]).max() < 1e-9 * abs(modes.right_flux[:, slow]).max()
    with pytest.raises(ValueError, match="where y -> -y is a symmetry"):
        _ = modes_of_section(line(CUTS["128YX"], order=6), FREQUENCY, 1.1).right_impedance


def test_units_do_not_matter():
    """A plate a thousand times thicker at a thousandth of the frequency: wavenumbers a thousand times smaller."""
    solid = replace(CUTS["128YX"], mechanical_quality=200.0)
    small = plate(solid, thickness=1.3)
    large = Stator(solid=solid, length=small.length * 1e3, thickness=small.thickness * 1e3, ends="absorbing")
    one = guided_modes(small, frequency=FREQUENCY, lateral_wavenumber=900.0, tolerance=1e-4)
    other = guided_modes(large, frequency=FREQUENCY / 1e3, lateral_wavenumber=0.9, tolerance=1e-4)
    assert other.surface_wavenumber * 1e3 == pytest.approx(one.surface_wavenumber, rel=1e-9)
