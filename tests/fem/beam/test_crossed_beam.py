"""Turned transducers: turning everything turns the field, beams add up, and coupling is that of Hankel functions."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.special import hankel2

from fem.beam.beam_of_section import surface_beam
from fem.beam.crossed_beam import crossed_beam, near_and_between
from fem.beam.electrode_charges import ElectrodeCharges
from fem.beam.line_source import line_source
from fem.beam.parallel_groups import mutual_admittance
from fem.beam.surface_beam import BeamError
from fem.circuit import Drive
from fem.discretize.element_sizes import Resolution
from fem.geometry import covers, separation, turn
from fem.layout import check_layout, check_plan
from fem.solve.driven_stator import driven_wave
from fem.waveguide.port_fields import stator_cascade
from tests.fem.beam.test_surface_beam import section_charges
from tests.fem.stators import FREQUENCY, comb, cut, plate, solution, wave_of

STATOR = plate(cut("PZT-8", "Z", quality=60.0), length=40.0, thickness=1.3)
MIDDLE, WIDTH = STATOR.length / 2, STATOR.length
LEFT = comb(STATOR, "a", 8.0, finger_pairs=2, aperture=4e-3)
RIGHT = comb(STATOR, "b", 31.0, aperture=3e-3)
FRONT = replace(
    comb(STATOR, "c", 20.0, finger_pairs=1, aperture=3e-3), center_y=-MIDDLE / 2, angle=np.pi / 2, termination=200.0
)
PLACES = MIDDLE + np.array([-2e-3, 1e-3, 4e-3]), np.array([0.0, 1.3e-3, -1.9e-3])


def solve(stator, row, drive, places=()):
    return wave_of(solution(stator, row, drive=drive, order=4))


def crossed(*transducers, drive="a", stator=STATOR):
    return crossed_beam(stator, transducers, width=WIDTH, frequency=FREQUENCY, drive=drive, solve=solve)


def turned(transducer, angle):
    """The transducer after a turn of the whole surface about its middle, rad."""
    x, y = np.array([transducer.center - MIDDLE, transducer.center_y]) @ turn(angle)
    return replace(transducer, center=MIDDLE + x, center_y=y, angle=transducer.angle + angle)


@pytest.mark.parametrize(
    ("degrees", "fingers"),
    [(37.0, {}), (90.0, {}), (180.0, {}), (-120.0, {}), (180.0, {"chirp": 0.3}), (180.0, {"cell": "DART"})],
)
def test_turning_everything_turns_the_field(degrees, fingers):
    angle, x, y = np.radians(degrees), *PLACES
    left = replace(LEFT, **fingers)
    as_it_was = crossed(left, FRONT)
    after = crossed(turned(left, angle), turned(FRONT, angle))
    moved = np.stack([x - MIDDLE, y], axis=-1) @ turn(angle)
    expected, found = as_it_was.motion(x, y), after.motion(MIDDLE + moved[:, 0], moved[:, 1])
    back = np.vstack([turn(angle) @ found[:2], found[2:]])
    np.testing.assert_allclose(back, expected, atol=1e-9 * abs(expected).max())
    np.testing.assert_allclose(after.circuit.voltages, as_it_was.circuit.voltages, atol=1e-9)


def test_a_beam_along_y_is_its_twin_along_x():
    """By two ways: the plane stator's beam, and the row of a turned one."""
    x, y = PLACES
    twin = surface_beam(solve(STATOR, (LEFT,), "a")).motion(x, y)
    along_y = crossed(turned(LEFT, np.pi / 2)).motion(MIDDLE - y, x - MIDDLE)
    np.testing.assert_allclose(along_y, [-twin[1], twin[0], twin[2]], atol=1e-10 * abs(twin).max())


def test_opposite_transducers_are_one_row():
    """Half a turn reverses the order of the fingers and nothing else; they receive as a row does."""
    opposite = crossed(LEFT, replace(RIGHT, angle=np.pi))
    row = surface_beam(solve(STATOR, (LEFT, replace(RIGHT, pattern="-+")), "a"))
    np.testing.assert_array_equal(opposite.motion(*PLACES), row.motion(*PLACES))
    assert opposite.circuit.voltages[1] == row.circuit.voltages[1] != 0


