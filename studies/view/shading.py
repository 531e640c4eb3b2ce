"""What a field can be coloured by: the quantity at an instant, its unit, its range and its colours.

A quantity at the phase omega t is mean + Re(amplitude exp(i n omega t)), n = 1 for the field itself and 2 for energy
and power.  The colours are straight lines in the perceptual space OKLab (Ottosson 2020), so that equal steps of the
quantity look equal: from blue over near-white to orange, the pair that every kind of colour-blindness tells apart, for
what takes both signs, and from near-white to dark blue for what is never negative.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from studies.refusal import SceneError, nearest

__all__ = ["QUANTITIES", "Quantity", "Shade", "colours", "palette", "present", "quantity", "shade"]

NM = 1e9
MARK_COLOURS = ("#CC79A7", "#009E73")  # of electrodes and crystal axes; the others are black, grey and white
SCALE = 192  # colours of a scale in a palette of 256
# lightness, chroma and hue (degrees) in OKLab
PALE, BLUE, ORANGE, DARK = (0.965, 0.0, 0.0), (0.45, 0.11, 252.0), (0.45, 0.11, 52.0), (0.30, 0.13, 272.0)


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """Something to colour the field by.

    Attributes
    ----------
    name : str
        As it is asked for.
    title : str
        As it is written.
    units : tuple of str
        Per volt of the source, and over u_z at the surface of a free wave.
    scales : tuple of float
        From SI to those.
    signed : bool
        Whether it takes both signs.
    turns : int
        n, its frequency over the wave's.
    parts : callable
        Mean and complex amplitude, in SI, of a WaveField.
    """

    name: str
    title: str
    units: tuple[str, str]
    scales: tuple[float, float]
    signed: bool
    turns: int
    parts: Callable


def _harmonic(name: str, title: str, units, scales, pick: Callable) -> Quantity:
    return Quantity(
        name=name,
        title=title,
        units=units,
        scales=scales,
        signed=True,
        turns=1,
        parts=lambda f: (0.0, pick(f)),
    )


QUANTITIES = {
    each.name: each
    for each in (
        _harmonic("u_z", "u_z", ("nm per V", "over u_z"), (NM, 1.0), lambda f: f.displacement[..., 2]),
        _harmonic("u_x", "u_x", ("nm per V", "over u_z"), (NM, 1.0), lambda f: f.displacement[..., 0]),
        _harmonic("u_y", "u_y", ("nm per V", "over u_z"), (NM, 1.0), lambda f: f.displacement[..., 1]),
        _harmonic("potential", "potential", ("V per V", "V per nm"), (1.0, 1 / NM), lambda f: f.potential),
        Quantity(
            name="strain_energy",
            title="strain energy",
            units=("mJ/m^3 per V^2", "J/m^3 per nm^2"),
            scales=(1e3, NM**-2),
            signed=False,
            turns=2,
            parts=lambda f: (f.densities.strain_energy, f.densities.strain_energy_pulse),
        ),
        Quantity(
            name="power_flow",
            title="power flow along x",
            units=("W/m^2 per V^2", "W/m^2 per nm^2"),
            scales=(1.0, NM**-2),
            signed=True,
            turns=2,
            parts=lambda f: (f.densities.power_flow[..., 0], f.densities.power_flow_pulse[..., 0]),
        ),
    )
}


@dataclass(frozen=True, kw_only=True)
class Shade:
    """A quantity as it colours the field of one run.

    Attributes
    ----------
    quantity : Quantity
    label : str
        Title and unit.
    scale : float
        From SI to that unit.
    reach : float
        End of the colour scale: the largest value beside the transducers, at whose edges the field is singular.
    """

    quantity: Quantity
    label: str
    scale: float
    reach: float

    @property
    def limits(self) -> tuple[float, float]:
        """Ends of the colour scale."""
        return (-self.reach, self.reach) if self.quantity.signed else (0.0, self.reach)

    @property
    def colours(self) -> str:
        """Name of the colour scale: "diverging" or "sequential"."""
        return "diverging" if self.quantity.signed else "sequential"

    def parts(self, field) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and amplitude at the nodes of a field, shapes (nx, nz), in the label's unit."""
        mean, amplitude = self.quantity.parts(field)
        return np.broadcast_to(mean, amplitude.shape) * self.scale, amplitude * self.scale


