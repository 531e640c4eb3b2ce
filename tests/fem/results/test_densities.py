"""Strain energy and power flow: against the modes' audit, the half-space, group velocity, and the instant."""

from dataclasses import replace

import numpy as np
import pytest

from fem.analytic.half_space import rayleigh
from fem.discretize.spectral import gll_nodes, lagrange, line_nodes
from fem.materials import isotropic
from fem.results.energy_densities import densities, shared, upward_slope
from fem.results.interior_field import free_field, wave_field
from fem.results.power_balance import power_balance
from fem.solve.guided import free_wave
from tests.fem.stators import FREQUENCY, comb, cut, lossless, plate, solution, wave_of

OMEGA = 2 * np.pi * FREQUENCY


def depth_integral(values, depth, order):
    """Gauss-Lobatto quadrature over the elements of the depth; the order of the fields' polynomials is enough."""
    points, weights = np.polynomial.legendre.leggauss(2 * order)
    basis, _ = lagrange(order, (points + 1) / 2)
    heights = np.diff(depth[::order])
    parts = [values[..., part * order : (part + 1) * order + 1] @ basis.T for part in range(len(heights))]
    return sum(part @ weights * height / 2 for part, height in zip(parts, heights, strict=True))


@pytest.mark.parametrize(
    ("name", "orientation"),
    [
        pytest.param("PZT-8", "Z", marks=pytest.mark.slow),
        pytest.param("PZT-5H", "X", marks=pytest.mark.slow),
        ("LiNbO3 (Ogi)", (17.0, 31.0, 49.0)),
    ],
)
def test_power_sent_out_is_what_the_audit_says(name, orientation):
    """Poynting's vector over the depth on both sides of the transducer against the modes' amplitudes."""
    stator = plate(cut(name, orientation), length=6.0)
    found = solution(stator, (comb(stator, "a", 2.3, finger_pairs=1),), order=9, layers=2)
    wave = wave_of(found)
    field = wave_field(wave, energies=True)
    lines = np.searchsorted(field.x, [wave.pieces[1].start - 1e-9, wave.pieces[1].stop + 1e-9])
    flux = depth_integral(field.densities.power_flow[lines - [0, 1], :, 0], field.z, 9)
    aperture, told = found.fields.transducers[0].aperture, power_balance(found)
    assert (flux[-1] - flux[0]) * aperture == pytest.approx(told.radiated, rel=5e-6)  # the fingers' edges
    assert flux[0] < 0 < flux[-1]


@pytest.mark.parametrize("name", ["glass", "PZT-8", pytest.param("LiNbO3 (Warner)", marks=pytest.mark.slow)])
def test_a_lossless_wave_carries_twice_its_kinetic_energy_at_its_velocity(name):
    """Half-space: no dispersion, so power = v (kinetic + stored), equal shares; glass stores in strain alone."""
    if name == "glass":
        solid = isotropic(name=name, youngs_modulus=7.31e10, poisson_ratio=0.2, density=2203.0)
    else:
        solid = lossless(name, "YZ" if "Li" in name else "Z")
    wave = free_wave(plate(solid, thickness=6.0, bottom="absorbing"), frequency=FREQUENCY, tolerance=1e-5)
    field = free_field(wave, span=(0.0, 1e-3), energies=True)
    kinetic = 0.25 * solid.density * OMEGA**2 * np.sum(abs(field.displacement) ** 2, axis=2)
    kinetic, strain, power = (
        depth_integral(values, field.z, wave.order)
        for values in (kinetic, field.densities.strain_energy, field.densities.power_flow[:, :, 0])
    )
    np.testing.assert_allclose(power, 2 * wave.velocity * kinetic, rtol=1e-5)  # 6 wavelengths deep
    if name == "glass":
        np.testing.assert_allclose(strain, kinetic, rtol=1e-5)
    else:
        assert np.all(strain < kinetic)  # the rest is the electric field's


