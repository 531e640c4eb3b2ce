"""What is drawn beside the field, the same in the pyvista window and on the HTML page: electrodes, balls, crystal axes.

Lengths are in m; colours are chosen so that they differ from the field's colour maps and from each other for every eye
(Okabe and Ito 2008).
"""

from dataclasses import dataclass, field

import numpy as np

from fem import rotation_matrix
from studies.report.free_surface import SEEN
from studies.view.run_field import RunField

AXIS_COLOUR, BALL_COLOUR = "#009E73", "#999999"
KINDS = {"+": ("#000000", "+ fingers"), "-": ("#CC79A7", "- fingers"), "o": ("#E69F00", "open strips")}


@dataclass(frozen=True, kw_only=True)
class Electrode:
    """The strips of one electrode, or the open strips, of all transducers."""

    sign: str  # "+", "-" or "o"
    colour: str
    label: str  # of the legend
    strips: tuple[tuple[float, float], ...] = field(repr=False)  # left and right edges, m


@dataclass(frozen=True, kw_only=True)
class Ball:
    """A ball of the slider."""

    place: float  # x of the contact, m
    lateral: float  # y of it, m
    radius: float  # m
    crest: float  # |u_z| of the surface under it, m per V: it rides on the crests of the enlarged wave


def electrodes(run: RunField) -> tuple[Electrode, ...]:
    """Return the electrodes that have strips."""
    return tuple(
        Electrode(sign=sign, colour=KINDS[sign][0], label=KINDS[sign][1], strips=tuple(strips))
        for sign, strips in run.fingers.items()
        if strips
    )


def shown_fingers(run: RunField, start: float, stop: float) -> str:
    """Return how many of the strips lie between two places (m), for a caption; empty without electrodes."""
    strips = [strip for each in electrodes(run) for strip in each.strips]
    shown = sum(left < stop and right > start for left, right in strips)
    return f"{shown} of {len(strips)} fingers" if shown else ""


def balls(run: RunField, *, spreads: bool = False) -> tuple[Ball, ...]:
    """Return the balls of the slider, on the crests of the section or of the beam."""
    listed = []
    for x, y in () if run.scene.slider is None else run.scene.slider.places:
        place = x if spreads else run.in_section((x, y))
        crest = abs(run.beam.motion(x, y)[2] if spreads else run.surface(place)[1])
        listed.append(Ball(place=place, lateral=y, radius=run.radius, crest=crest))
    return tuple(listed)


def crystal_axes(run: RunField) -> tuple[tuple[str, float, float], ...]:
    """Return name and x and z components of the crystal axes that lie in the section, at least in part."""
    columns = rotation_matrix(run.scene.stator.orientation).T
    return tuple(
        (name, float(x), float(z))
        for name, (x, _, z) in zip("XYZ", columns, strict=True)
        if np.hypot(x, z) > SEEN
    )
