"""Functions of a Universal File: dataset 58, text or binary, read from any columns and written as 58b of doubles.

Source: Universal dataset numbers 58 and 58b, University of Cincinnati, Structural Dynamics Research Laboratory,
ceas3.uc.edu/sdrluff.
"""

import re
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from studies.lab.uff_lines import UffLines, body, is_delimiter, numbers
from studies.refusal import shown

FUNCTION = 58
HEAD_LINES = 11  # before the values
# Behind the bytes of a 58b; not "-1" in any column, as the four blanks tell whether all bytes are there
CLOSING = re.compile(rb"(?:\r?\n)?    -1[ \t]*(?:\r?\n|\r|$)")
VALUE_TYPES = {2: (False, 4), 4: (False, 8), 5: (True, 4), 6: (True, 8)}  # ordinate data type: complex, bytes


@dataclass(frozen=True, kw_only=True)
class Axis:
    """What an abscissa, ordinate or denominator is: data type of dataset 58, and unit, empty if it is not stated."""

    kind: int
    unit: str


@dataclass(frozen=True, kw_only=True)
class Function:
    """A dataset 58."""

    line: int  # of the file, where it begins
    identification: tuple[str, ...]  # its five lines of text
    kind: int  # 4 is a frequency response
    node: int  # of the response; 0 if none is stated
    direction: int  # 1, 2, 3 along x, y, z; negative against them; 0 if none is stated
    abscissa: Axis
    ordinate: Axis
    denominator: Axis
    six_digits: bool  # whether the abscissa stands in six digits
    x: np.ndarray = field(repr=False)
    values: np.ndarray = field(repr=False)  # real or complex


def function(reading: UffLines, first: int, binary: str | None) -> Function:
    """Return the dataset 58 whose identifier has just been read; ``binary``: the rest of the identifier of a 58b."""
    head = []
    for _ in range(HEAD_LINES):
        text = reading.line()
        if text is None or is_delimiter(text):
            raise reading.error(f"the dataset 58 that begins in line {first} is cut off in its head")
        head.append((reading.number, text))
    kind, node, direction = _identity(reading, *head[5])
    value_type, count, even, start, step = _form(reading, *head[6])
    abscissa, ordinate, denominator, _ = (_axis(reading, *line) for line in head[7:])
    is_complex, size = VALUE_TYPES[value_type]
    columns = (0 if even else 1) + (2 if is_complex else 1)
    if binary is None:
        values = np.array(numbers(reading, body(reading, first, FUNCTION)))
        rule = f"the dataset 58 that begins in line {first} must hold {count * columns} numbers, got {len(values)}"
        reading.refuse_if(len(values) != count * columns, f"{rule}: is it cut off?")
    else:
        values = _binary_values(reading, first, binary, count, columns, size, even)
    table = values.reshape(count, columns)
    x = start + step * np.arange(count) if even else table[:, 0]
    ordinates = table if even else table[:, 1:]
    values = ordinates[:, 0] + 1j * ordinates[:, 1] if is_complex else ordinates[:, 0]
    reading.refuse_if(
        not (np.all(np.isfinite(x)) and np.all(np.isfinite(values))),
        f"the dataset 58 that begins in line {first} must hold finite numbers only",
    )
    return Function(
        line=first, identification=tuple(text.strip() for _, text in head[:5]), kind=kind, node=node,
        direction=direction, abscissa=abscissa, ordinate=ordinate, denominator=denominator,
        six_digits=even or binary is None, x=x, values=values,
    )  # fmt: skip


@contextmanager
def _record(reading: UffLines, number: int, text: str, content: str):
    """Refuse a record whose numbers cannot be read."""
    try:
        yield
    except (ValueError, IndexError):
        rule = f"must hold {content}, got {shown(text.strip())}: is a line of the head missing?"
        raise reading.error(rule, number) from None


def _identity(reading: UffLines, number: int, text: str) -> tuple[int, int, int]:
    """Return function type, node and direction of record 6, of ten fields in any columns or in its own."""
    cells = text.split()
    if len(cells) != 10:
        ends = np.cumsum([5, 10, 5, 10, 11, 10, 4, 11, 10, 4]).tolist()
        cells = [text[a:b].strip() for a, b in zip([0, *ends], ends, strict=False)]
    with _record(reading, number, text, "function type, response node and direction (record 6 of dataset 58)"):
        return int(cells[0]), int(cells[5] or 0), int(cells[6] or 0)


def _form(reading: UffLines, number: int, text: str) -> tuple[int, int, bool, float, float]:
    """Return data type, number of points, whether they are even, start and step of record 7."""
    cells = text.split()
    if len(cells) < 6:
        ends = [10, 20, 30, 43, 56, 69]
        cells = [text[a:b].strip() for a, b in zip([0, *ends], ends, strict=False)]
    with _record(reading, number, text, "data type, number of points and spacing (record 7 of dataset 58)"):
        value_type, count, spacing = (int(each) for each in cells[:3])
        start, step = (numbers(reading, [(number, each or "0")])[0] for each in cells[3:5])
    rule = "must hold a data type of 2, 4, 5, 6, a number of points and a spacing of 0 or 1 (record 7 of dataset 58)"
    reading.refuse_if(
        value_type not in VALUE_TYPES or count < 1 or spacing not in (0, 1),
        f"{rule}, got {shown(text.strip())}",
        number,
    )
    reading.refuse_if(spacing and step == 0.0 and count > 1, "an even abscissa must have an increment, got 0", number)
    return value_type, count, bool(spacing), start, step


