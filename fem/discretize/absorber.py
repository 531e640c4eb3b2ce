"""Absorbing bottom: elements below the solid in which waves decay, in one of three kinds of layer.

matched
    Perfectly matched layer: the depth is continued into the complex plane (complex coordinate stretching; Berenger
    1994).  It is used if phase and energy of every bulk wave travel in the same direction of depth.  In other cuts it
    makes some waves grow (Becache, Fauqueux and Joly 2003).
selective
    Matched layer with an additional loss.  It acts on the x derivative of displacements that are polarised like a
    sheet whose slowness curve is concave at the x axis (`backwardness`).  This loss causes reflections, so that it
    begins only at a depth where the layer has absorbed all other waves.
viscous
    Layer of a lossy solid, which is passive in every cut but converges slowly.  It is used if no selective layer keeps
    the guided modes from growing.
"""

from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np

from fem.discretize.graded_medium import graded_medium
from fem.discretize.stability import layer_growth
from fem.materials.christoffel import slowness_sheets, stretch_absorbs
from fem.materials.medium import Medium, damped, medium, units
from fem.materials.rotation import fields, isotropic_about_normal
from fem.materials.solids import Solid

Kind = Literal["matched", "selective", "viscous"]

# Perfectly matched layer from the top down: height of an element in wavelengths and its complex stretching factor,
# which is close to 1 where waves arrive and large where only the static field is left.  The error of the motion is
# 4e-6 or less on PZT-8, LiNbO3 YZ and ST-X quartz.  From level 3 on another element with a real stretch follows,
# because the grounded bottom would disturb the static field of a transducer (2e-5 of the motion on YZ LiNbO3 and
# PZT-5A).  A complex stretch of this element would make modes grow.
MATCHED_LAYER = ((0.5, 1 - 1j), (0.5, 1.5 - 2j), (0.5, 4 - 4j), (0.5, 12 - 8j), (0.5, 60 - 20j))
STATIC_ELEMENT = (0.5, 300 + 0j)

# Selective layer, with t = 0 at its top and t = 1 at its bottom.  The complex stretching factor of the depth is
#     1 + STRETCH t^STRETCH_POWER + STATIC_STRETCH t^STATIC_POWER - i DECAY t,                                (1)
# and the loss of the motion of a slowness sheet is its backwardness times
#     f DAMPING t^DAMPING_POWER,                                                                              (2)
# with a factor f of DAMPING_TRIALS.  On 128YX LiNbO3 a layer of 2 wavelengths has errors of 1.4e-6 in u_z and 5.6e-6
# in u_x, measured by tests/fem/discretize/test_half_space.py; with STRETCH 9 or 12, STRETCH_POWER 2 or DAMPING_POWER
# 4 they are 4e-5 and more.  STATIC_STRETCH serves the static field of a transducer, which the grounded bottom
# disturbs without it (2e-4 of the motion).  With STATIC_POWER 16 modes grow in layers of 2.5 wavelengths and more.
STRETCH, STRETCH_POWER, DECAY = 21.0, 1.6, 6.0
STATIC_STRETCH, STATIC_POWER = 1000.0, 24
DAMPING, DAMPING_POWER = 13.0, 8
NODES = 17  # per wavelength of a selective layer; with 12 modes grow (128YX, by 6e-4 of k)
# Pairs (f, share) that are tried in turn until no mode grows: f of equation (2), and the least backwardness that is
# assumed of a sheet, as a share of that of the most concave sheet.  If the polarisation of a sheet changes with the
# direction (X quartz), a loss of one polarisation is not sufficient.
DAMPING_TRIALS = ((1.0, 0.0), (2.0, 0.0), (2.0, 0.25), (4.0, 0.0), (4.0, 0.25), (8.0, 0.25))
# Nepers per slowest bulk wavelength, as `layer_growth` returns them; 1e-3 causes errors of the motion of 1e-3 and more.
MAX_GROWTH = 1e-4
TYPICAL_ORDER, TYPICAL_LEVEL = 7, 2  # order and level at which the kind of layer is selected

# Loss factor of the lowest element of a viscous layer, and the power of the depth with which it increases.  With 8
# elements the error of the motion on 128YX LiNbO3 is 2e-4; with a square law it is 8e-4, with a fourth power and a
# loss of 4 it is 6e-4.
MAX_LOSS, LOSS_POWER = 0.6, 3


class Depth(NamedTuple):
    """Extent of the three layers at one level of refinement."""

    static: bool  # True if a matched layer has the `STATIC_ELEMENT`
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


