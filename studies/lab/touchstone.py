"""Touchstone files of versions 1 and 2: option line, keywords, parameters of each frequency.

Read here, because scikit-rf 2.2.0 (scikit-rf.org) makes Y-parameters of version 1 too large by the reference squared,
scales H and G by rows, leaves entries of triangular matrices of version 2 unset, takes the option line's fields in one
order only, and keeps the power waves of an empty network although a file states others.
`tests/studies/test_touchstone.py` shows each of these, and takes it as an independent reader of the rest.

Sources: Touchstone File Format Specification 1.1 (2002) and 2.0 (2009), EIA/IBIS Open Forum; references of each port
and frequency in comments: Ansys HFSS.
"""

import re
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from studies.lab.csv_columns import finite_numbers
from studies.lab.input_file import InputFile
from studies.lab.waves import WAVES
from studies.refusal import SceneError, reading, shown

TOUCHSTONE = re.compile(r"\.(?:[syzgh](?P<ports>\d+)p|ts)", re.IGNORECASE)
FREQUENCY_UNITS = {"hz": 1.0, "khz": 1e3, "mhz": 1e6, "ghz": 1e9}
KINDS, FORMATS = ("s", "y", "z", "g", "h"), ("ma", "db", "ri")
NOISE_NUMBERS = 5  # of a frequency of the noise data behind the network data of two ports
PORT_IMPEDANCE = re.compile(r"!\s*port\s+impedance(.*)", re.IGNORECASE)


@dataclass(kw_only=True)
class TouchstoneFile(InputFile):
    """The contents of a Touchstone file, which its reading fills."""

    path: Path
    option: str
    ports: int = 0
    version: int = 1
    unit: float = 1e9
    kind: str = "s"
    form: str = "ma"
    references: list[complex] = field(default_factory=lambda: [50.0])
    wave: str = ""  # of `WAVES`; empty if the file states none
    order: str = ""  # of the elements of two ports: "21_12" or "12_21"
    matrix: str = "full"
    count: int | None = None  # of frequencies, as stated
    frequency: list[float] = field(default_factory=list)
    numbers: list[list[float]] = field(default_factory=list)  # of each frequency
    impedances: list[list[float]] = field(default_factory=list)  # of comments, of each frequency
    continues: bool = False  # whether the comment before was of port impedances
    has_noise: bool = False

    @property
    def per_frequency(self) -> int:
        """How many real numbers follow a frequency."""
        return 2 * self.ports**2 if self.matrix == "full" else self.ports * (self.ports + 1)

    def matrices(self) -> np.ndarray:
        """Return the parameters as they are written, complex, shape (n, ports, ports)."""
        pairs = np.reshape(self.numbers, (len(self.frequency), -1, 2))
        if self.form == "ri":
            flat = pairs[..., 0] + 1j * pairs[..., 1]
        else:
            size = pairs[..., 0] if self.form == "ma" else 10.0 ** (pairs[..., 0] / 20.0)
            flat = size * np.exp(1j * np.radians(pairs[..., 1]))
        shape = (len(self.frequency), self.ports, self.ports)
        if self.matrix == "full":
            whole = flat.reshape(shape)
            return whole.transpose(0, 2, 1) if self.ports == 2 and self.order == "21_12" else whole
        indices = np.tril_indices(self.ports) if self.matrix == "lower" else np.triu_indices(self.ports)
        whole = np.zeros(shape, complex)
        whole[:, indices[0], indices[1]] = flat
        whole[:, indices[1], indices[0]] = flat
        return whole

    def impedance(self) -> np.ndarray:
        """Return the references of the ports in ohm, complex, shape (n, ports)."""
        count = len(self.frequency)
        if not self.impedances:
            self.refuse_if(
                len(self.references) not in (1, self.ports),
                f"must state one reference, or one of each of {self.ports} ports",
            )
            return np.array(np.broadcast_to(self.references, (count, self.ports)), complex)
        values = [np.reshape(each, (-1, 2)) @ np.array([1, 1j]) for each in self.impedances if len(each) % 2 == 0]
        rows = [np.diag(np.reshape(each, (self.ports, -1))) if len(each) == self.ports**2 else each for each in values]
        rule = f"must state a port impedance of {self.ports} complex numbers for each of {count} frequencies"
        self.refuse_if(
            len(rows) not in (1, count) or any(len(each) != self.ports for each in rows), f"{rule}, got {len(rows)}"
        )
        return np.array(np.broadcast_to(rows, (count, self.ports)))


def read_touchstone(path: Path, option: str) -> TouchstoneFile:
    """Read a Touchstone file.

    Raises
    ------
    SceneError
        If the file cannot be read, is cut off or breaks a rule of the format; the sentence names the line.
    """
    ending = TOUCHSTONE.fullmatch(path.suffix)
    if ending is None:
        raise SceneError(option, f"must be a Touchstone file, .s1p, .s2p ..., got {path.name!r}")
    file = TouchstoneFile(path=path, option=option, ports=int(ending["ports"] or 0))
    lines = [(number, text.strip()) for number, text in enumerate(_text(path, option).splitlines(), 1)]
    has_option, data = False, []
    pending = iter(lines)
    for number, text in pending:
        if text.startswith("!"):
            _comment(file, text)
        elif text.startswith("#"):
            if not has_option:  # others are ignored, as the specification says
                _option_line(file, number, text)
            has_option = True
        elif text.startswith("["):
            _keyword(file, number, text, pending)
            if text.lower().startswith(("[noise data]", "[end]")):
                break
        elif content := text.partition("!")[0].strip():
            data.append((number, content))
            file.continues = False
    file.refuse_if(not has_option, "must have an option line, such as '# MHz S RI R 50'")
    if file.version == 1:
        file.order = "21_12"
    elif file.ports == 2 and file.matrix == "full" and not file.order:
        raise file.error("must state [Two-Port Data Order] 12_21 or 21_12, as version 2 requires of two ports")
    file.refuse_if(
        file.kind in "gh" and file.ports != 2,
        f"must have two ports for parameters {file.kind.upper()}, got {file.ports}",
    )
    _data(file, data)
    return file


