"""A measurement of a motor: measured values, and the levels, times, positions or frequencies that they belong to."""

from dataclasses import dataclass, field, replace
from typing import Any

from studies.lab.s_parameters import NetworkData
from studies.lab.scan import Scan

FIELD = ("scan", "network")  # quantities of the stator alone


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """Measured or planned values of one quantity, as arrays of one length in SI units."""

    name: str  # of the file, or a description
    quantity: (
        # "lateral velocity" and "yaw rate" are of a slider in the plane
        str  # "velocity", "mean velocity", "burst", "position", "amplitude", "ring-down frequency", "scan" or "network"
    )
    level_key: str = ""  # "voltage_V" or "normal_amplitude_m"; empty if the level is that of the scene
    levels: tuple[float, ...] = ()  # drive voltages in V, or normal amplitudes in m
    time: tuple[float, ...] = ()  # s from the start of a burst; empty for other quantities
    values: tuple[float, ...] = ()  # empty for a measurement that is only planned
    deviations: tuple[float, ...] | Any = None  # standard deviations; None if they are unknown
    systematic: float = 0.0  # relative standard deviation of a factor common to all values
    remarks: tuple[str, ...] = ()  # on the reading of the file, for the user; a scan or a network has its own
    settings: dict = field(default_factory=dict)  # keys of the scene, and their values for this measurement alone
    # of a vibrometer or a network analyser; the values are then its real parts, followed by the imaginary ones
    scan: Scan | None = field(default=None, repr=False)
    network: NetworkData | None = field(default=None, repr=False)

    @property
    def coordinate(self) -> "tuple[float, ...]":
        """Abscissa of each value: time in s or level; position in m of a scan, frequency in Hz of a network."""
        data = self.scan if self.scan is not None else self.network
        if data is None:
            return self.time or self.levels
        return tuple(data.coordinate) * (len(self.values) // len(data.coordinate))

    def scattered(self, factor: float) -> "Measurement":
        """Return the measurement with its standard deviations multiplied by a factor."""
        return replace(self, deviations=tuple(factor * each for each in self.deviations))
