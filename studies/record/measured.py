"""Measurements: reading the CSV file of a measurement, and comparing it with the prediction of a run.

The columns of the file have the names of run.json and determine the kind of measurement:

- ``voltage_V`` or ``normal_amplitude_m``, with ``velocity_m_per_s``: velocity curve,
- ``voltage_V`` with ``normal_amplitude_m``, without a velocity: calibration of the surface amplitude,
- ``time_s`` with ``velocity_m_per_s``: burst,
- ``time_s`` with ``position_m``: trace of an encoder.

``velocity_standard_deviation_m_per_s`` (or ``error_m_per_s``) and ``normal_amplitude_standard_deviation_m`` are
standard deviations.  The units ``_mm_per_s``, ``_nm`` and ``_ms`` are also accepted.  Other columns are ignored, so
that the velocity.csv of one run can be compared with another run.  Files of vibrometers and network analysers are
recognised here and read by `studies.lab.scan` and `studies.lab.network`.
"""

import csv
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from studies.lab.heads import DISPLACEMENTS, TIMES, Heads
from studies.lab.network import TOUCHSTONE, NetworkData, read_network
from studies.lab.scan import UFF_ENDINGS, Scan, is_scan, scan_of_columns, scan_of_uff
from studies.record.quantities import quantity
from studies.refusal import SceneError

if TYPE_CHECKING:
    from studies.scene import Scene

VOLTAGES, LENGTHS = {"V": 1.0}, {"m": 1.0, "nm": 1e-9}  # units of a column's name, in SI units
SPEEDS = {"m_per_s": 1.0, "mm_per_s": 1e-3}
OPTION = "--measured"
FIELD = ("scan", "network")  # quantities of the stator alone
QUANTITIES = {
    "velocity": quantity("velocity_m_per_s"),
    "burst": quantity("velocity_m_per_s"),
    "amplitude": quantity("normal_amplitude_m"),
    "ring-down frequency": quantity("ring_down_frequency_Hz"),
    "position": quantity("travelled_m"),
    "scan": quantity("surface_motion_m_per_V"),
    "network": quantity("scattering"),
}  # that are measured


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """Measured or planned values of one quantity, as arrays of one length in SI units.

    Attributes
    ----------
    name : str
        Name of the file, or a description.
    quantity : str
        A key of ``QUANTITIES``.
    level_key : str
        ``voltage_V`` or ``normal_amplitude_m``; empty if the level is that of the scene.
    levels : tuple of float
        Drive voltages in V, or normal amplitudes in m.
    time : tuple of float
        Time in s from the start of a burst; empty if the measurement is no burst.
    values : tuple of float
        Measured values; empty for a measurement that is only planned.
    deviations : tuple of float or None
        Standard deviations; None if they are unknown.
    systematic : float
        Relative standard deviation of a factor common to all values of the measurement.
    settings : dict
        Keys of the scene, and their values for this measurement alone.
    """

    name: str
    quantity: str
    level_key: str = ""
    levels: tuple[float, ...] = ()
    time: tuple[float, ...] = ()
    values: tuple[float, ...] = ()
    deviations: tuple[float, ...] | Any = None
    systematic: float = 0.0
    settings: dict = field(default_factory=dict)
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