def test_beams_add_up():
    both = crossed(LEFT, FRONT, drive=Drive(sources={"a": 1.0, "c": 0.5j})).motion(*PLACES)
    alone = [
        crossed(LEFT, FRONT, drive=Drive(sources=each)).motion(*PLACES)
        for each in ({"a": 1.0, "c": 0.0}, {"a": 0.0, "c": 1.0})
    ]
    np.testing.assert_allclose(both, alone[0] + 0.5j * alone[1], atol=1e-10 * abs(both).max())
    assert abs(alone[1][1]).max() > 3 * abs(alone[1][0]).max()  # along y


def test_coupling_is_a_sum_of_hankel_functions():
    """Every mode's beam is k H0(k r) / 2; by any direction in which both are apart, and either way."""
    resolution = Resolution(order=4, edge_layers=0)
    modes = stator_cascade(STATOR, (LEFT,), frequency=FREQUENCY, resolution=resolution).modes
    plan = LEFT, replace(FRONT, angle=1.1)
    charges = [
        ElectrodeCharges(x=7e-3 + each.center * np.array([-0.04, 0.01, 0.03]), charge=np.array(q), finger=np.arange(3))
        for each, q in zip(plan, ([1e-9, -3e-9, 2e-9j], [2e-9, 1e-9j, -1e-9]), strict=True)
    ]
    origins = tuple(7e-3 + 0.0 * each.center for each in plan)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    places = []
    for each, own in zip(plan, charges, strict=True):
        line = np.stack(np.broadcast_arrays(own.x[:, None] - 7e-3, each.aperture / 2 * nodes), axis=-1)
        places.append(np.array([each.center, each.center_y]) + line @ turn(each.angle))
    (a, b), (q, p) = places, (each.charge for each in charges)
    distance = np.linalg.norm(a[:, :, None, None] - b, axis=-1)
    source, section = line_source(modes, "charge"), modes.section
    potentials = modes.right[section.surface_dofs["phi"], modes.wavenumbers != 0] * source.amplitudes
    expected = 0.0
    for k, potential in zip(source.wavenumbers, potentials * section.solid.potential_unit, strict=True):
        if -k.imag < 2e3:
            field = hankel2(0, k * distance)
            mean = np.einsum(
                "i,m,imjn,j,n->", q, weights * plan[0].aperture / 2, field, p, weights * plan[1].aperture / 2
            )
            expected += potential * k / 2 * mean
    expected *= -2j * np.pi * FREQUENCY
    widest = separation(*plan)[1]
    for along in (None, widest + 0.2, widest - 0.2):
        found = mutual_admittance(modes, plan, origins, (0.0, 1.1), tuple(charges), along=along)
        assert found == pytest.approx(expected, rel=1e-6)
    back = mutual_admittance(modes, plan[::-1], origins[::-1], (1.1, 0.0), tuple(charges[::-1]))
    assert back == pytest.approx(expected, rel=1e-6)


def test_coupling_of_aligned_transducers_is_that_of_a_row():
    """From the charges of each alone, but for what passes between them more than once; wide apertures and much loss."""
    stator = plate(cut("PZT-8", "Z", quality=15.0), length=40.0, thickness=1.3)
    two = [replace(each, aperture=60e-3) for each in (LEFT, RIGHT)]
    row = surface_beam(solve(stator, tuple(two), "a")).solution.fields
    beside = replace(two[1], center_y=1e-9)
    alone = crossed_beam(
        stator, (two[0], replace(beside, angle=1e-7)), width=1.0, frequency=FREQUENCY, drive="a", solve=solve
    )
    assert len(alone.rows) == 2
    found = -alone.circuit.voltages[1] * alone.beams[1].solution.fields.admittances[0, 0]  # open: Y_21 V_1
    assert found == pytest.approx(row.admittances[1, 0], rel=0.01)


