r"""Amplitudes of the forward and the backward surface wave at rows of contacts that act back on the wave.

The forces on the slider are P = P_0 + Re P_1 exp(i omega t), and Q in the same form. With C = u_x/u_z of the forward
wave and g = Gamma/w, reciprocity gives

    dU+/dx = +i g sum_i (P_1 + C* Q_1) exp(+i k x) delta(x - x_i),        U+ known on the left,         (1)
    dU-/dx = -i g sum_i (P_1 + C Q_1) exp(-i k x) delta(x - x_i),         U- known on the right.        (2)

C = i r for a Rayleigh wave, and the backward wave has C*. The forces of a row are evaluated at the mean of the
amplitudes on its two sides (implicit midpoint rule). The change of |U+|^2 + |U-|^2 then equals the power that the
contacts take from the wave, up to rounding.

The forces F = (sum P_1 + C* Q_1, sum P_1 + C Q_1) of a row depend only on the amplitudes at this row, q = (U+ exp(-i k
x), U- exp(+i k x)). `march` uses the linear form F_0 + J (q - q_0), for which (1) and (2) are linear equations, solved
from row to row. For the forces of linear springs J is a complex 2 x 2 matrix. For Newton's method J is the derivative
of the forces, a real 4 x 4 matrix: if a contact touches only for a short time, its relative change of force is much
larger than the relative change of the amplitude, and a change of the phase has a different effect.
"""

from typing import NamedTuple

import numpy as np

from contact.exceptions import ConvergenceError
from contact.jit.compiled import compiled, native

PARTS, REAL = 2, 4  # real and imaginary part; those of U+, then those of U-


class _Rows(NamedTuple):
    """Linear forces of m rows in real numbers; U+ and U- are those at the row, with exp(-i k x) and exp(+i k x)."""

    force: np.ndarray  # (m, 4): F_0
    slope: np.ndarray  # (m, 4, 4): J
    amplitude: np.ndarray  # (m, 4): q_0
    ahead: np.ndarray  # (m, 2): exp(-i k d) of the distance d to the next row; the last one is not read
    incident: np.ndarray  # (2, 2): U+ on the left of the first row, U- on the right of the last one
    # what is filled: linear functions of U+ on the left, their constants last, U- on the left and U+ on the right;
    # U- on the right, of U+ on the right, of one row; and both amplitudes in the mean of the two sides
    returned: np.ndarray  # (m, 2, 3)
    passed: np.ndarray  # (m, 2, 3)
    behind: np.ndarray  # (2, 3)
    out: np.ndarray  # (m, 4)
    block: np.ndarray  # (4, 7): equations of one row


@compiled
def _set_behind(rows, j):
    """Express U- on the right of a row by U+ there: through the gap to the next row, and back."""
    behind = rows.behind
    if j == rows.force.shape[0] - 1:
        for part in range(PARTS):
            behind[part, 0] = behind[part, 1] = 0.0
            behind[part, PARTS] = rows.incident[1, part]
        return
    co, si, returned = rows.ahead[j, 0], rows.ahead[j, 1], rows.returned[j + 1]
    for k in range(PARTS + 1):
        real, imag = returned[0, k], returned[1, k]
        behind[0, k], behind[1, k] = co * real - si * imag, si * real + co * imag
    for k in range(PARTS):
        real, imag = behind[k, 0], behind[k, 1]
        behind[k, 0], behind[k, 1] = real * co + imag * si, imag * co - real * si


@compiled
def _set_equations(rows, g, j):
    """Fill the equations of U+ on the right and U- on the left; right-hand sides: factors of U+ on the left, constant.

    They are the jumps (1) and (2) for the forces F_0 + J (q - q_0), where q is the mean of the two sides.
    """
    block, behind, force, slope, amplitude = rows.block, rows.behind, rows.force[j], rows.slope[j], rows.amplitude[j]
    constant = REAL + PARTS
    for row in range(REAL):
        # i g F: the real part of this jump is -g times the imaginary part of F
        of, factor = (row + 1, -g) if row % PARTS == 0 else (row - 1, g)
        fixed = force[of]
        for column in range(REAL):
            fixed -= slope[of, column] * amplitude[column]
        block[row, constant] = factor * fixed
        for k in range(PARTS):
            forward, backward = 0.5 * factor * slope[of, k], 0.5 * factor * slope[of, PARTS + k]
            block[row, k], block[row, REAL + k], block[row, PARTS + k] = -forward, forward, -backward
        if row < PARTS:
            block[row, row] += 1.0
            block[row, REAL + row] += 1.0
        else:
            block[row, row] += 1.0
        for k in range(PARTS):
            on_right = 0.5 * factor * slope[of, PARTS + k] + (1.0 if row == PARTS + k else 0.0)
            block[row, 0] -= on_right * behind[k, 0]
            block[row, 1] -= on_right * behind[k, 1]
            block[row, constant] += on_right * behind[k, PARTS]


@compiled
def _solve_block(block):
    """Solve the equations of a row in place (Gauss and Jordan, with the largest pivot); return True if singular."""
    for k in range(REAL):
        best = k
        for row in range(k + 1, REAL):
            if abs(block[row, k]) > abs(block[best, k]):
                best = row
        if block[best, k] == 0.0:
            return True
        pivot = 1.0 / block[best, k]
        for column in range(k, REAL + PARTS + 1):
            value = block[best, column] * pivot
            block[best, column] = block[k, column]
            block[k, column] = value
        for row in range(REAL):
            factor = block[row, k]
            if row != k:
                for column in range(k + 1, REAL + PARTS + 1):
                    block[row, column] -= factor * block[k, column]
    return False