@dataclass(frozen=True, kw_only=True)
class MeasuredTable(Heads):
    """Columns of a CSV file of a measurement; columns that are not requested may have any unit."""

    @classmethod
    def read(cls, path: str | Path, option: str) -> "MeasuredTable":
        """Read a CSV file; lines that begin with # are ignored."""
        path = Path(path)
        try:
            text = path.read_text(encoding="utf-8-sig")
        except OSError as error:
            raise SceneError(option, f"{str(path)!r} cannot be read: {error.strerror}") from None
        except UnicodeDecodeError:
            raise SceneError(option, f"{str(path)!r} is no CSV file in UTF-8") from None
        lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
        separator = next((sign for sign in ",;\t" if lines and sign in lines[0]), ",")
        rows = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=separator)]
        if len(rows) < 2:
            raise SceneError(option, f"{str(path)!r} must hold a line of names and at least one point")
        return cls(path=path, option=option, names=rows[0], rows=rows[1:])

    def known(self, noun: str, units: dict[str, float]) -> tuple[float, ...] | None:
        """Return the column ``noun_unit`` in SI units, or None if the file has none."""
        for unit, factor in units.items():
            if f"{noun}_{unit}" in self.names:
                at = self.names.index(f"{noun}_{unit}")
                return tuple(self._number(row, at) * factor for row in range(len(self.rows)))
        return None

    def deviation(self, nouns: tuple[str, ...], units: dict[str, float]) -> tuple[float, ...] | None:
        """Return the first of the columns ``nouns`` that exists, in SI units, or None; it must be positive."""
        bare = next(
            (name for name in ("error", "velocity_error", "sigma", "uncertainty") if name in self.names), None
        )
        if bare is not None:
            rule = f"the column {bare} has no unit; name it " + " or ".join(
                f"{nouns[0]}_{unit}" for unit in units
            )
            raise SceneError(self.option, f"{str(self.path)!r}: {rule}")
        noun = next((noun for noun in nouns for unit in units if f"{noun}_{unit}" in self.names), None)
        if noun is None:
            return None
        values = self.known(noun, units) or ()
        if min(values) <= 0:
            rule = f"{str(self.path)!r}: {noun}_{next(iter(units))} must be positive, got {min(values)!r}"
            raise SceneError(self.option, rule)
        return values


def read_measured(path: str | Path, option: str = OPTION) -> Measurement:
    """Read the file of a measurement; ``option``: the command's option that error messages name.

    Raises
    ------
    SceneError
        If the file cannot be read, lacks a column, or contains an entry that is not a number.
    """
    if TOUCHSTONE.fullmatch(Path(path).suffix):
        data = read_network(Path(path), option)
        return Measurement(name=data.name, quantity="network", values=tuple(data.flat()), network=data)
    if Path(path).suffix.lower() in UFF_ENDINGS:
        if not Path(path).is_file():
            raise SceneError(option, f"{str(path)!r} cannot be read: no such file")
        return measured_scan(scan_of_uff(Path(path), option))
    table = MeasuredTable.read(path, option)
    if is_scan(table.path, table.names):
        return measured_scan(scan_of_columns(table))
    position = table.column("position", DISPLACEMENTS | {"mm": 1e-3})
    voltage, amplitude = table.known("voltage", VOLTAGES), table.known("normal_amplitude", LENGTHS)
    velocity, time = table.known("velocity", SPEEDS), table.known("time", TIMES)
    level_key = "voltage_V" if voltage is not None else "normal_amplitude_m" if amplitude is not None else ""
    levels = voltage or amplitude or ()
    if min(levels, default=0.0) < 0.0:
        raise SceneError(option, f"{str(path)!r}: voltages and amplitudes must be zero or positive")
    if time is not None and (
        list(time) != sorted(set(time)) or time[-1] <= 0.0
    ):  # before 0: ahead of the trigger
        raise SceneError(option, f"{str(path)!r}: time must rise from point to point, to a time after 0")
    if velocity is not None and time is not None:
        quantity, values = "burst", velocity
        if len(set(levels)) > 1:
            raise SceneError(option, f"{str(path)!r} must hold one burst: one level, got {len(set(levels))}")
        levels = levels[:1]
    elif position is not None and time is not None:
        quantity, values, levels = "position", tuple(position[0]), levels[:1]
    elif velocity is not None and level_key:
        quantity, values = "velocity", velocity
    elif voltage is not None and amplitude is not None:
        quantity, values = "amplitude", amplitude
    else:
        wanted = "voltage_V or normal_amplitude_m with velocity_m_per_s, voltage_V with normal_amplitude_m, "
        wanted += (
            "time_s with velocity_m_per_s or position_m, or x_m with u_z_real_m_per_V and u_z_imag_m_per_V"
        )
        bracketed = any(sign in name for name in table.names for sign in "[( ")
        hint = ": a head is a name and its unit, such as x_mm or u_z_real_pm" if bracketed else ""
        raise SceneError(
            option, f"{str(path)!r} must have the columns {wanted}; got {', '.join(table.names)}{hint}"
        )
    if quantity == "amplitude":
        deviations = table.deviation(("normal_amplitude_standard_deviation",), LENGTHS)
    elif quantity == "position":
        deviations = table.deviation(("position_standard_deviation",), LENGTHS)
    else:
        deviations = table.deviation(("error", "velocity_standard_deviation"), SPEEDS)
    return Measurement(
        name=Path(path).name, quantity=quantity, level_key=level_key, levels=tuple(levels), time=time or (),
        values=values, deviations=deviations,
    )  # fmt: skip


