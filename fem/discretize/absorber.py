"""The absorbing bottom: elements below the solid in which waves decay.

Where every bulk wave carries its energy to the side in depth to which its phase goes, a perfectly matched layer: the
depth is continued into the complex plane (complex coordinate stretching; Berenger 1994).  In other cuts such a layer
makes some waves grow (Becache, Fauqueux and Joly 2003).  A selective layer then adds a loss to the motion along x of
the waves whose slowness curve is concave at the axis.  The loss comes late, where the layer has absorbed all other
waves, for it is not matched.  Where no such loss keeps the guided modes from growing, a viscous layer takes its place,
which is passive in any cut and converges slowly.
"""

from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np

from fem.discretize.graded_medium import graded_medium
from fem.discretize.stability import layer_growth
from fem.materials.christoffel import slowness_sheets, stretch_absorbs
from fem.materials.medium import Medium, damped, medium
from fem.materials.rotation import fields, isotropic_about_normal
from fem.materials.solids import Solid

Kind = Literal["matched", "selective", "viscous"]

# Perfectly matched layer from above: height of an element in wavelengths and its complex stretching factor, close to 1
# where waves arrive and large where only the static field is left.  The motion errs by 4e-6 or less on PZT-8, LiNbO3 YZ
# and ST-X quartz.  From level 3 on a real stretch below keeps the grounded bottom from the static field of a transducer
# (2e-5 of the motion on YZ LiNbO3 and PZT-5A without it); as complex as the elements above it lets modes grow.
MATCHED_LAYER = ((0.5, 1 - 1j), (0.5, 1.5 - 2j), (0.5, 4 - 4j), (0.5, 12 - 8j), (0.5, 60 - 20j))
STATIC_ELEMENT = (0.5, 300 + 0j)

# Selective layer, t = 0 at its top and 1 at its bottom: stretch 1 + a t^b + f t^g - i c t, damping d t^e times the
# sheet's backwardness.  On 128YX LiNbO3 a layer of 2 wavelengths errs by 1.4e-6 in u_z and 5.6e-6 in u_x, as
# tests/fem/discretize/test_half_space.py measures it; a = 9 and 12, b = 2 or e = 4 err by 4e-5 and more.  The term in
# f is for the static field of a transducer, which f = 0 lets feel the grounded bottom (2e-4 of the motion); g = 16
# lets modes grow in layers of 2.5 wavelengths and more.
STRETCH, STRETCH_POWER, DECAY = 21.0, 1.6, 6.0
STATIC_STRETCH, STATIC_POWER = 1000.0, 24
DAMPING, DAMPING_POWER = 13.0, 8
NODES = 17  # per wavelength of a selective layer; 12 let modes grow again (128YX, 6e-4 of k)
# Factors of the damping, and least damping of the other sheets over that of the most concave one, as they are tried:
# where the polarisation of a sheet turns with the direction (X quartz) a loss of one polarisation does not suffice.
STRENGTHS = ((1.0, 0.0), (2.0, 0.0), (2.0, 0.25), (4.0, 0.0), (4.0, 0.25), (8.0, 0.25))
MAX_GROWTH = 1e-4  # rad per wavelength in `layer_growth`; growth of 1e-3 lets the motion err by 1e-3 and more
TYPICAL_ORDER, TYPICAL_LEVEL = 7, 2  # at which the kind of the layer is chosen

# Loss factor of the lowest element of a viscous layer, and the power of the depth by which it grows.  With 8 elements
# the motion on 128YX LiNbO3 errs by 2e-4; a square law gives 8e-4, a fourth power and a loss of 4 give 6e-4.
MAX_LOSS, LOSS_POWER = 0.6, 3


class Depth(NamedTuple):
    """Extent of the three layers at one level of refinement."""

    static: bool  # whether a matched layer has the `STATIC_ELEMENT`
    selective: float  # wavelengths
    viscous: int  # elements of one wavelength


DEPTHS = (
    Depth(False, 0.75, 5),
    Depth(False, 1.0, 6),
    Depth(False, 1.5, 8),
    Depth(True, 2.5, 10),
    Depth(True, 4.0, 12),
    Depth(True, 6.0, 14),
)

Layer = list[tuple[float, complex, Medium]]