@native("t f", {
    "rows.force": "m 4", "rows.slope": "m 4 4", "rows.amplitude": "m 4", "rows.ahead": "m 2", "rows.incident": "2 2",
    "rows.returned": "m 2 3", "rows.passed": "m 2 3", "rows.behind": "2 3", "rows.out": "m 4", "rows.block": "4 7",
})  # fmt: skip
def _march(rows, g):
    """Fill the mean amplitudes at all rows; return whether the forces leave them open.

    From the last row to the first, U- on the left of each is expressed by U+ there (invariant imbedding: Bellman and
    Kalaba, Proc. Natl. Acad. Sci. 42 (1956) 629). Then U+ is followed from the first row to the last.
    """
    block, out, m = rows.block, rows.out, rows.force.shape[0]
    for j in range(m - 1, -1, -1):
        _set_behind(rows, j)
        _set_equations(rows, g, j)
        if _solve_block(block):
            return True
        for part in range(PARTS):
            for k in range(PARTS + 1):
                rows.passed[j, part, k] = block[part, REAL + k]
                rows.returned[j, part, k] = block[PARTS + part, REAL + k]
    real, imag = rows.incident[0, 0], rows.incident[0, 1]
    for j in range(m):
        _set_behind(rows, j)
        passed, returned, behind = rows.passed[j], rows.returned[j], rows.behind
        right = passed[0, 0] * real + passed[0, 1] * imag + passed[0, 2]
        right_imag = passed[1, 0] * real + passed[1, 1] * imag + passed[1, 2]
        for part in range(PARTS):
            left = returned[part, 0] * real + returned[part, 1] * imag + returned[part, 2]
            back = behind[part, 0] * right + behind[part, 1] * right_imag + behind[part, 2]
            out[j, PARTS + part] = 0.5 * (left + back)
        out[j, 0], out[j, 1] = 0.5 * (real + right), 0.5 * (imag + right_imag)
        co, si = rows.ahead[j, 0], rows.ahead[j, 1]
        real, imag = co * right - si * right_imag, si * right + co * right_imag
    return False


def march(turn, force, slope, amplitude, g, incident):
    """Return the mean amplitudes of the two sides of each row for linear forces, shape (m, 2), complex.

    Parameters
    ----------
    turn : (m,) array, complex
        exp(-i k x) of the rows, from left to right.
    force, amplitude : (m, 2) array, complex
        F_0 and q_0 of each row.
    slope : (m, 4, 4) array
        J; it acts on real and imaginary parts by turns (`real_form`).
    g : float
        Gamma/w, 1/(Pa m).
    incident : (2,) array, complex
        U+ on the left and U- on the right, m.
    """
    m = turn.size
    ahead = np.append(turn[1:] * turn[:-1].conj(), 1.0)
    edges = np.array([turn[0] * incident[0], turn[-1].conj() * incident[1]])
    rows = _Rows(
        force=_parts(force), slope=slope, amplitude=_parts(amplitude),
        ahead=_parts(ahead).reshape(m, 2), incident=_parts(edges).reshape(2, 2), returned=np.empty((m, 2, 3)),
        passed=np.empty((m, 2, 3)), behind=np.empty((2, 3)), out=np.empty((m, 4)), block=np.empty((4, 7)),
    )  # fmt: skip
    if _march(rows, float(g)):
        message = "the rows' forces change so fast with the wave that it is not determined"
        raise ConvergenceError("not converged", message)
    return rows.out.view(complex)


def _parts(values):
    """Return complex numbers as real ones, the real and imaginary parts by turns."""
    return np.ascontiguousarray(values, complex).view(float)


def real_form(matrix):
    """Return complex matrices (m, n, n) as real ones (m, 2n, 2n), with alternating real and imaginary parts."""
    m, n, _ = matrix.shape
    parts = np.empty((m, n, 2, n, 2))
    parts[:, :, 0, :, 0] = parts[:, :, 1, :, 1] = matrix.real
    parts[:, :, 1, :, 0] = matrix.imag
    np.negative(matrix.imag, out=parts[:, :, 0, :, 1])
    return parts.reshape(m, 2 * n, 2 * n)


def passed(turn, normal, tangential, orbit, g, incident):
    """Return U+ on the right and U- on the left of each row for N harmonics, shape (2, m, N), by (1) and (2).

    `normal` and `tangential` are the harmonics P_n and Q_n of the forces, shape (m, N). `incident` is U+ on the left
    and U- on the right of all rows, which have the fundamental only.
    """
    turn = turn[:, None] ** (np.arange(normal.shape[1]) + 1)
    jump = 1j * g * np.array(
        [(normal + orbit.conjugate() * tangential) / turn, (normal + orbit * tangential) * turn]
    )  # fmt: skip
    jump[0, 0, 0] += incident[0]
    jump[1, -1, 0] += incident[1]
    return np.array([np.cumsum(jump[0], axis=0), np.cumsum(jump[1, ::-1], axis=0)[::-1]])