def test_beside_the_middle_line():
    """A transducer that is moved across moves its beam; of two, the second receives by its distance across."""
    x, y = PLACES
    shift = 2.1e-3
    plain = surface_beam(solve(STATOR, (LEFT, RIGHT), "a"))
    moved = [replace(each, center_y=shift) for each in (LEFT, RIGHT)]
    beam = surface_beam(solve(STATOR, tuple(moved), "a"))
    expected = plain.motion(x, y)
    np.testing.assert_allclose(beam.motion(x, y + shift), expected, atol=1e-7 * abs(expected).max())
    np.testing.assert_allclose(beam.circuit.voltages, plain.circuit.voltages, rtol=1e-9)
    apart = surface_beam(solve(STATOR, (LEFT, replace(RIGHT, center_y=shift)), "a"))
    mirrored = surface_beam(solve(STATOR, (LEFT, replace(RIGHT, center_y=-shift)), "a"))
    flipped = mirrored.motion(x, -y) * [[1], [-1], [1]]
    np.testing.assert_allclose(apart.motion(x, y), flipped, atol=1e-9 * abs(flipped).max())
    received = [abs(each.circuit.voltages[1]) for each in (plain, apart)]
    assert received[1] < 0.95 * received[0]


def test_side_by_side_transducers_are_two_rows():
    """What a section cannot hold: two that stand beside one another; on the line between them u_y vanishes."""
    pair = [replace(LEFT, name=name, center_y=side * 4e-3) for name, side in (("a", 1), ("b", -1))]
    found = crossed(*pair, drive=Drive(sources={"a": 1.0, "b": 1.0}))
    assert len(found.rows) == 2
    _, u_y, u_z = found.motion(PLACES[0], 0.0)
    assert abs(u_y).max() < 1e-9 * abs(u_z).max()
    one = crossed(pair[0])
    np.testing.assert_allclose(found.motion(*PLACES)[2], one.motion(*PLACES)[2] + one.motion(PLACES[0], -PLACES[1])[2])


@pytest.mark.parametrize(
    ("degrees", "faces"), [(0.0, "y"), (90.0, "x"), (-90.0, "x"), (180.0, "y"), (30.0, "y"), (-60.0, "x"), (45.0, "")]
)
def test_first_images_are_image_sources_in_the_faces_along_the_beam(degrees, faces):
    """A sum of Hankel functions over the charges, turned and mirrored in faces that are named here."""
    beam, angle = crossed(turned(LEFT, np.radians(degrees))).surface_mode, np.radians(degrees)
    charges = section_charges(beam.beams[0])
    ((sheet,), source) = next((each.sheets, each.source) for each in charges.emitters)
    beam = replace(beam, beams=(charges,))
    nodes, weights = (each * sheet.length / 2 for each in np.polynomial.legendre.leggauss(60))
    backwards = np.cos(beam.rows[0].angle - angle) < 0  # the group runs against its transducer
    ahead = (sheet.x - beam.rows[0].transducers[0].center) * (-1.0 if backwards else 1.0)
    line = np.stack(np.broadcast_arrays(ahead[:, None], nodes), axis=-1)
    a, b = np.moveaxis(line @ turn(angle), -1, 0)
    left = np.array([LEFT.center - MIDDLE, 0.0]) @ turn(angle)
    a, b = a + MIDDLE + left[0], b + left[1]
    x, y = np.array([MIDDLE + 1e-3, MIDDLE - 2e-3]), np.array([2e-3, -3e-3])
    mirrored = [(-a, b), (2 * STATOR.length - a, b)] if faces == "x" else [(a, WIDTH - b), (a, -WIDTH - b)]
    expected = np.zeros(2)
    for at, beside in mirrored if faces else ():
        distance = np.hypot(x[:, None, None] - at, y[:, None, None] - beside)
        (k,), (normal,) = source.wavenumbers, source.normal
        expected += abs(normal * k / 2 * (hankel2(0, k * distance) @ weights @ sheet.charge))
    assert beam.first_images(x, y) == pytest.approx(expected, rel=1e-6)


def test_the_incoherent_amplitude_is_the_root_mean_square_over_phases():
    """Of the coherent sum, over the phase between the sources."""
    beams = [
        crossed(LEFT, FRONT, drive=Drive(sources={"a": 1.0, "c": np.exp(1j * each)}))
        for each in np.arange(4) * np.pi / 2
    ]
    squares = [abs(each.motion(*PLACES)[2]) ** 2 for each in beams]
    assert beams[0].incoherent_amplitude(*PLACES) ** 2 == pytest.approx(np.mean(squares, axis=0), rel=1e-9)


