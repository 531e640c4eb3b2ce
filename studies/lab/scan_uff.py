"""Vibrometer scans as Universal File Format (UFF): dataset 58, ASCII or binary, real or complex.

The abscissa is the position along x, or the frequency at one position, which the fourth identification line contains as
``x = 0.08 m, y = 0 m``.
"""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from studies.lab.csv_columns import DISPLACEMENTS, FREQUENCIES, POSITIONS, VELOCITIES, file_error
from studies.lab.scan import COMPONENTS, Scan
from studies.refusal import SceneError, needed

UFF_ENDINGS = (".uff", ".unv", ".uf58")
FREQUENCY, GENERAL, DISPLACEMENT, VELOCITY = 18, 1, 8, 11  # data types of dataset 58
POSITION, VOLTAGE = re.compile(r"x = (\S+) m, y = (\S+) m"), re.compile(r"voltage = (\S+) V")


def scan_uff(scan: Scan, path: Path, remarks: tuple[str, ...] = ()) -> None:
    """Write a scan into a UFF file, with one dataset 58 (ASCII) per line of positions or for all frequencies."""
    by_frequency, file = scan.kind == "frequency", needed("pyuff", "a UFF file").UFF(str(path))
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
        raise file_error(path, option, "must be a scan over positions or over frequencies, got both")
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
    abscissa = {FREQUENCY: FREQUENCIES, GENERAL: POSITIONS, DISPLACEMENT: POSITIONS}.get(kind, {})
    if length not in abscissa:
        expected = "frequencies (data type 18, Hz) or positions (1 or 8, m or mm)"
        raise file_error(path, option, f"must have {expected} as abscissa, got type {kind} in {length or 'no unit'}")
    points, values = np.array(dataset["x"], float) * abscissa[length], np.array(dataset["data"]) * base[unit]
    start, volts = POSITION.search(str(dataset["id4"])), VOLTAGE.search(str(dataset["id5"]))
    x, y = map(float, start.groups()) if start else (np.nan, 0.0)
    direction = abs(int(dataset["rsp_dir"])) or 3  # 1, 2, 3: along x, y, z of either sign; 0: not stated
    if direction > len(COMPONENTS):
        raise file_error(path, option, f"must hold motions along x, y or z (directions 1 to 3), got {direction}")
    by_frequency = kind == FREQUENCY
    return Scan(
        name=path.name, component=COMPONENTS[direction - 1], values=values,
        x=np.full(len(points), x) if by_frequency else points, y=np.full(len(points), y),
        frequency=points if by_frequency else None, per_volt=dataset["orddenom_axis_units_lab"].strip() == "V",
        voltage=float(volts[1]) if volts else None, is_velocity=is_velocity,
    )  # fmt: skip
