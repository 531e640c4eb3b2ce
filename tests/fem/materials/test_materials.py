"""Solids: what is refused and in which words; the catalogue against the entries of the published tables."""

import numpy as np
import pytest

from fem.materials import VACUUM_PERMITTIVITY, Solid, anisotropic, catalogue, isotropic, material

PZT = material("PZT-4")
TABLES = {
    "name": "mine",
    "stiffness": PZT.stiffness,
    "coupling": PZT.coupling,
    "permittivity": PZT.permittivity / VACUUM_PERMITTIVITY,
    "density": 7500,
}


def changed(table, place, value):
    table = np.array(table)
    table[place] = value
    return table


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"stiffness": changed(PZT.stiffness, (5, 5), -1.2e9)},
            r"stiffness must be positive definite; its smallest eigenvalue is -1\.2e\+09 Pa",
        ),
        (
            {"stiffness": changed(PZT.stiffness, (0, 2), 7.4e10)},
            r"stiffness must be symmetric; entries \(1, 3\) and \(3, 1\) are 7\.4e\+10 and 7\.43e\+10 Pa",
        ),
        ({"stiffness": changed(PZT.stiffness, (1, 3), np.nan)}, r"stiffness must be finite; entry \(2, 4\) is nan Pa"),
        ({"stiffness": np.eye(3)}, r"stiffness must be a table of 6 rows of 6 numbers \(Pa\), .*\(3, 3\)"),
        ({"stiffness": [[1, 2], [3]]}, r"stiffness must be a table of 6 rows of 6 numbers \(Pa\)"),
        ({"coupling": np.zeros((6, 3))}, r"coupling must be a table of 3 rows of 6 numbers \(C/m2\)"),
        (
            {"permittivity": np.diag([4, 4, -2])},
            r"permittivity must be positive definite; its smallest eigenvalue is -2 relative to vacuum",
        ),
        ({"density": 0}, r"density must be positive and finite, got 0 kg/m\^3"),
        ({"density": np.nan}, r"density must be positive and finite, got nan kg/m\^3"),
        ({"mechanical_quality": 0}, r"mechanical_quality must be positive, got 0"),
        ({"mechanical_quality": np.nan}, r"mechanical_quality must be positive, got nan"),
        ({"dielectric_loss": -0.1}, r"dielectric_loss must be zero or positive, got -0\.1"),
    ],
)
def test_refusals_name_the_key_the_rule_the_value_and_the_unit(change, message):
    with pytest.raises(ValueError, match=message):
        anisotropic(**TABLES | change)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"poisson_ratio": 0.5}, r"poisson_ratio must be above -1 and below 0\.5, got 0\.5"),
        ({"poisson_ratio": -1.0}, r"poisson_ratio must be above -1 and below 0\.5, got -1\.0"),
        ({"poisson_ratio": np.nan}, r"poisson_ratio must be above -1 and below 0\.5, got nan"),
        ({"youngs_modulus": -1.0}, r"youngs_modulus must be positive and finite, got -1\.0 Pa"),
    ],
)
def test_isotropic_refusals(change, message):
    with pytest.raises(ValueError, match=message):
        isotropic(**{"name": "x", "youngs_modulus": 7e10, "poisson_ratio": 0.3, "density": 2700.0} | change)


def test_user_table_equals_the_catalogue():
    solid = anisotropic(**TABLES)
    assert np.array_equal(solid.stiffness, PZT.stiffness)
    assert np.allclose(solid.permittivity, PZT.permittivity, rtol=1e-15, atol=0)


def test_solids_are_values():
    assert anisotropic(**TABLES) == anisotropic(**TABLES)
    assert hash(anisotropic(**TABLES)) == hash(anisotropic(**TABLES))
    assert anisotropic(**TABLES) != anisotropic(**TABLES | {"density": 7501})
    with pytest.raises(ValueError, match="read-only"):
        PZT.stiffness[0, 0] = 1.0


def test_losses_dissipate():
    """Stored energy lags: Im c > 0 and Im eps < 0 with exp(+i omega t)."""
    assert PZT.is_lossy
    assert np.allclose(PZT.stiffness_lossy, PZT.stiffness * (1 + 1j / 500), rtol=1e-15, atol=0)
    assert np.allclose(PZT.permittivity_lossy, PZT.permittivity * (1 - 0.004j), rtol=1e-15, atol=0)
    quartz = material("quartz (Bechmann)")
    assert not quartz.is_lossy
    assert not np.any(quartz.stiffness_lossy.imag)


def test_isotropic_solid_returns_its_constants():
    steel = material("steel")
    compliance = np.linalg.inv(steel.stiffness)
    assert 1 / compliance[0, 0] == pytest.approx(210e9, rel=1e-12)
    assert -compliance[0, 1] / compliance[0, 0] == pytest.approx(0.3, rel=1e-12)
    assert 1 / compliance[3, 3] == pytest.approx(210e9 / 2.6, rel=1e-12)
    assert not steel.is_piezoelectric


def test_unknown_name_is_answered_with_the_nearest():
    with pytest.raises(ValueError, match=r"got 'PTZ-8'; the nearest known one is 'PZT-8'"):
        material("PTZ-8")
    assert set(catalogue()) >= {"PIC181", "silicon", "aluminium"}
    assert all(isinstance(solid, Solid) for solid in catalogue().values())
