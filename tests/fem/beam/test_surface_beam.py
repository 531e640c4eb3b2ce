"""Field of a finite aperture: against the exact plate response, the section, the far field and the power balance."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import hankel2

from fem.beam.beam_of_charges import AT_POINTS, IN_PICTURES, EmittedBeam
from fem.beam.beam_of_section import aperture_beam, surface_beam
from fem.beam.electrode_charges import electrode_charges
from fem.beam.own_aperture import STEPS
from fem.beam.reception import with_apertures
from fem.beam.surface_beam import BeamError
from fem.discretize.mesh_refinement import LEVELS
from fem.results.stator_solution import driven_solution
from fem.solve.driven_stator import solve_driven
from fem.waveguide.guided_modes import power
from tests.fem.stators import FREQUENCY, comb, constants, cut, lossless, plate, solution, wave_of
from tests.oracles.fem_plate_beam import plate_beam
from tests.oracles.fem_plate_response import PlateResponse


def beam_of(solid, *, length=30.0, thickness=1.3, order=7, layers=1, aperture=5e-3, **rest):
    stator = plate(solid, length=length, thickness=thickness, **rest)
    left = comb(stator, "a", 6.0, finger_pairs=3, aperture=aperture)
    return surface_beam(wave_of(solution(stator, (left,), order=order, layers=layers)))


def section_charges(beam):
    """A beam of the charges that the section has: without what finite apertures change in them."""
    whole = tuple(electrode_charges(beam.wave.solution, index) for index in range(len(beam.charges)))
    return replace(beam, charges=whole)


@pytest.fixture(scope="module")
def lossy():
    return beam_of(cut("PZT-8", "Z", quality=60.0))


@pytest.mark.parametrize(
    "bottom", ["free", *(pytest.param(each, marks=pytest.mark.slow) for each in ("grounded", "clamped"))]
)
def test_infinite_aperture_is_the_section(bottom):
    """Charges, line source and modes at k_y = 0 on both sides, next to the fingers and far away."""
    beam = section_charges(beam_of(cut("PZT-8", "Z", quality=60.0), bottom=bottom, aperture=0.5, layers=0))
    edges = beam.charges[0].x[[0, -1]]
    first, second = (beam.charges[0].x[beam.charges[0].finger == number] for number in (2, 3))
    between = 0.5 * (first[-1] + second[0])
    x = np.array([edges[0] - 3e-3, edges[0] - 1e-3, between, edges[1] + 1e-3, edges[1] + 8e-3])
    section = beam.wave.motion(x)
    tangential, _, normal = beam.motion(x)
    np.testing.assert_allclose(normal, section[1], atol=1e-8 * abs(section).max())
    # what is left of u_x is the pole at k = 0, whose field falls as 1 / W
    left = abs(tangential - section[0])
    assert left.max() < 5e-3 * abs(section).max()
    wider = replace(beam, apertures=(1.0,)).motion(x)[0]
    np.testing.assert_allclose(abs(wider - section[0]), left / 2, rtol=1e-3, atol=3e-8 * abs(section).max())


def test_the_two_surface_waves_of_a_thick_plate():
    """One part in 1e8 apart, so that the eigensolver mixes them by 1e-4: together they are the section's wave."""
    beam = beam_of(cut("PZT-8", "Z"), thickness=5.5, order=8, layers=3)
    x = beam.charges[0].x[-1] + np.array([5e-3, 8e-3])
    twins = beam.source.wavenumbers[beam.source.surface].real
    assert 0 < np.ptp(twins) < 1e-7 * twins[0]
    assert abs(beam.motion_beyond_modes(x)).max() < 1e-7 * abs(beam.wave.motion(x)).max()


def test_two_transducers_add_up_to_the_section():
    """Massless fingers scatter by their charges alone: before, between and behind them, with the second one shorted."""
    stator = plate(cut("PZT-8", "Z", quality=60.0), length=24.0, thickness=1.3, bottom="grounded")
    pair = (
        comb(stator, "a", 6.0, aperture=1.0),
        comb(stator, "b", 14.0, finger_pairs=2, period=0.9, aperture=1.0, termination="short"),
    )
    beam = section_charges(surface_beam(wave_of(solution(stator, pair, order=7))))
    first, second = (each.x[[0, -1]] for each in beam.charges)
    x = np.array([first[0] - 2e-3, first[1] + 1e-3, second[0] - 1e-3, second[1] + 2e-3])
    section = beam.wave.motion(x)
    np.testing.assert_allclose(beam.motion(x)[[0, 2]], section, atol=1e-7 * abs(section).max())
    alone = replace(beam, charges=beam.charges[:1], apertures=(1.0,), centers=(0.0,)).motion(x)
    assert abs(alone[2] - section[1]).max() > 1e-3 * abs(section).max()


