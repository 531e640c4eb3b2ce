"""Sizes of the elements through the depth of a stator, and the numbering of the unknowns on a vertical line.

The elements shrink by a fixed ratio per layer towards the surface, where the charge at a finger edge is singular
(r^-1/2), and towards a bottom corner where a clamped face meets a free one.  An absorbing bottom is described in
absorber.py, the vacuum above in vacuum.py.  The matrices of the elements (stiffness, inertia) are integrated in
element_matrices.py, and on meshes in quad_elements.py.
"""

from dataclasses import replace

import numpy as np

from fem.analytic.layered_wave import bound_wave
from fem.discretize import bond as bonds
from fem.discretize.absorber import absorber
from fem.discretize.element_sizes import CORNER_RATIO, LAYER_RATIO, Resolution, bottom_corners, edge_layers, graded
from fem.discretize.graded_medium import is_bond
from fem.discretize.layered_depth import Region, divided, with_corner
from fem.discretize.section import FIELD_COLUMN, Section
from fem.discretize.vacuum import vacuum_elements
from fem.exceptions import ConvergenceError, InputError
from fem.geometry import Stator
from fem.materials.medium import media

# Depth of ordinary solid above the absorbing layer, in wavelengths: of a half-space, and the largest
HALF_SPACE_DEPTH, MAX_DEPTH = 2.0, 8.0
# Smallest height of the element that is graded, in wavelengths; under narrower fingers it is divided into more layers.
FINGER_SCALE = 0.125
# Largest number of unknowns on a vertical line, at a typical polynomial order; a driven stator then takes about
# MINUTES_AT_MAX.
MAX_UNKNOWNS, TYPICAL_ORDER = 2000, 7
MINUTES_AT_MAX = 10


def discretise(
    stator: Stator,
    resolution: Resolution,
    *,
    wavelength: float,
    surface_scale: float,
    lateral: bool = False,
    least_depth: float = HALF_SPACE_DEPTH,
) -> Section:
    """Divide the depth of a stator into elements and number the unknowns of a vertical line.

    Parameters
    ----------
    stator : Stator
    resolution : Resolution
    wavelength : float
        Wavelength of the slowest bulk wave at the drive frequency in m; it limits the size of the elements.
    surface_scale : float
        Length in m over which the electrodes vary along the surface (half a finger); it sets the height of the graded
        element.  Infinite if there is no electrode.
    lateral : bool
        True if the fields will have a lateral wavenumber, so that all displacements, and phi in a piezoelectric stator,
        take part.
    least_depth : float
        Least depth of ordinary solid above an absorbing layer, in wavelengths; a half-space has exactly this depth.

    Raises
    ------
    ConvergenceError
        If the plate is so thick that a line would have many more unknowns than MAX_UNKNOWNS.
    """
    names = lateral_fields(stator) if lateral else stator.fields
    bodies = media(stator.solids, names)
    _refuse_thick(stator, resolution, wavelength, len(names))
    depth = _solid_depth(stator, wavelength, least_depth)
    top, layers = _graded_top(resolution, depth, surface_scale / wavelength)
    if stator.layers:
        solid, owners, above_plane = _layered_heights(stator, resolution, wavelength, depth, surface_scale / wavelength)
    else:
        solid = _solid_heights(stator, resolution, depth, top, layers)
        owners, above_plane = [0] * len(solid), 0
    below = []
    if stator.absorbs_below:
        own = stator.relative_wavelengths[0]
        kind = {"lateral": lateral, "layered": bool(stator.layers)}
        below = absorber(stator.solid, bodies[0], resolution.order, resolution.absorber, **kind)
        below = [(own * height, stretch, each) for height, stretch, each in below]
    above = np.empty(0)
    parts = [each for _, _, each in below]
    for height, owner in zip(solid, owners, strict=True):
        bond = stator.layers[owner - 1].bond if owner and height == bonds.HEIGHT else None
        parts.append(bonds.bond_medium(bond, bodies[owner], resolution.order, wavelength) if bond else bodies[owner])
    solid_elements = len(parts)
    if stator.above == "vacuum" and "phi" in parts[-1].fields:
        above, vacuum = vacuum_elements(stator, bodies, resolution, wavelength=wavelength, top=top, layers=layers)
        parts += vacuum
    heights = np.concatenate([[height.real for height, _, _ in below], solid, above])
    breakpoints = np.concatenate([[0.0], np.cumsum(heights)])
    breakpoints -= breakpoints[solid_elements]
    stretched = solid.astype(complex) if stator.absorbs_below else solid
    return Section(
        heights=np.concatenate([[height * stretch for height, stretch, _ in below], stretched, above]),
        breakpoints=breakpoints,
        media=tuple(parts),
        solid=replace(bodies[0], fields=names, inertia=np.zeros(len(names))) if stator.solid.conducting else bodies[0],
        owners=(0,) * len(below) + tuple(owners),
        order=resolution.order,
        length_unit=wavelength,
        dofs=_numbered(names, solid_elements, parts, resolution.order, stator),
        surface=solid_elements * resolution.order,
        plane=(solid_elements - above_plane) * resolution.order,
        bottom=len(below) * resolution.order,
        surface_scale=surface_scale,
        surface_speed=_surface_speed(stator, stator.slowest_wavelength(1.0) / wavelength),
    )


