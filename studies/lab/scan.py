"""Vibrometer scans: the motion of the surface against position or frequency, as CSV or Universal File Format (UFF).

A CSV file has one row per point. The columns are

- the position (``x_mm``, optionally ``y_mm``) or the frequency (``frequency_MHz``);
- the motion, as ``u_z_real_nm`` and ``u_z_imag_nm``, or as ``u_z_magnitude_nm`` with an optional ``u_z_phase_rad``.
  Columns of u_x and u_y have the same form. Velocities have names such as ``v_z_real_mm_per_s``;
- optionally ``u_z_standard_deviation_nm``, the standard deviation of the real part and of the imaginary part, or of the
  magnitude;
- ``voltage_V``, unless the unit of the motion ends in ``_per_V`` (per volt of the source, peak).

Lines that begin with # are comments.

A UFF file contains dataset 58 (ASCII or binary), real or complex. The abscissa is the position along x, or the
frequency at one position, which is given in the fourth identification line as ``x = 0.08 m, y = 0 m``.

The time convention is exp(+i omega t) with peak amplitudes.
"""

import re
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from studies.lab.csv_columns import (
    DISPLACEMENTS,
    FREQUENCIES,
    PHASES,
    PLACES,
    VELOCITIES,
    VOLTAGES,
    CsvColumns,
    csv_text,
    file_error,
)
from studies.refusal import SceneError, needed

COMPONENTS = ("u_x", "u_y", "u_z")
UFF_ENDINGS = (".uff", ".unv", ".uf58")
FREQUENCY, GENERAL, DISPLACEMENT, VELOCITY = 18, 1, 8, 11  # data types of dataset 58
PLACE = re.compile(r"x = (?P<x>\S+) m, y = (?P<y>\S+) m")


@dataclass(frozen=True, kw_only=True)
class Scan:
    """Motion of the surface at several positions or frequencies. All arrays have the same length; units are SI.

    Attributes
    ----------
    name : str
        Name of the file.
    component : str
        ``u_x``, ``u_y`` or ``u_z``.
    x, y : ndarray
        Positions in m.
    frequency : ndarray or None
        Frequency of each point in Hz, or None if all points have the drive frequency.
    values : ndarray
        Complex amplitudes or real magnitudes of the displacement (m or m per V) or of the velocity (m/s or m/s per V).
    deviation : ndarray or None
        Standard deviation of the real part and of the imaginary part, or of the magnitude.
    per_volt : bool
        True if the values are per volt of the source.
    voltage : float or None
        Peak voltage of the source in V, if the values are not per volt and the file states it.
    is_velocity : bool
        True if the values are velocities, equal to i omega times the displacements.
    """

    name: str
    component: str = "u_z"
    x: np.ndarray = field(repr=False)
    y: np.ndarray = field(repr=False)
    values: np.ndarray = field(repr=False)
    frequency: np.ndarray | None = field(default=None, repr=False)
    deviation: np.ndarray | None = field(default=None, repr=False)
    per_volt: bool = True
    voltage: float | None = None
    is_velocity: bool = False

    @property
    def is_complex(self) -> bool:
        """True if the phase was measured."""
        return bool(np.iscomplexobj(self.values))

    @property
    def kind(self) -> str:
        """The varying coordinate: "frequency", "x", "y" or "x, y"."""
        if self.frequency is not None and np.ptp(self.frequency) > 0.0:
            return "frequency"
        ways = [name for name in "xy" if np.ptp(getattr(self, name)) > 0.0]
        return ", ".join(ways) or "x"

    @property
    def coordinate(self) -> np.ndarray:
        """The varying coordinate: frequency in Hz or position in m. For a scan of an area it is x."""
        if self.frequency is not None and self.kind == "frequency":
            return self.frequency
        return self.y if self.kind == "y" else self.x

    def as_displacement(self, drive_frequency: float) -> "Scan":
        """Return the scan as displacements; ``drive_frequency`` in Hz is used if the scan has no frequencies."""
        if not self.is_velocity:
            return self
        omega = 2.0 * np.pi * (drive_frequency if self.frequency is None else self.frequency)
        factor = 1.0 / (1j * omega) if self.is_complex else 1.0 / omega
        deviation = None if self.deviation is None else self.deviation / omega
        return replace(self, values=self.values * factor, deviation=deviation, is_velocity=False)

    def at_volts(self, voltage: float | None) -> "Scan":
        """Return the scan per volt of the source; the voltage of the file has priority over ``voltage`` (V)."""
        if self.per_volt:
            return self
        source_voltage = self.voltage if self.voltage is not None else voltage
        if source_voltage is None or not source_voltage > 0.0:
            raise SceneError(
                "--measured",
                f"{self.name!r} holds motions at an unknown voltage: add a column voltage_V, or units _per_V",
            )
        deviation = None if self.deviation is None else self.deviation / source_voltage
        return replace(self, values=self.values / source_voltage, deviation=deviation, per_volt=True)

    def flat(self) -> np.ndarray:
        """Return the values as a real array: real parts followed by imaginary parts, or magnitudes."""
        return np.concatenate([self.values.real, self.values.imag]) if self.is_complex else self.values


