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
# One generator of each point group besides the threefold or continuous axis 3.
MIRROR_1, TWOFOLD_1 = np.diag([-1.0, 1.0, 1.0]), np.diag([1.0, -1.0, -1.0])
DIAGONAL = np.eye(3)[[1, 2, 0]]  # threefold axis [111]
CRYSTALS = {
    # class, density, constants in GPa, C/m2 and relative to vacuum, by their names
    "LiTaO3 (Warner)": ("3m", 7450, """
        c11 233 c33 275 c44 94 c12 47 c13 80 c14 -11 e15 2.6 e22 1.6 e33 1.9 eps11 41 eps33 43
        """),
    "AlN (Tsubouchi)": ("6mm", 3260, """
        c11 345 c33 395 c44 118 c12 125 c13 120 e15 -.48 e31 -.58 e33 1.55 eps11 9.04 eps33 10.73
        """),
    "AlN (McNeil)": ("6mm", 3260, """
        c11 410 c33 388.5 c44 124.6 c12 148.5 c13 98.9 e15 -.48 e31 -.58 e33 1.55 eps11 9.04 eps33 10.73
        """),
    "ZnO (Bateman)": ("6mm", 5680, """
        c11 209.7 c33 210.9 c44 42.47 c12 121.1 c13 105.1 e15 -.48 e31 -.573 e33 1.32 eps11 8.55 eps33 10.2
        """),
    "ScAlN 30 % (Caro)": ("6mm", 3400, """
        c11 331.6 c33 241.1 c44 108.1 c12 146.3 c13 134.3 e15 -.32 e31 -.72 e33 2.24 eps11 14.1 eps33 14.1
        """),
    "langasite (Bungo)": ("32", 5739, """
        c11 188.75 c33 261.4 c44 53.5 c12 104.75 c13 95.89 c14 14.12 e11 -.437 e14 .104 eps11 18.92 eps33
        50.7
        """),
    "GaAs (McSkimin)": ("-43m", 5316.9, """
        c11 118.77 c33 118.77 c44 59.44 c12 53.72 c13 53.72 e14 -.16 eps11 12.5 eps33 12.5
        """),
    "silicon (cubic)": ("m3m", 2331, """
        c11 165.7 c22 165.7 c66 79.56 c23 63.9 eps11 11.7 eps33 11.7
        """),
    "diamond (McSkimin)": ("m3m", 3515, """
        c11 1079 c22 1079 c66 578 c23 124 eps11 5.67 eps33 5.67
        """),
    "sapphire (Wachtman)": ("-3m", 3980, """
        c11 496.8 c33 498.1 c44 147.4 c12 163.6 c13 110.9 c14 -23.5 eps11 9.4 eps33 11.5
        """),
    "fused silica": ("m3m", 2203, """
        c11 78.5 c22 78.5 c66 31.2 c23 16.1 eps11 3.78 eps33 3.78
        """),
}  # fmt: skip
# 1/TPa, pC/N, relative to vacuum; class 4mm
RELAXOR = "s11 69.0 s12 -11.1 s13 -55.7 s33 119.6 s44 14.5 s66 15.2 d15 146 d31 -1330 d33 2820 eps11 1600 eps33 8200"
GENERATORS = {  # angle of a turn about 3, another operation
    "3m": (120.0, MIRROR_1), "6mm": (37.0, MIRROR_1), "32": (120.0, TWOFOLD_1), "-3m": (120.0, MIRROR_1),
    "-43m": (180.0, DIAGONAL), "m3m": (90.0, DIAGONAL),
}  # fmt: skip
METALS = {
    "SU-8": (4.4e9, 0.22, 1190), "epoxy": (4.25e9, 0.38, 1160), "gold": (78.9e9, 0.42, 19300),
    "platinum": (167e9, 0.304, 21400), "chromium": (279e9, 0.21, 7190), "titanium": (116e9, 0.32, 4500),
}  # fmt: skip
ISOTROPIC |= METALS
VOIGT = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


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


def by_name(text: str) -> dict[str, float]:
    parts = text.split()
    return {name: float(value) for name, value in zip(parts[::2], parts[1::2], strict=True)}


@pytest.mark.parametrize("name", CRYSTALS)
def test_other_crystals(name):
    kind, density, text = CRYSTALS[name]
    values, solid = by_name(text), material(name)
    relative = values.pop("eps11"), values.pop("eps33")
    stiffness = {each[1:]: value for each, value in values.items() if each[0] == "c"}
    coupling = {each[1:]: value for each, value in values.items() if each[0] == "e"}
    assert_entries(solid, stiffness, coupling, relative, density)
    degrees, other = GENERATORS[kind]
    assert_invariant(solid, (about_axis_3(degrees), other))


def test_a_relaxor_is_the_inverse_of_its_compliances():
    """Class 4mm from s^E, d and eps^T: c s = 1, e = d c, eps^S + e d^T = eps^T."""
    values, solid = by_name(RELAXOR), material("PMN-33PT (Zhang)")
    compliance = np.linalg.inv(solid.stiffness) * 1e12
    charge = solid.coupling @ compliance
    free = solid.permittivity / VACUUM_PERMITTIVITY + charge * 1e-12 @ solid.coupling.T / VACUUM_PERMITTIVITY
    tables = {"s": compliance, "d": charge, "e": free}
    for name, value in values.items():
        row, column = int(name[-2]) - 1, int(name[-1]) - 1
        assert tables[name[0]][row, column] == pytest.approx(value, rel=1e-9), name
    assert solid.density == 8060


def test_no_solid_escapes_the_tables():
    known = {*CERAMICS, *NIOBATES, "quartz (Bechmann)", *ISOTROPIC, *CRYSTALS, "PMN-33PT (Zhang)"}
    assert set(catalogue()) == known
    assert all(solid.name == name and solid.source for name, solid in catalogue().items())
