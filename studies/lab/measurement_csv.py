"""Reading the file of a measurement: CSV files of velocities, amplitudes, bursts and traces, and files of instruments.

The columns of the file (`csv_columns`) have the names of run.json and determine the kind of measurement:

- ``voltage_V`` or ``normal_amplitude_m``, with ``velocity_m_per_s``: velocity curve, at the slider's position,
- the same with ``lateral_velocity_m_per_s``, ``yaw_rate_rad_per_s`` or ``rotation_rpm`` instead: of a slider in the
  plane,
- the same with ``mean_velocity_m_per_s`` instead: mean over place within half a wavelength about the position,
- ``voltage_V`` with ``normal_amplitude_m``, without a velocity: calibration of the surface amplitude,
- ``time_s`` with ``velocity_m_per_s``: burst,
- ``time_s`` with ``position_m``: trace of an encoder.

``velocity_standard_deviation_m_per_s`` (or ``error_m_per_s``) and ``normal_amplitude_standard_deviation_m`` are
standard deviations.  The units ``_mm_per_s``, ``_nm`` and ``_ms`` are also accepted.  Other columns are ignored, so
that the velocity.csv of one run can be compared with another run; a remark names further velocities in the plane, since
a measurement has one quantity.  Files of vibrometers and network analysers are
recognised here and read by `scan`, `scan_uff` and `network`.
"""

from pathlib import Path

from studies.lab.analyser_csv import analyser_table
from studies.lab.column_heads import DISPLACEMENTS, ROTATIONS, TIMES, VELOCITIES, VOLTAGES, YAW_RATES
from studies.lab.csv_columns import CsvColumns
from studies.lab.input_file import file_lines
from studies.lab.measurement import Measurement
from studies.lab.network_file import read_network
from studies.lab.s_parameters import NetworkData
from studies.lab.scan import Scan, motions, scan_of_columns
from studies.lab.scan_uff import UFF_ENDINGS, scan_of_uff
from studies.lab.touchstone import TOUCHSTONE

DEVIATIONS = ("deviation", "std", "stdev", "sd", "sigma", "uncertainty", "err")  # words in heads of standard deviations


