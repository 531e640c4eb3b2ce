"""The field on its mesh: the surface's motion, electrodes, gauge, equations of the interior, and the file."""

import numpy as np
import pytest

from fem.discretize.spectral import line_nodes
from fem.materials import fields
from fem.results.field_files import write_vtu
from fem.results.interior_field import WaveField, wave_field
from tests.fem.stators import FREQUENCY, comb, cut, lossless, plate, solution, wave_of

CASES = (
    (cut("PZT-8", "Z"), {"ends": "free"}),
    (cut("PZT-5H", "X"), {"ends": "absorbing", "bottom": "grounded"}),
    (cut("PZT-8", "X"), {"ends": "free"}),
    (lossless("LiNbO3 (Warner)", "YZ"), {"ends": "absorbing"}),
    (cut("LiNbO3 (Ogi)", (17.0, 31.0, 49.0)), {"ends": "clamped"}),
    (cut("PZT-4", "Z"), {"ends": "free", "above": "vacuum", "bottom": "clamped"}),
)


@pytest.fixture(scope="module", params=CASES, ids=[f"{solid.name} {solid.frame}" for solid, _ in CASES])
def case(request):
    solid, rest = request.param
    stator = plate(solid, length=7.0, **rest)
    row = comb(stator, "a", 1.7, finger_pairs=2), comb(stator, "b", 5.3, period=0.9)
    wave = wave_of(solution(stator, row, order=8))
    return wave, wave_field(wave, per_wavelength=24)


def test_surface_of_the_field_is_the_surface_motion(case):
    wave, field = case
    assert np.all(np.diff(field.x) > 0)
    assert np.all(np.diff(field.z) > 0)
    assert (field.x[0], field.x[-1]) == pytest.approx((0, wave.length))
    assert field.z[-1] == 0
    assert field.z[0] == pytest.approx(-wave.solution.fields.stator.thickness, rel=1e-12)
    motion = wave.motion(np.clip(field.x, 0, wave.length))
    size = np.abs(motion).max()
    assert np.abs(field.displacement[:, -1, [0, 2]] - motion.T).max() < 1e-8 * size
    if "uy" not in fields(wave.solution.fields.stator.solid):
        assert not np.any(field.displacement[:, :, 1])


def test_fingers_are_equipotential(case):
    """One volt between the driven electrodes, their mean zero where it is a matter of gauge."""
    wave, field = case
    driven, other = wave.solution.fields.transducers
    potentials = [
        field.potential[(field.x >= left - 1e-12) & (field.x <= right + 1e-12), -1]
        for transducer in (driven, other)
        for left, right in transducer.fingers
    ]
    assert min(len(values) for values in potentials) > 8
    assert max(np.abs(values - values[0]).max() for values in potentials) < 1e-9
    a = [values[0] for values in potentials[: 2 * driven.finger_pairs]]
    assert np.subtract(a[::2], a[1::2]) == pytest.approx(1.0, abs=1e-9)
    if wave.solution.fields.section.floating_potential:
        assert np.add(a[::2], a[1::2]) == pytest.approx(0.0, abs=1e-9)


