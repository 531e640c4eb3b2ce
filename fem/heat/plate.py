"""A plate that is heated inside and cooled at its surface: resistance, capacity and time constant.

Temperatures are rises above the surroundings. Air takes h (T - T_a) per area from all faces (natural convection and
radiation together, h of 5 to 10 W/(m^2 K)); a bottom that is held, or glued with a conductance per area, takes the heat
through half of the plate's modes of conduction: the source lies at the surface, the resistance of a unit area is H/k.
Carslaw and Jaeger, *Conduction of Heat in Solids* (1959), sections 3.3 and 4.2.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from fem.parameters import Number, Parameters

MAX_BIOT_NUMBER = 0.1  # above it the temperature differs across the section


@dataclass(frozen=True, kw_only=True)
class HeatedPlate(Parameters):
    """A plate along x with constants of its material and its cooling.

    Attributes
    ----------
    length, width, thickness : float
        Along x, y and z, m.
    conductivity : float
        Of the solid, W/(m K).
    volumetric_heat : float or None
        Density times heat capacity, J/(m^3 K); None where it is unknown: then there is no time.
    film : float
        h of the air with radiation, W/(m^2 K); 0 for vacuum without radiation.
    bottom : float or None
        Conductance per area from the lower face to a body at the surroundings' temperature, W/(m^2 K); infinite where
        the lower face is held at it; None for air below.

    Raises
    ------
    InputError
        For a size or constant that is not positive, or a plate that nothing cools.

    Examples
    --------
    The stator of Feenstra and Breedveld in still air:

    >>> plate = HeatedPlate(length=0.16, width=0.035, thickness=5e-3, conductivity=1.25,
    ...                     volumetric_heat=7600 * 420, film=10.0)
    >>> round(plate.resistance, 6), round(plate.time_constant, 4)
    (7.604563, 679.6654)
    """

    length: Annotated[float, Number("m")]
    width: Annotated[float, Number("m")]
    thickness: Annotated[float, Number("m")]
    conductivity: Annotated[float, Number("W/(m K)")]
    volumetric_heat: Annotated[float | None, Number("J/(m^3 K)")] = None
    film: Annotated[float, Number("W/(m^2 K)", zero=True)] = 10.0
    bottom: Annotated[float | None, Number("W/(m^2 K)", infinite=True)] = None

    def check_cooled(self) -> Iterator[tuple[str, str]]:
        """Require something that takes the heat."""
        if self.film == 0.0 and self.bottom is None:
            yield "film", "must be positive where no bottom takes heat: nothing cools the plate"

    @property
    def section(self) -> float:
        """Area of the cross-section, m^2."""
        return self.width * self.thickness

    @property
    def bottom_conductance(self) -> float:
        """From the surface where the heat arises through the plate and its bottom, per area, W/(m^2 K)."""
        if self.bottom is None:
            return 0.0
        return 1.0 / (self.thickness / self.conductivity + 1.0 / self.bottom)

    @property
    def loss_per_length(self) -> float:
        """Heat taken per length and per kelvin by all faces but the two ends, W/(m K)."""
        perimeter = self.width + 2.0 * self.thickness + (self.width if self.bottom is None else 0.0)
        return self.film * perimeter + self.bottom_conductance * self.width

    @property
    def end_loss(self) -> float:
        """Heat taken by one end per kelvin, W/K."""
        return self.film * self.section

    @property
    def conductance(self) -> float:
        """Heat taken by all faces per kelvin of a uniform temperature, W/K."""
        return self.loss_per_length * self.length + 2.0 * self.end_loss

    @property
    def resistance(self) -> float:
        """Rise of the uniform temperature per watt, K/W."""
        return 1.0 / self.conductance

    @property
    def heat_capacity(self) -> float | None:
        """Of the whole plate, J/K; None without `volumetric_heat`."""
        if self.volumetric_heat is None:
            return None
        return self.volumetric_heat * self.section * self.length

    @property
    def time_constant(self) -> float | None:
        """Of the slowest approach to the steady temperature, s; None without `volumetric_heat`.

        In air C/(h S). With a held or glued bottom the slowest mode of conduction across the thickness, whose
        wavenumber q solves q tan(q) = bottom H/k, with the losses to the air beside it.
        """
        if self.volumetric_heat is None:
            return None
        if self.bottom is None:
            return self.volumetric_heat * self.section * self.length * self.resistance
        diffusive = self.conductivity * _wavenumber(self.bottom * self.thickness / self.conductivity) ** 2
        upper = self.film * (self.width + 2.0 * self.thickness) * self.length + 2.0 * self.end_loss
        rate = diffusive / self.thickness**2 + upper / (self.section * self.length)
        return self.volumetric_heat / rate

    @property
    def biot_number(self) -> float:
        """Film times thickness over conductivity; below `MAX_BIOT_NUMBER` the section has one temperature in air."""
        return self.film * self.thickness / self.conductivity

    @property
    def decay_length(self) -> float:
        """Length over which the temperature beside a hot place falls by e, m."""
        return math.sqrt(self.conductivity * self.section / self.loss_per_length)

    def heating_rate(self, power: float) -> float | None:
        """Return the rise per second of the mean temperature at the start, K/s, for a power in W."""
        capacity = self.heat_capacity
        return None if capacity is None else power / capacity

    def steady_rise(self, power: float) -> float:
        """Return the mean rise above the surroundings in K for a power in W."""
        return power * self.resistance


def _wavenumber(biot: float) -> float:
    """Return the smallest positive root of q tan(q) = biot; pi/2 where the bottom is held."""
    if math.isinf(biot):
        return 0.5 * math.pi
    from scipy.optimize import brentq

    return float(brentq(lambda q: q * math.sin(q) - biot * math.cos(q), 0.0, 0.5 * math.pi, xtol=1e-15, rtol=1e-14))
