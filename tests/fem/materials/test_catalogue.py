"""Every number of the catalogue against the published tables, typed here a second time.

Truth: the publications that each set names.  GPa, C/m2, permittivity relative to vacuum, kg/m3.  The symmetry of the
crystal class is applied here by Neumann's principle (the tensors are averaged over the point group), not by the rules
that `fem.materials.tables` uses.
"""

import numpy as np
import pytest

from fem.materials import VACUUM_PERMITTIVITY, catalogue, material

CERAMICS = {
    # c11, c12, c13, c33, c44; e31, e33, e15; eps11, eps33; density, mechanical_quality, dielectric_loss
    "PZT-4": (139, 77.8, 74.3, 115, 25.6, -5.2, 15.1, 12.7, 730, 635, 7500, 500, 0.004),
    "PZT-8": (146.9, 81.1, 81.1, 131.7, 31.35, -3.88, 13.91, 10.34, 904, 562, 7600, 1000, 0.004),
    "PZT-8 (Near)": (137, 69.7, 71.6, 124, 31.3, -4.0, 13.8, 10.3, 900, 582, 7600, 1000, 0.004),
    "PZT-5A": (121, 75.9, 75.4, 111, 21.1, -5.4, 15.8, 12.3, 916, 830, 7750, 70, 0.02),
    "PZT-5H": (126, 79.5, 84.1, 117, 23.0, -6.5, 23.3, 17.0, 1700, 1470, 7500, 65, 0.02),
    "PIC181": (152.3, 89.1, 85.5, 134, 28.3, -4.5, 14.7, 11.0, 740, 634, 7850, 2000, 0.003),
}
NIOBATES = {
    # c11, c12, c13, c14, c33, c44; e15, e22, e31, e33; eps11, eps33; density
    "LiNbO3 (Warner)": (203, 53, 75, 9, 245, 60, 3.7, 2.5, 0.2, 1.3, 44, 29, 4700),
    "LiNbO3 (Ogi)": (199.5, 55.27, 67.67, 8.70, 235.2, 59.48, 3.65, 2.39, 0.31, 1.72, 45.05, 26.2, 4640),
    "LiNbO3 (Kovacs)": (*(198.39, 54.72, 65.13, 7.88, 227.9, 59.65), *(3.69, 2.42, 0.30, 1.77, 45.6, 26.3, 4628)),
}
# c11, c12, c13, c14, c33, c44; e11, e14; eps11, eps33 in F/m; density
QUARTZ = (86.74, 6.99, 11.91, -17.91, 107.2, 57.94, 0.171, -0.0406, 3.921e-11, 4.103e-11, 2649)
ISOTROPIC = {  # Young's modulus in Pa, Poisson ratio, density
    "steel": (210e9, 0.30, 7850),
    "aluminium": (70e9, 0.34, 2700),
    "silicon": (162e9, 0.22, 2330),
}
VOIGT = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
# One generator of each point group besides the threefold or continuous axis 3.
MIRROR_1, TWOFOLD_1 = np.diag([-1.0, 1.0, 1.0]), np.diag([1.0, -1.0, -1.0])


def about_axis_3(degrees: float) -> np.ndarray:
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def stiffness_tensor(table: np.ndarray) -> np.ndarray:
    tensor = np.empty((3, 3, 3, 3))
    for row, (i, j) in enumerate(VOIGT):
        for column, (k, m) in enumerate(VOIGT):
            tensor[i, j, k, m] = tensor[j, i, k, m] = tensor[i, j, m, k] = tensor[j, i, m, k] = table[row, column]
    return tensor


def coupling_tensor(table: np.ndarray) -> np.ndarray:
    tensor = np.empty((3, 3, 3))
    for column, (k, m) in enumerate(VOIGT):
        tensor[:, k, m] = tensor[:, m, k] = table[:, column]
    return tensor


