"""S-parameters as Touchstone files, version 1.1 (EIA/IBIS Open Forum, 2002), of any number of ports.

Written in Hz, real and imaginary parts and a real reference, with all digits of a double; scikit-rf reads such files.
A file of two ports lists S11 S21 S12 S22, others go row by row, four pairs to a line.
"""

import numpy as np

PAIRS = 4  # on a line


def touchstone(frequency: np.ndarray, scattering: np.ndarray, reference: float, remarks: tuple[str, ...] = ()) -> str:
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
