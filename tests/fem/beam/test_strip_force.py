"""Forces on strips of the surface: Lamb's problem, Gamma, rotated modes, Maxwell-Betti, currents into transducers."""

from dataclasses import replace

import numpy as np
import pytest

from fem.analytic.wave_compliance import wave_compliance
from fem.beam.beam_of_charges import Strip
from fem.beam.beam_of_section import surface_beam
from fem.beam.cut_source import cut_source
from fem.beam.electrode_charges import all_charges, electrode_charges
from fem.beam.reception import aperture_coupling, with_apertures
from fem.beam.surface_beam import BeamError
from fem.discretize.mesh_refinement import LEVELS
from fem.exceptions import InputError
from fem.geometry import Stator
from fem.materials import isotropic
from fem.results.stator_solution import driven_solution
from fem.solve.forced_surface import forced_wave
from fem.waveguide.line_force import LineForce
from fem.waveguide.port_fields import stator_cascade
from tests.fem.stators import FREQUENCY, comb, cut, lossless, plate, wave_of
from tests.frozen import frozen
from tests.oracles.fem_point_force import point_force

GLASS = isotropic(name="glass", density=2500.0, youngs_modulus=70e9, poisson_ratio=0.25)


def forced(stator, force, transducers=(), *, level=LEVELS[1], drive=None, **options):
    """Beam of one force on one discretisation, whose error is taken for zero."""
    row = stator_cascade(stator, transducers, frequency=FREQUENCY, resolution=level, forces=(force,))
    wave = wave_of(driven_solution(row.solved(), drive, np.array([force.amplitude])))
    return surface_beam(replace(wave, relative_error=0.0), **options)


def strip(stator, place, **options):
    """Force at a place in wavelengths of the slowest bulk wave."""
    unit = plate(stator.solid, length=1.0).length
    return LineForce(name="f", position=place * unit, **({"width": 1e-3} | options))


COMPONENTS, WIDTHS = ("z", "x"), (2e-3, 1e-4)
STRIP_X, STRIP_Y = 10e-3, 0.5e-3  # centre of the strip, m
PLACES = np.array([12e-3, 13e-3, 8e-3, 20e-3, 30e-3]), np.array([1e-3, 4e-3, -1e-3, 5e-3, 0.5e-3])  # x and y, m


# Oracle: closed-form response, integrated over the wavenumber and over the strip
@frozen([(component, width) for component in COMPONENTS for width in WIDTHS])
def lambs_strip(component, width):
    """Motion of glass at the places, u_x, u_y and u_z in m, under 1 N on a strip of a width in m at 2 MHz."""
    shear, (x, y) = 70e9 / 2.5, PLACES
    wavenumber = 2 * np.pi * 2e6 * np.sqrt(2500.0 / shear)
    s, weights = np.polynomial.legendre.leggauss(3 if width < 1e-3 else 8)
    expected = np.zeros((3, len(x)), dtype=complex)
    for at, share in zip(STRIP_Y + width / 2 * s, weights / 2, strict=True):
        for number, (dx, dy) in enumerate(zip(x - STRIP_X, y - at, strict=True)):
            u_z, u_x, u_y = point_force(shear, 0.25, wavenumber, np.hypot(dx, dy), np.arctan2(dy, dx))
            expected[:, number] += share * np.array((0, 0, u_z) if component == "z" else (u_x, u_y, 0))
    return expected


@pytest.mark.parametrize("component", COMPONENTS)
@pytest.mark.parametrize("width", WIDTHS)
def test_a_strip_on_glass_is_lambs_problem(component, width):
    """SH waves and wide angles included."""
    block = Stator(solid=GLASS, length=40e-3, thickness=float("inf"), ends="absorbing")
    force = LineForce(
        name="f", position=STRIP_X, component=component, amplitude=1 / width, width=width, center_y=STRIP_Y
    )
    wave = forced_wave(block, (), (force,), frequency=2e6, tolerance=1e-3, places=(30e-3,))
    found, error = surface_beam(wave).motion_and_error(*PLACES)
    known = [2] if component == "z" else [0, 1]
    apart = abs(found - lambs_strip(component, width))[known].max(axis=0) / abs(found[[0, 2]]).max(axis=0)
    assert np.all(apart < 1e-4)
    assert np.all(apart < 1.2 * error)


