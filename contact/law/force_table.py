"""The normal force of a contact as a table of its approach: what its friction needs to know of its surface."""

from typing import NamedTuple

import numpy as np

from contact.jit.compiled import compiled


class ForceTable(NamedTuple):
    """Normal forces of contacts at equally spaced approaches: cubics between them, zero before the first."""

    force: np.ndarray  # N, shape (contacts, rows)
    rate: np.ndarray  # dP/dz times the spacing, N, shape (contacts, rows)
    start: np.ndarray  # approach of the first row, m, shape (contacts,)
    spacing: np.ndarray  # of the rows, m, shape (contacts,)


def joined(tables) -> ForceTable:
    """Return tables of as many rows as one."""
    return ForceTable(*(np.concatenate(each) for each in zip(*tables, strict=True)))


@compiled
def force_at(table, k, z):
    """Return the force of contact k at an approach z."""
    return force_and_rate_at(table, k, z)[0]


@compiled
def force_and_rate_at(table, k, z):
    """Return the force of contact k at an approach z, and its derivative."""
    at = (z - table.start[k]) / table.spacing[k]
    if at <= 0.0:
        return 0.0, 0.0
    row = min(int(at), table.force.shape[1] - 2)
    t = at - row
    low, high, rise, fall = table.force[k, row], table.force[k, row + 1], table.rate[k, row], table.rate[k, row + 1]
    cubic, square = 2.0 * (low - high) + rise + fall, 3.0 * (high - low) - 2.0 * rise - fall
    force = low + t * (rise + t * (square + t * cubic))
    return force, (rise + t * (2.0 * square + 3.0 * t * cubic)) / table.spacing[k]
