"""A band of frequencies made ready: half cells at the nodes, bases of the lines, and the check between the nodes."""

import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from fem.band import Band, HalfCell
from fem.cell import PORTS, Block, condensed
from fem.chain import FingerShape, half_cells, repeated
from fem.geometry import Stator, Transducer, check_layout, outer_gaps
from fem.harmonic import LEVELS, driven_wave, orbit_difference
from fem.readout import surface_wave
from fem.reduced import WALL_WIDTH, ReducedSection, bases_of, finger_key, parity_groups, snapshots
from fem.section import Section, discretise
from fem.threads import one_blas_thread
from fem.wavelength import slowest_wavelength

KEPT = 1e-2  # share of the tolerance below which a singular value of the lines' fields is left out
MOST_LEFT_OUT = 1e-5
WALL_COLUMNS = 2
NODES = (
    (0.12, 4),
    (0.25, 5),
    (0.5, 7),
)  # relative width of the band up to which so many nodes serve: 1e-7 and better


@one_blas_thread
def frequency_band(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    *,
    lowest: float,
    highest: float,
    driven: str,
    tolerance: float,
    places: tuple[float, ...] = (),
    level: int | None = None,
    workers: int = 2,
) -> Band:
    """Prepare a driven stator for the frequencies of a band.

    Parameters
    ----------
    stator : Stator
    transducers : tuple of Transducer
        Their outer gaps must be whole: half a gap of bare surface on either side.
    lowest, highest : float
        Hz.
    driven : str
        Transducer whose wave the check is made with.
    tolerance : float
        Relative, of the surface motion at ``places``.
    places : tuple of float
        m; mid-stator if empty.
    level : int, optional
        Discretisation to use, an index of `fem.harmonic.LEVELS`; by the tolerance if not given.
    workers : int
        Threads over the nodes; the linear algebra of each runs outside the interpreter's lock.

    Returns
    -------
    Band

    Raises
    ------
    ConvergenceError
        If the reduction cannot follow the band.
    """
    begun = time.perf_counter()
    check_layout(stator, transducers)
    if not 0 < lowest < highest < np.inf:
        raise ValueError(
            f"the band must run from a lower to a higher frequency, got {lowest!r} to {highest!r} Hz"
        )
    transducers = tuple(sorted(transducers, key=lambda transducer: transducer.center))
    for transducer, gaps in zip(transducers, outer_gaps(stator, transducers), strict=True):
        if min(gaps) < (1 - 1e-9) * transducer.half_gap:
            raise ValueError(
                f"a band takes transducers with half a gap of bare surface on either side, "
                f"{transducer.half_gap:g} m; {transducer.name!r} has {min(gaps):g} m"
            )
    at = np.array(places or (stator.length / 2,))
    middle = float(np.sqrt((lowest**2 + highest**2) / 2))
    checked = driven_wave(
        stator, transducers, frequency=middle, driven=driven, tolerance=tolerance, places=tuple(at)
    )
    resolution = LEVELS[level] if level is not None else checked.solution.resolution
    prepared = _prepared(
        stator,
        transducers,
        lowest,
        highest,
        resolution,
        driven,
        min(KEPT * tolerance, MOST_LEFT_OUT),
        workers,
    )
    wave = surface_wave(prepared.solution(middle, driven=driven))
    reduction = orbit_difference(wave, checked, at)
    of_admittance = abs(wave.admittance / checked.admittance - 1)
    return replace(
        prepared,
        relative_error=checked.relative_error + reduction,
        admittance_error=checked.admittance_error + of_admittance,
        seconds=time.perf_counter() - begun,
    )