def absorber(solid: Solid, body: Medium, order: int, level: int, *, lateral: bool = False) -> Layer:
    """Elements below the solid from the bottom up: height in wavelengths, mean complex stretching factor, medium.

    ``body``: medium of the solid in the fields that take part; ``level``: of refinement, a number of `DEPTHS`;
    ``lateral``: the waves will have a lateral wavenumber.  A matched layer that absorbs the waves of the sagittal plane
    lets oblique ones grow (ST-X quartz: 6e-3 rad per wavelength; LiNbO3 rotated by 41 degrees: 3e-4); over a selective
    layer none does (tests/fem/discretize/test_absorber.py).
    """
    kind = absorber_kind(solid)
    if kind == "matched" and lateral and not isotropic_about_normal(solid):
        kind = "selective"
    if kind == "matched":
        return _matched(body, DEPTHS[level].static)
    if kind == "viscous":
        return _viscous(body, DEPTHS[level].viscous)
    strength, _ = _strength(solid, order, level)
    return _selective(solid, body, order, DEPTHS[level].selective, *strength)


@lru_cache(maxsize=32)
def absorber_kind(solid: Solid) -> Kind:
    """Which layer absorbs the waves of a solid in the stator's frame."""
    body = _lossless(solid)
    if (
        stretch_absorbs(solid)
        and layer_growth(solid, body, _matched(body, False), TYPICAL_ORDER) < MAX_GROWTH
    ):
        return "matched"
    if not np.isfinite(backwardness(solid)) or _strength(solid, TYPICAL_ORDER, TYPICAL_LEVEL)[1] > MAX_GROWTH:
        return "viscous"
    return "selective"


def backwardness(solid: Solid) -> float:
    """Largest |k_z V_z / (k_x V_x)| of the bulk waves of the sagittal plane whose k_z V_z < 0; 0 if there is none."""
    return max(sheet.backwardness for sheet in slowness_sheets(solid))


@lru_cache(maxsize=64)
def _strength(solid: Solid, order: int, level: int) -> tuple[tuple[float, float], float]:
    """First of `STRENGTHS` with which no guided mode grows, or that with the least growth; and the growth."""
    body, tried = _lossless(solid), []
    for strength in STRENGTHS:
        layer = _selective(solid, body, order, DEPTHS[level].selective, *strength)
        tried.append((layer_growth(solid, body, layer, order), strength))
        if tried[-1][0] < MAX_GROWTH:
            break
    growth, strength = min(tried)
    return strength, growth


def _lossless(solid: Solid) -> Medium:
    return medium(solid, fields(solid), lossy=False)


def _matched(body: Medium, static: bool) -> Layer:
    layer = (*MATCHED_LAYER, STATIC_ELEMENT) if static else MATCHED_LAYER
    return [(height, stretch, body) for height, stretch in layer[::-1]]


def _viscous(body: Medium, count: int) -> Layer:
    losses = MAX_LOSS * ((np.arange(count) + 0.5) / count) ** LOSS_POWER
    return [(1.0, 1.0, damped(body, 1 - 1j * loss)) for loss in losses[::-1]]


def _selective(solid: Solid, body: Medium, order: int, depth: float, strength: float, least: float) -> Layer:
    names, sheets = fields(solid), slowness_sheets(solid)
    worst = max(sheet.backwardness for sheet in sheets)
    displaced = [body.fields.index(name) for name in names if name != "phi"]
    loss = np.zeros((len(body.fields),) * 2)
    for sheet in sheets:
        weight = max(sheet.backwardness, least * worst) * sheet.modulus
        loss[np.ix_(displaced, displaced)] += weight * np.outer(sheet.polarisation, sheet.polarisation)
    count = int(np.ceil(NODES * depth / order))

    def element(number: int) -> tuple[float, complex, Medium]:
        def stretch(height: np.ndarray) -> np.ndarray:
            t = 1 - (number + height) / count
            return 1 + STRETCH * t**STRETCH_POWER + STATIC_STRETCH * t**STATIC_POWER - 1j * DECAY * t

        def damping(height: np.ndarray) -> np.ndarray:
            return strength * DAMPING * (1 - (number + height) / count) ** DAMPING_POWER

        mean, part = graded_medium(body, order, stretch=stretch, damping=damping, loss=loss)
        return depth / count, mean, part

    return [element(number) for number in range(count)]
