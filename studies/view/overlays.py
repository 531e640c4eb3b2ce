"""Electrodes, balls and crystal axes that the pyvista pictures and the HTML page draw in addition to the field.

Lengths are in m. The colours differ from the colour maps of the field and from each other, also for colour-blind
readers (Okabe and Ito 2008).
"""

from dataclasses import dataclass, field

import numpy as np

from fem import rotation_matrix
from studies.model.model import model_of
from studies.report.free_surface import MIN_COMPONENT
from studies.view.run_field import RunField

AXIS_COLOUR, BALL_COLOUR = "#009E73", "#999999"
KINDS = {"+": ("#000000", "+ fingers"), "-": ("#CC79A7", "- fingers"), "o": ("#E69F00", "open strips")}


@dataclass(frozen=True, kw_only=True)
class Electrode:
    """The strips of one electrode, or the open strips, of all transducers."""

    sign: str  # "+", "-" or "o"
    colour: str
    label: str  # text of the legend
    strips: tuple[tuple[float, float], ...] = field(repr=False)  # left and right edges, m


@dataclass(frozen=True, kw_only=True)
class Ball:
    """A ball of the slider."""

    x: float  # of the contact, along the section or the stator, m
    y: float  # of the contact, m
    radius: float  # m
    # |u_z| of the surface under the ball, m per V; the ball is drawn on the crests of the enlarged wave
    crest: float


def electrodes(run: RunField) -> tuple[Electrode, ...]:
    """Return the electrodes that have at least one strip."""
    return tuple(
        Electrode(sign=sign, colour=KINDS[sign][0], label=KINDS[sign][1], strips=tuple(strips))
        for sign, strips in run.fingers.items()
        if strips
    )


def shown_fingers(run: RunField, start: float, stop: float) -> str:
    """Return a caption with the number of strips between two positions (m), or an empty string if there are none."""
    strips = [strip for each in electrodes(run) for strip in each.strips]
    shown = sum(left < stop and right > start for left, right in strips)
    return f"{shown} of {len(strips)} fingers" if shown else ""


def balls(run: RunField, *, spreads: bool = False) -> tuple[Ball, ...]:
    """Return the balls of the slider on the surface of the section or, with ``spreads``, of the beam."""
    listed = []
    for x, y in () if run.scene.slider is None else run.scene.slider.contact_positions:
        along = x if spreads else run.in_section((x, y))
        crest = abs(run.beam.motion(x, y)[2] if spreads else run.surface(along)[1])
        listed.append(Ball(x=along, y=y, radius=run.radius, crest=crest))
    return tuple(listed)


def interfaces(run: RunField) -> tuple[float, ...]:
    """Return z in m of the lower faces of the stator's layers, from the surface down."""
    layers = model_of(run.scene).plain.layers[::-1]
    return tuple(-float(each) for each in np.cumsum([each.thickness for each in layers]))


def finger_height(run: RunField) -> float:
    """Return z in m of the plane of the fingers."""
    plane = model_of(run.scene).stator.plane
    return interfaces(run)[plane - 1] if plane else 0.0


def crystal_axes(run: RunField) -> tuple[tuple[str, float, float], ...]:
    """Return the name and the x and z components of each crystal axis with a visible projection on the section."""
    columns = rotation_matrix(run.scene.stator.cut).T
    return tuple(
        (name, float(x), float(z))
        for name, (x, _, z) in zip("XYZ", columns, strict=True)
        if np.hypot(x, z) > MIN_COMPONENT
    )