def is_scan(path: Path, names: list[str]) -> bool:
    """Return whether a file is a scan, by its suffix or by a motion among its column names."""
    if path.suffix.lower() in UFF_ENDINGS:
        return True
    return any(name.startswith(f"{kind}_{axis}_") for name in names for kind in "uv" for axis in "xyz")


def scan_of_columns(columns: CsvColumns) -> Scan:
    """Return the scan from the columns of a CSV file; raise SceneError for a missing column or a wrong unit."""
    noun = _motion_name(columns)
    is_velocity, component = noun[0] == "v", "u" + noun[1:]
    base = VELOCITIES if is_velocity else DISPLACEMENTS
    units = base | {f"{unit}_per_V": factor for unit, factor in base.items()}
    x, y, frequency = (
        columns.column("x", PLACES),
        columns.column("y", PLACES),
        columns.column("frequency", FREQUENCIES),
    )
    if x is None and y is None and frequency is None:
        raise columns.error(f"must have a column x_UNIT, y_UNIT or frequency_UNIT, got {', '.join(columns.names)}")
    values, unit = _values(columns, noun, units)
    deviation = columns.column(f"{noun}_standard_deviation", units)
    if deviation is not None and np.min(deviation[0]) <= 0.0:
        raise columns.error(
            f"must have a {noun}_standard_deviation that is positive, got {float(np.min(deviation[0])):g}"
        )
    voltage = columns.column("voltage", VOLTAGES)
    if voltage is not None and np.ptp(voltage[0]) > 0.0:
        raise columns.error("must hold one voltage_V, got several")
    zeros = np.zeros(len(columns.rows))
    # without a column, the position is that of the slider or of the middle of the stator: NaN until the scene is known
    unknown = zeros * np.nan
    return Scan(
        name=columns.path.name, component=component, x=unknown if x is None else x[0],
        y=(zeros if x is not None else unknown) if y is None else y[0],
        frequency=None if frequency is None else frequency[0], values=values,
        deviation=None if deviation is None else deviation[0], per_volt=unit.endswith("_per_V"),
        voltage=None if voltage is None else float(voltage[0][0]), is_velocity=is_velocity,
    )  # fmt: skip


def _motion_name(columns: CsvColumns) -> str:
    """Return the name of the motion among the column names, such as ``u_z``."""
    known = [f"{kind}_{axis}" for kind in "uv" for axis in "xyz"]
    motions = sorted({each for each in known for name in columns.names if name.startswith(f"{each}_")})
    if len(motions) != 1:
        raise columns.error(f"must hold one motion, such as u_z, got {', '.join(motions) or 'none'}")
    return motions[0]


