"""S-parameters as Touchstone files, version 1.1 (EIA/IBIS Open Forum, 2002), of any number of ports.

Written in Hz, real and imaginary parts and a real reference, with all digits of a double; read in any unit and format.
A file of two ports lists S11 S21 S12 S22, others go row by row, four pairs to a line.
"""

import numpy as np

from fem.input_error import InputError

UNITS = {"hz": 1.0, "khz": 1e3, "mhz": 1e6, "ghz": 1e9}
PAIRS = 4  # on a line


def touchstone(
    frequency: np.ndarray, scattering: np.ndarray, reference: float, remarks: tuple[str, ...] = ()
) -> str:
    """Return the text of a Touchstone file.

    Parameters
    ----------
    frequency : ndarray, shape (n,)
        Hz, rising.
    scattering : ndarray, shape (n, ports, ports)
    reference : float
        ohm.
    remarks : tuple of str
        Comment lines at the top.

    Examples
    --------
    >>> import numpy as np
    >>> print(touchstone(np.array([1e6]), np.array([[[0.5 - 0.25j]]]), 50.0), end="")
    # Hz S RI R 50.0
    1000000.0 0.5 -0.25
    """
    lines = [*(f"! {remark}" for remark in remarks), f"# Hz S RI R {float(reference)!r}"]
    for at, matrix in zip(frequency, scattering, strict=True):
        ports = len(matrix)
        rows = [matrix.T.ravel()] if ports <= 2 else list(matrix)
        texts = [[f"{float(s.real)!r} {float(s.imag)!r}" for s in row] for row in rows]
        pieces = [row[k : k + PAIRS] for row in texts for k in range(0, len(row), PAIRS)]
        pieces[0].insert(0, repr(float(at)))
        lines += [" ".join(piece) for piece in pieces]
    return "\n".join(lines) + "\n"


def read_touchstone(text: str, ports: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Return frequencies (Hz), S-parameters (n, ports, ports) and reference (ohm) of a Touchstone file's text.

    Raises
    ------
    ValueError
        If it is no Touchstone file of S-parameters for so many ports.
    """
    options, numbers = ["ghz", "s", "ma", "r", "50"], []
    for line in text.splitlines():
        content = line.partition("!")[0].split()
        if content and content[0].startswith("["):
            raise InputError("file", f"must be a Touchstone file of version 1, got the keyword {content[0]}")
        if content and content[0].startswith("#"):
            given = " ".join(content).lstrip("#").lower().split()
            options = _options(given, options)
        else:
            numbers += content
    unit, _, form, _, reference = options
    width = 1 + 2 * ports**2
    try:
        table = np.array([float(number) for number in numbers])
    except ValueError:
        raise InputError("file", "must hold numbers only beside comments and options", numbers[:3]) from None
    if len(table) == 0 or len(table) % width:
        raise InputError(
            "file", f"must have {width} numbers for each frequency of {ports} ports, got {len(table)} in all"
        )
    table = table.reshape(-1, width)
    one, other = table[:, 1::2], table[:, 2::2]
    if form == "ri":
        values = one + 1j * other
    else:
        values = (10 ** (one / 20) if form == "db" else one) * np.exp(1j * np.radians(other))
    scattering = values.reshape(-1, ports, ports)
    if ports == 2:
        scattering = scattering.transpose(0, 2, 1)
    return table[:, 0] * UNITS[unit], scattering, float(reference)


def _options(given: list[str], options: list[str]) -> list[str]:
    options = list(options)
    while given:
        word = given.pop(0)
        if word in UNITS:
            options[0] = word
        elif word in ("ri", "ma", "db"):
            options[2] = word
        elif word == "r" and given:
            options[4] = given.pop(0)
        elif word != "s":
            raise InputError(
                "file", f"must hold S-parameters in Hz to GHz as RI, MA or DB, got the option {word!r}"
            )
    return options
