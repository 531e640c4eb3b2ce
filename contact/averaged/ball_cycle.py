r"""One cycle of the wave under the balls of a heavy slider: the columns of `flat_cycle`, by quadrature.

P = k_n z^(3/2) and Cattaneo's and Mindlin's tangential force (`law.elastic`); k_n and k_t are those of z^(3/2), in
N/m^1.5, with c = mu k_n/k_t as for a flat pillar. The cycle is that of `cycle_mean`, each ball on its own surface
motion and at its own approach. The tangential spring of the elastic law does not act back on the normal motion, so the
column of friction is all that a ball takes from the wave and does not give to the slider.
"""

import numpy as np

from contact.averaged.cycle_mean import Each, cycle, cycle_room
from contact.averaged.riding import arc, mean_loads, quadrature
from contact.body import Paths
from contact.codes import Shape, Tangential
from contact.law.elastic import coulomb
from contact.problem import Problem

NODES = 24  # per smooth piece; errors of 1e-10 of the largest force


def ball_cycles(height, A, d, e, limit_slope, w, side, out):
    """Fill the columns of `flat_cycles` for balls, lengths to the power 3/2."""
    unit = max(float(np.max(A)), float(np.max(np.abs(height))), 1e-300)
    touching = height > -A
    out[:] = 0.0
    for c in np.unique(limit_slope[touching]):
        some = touching & (limit_slope == c)
        amplitude, none = A[some] / unit, np.zeros(int(some.sum()))
        paths = Paths(height[some] / unit, amplitude, none, d[some] / unit, e[some] / unit)
        work = cycle_room(1, NODES, none.size)
        v = w / unit if w != 0.0 else (-1e-300 if side < 0.0 else 0.0)
        cycle(_problem(paths, float(c)), 0.0, v, quadrature(NODES), work)
        each = work.each.T * unit**1.5
        stretch, cos, sin = each[Each.TANGENTIAL], each[Each.TANGENTIAL_COS], each[Each.TANGENTIAL_SIN]
        out[some] = np.transpose(
            [
                each[Each.NORMAL], each[Each.NORMAL_COS], stretch, cos, sin,
                0.5 * (cos * e[some] - sin * d[some]) - stretch * w, arc(paths.height, amplitude) / np.pi,
            ]
        )  # fmt: skip


def mean_normal(height, A):
    """Return <z^(3/2)> of balls at mean approaches on amplitudes, arrays, and its derivative in the approach."""
    return mean_loads(height, A, Shape.SPHERE)


def _problem(paths, c):
    """Return the equations of balls whose forces are P/k_n and Q/k_t."""
    return Problem(
        stiffness=1.0, contact_damping=0.0, normal_damping=0.0, preload=1.0, tangential_damping=0.0, load=0.0,
        friction=c, limit_slope=c, stick_band=0.0, longest=1.0, shape=int(Shape.SPHERE), paths=paths, length=1.0,
        omega=1.0, law=coulomb(Tangential.ELASTIC),
    )  # fmt: skip
