"""Vibrometer scans as Universal File Format (UFF).

A scan is either

- functions over the position along x (dataset 58), one for each line of constant y, which the fourth line of
  identification contains as ``x = 0.08 m, y = 0 m``; or
- functions over the frequency, one for each node of a scanning vibrometer, at the nodes' coordinates (dataset 15 or
  2411); without nodes, one function at the position of the fourth line of identification, or of the slider.

Units are those of the axes' labels or, where these are NONE, of dataset 164 with seconds.  Everything else is refused.
"""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from studies.lab.column_heads import FREQUENCIES, POSITIONS, VOLTAGES
from studies.lab.scan import COMPONENTS, MOTIONS, SAME_FREQUENCY, Scan
from studies.lab.uff import UniversalFile, read_uff
from studies.lab.uff_function import Function, function_58b
from studies.refusal import refuse_if

UFF_ENDINGS = (".uff", ".unv", ".uf58", ".uf58b")
FREQUENCY, GENERAL, UNKNOWN = 18, 1, 0  # data types of dataset 58
MOTION_TYPES = {8: "displacement", 11: "velocity", 12: "acceleration"}
RESPONSE, SPECTRUM = 4, 12  # function types of amplitudes over the frequency; 0 is a general function
FUNCTION_TYPES = {
    1: "a time response", 2: "an auto spectrum", 3: "a cross spectrum", 5: "a transmissibility", 6: "a coherence",
    9: "a power spectral density", 10: "an energy spectral density",
}  # fmt: skip
POSITION, VOLTAGE = re.compile(r"x = (\S+) m, y = (\S+) m"), re.compile(r"voltage = (\S+) V")
SIX_DIGITS = 5e-6  # relative rounding of a number in the format E13.5


def scan_uff(scan: Scan, remarks: tuple[str, ...] = ()) -> bytes:
    """Return a scan as a UFF file, with one dataset 58b of doubles per line of positions or for all frequencies."""
    by_frequency = scan.kind == "frequency"
    direction = COMPONENTS.index(scan.component) + 1
    lines = [np.arange(len(scan.x))] if by_frequency else [np.flatnonzero(scan.y == y) for y in np.unique(scan.y)]
    axes = (
        (FREQUENCY, "frequency", "Hz") if by_frequency else (GENERAL, "x", "m"),
        ({motion: kind for kind, motion in MOTION_TYPES.items()}[scan.motion], scan.component, _si_unit(scan.motion)),
        (UNKNOWN, "voltage", "V") if scan.per_volt else (UNKNOWN, "NONE", "NONE"),
    )
    datasets = []
    for number, line in enumerate(lines, 1):
        refuse_if(
            len(line) < 2, "--format", "uff needs at least two points on each line along x: ask for more, or for csv"
        )
        along = scan.coordinate if by_frequency else scan.x
        order = line[np.argsort(along[line])]
        where = f"x = {float(scan.x[order[0]])!r} m, y = {float(scan.y[order[0]])!r} m"
        title = remarks[0] if remarks else ""
        voltage = "" if scan.voltage is None else f"voltage = {scan.voltage!r} V"
        datasets.append(function_58b(
            scan.values[order], along[order],
            identification=(f"{scan.motion} {scan.component}", title, "peak values, exp(+i omega t)", where, voltage),
            kind=RESPONSE if by_frequency else 0, node=number, direction=direction, axes=axes,
        ))  # fmt: skip
    return b"".join(datasets)


def _si_unit(motion: str) -> str:
    return {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}[motion]