def test_potential_is_continuous(case):
    """One gauge for all stretches and transducers: along every line the next node is the next value.

    Quadratic extrapolation over each border, against the same over ordinary nodes.
    """
    wave, field = case
    borders = [piece.start for piece in wave.pieces[1:]]
    middle = len(field.z) // 2
    phi = field.potential[:, middle]
    jump = []
    for index in range(3, len(field.x) - 1):
        nodes, at = field.x[index - 3 : index], field.x[index]
        weights = [np.prod([(at - other) / (node - other) for other in nodes if other != node]) for node in nodes]
        jump.append(abs(weights @ phi[index - 3 : index] - phi[index]) / np.abs(weights).sum())
    jump = np.array(jump)
    at_border = [int(np.searchsorted(field.x, border + 1e-12)) - 3 for border in borders]
    assert jump[at_border].max() < 4 * np.sort(jump)[-len(jump) // 20] + 1e-4 * np.abs(phi).max()


def test_field_satisfies_the_equations():
    """C_xx u_xx + (C_xz + C_xz^T) u_xz + C_zz u_zz + omega^2 rho u = 0 at points of a stretch, by differentiation.

    x derivatives of the sum of modes by differences, z derivatives by the elements' polynomials.
    """
    from fem.discretize.spectral import gll_nodes, lagrange
    from fem.materials.medium import medium

    solid = cut("LiNbO3 (Ogi)", (17.0, 31.0, 49.0), quality=300.0)
    stator = plate(solid, length=6.0, thickness=0.9)
    wave = wave_of(solution(stator, (comb(stator, "a", 1.5),), order=12))
    section = wave.solution.fields.section
    field = wave_field(wave, per_wavelength=600)
    body = medium(solid, fields(solid))
    unit = section.length_unit
    values = np.concatenate([field.displacement, field.potential[:, :, None] / body.potential_unit], axis=2)
    values = values[:, : section.order + 1]  # the lowest element
    index = int(np.searchsorted(field.x, 4.0 * unit))
    h = (field.x[index + 1] - field.x[index]) / unit
    u_x = (values[index + 1] - values[index - 1]) / (2 * h)
    u_xx = (values[index + 1] - 2 * values[index] + values[index - 1]) / h**2
    _, slope = lagrange(section.order, gll_nodes(section.order))
    slope = slope / section.heights[0]
    u_zz, u_xz = slope @ slope @ values[index], slope @ u_x
    inertia = (2 * np.pi * FREQUENCY * unit) ** 2 * body.inertia * values[index]
    residual = u_xx @ body.xx.T + u_xz @ (body.xz + body.xz.T).T + u_zz @ body.zz.T + inertia
    inner = slice(2, -2)
    assert np.abs(residual[inner]).max() < 1e-3 * np.abs(inertia).max()


def test_file_keeps_every_digit(case, tmp_path):
    import meshio

    _, field = case
    path = tmp_path / "field.vtu"
    write_vtu(field, path)
    mesh = meshio.read(path)
    assert np.array_equal(np.unique(mesh.points[:, 0]), field.x)
    assert np.array_equal(np.unique(mesh.points[:, 2]), field.z)
    for name, exact in (("displacement_m_per_V", field.displacement), ("potential_V_per_V", field.potential)):
        back = mesh.point_data[f"{name}_real"] + 1j * mesh.point_data[f"{name}_imag"]
        assert np.array_equal(back.reshape(exact.shape), exact)


def test_file_is_a_mesh_of_the_section(case, tmp_path):
    """Quadrilaterals that cover length times thickness, all turned the same way."""
    import meshio

    wave, field = case
    path = tmp_path / "field.vtu"
    write_vtu(field, path)
    mesh = meshio.read(path)
    corners = mesh.points[mesh.cells_dict["quad"]]
    assert not np.any(mesh.points[:, 1])
    along, up = corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0]
    areas = along[:, 0] * up[:, 2]
    assert areas.min() > 0
    assert areas.sum() == pytest.approx(wave.length * wave.solution.fields.stator.thickness, rel=1e-9)
    assert "displacement_m_per_V_real" in mesh.point_data
    assert "potential_V_per_V_imag" in mesh.point_data


@pytest.mark.parametrize("span", [(0.2, 0.8), (1.1, 3.0), (4.2, 4.9), (4.0, 7.0)])
def test_a_span_of_the_field_is_the_field_there(case, span):
    """Cut anywhere: in a stretch, under a transducer, past both; finer lines, the same field and gauge."""
    wave, field = case
    low, high = (place * wave.length / 7.0 for place in span)
    part = wave_field(wave, per_wavelength=48, span=(low, high), places=tuple(field.x))
    assert low <= part.x[0] < part.x[-1] <= high * (1 + 1e-12)
    assert np.all(np.diff(part.x) > 0)
    _, ours, theirs = np.intersect1d(part.x.round(13), field.x.round(13), return_indices=True)
    assert len(ours) == np.count_nonzero((field.x >= low) & (field.x <= high))
    size = abs(field.potential).max(), abs(field.displacement).max()
    assert abs(part.potential[ours] - field.potential[theirs]).max() < 1e-9 * size[0]
    assert abs(part.displacement[ours] - field.displacement[theirs]).max() < 1e-9 * size[1]


def test_a_line_stands_where_it_is_wanted(case):
    wave, _ = case
    place = 0.5123 * wave.length
    field = wave_field(wave, places=(place,))
    assert np.count_nonzero(field.x == place) == 1
    assert np.all(np.diff(field.x) > 0)
    motion = field.displacement[field.x == place][0, -1, [0, 2]]
    assert motion == pytest.approx(wave.motion(place), rel=1e-10)


def test_between_nodes_the_elements_polynomials_hold():
    """Three elements, on each a polynomial of its order; ends are shared."""
    order, ends = 4, np.array([-3.0, -1.0, -0.4, 0.0])
    z = line_nodes(ends, order)
    field = WaveField(
        x=np.zeros(1), z=z, displacement=np.zeros((1, 13, 3)), potential=np.zeros((1, 13)), frequency=1.0, order=order
    )

    def broken(at):
        return at**4 + np.where(at > -1, 5 * (at + 1) ** 3, 0.0) - np.where(at > -0.4, 9 * (at + 0.4) ** 2, 0.0)

    np.testing.assert_allclose(field.depth_basis(z), np.eye(13), atol=1e-13)
    heights = np.linspace(-3, 0, 101)
    np.testing.assert_allclose(field.depth_basis(heights) @ broken(z), broken(heights), atol=1e-11)
