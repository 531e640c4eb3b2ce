r"""Whether friction holds a slider in the plane on its waves, and about which contact it turns where it does not.

A slider at rest may be displaced: each contact that never opens carries the deformation e_i that it has at the start of
a period, as far as the discs of the whole period allow, and the body moves slowly with what is left of the forces,

    d = K^-1 B^T (sum G_i^T Q_i(e_i) - F),      e_i <- e_i - G_i B d,

with K the stiffness of the contacts, until nothing is left (held), or what is left no longer falls (it moves). The stop
operator is a contraction: if there is a state of rest with this load, no path leads away from it for ever.

A slider that is free in yaw may have one contact that never slips and turn about it. The force of that contact is what
the others leave, and lies among those that it can carry at rest.
"""

from typing import NamedTuple

import numpy as np

from contact.law import normal
from contact.plane.disc_contacts import Sum

MAX_STEPS = 400
ENOUGH = 1e-9  # of the friction limit: forces that are left at rest
NEAR = 1e-5  # the same where the means are taken finer
FALLS, WINDOW = 0.9, 24  # what is left falls at least by this factor within so many steps, or does not vanish
# A step is as long again where what is left still points the same way, for contacts near their limits are softer
ONWARD, MOST = 0.3, 1e3
LARGEST = 0.5  # of the limit of the deformation: a step


class Rest(NamedTuple):
    """The end of a search for rest."""

    held: bool
    contacts: np.ndarray  # (n, COLUMNS): means
    deformation: np.ndarray  # (n, 2)


def settled(averaged, load, basis, hows, only=None) -> Rest:
    """Return the rest of an `Averaged` slider under a load (3,) that is free along `basis`, or that it moves.

    ``hows``: accuracies of the means, the coarse one for the way to rest; ``only``: the one contact whose force counts,
    None for all.
    """
    coarse, fine = hows
    problem, n = averaged.problem, len(averaged.start)
    counts = np.ones(n, bool) if only is None else np.arange(n) == only
    rigid = averaged.rigid @ basis
    z = np.maximum(problem.height - averaged.height, 0.0)
    each = np.where(averaged.closed & counts, problem.friction * problem.stiffness, 0.0)
    limit = problem.limit_slope * z
    slope = np.array([float(normal.slope(at, problem.normal)) for at in z])
    each = np.where(limit > 0.0, each * slope / np.maximum(problem.limit_slope, 1e-300), 0.0)
    stiffness = np.einsum("i,ick,icl->kl", each, rigid, rigid)
    target, friction = basis.T @ load, averaged.friction
    deformation, still = averaged.deformation * 0.0, np.zeros((n, 2))
    reach = LARGEST * float(limit[each > 0.0].min()) if (each > 0.0).any() else 0.0
    lefts, before, gain, how = [], None, 1.0, coarse
    while True:
        contacts, _ = averaged.contact_means(still, how, deformation)
        force = contacts[:, [Sum.ALONG_X, Sum.ALONG_Y]] * counts[:, None]
        left = np.einsum("ick,ic->k", rigid, force) - target
        size = float(np.linalg.norm(left))
        lefts.append(size)
        if how == coarse and size <= NEAR * friction:
            how = fine
            continue
        if size <= ENOUGH * friction:
            return Rest(True, contacts, deformation)
        stuck = len(lefts) > WINDOW and min(lefts[-WINDOW:]) > FALLS * min(lefts[:-WINDOW])
        if reach == 0.0 or stuck or len(lefts) > MAX_STEPS:
            return Rest(False, contacts, deformation)
        if before is not None:
            onward = before @ left > ONWARD * np.linalg.norm(before) * size
            gain = min(2.0 * gain, MOST) if onward else max(1.0, 0.125 * gain)
        step = gain * np.linalg.lstsq(stiffness, left, rcond=1e-12)[0]
        largest = float(np.linalg.norm(rigid @ step, axis=1).max())
        step = step * min(1.0, reach / largest) if largest > 0.0 else step
        before = left
        deformation = deformation - rigid @ step