def test_a_point_force_sends_gamma_as_one_over_root_distance():
    """|u_z| = Gamma F (k / 2 pi r)^(1/2), Gamma from the surface impedance."""
    block = Stator(solid=GLASS, length=90e-3, thickness=float("inf"), ends="absorbing")
    force = LineForce(name="f", position=5e-3, amplitude=1e4, width=1e-4)
    beam = forced(block, force, level=LEVELS[2])
    r = np.array([20e-3, 40e-3, 80e-3])
    wavenumber = 2 * np.pi * FREQUENCY / beam.wave.phase_velocity
    expected = wave_compliance(GLASS, "open") * np.sqrt(wavenumber / (2 * np.pi * r))
    # the next term of the Hankel function is 1/(8 k r)^2
    assert abs(beam.surface_mode.motion(5e-3 + r)[2]) == pytest.approx(expected, rel=3e-5)
    assert abs(beam.motion(85e-3)[2]) == pytest.approx(expected[-1], rel=1.5e-3)  # the bulk waves have decayed


@pytest.mark.parametrize(
    ("name", "orientation"), [("PZT-8", "Z"), ("LiNbO3 (Kovacs)", "128YX"), ("quartz (Bechmann)", "ST-X")]
)
def test_the_mean_of_a_beam_between_mirrors_is_gamma(name, orientation):
    """The part at k_y = 0 of a narrow strip's waves, by the mean over the distance of the mirrors: three cuts."""
    solid, width = lossless(name, orientation), 6e-3
    stator = replace(plate(solid, length=20.0), thickness=np.inf)
    beam = forced(stator, strip(stator, 5.0, amplitude=1e3), level=LEVELS[2], mirror_width=width)
    y = (np.arange(64) / 64 - 0.5) * width
    mean = beam.surface_mode.motion(stator.length * 0.8, y)[2].mean()
    assert abs(mean) * width == pytest.approx(wave_compliance(solid, "open"), rel=1e-6, abs=0)


def test_forces_along_x_send_sh_waves_and_the_static_field():
    """Rotated modes against the modes solved at every k_y, in a plate without ground: u_x lacks 2e-3 without S."""
    stator = plate(cut("PZT-8", "Z", quality=60.0), length=30.0, thickness=1.3)
    beam = forced(stator, strip(stator, 15.0, component="x"))
    source = cut_source(beam.wave.solution.fields).loaded("x")
    other = replace(beam, source=source, strips=(Strip(beam.strips[0].sheet, source),))
    unit = stator.length / 30.0
    x, y = np.array([20.0, 22.0, 12.0, 26.0]) * unit, np.array([-1e-3, 2e-3, 1e-3, -2.5e-3])
    expected, found = other.motion(x, y), beam.motion(x, y)
    assert np.all(abs(found - expected).max(axis=0) < 7e-4 * abs(expected).max(axis=0))
    static = beam.strips[0].source.static
    without = replace(beam, strips=(Strip(beam.strips[0].sheet, replace(beam.strips[0].source, static=-static)),))
    assert abs(without.motion(x, y) - expected)[0].max() > 2e-3 * abs(expected).max()


@pytest.mark.parametrize(
    ("name", "orientation", "tolerance"), [("PZT-8", "Z", 1e-8), ("LiNbO3 (Kovacs)", "128YX", 1e-5)]
)
def test_two_strips_answer_each_other(name, orientation, tolerance):
    """Maxwell-Betti between means over strips at different y: u_x by a normal force is u_z by one along x."""
    stator = plate(cut(name, orientation, quality=100.0), length=20.0, thickness=1.3)
    s, weights = np.polynomial.legendre.leggauss(30)
    one = strip(stator, 5.0, component="z", center_y=0.4e-3)
    other = strip(stator, 14.0, component="x", width=2e-3, center_y=-0.7e-3)

    def mean(by, at):
        motion = forced(stator, by).motion(at.position, at.center_y + at.width / 2 * s)
        return weights @ motion["xyz".index(at.component)] / 2 * at.width

    there, back = mean(one, other), mean(other, one)
    assert abs(there - back) < tolerance * abs(there)


