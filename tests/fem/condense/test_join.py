"""Joined pieces: algebra that must not depend on the order of joining, mirrors, and the way back."""

import gc
import weakref
from itertools import pairwise

import numpy as np
import pytest

from fem.condense.finger_columns import columns_from_left, condensed
from fem.condense.joined_fingers import exchanged, joined, mirror_images, repeated
from fem.condense.transducer import Condensation, FingerShape, finger_cell, finger_ports, half_cells, joined_fingers
from fem.discretize.element_sizes import Resolution
from fem.waveguide.guided_modes import guided_modes
from tests.fem.stators import FREQUENCY, cut, lossless, plate, section

CASES = (
    cut("PZT-4", "Z"),
    lossless("PZT-5H", "X"),
    lossless("LiNbO3 (Kovacs)", "128YX"),
    cut("LiNbO3 (Warner)", "YZ", quality=500.0),
)
SHAPE = FingerShape(half_finger=0.11, half_gaps=(0.14, 0.14))
RESOLUTION = Resolution(order=5, edge_layers=1)


@pytest.fixture(scope="module", params=CASES, ids=[f"{solid.name} {solid.frame}" for solid in CASES])
def depth(request):
    return section(plate(request.param, thickness=0.9), order=5, layers=1)


def widths(piece):
    """Widths of a piece's columns from left to right."""
    return [column.width for _, column, _ in columns_from_left(piece, np.zeros(len(piece.matrix)))]


def close(one, other, tolerance=1e-11):
    return np.abs(one - other).max() < tolerance * np.abs(other).max()


def test_joining_is_associative(depth):
    phi = depth.surface_dofs["phi"]
    finger, gap = (condensed(depth, FREQUENCY, width=0.1, electrode=comb) for comb in (0, None))
    tied = {"phi": phi, "electrode": 0}
    ours = joined(joined(gap, finger, **tied), joined(finger, gap, **tied), **tied)
    other = joined(joined(joined(gap, finger, **tied), finger, **tied), gap, **tied)
    assert close(ours.matrix, other.matrix)
    assert ours.width == pytest.approx(0.4, rel=1e-14)
    bare = joined(joined(gap, gap), gap).matrix, joined(gap, joined(gap, gap)).matrix
    assert close(*bare)


@pytest.mark.parametrize("tied", [True, False], ids=["finger on the line", "gap on the line"])
def testmirror_images_are_joined_as_any_two_parts(tied):
    """Each parity alone, against all unknowns together; and only where the right part is the mirror image."""
    depth = section(plate(CASES[0], thickness=0.9), order=5, layers=1)
    make = Condensation(depth, FREQUENCY)
    rising, falling = half_cells(make, SHAPE, RESOLUTION)
    if not tied:
        rising, falling = falling, exchanged(rising)
    electrode = {"phi": depth.finger_potential, "electrode": 0} if tied else {}
    images = [
        mirror_images(left.matrix, right.matrix, left.at, depth.odd)
        for left, right in ((rising, falling), (rising, rising))
    ]
    assert images == [True, False]
    one, other = (joined(rising, falling, **electrode, odd=odd) for odd in (depth.odd, None))
    assert close(one.matrix, other.matrix, 1e-12)
    assert close(one.pair.middle, other.pair.middle, 1e-11)
    np.testing.assert_array_equal(one.matrix, one.matrix.T)
    assert mirror_images(one.matrix, exchanged(one).matrix, one.at, depth.odd)


@pytest.mark.parametrize("count", [1, 2, 5, 6])
def test_doubling_is_joining_one_by_one(depth, count):
    cell = finger_cell(Condensation(depth, FREQUENCY), SHAPE, RESOLUTION)
    one_by_one = cell
    for _ in range(count - 1):
        one_by_one = joined(one_by_one, cell)
    doubled = repeated(cell, count)
    assert close(doubled.matrix, one_by_one.matrix, 1e-9)
    assert (widths(doubled)) == pytest.approx((widths(one_by_one)), rel=1e-14)


def test_a_row_of_fingers_is_freed_with_its_last_user(depth):
    """No cycle of references keeps its matrices until the next search for cyclic garbage: 45 MB of a run of twente."""
    gc.disable()
    try:
        cell = finger_cell(Condensation(depth, FREQUENCY), SHAPE, RESOLUTION)
        row = joined_fingers(
            Condensation(depth, FREQUENCY), "+-+-", [SHAPE] * 4, lambda shape: cell, lambda shape: cell
        )
        with_ports, _ = finger_ports(row, "+-+-")
        kept = [weakref.ref(each) for each in (row, with_ports)]
        del row, with_ports
        assert [each() for each in kept] == [None, None]
    finally:
        gc.enable()