def test_charges_give_the_admittance():
    wave = wave_of(solution(plate(cut("PZT-8", "Z")), (comb(plate(cut("PZT-8", "Z")), "a", 2.0),)))
    charges = electrode_charges(wave.solution, 0)
    positive = charges.charge[charges.finger == 1].sum()
    assert 2j * np.pi * FREQUENCY * 0.02 * positive == pytest.approx(wave.admittance, rel=1e-10)
    assert abs(charges.charge.sum()) < 1e-10 * abs(positive)


def test_exact_plate_response_over_the_plane_of_wave_vectors(lossy):
    solid = lossy.wave.solution.fields.stator.solid
    exact = PlateResponse(
        **constants(solid), thickness=lossy.wave.solution.fields.stator.thickness, frequency=FREQUENCY
    )
    lossy = section_charges(lossy)
    charges = lossy.charges[0]
    propagating = lossy.source.wavenumbers[lossy.source.wavenumbers.imag > -2000]
    edge = charges.x[-1]
    points = np.array([[edge + along, y] for along in (4e-3, 9e-3) for y in (0.0, 1.1e-3, 2.2e-3, 3.5e-3)])
    middle = charges.x.mean()
    expected = plate_beam(
        exact.surface,
        float(abs(propagating.real).max()),
        charges.x - middle,
        charges.charge,
        lossy.apertures[0],
        points - [middle, 0.0],
    )
    found = lossy.motion(*points.T)
    assert abs(found - expected).max() < 1e-4 * abs(expected).max()


def test_mirror_images(lossy):
    """u_x and u_z are even in y and u_y odd; x -> -x turns the comb into its negative."""
    edges = lossy.charges[0].x[[0, -1]]
    right = lossy.motion(edges[1] + 3e-3, np.array([1.7e-3, -1.7e-3]))
    np.testing.assert_allclose(right[:, 1], right[:, 0] * [1, -1, 1], rtol=1e-12)
    left = lossy.motion(edges[0] - 3e-3, 1.7e-3)
    np.testing.assert_allclose(left, right[:, 0] * [1, -1, -1], rtol=1e-7)


def test_far_field_follows_the_aperture():
    """At 0.2 m the surface wave alone is left; over the angle it is W sinc(k W sin / 2) T(k cos) over the axis's."""
    beam = section_charges(beam_of(lossless("PZT-8", "Z"), thickness=np.inf, aperture=3e-3, length=600.0))
    surface = beam.wave.solution.fields.modes.rayleigh[0]
    k = float(beam.wave.solution.fields.modes.wavenumbers[surface].real) / beam.wave.solution.fields.section.length_unit
    charges = beam.charges[0].sheets(3e-3, 0.0)[0]
    middle = 0.5 * (charges.x[0] + charges.x[-1])
    angles = np.radians([0.0, 3.0, 6.0, 9.0, 14.0])
    distance = 0.2
    normal = beam.motion(middle + distance * np.cos(angles), distance * np.sin(angles))[2]
    expected = np.sinc(k * np.sin(angles) * 3e-3 / (2 * np.pi)) * charges.transform(k * np.cos(angles), middle)
    np.testing.assert_allclose(abs(normal / normal[0]), abs(expected / expected[0]), atol=1e-3)


def test_error_estimate_covers_the_rule(lossy, monkeypatch):
    points = lossy.charges[0].x[-1] + np.array([1e-3, 5e-3, 12e-3]), np.array([0.0, 2e-3, 6e-3])
    stated = replace(lossy, wave=replace(lossy.wave, relative_error=0.0)).relative_error(*points)
    before = lossy.motion(*points)
    monkeypatch.setattr("fem.beam.lateral.SPACING", 0.1)
    after = lossy.motion(*points)
    assert np.all(stated < 1e-5)
    assert np.all(abs(after - before).max(axis=0) <= np.maximum(stated, 1e-12) * abs(after).max(axis=0))


def test_the_section_s_error_is_relative_to_half_of_its_amplitude_where_the_beam_is_weak(lossy):
    """On the axis the error is the section's own, and outside the beam that of half the section's amplitude."""
    x, y = lossy.charges[0].x[-1] + 5e-3, np.array([0.0, 6e-3])
    none, some = (
        replace(lossy, wave=replace(lossy.wave, relative_error=error)).relative_error(x, y) for error in (0.0, 1e-3)
    )
    amplitude = abs(lossy.wave.motion(x)).max() / abs(lossy.motion(x, y)[[0, 2]]).max(axis=0)
    assert amplitude[0] < 2.0 < 4.0 < amplitude[1]
    np.testing.assert_allclose((some - none) / 1e-3, [1.0, 0.5 * amplitude[1]], rtol=1e-9)