def test_a_wide_strip_beside_wide_transducers_is_the_section():
    """Fingers and a strip of 100 wavelengths: motion and current per width of the same line force in the section."""
    stator = plate(cut("PZT-8", "Z", quality=60.0), length=24.0, thickness=1.3)
    row = tuple(
        comb(stator, name, place, finger_pairs=2, aperture=0.1, termination=termination)
        for name, place, termination in (("a", 5.0, "short"), ("b", 19.0, 1.0))
    )
    beam = forced(stator, strip(stator, 12.0, width=0.1), row)
    x = np.array([9.0, 14.0]) * stator.length / 24.0
    section = beam.wave.motion(x)
    assert abs(beam.motion(x)[[0, 2]] - section).max() < 0.02 * abs(section).max()
    assert beam.circuit.currents == pytest.approx(beam.wave.circuit.currents, rel=0.02)
    assert beam.scattering_error < 1e-3


@pytest.mark.parametrize(
    ("orientation", "name", "largest", "fingers"),
    [
        ("Z", "PZT-8", 0.01, {}),
        ("128YX", "LiNbO3 (Kovacs)", 0.05, {}),
        ("Z", "PZT-8", 0.01, {"cell": "DART"}),
        ("Z", "PZT-8", 0.01, {"chirp": 0.4}),
    ],
)
def test_a_transducer_receives_what_it_sends_to_the_strip(orientation, name, largest, fingers):
    """The charges that the strip's waves induce, summed, against the velocity of the transducer's own beam there.

    They share the modes; the first comes from the response to arriving waves, the second from the beam per volt.
    """
    solid = cut(name, orientation, quality=100.0)
    stator = replace(plate(solid, length=40.0), thickness=np.inf)
    row = (comb(stator, "a", 8.0, finger_pairs=2, aperture=4e-3, termination="short", **fingers),)
    force = strip(stator, 25.0, center_y=0.5e-3)
    beam = forced(stator, force, row)
    assert 0 < beam.scattering_error < largest
    assert 0 < beam.received_error < 1e-4
    row_alone = stator_cascade(stator, row, frequency=FREQUENCY, resolution=LEVELS[1])
    driven = surface_beam(wave_of(driven_solution(row_alone.solved(), "a")))
    y = force.center_y + force.width / 2 * np.polynomial.legendre.leggauss(20)[0]
    u_z = driven.motion(force.position, y)[2] @ np.polynomial.legendre.leggauss(20)[1] / 2
    assert beam.circuit.currents[0] == pytest.approx(2j * np.pi * FREQUENCY * u_z * force.width, rel=1e-6)
    assert abs(beam.wave.circuit.currents[0] / beam.circuit.currents[0] - 1) > 0.1
    if name == "PZT-8":
        fields = with_apertures(beam.wave.solution.fields)
        assert fields.received[0, 0] == pytest.approx(beam.circuit.currents[0], rel=largest)


@pytest.mark.parametrize("bottom", ["grounded", "free"])
def test_each_finger_receives_the_beam_at_its_own_distance(bottom):
    """Charges by the beam at the centre of 10 wavelengths of fingers are 0.02 to 0.37 off.

    The sum of the fingers' charges is held against the velocity under the strip by both transducers, of equal fingers
    at unequal distances.
    """
    stator = plate(cut("PZT-8", "Z", quality=60.0), length=60.0, thickness=1.3, bottom=bottom)
    options = {"finger_pairs": 10, "aperture": 10e-3, "termination": "short"}
    row = (comb(stator, "a", 10.0, **options), comb(stator, "b", 48.0, **options))
    beam = forced(stator, strip(stator, 32.0, width=2e-3), row)
    by_charges = with_apertures(beam.wave.solution.fields).received[:, 0]
    assert by_charges == pytest.approx(beam.circuit.currents, rel=0.016)


def test_an_open_transducer_scatters_the_beam_of_a_strip():
    """Short and open, its voltage and the field before it differ; by more than the stated error."""
    stator = plate(cut("PZT-8", "Z", quality=100.0), length=24.0, thickness=1.3)
    unit = stator.length / 24.0
    force, motions = strip(stator, 14.0, amplitude=1e3), {}
    for termination in ("short", "open"):
        row = (comb(stator, "a", 5.0, finger_pairs=2, aperture=4e-3, termination=termination),)
        beam = forced(stator, force, row)
        motions[termination], error = beam.motion_and_error(9.0 * unit, 0.3e-3)
        assert error < 1e-3
    assert abs(motions["open"] - motions["short"]).max() > 0.01 * abs(motions["short"]).max()
    assert abs(beam.circuit.currents[0]) < 1e-12 * abs(beam.circuit.voltages[0])
    with pytest.raises(BeamError, match="power balance of forces on strips is not computed"):
        _ = beam.power


