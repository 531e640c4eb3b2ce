"""Guided modes: the equation they solve, the ends they make, and plates and half-spaces with known answers."""

import numpy as np
import pytest

from fem.analytic.half_space import rayleigh
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.exceptions import ConvergenceError
from fem.geometry import Stator
from fem.materials import isotropic
from fem.waveguide.guided_modes import guided_modes, power
from tests.fem.stators import FREQUENCY, cut, lossless, plate, section
from tests.oracles import fem_lamb

SECTIONS = (
    (lossless("PZT-4", "Z"), {}),
    (cut("PZT-8", "Z"), {"bottom": "grounded"}),
    (cut("PZT-5H", "X"), {"bottom": "clamped"}),
    (cut("PZT-4", "Z"), {"above": "vacuum"}),
    (lossless("LiNbO3 (Warner)", "YZ"), {}),
    (lossless("LiNbO3 (Warner)", "YZ"), {"bottom": "absorbing"}),
    (lossless("LiNbO3 (Kovacs)", "128YX"), {"bottom": "clamped"}),
    (cut("LiNbO3 (Kovacs)", (17.0, 31.0, 49.0), quality=300.0), {"bottom": "grounded"}),
    (lossless("LiNbO3 (Ogi)", (17.0, 31.0, 49.0)), {}),
    (lossless("quartz (Bechmann)", "ST-X"), {}),
    (cut("steel", "Z"), {}),
)
NAMES = [f"{solid.name} {solid.frame} {' '.join(rest.values())}" for solid, rest in SECTIONS]


@pytest.fixture(scope="module", params=SECTIONS, ids=NAMES)
def guided(request):
    solid, rest = request.param
    return guided_modes(section(plate(solid, thickness=1.3, **rest), layers=1), FREQUENCY)


def test_modes_solve_the_quadratic_eigenproblem(guided):
    """Worst of the modes up to 40 rad per length unit; fast evanescent ones keep fewer digits."""
    second, first, zeroth = guided.section.matrices(FREQUENCY)
    size = max(np.abs(matrix).max() for matrix in (second, first, zeroth))
    for wavenumbers, shapes in ((guided.wavenumbers, guided.right), (guided.backwards, guided.left)):
        slow = np.abs(wavenumbers) < 40.0
        k, v = wavenumbers[slow], shapes[:, slow] / np.linalg.norm(shapes[:, slow], axis=0)
        residual = second @ v * k**2 + 1j * (first - first.T) @ v * k + zeroth @ v
        assert slow.sum() > 12
        assert np.abs(residual).max() < 1e-10 * size
    fluxes = first @ guided.right - 1j * second @ guided.right * guided.wavenumbers
    assert np.abs(guided.right_flux - fluxes).max() < 1e-12 * np.abs(fluxes).max()


def test_ends_solve_their_riccati_equation(guided):
    """(X - K1^T) K2^-1 (X - K1) = K0 - omega^2 M, and to the left with K1 turned round; both symmetric."""
    second, first, zeroth = guided.section.matrices(FREQUENCY)
    scale = np.abs(zeroth).max()
    for ends, skew in ((guided.right_impedance, first), (guided.left_impedance, -first)):
        residual = (ends - skew.T) @ np.linalg.solve(second, ends - skew) - zeroth
        assert np.abs(residual).max() < 1e-12 * scale
        assert np.abs(ends - ends.T).max() == 0


def test_ends_know_their_modes(guided):
    slow = np.abs(guided.wavenumbers) < 40.0
    right, left = guided.right[:, slow], guided.left[:, slow]
    assert np.abs(guided.right_impedance @ right - guided.right_flux[:, slow]).max() < 1e-8
    assert np.abs(guided.left_impedance @ left + guided.left_flux[:, slow]).max() < 1e-8


