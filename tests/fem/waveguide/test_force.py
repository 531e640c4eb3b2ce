"""A line force on the surface: the surface wave that it sends is the half-space's compliance at its pole."""

import numpy as np
import pytest

from fem.analytic.wave_compliance import wave_compliance
from fem.discretize.depth_mesh import discretise
from fem.discretize.mesh_refinement import LEVELS
from fem.geometry import Stator
from fem.materials.christoffel import slowest_wavelength
from fem.waveguide.guided_modes import guided_modes
from fem.waveguide.line_force import force_response
from tests.fem.stators import FREQUENCY, lossless, plate


def modes_of(solid, frequency=5e6):
    """Guided modes of a half-space."""
    stator = Stator(solid=solid, length=1.0, thickness=np.inf, ends="absorbing")
    unit = slowest_wavelength(solid, frequency)
    return guided_modes(discretise(stator, LEVELS[4], wavelength=unit, surface_scale=np.inf), frequency)


@pytest.mark.parametrize(
    ("name", "cut"),
    [("PZT-8", "Z"), ("LiNbO3 (Kovacs)", "128YX"), ("LiNbO3 (Warner)", "128YX"), ("quartz (Bechmann)", "ST-X")],
)
def test_the_surface_wave_of_a_normal_force_is_gamma(name, cut):
    """U_z = -i Gamma F: Gamma from the radiation impedances against the derivative of the surface impedance."""
    solid = lossless(name, cut)
    sent = force_response(modes_of(solid), "z").surface_wave
    gamma = 1j * sent[1]
    assert gamma.real == pytest.approx(wave_compliance(solid, "open"), rel=1e-6, abs=0)
    assert abs(gamma.imag) < 1e-6 * gamma.real


def test_forces_along_x_and_z_answer_each_other():
    """Maxwell-Betti: u_x at a distance by a normal force is u_z there, backwards, by a tangential one; r^2 Gamma."""
    modes = modes_of(lossless("LiNbO3 (Kovacs)", "128YX"))
    normal, along = force_response(modes, "z"), force_response(modes, "x")
    for distance in (0.0, 0.13e-3, 2.1e-3):
        assert normal.motion(distance)[0] == pytest.approx(along.motion(-distance)[1], rel=1e-8, abs=1e-24)
    ratio = abs(normal.surface_wave[0] / normal.surface_wave[1])
    assert abs(along.surface_wave[0]) == pytest.approx(ratio**2 * abs(normal.surface_wave[1]), rel=1e-8, abs=0)
    assert along.component == "x"


def test_the_power_of_a_force_leaves_as_waves():
    """What the force gives, -omega Im(u F*) / 2, is what the radiation impedances carry away on both sides."""
    modes = modes_of(lossless("PZT-8", "Z"))
    response = force_response(modes, "z")
    omega, unit = 2 * np.pi * modes.frequency, modes.section.solid.stress_unit
    given = -0.5 * omega * np.imag(response.motion(0.0)[1])
    line = response.line
    carried = -0.5 * omega * unit * np.imag(np.conj(line) @ modes.impedance_sum @ line)
    assert given == pytest.approx(carried, rel=1e-10)
    surface = abs(response.surface_wave[1]) ** 2 * omega / (4 * wave_compliance(lossless("PZT-8", "Z"), "open"))
    assert 0.3 * given < 2 * surface < given


@pytest.mark.parametrize("share", [0.3, 0.8])
def test_a_force_that_varies_along_y_sends_gamma_obliquely(share):
    """exp(-i k_y y) on a solid isotropic about z: U_z = -i Gamma kappa / k_x exp(-i k_x x), as of a beam's spectrum."""
    solid, frequency = lossless("PZT-8", "Z"), 5e6
    stator = Stator(solid=solid, length=1.0, thickness=np.inf, ends="absorbing")
    unit = slowest_wavelength(solid, frequency)
    section = discretise(stator, LEVELS[3], wavelength=unit, surface_scale=np.inf, lateral=True)
    plain = guided_modes(section, frequency)
    kappa = plain.wavenumbers[plain.rayleigh[0]].real
    modes = guided_modes(section, frequency, share * kappa)
    sent = force_response(modes, "z").surface_wave[1]
    expected = -1j * wave_compliance(solid, "open") / np.sqrt(1 - share**2)
    assert sent == pytest.approx(expected, rel=1e-5, abs=0)


def test_the_jump_of_the_flux_is_the_force():
    """(X_right + X_left) u = -F e in a plate without ground, whose constant potential is a mode at k_y = 0 alone."""
    solid = lossless("PZT-8", "Z")
    stator = plate(solid, ends="absorbing")
    unit = slowest_wavelength(solid, FREQUENCY)
    section = discretise(stator, LEVELS[0], wavelength=unit, surface_scale=np.inf, lateral=True)
    for lateral_wavenumber in (0.0, 2.0):
        response = force_response(guided_modes(section, FREQUENCY, lateral_wavenumber), "z")
        jump = response.modes.impedance_sum @ response.line
        load = section.surface_rows[1] / section.solid.stress_unit
        assert abs(jump + load).max() < 1e-8 * abs(load).max()