def _values(columns: CsvColumns, noun: str, units) -> tuple[np.ndarray, str]:
    """Return the motion as complex amplitudes or magnitudes, and its unit."""
    real, imaginary = (columns.column(f"{noun}_{part}", units) for part in ("real", "imag"))
    magnitude, phase = columns.column(f"{noun}_magnitude", units), columns.column(f"{noun}_phase", PHASES)
    if (real is None) != (imaginary is None):
        missing = "imag" if imaginary is None else "real"
        raise columns.error(f"must have a column {noun}_{missing}_UNIT beside the other part")
    if real is not None and imaginary is not None:
        if magnitude is not None:
            raise columns.error(f"must hold {noun} once, as complex parts or as a magnitude")
        if real[1] != imaginary[1]:
            raise columns.error(f"must have one unit for {noun}, got {real[1]} and {imaginary[1]}")
        return real[0] + 1j * imaginary[0], real[1]
    if magnitude is None:
        wanted = f"{noun}_real_UNIT with {noun}_imag_UNIT, or {noun}_magnitude_UNIT"
        raise columns.error(f"must have the columns {wanted}; got {', '.join(columns.names)}")
    if np.min(magnitude[0]) < 0.0:
        raise columns.error(
            f"must have a {noun}_magnitude that is zero or positive, got {float(np.min(magnitude[0])):g}"
        )
    return (magnitude[0] if phase is None else magnitude[0] * np.exp(1j * phase[0])), magnitude[1]


def scan_csv(scan: Scan, remarks: tuple[str, ...] = ()) -> str:
    """Return a scan as CSV. `scan_of_columns` reads exactly the same numbers from it."""
    unit = "m_per_s" if scan.is_velocity else "m"
    unit += "_per_V" if scan.per_volt else ""
    noun = ("v" if scan.is_velocity else "u") + scan.component[1:]
    columns = {}
    if scan.frequency is not None:
        columns["frequency_Hz"] = scan.frequency
    columns |= {"x_m": scan.x, "y_m": scan.y}
    if scan.is_complex:
        columns |= {f"{noun}_real_{unit}": scan.values.real, f"{noun}_imag_{unit}": scan.values.imag}
    else:
        columns[f"{noun}_magnitude_{unit}"] = scan.values
    if scan.deviation is not None:
        columns[f"{noun}_standard_deviation_{unit}"] = scan.deviation
    if scan.voltage is not None:
        columns["voltage_V"] = np.full(len(scan.x), scan.voltage)
    return csv_text(columns, remarks)


def scan_uff(scan: Scan, path: Path, remarks: tuple[str, ...] = ()) -> None:
    """Write a scan into a UFF file, with one dataset 58 (ASCII) per line of positions or for all frequencies."""
    by_frequency = scan.kind == "frequency"
    file = needed("pyuff", "a UFF file").UFF(str(path))
    lines = [np.arange(len(scan.x))] if by_frequency else [np.flatnonzero(scan.y == y) for y in np.unique(scan.y)]
    for number, line in enumerate(lines, 1):
        if len(line) < 2:
            raise SceneError("--format", "uff needs at least two points on each line along x: ask for more, or for csv")
        along = scan.coordinate if by_frequency else scan.x
        order = line[np.argsort(along[line])]
        abscissa, first = along[order], order[0]
        where = f"x = {float(scan.x[first])!r} m, y = {float(scan.y[first])!r} m"
        dataset = {
            "type": 58, "func_type": 4 if by_frequency else 0, "data": scan.values[order], "x": abscissa, "binary": 0,
            "id1": f"{'velocity' if scan.is_velocity else 'displacement'} {scan.component}"[:80],
            "id2": (remarks[0] if remarks else "")[:80] or "NONE", "id3": "peak values, exp(+i omega t)", "id4": where,
            "id5": "NONE" if scan.voltage is None else f"voltage = {scan.voltage!r} V",
            "rsp_node": number, "rsp_dir": COMPONENTS.index(scan.component) + 1, "ref_node": 0, "ref_dir": 0,
            "abscissa_spacing": 0, "abscissa_spec_data_type": FREQUENCY if by_frequency else GENERAL,
            "abscissa_axis_lab": "frequency" if by_frequency else "x",
            "abscissa_axis_units_lab": "Hz" if by_frequency else "m",
            "ordinate_spec_data_type": VELOCITY if scan.is_velocity else DISPLACEMENT,
            "ordinate_axis_lab": scan.component, "ordinate_axis_units_lab": "m/s" if scan.is_velocity else "m",
            "orddenom_spec_data_type": 0, "orddenom_axis_lab": "voltage" if scan.per_volt else "NONE",
            "orddenom_axis_units_lab": "V" if scan.per_volt else "NONE",
        }  # fmt: skip
        file.write_sets(dataset, "add" if number > 1 else "overwrite")


