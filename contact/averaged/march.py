r"""Rows of contacts on a surface wave that they load: the wave's two amplitudes from row to row.

With the forces on the slider P = P_0 + Re P_1 exp(i omega t), Q likewise, C = u_x/u_z of the forward wave and
g = Gamma/w, reciprocity gives

    dU+/dx = +i g sum_i (P_1 + C* Q_1) exp(+i k x) delta(x - x_i),        U+ given on the left,         (1)
    dU-/dx = -i g sum_i (P_1 + C Q_1) exp(-i k x) delta(x - x_i),         U- given on the right,        (2)

(C = i r of a Rayleigh wave, the backward wave's is C*). At a row the forces belong to the amplitudes half-way through
its jump (implicit midpoint): the change of |U+|^2 + |U-|^2 is then the power that the contacts take, to rounding.

The forces F = (sum P_1 + C* Q_1, sum P_1 + C Q_1) of a row depend on its own amplitudes
q = (U+ exp(-i k x), U- exp(+i k x)) alone. `march` takes F_0 + J (q - q_0), with which (1) and (2) are a linear chain
of rows. J is a complex 2 x 2 matrix where the forces are those of springs. Their derivative, for a step of Newton's
method, is a real 4 x 4 matrix: contacts that touch for a short time answer a change of the amplitude by many times what
their forces over the amplitude say, and a change of the phase by another factor.
"""

import numpy as np

from contact.convergence_error import ConvergenceError


def real_form(matrix):
    """Return complex matrices (m, n, n) as real ones (m, 2n, 2n), real and imaginary parts in turn."""
    m, n, _ = matrix.shape
    parts = np.array([[matrix.real, -matrix.imag], [matrix.imag, matrix.real]])
    return parts.transpose(2, 3, 0, 4, 1).reshape(m, 2 * n, 2 * n)


def march(turn, force, slope, amplitude, g, incident):
    """Return the amplitudes half-way through each row that linear forces leave, shape (m, 2), complex.

    Parameters
    ----------
    turn : (m,) array, complex
        exp(-i k x) of the rows, from left to right.
    force, amplitude : (m, 2) array, complex
        F_0 and q_0 of each row.
    slope : (m, 2, 2) array, complex, or (m, 4, 4) array
        J; the real one is for real and imaginary parts in turn.
    g : float
        Gamma/w, 1/(Pa m).
    incident : (2,) array, complex
        U+ on the left and U- on the right, m.
    """
    from scipy.linalg import solve_banded

    m, kind, n = turn.size, slope.dtype, slope.shape[1]  # n equations for each row
    # from the row's frame: the jumps of U+ and -U- are i g times this matrix times F
    to_wave = np.zeros((m, 2, 2), complex)
    to_wave[:, 0, 0], to_wave[:, 1, 1] = turn.conj(), turn
    to_row, half = to_wave.conj(), 0.5j * g * to_wave
    if n == 4:
        to_row, half = real_form(to_row), real_form(half)
    answer = half @ slope @ to_row
    fixed = force.view(kind)[..., None] - slope @ amplitude.view(kind)[..., None]
    source = 2.0 * (half @ fixed)[..., 0]
    # unknowns of row j are U+ behind it and U- before it:
    # (U+_j+1 - U+_j, U-_j - U-_j+1) - answer (U+_j + U+_j+1, U-_j + U-_j+1) = source
    own, neighbours = np.eye(n) - answer, -np.eye(n) - answer
    source[0] -= neighbours[0, :, : n // 2] @ incident[:1].view(kind)
    source[-1] -= neighbours[-1, :, n // 2 :] @ incident[1:].view(kind)
    band = 2 * n - 1  # a row's equations reach from U+ before it to U- behind it
    bands = np.zeros((2 * band + 1, n * m), kind)
    for row in range(n):
        for column in range(n):
            bands[band + row - column, column::n] = own[:, row, column]
            if column < n // 2:  # U+ before row j is that behind row j - 1
                bands[band + row - column + n, column : n * (m - 1) : n] = neighbours[1:, row, column]
            else:
                bands[band + row - column - n, n + column :: n] = neighbours[:-1, row, column]
    try:
        solution = solve_banded((band, band), bands, source.ravel(), overwrite_ab=True, check_finite=False)
    except np.linalg.LinAlgError as error:
        message = "the rows' forces change so fast with the wave that it is not determined"
        raise ConvergenceError("not converged", message) from error
    amplitudes = solution.view(complex).reshape(m, 2)
    forward = np.append(incident[0], amplitudes[:, 0])
    backward = np.append(amplitudes[:, 1], incident[1])
    return 0.5 * np.stack(
        [turn * (forward[:-1] + forward[1:]), turn.conj() * (backward[:-1] + backward[1:])], axis=1
    )


def passed(turn, normal, tangential, orbit, g, incident):
    """Return U+ behind each row and U- before it, shape (2, m, N), of forces P_n, Q_n of shape (m, N); (1) and (2).

    `incident`: U+ on the left and U- on the right, of the fundamental alone.
    """
    turn = turn[:, None] ** (np.arange(normal.shape[1]) + 1)
    jump = 1j * g * np.array(
        [(normal + orbit.conjugate() * tangential) / turn, (normal + orbit * tangential) * turn]
    )  # fmt: skip
    jump[0, 0, 0] += incident[0]
    jump[1, -1, 0] += incident[1]
    return np.array([np.cumsum(jump[0], axis=0), np.cumsum(jump[1, ::-1], axis=0)[::-1]])
