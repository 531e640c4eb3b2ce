"""Sets of constants against published velocities and couplings, which are what the sets' files name as confirmation.

Surface waves are computed on a lossless half-space with the vacuum's field. Sources stand beside the values; without
one they are those that handbooks quote (Slobodnik, Conway and Delmonico 1973; Auld 1973; Campbell 1998).
"""

import numpy as np
import pytest

import fem

# name, cut, velocity in m/s and its tolerance, K2 in % as the literature states it (low, high)
WAVES = [
    (
        "LiTaO3 (Warner)",
        "YZ",
        3230,
        2e-3,
        (0.65, 0.74),
    ),  # Slobodnik, Conway and Delmonico (1973): 3230, 0.66; others 0.72
    ("LiTaO3 (Warner)", "X-112Y", 3295, 2e-3, (0.64, 0.75)),
    ("langasite (Bungo)", (0, 138.5, 26.6), 2734, 3e-3, (0.31, 0.38)),
    ("GaAs (McSkimin)", (45, 0, 0), 2863, 1e-3, (0.06, 0.075)),  # (001)[110]
    ("silicon (cubic)", "Z", 4921, 2e-3, None),  # (001)[100]
    ("silicon (cubic)", (45, 0, 0), 5082, 2e-3, None),  # (001)[110]
    ("fused silica", "Z", 3410, 2e-3, None),
    ("AlN (Tsubouchi)", "Z", 5760, 3e-2, None),  # Bu et al., IEEE Trans. UFFC 53 (2006) 251, single crystals
    ("AlN (McNeil)", "Z", 5760, 2e-2, None),
    ("LiNbO3 (Warner)", "YZ", 3488, 1e-3, (4.6, 5.0)),  # Slobodnik
    ("LiNbO3 (Warner)", "128YX", 3994, 1e-3, None),
    ("LiNbO3 (Kovacs)", "128YX", 3979, 1e-3, (5.3, 5.5)),
    ("quartz (Bechmann)", "ST-X", 3158, 1e-3, (0.11, 0.125)),
]
# name, direction, displacement, velocity in m/s: bulk waves, of ioffe.ru (McSkimin and Andreatch 1972; Adachi 1985)
# and, of the relaxor, of the paper of the set itself
BULK = [
    ("diamond (McSkimin)", (1, 0, 0), (1, 0, 0), 17520), ("diamond (McSkimin)", (1, 0, 0), (0, 0, 1), 12820),
    ("diamond (McSkimin)", (1, 1, 0), (1, 1, 0), 18320), ("diamond (McSkimin)", (1, 1, 0), (1, -1, 0), 11660),
    ("diamond (McSkimin)", (1, 1, 1), (1, 1, 1), 18580), ("diamond (McSkimin)", (1, 1, 1), (1, -1, 0), 12060),
    ("GaAs (McSkimin)", (1, 0, 0), (1, 0, 0), 4730), ("GaAs (McSkimin)", (1, 0, 0), (0, 0, 1), 3340),
    ("GaAs (McSkimin)", (1, 1, 0), (1, 1, 0), 5240), ("GaAs (McSkimin)", (1, 1, 0), (1, -1, 0), 2470),
    ("GaAs (McSkimin)", (1, 1, 1), (1, 1, 1), 5400), ("GaAs (McSkimin)", (1, 1, 1), (1, -1, 0), 2790),
    ("PMN-33PT (Zhang)", (1, 1, 0), (1, -1, 0), 880),
]  # fmt: skip


# name, k33, k15, d33 in pC/N: Berlincourt and Krueger (Morgan, TP-226), PI Ceramic, and the paper of the relaxor's set
COUPLINGS = [
    ("PZT-4", 0.70, 0.71, 289), ("PZT-5A", 0.705, 0.685, 374), ("PZT-5H", 0.752, 0.675, 593),
    ("PZT-8", 0.64, 0.55, 225), ("PZT-8 (Near)", 0.64, 0.55, 225), ("PIC181", 0.66, 0.63, None),
    ("PMN-33PT (Zhang)", 0.94, None, 2820),
]  # fmt: skip


@pytest.mark.parametrize(("name", "cut", "velocity", "near", "coupling"), WAVES)
def test_surface_waves(name, cut, velocity, near, coupling):
    solid = fem.rotated(fem.material(name), cut)
    assert fem.rayleigh(solid, "vacuum").velocity == pytest.approx(velocity, rel=near)
    if coupling is not None:
        low, high = coupling
        assert low <= 100 * fem.coupling(solid) <= high


@pytest.mark.parametrize(("name", "direction", "displacement", "velocity"), BULK)
def test_bulk_waves(name, direction, displacement, velocity):
    """Christoffel tensor of constant field; the waves named here carry no field, or a weak one."""
    solid = fem.material(name)
    n, u = (np.array(each) / np.linalg.norm(each) for each in (direction, displacement))
    strain = np.outer(n, u) + np.outer(u, n)
    voigt = np.array([*np.diag(strain) / 2, strain[1, 2], strain[0, 2], strain[0, 1]])
    modulus = voigt @ solid.stiffness @ voigt
    assert np.sqrt(modulus / solid.density) == pytest.approx(velocity, rel=3e-3)


@pytest.mark.parametrize(("name", "k33", "k15", "d33"), COUPLINGS)
def test_couplings_of_ceramics(name, k33, k15, d33):
    """k33 = d33 / sqrt(s33 eps33), k15 = d15 / sqrt(s55 eps11), measured on bars and plates by themselves."""
    solid = fem.material(name)
    compliance = np.linalg.inv(solid.stiffness)
    charge = solid.coupling @ compliance
    free = solid.permittivity + charge @ solid.coupling.T
    assert charge[2, 2] / np.sqrt(compliance[2, 2] * free[2, 2]) == pytest.approx(k33, rel=0.025)
    if k15 is not None:
        assert charge[0, 4] / np.sqrt(compliance[4, 4] * free[0, 0]) == pytest.approx(k15, rel=0.015)
    if d33 is not None:
        assert 1e12 * charge[2, 2] == pytest.approx(d33, rel=0.015)


def test_every_confirmation_is_one_of_these():
    confirmed = {name for name in fem.catalogue() if "confirmed" in fem.catalogue_table(name)}
    assert confirmed == {row[0] for row in (*WAVES, *BULK, *COUPLINGS)}
