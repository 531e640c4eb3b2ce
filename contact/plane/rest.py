r"""Whether friction holds a slider in the plane on its waves, and about which contact it turns where it does not.

A slider that has crept along d meets the force q(d) that resists most: of all forces that its contacts can carry at
rest the one with the least q.d, for the stop operator dissipates most. These forces are therefore the convex set whose
points in the directions d are q(d), and rest carries a load that lies in it. The point of the set that is nearest to
the load is approached by Wolfe's algorithm (Math. Program. 11, 128, 1976): x is the least combination of the known
points q(d) less the load; d = x is the way on which what is left moves the slider, and adds q(x), until x vanishes
(held) or no point lies nearer (it moves).

A slider that is free in yaw may have one contact that never slips and turn about it. The force of that contact is what
the others leave, and lies among those that it can carry at rest.
"""

from typing import NamedTuple

import numpy as np

from contact.plane.disc_contacts import Sum

MAX_POINTS = 60
ENOUGH = 1e-9  # of the friction limit: what is left at rest
LEAST_SHARE = 1e-12  # of a point in a combination
APART = 1e-7  # of the friction limit: from there on 0 is apart from the forces that rest can carry
NEARER = 1e-7  # of it: by which a point has to lie nearer


class Rest(NamedTuple):
    """The end of a search for rest."""

    held: bool
    contacts: np.ndarray  # (n, COLUMNS): means
    deformation: np.ndarray  # (n, 2)
    left: np.ndarray  # (3,): the nearest force that is left
    most: float  # of the forces of rest along minus `left`, times its length


class Forces(NamedTuple):
    """Forces that contacts carry at rest after a creep, of k creeps."""

    forces: list  # (m,): along the free motions
    means: list  # (n, COLUMNS)
    deformations: list  # (n, 2)

    @classmethod
    def none(cls) -> "Forces":
        """Return those of no creep."""
        return cls([], [], [])


def settled(averaged, load, basis, how, only=None, known: Forces | None = None) -> Rest:
    """Return the rest of an `Averaged` slider under a load (3,) that is free along `basis`, or that it moves.

    ``how``: accuracy of the means; ``only``: the one contact whose force counts, None for all; ``known``: forces of the
    same slider under other loads, to which those found are added. The means of a slider that is held are combined too.
    """
    n = len(averaged.start)
    counts = np.ones(n) if only is None else np.arange(n) == only
    target, rigid = basis.T @ load, averaged.rigid @ basis
    known = Forces.none() if known is None else known

    def add(way):
        contacts, deformation = crept(averaged, rigid @ way * counts[:, None], how)
        force = contacts[:, [Sum.ALONG_X, Sum.ALONG_Y]] * counts[:, None]
        known.forces.append(np.einsum("ick,ic->k", rigid, force))
        known.means.append(contacts)
        known.deformations.append(deformation)

    if not known.forces:
        add(np.zeros(basis.shape[1]))
    share, added = np.zeros(len(known.forces)), 0
    share[0] = 1.0
    while True:
        points = (np.array(known.forces) - target) / averaged.friction
        left = share @ points
        size = float(np.linalg.norm(left))
        held = size <= ENOUGH
        # all points lie beyond 0, or none is nearer to it
        nearer = size * min(size - NEARER, APART)
        next_one = int((points @ left).argmin())
        if not held and points[next_one] @ left >= nearer and added < MAX_POINTS:
            add(left / size)
            points = np.vstack([points, (known.forces[-1] - target) / averaged.friction])
            share, added, next_one = np.append(share, 0.0), added + 1, len(points) - 1
        if held or points[next_one] @ left >= nearer:
            break
        share = nearest(points, share, next_one)
        if np.linalg.norm(share @ points) >= size:  # rounding is all that is left to gain
            break
    contacts, deformation = (np.tensordot(share, each, 1) for each in (known.means, known.deformations))
    most = -float((points[next_one] * averaged.friction + target) @ left)
    return Rest(held, contacts, deformation, basis @ left, most)


def crept(averaged, velocities, how):
    """Return means (n, COLUMNS) and deformations of contacts at rest that have crept with velocities (n, 2)."""
    speed = np.linalg.norm(velocities, axis=1).max()
    deformation = dragged_against(velocities)
    if speed > 0.0:
        averaged.contact_means(velocities * (averaged.creep / speed), how, deformation)
    return averaged.contact_means(0.0 * velocities, how, deformation)[0], deformation


def nearest(points: np.ndarray, share: np.ndarray, other: int) -> np.ndarray:
    """Return the combination (k,) of points (k, m) and another of them that is nearest to 0."""
    share = share.copy()
    active = np.append(np.flatnonzero(share), other)
    while True:
        own, k = points[active], len(active)
        # least |sum shares points| with a sum of shares of 1
        system = np.ones((k + 1, k + 1))
        system[:k, :k], system[k, k] = own @ own.T, 0.0
        new = np.linalg.lstsq(system, np.append(np.zeros(k), 1.0), rcond=None)[0][:k]
        old, falls = share[active], new <= 0.0
        if not falls.any():
            part = 1.0
        else:
            part = min(1.0, float((old[falls] / np.maximum(old[falls] - new[falls], 1e-300)).min()))
        share[active] = old + part * (new - old)
        gone = share[active] <= LEAST_SHARE
        if not gone.any() or part == 1.0:
            share[share <= LEAST_SHARE] = 0.0
            return share / share.sum()
        share[active[gone]] = 0.0
        active = active[~gone]


def dragged_against(velocities: np.ndarray) -> np.ndarray:
    """Return deformations beyond every limit against the velocities of contacts (n, 2)."""
    speed = np.linalg.norm(velocities, axis=1, keepdims=True)
    return -1e3 * np.divide(velocities, speed, out=np.zeros_like(velocities), where=speed > 0.0)