def test_constant_potential_sends_nothing(guided):
    """Where nothing grounds the section, phi = 1 has no flux to either side and is one of the modes."""
    depth = guided.section
    if not depth.floating_potential:
        assert not np.any(guided.wavenumbers == 0)
        return
    size = np.abs(guided.right_impedance).max()
    assert np.abs(guided.right_impedance @ depth.constant_potential).max() < 1e-12 * size
    assert np.abs(guided.left_impedance @ depth.constant_potential).max() < 1e-12 * size
    assert np.sum(guided.wavenumbers == 0) == 1


def test_modes_go_right_and_left(guided):
    """As many as a line has unknowns to either side, by decay or, without loss, by power.

    An absorbing layer's discretisation error may turn a wave's decay by 1e-3 of k at this order.
    """
    n = guided.section.size
    slack = 1e-3 if np.iscomplexobj(guided.section.heights) else 1e-9
    assert guided.right.shape == guided.left.shape == (n, n)
    assert np.all(guided.wavenumbers.imag < slack * (1 + np.abs(guided.wavenumbers)))
    assert np.all(guided.backwards.imag > -slack * (1 + np.abs(guided.backwards)))


@pytest.fixture(
    scope="module",
    params=[case for case in SECTIONS if not case[0].is_lossy and case[1].get("bottom") != "absorbing"],
    ids=lambda case: f"{case[0].name} {case[0].frame}",
)
def travelling(request):
    """Modes of a lossless section, and which of them travel."""
    solid, rest = request.param
    modes = guided_modes(section(plate(solid, thickness=1.3, **rest), layers=1), FREQUENCY)
    straight = np.abs(modes.wavenumbers.imag) < 1e-9 * np.abs(modes.wavenumbers)
    return modes, np.flatnonzero(straight)


def test_lossless_modes_are_told_by_their_power(travelling):
    modes, travels = travelling
    assert len(travels) >= 3
    assert np.all(power(modes.right, modes.right_flux, FREQUENCY)[travels] > 0)
    assert np.all(power(modes.left, modes.left_flux, FREQUENCY)[travels] < 0)


def test_lossless_modes_carry_power_each_for_itself(travelling):
    """Orthogonality u_m^H f_n - f_m^H u_n = 0 for different modes that travel (Auld, vol. 2, section 10.B)."""
    modes, travels = travelling
    u, f = modes.right[:, travels], modes.right_flux[:, travels]
    cross = u.conj().T @ f - f.conj().T @ u
    size = np.sqrt(np.abs(np.outer(np.diag(cross), np.diag(cross))))
    assert np.all(np.abs(cross - np.diag(np.diag(cross))) <= 1e-9 * size)


@pytest.mark.parametrize("solid", [lossless("PZT-4", "X"), cut("quartz (Bechmann)", "ST-X")], ids=["X", "ST-X"])
def test_symmetry_only_saves_time(solid):
    """The half-size problem linear in k^2 and the full companion problem give the same modes and ends."""
    half = section(plate(solid, thickness=1.3), layers=1)
    full = section(plate(solid, thickness=1.3), layers=1)
    full.__dict__["odd"] = None  # as if x -> -x were no symmetry
    one, other = guided_modes(half, FREQUENCY), guided_modes(full, FREQUENCY)
    size = np.abs(one.right_impedance).max()
    assert np.abs(one.right_impedance - other.right_impedance).max() < 1e-9 * size
    assert np.abs(one.left_impedance - other.left_impedance).max() < 1e-9 * size
    slow = [np.sort_complex(np.round(m.wavenumbers[np.abs(m.wavenumbers) < 15], 7)) for m in (one, other)]
    assert np.abs(slow[0] - slow[1]).max() < 1e-6


@pytest.mark.parametrize("order", [6, 7, 9])
@pytest.mark.parametrize(("name", "orientation"), [("PZT-4", "Z"), ("LiNbO3 (Kovacs)", "128YX")])
def test_absorber_does_not_turn_the_surface_wave_round(name, orientation, order):
    """Its error of 1e-7 in k may look like growth: the mode still goes where it carries power."""
    solid = lossless(name, orientation)
    depth = section(plate(solid, thickness=np.inf), order=order)
    modes = guided_modes(depth, FREQUENCY)
    k = modes.wavenumbers / depth.length_unit
    speed = 2 * np.pi * FREQUENCY / k[np.abs(k.imag) < 1e-2 * np.abs(k.real)].real
    assert np.abs(speed / rayleigh(solid, "open").velocity - 1).min() < 1e-5


