"""The reference without a mesh: against closed forms, the half-space's wave, the structured solver."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipk

from fem import material, rayleigh
from tests.oracles.fem_plate_response import PlateResponse
from tests.studies.motors import small_problem, truth
from tests.validation import strip_charges
from tests.validation.contenders import CURVES
from tests.validation.strip_charges import StripCharges


def plate(*, coupled: bool = True, lossy: bool = True, thickness: float = 0.7e-3) -> PlateResponse:
    solid = material("PZT-8")
    return PlateResponse(
        stiffness=solid.stiffness_lossy if lossy else solid.stiffness.astype(complex),
        coupling=solid.coupling * coupled,
        permittivity=solid.permittivity_lossy if lossy else solid.permittivity.astype(complex),
        density=solid.density,
        thickness=thickness,
        frequency=2.2e6,
    )


def test_without_coupling_the_plate_is_a_dielectric_slab():
    """Oracle: phi = coth(k r h) / (sqrt(eps11 eps33) k), r^2 = eps11 / eps33, for real and complex k."""
    slab = plate(coupled=False)
    across, through = slab.permittivity[0, 0], slab.permittivity[2, 2]
    k = np.array([37.0, 2.1e3, 6.4e3 - 2.3e3j, 1.7e5])
    decay = k * np.sqrt(across / through) * slab.thickness
    expected = 1 / (np.tanh(decay) * np.sqrt(across * through) * k)
    assert slab.surface(k)[:, 2] == pytest.approx(expected, rel=1e-10)
    assert slab.high_wavenumber == pytest.approx(1 / np.sqrt(across * through), rel=1e-12)
    assert slab.low_wavenumbers[0] == pytest.approx(1 / (across * slab.thickness), rel=1e-9)


def test_a_thick_plate_resonates_at_the_half_space_wave():
    """Oracle: 1 / G changes sign at the Rayleigh wave of the bare surface, to 1e-8."""
    wave = rayleigh(material("PZT-8"), "open")
    thick = plate(lossy=False, thickness=20e-3)
    k = 2 * np.pi * thick.frequency / wave.velocity * (1 + np.array([-1e-8, 1e-8]))
    below, above = (1 / thick.surface(k)[:, 2]).real
    assert below * above < 0
    ratio = abs(thick.surface(k)[0, 0] / thick.surface(k)[0, 1])
    assert ratio == pytest.approx(wave.surface_ratio, rel=1e-6)


def test_two_strips_on_a_thick_slab_have_the_capacitance_of_conformal_mapping():
    """Oracle: C = sqrt(eps11 eps33) K(k') / (2 K(k)), k = gap / (gap + 2 width); the slab ends at (width / h)^2."""
    slab = plate(coupled=False, lossy=False, thickness=0.1)
    half, apart = 0.12e-3, 0.5e-3
    strips = StripCharges(plate=slab, centers=np.array([0.0, apart]), half_width=half, terms=10)
    charges, _ = strips.charges(np.array([0, 1]), {0: 0.5, 1: -0.5})
    share = (apart - 2 * half) / (apart + 2 * half)
    mean = np.sqrt(slab.permittivity[0, 0] * slab.permittivity[2, 2])
    assert charges[0] == pytest.approx(mean * ellipk(1 - share**2) / (2 * ellipk(share**2)), rel=1e-5)
    assert charges[0] == pytest.approx(-charges[1], rel=1e-10)


@pytest.mark.slow
def test_terms_and_paths_change_nothing(monkeypatch):
    """The matrix is symmetric; more terms, another K, slope, panel and Gaussian leave the answer alone (Cauchy)."""
    posed = small_problem()
    owner, held = np.array([0, 1, 2]), {0: 0.5, 1: -0.5}
    one = StripCharges(plate=plate(), centers=np.array([1e-3, 1.5e-3, 4e-3]), half_width=0.12e-3, terms=7)
    charges, coefficients = one.charges(owner, held)
    moved = one.motion(coefficients, posed.place)
    assert abs(one.matrix - one.matrix.T).max() < 1e-13 * abs(one.matrix).max()
    assert abs(charges[2]) < 1e-12 * abs(charges[0])
    for name, value in (("_ANGLE", 0.8), ("_BEYOND", 1.5), ("_PANEL", 4.0), ("_SMOOTH", 0.7e-3)):
        monkeypatch.setattr(strip_charges, name, value)
    more = replace(one, terms=9)
    again, coefficients = more.charges(owner, held)
    assert charges[:2] == pytest.approx(again[:2], rel=1e-10)
    assert moved == pytest.approx(more.motion(coefficients, posed.place), rel=1e-10)


def test_the_structured_solver_agrees():
    """Two methods that share the constants alone; level 2 errs by some 1e-4 on the seed's stator."""
    posed = small_problem()
    admittance, motion = truth()
    found, moved, _ = CURVES["structured"][0](posed, level=2)()
    assert found == pytest.approx(admittance, rel=4e-4)
    assert moved == pytest.approx(np.array(motion), rel=4e-4)


@pytest.mark.parametrize("thickness", [0.525e-3, 0.535e-3])
def test_a_mode_at_its_cut_off_is_refused(thickness):
    """Its pole lies within the circle about k = 0."""
    with pytest.raises(ValueError, match="a mode of the plate is at its cut-off"):
        _ = plate(thickness=thickness).low_wavenumbers