def test_nodes_in_k_y_are_added_until_the_motion_is_resolved(lossy, monkeypatch):
    points = lossy.charges[0].x[-1] + np.array([2e-3, 12e-3]), np.array([0.0, 6e-3])
    before = lossy.motion(*points)
    monkeypatch.setattr("fem.beam.lateral.SPACING", 2.5)
    after = lossy.motion(*points)
    assert abs(after - before).max() < 1e-3 * abs(before).max()
    monkeypatch.setattr("fem.beam.beam_of_charges.MAX_HALVINGS", 0)
    assert abs(lossy.motion(*points) - before).max() > 1e-2 * abs(before).max()


@pytest.mark.slow
def test_between_and_under_the_fingers():
    """With a wide aperture the field of the charges is the section's there too."""
    stator = plate(cut("PZT-8", "Z", quality=60.0), length=24.0, thickness=1.3, bottom="grounded")
    pair = (
        comb(stator, "a", 6.0, finger_pairs=2, aperture=1.0),
        comb(stator, "b", 14.0, aperture=0.5, termination="short"),
    )
    beam = section_charges(surface_beam(wave_of(solution(stator, pair, order=8, layers=2))))
    fingers = [beam.charges[0].x[beam.charges[0].finger == number] for number in (2, 3)]
    x = np.array([0.5 * (fingers[0][-1] + fingers[1][0]), fingers[1].mean(), beam.charges[1].x.mean()])
    section = beam.wave.motion(x)
    np.testing.assert_allclose(beam.motion(x)[[0, 2]], section, atol=1e-7 * abs(section).max())