@pytest.mark.parametrize(
    ("name", "orientation"),
    [
        ("PZT-4", "Z"),
        ("PZT-5H", "X"),
        pytest.param("LiNbO3 (Warner)", "YZ", marks=pytest.mark.slow),
        pytest.param("LiNbO3 (Kovacs)", "128YX", marks=pytest.mark.slow),
        ("quartz (Bechmann)", "ST-X"),
        ("steel", "Z"),
    ],
)
def test_surface_mode_is_the_half_spaces(name, orientation):
    """Over an absorbing bottom four wavelengths down, D_n = 0 above; no loss, so no attenuation."""
    solid = lossless(name, orientation)
    expected = rayleigh(solid, "open")
    depth = section(plate(solid, thickness=4.0, bottom="absorbing"), order=9)
    modes = guided_modes(depth, FREQUENCY)
    (index,) = modes.rayleigh
    k = modes.wavenumbers[index] / depth.length_unit
    assert 2 * np.pi * FREQUENCY / k.real == pytest.approx(expected.velocity, rel=1e-8)
    assert abs(k.imag) < 1e-8 * k.real
    at = [depth.surface_dofs[field] for field in ("ux", "uz")]
    ratio = modes.right[at[0], index] / modes.right[at[1], index]
    assert ratio == pytest.approx(expected.displacement[0], abs=1e-6)
    mirror = modes.left[at[0], index] / modes.left[at[1], index]
    assert (1j * ratio).real < 0 < (1j * mirror).real


def test_surface_mode_under_vacuum_is_slower():
    """Vacuum's permittivity: the half-space's own shift, to 1e-4 of it (the vacuum ends 64 wavelengths up)."""
    solid = lossless("LiNbO3 (Kovacs)", "128YX")
    velocities = []
    for above in ("none", "vacuum"):
        depth = section(plate(solid, thickness=np.inf, above=above), order=9)
        modes = guided_modes(depth, FREQUENCY)
        velocities.append(2 * np.pi * FREQUENCY * depth.length_unit / modes.wavenumbers[modes.rayleigh[0]].real)
    expected = rayleigh(solid, "vacuum").velocity / rayleigh(solid, "open").velocity
    assert velocities[1] / velocities[0] - 1 == pytest.approx(expected - 1, rel=1e-4)


def test_thick_plate_has_a_pair_of_surface_modes():
    """Symmetric and antisymmetric, as localised as each other; their mean is the half-space's velocity."""
    solid = lossless("PZT-4", "Z")
    depth = section(plate(solid, thickness=4.0), order=10)
    modes = guided_modes(depth, FREQUENCY)
    assert len(modes.rayleigh) == 2
    k = np.mean(modes.wavenumbers[modes.rayleigh]).real / depth.length_unit
    assert 2 * np.pi * FREQUENCY / k == pytest.approx(rayleigh(solid, "open").velocity, rel=1e-8)


NU = 0.31
GLASS = isotropic(name="glass", youngs_modulus=7.31e10, poisson_ratio=NU, density=2203.0)
SHEAR = float(np.sqrt(7.31e10 / (2 * (1 + NU)) / 2203.0))
PLATE = {"longitudinal": SHEAR * np.sqrt(2 * (1 - NU) / (1 - 2 * NU)), "shear": SHEAR, "half_thickness": 0.7e-3}
BACKWARD = 2.945  # omega h / c_S between the minimum of S1 and its cut-off


def lamb_roots(omega):
    """Wavenumbers of the modes that carry power to the right, the backward one negative."""
    roots = []
    for symmetric in (True, False):
        for k in fem_lamb.wavenumbers(omega, symmetric=symmetric, **PLATE):
            roots.append(k * np.sign(fem_lamb.group_velocity(k, omega, symmetric=symmetric, **PLATE)))
    return np.sort(roots)