def test_densities_of_the_meshless_half_space():
    """Node by node; the half-space's derivatives by central differences of its exponentials."""
    solid = lossless("PZT-8", "Z")
    exact = rayleigh(solid, "open")
    wave = free_wave(plate(solid, thickness=4.0, bottom="absorbing"), frequency=FREQUENCY, tolerance=1e-9)
    found = free_field(wave, span=(0.0, 1e-3), energies=True).densities
    wavelength, step = exact.velocity / FREQUENCY, 1e-4
    near = (wave.depth > -1.5 * wavelength) & (wave.depth < -step * wavelength)
    depth = -wave.depth[near] / wavelength

    def fields(at):
        u, phi = exact.profile(at)
        return np.concatenate([u, phi[:, None]], axis=1)[None]

    values = fields(depth)
    upward = (fields(depth - step) - fields(depth + step)) / (2 * step * wavelength)
    expected = densities(solid, FREQUENCY, values, -2j * np.pi / wavelength * values, upward)
    for part in ("strain_energy", "strain_energy_pulse", "power_flow", "power_flow_pulse"):
        ours, theirs = getattr(found, part)[0, near], getattr(expected, part)[0]
        assert abs(ours - theirs).max() < 3e-5 * abs(theirs).max()


def test_mean_and_pulse_make_the_instant():
    """At any phase the energy and the flow of the real fields of that instant, by the tensors' definitions."""
    rng = np.random.default_rng(3)
    solid = replace(lossless("LiNbO3 (Ogi)", (17.0, 31.0, 49.0)))
    values, along, upward = (rng.normal(size=(2, 3, 4)) + 1j * rng.normal(size=(2, 3, 4)) for _ in range(3))
    found = densities(solid, FREQUENCY, values, along, upward)
    voigt = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
    for phase in (0.0, 0.7, 2.9):
        turn = np.exp(1j * phase)
        gradient = np.zeros((2, 3, 4, 3), dtype=complex)  # d_j of u_i and phi
        gradient[..., 0], gradient[..., 2] = along * turn, upward * turn
        now, rate = gradient.real, (1j * OMEGA * gradient).real
        tensor = 0.5 * (now[..., :3, :] + np.swapaxes(now[..., :3, :], -1, -2))
        stiffness, coupling = solid.stiffness[voigt[:, :, None, None], voigt], solid.coupling[:, voigt]
        stress = np.einsum("ijkl,...kl->...ij", stiffness, tensor)
        energy = 0.5 * np.einsum("...ij,...ij->...", stress, tensor)
        stress = stress + np.einsum("kij,...k->...ij", coupling, now[..., 3, :])
        growth = 0.5 * (rate[..., :3, :] + np.swapaxes(rate[..., :3, :], -1, -2))
        current = np.einsum("ijk,...jk->...i", coupling, growth) - rate[..., 3, :] @ solid.permittivity
        velocity = (1j * OMEGA * values[..., :3] * turn).real
        flow = (values[..., 3] * turn).real[..., None] * current - np.einsum("...ij,...j->...i", stress, velocity)
        told = found.strain_energy + (found.strain_energy_pulse * turn**2).real
        np.testing.assert_allclose(told, energy, rtol=1e-12)
        told = found.power_flow + (found.power_flow_pulse * turn**2).real
        np.testing.assert_allclose(told, flow[..., [0, 2]], rtol=1e-9)


def test_slopes_are_those_of_the_elements_polynomials():
    breaks, order = np.array([-3.0, -1.1, -0.4, 0.0]), 5
    z = line_nodes(breaks, order)
    values = np.stack([z**5 - z, 3 * z**2])[:, :, None]
    slope = upward_slope(values, order, np.diff(breaks))
    np.testing.assert_allclose(slope[:, :, 0], [5 * z**4 - 1, 6 * z], rtol=1e-11, atol=1e-11)
    assert gll_nodes(order).size == order + 1


def test_where_elements_meet_the_mean_is_taken():
    parts = np.arange(6.0).reshape(1, 2, 3)
    np.testing.assert_array_equal(shared(parts, axis=1), [[0.0, 1.0, 2.5, 4.0, 5.0]])
