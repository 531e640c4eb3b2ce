"""The flat arrays of `reduced_plane` for a slider that moves in the plane: each contact and the waves under it.

Its mean forces are computed from them in fixed steps (`plane_cycle`). A rotor's are tabulated (`planar_tables`).
"""

import math

import numpy as np

from contact import plane
from studies.export.force_grid import as_written
from studies.export.planar_body import Body, common_parameters
from studies.export.reduced_plane import plane_index as index

# Steps in a cycle of the fastest wave, of the coarser of two lengths: of one wave, and at least of two. Of two they are
# as many in a period as keep its cost, and the errors of the cycles are each other's mean: on waves of 2.2 and 2.3 MHz
# (23 cycles) the mean force over mu P errs by up to 7.5e-3 with 16, 2.3e-3 with 32, 1.0e-3 with 64
STEPS, LEAST_STEPS, PERIOD_STEPS = 96, 32, 736
MAX_CYCLES = 60  # of the fastest wave in a common period: its cost; frequencies without one change by up to 1e-4


def packed_contacts(
    body: Body, *, creep: float, steps: tuple[float, float], rise: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return parameters and orbits of the contacts; ``steps``: the longest and the fast one, s."""
    slider, n = body.slider, body.slider.count
    p = common_parameters(body, body.amplitudes(), n, creep=creep, steps=steps, rise=rise)
    waves = body.waves(slider)
    frequencies = np.array([each.frequencies[0] for each in waves])
    ratios, period, _ = plane.common_period(frequencies, MAX_CYCLES)
    cycles = round(period / (2.0 * math.pi))
    p[index.STEPS], p[index.COMMON_CYCLES] = STEPS, cycles
    p[index.STEPS_OF_BOTH] = min(max(LEAST_STEPS, PERIOD_STEPS // cycles), STEPS)
    p[index.OMEGA :][: len(waves)], p[index.OMEGA_RATIO :][: len(waves)] = 2.0 * math.pi * frequencies, ratios
    own = slider.contacts(n)
    stiffness = np.broadcast_to(own.weight * own.normal_stiffness, n)
    places = np.stack([own.x, own.y], axis=1)
    arms = np.abs(places).max(axis=0)
    if slider.tilt != "held":
        p[index.TILTS], p[index.LOAD_X : index.LOAD_X + 2] = 1.0, np.array(slider.preload_at) / arms
    parts, length = [], 0
    for k in range(n):
        at = index.FIRST_ELEMENT + k * index.ELEMENT_SIZE
        p[at + index.ELEMENT_X : at + index.ELEMENT_Y + 1], p[at + index.REST_TABLE] = places[k], length
        arm = places[k] / np.where(arms > 0.0, arms, 1.0)
        head = [stiffness[k] / stiffness.sum(), own.limit_slope[k], *arm]
        orbits = np.zeros((2, 3, 2))
        for number, each in enumerate(waves):
            orbits[number] = np.stack([each.amplitudes[0, k].real, -each.amplitudes[0, k].imag], axis=1)
        parts.append(np.concatenate([head, orbits.ravel()]))
        length += parts[-1].size
    return p, as_written(parts)