@pytest.mark.parametrize("number", [0.05, 0.7, 1.9, BACKWARD, 4.4, 7.3])
def test_plate_modes_solve_the_rayleigh_lamb_equation(number):
    """Every real root, each to the side to which it carries power: the backward S1 wave has k < 0."""
    omega = number * SHEAR / PLATE["half_thickness"]
    frequency = omega / (2 * np.pi)
    stator = Stator(solid=GLASS, length=1.0, thickness=2 * PLATE["half_thickness"], ends="absorbing")
    depth = discretise(stator, Resolution(order=12, edge_layers=0), wavelength=SHEAR / frequency, surface_scale=np.inf)
    modes = guided_modes(depth, frequency)
    travels = np.abs(modes.wavenumbers.imag) < 1e-7 * np.abs(modes.wavenumbers)
    found = np.sort(modes.wavenumbers[travels].real) / depth.length_unit
    expected = lamb_roots(omega)
    assert len(found) == len(expected)
    assert found == pytest.approx(expected, rel=1e-8)
    assert (number == BACKWARD) == bool(np.any(expected < 0))


def test_nothing_propagates_where_the_loss_eats_all():
    """Q = 0.5 damps every wave within a fraction of its length: refused, not guessed."""
    depth = section(plate(cut("PZT-4", "Z", quality=0.5)))
    modes = guided_modes(depth, FREQUENCY)
    with pytest.raises(ConvergenceError, match=r"no mode of this section propagates at 2\.3e"):
        _ = modes.rayleigh


def test_long_waves_in_fine_layers_raise_no_warning():
    """A thousandth of the frequency: k^2 over 22 decades, and no word from the linear algebra."""
    stator = plate(cut("PZT-8", "Z"), thickness=1.0)
    slow = 1e-3 * FREQUENCY
    depth = section(stator, order=8, layers=3, frequency=slow, scale=1e-4)
    modes = guided_modes(depth, slow)
    assert np.all(np.isfinite(modes.right_impedance))
    assert np.abs(modes.right_impedance @ depth.constant_potential).max() < 1e-5 * np.abs(modes.right_impedance).max()
    propagating = modes.propagating
    flux = modes.right_flux[:, propagating]
    missed = np.abs(modes.right_impedance @ modes.right[:, propagating] - flux).max(axis=0)
    assert np.all(missed < 1e-5 * np.abs(flux).max(axis=0))


def test_finest_level_keeps_the_fluxes_of_slow_modes():
    """PZT-4 poled along x, clamped below, vacuum above, five edge layers: k^2 over 16 decades.

    Unscaled, the eigenproblem leaves errors of 6e-3 in the fluxes of the slow modes; the motion of a
    stator came out wrong by 6e-3 where 8e-4 was stated.
    """
    solid = cut("PZT-4", "X", quality=1e4)
    stator = Stator(solid=solid, length=0.0177, thickness=1.194e-3, bottom="clamped", ends="clamped", above="vacuum")
    frequency = 2429119.16
    depth = section(stator, order=10, layers=5, frequency=frequency, scale=0.1)
    modes = guided_modes(depth, frequency)
    slow = (abs(modes.wavenumbers) < 40) & (modes.wavenumbers != 0)
    flux = modes.right_flux[:, slow]
    missed = abs(modes.right_impedance @ modes.right[:, slow] - flux).max(axis=0) / abs(flux).max(axis=0)
    assert slow.sum() > 12
    assert missed.max() < 5e-4  # rounding decides: 1e-5 to 1.2e-4 on the machines seen


def test_fluxes_that_rounding_decides_are_refused():
    """A ten-thousandth of the frequency: the Riccati equation holds to 4e-14, the waves' own fluxes are off by 2."""
    stator = plate(cut("PZT-8", "Z"), thickness=1.0)
    slow = 1e-4 * FREQUENCY
    modes = guided_modes(section(stator, order=8, layers=3, frequency=slow, scale=1e-5), slow)
    with pytest.raises(ConvergenceError, match=r"miss their own fluxes by"):
        _ = modes.right_impedance
