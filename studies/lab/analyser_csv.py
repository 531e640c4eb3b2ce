"""Tables of impedance and network analysers: frequency with |Z| and phase, R and X, G and B, or the reflection S11.

Files are text with columns between tabs, semicolons, commas or blanks, decimal points or commas, and other lines before
the heads.  A head is a quantity with its unit: ``Frequency (kHz)``, ``|Z| [Ohm]``, ``Phase (deg)``, ``f/MHz``,
``S11 (dB)``, ``Re(Z)``; the units may also stand in a line of their own below.  Other columns are passed over.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from studies.lab.analyser_heads import UNITS, Head, head_of, unit_of
from studies.lab.column_heads import PHASES
from studies.lab.csv_columns import above_zero, finite_number, no_number, other_number
from studies.lab.csv_layout import DECIMAL_COMMA, SEPARATORS, cells_of
from studies.lab.input_file import InputFile, file_lines
from studies.lab.s_parameters import NetworkData, gains
from studies.lab.waves import scattering

COMMENTS = ("#", "!", "%", "//", ";")
REFERENCE = re.compile(r"\bz0\b\D{0,12}?(\d+(?:\.\d+)?)", re.IGNORECASE)
DECIBEL = "dB"
DEGREE = "deg"  # taken where a phase has no unit
RADIANS = 1.6  # phases of a table without their unit that stay below may be radians


@dataclass(frozen=True, kw_only=True)
class AnalyserTable:
    """The table of a file, as text."""

    heads: tuple[Head | None, ...]
    rows: list[tuple[int, list[str]]]  # number of the line in the file, and cells
    separator: str
    texts: str  # of the lines before


def network_of_text(path: Path, option: str) -> NetworkData:
    """Return the reflection that the table of an analyser holds.

    Raises
    ------
    SceneError
        If the file cannot be read or holds no such table, a unit is missing, or a cell is no number.
    """
    table = analyser_table(file_lines(path, option))
    if table is None:
        rule = "is neither a Touchstone file nor a table with a frequency and |Z| with its phase, R and X, or S11"
        raise InputFile(path, option).error(rule)
    reading = _Reading(table, path, option)
    remarks: list[str] = []
    frequency = reading.column("frequency", "", remarks)
    if frequency is None:
        raise reading.error("must have one column of frequencies")
    kind, values = reading.parameters(remarks)
    order = np.argsort(frequency, kind="stable")
    reading.refuse_if(
        np.any(np.diff(frequency[order]) <= 0.0)
        or (np.any(np.diff(frequency) <= 0.0) and not np.all(np.diff(frequency) < 0.0)),
        "must have frequencies that rise or fall from line to line",
    )
    if frequency[0] > frequency[-1]:
        remarks.append("its frequencies fall: they are reversed")
    at, values = frequency[order], values[order]
    if at[0] <= 0.0:
        kept = above_zero(at, reading.error)
        at, values = at[kept], values[kept]
        remarks.append("the point at 0 Hz is left out")
    stated = REFERENCE.search(table.texts)
    reference = float(stated[1]) if stated else 50.0
    if kind == "s":
        remarks.append(f"S11 with a reference of {reference:g} ohm" + ("" if stated else ", which it does not state"))
    whole = values[:, None, None]
    data = NetworkData(
        name=path.name, frequency=at, reference=reference,
        scattering=scattering(kind, whole, reference, np.full((len(at), 1), reference)), remarks=tuple(remarks),
    )  # fmt: skip
    return NetworkData(**{**vars(data), "remarks": (*data.remarks, *gains(data))})


def analyser_table(lines: list[str]) -> AnalyserTable | None:
    """Return the first table of lines with a frequency and a network quantity among its heads; None without one."""
    for number, line in enumerate(lines):
        if "f" not in line.lower():  # as every word for a frequency has: lines of numbers are passed over quickly
            continue
        text = line.strip()
        for sign in COMMENTS:
            text = text.removeprefix(sign).strip()
        for separator in SEPARATORS:
            heads = [head_of(cell) for cell in cells_of(text, separator)]
            if sum(each is not None for each in heads) >= 2 and any(
                each and each.kind == "frequency" for each in heads
            ):
                rows, heads = _rows(lines, number + 1, separator, heads)
                return AnalyserTable(
                    heads=tuple(heads), rows=rows, separator=separator, texts="\n".join(lines[:number])
                )
    return None


def _rows(lines: list[str], start: int, separator: str, heads: list) -> tuple[list[tuple[int, list[str]]], list]:
    """Return the rows below the heads, up to a line END, and the heads with the units of a line of units."""
    rows: list[tuple[int, list[str]]] = []
    for number, line in enumerate(lines[start:], start + 1):
        text = line.strip()
        if not text or text.startswith(COMMENTS[:-1]):
            continue
        if text.upper().startswith("END"):
            break
        cells = cells_of(line if separator == "\t" else text, separator)
        if not rows and len(cells) == len(heads) and all(not cell or unit_of(cell) for cell in cells):
            heads = [
                Head(**{**vars(head), "unit": unit_of(cell) or head.unit}) if head else None
                for head, cell in zip(heads, cells, strict=True)
            ]
            continue
        rows.append((number, cells))
    return rows, heads


class _Reading(InputFile):
    """The numbers of a table, with refusals that name its lines and heads."""

    def __init__(self, table: AnalyserTable, path: Path, option: str):
        super().__init__(path, option)
        self.table = table
        self.refuse_if(not table.rows, "must hold at least one line of numbers below its heads")
        cells = [cell for _, row in table.rows for cell in row]
        self.decimal_comma = table.separator != "," and any("," in cell for cell in cells)
        self.refuse_if(
            self.decimal_comma and any("." in cell and "," in cell for cell in cells),
            "mixes decimal points and commas in one number",
        )
        if table.separator == ",":
            self.decimal_comma = any(DECIMAL_COMMA.fullmatch(cell.strip()) for cell in cells)

    def column(self, kind: str, part: str, remarks: list[str]) -> np.ndarray | None:
        """Return the column of a part of a kind in SI units, or None if there is none."""
        matches = [k for k, each in enumerate(self.table.heads) if each and (each.kind, each.part) == (kind, part)]
        if not matches:
            return None
        names = ", ".join(repr(self.table.heads[k].text) for k in matches)  # type: ignore[union-attr]
        self.refuse_if(len(matches) > 1, f"must hold one column of each quantity, got {names}")
        head = self.table.heads[matches[0]]
        assert head is not None
        values = head.sign * np.array([self._number(row, matches[0], head) for row in self.table.rows])
        if part == "phase":
            self.refuse_if(not head.unit and np.max(np.abs(values)) < RADIANS, _without_unit(head.text, DEGREE))
            remarks += [] if head.unit else [f"{head.text!r} has no unit: taken in degrees"]
            return values * PHASES[head.unit or DEGREE]
        self.refuse_if(kind == "frequency" and not head.unit, _without_unit(head.text, "Hz"))
        if kind == "s":
            self.refuse_if(
                part == "magnitude" and not head.unit and np.min(values) < 0.0, _without_unit(head.text, DECIBEL)
            )
            return 10.0 ** (values / 20.0) if head.unit == "dB" else values
        if not head.unit:
            remarks.append(f"{head.text!r} has no unit: taken in {'ohm' if kind == 'z' else 'S'}")
        return values * (UNITS[kind][head.unit] if head.unit else 1.0)

    def parameters(self, remarks: list[str]) -> tuple[str, np.ndarray]:
        """Return the kind of parameter, "z", "y" or "s", and its complex values."""
        held = {(each.kind, each.part) for each in self.table.heads if each}
        for kind in "zys":
            if {(kind, "real"), (kind, "imag")} <= held:
                real, imag = (self.column(kind, part, remarks) for part in ("real", "imag"))
                assert real is not None
                assert imag is not None
                return kind, real + 1j * imag
            phase = next((each for each in ((kind, "phase"), ("", "phase")) if each in held), None)
            if (kind, "magnitude") in held and phase is not None:
                size, angle = self.column(kind, "magnitude", remarks), self.column(*phase, remarks)
                assert size is not None
                assert angle is not None
                self.refuse_if(np.min(size) < 0.0, "must have magnitudes that are zero or positive")
                return kind, size * np.exp(1j * angle)
        names = ", ".join(repr(each.text) for each in self.table.heads if each)
        raise self.error(f"must have |Z| with its phase, R with X, G with B, or S11 with its phase, got {names}")

    def _number(self, row: tuple[int, list[str]], at: int, head: Head) -> float:
        number, cells = row
        if len(cells) < len(self.table.heads) or len(cells) > len(self.table.heads) + 1:
            rule = f"line {number}, {other_number(len(self.table.heads), len(cells))}"
            hint = ": decimal commas need tabs or semicolons between the columns" if self.table.separator == "," else ""
            raise self.error(rule + hint)
        text = cells[at].replace(",", ".") if self.decimal_comma else cells[at]
        value = finite_number(text)
        if value is None:
            raise self.error(f"line {number}, {head.text} {no_number(cells[at])}")
        return value


def _without_unit(head: str, unit: str) -> str:
    """Return the rule of a head that lacks its unit."""
    return f"must state the unit of {head!r}, such as {head} ({unit})"
