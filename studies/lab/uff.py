"""Universal File Format: nodes (datasets 15, 781, 2411), units (164) and functions (58, text or binary) of a file.

Read and written here, because pyuff 2.5.8 (github.com/ladisk/pyuff) raises a plain `Exception` without a place for any
damage, reads text in fixed columns only and no D exponents, writes abscissas of text in six digits, loses all but seven
bytes of a binary dataset that is written with ``overwrite``, and writes complex rotations of dataset 55 that it cannot
read back.  `tests/studies/test_uff.py` shows each of these, and takes pyuff as an independent reader and writer.

Numbers of text may stand in any columns, with exponents E or D, with decimal points or commas.

Sources: Universal dataset numbers 15, 58, 58b, 164 and 2411, University of Cincinnati, Structural Dynamics Research
Laboratory, ceas3.uc.edu/sdrluff.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from studies.lab.input_file import InputFile
from studies.lab.uff_function import FUNCTION, Function, function
from studies.lab.uff_lines import UffLines, body, is_delimiter, numbers
from studies.refusal import shown

NODES, UNITS = (15, 781, 2411), 164
# Units of length by code of dataset 164, per m; 9 is the user's own
PER_METRE = {1: 1.0, 2: 3.280839895, 3: 1.0, 4: 3.280839895, 5: 1e3, 6: 1e2, 7: 39.37007874, 8: 1e3}


@dataclass(frozen=True, kw_only=True)
class UniversalFile(InputFile):
    """What a Universal File contains that a scan needs."""

    path: Path
    option: str
    kinds: tuple[int, ...]  # of all datasets
    functions: tuple[Function, ...]
    nodes: dict[int, tuple[float, float, float]]  # coordinates by label, in the file's unit of length
    metres: float | None  # the file's unit of length; None without dataset 164


def read_uff(path: Path, option: str) -> UniversalFile:
    """Read a Universal File; datasets of other kinds are passed over.

    Raises
    ------
    SceneError
        If the file cannot be read, is cut off, or a number in it cannot be read; the sentence names the line.
    """
    reading = UffLines(path, option)
    kinds: list[int] = []
    functions: list[Function] = []
    nodes: dict[int, tuple[float, float, float]] = {}
    metres: float | None = None
    while (text := reading.line()) is not None:
        if not text.strip():
            continue
        InputFile(path, option).refuse_if(
            not is_delimiter(text), f"is no Universal File: line {reading.number} must hold -1, got {shown(text)}"
        )
        first, head = reading.number, reading.line()
        if head is None:
            break
        matched = re.fullmatch(r"\s*(\d+)(b?)(.*)", head, re.IGNORECASE)
        if matched is None:
            raise reading.error(f"must hold the number of a dataset, got {shown(head)}")
        kind = int(matched[1])
        kinds.append(kind)
        if kind == FUNCTION:
            functions.append(function(reading, first, matched[3] if matched[2] else None))
            continue
        lines = body(reading, first, kind)
        if kind in NODES:
            nodes |= _nodes(reading, lines, kind)
        elif kind == UNITS:
            own = _metres(reading, lines)
            reading.refuse_if(
                metres is not None and own != metres,
                "a second dataset 164 states other units than the first",
                lines[0][0],
            )
            metres = own
    return UniversalFile(
        path=path, option=option, kinds=tuple(kinds), functions=tuple(functions), nodes=nodes, metres=metres
    )


def _nodes(reading: UffLines, lines: list[tuple[int, str]], kind: int) -> dict[int, tuple[float, float, float]]:
    values = numbers(reading, lines)
    rule = f"the nodes of dataset {kind} must hold 4 whole numbers and 3 coordinates each, got {len(values)} numbers"
    reading.refuse_if(len(values) % 7, f"{rule} in all", lines[0][0] if lines else None)
    rows = np.reshape(values, (-1, 7))
    reading.refuse_if(
        len(set(rows[:, 1].tolist())) > 1,
        "the nodes must lie in one coordinate system, got several",
        lines[0][0] if lines else None,
    )
    return {int(row[0]): (float(row[4]), float(row[5]), float(row[6])) for row in rows}


def _metres(reading: UffLines, lines: list[tuple[int, str]]) -> float:
    """Return the unit of length in m of a dataset 164: the inverse of its factor, which must fit its code."""
    head = lines[0][1].split() if lines else []
    factors = numbers(reading, lines[1:])
    reading.refuse_if(
        not head or not head[0].isdigit() or not factors or factors[0] <= 0.0,
        "dataset 164 must hold a units code and positive factors",
        lines[0][0] if lines else None,
    )
    code, factor = int(head[0]), factors[0]
    if code in PER_METRE and abs(factor / PER_METRE[code] - 1.0) > 1e-3:
        rule = f"dataset 164 contradicts itself: units code {code} has {PER_METRE[code]:g} units of length to a metre"
        raise reading.error(f"{rule}, and the factor is {factor:g}", lines[0][0])
    return 1.0 / factor