def measured_scan(scan: Scan) -> Measurement:
    """Return a vibrometer's scan as a measurement: per volt and as displacement if its file allows it."""
    if not scan.is_velocity:
        scan = scan.at_volts(None)
    elif scan.frequency is not None:
        scan = scan.at_volts(None).as_displacement(0.0)
    count = 2 if scan.is_complex else 1
    deviations = None if scan.deviation is None else tuple(scan.deviation) * count
    return Measurement(
        name=scan.name, quantity="scan", values=tuple(scan.flat()), deviations=deviations, scan=scan
    )


def refuse_incomparable(scene: "Scene", measured: Measurement) -> None:
    """Raise a SceneError if a run of the scene does not predict the measured quantity."""
    if measured.quantity == "scan":
        if scene.stator is None or not scene.transducer:
            raise SceneError(OPTION, f"{measured.name!r} is a scan: it needs a scene with a driven stator")
        return
    if measured.quantity == "network":
        raise SceneError(
            OPTION, f"{measured.name!r} is a network analyser's: sawmotor study network draws it"
        )
    if scene.slider is None:
        raise SceneError(OPTION, "needs a scene with a [slider]: there is no velocity to compare with")
    level = "voltage_V" if scene.wave is None else "normal_amplitude_m"
    if measured.quantity in ("burst", "position"):
        if scene.burst is None:
            key = "wave.burst" if scene.wave is not None else "drive.burst"
            raise SceneError(
                OPTION, f'{measured.name!r} holds a burst: --set {key}="0.1 s" says how long it was'
            )
        return
    if measured.quantity != "velocity":
        raise SceneError(OPTION, f"must hold velocities against {level}, got a {measured.quantity}")
    if measured.level_key != level:
        raise SceneError(OPTION, f"must have the column {level} for this scene, got {measured.level_key}")


def compared(measured: Measurement, predicted: list[float | None]) -> dict:
    """Return the block ``measured`` of run.json: the measured points, their predictions and the deviations.

    Speeds that were measured without a sign get the sign of the prediction.

    Parameters
    ----------
    measured : Measurement
        Velocities.
    predicted : list of float or None
        Velocity at each level of the measurement, m/s; None where the motor has no steady velocity.

    Raises
    ------
    SceneError
        If there is no level with both a measured and a predicted velocity.
    """
    import numpy as np

    answered = np.array([each is not None for each in predicted])
    if not answered.any():
        raise SceneError(OPTION, "has nothing to be compared with: the motor has no velocity at its levels")
    expected = np.array([each or 0.0 for each in predicted])
    velocity = np.array(measured.values)
    unsigned = bool(np.all(velocity >= 0) and np.all(expected <= 0) and np.any(expected < 0))
    if unsigned:
        velocity = -velocity
    points = []
    for k, level in enumerate(measured.levels):
        point = {measured.level_key: float(level), "velocity_m_per_s": float(velocity[k]) + 0.0}
        if measured.deviations is not None:
            point["error_m_per_s"] = measured.deviations[k]
        if answered[k]:
            point["predicted_m_per_s"] = float(expected[k])
        points.append(point)
    gap = (velocity - expected)[answered]
    rms, largest = float(np.sqrt(np.mean(gap**2))), float(abs(expected).max())
    block = {
        "file": measured.name,
        "points": points,
        "compared": int(answered.sum()),
        "sign_of_prediction_given": unsigned,
        "rms_deviation_m_per_s": rms,
        "mean_deviation_m_per_s": float(gap.mean()),
    }
    if largest > 0:
        block["rms_deviation_relative"] = rms / largest
        block["measured_over_predicted"] = float(np.sum(velocity * expected) / np.sum(expected**2))
    if measured.deviations is not None:
        ratios = gap / np.array(measured.deviations)[answered]
        block["within_one_error"] = int(np.sum(abs(ratios) <= 1))
        block["chi_square_per_point"] = float(np.mean(ratios**2))
    return block
