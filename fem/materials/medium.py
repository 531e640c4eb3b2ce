"""Weak form of time-harmonic piezoelectricity in the sagittal section.

T = c S + e^T grad phi,  D = e S - eps grad phi,  div T = -rho omega^2 u,  div D = 0  (exp(+i omega t);
Auld, *Acoustic Fields and Waves in Solids*, vol. 1, 1973, section 8; Allik and Hughes 1970):

    int S(v):T + grad psi . D - rho omega^2 v . u = boundary and charge terms,

symmetric in (u, phi), complex symmetric with loss.  With d/dy = 0 it needs only d/dx and d/dz of the fields, so
a medium is three small tables, C_xx, C_xz and C_zz, of which every matrix of the package is made.

Scaling: stress by ``stress_unit`` c0 = c_33-like modulus, phi by ``potential_unit`` = sqrt(c0/eps): without it
the condition number is 1e20 instead of 1e8 and sparse solvers fill in.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from fem.materials import VACUUM_PERMITTIVITY, Solid

# Generalised strain: Voigt strain 11 22 33 23 13 12, then grad phi; rows that d/dx and d/dz of a field feed.
_D_DX = {"ux": (0,), "uy": (5,), "uz": (4,), "phi": (6,)}
_D_DZ = {"ux": (4,), "uy": (3,), "uz": (2,), "phi": (8,)}


@dataclass(frozen=True, kw_only=True, eq=False)
class Medium:
    """Coefficients of the scaled weak form for the fields that take part.

    Attributes
    ----------
    fields : tuple of str
        Of "ux", "uy", "uz", "phi".
    xx, xz, zz : ndarray, shape (fields, fields)
        Factors of (d_x v)(d_x u), (d_x v)(d_z u), (d_z v)(d_z u); (d_z v)(d_x u) takes ``xz.T``.
    inertia : ndarray, shape (fields,)
        rho / stress_unit in s^2/m^2; 0 for phi.
    stress_unit, potential_unit : float
        Pa, and volt per metre of displacement.
    """

    fields: tuple[str, ...]
    xx: np.ndarray
    xz: np.ndarray
    zz: np.ndarray
    inertia: np.ndarray
    stress_unit: float
    potential_unit: float

    @property
    def parity(self) -> np.ndarray | None:
        """Fields that change sign under x -> -x when that maps solutions to solutions; None if no choice does.

        Shape (fields,), bool.  u_x is odd and u_z even; u_y and phi are what the tables allow (phi is even for
        poling along z, odd for poling along x).
        """
        size = max(abs(self.xx).max(), abs(self.zz).max())
        free = [name for name in ("uy", "phi") if name in self.fields]
        for choice in product((False, True), repeat=len(free)):
            signs = {"ux": True, "uz": False} | dict(zip(free, choice, strict=True))
            odd = np.array([signs[name] for name in self.fields])
            across = odd[:, None] != odd[None, :]
            leaks = (self.xx[across], self.zz[across], self.xz[~across])
            if max(abs(leak).max(initial=0.0) for leak in leaks) <= 1e-12 * size:
                return odd
        return None


def units(solid: Solid) -> tuple[float, float]:
    """Stress unit in Pa and potential unit in V/m (volt per metre of displacement) that balance a solid's form."""
    stress = float(np.max(np.diag(solid.stiffness)))
    return stress, float(np.sqrt(stress / np.max(np.diag(solid.permittivity))))


def medium(solid: Solid, fields: tuple[str, ...], *, lossy: bool = True) -> Medium:
    """Scaled coefficients of a solid.

    Parameters
    ----------
    solid : Solid
        In the stator's frame.
    fields : tuple of str
        Fields to keep.
    lossy : bool
        Complex moduli if the solid has loss; real ones otherwise.

    Returns
    -------
    Medium
        Real tables where there is no loss.
    """
    stress, potential = units(solid)
    stiffness = solid.stiffness_lossy if lossy else solid.stiffness
    permittivity = solid.permittivity_lossy if lossy else solid.permittivity
    law = np.block(
        [
            [stiffness / stress, solid.coupling.T * (potential / stress)],
            [solid.coupling * (potential / stress), -permittivity * (potential**2 / stress)],
        ]
    )
    if not np.any(np.imag(law)):
        law = law.real
    inertia = [0.0 if field == "phi" else solid.density / stress for field in fields]
    return _tabulated(law, fields, np.array(inertia), stress, potential)


def damped(body: Medium, factor: complex) -> Medium:
    """A medium of equal wave impedance in which waves decay: elastic tables over ``factor``, inertia times it.

    Passive for any cut, which a stretched depth is not; the piezoelectric and dielectric tables stay.
    """
    moves = np.array([name != "phi" for name in body.fields])
    both = moves[:, None] & moves[None, :]
    tables = (np.where(both, table / factor, table) for table in (body.xx, body.xz, body.zz))
    xx, xz, zz = tables
    return Medium(
        fields=body.fields,
        xx=xx,
        xz=xz,
        zz=zz,
        inertia=body.inertia * factor,
        stress_unit=body.stress_unit,
        potential_unit=body.potential_unit,
    )


def vacuum_medium(stress_unit: float, potential_unit: float) -> Medium:
    """Vacuum above the surface, in the units of the solid below: phi alone."""
    law = np.zeros((9, 9))
    law[6:, 6:] = -np.eye(3) * VACUUM_PERMITTIVITY * potential_unit**2 / stress_unit
    return _tabulated(law, ("phi",), np.zeros(1), stress_unit, potential_unit)


def _tabulated(law, fields, inertia, stress, potential) -> Medium:
    d_dx, d_dz = (np.zeros((9, len(fields))) for _ in range(2))
    for column, field in enumerate(fields):
        d_dx[_D_DX[field], column] = 1.0
        d_dz[_D_DZ[field], column] = 1.0
    return Medium(
        fields=tuple(fields),
        xx=d_dx.T @ law @ d_dx,
        xz=d_dx.T @ law @ d_dz,
        zz=d_dz.T @ law @ d_dz,
        inertia=inertia,
        stress_unit=stress,
        potential_unit=potential,
    )
