r"""The rows of `march` with the full derivative of their forces: Newton's method for the wave below the contacts.

A row's forces F = (sum P_1 + C* Q_1, sum P_1 + C Q_1) follow its amplitudes q = (U+ exp(-i k x), U- exp(i k x)), four
real numbers, by F_0 + J (q - q_0): contacts that touch for a short time answer a change of the amplitude by many times
what their forces over the amplitude say, and a phase by another factor, so that J is no complex number. With h = i g/2
and U- = S U+ + s to the right of the row (2 x 2 and 2 real numbers, in its frame)

    (1 - h J - (0, 0; 2 S, 0)) q = (1; -S) p+_in + (0; s) + h (F_0 - J q_0),

which gives q = M p+_in + m and the S, s to the left of the row; then the amplitudes follow from left to right.
"""

from contact.jit.compiled import compiled, native

ACROSS = 7  # columns of a row's equations: its four unknowns, and three right sides


@compiled
def _turned(matrix, c, s):
    """Replace a 2 x 2 matrix by itself between two turns of the plane by the angle with cosine c and sine s."""
    for _ in range(2):  # from the left, then, transposed, from the right
        for k in range(2):
            top, low = matrix[0, k], matrix[1, k]
            matrix[0, k], matrix[1, k] = c * top - s * low, s * top + c * low
        matrix[0, 1], matrix[1, 0] = matrix[1, 0], matrix[0, 1]
        s = -s  # A turn(s) = (turn(-s) A^T)^T


@compiled
def _eliminated(table):
    """Solve the four equations of a table for its right sides, with pivots."""
    for k in range(4):
        best = k
        for i in range(k + 1, 4):
            if abs(table[i, k]) > abs(table[best, k]):
                best = i
        for j in range(ACROSS):
            table[k, j], table[best, j] = table[best, j], table[k, j]
        pivot = table[k, k] if table[k, k] != 0.0 else 1e-300
        for i in range(4):
            if i != k:
                factor = table[i, k] / pivot
                for j in range(k, ACROSS):
                    table[i, j] -= factor * table[k, j]
        for j in range(k, ACROSS):
            table[k, j] /= pivot


@native(
    "t f2 f3 f2 f3 f2 f2",
    {"waves.turn": "n", "waves.orbit": "1", "waves.incident": "2", "force": "n 4", "slope": "n 4 4",
     "amplitude": "n 4", "answer": "n 4 3", "table": "4 7", "right": "2 3"},
)  # fmt: skip
def tangent_march(waves, force, slope, amplitude, answer, table, right):
    """Replace the amplitudes half-way through each row by Newton's next ones; returns 0.

    `waves`: `march.Waves`; `force`, `slope`: F_0 and J at `amplitude`, real and imaginary parts in turn; `answer`,
    `table`, `right`: room.
    """
    n, half, incident = waves.turn.size, 0.5 * waves.g, waves.incident
    for i in range(2):
        for j in range(2):
            right[i, j] = 0.0
    right[0, 2], right[1, 2] = incident[1].real, incident[1].imag
    for m in range(n):
        j = n - 1 - m
        c, s = waves.turn[j].real, -waves.turn[j].imag
        # into the row's frame: U+_right = p+_out exp(i k x), p-_in = U-_right exp(i k x)
        _turned(right, c, s)
        top, low = right[0, 2], right[1, 2]
        right[0, 2], right[1, 2] = c * top - s * low, s * top + c * low
        for i in range(4):
            for k in range(ACROSS):
                table[i, k] = 0.0
            table[i, i] = 1.0
        for side in range(2):
            for k in range(4):  # h F = half (-Im, Re)
                table[2 * side, k] += half * slope[j, 2 * side + 1, k]
                table[2 * side + 1, k] -= half * slope[j, 2 * side, k]
            real, imaginary = force[j, 2 * side], force[j, 2 * side + 1]
            for k in range(4):
                real -= slope[j, 2 * side, k] * amplitude[j, k]
                imaginary -= slope[j, 2 * side + 1, k] * amplitude[j, k]
            table[2 * side, 6] = -half * imaginary
            table[2 * side + 1, 6] = half * real
        for i in range(2):
            table[i, 4 + i] = 1.0
            table[2 + i, 6] += right[i, 2]
            for k in range(2):
                table[2 + i, k] -= 2.0 * right[i, k]
                table[2 + i, 4 + k] = -right[i, k]
        _eliminated(table)
        for i in range(4):
            for k in range(3):
                answer[j, i, k] = table[i, 4 + k]
        # before the row: p-_out = 2 p- - S (2 p+ - p+_in) - s
        s00, s01, s10, s11 = right[0, 0], right[0, 1], right[1, 0], right[1, 1]
        for k in range(3):
            plus0, plus1 = 2.0 * table[0, 4 + k], 2.0 * table[1, 4 + k]
            if k == 0:
                plus0 -= 1.0
            elif k == 1:
                plus1 -= 1.0
            extra0 = right[0, 2] if k == 2 else 0.0
            extra1 = right[1, 2] if k == 2 else 0.0
            table[0, k] = 2.0 * table[2, 4 + k] - s00 * plus0 - s01 * plus1 - extra0
            table[1, k] = 2.0 * table[3, 4 + k] - s10 * plus0 - s11 * plus1 - extra1
        for k in range(3):
            right[0, k], right[1, k] = table[0, k], table[1, k]
        # out of the frame: p+_in = U+ exp(-i k x), U-_left = p-_out exp(-i k x)
        _turned(right, c, -s)
        top, low = right[0, 2], right[1, 2]
        right[0, 2], right[1, 2] = c * top + s * low, -s * top + c * low
    real, imaginary = incident[0].real, incident[0].imag
    for j in range(n):
        c, s = waves.turn[j].real, -waves.turn[j].imag
        before0, before1 = c * real + s * imaginary, c * imaginary - s * real
        for i in range(4):
            amplitude[j, i] = answer[j, i, 0] * before0 + answer[j, i, 1] * before1 + answer[j, i, 2]
        out0, out1 = 2.0 * amplitude[j, 0] - before0, 2.0 * amplitude[j, 1] - before1
        real, imaginary = c * out0 - s * out1, s * out0 + c * out1
    return 0
