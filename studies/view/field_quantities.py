"""Quantities that can colour a picture of a field: value at an instant, range and colour map.

Title and unit are those of ``field`` and, for a free wave, of ``free_field`` in the table of quantities.

A quantity at the phase omega t is mean + Re(amplitude exp(i n omega t)), with n = 1 for displacements and potential and
n = 2 for energy and power.  The colour maps are matplotlib's RdBu_r (blue over white to red) for quantities of both
signs, and Blues for those that are never negative.  Both are legible to colour-blind readers and change evenly in
lightness.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import matplotlib
import numpy as np
from PIL import Image

from studies.record import quantities as table
from studies.refusal import refuse_if, refuse_unknown

# Colours of the marks in overlays.py that are not black, grey or white.
MARK_COLOURS = ("#CC79A7", "#E69F00", "#009E73")
SCALE = 192  # number of a palette's 256 colours that the colour map takes
DIVERGING, SEQUENTIAL = "RdBu_r", "Blues"


class Quantity(NamedTuple):
    """A quantity that can colour a field."""

    name: str  # on the command line, and in the table of quantities
    parts: Callable  # returns mean and complex amplitude of a WaveField, in SI units
    signed: bool = True  # True if it takes both signs
    harmonic: int = 1  # n, the frequency of the quantity over that of the wave
    envelope: bool = False  # True if only its amplitude is drawn

    def entry(self, free: bool) -> table.Quantity:
        """Return its entry in the table of quantities."""
        return table.quantity(f"{'free_' * free}field.{self.name}")

    @property
    def title(self) -> str:
        """Text in pictures."""
        return f"{'amplitude of ' * self.envelope}{self.entry(False).label}"


MOTIONS = ("u_x", "u_y", "u_z")
QUANTITIES = {
    each.name: each
    for each in (
        Quantity("u_z", lambda f: (0.0, f.displacement[..., 2])),
        Quantity("u_x", lambda f: (0.0, f.displacement[..., 0])),
        Quantity("u_y", lambda f: (0.0, f.displacement[..., 1])),
        Quantity("potential", lambda f: (0.0, f.potential)),
        Quantity("strain_energy", lambda f: (f.densities.strain_energy, f.densities.strain_energy_pulse),
                 signed=False, harmonic=2),
        Quantity("power_flow", lambda f: (f.densities.power_flow[..., 0], f.densities.power_flow_pulse[..., 0]),
                 harmonic=2),
    )
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Shade:
    """Colouring of the field of one run by a quantity."""

    quantity: Quantity
    label: str  # title and unit
    scale: float  # factor from SI units to the unit of the label
    # End of the colour scale: the largest value outside the transducers, because the field is singular at finger edges.
    scale_end: float

    @property
    def limits(self) -> tuple[float, float]:
        """The two ends of the colour scale."""
        return (-self.scale_end, self.scale_end) if self.quantity.signed else (0.0, self.scale_end)

    @property
    def colour_map(self) -> str:
        """Name of the matplotlib colour map."""
        return DIVERGING if self.quantity.signed else SEQUENTIAL

    def parts(self, field) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and amplitude at the nodes of a field, shapes (nx, nz), in the unit of the label."""
        mean, amplitude = self.quantity.parts(field)
        return np.broadcast_to(mean, amplitude.shape) * self.scale, amplitude * self.scale


def quantity(name: str) -> Quantity:
    """Return a quantity by its name."""
    refuse_unknown(name, QUANTITIES, "--quantity")
    return QUANTITIES[name]


def present(run) -> list[str]:
    """Return the names of the quantities that are not zero in the field of a run."""
    absent = {"u_y": not np.any(run.field.displacement[..., 1]), "potential": not np.any(run.field.potential)}
    return [name for name in QUANTITIES if not absent.get(name, False)]


def shade(run, name: str) -> Shade:
    """Return the colouring of a run's field by a quantity; SceneError if unknown or zero in this solid."""
    drawn = quantity(name)
    field = run.with_energies if drawn.harmonic == 2 else run.field
    mean, amplitude = drawn.parts(field)
    outside = ~run.near_transducer(field.x)
    material = run.scene.stator.orientation
    refuse_if(
        not np.any(amplitude),
        "--quantity",
        f"{name!r} is zero everywhere: uncoupled in this solid, orientation {material}",
    )
    outside |= not outside.any()  # all points, if fingers cover the whole stator
    size = abs(amplitude[outside]) + (abs(mean[outside]) if drawn.harmonic == 2 else 0.0)
    return shade_of(drawn, size, free=run.free)


def shade_of(drawn: Quantity, size, *, free: bool) -> Shade:
    """Return the colouring by a quantity of values whose magnitudes are ``size``, in SI units."""
    entry = drawn.entry(free)
    label, scale_end = f"{drawn.title} ({entry.shown})", float(np.max(size)) * entry.scale
    return Shade(quantity=drawn, label=label, scale=entry.scale, scale_end=scale_end)


def palette(colour_map: str):
    """Return an image whose palette has 256 colours: those of the colour map and of the marks, and greys."""
    scale = matplotlib.colormaps[colour_map](np.linspace(0.0, 1.0, SCALE), bytes=True)[:, :3]
    marks = [list(bytes.fromhex(colour[1:])) for colour in MARK_COLOURS]
    greys = np.repeat(np.linspace(0, 255, 256 - SCALE - len(marks)).round()[:, None], 3, axis=1)
    image = Image.new("P", (1, 1))
    image.putpalette(np.concatenate([scale, marks, greys]).astype(np.uint8).tobytes())
    return image