def test_the_static_field_between_mirrors_is_that_of_all_images():
    """The sum over k_y = 2 pi n / width against the closed form at y and at all images of the strip."""
    stator, width = plate(cut("PZT-8", "Z", quality=60.0), length=20.0, thickness=1.3), 5e-3
    beam = forced(stator, strip(stator, 9.0, component="x"))
    (force,) = beam.strips
    bare = Strip(force.sheet, replace(force.source, static=0.0))
    x, y = np.array([10.5, 8.0]) * stator.length / 20.0, np.array([0.8e-3, -1.7e-3])
    found, without = (replace(beam, strips=(each,), mirror_width=width).motion(x, y) for each in (force, bare))
    images = y + width * np.arange(-4000, 4001)[:, None]
    ends = (force.sheet.length / 2 + images, force.sheet.length / 2 - images)
    expected = np.array(force.source.static_motion(x - force.sheet.x, *ends)).sum(axis=1)
    assert (found - without)[:2] == pytest.approx(expected, abs=1e-4 * abs(expected).max())


def test_a_transducer_far_away_does_not_change_the_charges_that_a_force_induces():
    """A transducer alone has the profile of its first sheet on all of them only while it drives, not while it receives.

    With the profile of the first sheet the charges of the later ones differ by 2 to 20 %.
    """
    stator = plate(cut("PZT-8", "Z", quality=40.0), length=40.0, thickness=1.3)
    receiving = comb(stator, "a", 6.0, finger_pairs=2, aperture=2e-3, termination="short")
    far, steps = comb(stator, "b", 36.0, aperture=2e-3, termination="short"), []
    for row in ((receiving,), (receiving, far)):
        fields = stator_cascade(
            stator, row, frequency=FREQUENCY, resolution=LEVELS[0], forces=(strip(stator, 12.0),)
        ).solved()
        steps.append(electrode_charges(driven_solution(with_apertures(fields), None, np.ones(1)), 0).steps)
    assert len(steps[0]) == len(steps[1]) > 2
    for (_, charge), (_, expected) in zip(*steps, strict=True):
        assert abs(charge - expected).max() < 2e-3 * abs(expected).max()


def test_a_force_along_x_is_received_as_the_slope_of_a_normal_one():
    """Between exp(-i kappa L) and k / kappa exp(-i kappa L) lies i/k times the derivative along L, at any angle."""
    k, sizes, length, step = np.array([2.9e3 - 4.0j, 1.7e3 - 2.0j]), (1e-3, np.array([4e-3, 3e-3])), 3e-3, 1e-7
    tangential = aperture_coupling(k, *sizes, length, None, 0.5e-3, tangential=True)
    before, after = (
        aperture_coupling(k, *sizes, length + side * step, None, 0.5e-3) * np.exp(-1j * k * (length + side * step))
        for side in (-1, 1)
    )
    expected = 1j / k * (after - before) / (2 * step) * np.exp(1j * k * length)
    assert abs(tangential - expected).max() < 1e-6
    assert abs(tangential - aperture_coupling(k, *sizes, length, None, 0.5e-3)).max() > 0.01


def test_near_a_strip_and_on_fingers():
    """Errors of a narrow strip: evanescent waves beside it, scattered waves; what is added near it alone."""
    stator = plate(cut("PZT-8", "Z", quality=100.0), length=24.0, thickness=1.3)
    unit, force = stator.length / 24.0, strip(stator, 14.0, amplitude=1e3, width=0.3e-3)
    row = (comb(stator, "a", 5.0, finger_pairs=2, aperture=4e-3, termination=100.0),)
    beam = forced(stator, force, row)
    near, far, on_a_finger = 14.3 * unit, 9.0 * unit, row[0].center + row[0].pitch / 2
    modes = replace(beam, complete=False)
    assert abs(beam.motion(near) - modes.motion(near)).max() > 1e-6 * abs(modes.motion(near)).max()
    assert np.all(beam.motion(on_a_finger) == modes.motion(on_a_finger))
    wavelength = beam.wave.phase_velocity / FREQUENCY
    assert beam.relative_error(near) > np.exp(-13.0 * 0.3 * unit / wavelength)
    assert beam.relative_error(on_a_finger) < 0.1  # 0.45 without the spreading of the beam
    known = replace(beam, scattering_error=0.0)
    scattered = abs(replace(beam, strips=(), complete=False).motion(far)).max()
    size = abs(beam.motion(far)[[0, 2]]).max()
    added = beam.relative_error(far) - known.relative_error(far)
    assert added == pytest.approx(beam.scattering_error * scattered / size, rel=1e-6)
    for one, other in zip(beam.charges, all_charges(beam.solution), strict=True):
        assert np.all(one.charge == other.charge)


