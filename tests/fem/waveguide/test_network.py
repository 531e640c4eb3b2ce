"""Stretches, ends and scatterers: waves that pass, come back, and do not know how long the rest is."""

from functools import reduce

import numpy as np
import pytest

from fem.condense.finger_columns import condensed
from fem.condense.joined_fingers import joined, repeated
from fem.discretize.element_sizes import CORNER_RATIO, Resolution, graded
from fem.parameters import InputError
from fem.waveguide.cascade_system import Element, Travel, solve_cascade
from fem.waveguide.end_conditions import closed, end_reflection, end_walls
from fem.waveguide.guided_modes import guided_modes
from fem.waveguide.scattering_network import NEGLIGIBLE, Scatterer
from tests.fem.stators import FREQUENCY, comb, cut, lossless, plate, section, solution

CASES = (
    (lossless("PZT-4", "Z"), {}),
    (cut("PZT-5H", "X"), {"bottom": "grounded"}),
    (lossless("LiNbO3 (Warner)", "YZ"), {}),
    (cut("LiNbO3 (Kovacs)", (17.0, 31.0, 49.0), quality=200.0), {"bottom": "clamped"}),
)
NAMES = [f"{solid.name} {solid.frame}" for solid, _ in CASES]


@pytest.fixture(scope="module", params=CASES, ids=NAMES)
def guided(request):
    solid, rest = request.param
    return guided_modes(section(plate(solid, thickness=0.9, **rest), order=8), FREQUENCY)


def test_bare_piece_scatters_nothing(guided):
    """A row of bare columns between two stretches passes every slow mode on, and sends nothing back.

    Without combs nothing fixes the mean potential: it is taken out.
    """
    depth, n = guided.section, guided.section.size
    block = repeated(condensed(depth, FREQUENCY, width=0.2, electrode=None), 3)
    scatterer = Scatterer(piece=block, modes=guided, potentials=np.array([[0.5], [-0.5]]))
    slow = np.flatnonzero((np.abs(guided.wavenumbers) < 9.0) & (guided.wavenumbers != 0))
    nothing = np.zeros((n, len(slow)))
    phase = np.exp(-1j * guided.wavenumbers[slow] * block.width)
    back_phase = np.exp(1j * guided.backwards[slow] * block.width)
    right, left = guided.right[:, slow], guided.left[:, slow]
    for incoming, expected in (
        (np.concatenate([right, nothing]), np.concatenate([right, right * phase])),
        (np.concatenate([nothing, left]), np.concatenate([left * back_phase, left])),
    ):
        error = scatterer.sides(incoming, np.zeros((2, len(slow)))) - expected
        if depth.floating_potential:
            constant = np.tile(depth.constant_potential, 2)
            error = error - np.outer(constant, constant @ error) / constant.sum()
        assert np.abs(error).max() < 1e-9


def test_a_scatterer_answers_each_mode_and_each_port_as_alone():
    """Asked for some modes and then for more: the lines that equation (1) has for each incident field alone."""
    guided = guided_modes(section(plate(cut("PZT-4", "Z"), thickness=0.9, bottom="grounded"), order=6), FREQUENCY)
    depth, n = guided.section, guided.section.size
    block = condensed(depth, FREQUENCY, width=0.13, electrode=0)
    scatterer = Scatterer(piece=block, modes=guided, potentials=np.array([[0.5, 1.0], [-0.5, 1.0]]))
    scatterer.responses(np.array([1, 3]))
    modes = np.array([4, 3, 0])
    found = scatterer.responses(modes)
    nothing, volts = np.zeros((n, 3)), np.zeros((2, 3))
    expected = (
        scatterer.sides(np.concatenate([guided.right[:, modes], nothing]), volts),
        scatterer.sides(np.concatenate([nothing, guided.left[:, modes]]), volts),
        scatterer.sides(np.zeros((2 * n, 2)), scatterer.potentials),
    )
    for ours, alone in zip(found, expected, strict=True):
        np.testing.assert_allclose(ours, alone, rtol=0, atol=1e-9 * abs(alone).max())