def _refuse_thick(stator: Stator, resolution: Resolution, unit: float, fields: int) -> None:
    """Raise a ConvergenceError if a section is so thick that it would take far too long; ``fields``: number."""
    regions = _regions(stator, resolution, unit, stator.thickness / unit)
    if stator.absorbs_below:
        regions = regions[:-1]  # the solid counts down to the absorbing layer alone
    unknowns = sum(each.thickness / each.largest for each in regions) * TYPICAL_ORDER * fields
    if unknowns <= MAX_UNKNOWNS:
        return
    what, thickness = "stator.thickness", stator.thickness
    remedy = 'take a thinner one, or bottom = "absorbing" where the bottom does not matter'
    if stator.absorbs_below:
        what, thickness = "stator.layers", stator.coating
        remedy = "make the thick one the material of the stator"
    minutes = MINUTES_AT_MAX * (unknowns / MAX_UNKNOWNS) ** 3
    raise ConvergenceError(
        f"{what}, {thickness:g} m, is {thickness / unit:.3g} wavelengths: its section has about {unknowns:.3g} "
        f"unknowns on a line, takes {minutes:.2g} minutes or more and is not begun: {remedy}"
    )


def _solid_depth(stator: Stator, unit: float, least_depth: float) -> float:
    """Depth of the ordinary solid, length units: the thickness, or what lies above an absorbing layer."""
    own = stator.relative_wavelengths[0]
    depth = stator.thickness / unit if np.isfinite(stator.thickness) else own * least_depth
    if not stator.absorbs_below:
        return depth
    # Every thickness stands for the same half-space, but an absorbing layer near the surface causes errors of 1e-4.
    depth = min(max(depth, own * least_depth), own * MAX_DEPTH)
    deepest = max(stator.pieces, key=lambda piece: piece.depth, default=None)
    if deepest is None:
        return depth
    if deepest.depth / unit > MAX_DEPTH * (1 + 1e-6):
        raise InputError(
            "piece",
            f"must be drawn down to at most {MAX_DEPTH * unit * 1e3:.4g} mm ({MAX_DEPTH:g} wavelengths) where the "
            "bottom absorbs, below which the program continues the solid by itself: it is drawn down to "
            f"{deepest.depth * 1e3:.4g} mm",
            owner=deepest.name,
        )
    return max(depth, deepest.depth / unit)


def _graded_top(resolution: Resolution, depth: float, scale: float) -> tuple[float, int]:
    """Height of the uppermost element, and number of layers that it is graded into; ``scale``: half a finger."""
    largest = resolution.element_size
    if not (resolution.edge_layers and np.isfinite(scale)):
        return min(depth, largest), 0
    top = min(max(scale, FINGER_SCALE), depth / 2, largest)
    return top, edge_layers(resolution, top, min(scale, top))


def _solid_heights(stator: Stator, resolution: Resolution, depth: float, top: float, layers: int) -> np.ndarray:
    """Heights of the elements of the ordinary solid from the bottom up, length units."""
    largest = resolution.element_size
    surface = graded(top, layers, largest=largest)
    if depth <= top * (1 + 1e-9):
        return surface
    corner_layers = resolution.edge_layers if bottom_corners(stator) and layers else 0
    rest = graded(depth - top, corner_layers, largest=largest, smallest_first=True, ratio=CORNER_RATIO)
    return np.concatenate([rest, surface])