def quantity(name: str) -> Quantity:
    """Return a quantity by its name.

    Raises
    ------
    SceneError
        If there is none of that name.
    """
    if name not in QUANTITIES:
        raise SceneError("--quantity", f"{name!r} does not exist{nearest(name, QUANTITIES)}")
    return QUANTITIES[name]


def present(found) -> list[str]:
    """Return the names of the quantities that a run's field has."""
    absent = {
        "u_y": not np.any(found.field.displacement[..., 1]),
        "potential": not np.any(found.field.potential),
    }
    return [name for name in QUANTITIES if not absent.get(name, False)]


def shade(found, name: str) -> Shade:
    """Return how a quantity colours the field of a run.

    Parameters
    ----------
    found : studies.view.run_field.RunField
    name : str

    Raises
    ------
    SceneError
        For an unknown name, or a field that this solid does not have.
    """
    chosen = quantity(name)
    field = found.whole(energies=chosen.turns == 2)
    mean, amplitude = chosen.parts(field)
    outside = ~found.near_transducer(field.x)
    if not np.any(amplitude):
        material = found.scene.stator.orientation
        raise SceneError(
            "--quantity", f"{name!r} is zero everywhere: uncoupled in this solid, orientation {material}"
        )
    size = abs(amplitude[outside]) + (abs(mean[outside]) if chosen.turns == 2 else 0.0)
    unit, scale = chosen.units[found.free], chosen.scales[found.free]
    return Shade(
        quantity=chosen,
        label=f"{chosen.title} ({unit})",
        scale=scale,
        reach=float(size.max()) * scale,
    )


def colours(name: str, count: int = 256) -> np.ndarray:
    """Return a colour scale as (count, 3) numbers from 0 to 1.

    Parameters
    ----------
    name : str
        "diverging" or "sequential".
    count : int
    """
    ends = (BLUE, PALE, ORANGE) if name == "diverging" else (PALE, DARK)
    return _srgb(_line(ends, count))


def palette(name: str) -> np.ndarray:
    """Return the 256 colours that a picture of a field needs, (256, 3) of uint8: a scale, greys, the marks on it."""
    marks = [[int(colour[k : k + 2], 16) for k in (1, 3, 5)] for colour in MARK_COLOURS]
    greys = np.repeat(np.linspace(0, 255, 256 - SCALE - len(marks))[:, None], 3, axis=1)
    return np.round(np.concatenate([255 * colours(name, SCALE), marks, greys])).astype(np.uint8)


def _line(ends, count: int) -> np.ndarray:
    """Points of OKLab on straight lines from end to end, shape (count, 3)."""
    corners = np.array([(L, C * np.cos(np.radians(hue)), C * np.sin(np.radians(hue))) for L, C, hue in ends])
    place = np.linspace(0, len(ends) - 1, count)
    return np.stack([np.interp(place, range(len(ends)), corner) for corner in corners.T], axis=1)


def _srgb(lab: np.ndarray) -> np.ndarray:
    """OKLab to sRGB (Ottosson 2020)."""
    roots = lab @ np.array(
        [[1, 0.3963377774, 0.2158037573], [1, -0.1055613458, -0.0638541728], [1, -0.0894841775, -1.2914855480]]
    ).T  # fmt: skip
    linear = roots**3 @ np.array(
        [
            [4.0767416621, -3.3077115913, 0.2309699292],
            [-1.2684380046, 2.6097574011, -0.3413193965],
            [-0.0041960863, -0.7034186147, 1.7076147010],
        ]
    ).T  # fmt: skip
    if linear.min() < -1e-6 or linear.max() > 1 + 1e-6:
        raise ValueError(f"the colour scale leaves sRGB: {linear.min():.3g} to {linear.max():.3g}")
    linear = linear.clip(0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