def assert_invariant(solid, operations) -> None:
    """Neumann's principle: every symmetry of the point group leaves all three tensors as they are."""
    stiffness, coupling = stiffness_tensor(solid.stiffness), coupling_tensor(solid.coupling)
    for a in operations:
        turned = np.einsum("ip,jq,kr,ls,pqrs", a, a, a, a, stiffness)
        assert np.abs(turned - stiffness).max() < 1e-14 * np.abs(stiffness).max()
        turned = np.einsum("ip,jq,kr,pqr", a, a, a, coupling)
        assert np.abs(turned - coupling).max() <= 1e-14 * np.abs(coupling).max()
        turned = a @ solid.permittivity @ a.T
        assert np.abs(turned - solid.permittivity).max() < 1e-14 * np.abs(solid.permittivity).max()


def assert_entries(solid, stiffness: dict, coupling: dict, permittivity: tuple, density: float) -> None:
    """Entries by their two-digit names; numbers of one set must be equal to the last digit but one."""
    for name, value in stiffness.items():
        row, column = (int(digit) - 1 for digit in name)
        assert solid.stiffness[row, column] == pytest.approx(value * 1e9, rel=1e-14), f"c{name}"
    for name, value in coupling.items():
        row, column = (int(digit) - 1 for digit in name)
        assert solid.coupling[row, column] == pytest.approx(value, rel=1e-14), f"e{name}"
    relative = np.diag(solid.permittivity) / VACUUM_PERMITTIVITY
    assert relative == pytest.approx([permittivity[0], permittivity[0], permittivity[1]], rel=1e-14)
    assert solid.density == density


@pytest.mark.parametrize("name", CERAMICS)
def test_poled_ceramics(name):
    """Class 6mm: the listed constants, the symmetry of the class, both loss factors."""
    c11, c12, c13, c33, c44, e31, e33, e15, eps11, eps33, density, quality, loss = CERAMICS[name]
    solid = material(name)
    stiffness = {"11": c11, "12": c12, "13": c13, "33": c33, "44": c44}
    assert_entries(solid, stiffness, {"31": e31, "33": e33, "15": e15}, (eps11, eps33), density)
    assert_invariant(solid, (about_axis_3(37.0), MIRROR_1))
    assert solid.mechanical_quality == quality
    assert solid.dielectric_loss == loss


@pytest.mark.parametrize("name", NIOBATES)
def test_lithium_niobate(name):
    """Class 3m, the mirror plane perpendicular to axis 1; no loss."""
    c11, c12, c13, c14, c33, c44, e15, e22, e31, e33, eps11, eps33, density = NIOBATES[name]
    solid = material(name)
    stiffness = {"11": c11, "12": c12, "13": c13, "14": c14, "33": c33, "44": c44}
    coupling = {"15": e15, "22": e22, "31": e31, "33": e33}
    assert_entries(solid, stiffness, coupling, (eps11, eps33), density)
    assert_invariant(solid, (about_axis_3(120.0), MIRROR_1))
    assert not solid.is_lossy


def test_quartz():
    """Class 32, the twofold axis along axis 1; no loss."""
    c11, c12, c13, c14, c33, c44, e11, e14, eps11, eps33, density = QUARTZ
    solid = material("quartz (Bechmann)")
    stiffness = {"11": c11, "12": c12, "13": c13, "14": c14, "33": c33, "44": c44}
    relative = (eps11 / VACUUM_PERMITTIVITY, eps33 / VACUUM_PERMITTIVITY)
    assert_entries(solid, stiffness, {"11": e11, "14": e14}, relative, density)
    assert_invariant(solid, (about_axis_3(120.0), TWOFOLD_1))
    assert not solid.is_lossy


@pytest.mark.parametrize("name", ISOTROPIC)
def test_isotropic_solids(name):
    modulus, ratio, density = ISOTROPIC[name]
    solid = material(name)
    compliance = np.linalg.inv(solid.stiffness)
    assert 1 / compliance[0, 0] == pytest.approx(modulus, rel=1e-13)
    assert -compliance[0, 1] / compliance[0, 0] == pytest.approx(ratio, rel=1e-13)
    assert solid.density == density
    assert_invariant(solid, (about_axis_3(37.0), about_axis_3(37.0)[np.ix_([2, 0, 1], [2, 0, 1])]))
    assert not solid.is_piezoelectric
    assert not solid.is_lossy


def test_no_solid_escapes_the_tables():
    assert set(catalogue()) == {*CERAMICS, *NIOBATES, "quartz (Bechmann)", *ISOTROPIC}
    assert all(solid.name == name and solid.source for name, solid in catalogue().items())