def scan_of_uff(path: Path, option: str) -> Scan:
    """Return the scan that a UFF file contains.

    Raises
    ------
    SceneError
        If the file is damaged, contains no function or several motions, or a unit or position is not stated.
    """
    file = read_uff(path, option)
    functions, remarks = file.functions, []
    kinds = ", ".join(map(str, dict.fromkeys(file.kinds))) or "none"
    file.refuse_if(not functions, f"must hold a dataset 58, got {kinds}")
    responses = tuple(each for each in functions if each.kind == RESPONSE)
    if responses and len(responses) < len(functions):
        others = {each.kind for each in functions} - {RESPONSE}
        left_out = [FUNCTION_TYPES.get(kind, f"a function of type {kind}") for kind in sorted(others)]
        remarks.append(f"only the frequency responses of the file are taken, not {', '.join(left_out)}")
        functions = responses
    over_nodes = any(each.abscissa.kind == FREQUENCY for each in functions) and len({e.node for e in functions}) > 1
    placed_by_text = all(POSITION.search(each.identification[3]) for each in functions)
    rule = f"holds spectra of {len(functions)} nodes, and their positions are missing: dataset 15 or 2411"
    file.refuse_if(over_nodes and not file.nodes and not placed_by_text, rule)
    _refuse_tall(file, {each.node for each in functions})
    parts = [_scan_of_function(each, file) for each in functions]
    first = parts[0]
    for name, noun in (("component", "directions"), ("motion", "motions"), ("per_volt", "denominators"),
                       ("voltage", "voltages"), ("is_complex", "forms, complex and real")):  # fmt: skip
        file.refuse_if(
            any(getattr(each, name) != getattr(first, name) for each in parts),
            f"must hold one motion in one unit, got several {noun}",
        )
    file.refuse_if(
        any((each.frequency is None) != (first.frequency is None) for each in parts),
        "must be a scan over positions or over frequencies, got both",
    )
    if first.frequency is not None and file.nodes and file.metres is None:
        remarks.append("the file states no unit of length (dataset 164): coordinates of nodes are taken as m")
    if any(each.direction == 0 for each in functions):
        remarks.append("the file states no direction of the motion: it is taken as u_z")
    x, y, values = (np.concatenate([getattr(each, name) for each in parts]) for name in ("x", "y", "values"))
    file.refuse_if(
        not np.iscomplexobj(values) and np.min(values) < 0.0,
        "holds real values below 0: magnitudes, or complex values, are needed",
    )
    frequency = None if first.frequency is None else np.concatenate([each.frequency for each in parts])
    rule = "holds motions at an unknown voltage: the denominator (record 10 of dataset 58) must have the unit V"
    file.refuse_if(
        not first.per_volt and first.voltage is None, f"{rule}, or the fifth line of identification be 'voltage = 15 V'"
    )
    return replace(first, x=x, y=y, values=values, frequency=frequency, remarks=tuple(remarks))


def _refuse_tall(file: UniversalFile, measured: set[int]) -> None:
    """Refuse measured nodes that do not lie in a plane of constant z, as the surface does."""
    places = [place for label, place in file.nodes.items() if label in measured]
    if places:
        x, y, z = np.ptp(np.array(places), axis=0)
        got = f"z over {z:g} and x over {x:g}"
        file.refuse_if(z > 0.1 * max(x, y), f"must hold nodes in a plane of constant z, got {got}")


def _refuse_if(file: UniversalFile, function: Function, broken: Any, rule: str) -> None:
    file.refuse_if(broken, f"the dataset 58 {rule}", function.line)


def _scan_of_function(function: Function, file: UniversalFile) -> Scan:
    """Return a function as a scan over positions, or over frequencies at its node."""
    rule = FUNCTION_TYPES.get(function.kind, f"a function of type {function.kind}")
    _refuse_if(
        file,
        function,
        function.kind not in (0, RESPONSE, SPECTRUM),
        f"must hold a frequency response (function type 4) or a spectrum (12), got {rule}",
    )
    points, by_frequency = _abscissa(function, file)
    motion, values, per_volt = _ordinate(function, file)
    rule = f"has an abscissa of {len(points)} points with {len(np.unique(points))} values: six digits do not tell"
    _refuse_if(
        file,
        function,
        len(np.unique(points)) < len(points),
        f"{rule} them apart, write the file binary or evenly spaced",
    )
    rule = f"must hold motions along x, y or z (directions 1 to 3), got {function.direction}, a rotation"
    _refuse_if(file, function, abs(function.direction) > len(COMPONENTS), rule)
    volts = VOLTAGE.search(function.identification[4])
    x, y = _place(function, file) if by_frequency else (np.nan, _line_of(function))
    return Scan(
        name=file.path.name, component=COMPONENTS[(abs(function.direction) or 3) - 1],
        values=-values if function.direction < 0 and np.iscomplexobj(values) else values,
        x=np.full(len(points), x) if by_frequency else points, y=np.full(len(points), y),
        frequency=points if by_frequency else None, per_volt=per_volt,
        voltage=float(volts[1]) if volts else None, motion=motion,
        resolution=SIX_DIGITS if function.six_digits else SAME_FREQUENCY,
    )  # fmt: skip


