"""Rotation of a solid to a cut: x along the propagation, z out of the surface.

Passive rotation: the rows of the matrix a are the new axes in crystal coordinates, a = R_z(psi) R_x(theta)
R_z(phi) for the Euler angles [phi, theta, psi] (z-x-z; Slobodnik, Conway and Delmonico, *Microwave Acoustics
Handbook*, 1973).  With Bond's matrix M (stress T' = M T; Auld, *Acoustic Fields and Waves in Solids*, vol. 1,
section 3.D)

    c' = M c M^T,    e' = a e M^T,    eps' = a eps a^T.
"""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fem.materials.solids import Solid
from fem.parameters import InputError, choice

# [phi, theta, psi] in degrees.  In X and YZ crystal axis 3 lies along x; the normal is crystal axis -1 in X, +2 in YZ.
ORIENTATIONS: dict[str, tuple[float, float, float]] = {
    "Z": (0, 0, 0),
    "X": (-90, 90, 90),
    "YZ": (180, 90, 90),
    "128YX": (0, 38, 0),
    "ST-X": (0, 132.75, 0),
}
Orientation = str | Sequence[float]
# Names by the crystal axis of the normal and of the propagation, with a turn: 64YX, the normal 64 degrees from Y
# towards Z, propagation along X; X112Y, the normal along X, propagation 112 degrees from Y towards Z
ROTATED_NORMAL = re.compile(r"(\d{1,3}(?:\.\d+)?)\s*°?[\s-]*Y-?X")
ROTATED_PROPAGATION = re.compile(r"X[\s-]*(\d{1,3}(?:\.\d+)?)\s*°?[\s-]*Y")
PLAIN_CUTS = {"ZX": (0, 0, 0), "ZY": (90, 0, 0), "YX": (0, -90, 0), "XY": (90, 90, 0), "XZ": (90, 90, 90)}
# Conventions of Euler angles.  SAW: [phi, theta, psi] as above, from the crystal to the cut.  COMSOL (rotated system in
# three dimensions, z normal) and sawsim (2.0.2) turn from the cut to the crystal: [alpha, beta, gamma] of
# R_z(alpha) R_x(beta) R_z(gamma) with active matrices, so that 128YX is [0, -38, 0].
CONVENTIONS = ("SAW", "COMSOL", "sawsim")

_SYMMETRY = 1e-9  # of the moduli, to which a solid must be isotropic about z
_GENERIC_TURN = 33.0  # degrees; no crystal class has such an axis
_NOISE = 1e-10  # relative size below which a rotated entry is rounding: it would change v by 1e-20
_PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
_SAGITTAL, _TRANSVERSE = [0, 2, 4], [3, 5]  # Voigt strains of (ux, uz) and of uy where d/dy = 0


def euler_angles(angles: Sequence[float], convention: str = "SAW") -> tuple[float, ...]:
    """Return the angles [phi, theta, psi] of this package, in degrees, for those of a convention of `CONVENTIONS`.

    Examples
    --------
    >>> euler_angles([10, -38, 20], "sawsim")
    (-20.0, 38.0, -10.0)
    """
    choice("euler_convention", convention, CONVENTIONS)
    return tuple(angles) if convention == "SAW" else tuple(0.0 - each for each in reversed(angles))


def named_cut(name: str) -> tuple[float, float, float] | None:
    """Return the Euler angles of a cut's name; None for a name that is none.

    Examples
    --------
    >>> named_cut("64YX"), named_cut("X-112Y"), named_cut("ZX")
    ((0.0, -26.0, 0.0), (90.0, 90.0, 112.0), (0, 0, 0))
    """
    known = ORIENTATIONS | PLAIN_CUTS
    if name in known:
        return known[name]
    if normal := ROTATED_NORMAL.fullmatch(name):
        return 0.0, float(normal[1]) - 90.0, 0.0
    if propagation := ROTATED_PROPAGATION.fullmatch(name):
        return 90.0, 90.0, float(propagation[1])
    return None