def test_many_places_at_an_oblique_angle_are_interpolated():
    """Beside the fingers as well as one by one; on a line across the beam, 3 mm and more from them."""
    found = crossed(turned(LEFT, 0.3))
    x, y = np.linspace(MIDDLE, MIDDLE + 5e-3, 601), np.linspace(-3e-3, 4e-3, 601)
    few = slice(None, None, 40)
    expected = found.motion(x[few], y[few])
    assert 0 < abs(found.motion(x, y)[:, few] - expected).max() < 1e-4 * abs(expected).max()


def test_power_and_error_of_crossing_beams():
    found = crossed(LEFT, FRONT)
    assert found.power.input == pytest.approx(found.circuit.power)
    assert 0 < found.power.radiated < found.power.input
    assert found.power.residual < 1e-9
    stated = [replace(each, wave=replace(each.wave, relative_error=1e-3)) for each in found.beams]
    assert np.all(replace(found, beams=tuple(stated)).relative_error(*PLACES) > 1e-3)


def test_power_beside_an_open_transducer_that_crosses():
    """It takes a voltage from the wave, but no current: its own apparent power is zero, or the rounding of zero."""
    found = crossed(LEFT, replace(FRONT, termination="open"))
    assert found.beams[1].circuit.apparent_power < 1e-15 * found.circuit.apparent_power
    assert abs(found.beams[1].circuit.voltages[0]) > 0.0
    assert found.power.residual < 1e-9


def test_a_place_on_the_surface():
    assert separation(LEFT, FRONT)[0] == pytest.approx(separation(FRONT, LEFT)[0])
    assert separation(LEFT, FRONT)[0] > 0
    for angle in (0.0, 0.7, np.pi / 2):
        own = turned(LEFT, angle)
        assert covers(own, tuple(own.corners.mean(axis=0)))
        assert not covers(own, tuple(own.corners[0] * 1.5 - own.corners[2] * 0.5))
        for one, other in pairwise(own.on_surface(own.fingers)[:, 0]):
            assert np.linalg.norm(other - one) == pytest.approx(own.pitch)


@pytest.mark.parametrize(
    ("transducers", "message"),
    [
        ((LEFT, replace(FRONT, center_y=0.0, center=LEFT.center)), "off those of 'a': they overlap on the surface"),
        ((LEFT, replace(FRONT, center_y=-0.499 * WIDTH)), "got fingers from y = "),
        ((LEFT, replace(FRONT, center=1e-3)), "got fingers from x = "),
        ((LEFT, replace(LEFT, center_y=6e-3)), "must differ from the others"),
    ],
)
def test_refused_layouts(transducers, message):
    with pytest.raises(ValueError, match=message):
        check_plan(STATOR, WIDTH, transducers)


def test_refusals():
    with pytest.raises(ValueError, match="'c' must have the angle 0 in a section along x, got 1"):
        check_layout(STATOR, (LEFT, FRONT))
    with pytest.raises(ValueError, match="'c' must have the angle 0"):
        driven_wave(STATOR, (LEFT, FRONT), frequency=FREQUENCY, drive="a", tolerance=0.1)
    for changed, message in (
        ({"ends": "free"}, "stator.ends must be absorbing where a transducer is turned"),
        ({"solid": cut("LiNbO3 (Warner)", "YZ")}, "only in solids isotropic about z"),
    ):
        with pytest.raises(ValueError, match=message):
            crossed(LEFT, FRONT, stator=replace(STATOR, **changed))
    with pytest.raises(
        ValueError, match=r"transducer 'c'.pattern must have \+ and - fingers where a transducer is turned"
    ):
        crossed(LEFT, replace(FRONT, pattern="oo"))
    with pytest.raises(BeamError, match="need a solid isotropic about z and absorbing sides"):
        surface_beam(solve(STATOR, (replace(LEFT, center_y=1e-3),), "a"), mirror_width=WIDTH)
    with pytest.raises(BeamError, match="points must lie on the stator"):
        crossed(LEFT, FRONT).motion(MIDDLE, WIDTH)


def test_points_near_fingers_are_those_within_the_clear_distance():
    (start, stop), clear = LEFT.extent, 0.7e-3
    s = np.array([start - 1.1 * clear, start - 0.9 * clear, LEFT.center, stop + 0.9 * clear, stop + 1.1 * clear])
    near = {tuple(np.flatnonzero(points)): is_near for points, is_near in near_and_between(s, (LEFT,), clear)}
    assert near == {(0,): False, (1, 2, 3): True, (4,): False}
