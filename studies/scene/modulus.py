"""The moduli of a ball on the stator, the stator as a transversely isotropic half-space.

A pressed circle sees the half-space's response to a point load averaged over directions, or in wavenumber
space: displacement = compliance / |k| times traction.  With the normal as axis of symmetry (3) the three
compliances are

    normal                2/M,  M = 2 sqrt{ (c11 c33 - c13^2)/c11 / [1/c44 + 2/(c13 + sqrt(c11 c33))] }
    tangential, along k   2/M sqrt(c33/c11)
    tangential, across k  1/sqrt(c44 c66)

and 1/E* = 1/M + (1 - nu^2)/E of the ball, 1/G* = the two tangential ones + (2 - nu)/G of the ball.
Isotropic: M = E/(1 - nu^2) and (1 - nu)/G + 1/G = (2 - nu)/G.  M: H. A. Elliott, Proc. Camb. Phil. Soc. 44
(1948) 522; J. R. Willis, J. Mech. Phys. Solids 14 (1966) 163; in this form A. Delafargue and F.-J. Ulm,
Int. J. Solids Struct. 41 (2004) 7351, eq. 30.  The electric field's stiffening is left out (c^E, a surface
that is short-circuited): it would raise M by a few per cent.  G*: the elastic model's 8 a G* of R. D.
Mindlin, J. Appl. Mech. 16 (1949) 259.
"""

import math

import numpy as np

from studies.refusal import SceneError

__all__ = ["indentation_modulus", "pair_moduli", "tangential_compliance"]

ASYMMETRY = (
    1e-6  # relative; a catalogue's digits keep the symmetry far better, a tilt of 0.1 degrees breaks it
)


def pair_moduli(ball: str, solid) -> tuple[float, float]:
    """Return E* and G* of a ball on a stator.

    Parameters
    ----------
    ball : str
        Name of an isotropic solid of the catalogue.
    solid : fem.Solid
        Of the stator, rotated to its axes.

    Returns
    -------
    effective_modulus, tangential_modulus : float
        Pa.

    Raises
    ------
    SceneError
        If the ball's solid is unknown or not isotropic, or the stator's normal is no axis of symmetry.
    """
    from fem import materials

    try:
        sphere = materials.material(ball)
    except ValueError as error:
        raise SceneError("slider.ball", str(error)) from None
    if not _is_isotropic(sphere.stiffness):
        raise SceneError("slider.ball", f'must be an isotropic solid such as "steel", got {ball!r}')
    if not _is_axial(solid.stiffness):
        rule = (
            f"must be absent on {solid.name} in orientation {solid.frame}: its normal is no axis of symmetry"
        )
        raise SceneError("slider.ball", f"{rule}; give effective_modulus and tangential_modulus in Pa")
    normal = 1 / indentation_modulus(solid.stiffness) + 1 / indentation_modulus(sphere.stiffness)
    tangential = tangential_compliance(solid.stiffness) + tangential_compliance(sphere.stiffness)
    return 1 / normal, 1 / tangential


def indentation_modulus(stiffness: np.ndarray) -> float:
    """Return M in Pa of a half-space with axis 3 as normal and axis of symmetry; stiffness (6, 6) in Pa."""
    c11, c13, c33, c44, _ = _axial(stiffness)
    flexible = 1 / c44 + 2 / (c13 + math.sqrt(c11 * c33))
    return 2 * math.sqrt((c11 * c33 - c13**2) / c11 / flexible)


def tangential_compliance(stiffness: np.ndarray) -> float:
    """Return the part of 1/G* of a half-space with axis 3 as normal and axis of symmetry, in 1/Pa."""
    c11, _, c33, c44, c66 = _axial(stiffness)
    return 2 / indentation_modulus(stiffness) * math.sqrt(c33 / c11) + 1 / math.sqrt(c44 * c66)


def _axial(c: np.ndarray) -> tuple[float, ...]:
    return tuple(float(c[i, j]) for i, j in ((0, 0), (0, 2), (2, 2), (3, 3), (5, 5)))


def _is_axial(c: np.ndarray) -> bool:
    """Whether the stiffness does not change when turned about axis 3."""
    c11, c13, c33, c44, c66 = _axial(c)
    expected = np.zeros((6, 6))
    expected[:3, :3] = [[c11, c11 - 2 * c66, c13], [c11 - 2 * c66, c11, c13], [c13, c13, c33]]
    expected[3, 3], expected[4, 4], expected[5, 5] = c44, c44, c66
    return bool(np.max(np.abs(c - expected)) <= ASYMMETRY * np.max(np.abs(c)))


def _is_isotropic(c: np.ndarray) -> bool:
    c11, c13, c33, c44, c66 = _axial(c)
    spread = max(abs(c11 - c33), abs(c44 - c66), abs(c11 - c13 - 2 * c44))
    return _is_axial(c) and spread <= ASYMMETRY * c11
