"""Line source in any cut: against the rotated modes, the section, reciprocity and the parabolic formula."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.special import fresnel

from fem.beam.beam_of_section import surface_beam
from fem.beam.cut_source import BASIS_ANGLE, LateralPolynomials, LateralSection, cut_source, surface_unknowns
from tests.fem.stators import comb, constants, cut, lossless, plate, solution, wave_of
from tests.oracles.fem_half_space_field import HalfSpaceField


def beam_in(solid, *, thickness=1.3, aperture=5e-3, length=30.0, pairs=3, order=7):
    stator = plate(solid, length=length, thickness=thickness)
    one = comb(stator, "a", 6.0, finger_pairs=pairs, aperture=aperture)
    return surface_beam(wave_of(solution(stator, (one,), order=order)))


def test_modes_at_each_lateral_wavenumber_are_the_rotated_ones():
    """In a ceramic poled along z, far enough for the directions that are left out."""
    turned = beam_in(cut("PZT-8", "Z", quality=60.0))
    solved = replace(turned, source=cut_source(turned.wave.solution.fields))
    right = turned.charges[0].x[-1] + np.array([6e-3, 8e-3])[:, None]
    y = np.array([-2.2e-3, 0.0, 1e-3, 2.2e-3])
    expected, found = turned.motion(right, y), solved.motion(right, y)
    # a ripple of 1e-4 in u_x is the pole at k = 0, whose integral has a kink
    np.testing.assert_allclose(found, expected, atol=4e-4 * abs(expected).max())
    np.testing.assert_allclose(found[2], expected[2], atol=2e-4 * abs(expected).max())
    left = turned.charges[0].x[0] - 2.5e-3
    expected = turned.motion(left, y)
    np.testing.assert_allclose(solved.motion(left, y), expected, atol=5e-3 * abs(expected).max())
    lateral = np.array([-0.3, 0.1, 0.3]) * turned.source.wavenumbers[turned.source.surface].mean().real
    np.testing.assert_allclose(solved.surface_wavenumbers(lateral), turned.surface_wavenumbers(lateral), rtol=3e-7)
    expected = turned.surface_mode.motion(right, y)
    np.testing.assert_allclose(solved.surface_mode.motion(right, y), expected, atol=1e-3 * abs(expected).max())


@pytest.fixture(scope="module")
def ceramic():
    """A half-space of a ceramic poled along z: its beam by rotated modes, and the source of any cut."""
    beam = beam_in(cut("PZT-8", "Z", quality=60.0), thickness=np.inf, length=30.0, aperture=3e-3)
    beam = replace(beam, wave=replace(beam.wave, relative_error=0.0))
    return beam, cut_source(beam.wave.solution.fields)


def test_half_space_by_rotated_modes(ceramic):
    """u_z is 3e-5 off and more with SPACING_GROUNDED = 4, TILT_GROUNDED = 0.03 or 0.24, or DEPTH = 0.1."""
    beam, source = ceramic
    x = beam.charges[0].x[-1] + np.array([3e-3, 6e-3])[:, None]
    y = np.array([-1.2e-3, 0.0, 1.2e-3])
    expected, found = beam.motion(x, y), replace(beam, source=source).motion(x, y)
    assert abs(found - expected).max() < 2e-4 * abs(expected).max()
    assert abs(found - expected)[2].max() < 1e-5 * abs(expected).max()


def test_artefacts_of_the_basis_that_grow_are_dropped(ceramic):
    """With vacuum above YZ lithium niobate one at 1.6 k grew by less than waves may, and more than doubled u_z."""
    source = ceramic[1]
    surface = source.wavenumber * source.section.length_unit
    k, ones = surface * np.array([0.9 + 0.01j, 1.6 + 0.01j, 1.0 - 1e-6j]), np.ones((source.reduced.basis.shape[1], 3))
    poles = source.select_poles(k, ones, ones[:4], np.ones(3), source.wavenumber, 0.02 * surface)
    np.testing.assert_allclose(poles.wavenumbers.real, source.wavenumber * np.array([0.9, 1.0]))


def test_stated_error_of_an_integral_that_ends_too_early(ceramic, monkeypatch):
    """Up to 2 % of the motion is missing; the error is understated twice with NARROWER = 0.9, or 0.6."""
    monkeypatch.setattr("fem.beam.cut_source.FADE", (0.5, 0.7))
    beam, source = ceramic
    x = beam.charges[0].x[-1] + np.array([1.5e-3, 3e-3, 6e-3])[:, None]
    y = np.array([-1.2e-3, 0.0, 1.2e-3])
    expected = beam.motion(x, y)
    found, stated = replace(beam, source=replace(source, known_poles={})).motion_and_error(x, y)
    off = abs(found - expected).max(axis=0) / abs(found[[0, 2]]).max(axis=0)
    assert off.max() > 0.01
    assert np.all(off < 1.5 * stated)


CUTS = {"128YX": ("LiNbO3 (Kovacs)", "128YX"), "YZ": ("LiNbO3 (Warner)", "YZ"), "ST-X": ("quartz (Bechmann)", "ST-X")}


@cache
def half_space(name):
    """The beam of one finger pair on a half-space, on a coarse discretisation: several tests ask it for its source."""
    return beam_in(lossless(*CUTS[name]), thickness=np.inf, length=14.0, pairs=1, order=5)


@cache
def thin_plate(name):
    """The beam of one finger pair on a plate."""
    return beam_in(lossless(*CUTS[name]), thickness=0.8, length=14.0, pairs=1)


def test_a_mode_missed_at_one_node_is_in_the_stated_error(monkeypatch):
    """Where half and a quarter of the nodes do not show an exponential convergence; halving the spacing mends it."""
    monkeypatch.setattr("fem.beam.beam_of_charges.MAX_HALVINGS", 0)
    beam = beam_in(lossless(*CUTS["YZ"]), thickness=0.8, length=14.0, pairs=1, order=5)
    beam = replace(beam, wave=replace(beam.wave, relative_error=0.0))
    place = beam.charges[0].x[-1] + 4e-3, 0.4e-3
    expected, unspoilt = beam.motion_and_error(*place)
    node, poles = list(beam.source.known_poles.items())[5]
    beam.source.known_poles[node] = poles._replace(column=np.where(poles.surface[:, None], 0.0, poles.column))
    found, stated = beam.motion_and_error(*place)
    off = abs(found - expected).max() / abs(found[[0, 2]]).max()
    assert unspoilt < off / 10
    assert off < 2 * stated


def test_a_finer_rule_takes_the_modes_of_the_coarser_one(ceramic):
    source = replace(ceramic[1], known_poles={})
    coarse, fine = (next(source.branches(0.5e-3, 0.0, 0.0, None, halvings)) for halvings in (0, 1))
    assert len(source.known_poles) == len(fine.rule.nodes) == 2 * len(coarse.rule.nodes) - 1
    assert np.array_equal(fine.rule.nodes[::2], coarse.rule.nodes)


def test_between_side_faces_the_field_is_repeated_across_the_width():
    """Of a plate: the images up to two widths away; farther ones change 2 % here, and with a third one 0.6 %.

    With the half of the basis that has the largest singular values the waves of a plate are wrong: 0.7 of the motion.
    """
    aperture, width = 9.6e-3, 14.4e-3  # 6 and 9 wavelengths
    beam = beam_in(cut(*CUTS["128YX"], quality=100.0), length=30.0, pairs=1, order=5, aperture=aperture)
    x, y = beam.charges[0].x[-1] + 16e-3, 0.4e-3
    between = beam.with_side_faces(width).motion(x, y)
    repeated = beam.motion(x, y + width * np.arange(-2, 3)).sum(axis=1)
    assert abs(between / beam.motion(x, y) - 1)[2] > 0.2
    assert abs(repeated - between).max() < 0.03 * abs(between).max()


@pytest.mark.parametrize("name", CUTS)
def test_response_of_the_reduced_basis(name):
    """Fields at the surface of loads there, at wave vectors of its own disc, against the whole section."""
    source = half_space(name).source
    whole, surface = (
        LateralPolynomials.of(source.section, source.frequency, source.wavenumber),
        surface_unknowns(source.section),
    )
    loads = np.eye(source.section.size)[:, surface]
    for along, lateral in ((0.93, 0.2), (-0.4, 0.7), (0.1, 0.03)):
        k = source.wavenumber * np.array([along * source.section.length_unit, lateral]) * (1 + 0.07j)
        expected = np.linalg.solve(whole.operator(*k), loads)[surface]
        off = abs(source.reduced.response(*k) - expected).max(axis=0) / abs(expected).max(axis=0)
        assert off.max() < 1e-3


def test_stated_error_of_the_basis():
    """At 60 wave vectors of waves the basis errs by 8e-6 at most; 2e-6 was stated from 5 trials of all SIZES."""
    source = half_space("128YX").source
    whole, surface = (
        LateralPolynomials.of(source.section, source.frequency, source.wavenumber),
        surface_unknowns(source.section),
    )
    loads, errors = np.eye(source.section.size)[:, surface], []
    for size, angle in np.random.default_rng(1).uniform([0.35, 0], [1.2, np.pi], (60, 2)):
        k = size * source.wavenumber * np.exp(1j * BASIS_ANGLE) * np.array([np.cos(angle), np.sin(angle)])
        k[0] *= source.section.length_unit
        expected = np.linalg.solve(whole.operator(*k), loads)[surface]
        off = abs(source.reduced.response(*k) - expected).max(axis=0) / abs(expected).max(axis=0)
        errors.append(off.max())
    assert max(errors) < source.error < 10 * max(errors)


def test_basis_of_the_skimming_waves():
    """Waves of 111 fingers on a half-space, 14 mm behind them, by the reduced and by the whole section.

    At the smallest k_y u_y is 1.8e-4 off with 10 directions and SINGULAR[0] = 1e-4, 4e-5 with 10 directions alone, and
    7e-4 or more with BASIS_ANGLE = 0.05.
    """
    beam = half_space("YZ")
    section, wavenumber = beam.source.section, beam.source.wavenumber
    matrices = LateralPolynomials.of(section, beam.source.frequency, wavenumber)
    unit = np.eye(section.size)
    opposite = beam.source.reduced.opposite
    whole = LateralSection(unit, matrices, unit[surface_unknowns(section)], None, opposite, 0.0)
    signs, distances = (-1.0) ** np.arange(111), 14e-3 + np.arange(111) * np.pi / wavenumber

    def arriving(source):
        """Motion for three k_y, shape (3, 3)."""
        for modes in source.poles_at(np.array([0.05, 0.12, 0.2]) * wavenumber):
            k = modes.wavenumbers[modes.right]
            yield np.exp(-1j * np.outer(k, distances)) @ signs @ modes.column[modes.right]

    exact = np.array([*arriving(replace(beam.source, reduced=whole, known_poles={}))])
    off = abs(np.array([*arriving(beam.source)]) - exact) / abs(exact[0, 2])
    assert off[0, 1] < 2.5e-5
    assert off.max() < 1e-4


def test_response_of_the_half_space():
    """By Stroh's problem at wave vectors within the disc.

    At small wave vectors it is 9e-5 and more off with LAYER = 2, at the others 7e-7 with SINGULAR[0] = 1e-4.
    """
    solid = lossless(*CUTS["128YX"])
    source = half_space("128YX").source
    field = HalfSpaceField(**constants(solid), frequency=source.frequency)
    turn = 1 + 0.07j
    vectors = source.wavenumber * turn * np.array([(0.93, 0.2), (-0.4, 0.7), (0.5, 0.0), (0.1, 0.03), (0.01, 0.3)])
    expected = abs(field.response(*vectors.T, turn))
    unit = source.section.length_unit
    found = abs(np.array([source.reduced.response(along * unit, lateral) for along, lateral in vectors]))
    found, expected = (each / each[:, 2:3, 2:3] for each in (found, expected))  # units differ by a factor
    off = (abs(found - expected) / expected.max(axis=1, keepdims=True)).max(axis=(1, 2))
    assert off[:3].max() < 4e-7
    assert off.max() < 1e-5


@pytest.mark.parametrize("name", CUTS)
def test_modes_without_lateral_wavenumber_are_the_section(name):
    beam = thin_plate(name)
    edges = beam.charges[0].x[[0, -1]]
    x = np.array([edges[0] - 2e-3, edges[1] + 1.5e-3, edges[1] + 4e-3])
    assert abs(beam.motion_beyond_modes(x)).max() < 5e-3 * abs(beam.wave.motion(x)).max()


def test_modes_of_the_reduced_basis_do_not_grow():
    """On 128YX the modes of backward bulk waves grew without `MAX_REFINEMENTS`; 2e-3 of the motion was lost."""
    beam = beam_in(lossless(*CUTS["128YX"]), thickness=np.inf, length=30.0)
    x = beam.charges[0].x[-1] + np.array([3e-3, 6e-3, 12e-3])
    assert abs(beam.motion_beyond_modes(x)).max() < 4e-4 * abs(beam.wave.motion(x)).max()


def test_places_beside_the_fingers_are_not_resolved():
    """In cuts whose waves at more than 45 degrees are left out; in a ceramic poled along z they are known."""
    beam = beam_in(lossless(*CUTS["YZ"]), thickness=0.8, length=14.0, pairs=1, order=5)
    (one,), near, side = beam.solution.fields.transducers, abs(beam.wavelength), 2.5e-3
    assert beam.unresolved(one.center, side + 3 * near)
    assert beam.unresolved(one.extent[1] + 0.9 * near, -side + 0.9 * near)
    assert not beam.unresolved(one.extent[1] + 1.1 * near, side)
    assert not beam.unresolved(one.center, side - 1.1 * near)


def test_constant_potential_leaves_no_motion():
    """k_y in the place of 0 makes u_x of the pole at k = 0 as small as itself."""
    beam = beam_in(cut("PZT-8", "Z", quality=60.0), thickness=0.8, length=14.0, pairs=1)
    solved = replace(beam, source=cut_source(beam.wave.solution.fields))
    x = beam.charges[0].x[-1] + np.array([2e-3, 4e-3])
    assert abs(solved.motion_beyond_modes(x)).max() < 3e-5 * abs(beam.wave.motion(x)).max()


@pytest.mark.parametrize("name", CUTS)
def test_reciprocity_gives_the_opposite_lateral_wavenumber(name):
    """Residues at -k_y, and those that the transposed response at k_y has, are solved for apart."""
    source = thin_plate(name).source
    k_y = (0.2 + 0.03j) * source.wavenumber
    (here,), (there,) = (source.poles_at(np.array([sign * k_y])) for sign in (1, -1))
    for mode in np.flatnonzero(here.surface):
        other = np.argmin(abs(there.wavenumbers + here.wavenumbers[mode]))
        assert there.wavenumbers[other] == pytest.approx(-here.wavenumbers[mode], rel=1e-6)
        scale = abs(there.column[other]).max()
        np.testing.assert_allclose(there.column[other], -here.transposed[mode], atol=1e-4 * scale)


@pytest.mark.parametrize(("name", "gamma"), [("128YX", -0.34), ("YZ", -1.10), ("ST-X", 0.378)])
def test_slowness_curvature_is_the_published_one(name, gamma):
    """Of the free surface: slowness surfaces of surface waves in tables, to the spread of the constants."""
    beam = half_space(name)
    k = beam.surface_wavenumbers(0.0).real
    step = 0.02 * k
    before, after = beam.surface_wavenumbers(np.array([-step, step])).real
    found = -k * (before + after - 2 * k) / step**2 - 1
    assert found == pytest.approx(gamma, abs=0.02)


def test_slowness_curve_passes_smoothly_through_the_axis():
    """A generic cut, whose power flows at an angle: the curve at -k_y is that of the waves to the other side."""
    beam = beam_in(lossless("LiNbO3 (Kovacs)", (10.0, 38.0, 15.0)), thickness=np.inf, length=14.0, pairs=1, order=5)
    step = 0.01 * beam.source.wavenumber
    before, here, after, further = beam.surface_wavenumbers(step * np.arange(-1, 3)).real
    slope = (after - before) / (2 * step)
    assert abs(slope) > 0.02
    assert (4 * after - 3 * here - further) / (2 * step) == pytest.approx(slope, abs=0.05 * slope)


def fresnel_profile(k: float, distance: float, aperture: float, y: np.ndarray) -> np.ndarray:
    scale = np.sqrt(k / (np.pi * distance))
    below, above = (np.array(fresnel(scale * (edge - y))) for edge in (-aperture / 2, aperture / 2))
    return np.hypot(*(above - below)) / np.sqrt(2)


@pytest.mark.slow
def test_parabolic_formula(monkeypatch):
    """Fresnel's integral at 1 + gamma times the distance, the slowness curvature gamma = -0.34 of 128YX.

    The formula holds for angles of a few hundredths only: a wide aperture far away, without the waves beyond 9 degrees.
    """
    monkeypatch.setattr("fem.beam.cut_source.FADE", (0.12, 0.2))
    aperture, distance = 100e-3, 3.0
    solid = lossless("LiNbO3 (Kovacs)", "128YX")
    beam = beam_in(solid, thickness=np.inf, aperture=aperture, length=2000.0, pairs=1, order=5)
    k_y = np.array([0.0, 0.015, 0.03]) * beam.source.wavenumber
    along = [each.wavenumbers[each.right & each.surface][0].real for each in beam.source.poles_at(k_y)]
    gamma = -2 * (along[2] - along[0]) * along[0] / k_y[2] ** 2 - 1
    assert gamma == pytest.approx(-0.34, abs=0.02)
    y = np.linspace(0, 0.7, 15) * aperture
    x = beam.charges[0].x.mean() + distance
    found = abs(beam.surface_mode.motion(x, y)[2] / beam.wave.rayleigh_motion(x)[1])
    expected = fresnel_profile(along[0], distance * (1 + gamma), aperture, y)
    np.testing.assert_allclose(found, expected, atol=0.01 * expected.max())
    assert abs(found - fresnel_profile(along[0], distance, aperture, y)).max() > 0.1
