"""Linear piezoelectric solids.

T = c^E S - e^T E, D = e S + eps^S E (IEEE Standard on Piezoelectricity 176-1987, section 2), in Voigt order
11 22 33 23 13 12 with engineering shear (S4 = 2 S23).  With exp(+i omega t) losses are c (1 + i/Q) and
eps (1 - i tan delta); e stays real.  Heating, depoling and hysteresis of the material are left out.
"""

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from fem.parameters import InputError, Number, Parameters, refuse_if

VACUUM_PERMITTIVITY = 8.8541878188e-12  # F/m, CODATA 2022
_ASYMMETRY = 1e-9  # relative; a mistyped digit is larger, the rounding of a rotation smaller
_SHAPES = {"stiffness": (6, 6), "coupling": (3, 6), "permittivity": (3, 3)}
_UNITS = {"stiffness": "Pa", "coupling": "C/m2", "permittivity": "F/m"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Solid(Parameters):
    """Constants of a homogeneous solid in one frame.  Two solids are equal if all their numbers are.

    Attributes
    ----------
    name, source : str
        Of the set of constants, and where it was published.
    frame : str
        "crystal", or the orientation that it was rotated to.
    stiffness : ndarray, shape (6, 6)
        c^E in Pa.
    coupling : ndarray, shape (3, 6)
        e in C/m2; all zero: no electric field is solved for.
    permittivity : ndarray, shape (3, 3)
        eps^S in F/m (absolute).
    density : float
        kg/m3.
    mechanical_quality : float
        Q_m; infinite without loss.
    dielectric_loss : float
        tan delta.
    conducting : bool
        True for a metal, in which the potential is constant; a layer of it is floating, without net charge.
    """

    name: str
    source: str
    frame: str = "crystal"
    stiffness: np.ndarray
    coupling: np.ndarray
    permittivity: np.ndarray
    density: Annotated[float, Number("kg/m^3")]
    mechanical_quality: Annotated[float, Number(infinite=True)] = float("inf")
    dielectric_loss: Annotated[float, Number(zero=True)] = 0.0
    conducting: bool = False

    def __post_init__(self):
        for key in _SHAPES:
            table = _table(key, getattr(self, key), _UNITS[key])
            if key != "coupling":
                table = _positive_definite(key, table, _UNITS[key])
            table.flags.writeable = False
            object.__setattr__(self, key, table)
        super().__post_init__()

    @property
    def is_piezoelectric(self) -> bool:
        """True if strain and electric field are coupled."""
        return bool(np.any(self.coupling))

    @property
    def sagittal_permittivity(self) -> float:
        """Permittivity in F/m that the charge on a line along y sees: (eps_xx eps_zz - eps_xz^2)^(1/2)."""
        own = self.permittivity
        return float(np.sqrt(own[0, 0] * own[2, 2] - own[0, 2] ** 2))

    @property
    def is_lossy(self) -> bool:
        """True if the solid dissipates power."""
        return np.isfinite(self.mechanical_quality) or self.dielectric_loss > 0

    @property
    def stiffness_lossy(self) -> np.ndarray:
        """c^E (1 + i/Q), shape (6, 6), Pa."""
        return self.stiffness * (1 + 1j / self.mechanical_quality)

    @property
    def permittivity_lossy(self) -> np.ndarray:
        """eps^S (1 - i tan delta), shape (3, 3), F/m."""
        return self.permittivity * (1 - 1j * self.dielectric_loss)

    @cached_property
    def _identity(self) -> tuple:
        values = (getattr(self, field.name) for field in fields(self))
        return tuple(value.tobytes() if isinstance(value, np.ndarray) else value for value in values)

    def __eq__(self, other):
        return self._identity == other._identity if isinstance(other, Solid) else NotImplemented

    def __hash__(self):
        return hash(self._identity)


@dataclass(frozen=True, kw_only=True)
class IsotropicConstants(Parameters):
    """Constants of an isotropic solid: Young's modulus in Pa, Poisson's ratio, density in kg/m3 and Q_m."""

    youngs_modulus: Annotated[float, Number("Pa")]
    poisson_ratio: Annotated[float, Number(above=-1.0, below=0.5)]
    density: Annotated[float, Number("kg/m^3")]
    mechanical_quality: Annotated[float, Number(infinite=True)] = float("inf")


def anisotropic(
    *,
    name: str,
    stiffness: ArrayLike,
    coupling: ArrayLike,
    permittivity: ArrayLike,
    density: float,
    mechanical_quality: float = float("inf"),
    dielectric_loss: float = 0.0,
    source: str = "user's table",
) -> Solid:
    """Return the solid of a user's tables, in the crystal frame.

    Parameters
    ----------
    name, stiffness, coupling, density, mechanical_quality, dielectric_loss, source
        As in `Solid`.
    permittivity : array_like, shape (3, 3)
        eps^S relative to vacuum.

    Raises
    ------
    ValueError
        Naming the table, the rule, the value and the unit.
    """
    relative = _table("permittivity", permittivity, "relative to vacuum")
    return Solid(
        name=name,
        source=source,
        stiffness=_table("stiffness", stiffness, _UNITS["stiffness"]),
        coupling=_table("coupling", coupling, _UNITS["coupling"]),
        permittivity=_positive_definite("permittivity", relative, "relative to vacuum") * VACUUM_PERMITTIVITY,
        density=density,
        mechanical_quality=mechanical_quality,
        dielectric_loss=dielectric_loss,
    )


def isotropic(
    *,
    name: str,
    youngs_modulus: float,
    poisson_ratio: float,
    density: float,
    mechanical_quality: float = float("inf"),
    conducting: bool = False,
    source: str = "user's table",
) -> Solid:
    """Return an isotropic solid: c12 = lambda, c44 = mu, c11 = lambda + 2 mu, no coupling, the permittivity of vacuum.

    Parameters
    ----------
    name, density, mechanical_quality, conducting, source
        As in `Solid`.
    youngs_modulus : float
        Pa.
    poisson_ratio : float
        Between -1 and 0.5, both excluded.  Towards 0.5 mu = (c11 - c12)/2 loses digits: its relative error is about
        1e-16 / (1 - 2 nu).

    Raises
    ------
    ValueError
        Naming the constant, the rule, the value and the unit.
    """
    own: dict[str, Any] = {"density": density, "mechanical_quality": mechanical_quality}
    IsotropicConstants(youngs_modulus=youngs_modulus, poisson_ratio=poisson_ratio, **own)
    shear = youngs_modulus / (2 * (1 + poisson_ratio))
    lame = 2 * shear * poisson_ratio / (1 - 2 * poisson_ratio)
    stiffness = np.diag([2 * shear] * 3 + [shear] * 3)
    stiffness[:3, :3] += lame
    return Solid(
        name=name,
        source=source,
        stiffness=stiffness,
        coupling=np.zeros((3, 6)),
        permittivity=np.eye(3) * VACUUM_PERMITTIVITY,
        **own,
        conducting=conducting,
    )


def _table(key: str, value: ArrayLike, unit: str) -> np.ndarray:
    """Finite float table of the right shape."""
    shape = _SHAPES[key]
    try:
        table = np.array(value, dtype=float)
    except (TypeError, ValueError):
        table = None
    if table is None or table.shape != shape:
        form = f"a table of {shape[0]} rows of {shape[1]} numbers ({unit})"
        received = repr(value)[:60] if table is None else f"one of shape {table.shape}"
        raise InputError(key, f"must be {form}, got {received}")
    if not np.all(np.isfinite(table)):
        entry = tuple(int(i) + 1 for i in np.argwhere(~np.isfinite(table))[0])
        raise InputError(key, f"must be finite; entry {entry} is {table[entry[0] - 1, entry[1] - 1]} {unit}")
    return table


def _positive_definite(key: str, table: np.ndarray, unit: str) -> np.ndarray:
    """Symmetric part of a table that is symmetric but for rounding, and positive definite."""
    skew = np.abs(table - table.T)
    i, j = (int(k) for k in np.unravel_index(np.argmax(skew), skew.shape))
    entries = f"entries ({i + 1}, {j + 1}) and ({j + 1}, {i + 1})"
    refuse_if(
        skew[i, j] > _ASYMMETRY * np.abs(table).max(),
        key,
        f"must be symmetric; {entries} are {table[i, j]:g} and {table[j, i]:g} {unit}",
    )
    table = (table + table.T) / 2
    smallest = float(np.linalg.eigvalsh(table)[0])
    refuse_if(not smallest > 0, key, f"must be positive definite; its smallest eigenvalue is {smallest:.3g} {unit}")
    return table