def _text(path: Path, option: str) -> str:
    with reading(path, option):
        content = path.read_bytes()
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:  # comments of an instrument
        return content.decode("latin-1")


def _comment(file: TouchstoneFile, text: str) -> None:
    """Read what a comment says of references and waves; port impedances go on in comments of numbers alone."""
    for wave in WAVES:
        if f"uses the {wave} definition" in text.lower():
            file.wave = wave
    matched = PORT_IMPEDANCE.match(text)
    values = _floats(text[1:] if matched is None else matched[1])
    if matched is not None:
        file.continues = bool(values)
        file.impedances += [values] if values else []
    elif file.continues and values:
        file.impedances[-1] += values
    else:
        file.continues = False


def _floats(text: str) -> list[float]:
    """Return the numbers of a text of numbers alone; of any other none."""
    try:
        return [float(each) for each in text.split()]
    except ValueError:
        return []


def _option_line(file: TouchstoneFile, number: int, text: str) -> None:
    """Read the option line, whose fields may stand in any order."""
    words = text.lower()[1:].partition("!")[0].split()
    while words:
        word = words.pop(0)
        if word in FREQUENCY_UNITS:
            file.unit = FREQUENCY_UNITS[word]
        elif word in KINDS:
            file.kind = word
        elif word in FORMATS:
            file.form = word
        elif word == "r":
            values = []
            while words and (value := _impedance(words[0])) is not None:
                values.append(value)
                words.pop(0)
            file.refuse_if(
                not values or any(each.real <= 0.0 for each in values),
                "must state a reference with a positive real part after R",
                number,
            )
            file.references = values
        else:
            expected = "a unit (Hz, kHz, MHz, GHz), a parameter (S, Y, Z, G, H), a format (MA, DB, RI) or R and ohms"
            raise file.error(f"the option line must hold {expected}, got {shown(word)}", number)


def _impedance(word: str) -> complex | None:
    try:
        return complex(word.replace("i", "j"))
    except ValueError:
        return None


def _keyword(file: TouchstoneFile, number: int, text: str, pending) -> None:
    """Read a keyword of version 2."""
    name, _, rest = text[1:].partition("]")
    name, value = name.strip().lower(), rest.partition("!")[0].strip()
    if name == "version":
        file.version = 2
    elif name == "number of ports":
        file.refuse_if(
            not value.isdigit() or (file.ports and int(value) != file.ports),
            f"must state {file.ports or 'the number of'} ports, got {shown(value)}",
            number,
        )
        file.ports = int(value)
    elif name == "number of frequencies" and value.isdigit():
        file.count = int(value)
    elif name == "two-port data order":
        file.order = value
    elif name == "matrix format":
        file.matrix = value.lower()
    elif name == "reference":
        words = value.split()
        while len(words) < file.ports:
            number, more = next(pending, (number, "[End]"))
            file.refuse_if(
                more.startswith("["), f"must state the references of {file.ports} ports, got {len(words)}", number
            )
            words += more.partition("!")[0].split()
        values = [_impedance(word) for word in words]
        file.refuse_if(
            any(each is None or each.real <= 0.0 for each in values),
            f"must state references with positive real parts, got {shown(' '.join(words))}",
            number,
        )
        file.references = [each for each in values if each is not None]
    elif name == "begin information":
        while not next(pending, (0, "[end information]"))[1].lower().startswith("[end information]"):
            pass
    elif name == "noise data":
        file.has_noise = True
    elif name == "mixed-mode order":
        raise file.error("holds mixed-mode parameters: those of single ports are needed", number)
    file.refuse_if(
        file.matrix not in ("full", "lower", "upper") or file.order not in ("", "12_21", "21_12"),
        f"must state Full, Lower or Upper, or an order 12_21 or 21_12, got {shown(value)}",
        number,
    )


def _data(file: TouchstoneFile, lines: list[tuple[int, str]]) -> None:
    """Read frequencies and parameters; noise data behind those of version 1 end them."""
    record: list[float] = []
    file.refuse_if(not file.ports, "must state [Number of Ports], as it has the ending .ts")
    for number, text in lines:
        values = finite_numbers(text.split(), text, partial(file.error, line=number))
        behind = file.frequency and not record and values[0] * file.unit <= file.frequency[-1]
        if behind and file.ports == 2 and file.version == 1 and len(values) == NOISE_NUMBERS:
            file.has_noise = True
            return
        record += values
        while len(record) > file.per_frequency:
            file.frequency.append(record[0] * file.unit)
            file.numbers.append(record[1 : file.per_frequency + 1])
            record = record[file.per_frequency + 1 :]
            rule = f"must hold a frequency and {file.per_frequency} numbers of {file.ports} ports"
            file.refuse_if(
                record and file.version == 1,
                f"{rule}, got {len(record)} more: is the ending of the file right?",
                number,
            )
    if record or (file.count is not None and len(file.frequency) != file.count):
        stated = "" if file.count is None else f" of {file.count}"
        held = f"{len(record)} of {file.per_frequency + 1} numbers"
        rule = f"ends with {held} after {len(file.frequency)}{stated} frequencies"
        raise file.error(f"{rule}: it is cut off, or its ending {file.path.suffix} is not that of its ports")
