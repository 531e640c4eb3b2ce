"""The depth's elements and matrices: against scikit-fem on a line, and by counting."""

import numpy as np
import pytest
from skfem import Basis, BilinearForm, ElementLinePp, MeshLine

from fem.discretize.element_sizes import LAYER_RATIO, graded
from fem.discretize.section import FIELD_COLUMN
from fem.discretize.vacuum import LAST_ALONG
from fem.materials.medium import vacuum_medium
from tests.fem.stators import FREQUENCY, cut, lossless, plate, section


@pytest.mark.parametrize("layers", [0, 1, 4])
@pytest.mark.parametrize(("length", "largest"), [(0.3, 1.0), (2.0, 1.0), (5.3, 0.7)])
def test_graded_sizes(length, largest, layers):
    sizes = graded(length, layers, largest=largest)
    assert sizes.sum() == pytest.approx(length, rel=1e-14)
    assert sizes.max() <= largest * (1 + 1e-9)
    assert np.array_equal(sizes[::-1], graded(length, layers, largest=largest, smallest_first=True))
    distances = np.cumsum(sizes[::-1])[: layers + 1]
    assert distances[:-1] == pytest.approx(LAYER_RATIO * distances[1:], rel=1e-12)


@pytest.mark.parametrize("above", ["none", "vacuum"])
@pytest.mark.parametrize("bottom", ["free", "grounded", "clamped", "absorbing"])
def test_unknowns(bottom, above):
    """Four fields less u_y, without those that the bottom holds; in the vacuum the potential alone."""
    depth = section(plate(cut("PZT-4", "Z"), bottom=bottom, above=above), layers=2)
    body, gap = depth.dofs[: depth.surface + 1], depth.dofs[depth.surface + 1 :]
    assert np.all(body[:, FIELD_COLUMN["uy"]] == -1)
    assert np.all(body[1:, [0, 2, 3]] >= 0)
    assert np.array_equal(
        body[0, [0, 3]] >= 0,
        {"free": [True, True], "grounded": [True, False], "clamped": [False, True], "absorbing": [False, False]}[
            bottom
        ],
    )
    assert np.all(gap[:, :3] == -1)
    assert np.all(gap[:, 3] >= 0)
    assert (len(gap) > 0) == (above == "vacuum")
    existing = depth.dofs[depth.dofs >= 0]
    assert np.array_equal(np.sort(existing), np.arange(depth.size))
    assert depth.floating_potential == (bottom in ("free", "clamped"))
    assert depth.nodes[depth.surface] == 0
    assert depth.nodes[0] < 0
    assert np.iscomplexobj(depth.heights) == (bottom == "absorbing")
    assert depth.constant_potential.sum() == (depth.dofs[:, 3] >= 0).sum()


def test_depth_is_the_thickness_and_its_elements_small_enough():
    stator = plate(cut("PZT-4", "Z"), thickness=3.7)
    depth = section(stator, layers=3, size=0.6)
    assert depth.nodes[0] == pytest.approx(-stator.thickness, rel=1e-14)
    assert depth.heights.max() <= 0.6
    assert depth.heights[-1] == pytest.approx(0.125 * LAYER_RATIO**3, rel=1e-12)
    bare = section(stator, layers=3, scale=np.inf)
    assert bare.heights.min() >= 0.9 - 1e-12


@pytest.mark.parametrize(
    ("solid", "rest"),
    [
        (cut("PZT-4", "Z"), {"above": "vacuum"}),
        (cut("PZT-4", "X"), {"bottom": "grounded"}),
        (lossless("LiNbO3 (Kovacs)", (17.0, 31.0, 49.0)), {"bottom": "clamped"}),
    ],
)
def test_matrices_of_a_stretch_are_those_of_scikit_fem(solid, rest):
    """K2, K1 and K0 - omega^2 M from one-dimensional forms on the same elements, field by field."""
    depth = section(plate(solid, **rest), order=5, layers=1)
    unit, body, order = depth.length_unit, depth.solid, depth.order
    nodes = depth.nodes / unit
    factor = (2 * np.pi * FREQUENCY * unit) ** 2
    expected = [np.zeros((depth.size, depth.size), dtype=np.asarray(body.xx).dtype) for _ in range(3)]
    for below, part in ((True, body), (False, vacuum_medium(body.stress_unit, body.potential_unit))):
        ends = depth.breakpoints[depth.breakpoints <= 0 if below else depth.breakpoints >= 0]
        if len(ends) < 2:
            continue
        basis = Basis(MeshLine(ends), ElementLinePp(order), intorder=2 * order)
        # the uppermost element of the vacuum conducts D along the surface better than vacuum
        along = 1.0 if below else LAST_ALONG
        mass, stiff, slope = (
            BilinearForm(form).assemble(basis).toarray()
            for form in (
                lambda u, v, w, along=along: np.where(w.x[0] > depth.breakpoints[-2], along, 1.0) * u * v,
                lambda u, v, _: u.grad[0] * v.grad[0],
                lambda u, v, _: v * u.grad[0],
            )
        )
        chosen = np.arange(depth.surface + 1) if below else np.arange(depth.surface, len(nodes))
        to_nodal = np.linalg.inv(basis.probes(nodes[chosen][None]).toarray())
        mass, stiff, slope = (to_nodal.T @ matrix @ to_nodal for matrix in (mass, stiff, slope))
        for row, name in enumerate(part.fields):
            for column, other in enumerate(part.fields):
                rows, columns = (
                    depth.dofs[chosen, FIELD_COLUMN[word]] if word in part.fields else None for word in (name, other)
                )
                keep = np.ix_(rows >= 0, columns >= 0)
                at = np.ix_(rows[rows >= 0], columns[columns >= 0])
                inertia = part.inertia[row] if row == column else 0.0
                expected[0][at] += (part.xx[row, column] * mass)[keep]
                expected[1][at] += (part.xz[row, column] * slope)[keep]
                expected[2][at] += (part.zz[row, column] * stiff - factor * inertia * mass)[keep]
    for ours, theirs in zip(depth.matrices(FREQUENCY), expected, strict=True):
        assert np.abs(ours - theirs).max() < 1e-11 * np.abs(theirs).max()


def test_motion_weights_measure_the_depth():
    depth = section(plate(cut("PZT-4", "Z"), thickness=2.3), layers=2)
    weights = np.zeros(depth.dofs.shape)
    weights[depth.dofs >= 0] = depth.motion_weights[depth.dofs[depth.dofs >= 0]]
    assert weights.sum(axis=0) == pytest.approx([2.3, 0.0, 2.3, 0.0], rel=1e-12)


def test_odd_unknowns():
    depth = section(plate(cut("PZT-4", "X")))
    assert np.array_equal(np.sort(depth.dofs[:, [0, 3]].ravel()), np.flatnonzero(depth.odd))
    assert section(plate(cut("LiNbO3 (Warner)", "YZ"))).odd is None


def test_absorbing_bottom_is_a_half_space_at_any_thickness():
    """A thin block's absorber stands off the surface as far as a half-space's, or it would err by 1e-4."""
    thin, endless = (
        section(plate(cut("PZT-4", "Z"), thickness=thickness, bottom="absorbing"), layers=1)
        for thickness in (0.3, np.inf)
    )
    assert np.array_equal(thin.heights, endless.heights)


def test_surface_speed():
    """The half-space's, where the cut has a surface wave."""
    assert section(plate(lossless("PZT-4", "Z"))).surface_speed == pytest.approx(2255, abs=60)
    assert section(plate(cut("PZT-4", (0.0, 20.0, 0.0)))).surface_speed is None
