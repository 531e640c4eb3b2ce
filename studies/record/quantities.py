"""The one table of what is computed: key, unit, label, scale and meaning of each quantity (``quantities.csv``).

The columns of CSV files and tables, the axes of pictures, the goals of a design, the units of data frames and xarray
objects and the tables of ``studies/README.md`` follow from it.  ``python -m studies.record.quantities FILE`` writes the
rows of a document's tables anew, and the fields of the classes in ``point.py`` and ``blocks.py``.
"""

import csv
import re
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from studies.refusal import SceneError, nearest

# SI units of keys that the table does not hold, by the ending of a key, of which the first that fits counts
ENDINGS = {
    "_rad_per_m": "rad/m", "_rad_per_s": "rad/s", "_rad": "rad", "_N_m": "N m",
    "_m_per_N": "m/N", "_A_per_N": "A/N", "_V_per_N": "V/N",
    "_K_per_s": "K/s",
    "_W_per_V2": "W/V^2", "_A_per_V": "A/V", "_m_per_V": "m/V", "_m_per_s": "m/s", "_per_m": "1/m", "_per_s": "1/s",
    "_Hz": "Hz", "_Pa": "Pa", "_W": "W", "_S": "S", "_N": "N", "_V": "V", "_K": "K", "_kg": "kg", "_m": "m", "_s": "s",
}  # fmt: skip
FIELDS = re.compile(
    r"^    # (\w+)\.\*\n((?:    \w+: .*\n)+)", re.MULTILINE
)  # of a class whose fields are a block of keys
ROW = re.compile(r"^\| `([a-z_]+(?:\.[\w-]+)*)` \| [^|]+ \|[^|]*\|$", re.MULTILINE)  # of a table of quantities


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A number or a word of a record, a sweep or a study.

    Attributes
    ----------
    key : str
        Path in run.json, ``points.velocity_m_per_s``; of a column alone its last part.
    unit : str
        SI unit of the value, "1" for a pure number, "-" for a word.
    head : str
        Name at the head of a column of printed text.
    label : str
        Name at an axis.
    shown : str
        Unit in which it is printed and drawn.
    scale : float
        Factor from the SI unit to that one.
    format : str
        Of the printed number.
    meaning : str
        What a reader of run.json must know.
    """

    key: str
    unit: str
    head: str
    label: str
    shown: str
    scale: float
    format: str
    meaning: str

    @property
    def heading(self) -> str:
        """Head of a column with its unit.

        Examples
        --------
        >>> quantity("velocity_m_per_s").heading
        'velocity (mm/s)'
        """
        return f"{self.head} ({self.shown})" if self.shown else self.head

    @property
    def axis(self) -> str:
        """Label of an axis with its unit.

        Examples
        --------
        >>> quantity("normal_amplitude_m").axis, quantity("stick_margin").axis
        ('normal amplitude (nm)', 'stick margin')
        """
        return f"{self.label} ({self.shown})" if self.shown else self.label

    @property
    def column(self) -> str:
        """Name of its column: the last part of the key."""
        return self.key.rpartition(".")[2]

    def text(self, value: Any) -> str:
        """Return a value as it is printed, without its unit.

        Examples
        --------
        >>> quantity("velocity_m_per_s").text(-0.0123456789), quantity("admittance_S").text(0.002 - 0.01j)
        ('-12.346', '2 - 10i')
        """
        if isinstance(value, complex):
            return f"{self.text(value.real)} {'-' if value.imag < 0 else '+'} {self.text(abs(value.imag))}i"
        return f"{value * self.scale:{self.format}}" if self.format else str(value)

    def with_unit(self, value: Any) -> str:
        """Return a value with its unit.

        Examples
        --------
        >>> quantity("normal_amplitude_m").with_unit(2e-9), quantity("power_share").with_unit(0.25)
        ('2 nm', '25 %')
        """
        return f"{self.text(value)} {self.shown}".rstrip()

    def interval(self, low: float, high: float) -> str:
        """Return an interval of values with its unit.

        Examples
        --------
        >>> quantity("voltage_V").interval(5.0, 60.0)
        '5 to 60 V'
        """
        return f"{self.text(low)} to {self.with_unit(high)}"


@cache
def quantities() -> dict[str, Quantity]:
    """Return all quantities by their path."""
    with Path(__file__).with_suffix(".csv").open(encoding="utf-8", newline="") as file:
        rows = [(row.pop("scale"), row) for row in csv.DictReader(file)]
    return {row["key"]: Quantity(**row, scale=float(scale or 1.0)) for scale, row in rows}


@cache
def _by_column() -> dict[str, Quantity]:
    """Return the quantities that have a label, by the last part of their path."""
    columns: dict[str, Quantity] = {}
    for each in quantities().values():
        if each.label:
            columns.setdefault(each.column, each)
    return columns


class _Named:
    """The quantities by name: ``quantity.thrust_N``, and ``quantity(key)`` of a path or a name in a variable.

    Only a quantity that is printed or drawn has a name of its own, the last part of its path.

    Raises
    ------
    SceneError
        If the table does not hold it.

    Examples
    --------
    >>> quantity.thrust_N.axis, quantity("panel.motor_efficiency").shown
    ('blocked thrust (mN)', '1e-6')
    """

    def __call__(self, key: str) -> Quantity:
        entry = quantities().get(key) or _by_column().get(key)
        if entry is None:
            raise SceneError(key, f"is no quantity of a record{nearest(key, _by_column())}")
        return entry

    def __getattr__(self, name: str) -> Quantity:
        if name.startswith("__"):
            raise AttributeError(name)
        return self(name)


quantity = _Named()


def unit_of(key: str) -> str | None:
    """Return the SI unit of a column, from the table or the ending of its name.

    It is None for a word, and for a column that neither the table nor an ending tells.

    Examples
    --------
    >>> unit_of("velocity_m_per_s"), unit_of("my_own_depth_m"), unit_of("relative_error"), unit_of("regime")
    ('m/s', 'm', '1', None)
    """
    key = re.sub("_(re|im|0|1)$", "", key)  # parts of a complex number and of a pair have the unit of the whole
    if key in _by_column():
        unit = _by_column()[key].unit
        return None if unit == "-" else unit
    return next((unit for ending, unit in ENDINGS.items() if key.endswith(ending)), None)


def described(key: str) -> dict[str, str]:
    """Return the attributes of a column in xarray: ``units``, and ``long_name`` where it has a label.

    Examples
    --------
    >>> described("velocity_m_per_s")
    {'units': 'm/s', 'long_name': 'slider velocity'}
    """
    unit, known = unit_of(key), _by_column().get(key)
    return ({} if unit is None else {"units": unit}) | ({} if known is None else {"long_name": known.label})


def with_quantities(document: str) -> str:
    """Return a document with its rows of quantities, or the fields of its classes, written anew.

    A row of an unknown key stays; of a block that has a row, each missing one is added after that of the key before;
    a field that exists keeps its type.
    """

    def row(match: re.Match) -> str:
        each = quantities().get(match[1])
        return match[0] if each is None else _row(each)

    def fields(match: re.Match) -> str:
        known = {line.split(":")[0].strip(): line for line in match[2].splitlines(keepends=True)}
        lines = {}
        for each in quantities().values():
            block, name, *_ = each.key.split(".") if "." in each.key else ("", each.key)
            if block == match[1]:
                lines[name] = known.get(name, f"    {name}: {'Text' if each.unit == '-' else 'Number'} = None\n")
        return f"    # {match[1]}.*\n{''.join(lines.values())}"

    return FIELDS.sub(fields, _with_missing_rows(ROW.sub(row, document)))


def _row(each: Quantity) -> str:
    return f"| `{each.key}` | {each.unit} | {each.meaning} |".replace("|  |", "| |")


def _with_missing_rows(document: str) -> str:
    """Return a document with a row for each quantity of the blocks of which it has a row."""
    held = [match[1] for match in ROW.finditer(document)]
    first: dict[str, str] = {}
    for key in held:
        first.setdefault(_block_of(key), key)
    before: dict[str, str] = {}
    for key, each in quantities().items():
        block = _block_of(key)
        if block in first and key not in held:
            beside = next(row for row in ROW.finditer(document) if row[1] == before.get(block, first[block]))
            place, text = (beside.end(), f"\n{_row(each)}") if block in before else (beside.start(), f"{_row(each)}\n")
            document = document[:place] + text + document[place:]
        before[block] = key
    return document


def _block_of(key: str) -> str:
    """Return the block of a key; empty for one at the top of a record."""
    return key.partition(".")[0] if "." in key else ""


if __name__ == "__main__":
    for name in sys.argv[1:]:
        file = Path(name)
        file.write_text(with_quantities(file.read_text(encoding="utf-8")), encoding="utf-8")