@pytest.mark.parametrize("width", [None, pytest.param(7e-3, marks=pytest.mark.slow)])
def test_surface_mode_is_a_sum_of_hankel_functions(lossy, width):
    """The transform of k exp(-i kappa x) / kappa is k H0(k r) / 2: charges and images in both side faces."""
    mode = section_charges(surface_beam(lossy.wave, mirror_width=width)).surface_mode
    charges, source = mode.charges[0], mode.source
    nodes, weights = (each * lossy.apertures[0] / 2 for each in np.polynomial.legendre.leggauss(80))
    images = np.arange(-35, 36) * width if width else [0.0]
    x = np.array([charges.x[-1] + 5e-3, charges.x[0] - 2e-3, charges.x[len(charges.x) // 3] + 0.1e-3])
    y = np.array([0.4e-3, 3.3e-3, 3.3e-3])
    expected = np.zeros(3, dtype=complex)
    for k, normal in zip(source.wavenumbers, source.normal, strict=True):
        for image in images:
            lateral = y[:, None, None] - image - nodes
            distance = np.hypot(x[:, None, None] - charges.x[:, None], lateral)
            expected += normal * k / 2 * (charges.charge @ hankel2(0, k * distance) @ weights)
    found = mode.motion(x, y)[2]
    limits = np.array([1e-7, 1e-7, 1e-3])  # the last under a finger, less than a wavelength from its end
    assert np.all(abs(found - expected) < limits * abs(expected).max())


def test_refusals(lossy):
    with pytest.raises(BeamError, match="must lie on the stator, 0 to"):
        lossy.motion(-1e-3)
    with pytest.raises(BeamError, match=r"between the side faces, \+-0.004 m"):
        surface_beam(lossy.wave, mirror_width=8e-3).motion(1e-3, 5e-3)
    with pytest.raises(BeamError, match=r"at least the largest aperture, 0\.005 m, got 0\.004"):
        surface_beam(lossy.wave, mirror_width=4e-3)
    with pytest.raises(BeamError, match="ends = 'absorbing', got 'free'"):
        beam_of(cut("LiNbO3 (Kovacs)", "128YX"), ends="free", thickness=0.8, order=5, layers=0)


def power_of_planes(beam):
    """Power of one transducer's propagating modes in 3-D, and in the section of charges uniform along y, per V^2."""
    modes, aperture = beam.wave.solution.fields.modes, beam.apertures[0]
    per_mode = power(modes.right, modes.right_flux, FREQUENCY)[modes.wavenumbers != 0]
    per_mode = per_mode * modes.section.solid.stress_unit * abs(beam.source.amplitudes) ** 2
    k = beam.source.wavenumbers
    charges, origin = beam.charges[0], float(beam.charges[0].x.mean())
    uniform = charges.sheets(aperture, 0.0)[0]
    angles, weights = (np.pi / 2 * each for each in np.polynomial.legendre.leggauss(300))
    section = total = 0.0
    for mode in np.flatnonzero(abs(k.imag) < 1e-9 * abs(k)):
        along, lateral = k[mode].real * np.cos(angles), k[mode].real * np.sin(angles)
        for side in (1, -1):
            section += aperture * per_mode[mode] * abs(uniform.transform(side * k[mode], origin)) ** 2
            sent = charges.plane_transform(np.array([side * along, lateral]), aperture, origin)
            share = abs(k[mode].real) / (2 * np.pi) * abs(sent) ** 2  # k/kappa from 1/kappa^2, kappa and dk_y
            total += per_mode[mode] * np.sum(weights * share)
    return total, section


def test_power_through_planes():
    """Without loss: what the port takes in, of the beam as of the section, though their charges differ."""
    beam = beam_of(lossless("PZT-8", "Z"), thickness=2.3)
    _, section = power_of_planes(section_charges(beam))
    assert section == pytest.approx(beam.wave.solution.circuit.power, rel=1e-8)
    total, _ = power_of_planes(beam)
    assert total == pytest.approx(beam.circuit.power, rel=2e-3)
    assert abs(total / section - 1) > 5e-3
    fields = with_apertures(beam.wave.solution.fields, fineness=len(STEPS))  # charges uniform along y
    uniform = aperture_beam(beam.wave, driven_solution(fields, "a"))
    total, of_charges = power_of_planes(uniform)
    assert total == pytest.approx(uniform.circuit.power, rel=1e-4)
    assert abs(total / of_charges - 1) > 0.05


def test_the_section_s_error_is_relative_to_half_its_amplitude_at_least():
    """Where the beam is weaker than half of the section, the section's error counts more; off the axis as on it."""
    stator = plate(cut("PZT-8", "Z", quality=60.0), length=24.0, thickness=1.3)
    beam = surface_beam(wave_of(solution(stator, (comb(stator, "a", 6.0, aperture=3e-3),))))
    x, y = 0.7 * stator.length, np.array([0.0, 4e-3])
    without, given = (replace(beam, wave=replace(beam.wave, relative_error=each)) for each in (0.0, 1e-3))
    size, section = abs(beam.motion(x, y)[[0, 2]]).max(axis=0), abs(beam.wave.motion(x)).max()
    added = given.relative_error(x, y) - without.relative_error(x, y)
    assert added == pytest.approx(1e-3 * np.maximum(size, 0.5 * section) / size, rel=1e-6)
    assert added[1] > 1.02 * added[0]


def test_a_driven_transducer_near_a_zero_of_its_response_converges_as_the_section_does():
    """The charges of its fingers nearly cancel in the surface wave; each sheet has its own profile across a finger."""
    solid = cut("PZT-5H", "Z")
    stator = plate(solid, length=59.0, thickness=1.43, frequency=11.11e6, bottom="clamped")
    one = comb(
        stator, "a", 11.6, frequency=11.11e6, finger_pairs=12, metallisation=0.664, aperture=3.66e-3, termination="open"
    )
    x, found = stator.length * np.array([0.4, 0.52, 0.6]), []
    for level in LEVELS[1:3]:
        wave = wave_of(solve_driven(stator, (one,), frequency=11.11e6, drive="a", resolution=level))
        found.append((wave.motion(x)[1], surface_beam(wave).motion(x)[2]))
    (section, beam), (finer_section, finer_beam) = found
    assert np.all(abs(section - finer_section) < 6e-4 * abs(finer_section))
    assert np.all(abs(beam - finer_beam) < 8e-4 * abs(finer_beam))


@pytest.mark.parametrize(("pictured", "halvings"), [(False, 3), (True, 1)])
def test_a_picture_takes_a_coarser_rule(lossy, monkeypatch, pictured, halvings):
    """Differences of two rules as on the shipped motor of YZ lithium niobate: 0.40, 0.084, 0.035, 0.018."""
    taken = []

    def modal(self, x, y, distance, number):
        taken.append(number)
        return np.multiply.outer([1.0, 1.0 + (0.4, 0.084, 0.035, 0.018)[number], 1.0, 1.0], np.ones((3, len(x))))

    monkeypatch.setattr(EmittedBeam, "modal", modal)
    (lossy.pictured if pictured else lossy).motion(0.8 * lossy.wave.length)
    assert taken == list(range(halvings + 1))


def test_in_a_picture_the_largest_motion_is_the_scale():
    """Two rules differ by 0.05 everywhere: a twentieth of the largest motion, a half of the least one."""
    fine = np.array([[1.0, 0.1], [0.0, 0.0], [0.0, 0.0]])
    for agreement, difference, agrees in (
        (IN_PICTURES, 0.05, True),
        (IN_PICTURES, 0.11, False),
        (AT_POINTS, 0.05, False),
    ):
        assert agreement.reached(fine, fine + difference) == agrees
    assert AT_POINTS.reached(fine, fine + 0.0029)
