"""Constants in the forms, orders of indices and conventions of other programs, as this package takes them.

Stress-charge form T = c^E S - e^T E, D = e S + eps^S E from the strain-charge form S = s^E T + d^T E, D = d T + eps^T E
by c^E = (s^E)^-1, e = d c^E, eps^S = eps^T - d c^E d^T, and from constants at constant D or at constant stress by
c^E = c^D - e^T (eps^S)^-1 e and eps^S = eps^T - e (c^E)^-1 e^T (IEEE 176-1987, section 2.5, table 4).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from fem.parameters import Parameters, Words, refuse_if

FORMS = ("stress-charge", "strain-charge")
ORDER = "11 22 33 23 13 12"  # of the six components of stress and strain
COMPLIANT = 1e-6  # 1/Pa, of a table's largest entry: a larger one is a stiffness
# Orders of other programs: that of Ansys, that of Abaqus
ORDERS = (ORDER, "11 22 33 12 23 13", "11 22 33 12 13 23")


@dataclass(frozen=True, kw_only=True)
class Conditions(Parameters):
    """Form of a table of constants, and the conditions under which its stiffness and permittivity hold."""

    form: Annotated[str, Words(FORMS)] = FORMS[0]
    stiffness_at: Annotated[str, Words(("constant E", "constant D"))] = "constant E"
    permittivity_at: Annotated[str | None, Words(("constant strain", "constant stress"))] = None

    def check_conditions(self) -> Iterator[tuple[str, str]]:
        """Refuse conditions that the form excludes, and two that depend on each other."""
        if self.form == "strain-charge":
            if self.stiffness_at == "constant D":
                yield "stiffness_at", 'must be "constant E" with form = "strain-charge"'
            if self.permittivity_at == "constant strain":
                yield "permittivity_at", 'must be "constant stress" or absent with form = "strain-charge"'
        elif self.permittivity_at == "constant stress" and self.stiffness_at == "constant D":
            yield "stiffness_at", "must be constant E where permittivity_at is constant stress: convert one of the two"


def in_order(table: ArrayLike, order: str) -> np.ndarray:
    """Return a table of shape (6, 6) or (3, 6) in `ORDER` from one in another order.

    Examples
    --------
    >>> in_order([[1, 2, 3, 12, 23, 13]] * 3, "11 22 33 12 23 13")[0].tolist()
    [1.0, 2.0, 3.0, 23.0, 13.0, 12.0]
    """
    names = ["".join(sorted(each)) for each in order.split()]
    refuse_if(
        sorted(names) != sorted(ORDER.split()), "order", f'must name each of {ORDER} once, such as "{ORDERS[1]}"', order
    )
    picked = [names.index(each) for each in ORDER.split()]
    table = np.array(table, dtype=float)
    return table[np.ix_(picked, picked)] if len(table) == 6 else table[:, picked]


def stress_charge(
    elastic: np.ndarray,
    coupling: np.ndarray,
    permittivity: np.ndarray,
    *,
    form: str = FORMS[0],
    order: str = ORDER,
    stiffness_at: str = "constant E",
    permittivity_at: str | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return c^E in Pa, e in C/m2 and eps^S in F/m, in `ORDER`, of tables in SI units in another form.

    Parameters
    ----------
    elastic : ndarray, shape (6, 6)
        Stiffness; in strain-charge form the compliance, or c^E where its entries are larger than any compliance.
    coupling, permittivity : ndarray, shapes (3, 6) and (3, 3)
        e and eps^S, or d and eps^T.
    form, order : str
        Of `FORMS`, and as `in_order` takes it.
    stiffness_at, permittivity_at : str
        "constant D" and "constant stress" where the tables of the stress-charge form are c^D or eps^T.
    """
    Conditions(form=form, stiffness_at=stiffness_at, permittivity_at=permittivity_at)
    elastic, coupling = in_order(elastic, order), in_order(coupling, order)
    if form == "strain-charge":
        if abs(elastic).max() > COMPLIANT:
            elastic = np.linalg.inv(_regular("stiffness", elastic))
        return from_strain_charge(elastic, coupling, permittivity)
    if stiffness_at == "constant D":
        elastic = at_constant_field(elastic, coupling, permittivity)
    if permittivity_at == "constant stress":
        permittivity = at_constant_strain(elastic, coupling, permittivity)
    return elastic, coupling, permittivity


def from_strain_charge(
    compliance: np.ndarray, coupling: np.ndarray, permittivity: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (c^E, e, eps^S) of s^E in 1/Pa, d in C/N and eps^T in F/m."""
    stiffness = np.linalg.inv(_regular("compliance", compliance))
    stiffness = (stiffness + stiffness.T) / 2
    piezoelectric = coupling @ stiffness
    return stiffness, piezoelectric, permittivity - piezoelectric @ coupling.T


def at_constant_field(stiffness: np.ndarray, coupling: np.ndarray, permittivity: np.ndarray) -> np.ndarray:
    """Return c^E of c^D, e and eps^S."""
    return stiffness - coupling.T @ np.linalg.solve(_regular("permittivity", permittivity), coupling)


def at_constant_strain(stiffness: np.ndarray, coupling: np.ndarray, permittivity: np.ndarray) -> np.ndarray:
    """Return eps^S of c^E, e and eps^T."""
    return permittivity - coupling @ np.linalg.solve(_regular("stiffness", stiffness), coupling.T)


def _regular(key: str, table: np.ndarray) -> np.ndarray:
    refuse_if(not np.linalg.cond(table) < 1e12, key, "must be a table that has an inverse")
    return table