def rotation_matrix(orientation: Orientation) -> np.ndarray:
    """Return the new axes in crystal coordinates, one per row: orthogonal, determinant 1, shape (3, 3).

    Parameters
    ----------
    orientation : str or sequence of 3 floats
        A name of `named_cut` or Euler angles [phi, theta, psi] in degrees; a ValueError for anything else.
    """
    if isinstance(orientation, str):
        angles_of_name = named_cut(orientation)
        if angles_of_name is None:
            names = ", ".join(ORIENTATIONS)
            rule = f"must be one of {names}, another such as 64YX, or [phi, theta, psi] degrees"
            raise InputError("orientation", rule, orientation)
        orientation = angles_of_name
    try:
        angles = np.array(orientation, dtype=float)
    except (TypeError, ValueError):
        angles = np.empty(0)
    if angles.shape != (3,) or not np.all(np.isfinite(angles)):
        raise InputError("orientation", "must be three finite angles in degrees", orientation)
    phi, theta, psi = angles
    return _about_z(psi) @ _about_z(theta)[np.ix_([2, 0, 1], [2, 0, 1])] @ _about_z(phi)


def rotated(solid: Solid, orientation: Orientation) -> Solid:
    """Return the solid in the frame of a cut, whose ``frame`` is the orientation's text.

    Parameters
    ----------
    solid : Solid
        In the crystal frame (or any other: the rotation is relative to its frame).
    orientation : str or sequence of 3 floats
        As in `rotation_matrix`.
    """
    a = rotation_matrix(orientation)
    bond = bond_matrix(a)
    return replace(
        solid,
        frame=orientation if isinstance(orientation, str) else str([float(angle) for angle in orientation]),
        stiffness=bond @ solid.stiffness @ bond.T,
        coupling=a @ solid.coupling @ bond.T,
        permittivity=a @ solid.permittivity @ a.T,
    )


def bond_matrix(a: np.ndarray) -> np.ndarray:
    """Return M with T' = M T for Voigt stress: M_IJ = a_ik a_jl + a_il a_jk over the pair J = (k, l), (6, 6)."""
    bond = np.empty((6, 6))
    for row, (i, j) in enumerate(_PAIRS):
        for column, (k, m) in enumerate(_PAIRS):
            bond[row, column] = a[i, k] * a[j, m] + (a[i, m] * a[j, k] if k != m else 0.0)
    return bond


def fields(*solids: Solid) -> tuple[str, ...]:
    """Return the fields, out of "ux", "uy", "uz", "phi", coupled to the sagittal motion of rotated solids in layers.

    Nothing depends on y, so that u_y or phi may be uncoupled; they are then left out.
    """
    transverse = electric = between = False
    for solid in solids:
        c, e, eps = solid.stiffness, solid.coupling[[0, 2]], solid.permittivity
        stiff = np.diag(c).max()
        polar = np.sqrt(stiff * np.diag(eps).max())
        transverse |= np.abs(c[np.ix_(_SAGITTAL, _TRANSVERSE)]).max() > _NOISE * stiff
        electric |= np.abs(e[:, _SAGITTAL]).max() > _NOISE * polar
        between |= np.abs(e[:, _TRANSVERSE]).max() > _NOISE * polar  # phi and u_y are coupled to each other
    transverse, electric = transverse or (electric and between), electric or (transverse and between)
    present = {"ux": True, "uy": transverse, "uz": True, "phi": electric}
    return tuple(field for field, coupled in present.items() if coupled)


def isotropic_about_normal(solid: Solid) -> bool:
    """True if no rotation about z changes a modulus of a solid, relative to the largest, by more than 1e-9."""
    turned = rotated(solid, (_GENERIC_TURN, 0.0, 0.0))
    pairs = ((getattr(turned, name), getattr(solid, name)) for name in ("stiffness", "coupling", "permittivity"))
    return all(abs(after - before).max() <= _SYMMETRY * abs(before).max() for after, before in pairs)


def _about_z(degrees: float) -> np.ndarray:
    """Passive rotation about z, exact at multiples of 90 degrees."""
    quarters, rest = divmod(float(degrees), 90.0)
    cosine, sine = np.cos(np.radians(rest)), np.sin(np.radians(rest))
    for _ in range(int(quarters % 4)):
        cosine, sine = -sine, cosine
    return np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