@pytest.mark.parametrize("ends", ["free", "clamped"])
def test_condensed_ends_are_closed_on_their_own_side(ends):
    """Each end by one join from its outer line: as a piece whose outer line is held or free."""
    depth = section(stator := plate(cut("PZT-4", "Z"), thickness=0.9, ends=ends), order=6)
    resolution = Resolution(order=6, edge_layers=1)
    walls = end_walls(depth, FREQUENCY, stator, resolution, width=0.2)
    layers = resolution.edge_layers if ends == "clamped" else 0
    widths = graded(0.2, layers, largest=0.1, ratio=CORNER_RATIO)
    lines = np.arange(2 * depth.size).reshape(2, -1)
    held = depth.mechanical if ends == "clamped" else []
    for wall, near, order in zip(walls, (1, 0), (widths[::-1], widths), strict=True):
        columns = [condensed(depth, FREQUENCY, width=each, electrode=None) for each in order]
        alone, _ = closed(reduce(joined, columns), lines[near], np.delete(lines[1 - near], held))
        np.testing.assert_allclose(wall.matrix, alone.matrix, rtol=0, atol=1e-11 * abs(alone.matrix).max())
        line = np.linspace(1.0, 2.0, depth.size)
        motion, expected = (each.recover(line).motion(np.array([0.05, 0.1])) for each in (wall, alone))
        np.testing.assert_allclose(motion, expected, rtol=0, atol=1e-9 * abs(expected).max())


@pytest.mark.parametrize("end", ["absorbing", "clampd", "grounded"])
def test_a_word_that_no_reflecting_end_has_is_refused(guided, end):
    with pytest.raises(InputError, match=rf"ends must be free or clamped to reflect, got '{end}'"):
        end_reflection(guided, end, 0, np.array([0]))


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("ends", ["free", "clamped"])
def test_ends_hold_what_they_say(guided, ends, side):
    """Free: no nodal flux of the whole field; clamped: no displacement, no flux of D."""
    depth = guided.section
    slow = np.flatnonzero((np.abs(guided.wavenumbers) < 12.0) & (guided.wavenumbers != 0))
    arriving, leaving = ((guided.left, guided.left_flux), (guided.right, guided.right_flux))[:: 1 if side == 0 else -1]
    back = end_reflection(guided, ends, side, slow)
    shape, flux = (there[:, slow] + here @ back for there, here in zip(arriving, leaving, strict=True))
    electric = np.setdiff1d(np.arange(depth.size), depth.mechanical)
    size = np.abs(arriving[1][:, slow]).max()
    assert np.abs(flux[electric]).max() < 1e-8 * size
    if ends == "clamped":
        assert np.abs(shape[depth.mechanical]).max() < 1e-8
    else:
        assert np.abs(flux[depth.mechanical]).max() < 1e-8 * size


@pytest.mark.parametrize("ends", ["free", "clamped"])
def test_lossless_ends_send_all_power_back(ends):
    """The modes that travel exchange power only among themselves: their reflection matrix is unitary."""
    modes = guided_modes(section(plate(lossless("PZT-4", "Z"), thickness=0.9), order=8), FREQUENCY)
    travels = np.flatnonzero((np.abs(modes.wavenumbers.imag) < 1e-9) & (modes.wavenumbers.real != 0))
    carried = np.abs(np.imag(np.sum(modes.right_flux * modes.right.conj(), axis=0)))[travels]
    back = end_reflection(modes, ends, 1, travels)[travels]
    scaled = np.sqrt(carried)[:, None] * back / np.sqrt(carried)
    assert len(travels) >= 3
    assert np.abs(scaled.conj().T @ scaled - np.eye(len(travels))).max() < 1e-8


def test_absorbing_ends_do_not_know_the_length():
    """Two transducers on a stator that goes on, cut anywhere: the same ports, the same motion."""
    solid = lossless("LiNbO3 (Kovacs)", "128YX")
    found = []
    for longer in (0.0, 3.7):
        stator = plate(solid, length=6.0 + 2 * longer)
        one, other = comb(stator, "a", 1.5 + longer), comb(stator, "b", 4.2 + longer)
        found.append(solution(stator, (one, other)).fields.admittances)
    assert np.abs(found[0] - found[1]).max() < 1e-12 * np.abs(found[0]).max()