def _prepared(stator, transducers, lowest, highest, resolution, driven, kept, workers) -> Band:
    unit = slowest_wavelength(stator.solid, highest)
    scale = min(transducer.finger_width / 2 for transducer in transducers)
    section = discretise(stator, resolution, wavelength=unit, surface_scale=scale)
    squares = _nodes(lowest, highest)
    feeding = {0, len(squares) // 2, len(squares) - 1}  # nodes whose full solution feeds the basis
    kinds = list(dict.fromkeys(finger_key(each) for each in transducers))

    def at_node(index: int):
        frequency = float(np.sqrt(squares[index]) / (2 * np.pi))
        halves = {}
        for key in kinds:
            shape = FingerShape(half_finger=key[0] / 2 / unit, half_gaps=(key[1] / 2 / unit,) * 2)
            halves[key] = half_cells(section, frequency, shape, resolution)
        walls = None if stator.ends == "absorbing" else _wall_matrices(section, frequency, stator.ends)
        seen = None
        if index in feeding:
            seen = snapshots(stator, transducers, section, frequency, halves, resolution, driven, kept)
        return halves, walls, seen

    with ThreadPoolExecutor(workers) as pool:
        nodes = list(pool.map(at_node, range(len(squares))))
    gap_fields, finger_fields = zip(*(seen for _, _, seen in nodes if seen is not None), strict=True)
    gap_fields = (*gap_fields, section.constant_potential[:, None])
    groups = parity_groups(section, stator.ends == "clamped")
    bases = bases_of((np.hstack(gap_fields), np.hstack(finger_fields)), groups, kept)
    odd = None
    if section.odd is not None:
        odd = np.array([section.odd[np.argmax(abs(column))] for column in bases[0].T])
    walls = [bases[0].T @ pair @ bases[0] for _, pair, _ in nodes if pair is not None]
    return Band(
        stator=stator,
        transducers=transducers,
        limits=(lowest, highest),
        resolution=resolution,
        section=ReducedSection(full=section, basis=bases[0], odd=odd),
        half_cells={
            key: _projected_halves([halves[key] for halves, _, _ in nodes], bases, section.odd is None)
            for key in kinds
        },
        nodes=squares,
        walls=np.stack(walls) if walls else None,
    )


def _nodes(lowest: float, highest: float) -> np.ndarray:
    """Chebyshev nodes of a band in omega^2, (rad/s)^2."""
    width = 2 * (highest - lowest) / (highest + lowest)
    count = next((count for widest, count in NODES if width <= widest), None)
    if count is None:
        raise ValueError(
            f"a band must not be wider than {NODES[-1][0]:g} of its middle, got {lowest:g} to {highest:g} Hz: split it"
        )
    angles = np.pi * (np.arange(count) + 0.5) / count
    return (2 * np.pi) ** 2 * (lowest**2 + (highest**2 - lowest**2) * (1 + np.cos(angles)) / 2)


def _projected_halves(pairs: list[tuple[Block, Block]], bases, both: bool) -> HalfCell:
    gap, finger = bases
    n, r = gap.shape
    rising_frame, falling_frame = (np.zeros((2 * n + PORTS, 2 * r + PORTS)) for _ in range(2))
    for frame, (left, right) in ((rising_frame, (gap, finger)), (falling_frame, (finger, gap))):
        frame[:n, :r], frame[n : 2 * n, r : 2 * r] = left, right
        frame[2 * n :, 2 * r :] = np.eye(PORTS)
    rising = np.stack([rising_frame.T @ each[0].matrix @ rising_frame for each in pairs])
    falling = np.stack([falling_frame.T @ each[1].matrix @ falling_frame for each in pairs]) if both else None
    return HalfCell(rising=rising, falling=falling, width=pairs[0][0].width)


def _wall_matrices(section: Section, frequency: float, ends: str) -> np.ndarray:
    """Left and right end pieces on their inner lines, shape (2, n, n)."""
    n = section.size
    column = condensed(section, frequency, width=WALL_WIDTH / WALL_COLUMNS, comb=None)
    piece = repeated(column, WALL_COLUMNS).matrix[: 2 * n, : 2 * n]
    outer = np.arange(n)
    if ends == "clamped":
        outer = np.setdiff1d(outer, section.mechanical)
    walls = []
    for outward, inner in ((0, n), (n, 0)):
        here, there = inner + np.arange(n), outward + outer
        back = np.linalg.solve(piece[np.ix_(there, there)], piece[np.ix_(there, here)])
        walls.append(piece[np.ix_(here, here)] - piece[np.ix_(here, there)] @ back)
    return np.stack(walls)