def scan_of_uff(path: Path, option: str) -> Scan:
    """Return the scan that the datasets 58 of a UFF file contain.

    Raises
    ------
    SceneError
        If the file contains no dataset 58, several motions, or a unit that is not of a displacement or velocity.
    """
    try:
        file = needed("pyuff", "a UFF file").UFF(str(path))
        kinds = list(file.get_set_types())
        sets = [file.read_sets(k) for k, kind in enumerate(kinds) if int(kind) == 58]
    except (OSError, ValueError, IndexError, UnicodeDecodeError, AttributeError) as error:
        text = " ".join(str(error).split())
        raise file_error(path, option, f"is no Universal File Format file: {text}") from None
    if not sets:
        raise file_error(path, option, f"must hold a dataset 58, got {', '.join(map(str, kinds)) or 'none'}")
    parts = [_scan_of_dataset(each, path, option) for each in sets]
    first = parts[0]
    same = ("component", "is_velocity", "per_volt", "voltage", "is_complex")
    if any(getattr(each, name) != getattr(first, name) for each in parts for name in same):
        raise file_error(path, option, "must hold one motion in one unit, complex or real, got several")
    if any((each.frequency is None) != (first.frequency is None) for each in parts):
        raise file_error(path, option, "must be a scan over places or over frequencies, got both")
    x, y, values = (np.concatenate([getattr(each, name) for each in parts]) for name in ("x", "y", "values"))
    whole = replace(first, x=x, y=y, values=values)
    if first.frequency is None:
        return whole
    return replace(whole, frequency=np.concatenate([each.frequency for each in parts]))


def _scan_of_dataset(dataset: dict, path: Path, option: str) -> Scan:
    kind, motion = int(dataset["abscissa_spec_data_type"]), int(dataset["ordinate_spec_data_type"])
    unit, length = dataset["ordinate_axis_units_lab"].strip(), dataset["abscissa_axis_units_lab"].strip()
    is_velocity = motion == VELOCITY
    base = VELOCITIES if is_velocity else DISPLACEMENTS
    unit = unit.replace("/", "_per_")
    if motion not in (DISPLACEMENT, VELOCITY) or unit not in base:
        expected = "displacements (data type 8: m, um, nm, pm) or velocities (11: m/s, mm/s, um/s)"
        raise file_error(path, option, f"must hold {expected}, got data type {motion} in {unit or 'no unit'}")
    abscissa = {FREQUENCY: FREQUENCIES, GENERAL: PLACES, DISPLACEMENT: PLACES}.get(kind, {})
    if length not in abscissa:
        expected = "frequencies (data type 18, Hz) or places (1 or 8, m or mm)"
        raise file_error(path, option, f"must have {expected} as abscissa, got type {kind} in {length or 'no unit'}")
    points, values = (np.array(dataset["x"], float) * abscissa[length], np.array(dataset["data"]) * base[unit])
    position_match, volts = (PLACE.search(str(dataset["id4"])), re.search(r"voltage = (\S+) V", str(dataset["id5"])))
    start = (float(position_match["x"]), float(position_match["y"])) if position_match else (np.nan, 0.0)
    direction = abs(int(dataset["rsp_dir"])) or 3
    by_frequency = kind == FREQUENCY
    return Scan(
        name=path.name, component=COMPONENTS[(direction - 1) % 3], values=values,
        x=np.full(len(points), start[0]) if by_frequency else points, y=np.full(len(points), start[1]),
        frequency=points if by_frequency else None, per_volt=dataset["orddenom_axis_units_lab"].strip() == "V",
        voltage=float(volts[1]) if volts else None, is_velocity=is_velocity,
    )  # fmt: skip