def _abscissa(function: Function, file: UniversalFile) -> tuple[np.ndarray, bool]:
    """Return frequencies in Hz and True, or positions in m and False."""
    kind, unit = function.abscissa.kind, function.abscissa.unit
    by_frequency = kind == FREQUENCY or (kind == UNKNOWN and unit in FREQUENCIES)
    if by_frequency:
        units = FREQUENCIES | {"": 1.0}  # the format's unit of frequency is Hz
    elif kind in (UNKNOWN, GENERAL, 8):
        units = POSITIONS | ({} if file.metres is None else {"": file.metres})
    else:
        units = {}
    expected = "frequencies (data type 18, Hz) or positions (1 or 8, m or mm)"
    _refuse_if(
        file, function, unit not in units, f"must have {expected} as abscissa, got type {kind} in {unit or 'no unit'}"
    )
    return function.x * units[unit], by_frequency


def _ordinate(function: Function, file: UniversalFile) -> tuple[str, np.ndarray, bool]:
    """Return which motion the ordinate is, its values in SI units, and whether they are per volt."""
    kind, unit = function.ordinate.kind, _head_unit(function.ordinate.unit)
    in_ratio = unit.endswith("_per_V")
    unit = unit.removesuffix("_per_V")
    of_label = next((motion for motion, units in MOTIONS.items() if unit in units), "")
    motion = MOTION_TYPES.get(kind, of_label if kind in (UNKNOWN, GENERAL) else "")
    expected = "displacements (data type 8: m, um, nm, pm), velocities (11: m/s, mm/s, um/s) or accelerations "
    rule = f"must hold {expected}(12: m/s^2, g), got data type {kind} in {function.ordinate.unit or 'no unit'}"
    _refuse_if(file, function, not motion or (unit and motion != of_label), rule)
    _refuse_if(
        file,
        function,
        not unit and file.metres is None,
        f"states no unit of its {motion}: neither a label of the axis nor dataset 164",
    )
    factor = MOTIONS[motion][unit] if unit else float(file.metres or np.nan)
    below = function.denominator
    got = below.unit or f"data type {below.kind}"
    _refuse_if(
        file,
        function,
        below.unit not in VOLTAGES and (below.unit or below.kind != UNKNOWN),
        f"must hold motions per volt (V, mV), got {got} as denominator",
    )
    volts = VOLTAGES.get(below.unit, 1.0)
    return motion, function.values * (factor / volts), in_ratio or bool(below.unit)


def _head_unit(unit: str) -> str:
    """Return the unit of an axis as heads of CSV columns write it.

    Examples
    --------
    >>> _head_unit("mm/s"), _head_unit("(m/s²)/V"), _head_unit("µm")
    ('mm_per_s', 'm_per_s2_per_V', 'um')
    """
    plain = unit.strip().strip("[]").replace("(", "").replace(")", "").replace("µ", "u").replace("μ", "u")
    return plain.replace("^2", "2").replace("²", "2").replace("**2", "2").replace("/", "_per_").replace(" ", "")


def _place(function: Function, file: UniversalFile) -> tuple[float, float]:
    """Return x and y in m of a function over frequency: of its node, of its text, or unknown."""
    if file.nodes:
        _refuse_if(
            file,
            function,
            function.node not in file.nodes,
            f"is of node {function.node}, which no dataset 15 or 2411 of the file places",
        )
        metres = 1.0 if file.metres is None else file.metres
        return file.nodes[function.node][0] * metres, file.nodes[function.node][1] * metres
    start = POSITION.search(function.identification[3])
    return (float(start[1]), float(start[2])) if start else (np.nan, 0.0)


def _line_of(function: Function) -> float:
    start = POSITION.search(function.identification[3])
    return float(start[2]) if start else 0.0
