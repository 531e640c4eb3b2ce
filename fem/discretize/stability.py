"""Stability of absorbing layers: growth of guided modes in the direction of their power flux.

In a layer with stretched depth a bulk wave grows if its energy travels down while its phase travels up (Becache,
Fauqueux and Joly 2003).  The section then has guided modes with power along +x and Im k > 0 for exp(-i k x).
"""

from collections.abc import Sequence

import numpy as np

from fem.discretize.section import FIELD_COLUMN, Section
from fem.eigenproblem import companion_modes, even_odd_modes
from fem.materials.christoffel import slowest_wavelength
from fem.materials.medium import Medium
from fem.materials.solids import Solid

TRIAL_FREQUENCY = 1e6  # Hz; arbitrary, because the layer's depth is in wavelengths
TRIAL_SOLID = (0.5, 0.5)  # elements of solid above the layer, wavelengths
PROPAGATING = 0.3  # |Im k| / |Re k| below which the power flux of a mode determines its direction
# rad per slowest bulk wavelength; modes with larger k are not physical but belong to the discretisation
MAX_WAVENUMBER = 4 * np.pi
Layer = Sequence[tuple[float, complex, Medium]]  # height in wavelengths, mean stretch, medium; from the bottom up


def largest_growth(wavenumbers: np.ndarray, shapes: np.ndarray, flux: np.ndarray) -> float:
    """Largest growth Im k > 0 of a mode along its power flux, nepers per slowest bulk wavelength; 0 if none grows.

    ``wavenumbers``: of modes of either direction, rad per slowest bulk wavelength; ``shapes``: in columns;
    ``flux``: the traction of each mode on a line x = const, in columns.
    """
    size = abs(wavenumbers.real)
    counted = (abs(wavenumbers.imag) < PROPAGATING * size) & (size < MAX_WAVENUMBER)
    carried = -np.imag(np.sum(flux[:, counted] * np.conj(shapes[:, counted]), axis=0))
    return float(np.max(np.sign(carried) * wavenumbers[counted].imag, initial=0.0))


def layer_growth(solid: Solid, body: Medium, layer: Layer, order: int) -> float:
    """Largest growth of a guided mode over an absorbing layer, nepers per slowest bulk wavelength.

    ``solid``: in the stator's frame; ``body``: its medium without loss, with the same unknowns (among u_x, u_y,
    u_z and phi) as the layer.
    """
    section = _trial_section(solid, body, layer, order)
    second, first, zeroth = section.matrices(TRIAL_FREQUENCY)
    if section.odd is None:
        wavenumbers, shapes = companion_modes(second, 1j * (first - first.T), zeroth)
    else:
        wavenumbers, shapes = even_odd_modes(second, first - first.T, zeroth, section.odd)
    return largest_growth(wavenumbers, shapes, first @ shapes - 1j * (second @ shapes) * wavenumbers)


def _trial_section(solid: Solid, body: Medium, layer: Layer, order: int) -> Section:
    """Section of the layer below a little of the solid; its length unit is the slowest bulk wavelength.

    Row 0 of ``exists``, the lower face of the layer, has no unknowns: it is clamped and grounded.  The heights are
    complex because the layer is stretched.
    """
    heights = np.array([height * stretch for height, stretch, _ in layer] + list(TRIAL_SOLID), dtype=complex)
    media = tuple(each for _, _, each in layer) + (body,) * len(TRIAL_SOLID)
    exists = np.zeros((len(heights) * order + 1, 4), dtype=bool)
    exists[1:, [FIELD_COLUMN[name] for name in body.fields]] = True
    dofs = np.full(exists.shape, -1)
    dofs[exists] = np.arange(exists.sum())
    return Section(
        heights=heights,
        breakpoints=np.concatenate([[0.0], np.cumsum(heights.real)]),
        media=media,
        solid=body,
        owners=(0,) * len(heights),
        order=order,
        length_unit=slowest_wavelength(solid, TRIAL_FREQUENCY),
        dofs=dofs,
        surface=len(dofs) - 1,
        plane=len(dofs) - 1,
        bottom=len(layer) * order,
        surface_scale=np.inf,
        surface_speed=None,
    )
