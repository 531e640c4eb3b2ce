"""Weak form of time-harmonic piezoelectricity in the sagittal section.

T = c S + e^T grad phi,  D = e S - eps grad phi,  div T = -rho omega^2 u,  div D = 0  (exp(+i omega t);
Auld, *Acoustic Fields and Waves in Solids*, vol. 1, 1973, section 8; Allik and Hughes 1970):

    int S(v):T + grad psi . D - rho omega^2 v . u = boundary and charge terms,

symmetric in (u, phi), complex symmetric with loss.  With d/dy = 0 it needs only d/dx and d/dz of the fields, so
a medium is three small tables, C_xx, C_xz and C_zz, of which every matrix of the package is made.

Fields that vary as exp(-i k_y y) add the tables C_xy, C_zy and C_yy.  Test functions vary as exp(+i k_y y), so that
the integrand does not depend on y: d/dy is -i k_y on the fields and +i k_y on the test functions, and a matrix of the
weak form obeys K(k_y)^T = K(-k_y).  Where y -> -y maps solutions to solutions, the fields that change sign (u_y) are
scaled by i, and K(k_y) is complex symmetric again, real without loss.

Scaling: stress by ``stress_unit`` c0, the largest diagonal stiffness, and phi by ``potential_unit`` = sqrt(c0/eps).
Without it the condition number is 1e20 instead of 1e8, and sparse solvers fill in.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np

from fem.materials.solids import VACUUM_PERMITTIVITY, Solid

# Generalised strain: Voigt strain 11 22 33 23 13 12, then grad phi; the row that d/dx, d/dy or d/dz of a field feeds.
_ROWS = {
    "x": {"ux": 0, "uy": 5, "uz": 4, "phi": 6},
    "y": {"ux": 5, "uy": 1, "uz": 3, "phi": 7},
    "z": {"ux": 4, "uy": 3, "uz": 2, "phi": 8},
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Medium:
    """Coefficients of the scaled weak form for the fields that take part."""

    fields: tuple[str, ...]  # of "ux", "uy", "uz", "phi"
    law: np.ndarray  # shape (9, 9): scaled stress and D (with its sign reflected) over strain and grad phi
    inertia: np.ndarray  # shape (fields,); rho / stress_unit in s^2/m^2; 0 for phi
    stress_unit: float  # Pa
    potential_unit: float  # volt per metre of displacement
    # of a section with layers: a medium that couples all fields that any of its solids couples; its symmetries count
    whole: "Medium | None" = None

    def _table(self, test: str, trial: str) -> np.ndarray:
        rows, columns = ([_ROWS[axis][name] for name in self.fields] for axis in (test, trial))
        return self.law[np.ix_(rows, columns)]

    # Tables of shape (fields, fields): xz is the factor of (d_x v)(d_z u), and so on; (d_z v)(d_x u) takes xz.T.
    xx = cached_property(lambda self: self._table("x", "x"))
    xz = cached_property(lambda self: self._table("x", "z"))
    zz = cached_property(lambda self: self._table("z", "z"))
    xy = cached_property(lambda self: self._table("x", "y"))
    zy = cached_property(lambda self: self._table("z", "y"))
    yy = cached_property(lambda self: self._table("y", "y"))

    @property
    def displaced(self) -> np.ndarray:
        """True for the fields that are displacements, shape (fields,)."""
        return np.array([name != "phi" for name in self.fields])

    @property
    def parity(self) -> np.ndarray | None:
        """Fields that change sign under x -> -x when that maps solutions to solutions; None if no choice does.

        Shape (fields,), bool.  u_x is odd and u_z even; u_y and phi are what the tables allow (phi is even for
        poling along z, odd for poling along x).
        """
        return self._odd_fields("ux", same=("xx", "zz"), opposite=("xz",))

    @cached_property
    def lateral_parity(self) -> np.ndarray | None:
        """As `parity`, for fields with a lateral wavenumber."""
        return self._odd_fields("ux", same=("xx", "zz", "yy", "zy"), opposite=("xz", "xy"))

    @cached_property
    def mirror_y(self) -> np.ndarray | None:
        """As `parity`, but fields that change sign under y -> -y: u_y, or u_y and phi."""
        return self._odd_fields("uy", same=("xx", "xz", "zz", "yy"), opposite=("xy", "zy"))

    def _odd_fields(self, odd_one: str, *, same: tuple[str, ...], opposite: tuple[str, ...]) -> np.ndarray | None:
        """Signs for which ``same`` couples only fields of one sign and ``opposite`` only those of different sign."""
        whole = self.whole or self
        size = max(abs(whole.xx).max(), abs(whole.zz).max())
        fixed = {"ux": False, "uz": False} | {odd_one: True}
        free = [name for name in whole.fields if name not in fixed]
        for choice in product((False, True), repeat=len(free)):
            signs = fixed | dict(zip(free, choice, strict=True))
            odd = np.array([signs[name] for name in whole.fields])
            across = odd[:, None] != odd[None, :]
            leaks = [getattr(whole, name)[across] for name in same]
            leaks += [getattr(whole, name)[~across] for name in opposite]
            if max(abs(leak).max(initial=0.0) for leak in leaks) <= 1e-12 * size:
                return np.array([signs[name] for name in self.fields])
        return None

    def lateral(self, wavenumber: complex) -> "LateralTables":
        """Return the terms of a lateral wavenumber in radians per length unit."""
        if self.mirror_y is None:
            xy, zy = -1j * wavenumber * self.xy, -1j * wavenumber * self.zy
            return LateralTables(xy=xy, yx=-xy.T, zy=zy, yz=-zy.T, yy=wavenumber**2 * self.yy)
        # -i conj(t_a) t_b with t = i for odd fields and 1 for even ones, where one of the two is odd
        signs = wavenumber * np.where(self.mirror_y[:, None], -1.0, 1.0)
        xy, zy = signs * self.xy, signs * self.zy
        return LateralTables(xy=xy, yx=xy.T, zy=zy, yz=zy.T, yy=wavenumber**2 * self.yy)


class LateralTables(NamedTuple):
    """Terms of the weak form with a lateral wavenumber, scaled by i where y -> -y is a symmetry.

    ``xy`` multiplies (d_x v) u, ``yx`` v (d_x u), ``zy`` (d_z v) u, ``yz`` v (d_z u), ``yy`` v u; shape
    (fields, fields) each, in the length unit of the wavenumber to the power -1, for ``yy`` -2.
    """

    xy: np.ndarray
    yx: np.ndarray
    zy: np.ndarray
    yz: np.ndarray
    yy: np.ndarray


def units(*solids: Solid) -> tuple[float, float]:
    """Stress unit in Pa and potential unit in V/m (volt per metre of displacement) that balance the form of solids."""
    stress = max(float(np.max(np.diag(each.stiffness))) for each in solids)
    return stress, float(np.sqrt(stress / max(np.max(np.diag(each.permittivity)) for each in solids)))


def medium(
    solid: Solid, fields: tuple[str, ...], *, lossy: bool = True, scales: tuple[float, float] | None = None
) -> Medium:
    """Scaled coefficients of a solid in the stator's frame for some fields; real tables where there is no loss.

    ``lossy``: complex moduli if the solid has loss; ``scales``: stress and potential unit, by default `units` of the
    solid itself.
    """
    stress, potential = scales or units(solid)
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
    return Medium(
        fields=tuple(fields), law=law, inertia=np.array(inertia), stress_unit=stress, potential_unit=potential
    )


def media(solids: Sequence[Solid], fields: tuple[str, ...]) -> list[Medium]:
    """Scaled coefficients of the solids of one section, in common units and with the symmetries that all have.

    A conductor has no potential of its own: phi is constant in it and does not take part.
    """
    scales = units(*solids)
    without = tuple(each for each in fields if each != "phi")
    single = [medium(each, without if each.conducting else fields, scales=scales) for each in solids]
    if len(single) == 1:
        return single
    whole = replace(
        single[0], fields=fields, law=np.max([abs(each.law) for each in single], axis=0), inertia=np.zeros(len(fields))
    )
    return [replace(each, whole=whole) for each in single]


def damped(body: Medium, factor: complex) -> Medium:
    """A medium of equal wave impedance in which waves decay: stiffness over ``factor``, inertia times it.

    Passive for any cut, which a stretched depth is not; the piezoelectric and dielectric constants stay.
    """
    law = body.law.astype(complex)
    law[:6, :6] /= factor
    return replace(body, law=law, inertia=body.inertia * factor)


def vacuum_medium(stress_unit: float, potential_unit: float, *, along: float = 1.0) -> Medium:
    """Vacuum above the surface, in the units of the solid below: phi alone.

    ``along``: factor on its permittivity along the surface, in both directions.
    """
    law = np.zeros((9, 9))
    scaled = VACUUM_PERMITTIVITY * potential_unit**2 / stress_unit
    law[6:, 6:] = -scaled * np.diag([along, along, 1.0])
    return Medium(fields=("phi",), law=law, inertia=np.zeros(1), stress_unit=stress_unit, potential_unit=potential_unit)