def test_halving_a_column_changes_little(depth):
    """Two columns of half the width: another discretisation of the same piece, seen by slow modes."""
    n = depth.size
    modes = guided_modes(depth, FREQUENCY)
    slow = np.abs(modes.wavenumbers) < 8.0
    lines_ = np.concatenate([modes.right[:, slow], modes.right[:, slow] * np.exp(-0.2j * modes.wavenumbers[slow])])
    whole = condensed(depth, FREQUENCY, width=0.2, electrode=None)
    half = condensed(depth, FREQUENCY, width=0.1, electrode=None)
    ours = joined(half, half).matrix[: 2 * n, : 2 * n] @ lines_
    assert close(whole.matrix[: 2 * n, : 2 * n] @ lines_, ours, 1e-5)


def test_row_of_bare_columns_is_a_stretch(depth):
    """Doubled to 3.2 wavelengths it still relates fluxes and lines as the guided modes do."""
    n = depth.size
    fine = section(plate(CASES[0], thickness=0.9), order=8)
    for here, tolerance in ((fine, 1e-9), (depth, 1e-5)):
        n = here.size
        modes = guided_modes(here, FREQUENCY)
        block = repeated(condensed(here, FREQUENCY, width=0.2, electrode=None), 16)
        slow = np.flatnonzero(np.abs(modes.wavenumbers) < 10.0)
        step = np.exp(-1j * modes.wavenumbers[slow] * block.width)
        both = np.concatenate([modes.right[:, slow], modes.right[:, slow] * step])
        expected = np.concatenate([-modes.right_flux[:, slow], modes.right_flux[:, slow] * step])
        assert np.abs(block.matrix[: 2 * n, : 2 * n] @ both - expected).max() < tolerance * np.abs(block.matrix).max()


def test_mirrored_half_is_the_other_half():
    """Where x -> -x is a symmetry the second half is not computed: it must be what computing it gives."""
    for solid in CASES[:3]:
        depth, plain = (section(plate(solid, thickness=0.9), order=5, layers=1) for _ in range(2))
        assert depth.odd is not None
        plain.__dict__["odd"] = None  # as if it were no symmetry
        rising, falling = half_cells(Condensation(depth, FREQUENCY), SHAPE, RESOLUTION)
        _, computed = half_cells(Condensation(plain, FREQUENCY), SHAPE, RESOLUTION)
        assert close(falling.matrix, computed.matrix)
        assert (widths(falling)) == pytest.approx((widths(rising))[::-1], rel=1e-14)
        sides = np.sin(1.0 + np.arange(2 * depth.size + 2))
        for ours, theirs in zip(columns_from_left(falling, sides), columns_from_left(computed, sides), strict=True):
            assert ours[0] == pytest.approx(theirs[0], rel=1e-12)
            assert close(ours[2], theirs[2], 1e-9)


def test_uneven_gaps():
    """A first finger near an end: its halves are not each other's mirror image, in any solid."""
    uneven = FingerShape(half_finger=0.11, half_gaps=(0.05, 0.14))
    turned = FingerShape(half_finger=0.11, half_gaps=(0.14, 0.05))
    depth = section(plate(CASES[0], thickness=0.9), order=5, layers=1)
    n, odd = depth.size, np.where(depth.odd, -1.0, 1.0)
    one = finger_cell(Condensation(depth, FREQUENCY), uneven, RESOLUTION)
    other = finger_cell(Condensation(depth, FREQUENCY), turned, RESOLUTION)
    order = np.r_[n : 2 * n, 0:n, 2 * n : 2 * n + 2]
    signs = np.concatenate([odd, odd, [1.0, 1.0]])
    assert close(signs[:, None] * one.matrix[np.ix_(order, order)] * signs, other.matrix)
    assert one.width == pytest.approx(0.41, rel=1e-12)


def test_swapped_combs(depth):
    cell = finger_cell(Condensation(depth, FREQUENCY), SHAPE, RESOLUTION)
    n = depth.size
    other = exchanged(cell)
    assert np.array_equal(other.matrix[2 * n + 1], cell.matrix[2 * n][np.r_[0 : 2 * n, 2 * n + 1, 2 * n]])
    assert not np.any(other.matrix[2 * n])
    assert np.array_equal(exchanged(other).matrix, cell.matrix)


def test_lines_between_carry_no_force(depth):
    """What is found again between the columns: the neighbours' fluxes cancel on every inner line."""
    phi = depth.surface_dofs["phi"]
    n = depth.size
    cell = finger_cell(Condensation(depth, FREQUENCY), SHAPE, RESOLUTION)
    block = repeated(joined(cell, exchanged(cell)), 2)
    sides = np.cos(1.0 + np.arange(2 * n + 2)).astype(complex)
    columns = list(columns_from_left(block, sides))
    assert [start for start, _, _ in columns] == pytest.approx(np.append(0.0, np.cumsum(widths(block))[:-1]), rel=1e-12)
    size = max(np.abs(values).max() for _, _, values in columns) * np.abs(cell.matrix).max()
    for (_, left, before), (_, right, after) in pairwise(columns):
        assert np.array_equal(before[n : 2 * n], after[:n])
        balance = left.matrix[n : 2 * n] @ before + right.matrix[:n] @ after
        under = left.column.electrode is not None or right.column.electrode is not None
        balance[phi] *= not under  # there the finger takes the charge
        assert np.abs(balance).max() < 1e-11 * size