def read_measured(path: str | Path, option: str = "--measured") -> Measurement:
    """Read the file of a measurement; ``option``: the command's option that error messages name.

    Raises
    ------
    SceneError
        If the file cannot be read, lacks a column, or contains an entry that is not a number.
    """
    if TOUCHSTONE.fullmatch(Path(path).suffix):
        return measured_network(read_network(Path(path), option))
    if Path(path).suffix.lower() in UFF_ENDINGS:
        return measured_scan(scan_of_uff(Path(path), option), option)
    if analyser_table(file_lines(Path(path), option)) is not None:
        return measured_network(read_network(Path(path), option))
    table = CsvColumns.read(path, option)
    if motions(table.names):
        return measured_scan(scan_of_columns(table), option)
    position = table.column("position", DISPLACEMENTS | {"mm": 1e-3})
    voltage, amplitude = table.values("voltage", VOLTAGES), table.values("normal_amplitude", DISPLACEMENTS)
    velocity, time = table.values("velocity", VELOCITIES), table.values("time", TIMES)
    mean_velocity = table.values("mean_velocity", VELOCITIES)
    lateral, yaw = table.values("lateral_velocity", VELOCITIES), table.values("yaw_rate", YAW_RATES)
    rotation = table.values("rotation", ROTATIONS)
    level_key = "voltage_V" if voltage is not None else "normal_amplitude_m" if amplitude is not None else ""
    levels = voltage or amplitude or ()
    for noun, units in (("voltage", VOLTAGES), ("normal_amplitude", DISPLACEMENTS)):
        table.refuse_signs(noun, units, zero=True)
    if time is not None:
        table.refuse_falling("time", time, "s")
        table.refuse_if(time[-1] <= 0.0, f"must hold times after 0, got {time[-1]:g} s as the last one")
    if velocity is not None and time is not None:
        quantity, values = "burst", velocity
        if len(set(levels)) > 1:
            other = next(k for k, level in enumerate(levels) if level != levels[0])
            got = f"{levels[0]:g} and in line {table.lines[other]} {levels[other]:g} {level_key[-1]}"
            raise table.error(f"must hold one burst: one level, got {got}")
        levels = levels[:1]
    elif position is not None and time is not None:
        quantity, values, levels = "position", tuple(position[0]), levels[:1]
    elif velocity is not None and level_key:
        quantity, values = "velocity", velocity
    elif mean_velocity is not None and level_key:
        quantity, values = "mean velocity", mean_velocity
    elif lateral is not None and level_key:
        quantity, values = "lateral velocity", lateral
    elif yaw is not None and level_key:
        quantity, values = "yaw rate", yaw
    elif rotation is not None and level_key:
        quantity, values = "yaw rate", rotation
    elif voltage is not None and amplitude is not None:
        quantity, values = "amplitude", amplitude
    else:
        wanted = "voltage_V or normal_amplitude_m with velocity_m_per_s, mean_velocity_m_per_s, "
        wanted += "lateral_velocity_m_per_s, yaw_rate_rad_per_s or rotation_rpm, voltage_V with normal_amplitude_m, "
        wanted += "time_s with velocity_m_per_s or position_m, or x_m with u_z_real_m_per_V and u_z_imag_m_per_V"
        plain = any(sign in name for name in table.names for sign in "[( ")
        hint = ": a head is a name and its unit, such as x_mm, u_z_real_pm or Velocity [mm/s]" if plain else ""
        raise table.lacking(wanted, hint)
    nouns = {
        "amplitude": (("normal_amplitude_standard_deviation",), DISPLACEMENTS),
        "position": (("position_standard_deviation",), DISPLACEMENTS),
        "yaw rate": (("yaw_rate_standard_deviation",), YAW_RATES),
    }
    if quantity == "yaw rate" and yaw is None:
        nouns["yaw rate"] = ("rotation_standard_deviation",), ROTATIONS
    named, units = nouns.get(quantity, (("error", "velocity_standard_deviation"), VELOCITIES))
    deviations = table.deviation(named, units)
    remarks = (*table.remarks, *_left_out(table, quantity))
    if deviations is None:
        remarks = (*remarks, *_no_deviation(table, f"{named[-1]}_{next(iter(units))}"))
    return Measurement(
        name=Path(path).name, quantity=quantity, level_key=level_key, levels=tuple(levels), time=time or (),
        values=values, deviations=deviations, remarks=remarks,
    )  # fmt: skip


def _left_out(table: CsvColumns, quantity: str) -> tuple[str, ...]:
    """Return the remark on the columns of further velocities in the plane beside the one that is read."""
    nouns = {"lateral_velocity": VELOCITIES, "yaw_rate": YAW_RATES}
    nouns |= {} if quantity == "yaw rate" else {"rotation": ROTATIONS}
    further = [
        f"{noun}_{unit}" for noun, units in nouns.items() for unit in units
        if f"{noun}_{unit}" in table.names and noun != quantity.replace(" ", "_")
    ]  # fmt: skip
    if not further:
        return ()
    return (f"{', '.join(further)} left out: the {quantity} is read; give each other quantity a file of its own",)


def _no_deviation(table: CsvColumns, name: str) -> tuple[str, ...]:
    """Return the remark on columns that look like standard deviations, of a file without the column ``name``."""
    heads = [head for head in table.names if any(word in head.lower().split("_") for word in DEVIATIONS)]
    return (f"{', '.join(heads)} not read: standard deviations are those of the column {name}",) if heads else ()


def measured_network(data: NetworkData) -> Measurement:
    """Return a network analyser's data as a measurement."""
    return Measurement(name=data.name, quantity="network", values=tuple(data.flat()), network=data)


def measured_scan(scan: Scan, option: str = "--measured") -> Measurement:
    """Return a vibrometer's scan as a measurement: per volt, and of displacements if the file states frequencies.

    Velocities and accelerations without a frequency are those at the drive's, which `studies.solve.scan_prediction`
    knows.
    """
    scan = scan.per_volt_of_source(option).without_rest(option)
    if scan.frequency is not None:
        scan = scan.as_displacement(0.0)
    count = 2 if scan.is_complex else 1
    deviations = None if scan.deviation is None else tuple(scan.deviation) * count
    return Measurement(name=scan.name, quantity="scan", values=tuple(scan.flat()), deviations=deviations, scan=scan)
