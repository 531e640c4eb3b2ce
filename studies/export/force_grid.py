"""Tables of the averaged motor's mean forces, and the flat arrays that `reduced_motor` reads.

The tables hold event-exact means over a cycle (`contact.mean_load`, `contact.mean_traction`) on a grid of the two
ratios tau and nu of the averaged equations (`reduced_motor`).
"""

from dataclasses import replace

import numpy as np

import contact
from studies.export.motor_model import Drive, force_exponent
from studies.export.reduced_motor import index

# Nodes of tau and of either side of nu: g between the nodes is within 3.3e-3 (at kinks) and 6e-5 (99 % of random
# points) of the exact mean, and the steady velocity of twente-contact within 5e-6 from 0.75 to 20 nm. With 361 rows
# 6e-4 at 0.75 nm, next to the threshold; with 601 and 401 columns 3e-6, and a C file twice as long.
ROWS, COLUMNS = 501, 301
MIN_SIZE = 1e-6  # sqrt(|nu|) at which the two limits of the jump at nu = 0 are taken
MAX_TAU = 1.0 - 1e-4  # of the last row of g, in place of 1, where the load is zero
MAX_STEP, FAST_STEP = 1e-5, 1e-6  # s
RING_STEPS = 30.0  # per period; 80 rings to 6e-4 of their amplitude, 15: 3e-2 (test_export_motor.py)
DEAD_BOUNCE = 1e-3  # over the approach; changes the mean force by its square
DIGITS = 9  # of the numbers in the tables, the same in Python and in C


def force_tables(slider, drive: Drive) -> tuple[np.ndarray, np.ndarray]:
    """Return R over tau, shape (ROWS,), and g over side, tau and sqrt|nu|, shape (2, ROWS, COLUMNS)."""
    taus = np.linspace(0.0, 1.0, ROWS)
    loads, forces = np.zeros(ROWS), np.zeros((2, ROWS, COLUMNS))
    loads[0], forces[0, 0], forces[1, 0] = 1.0, 1.0, -1.0  # tau = 0: no wave, friction has one direction
    sizes = np.linspace(0.0, 1.0, COLUMNS)
    for k in range(1, ROWS):
        loads[k], forces[:, k] = mean_forces(slider, drive, min(taus[k], MAX_TAU), sizes)
    loads[-1] = 0.0  # tau = 1: the wave no longer reaches the slider
    return loads, forces


def mean_forces(slider, drive: Drive, tau: float, sizes: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the exact R and g, shape (2, k), at a ratio tau and at ``sizes`` = sqrt(|nu|), for nu < 0 and nu > 0.

    R and g depend on the two ratios only; they are evaluated at the amplitude of a level of 1, with a heavy slider,
    because the mass does not enter the means and averaging requires a slow bounce.
    """
    size = drive.amplitude
    height = ((1.0 / tau - 1.0) ** 2 - 1.0) * size  # tau = sqrt(s)/(sqrt(s) + sqrt(h + s)) solved for h
    if slider.adhesion is not None:
        slider = replace(slider, adhesion=None)  # friction feels the elastic force alone: `reduced_motor` has the other
    loads = [contact.mean_load(height, abs(orbit.normal), slider.profile) for orbit in drive.orbits]
    preload = slider.normal_stiffness * sum(loads)
    exponent = force_exponent(slider)
    share = sum(loads) / (len(loads) * (height + size) ** exponent)
    heavy = replace(slider, preload=preload, load=0.0, mass=1e30 * preload * size, tangential_damping=0.0,
                    normal_damping=0.0, contact_damping=0.0)  # fmt: skip
    nu = np.maximum(sizes, MIN_SIZE) ** 2
    speeds = np.concatenate([-nu, nu]) * drive.saturation(slider) * size
    forces = contact.mean_traction(heavy, drive.orbits, speeds).reshape(2, -1)
    return share, forces / (slider.friction_coefficient * preload)


def packed(slider, drives, tables, grid=None) -> tuple[np.ndarray, np.ndarray]:
    """Return the flat arrays of `reduced_motor`, parameters and tables; a mirrored drive has no table (None).

    ``grid``: `law_grid.LawGrid` of tables with depths.
    """
    p = np.zeros(index.FIRST_DRIVE + 2 * index.DRIVE_SIZE)
    contacts = len(drives[0].orbits)
    p[index.MASS], p[index.NORMAL_DAMPING] = slider.mass, slider.normal_damping
    p[index.TANGENTIAL_DAMPING], p[index.CONTACT_DAMPING] = slider.tangential_damping, slider.contact_damping
    p[index.FRICTION], p[index.LIMIT_SLOPE] = slider.friction_coefficient, slider.limit_slope
    p[index.STIFFNESS] = slider.normal_stiffness * contacts
    p[index.EXPONENT] = force_exponent(slider)
    p[index.TAU_NODES], p[index.NU_NODES], p[index.DRIVES] = ROWS, COLUMNS, len(drives)
    fastest = max(slider.normal_resonance(contacts), slider.tangential_resonance(contacts))
    p[index.MAX_STEP], p[index.FAST_STEP] = MAX_STEP, min(FAST_STEP, 1.0 / (100.0 * fastest))
    p[index.RING_STEP] = min(MAX_STEP, 1.0 / (RING_STEPS * fastest))
    p[index.DEAD_BOUNCE] = DEAD_BOUNCE
    p[index.THERMAL_TIME] = drives[0].thermal_time
    p[index.CONTACTS], p[index.PULL] = contacts, slider.normal_stiffness * slider.profile.pull
    parts, length = [], 0
    if grid is not None:
        grid.parameters(p)
        parts, length = [grid.force ** (1.0 / force_exponent(slider))], grid.force.size
    for number, (drive, table) in enumerate(zip(drives, tables, strict=True)):
        own = index.FIRST_DRIVE + number * index.DRIVE_SIZE
        p[own + index.AMPLITUDE], p[own + index.SATURATION] = drive.amplitude, drive.saturation(slider)
        p[own + index.POWER], p[own + index.RESPONSE_STEP] = drive.power, drive.response_step
        p[own + index.FACING], p[own + index.WARMTH] = -1.0 if drive.mirrored else 1.0, drive.warmth
        p[own + index.PULLS] = -1.0
        if table is None:  # as the first drive, except for the sign
            first = index.FIRST_DRIVE
            p[own : own + index.FACING] = p[first : first + index.FACING]
            p[own + index.PULLS], p[own + index.SIZES] = p[first + index.PULLS], p[first + index.SIZES]
            continue
        if grid is None:
            pieces = {index.LOADS: table[0], index.FORCES: table[1].ravel()}
        else:
            pieces = {index.LOADS: table.loads.ravel(), index.FORCES: table.forces.ravel()}
            if table.pulls is not None:
                pieces[index.PULLS] = table.pulls.ravel()
        if p[index.PULL] > 0.0:
            pieces[index.SIZES] = np.array([abs(orbit.normal) for orbit in drive.orbits]) / drive.amplitude
        if drive.response is not None:
            p[own + index.RESPONSE_NODES] = len(drive.response)
            pieces[index.RESPONSE] = np.ascontiguousarray(drive.response).view(float)
        for start_index, piece in pieces.items():
            p[own + start_index] = length
            parts.append(piece)
            length += piece.size
    return p, as_written(parts)


def as_written(parts: list[np.ndarray]) -> np.ndarray:
    """Return tables as one array of the numbers that the C source holds, of `DIGITS` digits."""
    return np.array([float(f"{value:.{DIGITS}g}") for value in np.concatenate(parts).tolist()])
