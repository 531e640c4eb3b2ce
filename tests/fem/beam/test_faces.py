"""Beam between free or clamped ends: against the section, power and reciprocity of a face, another contour."""

from dataclasses import replace

import numpy as np
import pytest

from fem.beam.beam_of_section import surface_beam
from fem.waveguide.end_conditions import end_reflection
from fem.waveguide.guided_modes import power
from tests.fem.stators import FREQUENCY, comb, cut, lossless, plate, solution, wave_of


def beam_between(ends, solid, *, length=9.0, thickness=0.8, order=5, aperture=5e-3, **rest):
    stator = plate(solid, length=length, thickness=thickness, ends=ends, **rest)
    one = comb(stator, "a", 3.0, finger_pairs=2, aperture=aperture)
    return surface_beam(wave_of(solution(stator, (one,), order=order)))


@pytest.mark.parametrize(
    ("ends", "bottom"), [("free", "free"), pytest.param("clamped", "grounded", marks=pytest.mark.slow)]
)
def test_wide_aperture_between_faces_is_the_section(ends, bottom):
    """At the faces, beside and between the fingers; where nothing is grounded, u_x has the pole at k = 0."""
    beam = beam_between(ends, cut("PZT-8", "Z", quality=20.0), bottom=bottom, aperture=0.2)
    edges, length = beam.charges[0].x[[0, -1]], beam.wave.length
    x = np.array([0.0, edges[0] - 1e-3, edges[1] + 1.2e-3, 0.7 * length, length])
    section = beam.wave.motion(x)
    tangential, _, normal = beam.motion(x)
    size = abs(section).max()
    np.testing.assert_allclose(normal, section[1], atol=1e-6 * size)
    np.testing.assert_allclose(tangential, section[0], atol=(5e-4 if bottom == "free" else 1e-6) * size)
    assert abs(beam.motion_beyond_modes(x)).max() < 1e-6 * size
    absorbing = replace(beam, faces=None).motion(x)
    assert abs(absorbing[2] - section[1]).max() > 0.1 * size


@pytest.mark.parametrize("ends", ["free", "clamped"])
def test_a_face_conserves_power_and_is_reciprocal(ends):
    """Without loss, at an angle: sagittal and SH modes mix, and their scattering matrix is unitary and symmetric."""
    beam = beam_between(ends, lossless("PZT-8", "Z"), thickness=1.3, order=6)
    for share in (0.0, 0.3, 0.6):
        modes = beam.faces.at((share + 1e-3) * beam.faces.highest).modes
        second, first, adjoint, zeroth = modes.section.lateral_matrices(FREQUENCY, modes.lateral_wavenumber)
        k, shapes = modes.wavenumbers, modes.right
        left_over = second @ shapes * k**2 + 1j * ((first - adjoint) @ shapes) * k + zeroth @ shapes
        slow = abs(k) < 30
        assert abs(left_over[:, slow]).max() < 1e-12 * abs(zeroth).max()
        flux = first @ shapes - 1j * (second @ shapes) * k
        np.testing.assert_allclose(modes.right_flux, flux, atol=1e-12 * abs(flux).max())
        moving = np.flatnonzero(abs(k.imag) < 1e-9 * abs(k))
        carried = power(modes.right, modes.right_flux, FREQUENCY)[moving]
        assert np.all(carried > 0)
        sent = end_reflection(modes, ends, 1, moving)[moving]
        scattering = np.sqrt(carried)[:, None] * sent / np.sqrt(carried)
        np.testing.assert_allclose(scattering.conj().T @ scattering, np.eye(len(moving)), atol=1e-8)
        np.testing.assert_allclose(abs(scattering), abs(scattering.T), atol=1e-8)
        sagittal = moving < beam.wave.solution.fields.modes.section.size
        mixed = abs(scattering[np.ix_(sagittal, ~sagittal)]).max()
        assert mixed > 0.1 if share else mixed < 0.1


def test_the_contour_gives_what_real_lateral_wavenumbers_give():
    """Strong loss, so that side faces far away, a sum over real k_y, leave the field as it is."""
    beam = beam_between("free", cut("PZT-8", "Z", quality=15.0))
    length = beam.wave.length
    x = np.array([0.1, 0.55, 0.8, 1.0])[:, None] * length
    y = np.array([0.0, 1.5e-3, 4e-3])
    found = beam.motion(x, y)
    size = abs(found).max()
    others = surface_beam(beam.wave, mirror_width=0.12).motion(x, y)
    np.testing.assert_allclose(found, others, atol=5e-4 * size)
    np.testing.assert_allclose(found[2], others[2], atol=1e-6 * size)
    assert abs(replace(beam, faces=None).motion(x, y) - found).max() > 0.1 * size
    between = surface_beam(beam.wave, mirror_width=8e-3)
    at_side_face = between.motion(x[:, 0], 4e-3)
    assert abs(at_side_face[1]).max() < 1e-12 * size
    assert abs(between.motion(x[:, 0], 2e-3)[1]).max() > 1e-2 * size


def test_twice_the_charges_make_twice_the_field():
    """Also after the field of others was asked for: what comes back belongs to the charges that sent it."""
    beam = beam_between("free", cut("PZT-8", "Z", quality=15.0))
    place = 0.8 * beam.wave.length, 1.5e-3
    once = beam.motion(*place)
    charges = tuple(replace(each, charge=2 * each.charge) for each in beam.charges)
    np.testing.assert_allclose(replace(beam, charges=charges).motion(*place), 2 * once, rtol=1e-12)


def test_no_shear_traction_at_a_free_face():
    """T_xy = c_66 (du_x/dy + du_y/dx), by differences along the surface."""
    beam, step = beam_between("free", cut("PZT-8", "Z", quality=60.0)), 2e-5
    y = np.array([1.2e-3, 2e-3, 3e-3])
    inward = beam.motion(step * np.arange(4)[:, None], y)[1]
    by_x = (-11 * inward[0] + 18 * inward[1] - 9 * inward[2] + 2 * inward[3]) / (6 * step)
    by_y = (beam.motion(0.0, y + step)[0] - beam.motion(0.0, y - step)[0]) / (2 * step)
    np.testing.assert_allclose(by_x, -by_y, atol=0.03 * abs(by_y).max())


@pytest.mark.parametrize("bottom", ["free", "grounded"])
def test_stated_error_bounds_a_finer_contour(monkeypatch, bottom):
    """Beside the charges too, and with hardly any loss."""
    solid = cut("PZT-8", "Z", quality=200.0 if bottom == "free" else 1e5)
    beam = beam_between("free", solid, length=12.0, thickness=0.8, bottom=bottom)
    exact_section = replace(beam, wave=replace(beam.wave, relative_error=0.0))
    x = np.array([0.5, 0.75, 1.0])[:, None] * beam.wave.length
    y = np.array([0.0, 2e-3, 5e-3])
    found, stated = exact_section.motion_and_error(x, y)
    monkeypatch.setattr("fem.beam.lateral.SPACING", 0.18)
    finer = surface_beam(beam.wave).motion(x, y)
    missed = abs(finer - found).max(axis=0) / abs(finer[[0, 2]]).max(axis=0)
    assert np.all(missed < np.maximum(stated, 1e-9))
    assert np.all(stated < 2e-2)
