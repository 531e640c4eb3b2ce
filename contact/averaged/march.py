r"""Rows of contacts on a surface wave that they load: the wave's two amplitudes from row to row.

With the forces on the slider P = P_0 + Re P_1 exp(i omega t), Q likewise, C = u_x/u_z of the forward wave and
g = Gamma/w, reciprocity gives

    dU+/dx = +i g sum_i (P_1 + C* Q_1) exp(+i k x) delta(x - x_i),        U+ given on the left,
    dU-/dx = -i g sum_i (P_1 + C Q_1) exp(-i k x) delta(x - x_i),         U- given on the right,

(C = i r of a Rayleigh wave, the backward wave's is C*). At a row the forces belong to the amplitude half-way through
its jump (implicit midpoint): the change of |U+|^2 + |U-|^2 is then the power that the contacts take, to rounding.
"""

from typing import NamedTuple

import numpy as np

from contact.jit.compiled import native


class Waves(NamedTuple):
    """What comes in, and how the rows see it."""

    turn: np.ndarray  # exp(-i k x) of the rows, from left to right, (n,)
    orbit: np.ndarray  # C, (1,)
    g: float  # Gamma/w, 1/(Pa m)
    incident: np.ndarray  # U+ on the left and U- on the right, m, (2,)


class Followed(NamedTuple):
    """How the forces follow the amplitudes at each row: exact where contacts stick all the time."""

    normal: np.ndarray  # sum P_1/u_z, N/m
    tangential: np.ndarray  # sum Q_1/u_x


@native(
    "t c1 c1 t c1 c1 c2",
    {"waves.turn": "n", "waves.orbit": "1", "waves.incident": "2", "forward_force": "n", "backward_force": "n",
     "followed.normal": "n", "followed.tangential": "n", "forward": "n", "backward": "n", "work": "n 4"},
)  # fmt: skip
def march(waves, forward_force, backward_force, followed, forward, backward, work):
    """Replace the amplitudes half-way through each row by those that the forces leave; returns 0.

    `forward`, `backward`: U+ exp(-i k x) and U- exp(i k x) at the rows, with which the forces sum (P_1 + C* Q_1) and
    sum (P_1 + C Q_1) were taken.

    With these stiffnesses the rows are a linear chain. What lies to the right of a row answers U- = rho U+ + tau, which
    is carried from the right end to the left; then the amplitudes follow from left to right.
    """
    turn, half, n, c = waves.turn, 0.5j * waves.g, waves.turn.size, waves.orbit[0]
    rho, tau = 0.0j, waves.incident[1]
    for m in range(n):
        j = n - 1 - m
        normal, tangential = followed.normal[j], followed.tangential[j]
        own = normal + (c.real * c.real + c.imag * c.imag) * tangential
        across, back = normal + c.conjugate() * c.conjugate() * tangential, normal + c * c * tangential
        right = half * (forward_force[j] - own * forward[j] - across * backward[j])
        left = half * (backward_force[j] - back * forward[j] - own * backward[j])
        # behind the row, in its frame: p-_in = rho p+_out + tau, p+_out = 2 p+ - p+_in
        after = turn[j].conjugate()
        seen, rest = rho * after * after, tau * after
        # p+ (1 - half own) - half across p- = p+_in + right
        # -(half back + 2 seen) p+ + (1 - half own) p- = rest - seen p+_in + left
        diagonal, upper, lower = 1.0 - half * own, -half * across, -(half * back + 2.0 * seen)
        determinant = diagonal * diagonal - upper * lower
        # p+ = work0 p+_in + work1, p- = work2 p+_in + work3
        plus, plus_rest = (
            (diagonal + upper * seen) / determinant,
            (diagonal * right - upper * (rest + left)) / determinant,
        )
        minus = (-diagonal * seen - lower) / determinant
        minus_rest = (diagonal * (rest + left) - lower * right) / determinant
        work[j, 0], work[j, 1], work[j, 2], work[j, 3] = plus, plus_rest, minus, minus_rest
        # before the row: p-_out = 2 p- - p-_in
        out = 2.0 * minus - seen * (2.0 * plus - 1.0)
        out_rest = 2.0 * minus_rest - seen * 2.0 * plus_rest - rest
        rho, tau = out * turn[j] * turn[j], out_rest * turn[j]
    here = waves.incident[0]
    for j in range(n):
        before = here * turn[j]
        forward[j] = work[j, 0] * before + work[j, 1]
        backward[j] = work[j, 2] * before + work[j, 3]
        here = (2.0 * forward[j] - before) * turn[j].conjugate()
    return 0


def ends(turn, forward_force, backward_force, g, first, last):
    """Return (U+, U-) at the right and at the left of each row, shape (2, n): U+ behind it, U- before it."""
    forward = first + 1j * g * np.cumsum(forward_force * turn.conj())
    backward = last + 1j * g * np.cumsum((backward_force * turn)[::-1])[::-1]
    return np.array([forward, backward])