def absorber(
    solid: Solid, body: Medium, order: int, level: int, *, lateral: bool = False, layered: bool = False
) -> Layer:
    """Elements below the solid from the bottom up: height in wavelengths, mean complex stretching factor, medium.

    ``body``: medium of the solid in the fields that take part; ``level``: level of refinement, an index of `DEPTHS`;
    ``lateral``: True if the waves will have a lateral wavenumber.  Oblique waves may then grow in a matched layer that
    absorbs all waves of the sagittal plane (ST-X quartz: 6e-3 nepers per wavelength; LiNbO3 rotated by 41 degrees:
    3e-4). A selective layer is used instead, in which none grows (tests/fem/discretize/test_absorber.py).
    ``layered``: True if the solid carries layers; a matched layer then has the static element one level earlier: under
    fingers on ZnO on diamond, which send little wave, the error of the motion is 1.4e-4 without it.
    """
    kind = absorber_kind(solid)
    if kind == "matched" and lateral and not isotropic_about_normal(solid):
        kind = "selective"
    if kind == "matched":
        return _matched(body, DEPTHS[min(level + layered, len(DEPTHS) - 1)].static)
    if kind == "viscous":
        return _viscous(body, DEPTHS[level].viscous)
    trial, _ = _damping_trial(solid, order, level)
    return _selective(solid, body, order, DEPTHS[level].selective, *trial)


@lru_cache(maxsize=32)
def absorber_kind(solid: Solid) -> Kind:
    """Select the kind of layer that absorbs all waves of a solid in the stator's frame."""
    body = _lossless(solid)
    if stretch_absorbs(solid) and layer_growth(solid, body, _matched(body, False), TYPICAL_ORDER) < MAX_GROWTH:
        return "matched"
    if not np.isfinite(backwardness(solid)) or _damping_trial(solid, TYPICAL_ORDER, TYPICAL_LEVEL)[1] > MAX_GROWTH:
        return "viscous"
    return "selective"


def backwardness(solid: Solid) -> float:
    """Largest |k_z V_z / (k_x V_x)| of the bulk waves of the sagittal plane whose k_z V_z < 0; 0 if there is none."""
    return max(sheet.backwardness for sheet in slowness_sheets(solid))


@lru_cache(maxsize=64)
def _damping_trial(solid: Solid, order: int, level: int) -> tuple[tuple[float, float], float]:
    """The pair of `DAMPING_TRIALS` to use, and the growth of the guided modes with it.

    It is the first pair for which no mode grows, or else the pair with the least growth.
    """
    body, tried = _lossless(solid), []
    for trial in DAMPING_TRIALS:
        layer = _selective(solid, body, order, DEPTHS[level].selective, *trial)
        tried.append((layer_growth(solid, body, layer, order), trial))
        if tried[-1][0] < MAX_GROWTH:
            break
    growth, trial = min(tried)
    return trial, growth


def _lossless(solid: Solid) -> Medium:
    return medium(solid, fields(solid), lossy=False)


def _matched(body: Medium, static: bool) -> Layer:
    layer = (*MATCHED_LAYER, STATIC_ELEMENT) if static else MATCHED_LAYER
    return [(height, stretch, body) for height, stretch in layer[::-1]]


def _viscous(body: Medium, count: int) -> Layer:
    """Elements of one wavelength whose loss factor rises with the depth to nearly MAX_LOSS."""
    losses = MAX_LOSS * ((np.arange(count) + 0.5) / count) ** LOSS_POWER
    return [(1.0, 1.0, damped(body, 1 - 1j * loss)) for loss in losses[::-1]]


def _selective(solid: Solid, body: Medium, order: int, depth: float, factor: float, least_share: float) -> Layer:
    """Selective layer of a depth in wavelengths, for one pair (factor, least_share) of `DAMPING_TRIALS`.

    ``loss`` is the matrix of the damping over the displacements: for each slowness sheet its modulus times its
    backwardness, which counts at least as ``least_share`` of the largest one, projected on its polarisation.
    """
    names, sheets = fields(solid), slowness_sheets(solid)
    worst = max(sheet.backwardness for sheet in sheets)
    displaced = [body.fields.index(name) for name in names if name != "phi"]
    loss = np.zeros((len(body.fields),) * 2)
    for sheet in sheets:
        weight = max(sheet.backwardness, least_share * worst) * sheet.modulus * (units(solid)[0] / body.stress_unit)
        loss[np.ix_(displaced, displaced)] += weight * np.outer(sheet.polarisation, sheet.polarisation)
    count = int(np.ceil(NODES * depth / order))

    def element(number: int) -> tuple[float, complex, Medium]:
        """Element number 0 is the lowest; ``height`` runs from 0 to 1 within an element, upwards."""

        def stretch(height: np.ndarray) -> np.ndarray:  # equation (1)
            t = 1 - (number + height) / count
            return 1 + STRETCH * t**STRETCH_POWER + STATIC_STRETCH * t**STATIC_POWER - 1j * DECAY * t

        def damping(height: np.ndarray) -> np.ndarray:  # equation (2)
            return factor * DAMPING * (1 - (number + height) / count) ** DAMPING_POWER

        mean, part = graded_medium(body, order, stretch=stretch, damping=damping, loss=loss)
        return depth / count, mean, part

    return [element(number) for number in range(count)]
