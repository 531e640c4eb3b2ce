"""Gamma of a half-space's surface wave: closed form, independent values, and power by the field through depth."""

import numpy as np
import pytest

import fem


def test_it_is_the_closed_form_of_an_isotropic_solid():
    # nu = 1/4: 0.183486/mu; any density
    solid = fem.isotropic(name="nu = 1/4", youngs_modulus=2.5e11, poisson_ratio=0.25, density=3210.0)
    assert fem.wave_compliance(solid) == pytest.approx(0.183486 / 1e11, rel=3e-6)


@pytest.mark.parametrize(
    ("name", "surface", "value", "digits"),
    [
        ("LiNbO3 (Kovacs)", "vacuum", 2.5078e-12, 5e-4),  # the values leave u_y out, which this cut couples weakly
        ("LiNbO3 (Kovacs)", "metallised", 2.9527e-12, 7e-4),
        ("LiNbO3 (Warner)", "vacuum", 2.3129e-12, 3e-3),
        ("PZT-8", "vacuum", 4.8674e-12, 2e-5),
    ],
)
def test_it_is_that_of_an_independent_program(name, surface, value, digits):
    solid = fem.material(name)
    solid = fem.rotated(solid, "128YX") if "LiNbO3" in name else solid
    assert fem.wave_compliance(solid, surface) == pytest.approx(value, rel=digits)


def test_the_power_of_the_wave_is_that_of_its_field():
    # Conservation: |U|^2 omega/(4 Gamma) is kinetic energy per length (twice its mean) times the group velocity
    solid = fem.rotated(fem.material("LiNbO3 (Kovacs)"), "128YX")
    wave = fem.rayleigh(solid, "open")
    depth = np.linspace(0.0, 12.0, 12001)
    displacement, _ = wave.profile(depth)
    density = np.trapezoid(np.sum(np.abs(displacement) ** 2, axis=1), depth)  # wavelengths
    omega = 2 * np.pi * 1e7
    wavelength = wave.velocity / 1e7
    power = 2 * 0.25 * solid.density * omega**2 * density * wavelength * wave.velocity
    assert fem.wave_compliance(solid, "open") == pytest.approx(omega / (4 * power), rel=1e-4)


def test_springs_shift_the_wave_by_the_root_of_rayleighs_function():
    # Published exact roots of mu R(k) = K k_T^2 q_L, nu = 0.17, at Gamma K/k = 1e-4 ... 3e-2
    solid = fem.isotropic(name="nu = 0.17", youngs_modulus=1e11, poisson_ratio=0.17, density=2200.0)
    k = 2 * np.pi * 1e7 / fem.rayleigh(solid).velocity
    for share, exact in ((1e-4, -9.99649e-5), (1e-3, -9.96493e-4), (1e-2, -9.65213e-3), (3e-2, -2.69306e-2)):
        springs = share * k / fem.wave_compliance(solid)
        assert fem.spring_shift(solid, springs, 0.0, 1e7) == pytest.approx(exact, rel=2e-6)


def test_springs_on_128yx():
    # Published with K_t = 0.844 K_n and without u_y, which couples where the shift reaches the bulk waves' limit
    cut = fem.rotated(fem.material("LiNbO3 (Kovacs)"), "128YX")
    for normal, exact, digits in ((1e12, -2.7557e-4, 3e-4), (1e13, -2.7411e-3, 4e-4), (5e13, -1.2833e-2, 2e-3)):
        assert fem.spring_shift(cut, normal, 0.844 * normal, 9.61e6) == pytest.approx(exact, rel=digits)
    assert fem.spring_shift(cut, 6e13, 6e13, 9.61e6) is None  # a shear-horizontal wave is left


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"frequency": np.nan}, "frequency must be positive and finite, got nan Hz"),
        ({"frequency": 0.0}, "frequency must be positive and finite, got 0.0 Hz"),
        ({"normal": np.nan}, "normal must be a finite stiffness, got nan Pa/m"),
    ],
)
def test_springs_without_a_number_are_refused(wrong, message):
    """With NaN the bracket of the root never closed."""
    with pytest.raises(fem.InputError, match=message):
        fem.spring_shift(fem.material("steel"), **({"normal": 1e13, "tangential": 1e13, "frequency": 2e6} | wrong))


def test_wavelengths_and_tolerances_without_a_number_are_refused():
    cut = fem.rotated(fem.material("PZT-8"), "Z")
    for call in (
        lambda: fem.slowest_wavelength(cut, np.nan),
        lambda: fem.automatic_period(cut, np.nan, 0.5),
        lambda: fem.free_wave(
            fem.Stator(solid=cut, length=1e-2, thickness=1e-3, ends="free"), frequency=np.nan, tolerance=1e-3
        ),
    ):
        with pytest.raises(fem.InputError, match="frequency must be positive and finite, got nan Hz"):
            call()
    with pytest.raises(fem.InputError, match="tolerance must be positive, got nan"):
        fem.cell_parameters(cut, period=1e-3, metallisation=0.5, tolerance=np.nan)


@pytest.mark.parametrize("share", [0.1, 0.6, 0.9, 0.97])
def test_a_travelling_pressure_dents_as_rayleighs_function_says(share):
    """u_z = -k_T^2 q_L/(mu R) t_z with R = (2 k^2 - k_T^2)^2 - 4 k^2 q_L q_T, which is 0 at c_R."""
    E, nu, density = 1e11, 0.17, 2200.0
    solid = fem.isotropic(name="nu = 0.17", youngs_modulus=E, poisson_ratio=nu, density=density)
    mu = E / (2 * (1 + nu))
    shear, pressure = np.sqrt(mu / density), np.sqrt(2 * mu * (1 - nu) / (1 - 2 * nu) / density)
    v, k = share * shear, 1.0
    k_t, q_l, q_t = v / shear, np.sqrt(1 - (v / pressure) ** 2), np.sqrt(1 - (v / shear) ** 2)
    R = (2 * k**2 - k_t**2) ** 2 - 4 * k**2 * q_l * q_t
    found = fem.travelling_compliance(solid, v)
    assert found[1, 1].real == pytest.approx(-(k_t**2) * q_l / (mu * R), rel=1e-9)
    assert found[0, 0].real == pytest.approx(-(k_t**2) * q_t / (mu * R), rel=1e-9)
    # of both signs of the mixed term: a pressure that runs the other way
    mixed = (2 * k**2 - k_t**2 - 2 * q_l * q_t) / (mu * R)
    assert abs(found[0, 1]) == pytest.approx(abs(mixed), rel=1e-9)
    assert found == pytest.approx(found.conj().T, abs=1e-24)


def test_a_pressure_faster_than_bulk_waves_is_refused():
    solid = fem.isotropic(name="soft", youngs_modulus=1e9, poisson_ratio=0.4, density=1000.0)
    with pytest.raises(fem.InputError, match="velocity must be below that of the bulk waves"):
        fem.travelling_compliance(solid, 4000.0)
