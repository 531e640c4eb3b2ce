"""Solids: what they are made of, the published sets of constants, and their rotation to a cut.

Voigt order 11 22 33 23 13 12, engineering shear; stress-charge form T = c^E S - e^T E, D = e S + eps^S E.
"""

from fem.materials.rotation import ORIENTATIONS, fields, isotropic_about_normal, rotated, rotation_matrix
from fem.materials.solids import VACUUM_PERMITTIVITY, Solid, anisotropic, isotropic
from fem.materials.tables import catalogue, material
from fem.materials.temperature import solid_at

__all__ = [
    "ORIENTATIONS",
    "VACUUM_PERMITTIVITY",
    "Solid",
    "anisotropic",
    "catalogue",
    "fields",
    "isotropic",
    "isotropic_about_normal",
    "material",
    "rotated",
    "rotation_matrix",
    "solid_at",
]