def test_only_modes_that_survive_couple():
    stator = plate(cut("PZT-4", "Z"), length=9.0)
    solved = solution(stator, (comb(stator, "a", 1.5), comb(stator, "b", 7.0)))
    network = solved.fields.network
    for length in (0.1, 1.0, 5.0):
        kept = network.survivors(length)
        decay = np.abs(np.exp(-1j * solved.fields.modes.wavenumbers * length))
        assert decay[kept].min() > NEGLIGIBLE
        assert solved.fields.modes.wavenumbers[kept].all()
    assert len(network.survivors(5.0)) < 0.6 * len(network.survivors(0.1))
    edges = network.segments * solved.fields.section.length_unit
    assert edges[0, 0] == 0
    assert edges[-1, 1] == pytest.approx(stator.length, rel=1e-12)
    assert np.all(np.diff(edges.ravel()) > 0)


def test_distant_ends_matter_to_rounding_only_with_loss():
    """Q = 5: what comes back over 30 wavelengths is e^-20 weaker; free ends are then absorbing ends."""
    solid = cut("PZT-8", "Z", quality=5.0)
    ports = []
    for ends in ("free", "clamped", "absorbing"):
        stator = plate(solid, length=60.0, ends=ends)
        ports.append(solution(stator, (comb(stator, "a", 30.0),)).fields.admittances[0, 0])
    assert ports[0] == pytest.approx(ports[2], rel=1e-9)
    assert ports[1] == pytest.approx(ports[2], rel=1e-9)


@pytest.mark.parametrize(
    ("ends", "bottom"),
    [
        ("free", "clamped"),  # where the reciprocity was off by 3e-9
        pytest.param("clamped", "clamped", marks=pytest.mark.slow),
        pytest.param("free", "free", marks=pytest.mark.slow),
    ],
)
def test_reciprocity_between_plain_ends_on_a_fine_level(ends, bottom):
    """1e-9 by the modes' own fluxes, 17 times that at a resonance."""
    stator = plate(cut("PZT-4", "Z"), length=9.0, ends=ends, bottom=bottom)
    row = (comb(stator, "a", 1.5, finger_pairs=2, metallisation=0.45), comb(stator, "b", 7.3, metallisation=0.55))
    admittances = solution(stator, row, order=9, layers=4).fields.admittances
    assert abs(admittances - admittances.T).max() < 1e-11 * abs(admittances).max()


def test_waves_in_groups_travel_as_by_one_matrix():
    """Three elements, of which the middle one receives from both sides, and a group without any waves."""
    rng = np.random.default_rng(5)

    def some(*shape):
        return 0.3 * (rng.normal(size=shape) + 1j * rng.normal(size=shape))

    own = [np.arange(4 * at, 4 * at + 4) for at in range(3)]
    elements = [
        Element(scattering=some(4, 4), excitation=some(4, 2), leaves=each, arrives=np.roll(each, 1)) for each in own
    ]
    travel, matrix = [], np.zeros((12, 12), dtype=complex)
    for sender, receiver in ((0, 1), (1, 0), (1, 2), (2, 1)):
        half = slice(0, 2) if sender < receiver else slice(2, 4)
        part = Travel(own[receiver][half][:, None], own[sender][half][:, None], some(2, 1, 1))
        travel.append(part)
        matrix[part.arrives[:, 0], part.leaves[:, 0]] = part.factors[:, 0, 0]
    travel.append(Travel(np.zeros((0, 1), int), np.zeros((0, 1), int), np.zeros((0, 1, 1))))
    scattering, excitation, outside = np.zeros((12, 12), dtype=complex), np.zeros((12, 2), dtype=complex), some(12, 2)
    for each in elements:
        scattering[np.ix_(each.leaves, each.arrives)], excitation[each.leaves] = each.scattering, each.excitation
    for from_outside in (None, outside):
        load = excitation if from_outside is None else excitation + scattering @ outside
        leaving = np.linalg.solve(np.eye(12) - scattering @ matrix, load)
        found = solve_cascade(elements, travel, from_outside)
        np.testing.assert_allclose(found.leaving, leaving, rtol=1e-12)
        arriving = matrix @ leaving + (0 if from_outside is None else outside)
        np.testing.assert_allclose(found.arriving, arriving, rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(found.coupling, scattering @ matrix, rtol=1e-12, atol=1e-15)