def test_strip_and_transducer_moved_together_across_the_stator():
    """What the fingers receive depends on the distance along y alone."""
    stator = plate(cut("PZT-8", "Z", quality=100.0), length=24.0, thickness=1.3)
    received = []
    for moved in (0.0, 1.2e-3):
        row = (comb(stator, "a", 5.0, aperture=3e-3, termination="short", center_y=moved),)
        beam = forced(stator, strip(stator, 12.0, center_y=0.9e-3 + moved), row)
        received.append((with_apertures(beam.wave.solution.fields).received[0, 0], beam.circuit.currents[0]))
    assert received[1] == pytest.approx(received[0], rel=1e-9)


def test_beside_a_strip_in_a_cut_is_not_resolved():
    stator = plate(cut("LiNbO3 (Kovacs)", "128YX"), length=9.0)
    unit = stator.length / 9.0
    beam = forced(stator, strip(stator, 4.0))
    assert beam.unresolved(4.2 * unit, 2e-3)
    assert not beam.unresolved(7.0 * unit, 2e-3)


def test_the_error_of_currents_is_relative_to_the_largest_one():
    """A transducer far beside the strip receives little: its error alone, times the ratio of both currents."""
    stator = plate(cut("PZT-8", "Z", quality=100.0), length=12.0, thickness=0.8)
    strong = comb(stator, "a", 2.0, aperture=3e-3, termination="short")
    weak = comb(stator, "b", 10.0, aperture=3e-3, termination="short", center_y=9e-3)
    both, alone = (forced(stator, strip(stator, 6.0), row) for row in ((strong, weak), (weak,)))
    currents = abs(both.circuit.currents)
    assert currents[1] < 0.02 * currents[0]
    expected = alone.received_error * abs(alone.circuit.currents[0]) / currents[0]
    assert both.received_error == pytest.approx(expected, rel=0.05)


def test_what_a_strip_cannot_be():
    stator = plate(cut("PZT-8", "Z"), length=9.0)
    with pytest.raises(InputError, match=r"force 'f'.width must be positive, got 0"):
        strip(stator, 2.0, width=0.0)
    with pytest.raises(InputError, match=r"force 'f'.center_y must be finite, got nan m"):
        strip(stator, 2.0, center_y=np.nan)
    with pytest.raises(InputError, match=r"force 'f'.width must be finite in three dimensions"):
        forced(stator, strip(stator, 2.0, width=np.inf))
    with pytest.raises(
        BeamError, match=r"the field of forces in three dimensions needs stator.ends = 'absorbing', got"
    ):
        forced(replace(stator, ends="free"), strip(stator, 2.0))
    with pytest.raises(BeamError, match="forces beside the middle line need absorbing sides"):
        forced(stator, strip(stator, 2.0, center_y=1e-3), mirror_width=9e-3)
    with pytest.raises(BeamError, match=r"mirror_width must be at least the largest aperture, 0.001 m"):
        forced(stator, strip(stator, 2.0), mirror_width=5e-4)


def test_the_waves_of_open_strips_alone_are_in_doubt_as_a_whole():
    """No current is received; the motion is that of the bare surface but for the strips' scattering."""
    stator = plate(cut("PZT-8", "Z"), length=12.0, ends="absorbing", bottom="absorbing")
    strips = comb(stator, "a", 8.0, finger_pairs=3, pattern="oooooo", aperture=3e-3)
    bare, covered = (forced(stator, strip(stator, 2.0), row) for row in ((), (strips,)))
    place = stator.length * np.array([4.0, 6.0]) / 12.0
    assert covered.scattering_error == 1.0
    apart = abs(covered.motion(place, 0.0) - bare.motion(place, 0.0))[2] / abs(bare.motion(place, 0.0))[2]
    error = covered.motion_and_error(place, 0.0)[1]
    assert np.all(apart > 1e-4)
    assert np.all(apart < 1.1 * error)
