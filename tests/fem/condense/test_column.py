"""Condensed columns: the waves they must pass, the gauge they must keep, dense elimination done apart."""

import numpy as np
import pytest

from fem.condense.cascade_piece import ELECTRODES
from fem.condense.element_column import ColumnField
from fem.condense.finger_columns import condensed
from fem.discretize.element_matrices import element_matrix
from fem.discretize.section import FIELD_COLUMN
from fem.waveguide.guided_modes import guided_modes
from tests.fem.stators import FREQUENCY, cut, lossless, plate, section

CASES = (
    (cut("PZT-4", "Z"), {}),
    (lossless("PZT-5H", "X"), {"bottom": "clamped"}),
    (lossless("LiNbO3 (Warner)", "YZ"), {"bottom": "grounded"}),
    (cut("LiNbO3 (Kovacs)", (17.0, 31.0, 49.0), quality=200.0), {}),
    (cut("PZT-4", "Z"), {"above": "vacuum"}),
    (lossless("LiNbO3 (Kovacs)", "128YX"), {"bottom": "absorbing"}),
)
NAMES = [f"{solid.name} {solid.frame} {' '.join(rest.values())}" for solid, rest in CASES]
WIDTH = 0.21


@pytest.fixture(scope="module", params=CASES, ids=NAMES)
def depth(request):
    solid, rest = request.param
    return section(plate(solid, thickness=0.9, **rest), order=8)


def test_bare_column_passes_the_guided_modes(depth):
    """Lines v and v exp(-i k w) meet the fluxes -f and f exp(-i k w); slow modes, which order 8 resolves along x."""
    n = depth.size
    modes = guided_modes(depth, FREQUENCY)
    block = condensed(depth, FREQUENCY, width=WIDTH, electrode=None)
    for wavenumbers, shapes, flux in (
        (modes.wavenumbers, modes.right, modes.right_flux),
        (modes.backwards, modes.left, modes.left_flux),
    ):
        slow = np.flatnonzero(np.abs(wavenumbers) < 10.0)
        step = np.exp(-1j * wavenumbers[slow] * WIDTH)
        lines = np.concatenate([shapes[:, slow], shapes[:, slow] * step])
        expected = np.concatenate([-flux[:, slow], flux[:, slow] * step])
        ours = block.matrix[: 2 * n, : 2 * n] @ lines
        assert len(slow) >= 3
        assert np.abs(ours - expected).max() < 1e-9 * np.abs(block.matrix).max()
    assert not np.any(block.matrix[2 * n :])


@pytest.mark.parametrize("comb", [None, 0, 1])
def test_constant_potential_is_a_gauge(depth, comb):
    """All potentials and the comb's raised by one volt: no flux and no charge, where nothing is grounded."""
    n = depth.size
    block = condensed(depth, FREQUENCY, width=WIDTH, electrode=comb)
    raised = np.concatenate([depth.constant_potential, depth.constant_potential, np.zeros(len(ELECTRODES))])
    if comb is not None:
        raised[[depth.surface_dofs["phi"], n + depth.surface_dofs["phi"]]] = 0.0
        raised[2 * n + comb] = 1.0
    size = np.abs(block.matrix @ raised).max() / np.abs(block.matrix).max()
    assert (size < 1e-13) == depth.floating_potential
    assert np.abs(block.matrix - block.matrix.T).max() == 0


@pytest.mark.parametrize("comb", [None, 0, 1])
def test_recovered_field_is_in_equilibrium_inside(depth, comb):
    """The matrices of the elements, assembled here: no reactions between the lines but those on the finger."""
    order, column = depth.order, condensed(depth, FREQUENCY, width=WIDTH, electrode=comb).column
    sides = np.random.default_rng(3).normal(size=(2 * depth.size + len(ELECTRODES), 2)) + 0j
    values = ColumnField(column).values(sides)  # (order + 1, nodes, fields, 2)
    reactions, largest = np.zeros_like(values), 0.0
    for element, (height, medium) in enumerate(zip(depth.heights, depth.media, strict=True)):
        matrix = element_matrix(medium, WIDTH, height, order, 2 * np.pi * FREQUENCY * depth.length_unit)
        nodes = slice(element * order, (element + 1) * order + 1)
        fields = [FIELD_COLUMN[name] for name in medium.fields]
        own = values[:, nodes][:, :, fields]
        reactions[:, nodes, fields] += (matrix @ own.reshape(len(matrix), 2)).reshape(own.shape)
        largest = max(largest, abs(matrix).max() * abs(own).max())
    phi = FIELD_COLUMN["phi"]
    if comb is not None:
        assert np.all(values[:, depth.surface, phi] == sides[2 * depth.size + comb])
        charge = column.matrix[2 * depth.size + comb] @ sides
        np.testing.assert_allclose(reactions[:, depth.surface, phi].sum(axis=0), charge, atol=1e-10 * largest)
        reactions[:, depth.surface, phi] = 0.0
    free = (depth.dofs >= 0)[None, ..., None]
    assert abs(np.where(free, reactions, 0.0)[1:-1]).max() < 1e-10 * largest


def test_combs_differ_by_name_only(depth):
    first, second = (condensed(depth, FREQUENCY, width=WIDTH, electrode=comb).matrix for comb in (0, 1))
    n = depth.size
    order = np.r_[0 : 2 * n, 2 * n + 1, 2 * n]
    # but for rounding, which depends on where the arrays lie in memory
    assert np.abs(first[np.ix_(order, order)] - second).max() < 1e-15 * np.abs(first).max()
    corner = depth.surface_dofs["phi"]
    assert not np.any(first[[corner, n + corner]])


def test_finger_charges_its_capacitor():
    """A thin grounded plate in long waves: q = (eps-term + e33^2/c33) w/d for one volt, T_33 = 0, d the thickness."""
    solid = lossless("PZT-4", "Z")
    thickness = 0.05
    deep = section(plate(solid, thickness=thickness, bottom="grounded"), order=4, frequency=FREQUENCY)
    n = deep.size
    tiny = 1e-6 * FREQUENCY
    block = condensed(deep, tiny, width=0.3, electrode=0)
    body = deep.solid
    z = deep.nodes / deep.length_unit + thickness
    line = np.zeros(n)
    phi = deep.dofs[:, 3]
    line[phi[phi >= 0]] = (z / thickness)[phi >= 0]
    stretch = -body.zz[1, 2] / body.zz[1, 1]  # T_33 = 0
    line[deep.dofs[:, 2]] = stretch * z / thickness
    lines = np.concatenate([line, line, [1.0, 0.0]])
    lines[[deep.surface_dofs["phi"], n + deep.surface_dofs["phi"]]] = 0.0
    charge = block.matrix[2 * n] @ lines
    expected = (body.zz[2, 2] + body.zz[1, 2] * stretch) * 0.3 / thickness
    assert charge == pytest.approx(expected, rel=1e-9)
    assert charge < 0