def _axis(reading: UffLines, number: int, text: str) -> Axis:
    """Return data type and unit of one of the records 8 to 11."""
    fixed = [text[a:b].strip() for a, b in ((0, 10), (10, 15), (15, 20), (20, 25))]
    if all(re.fullmatch(r"[+-]?\d+", each) for each in fixed):
        kind, unit = fixed[0], text[46:67].strip()
    else:
        cells = text.split()
        kind, unit = (cells[0], cells[-1] if len(cells) > 5 else "") if cells else ("", "")
    rule = "must hold a data type, label and unit of an axis (records 8 to 11 of dataset 58)"
    reading.refuse_if(
        not re.fullmatch(r"\d+", kind), f"{rule}, got {shown(text.strip())}: is a line of the head missing?", number
    )
    return Axis(kind=int(kind), unit="" if unit.upper() == "NONE" else unit)


def _binary_values(
    reading: UffLines, first: int, binary: str, count: int, columns: int, size: int, even: bool
) -> np.ndarray:
    """Return the numbers of a 58b in their order, and move behind its closing -1.

    The number of bytes follows from the head; what the identifier says is not used, as pyuff 2.5.8 writes there that
    of a real function on an even abscissa.  The abscissa of doubles may be single, as record 12 defines it.
    """
    fields = binary.split()
    rule = f"the dataset 58b that begins in line {first} must have byte order 1 or 2, IEEE numbers (2) and"
    reading.refuse_if(
        len(fields) >= 3 and (fields[0] not in "12" or fields[1] != "2" or fields[2] != str(HEAD_LINES)),
        f"{rule} {HEAD_LINES} lines of text, got {' '.join(fields[:3])}",
        first + 1,
    )
    order = ">" if fields and fields[0] == "2" else "<"
    forms = [np.dtype(f"{order}f{size}")] * columns
    layouts = [forms, [np.dtype(f"{order}f4"), *forms[1:]]] if size == 8 and not even else [forms]
    for layout in layouts:
        record = np.dtype([(f"c{k}", form) for k, form in enumerate(layout)])
        end = reading.at + count * record.itemsize
        closing = CLOSING.match(reading.content, end)
        if closing is None:
            continue
        table = np.frombuffer(reading.content, record, count, reading.at)
        reading.number += reading.content.count(b"\n", reading.at, closing.end())
        reading.at = closing.end()
        return np.stack([table[name].astype(float) for name in table.dtype.names or ()], axis=1).ravel()
    closing = CLOSING.search(reading.content, reading.at)
    held = (closing.start() if closing else len(reading.content)) - reading.at
    reading.refuse_if(
        closing is None and held in [count * sum(each.itemsize for each in layout) for layout in layouts],
        f"the closing -1 of the dataset 58b that begins in line {first} is missing",
    )
    needs = " or ".join(str(count * sum(each.itemsize for each in layout)) for layout in layouts)
    rule = f"the dataset 58b that begins in line {first} must hold {needs} bytes of values before its closing -1"
    raise reading.error(f"{rule}, got {held}: is it cut off, or were its line ends converted?")


def function_58b(
    values: np.ndarray, abscissa: np.ndarray, *, identification: tuple[str, ...], kind: int, node: int, direction: int,
    axes: tuple[tuple[int, str, str], ...],
) -> bytes:  # fmt: skip
    """Return a dataset 58b with doubles for abscissa and values, real or complex.

    ``axes``: data type, label and unit of abscissa, ordinate and denominator.
    """
    is_complex = np.iscomplexobj(values)
    parts = (values.real, values.imag) if is_complex else (values,)
    data = np.stack([abscissa, *parts], axis=1).astype("<f8").tobytes()
    lines = [
        f"{-1:6d}", f"{58:6d}b{1:6d}{2:6d}{HEAD_LINES:12d}{len(data):12d}{0:6d}{0:6d}{0:12d}{0:12d}",
        *(f"{(text or 'NONE')[:80]:<80}" for text in identification),
        f"{kind:5d}{0:10d}{0:5d}{0:10d} {'NONE':>10}{node:10d}{direction:4d} {'NONE':>10}{0:10d}{0:4d}",
        f"{6 if is_complex else 4:10d}{len(values):10d}{0:10d}{0.0:13.5e}{0.0:13.5e}{0.0:13.5e}",
        *(f"{each:10d}{0:5d}{0:5d}{0:5d} {label:<20} {unit:<20}" for each, label, unit in (*axes, (0, "NONE", "NONE"))),
    ]  # fmt: skip
    return "\n".join(lines).encode("utf-8") + b"\n" + data + f"{-1:6d}\n".encode()
