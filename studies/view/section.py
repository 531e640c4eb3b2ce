"""What is shown of the section: its stretches one above the other, and the points of the field that are drawn.

Field points are nodes: those nearer to the one before than a pixel are passed over, and where nodes are far apart the
modes and the elements' polynomials give points between them.  Nothing is averaged.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from studies.refusal import SceneError
from studies.view.quantities import Shade
from studies.view.run_field import LINES, RunField

__all__ = ["View", "chosen_views", "limits", "magnification", "near", "piece", "thinned", "views"]

MM = 1e3
AMPLITUDE = 0.08  # of a wavelength: as large as the largest displacement is drawn
CLOSE = 7.0  # wavelengths either side, in the close views
NARROWEST = 0.05  # wavelengths
FACET = 4.0  # largest distance of drawn points over the smallest


@dataclass(frozen=True, kw_only=True)
class View:
    """A stretch of the section from start to stop (m), and its share of the picture's height."""

    name: str
    start: float
    stop: float
    weight: float


def limits(found: RunField, span) -> tuple[float, float] | None:
    """Return the stretch (m) that "whole", "slider", "wavelength" or two places mean; refuse one off the stator."""
    if span is None:
        return None
    if span == "whole":
        return 0.0, found.length
    if isinstance(span, str):
        half = (0.5 if span == "wavelength" else CLOSE) * found.wavelength
        return max(found.focus[1] - half, 0.0), min(found.focus[1] + half, found.length)
    if not 0 <= span[0] < span[1] <= found.length * (1 + 1e-9):
        rule = f"must lie on the stator, 0:{found.length * 1e3:g} mm"
        raise SceneError("--span", f"{rule}, got {span[0] * 1e3:g}:{span[1] * 1e3:g} mm")
    least = NARROWEST * found.wavelength
    if span[1] - span[0] < least:
        rule = f"must be at least {least * 1e3:.3g} mm long, a twentieth of a wavelength"
        raise SceneError("--span", f"{rule}, got {(span[1] - span[0]) * 1e3:.3g} mm")
    return span


def near(found: RunField) -> tuple[float, float]:
    """Return the two wavelengths (m) about what is to be looked at from near."""
    return found.focus[1] - found.wavelength, found.focus[1] + found.wavelength


def views(found: RunField) -> tuple[View, ...]:
    """Return what is shown unless something else is asked for: the whole, the driven transducer, the slider."""
    if found.free:
        return chosen_views(found, (0.0, found.length))
    driven, reach = found.scene.driven_transducer, CLOSE * found.wavelength
    whole = View(name="the whole section", start=0.0, stop=found.length, weight=0.17)
    return whole, *(
        View(name=name, start=max(place - reach, 0.0), stop=min(place + reach, found.length), weight=0.4)
        for name, place in (
            (f"driven transducer {driven.name!r}", found.in_section(driven.place)),
            found.focus,
        )
    )


def chosen_views(found: RunField, span: tuple[float, float] | None) -> tuple[View, ...]:
    """Return the whole section and below it a stretch (m), what lies about the slider if None."""
    start, stop = span or limits(found, "slider")
    count = (stop - start) / found.wavelength
    name = "1 wavelength" if abs(count - 1) < 5e-4 else f"{count:.3g} wavelengths"
    if stop - start > 0.99 * found.length:
        return (View(name=name, start=start, stop=stop, weight=1.0),)
    whole = View(name="the whole section", start=0.0, stop=found.length, weight=0.3)
    name = f"{name}, {start * MM:.4g} to {stop * MM:.4g} mm"
    return whole, View(name=name, start=start, stop=stop, weight=0.7)


def magnification(found: RunField) -> float:
    """Return how many times the displacement is enlarged unless asked otherwise: one round digit."""
    largest = float(abs(found.field.displacement).max())
    return float(f"{AMPLITUDE * found.wavelength / largest:.0e}") if largest else 1.0


@dataclass(frozen=True, kw_only=True)
class Piece:
    """A piece of the section: x (n,) and z (m,) in m, complex u_x and u_z (n, m, 2), parts of a shade (n, m)."""

    x: np.ndarray
    z: np.ndarray
    displacement: np.ndarray
    mean: np.ndarray
    amplitude: np.ndarray


def piece(
    found: RunField, shading: Shade, *, span: tuple[float, float], bottom: float, spacing: float
) -> Piece:
    """Return a piece of the field between two places and down to a depth; neighbours at least a spacing (m) apart."""
    energies, facet = shading.quantity.turns == 2, FACET * spacing
    if facet < found.wavelength / LINES:
        field = found.compute(span=span, per_wavelength=found.wavelength / facet, energies=energies)
    else:
        field = found.with_energies if energies else found.field
    lines = thinned(field.x, spacing, *span)
    bottom = max(bottom, field.z[0])
    nodes = np.append(bottom, field.z[field.z > bottom])
    nodes = nodes[thinned(nodes, spacing, bottom, 0.0)]
    parts = [
        np.linspace(low, high, int(np.ceil((high - low) / facet)), endpoint=False)
        for low, high in pairwise(nodes)
    ]
    z = np.append(np.concatenate(parts), 0.0)
    basis = field.depth_basis(z)
    displacement, mean, amplitude = (
        np.einsum("kj,xj...->xk...", basis, values[lines])
        for values in (field.displacement[..., [0, 2]], *shading.parts(field))
    )
    return Piece(x=field.x[lines], z=z, displacement=displacement, mean=mean, amplitude=amplitude)


def thinned(places: np.ndarray, spacing: float, start: float, stop: float) -> np.ndarray:
    """Return the numbers of increasing places between two limits, each at least a spacing after the one before.

    The first and the last within the limits are always among them.

    Examples
    --------
    >>> thinned(np.array([0.0, 0.1, 0.2, 1.0, 2.0, 3.0]), 0.15, 0.0, 2.0)
    array([0, 2, 3, 4])
    """
    inside = np.flatnonzero((places >= start) & (places <= stop)).tolist()
    kept = inside[:1]
    for number in inside[1:]:
        if places[number] - places[kept[-1]] >= spacing:
            kept.append(number)
    if kept[-1] != inside[-1]:
        # the end is kept: its neighbour gives way
        kept[max(len(kept) - 1, 1) :] = inside[-1:]
    return np.array(kept)
