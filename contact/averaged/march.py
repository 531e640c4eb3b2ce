r"""Amplitudes of the forward and the backward surface wave at rows of contacts that act back on the wave.

The forces on the slider are P = P_0 + Re P_1 exp(i omega t), and Q in the same form. With C = u_x/u_z of the forward
wave and g = Gamma/w, reciprocity gives

    dU+/dx = +i g sum_i (P_1 + C* Q_1) exp(+i k x) delta(x - x_i),        U+ known on the left,         (1)
    dU-/dx = -i g sum_i (P_1 + C Q_1) exp(-i k x) delta(x - x_i),         U- known on the right.        (2)

C = i r for a Rayleigh wave, and the backward wave has C*. The forces of a row are evaluated at the mean of the
amplitudes on its two sides (implicit midpoint rule). The change of |U+|^2 + |U-|^2 then equals the power that the
contacts take from the wave, up to rounding.

The forces F = (sum P_1 + C* Q_1, sum P_1 + C Q_1) of a row depend only on the amplitudes at this row,
q = (U+ exp(-i k x), U- exp(+i k x)). `march` uses the linear form F_0 + J (q - q_0), for which (1) and (2) are a block
tridiagonal system. For the forces of linear springs J is a complex 2 x 2 matrix. For Newton's method J is the
derivative of the forces, a real 4 x 4 matrix: if a contact touches only for a short time, its relative change of force
is much larger than the relative change of the amplitude, and a change of the phase has a different effect.
"""

import numpy as np

from contact.exceptions import ConvergenceError

# Unknowns up to which a dense matrix is solved: a motor with a few balls then spares the import of scipy.linalg, 0.15 s
MAX_DENSE = 64


def real_form(matrix):
    """Return complex matrices (m, n, n) as real ones (m, 2n, 2n), with alternating real and imaginary parts."""
    m, n, _ = matrix.shape
    parts = np.array([[matrix.real, -matrix.imag], [matrix.imag, matrix.real]])
    return parts.transpose(2, 3, 0, 4, 1).reshape(m, 2 * n, 2 * n)


def march(turn, force, slope, amplitude, g, incident):
    """Return the mean amplitudes of the two sides of each row for linear forces, shape (m, 2), complex.

    Parameters
    ----------
    turn : (m,) array, complex
        exp(-i k x) of the rows, from left to right.
    force, amplitude : (m, 2) array, complex
        F_0 and q_0 of each row.
    slope : (m, 2, 2) array, complex, or (m, 4, 4) array
        J; the real matrix acts on alternating real and imaginary parts.
    g : float
        Gamma/w, 1/(Pa m).
    incident : (2,) array, complex
        U+ on the left and U- on the right, m.
    """
    m, kind, n = turn.size, slope.dtype, slope.shape[1]  # n equations for each row
    # the jumps of U+ and -U- at a row are i g times `to_wave` times F
    to_wave = np.stack([turn.conj(), turn], axis=1)
    to_row, half = to_wave.conj(), 0.5j * g * to_wave
    fixed = force.view(kind) - (slope @ amplitude.view(kind)[..., None])[..., 0]
    if n == 2:  # `to_wave` is diagonal
        response, source = half[:, :, None] * slope * to_row[:, None], 2.0 * half * fixed
    else:
        to_row, half = (real_form(each[:, :, None] * np.eye(2)) for each in (to_row, half))
        response, source = half @ slope @ to_row, 2.0 * (half @ fixed[..., None])[..., 0]
    # Unknowns of row j are U+ on its right (j + 1) and U- on its left (j):
    # (U+_j+1 - U+_j, U-_j - U-_j+1) - response (U+_j + U+_j+1, U-_j + U-_j+1) = source
    own, neighbours = np.eye(n) - response, -np.eye(n) - response
    source[0] -= neighbours[0, :, : n // 2] @ incident[:1].view(kind)
    source[-1] -= neighbours[-1, :, n // 2 :] @ incident[1:].view(kind)
    band = 2 * n - 1  # the equations of a row contain U+ on its left and U- on its right
    bands = np.zeros((3 * band + 1, n * m), kind)  # with the space that LAPACK needs for pivoting
    for row in range(n):
        for column in range(n):
            diagonal = 2 * band + row - column
            bands[diagonal, column::n] = own[:, row, column]
            if column < n // 2:  # U+ on the left of row j is an unknown of row j - 1
                bands[diagonal + n, column : n * (m - 1) : n] = neighbours[1:, row, column]
            else:
                bands[diagonal - n, n + column :: n] = neighbours[:-1, row, column]
    try:
        solution = _solve_banded(band, bands, source.ravel())
    except np.linalg.LinAlgError as error:
        message = "the rows' forces change so fast with the wave that it is not determined"
        raise ConvergenceError("not converged", message) from error
    amplitudes = solution.view(complex).reshape(m, 2)
    forward = np.append(incident[0], amplitudes[:, 0])
    backward = np.append(amplitudes[:, 1], incident[1])
    return 0.5 * np.stack([turn * (forward[:-1] + forward[1:]), turn.conj() * (backward[:-1] + backward[1:])], axis=1)


def _solve_banded(band, bands, right_hand_side):
    """Solve a banded system; `bands` as for LAPACK's gbsv: `band` diagonals on each side, `band` spare ones above."""
    unknowns = right_hand_side.size
    if unknowns <= MAX_DENSE:
        row, column = np.indices((unknowns, unknowns))
        diagonal = 2 * band + row - column
        inside = (diagonal >= band) & (diagonal <= 3 * band)
        matrix = np.where(inside, bands[np.clip(diagonal, band, 3 * band), column], 0.0)
        return np.linalg.solve(matrix, right_hand_side)
    from scipy.linalg import lapack

    # scipy.linalg.solve_banded does the same, but checks its arguments for as long as this takes for a hundred rows
    solve = lapack.zgbsv if bands.dtype.kind == "c" else lapack.dgbsv
    _, _, solution, status = solve(band, band, bands, right_hand_side, overwrite_ab=True)
    if status != 0:
        raise np.linalg.LinAlgError("singular matrix")
    return solution


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