def _regions(stator: Stator, resolution: Resolution, unit: float, depth: float) -> list[Region]:
    """The layers from the surface down and the solid, of a depth in length units; ``unit``: the length unit in m."""
    thicknesses = [depth, *((each.thickness or 0.0) / unit for each in stator.layers)]
    own = stator.relative_wavelengths
    return [Region(each, resolution.element_size * own[k], k) for k, each in enumerate(thicknesses)][::-1]


def _layered_heights(
    stator: Stator, resolution: Resolution, unit: float, depth: float, scale: float
) -> tuple[np.ndarray, list[int], int]:
    """Heights of the elements of solid and layers from the bottom up, their solids, and how many are above the fingers.

    Arguments as of `_regions` and `_graded_top`.
    """
    regions = _regions(stator, resolution, unit, depth)
    over, under = regions[: stator.plane][::-1], regions[stator.plane :]
    top, layers = _graded_top(resolution, sum(each.thickness for each in under), scale)
    smallest = top * LAYER_RATIO**layers if resolution.edge_layers and np.isfinite(scale) else np.inf
    finest_over, finest_under = _finest(stator, smallest)
    elements = divided(under, finest_under)[::-1]
    if bottom_corners(stator) and layers:
        elements = with_corner(elements, resolution.edge_layers, under[-1].largest)
    coating = divided(over, finest_over)
    coating = _with_bonds(stator, coating, elements[-1][1])
    heights, owners = zip(*_with_bonds(stator, elements, 0), *coating, strict=True)
    return np.array(heights), list(owners), len(coating)


def _finest(stator: Stator, smallest: float) -> tuple[float, float]:
    """Heights of the elements above and below the plane of the fingers, where ``smallest`` is that of one solid.

    Near an edge the error of the energy grows as the element's height times the permittivity, so that the side with
    the smaller one needs no finer elements than this ratio says; at most one layer of the grading is left out.
    """
    if not stator.plane:
        return smallest, smallest
    under, over = (stator.solids[-stator.plane - 1 + k].sagittal_permittivity for k in (0, 1))
    coarser = [min(max(ratio, 1.0), 1.0 / LAYER_RATIO) for ratio in (under / over, over / under)]
    return smallest * coarser[0], smallest * coarser[1]


def _with_bonds(stator: Stator, elements: list[tuple[float, int]], below: int) -> list[tuple[float, int]]:
    """Return the elements from the bottom up with one for each bond; ``below``: solid below the lowest of them."""
    result = []
    for height, owner in elements:
        if owner != below and stator.layers[owner - 1].bond is not None:
            result.append((bonds.HEIGHT, owner))
        result.append((height, owner))
        below = owner
    return result


def lateral_fields(stator: Stator) -> tuple[str, ...]:
    """Names of the fields that take part if the solution depends on y."""
    return ("ux", "uy", "uz", "phi") if any(each.is_piezoelectric for each in stator.solids) else ("ux", "uy", "uz")


def _surface_speed(stator: Stator, frequency: float) -> float | None:
    """Velocity of the half-space's Rayleigh wave in m/s at a frequency in Hz; None if it is leaky."""
    try:
        return bound_wave(stator, frequency, "open").velocity
    except ConvergenceError:
        return None


def _numbered(names, solid_elements, media, order, stator) -> np.ndarray:
    """Number of each field's unknown at each node of a line, shape (nodes, 4); -1 if absent or fixed at zero."""
    exists = np.zeros((len(media) * order + 1, 4), dtype=bool)
    for name in names:
        exists[: solid_elements * order + 1, FIELD_COLUMN[name]] = True
    if len(media) > solid_elements:
        exists[solid_elements * order :, FIELD_COLUMN["phi"]] = True
    for element, own in enumerate(media):
        if "phi" not in own.fields:  # a conductor, whose potential counts as zero
            exists[element * order : (element + 1) * order + 1, FIELD_COLUMN["phi"]] = False
        if is_bond(own):
            exists[element * order + 1 : (element + 1) * order] = False
    if stator.bottom == "clamped" or stator.absorbs_below:
        exists[0, :3] = False
    if stator.bottom == "grounded" or stator.absorbs_below:
        exists[0, FIELD_COLUMN["phi"]] = False
    dofs = np.full(exists.shape, -1)
    dofs[exists] = np.arange(exists.sum())
    return dofs
