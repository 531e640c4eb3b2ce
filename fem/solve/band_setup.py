"""A band of frequencies made ready: half cells at the nodes, bases of the lines, and the check between the nodes."""

import time
from dataclasses import dataclass, field, replace
from functools import reduce

import numpy as np

from fem.condense.join import joined
from fem.condense.superelement import PORTS, condensed
from fem.condense.transducer import FingerShape, half_cells
from fem.convergence import ConvergenceError
from fem.discretize.refinement import LEVELS, first_level
from fem.discretize.section import CORNER_RATIO, Resolution, Section, discretise, graded
from fem.geometry import Stator, Transducer, check_layout, outer_gaps
from fem.materials.christoffel import slowest_wavelength
from fem.results.evaluation import surface_wave
from fem.results.surface import SurfaceWave
from fem.solve.band import Band, HalfCell
from fem.solve.harmonic import driven_wave, motion_difference
from fem.solve.reduced_basis import WALL_WIDTH, ReducedSection, bases_of, finger_key, parity_groups, snapshots
from fem.threads import one_blas_thread, side_by_side

# Shares of the tolerance below which a singular value of the lines' fields is left out: at first, at last, and from
# one attempt to the next.
LARGEST_LEFT_OUT, SMALLEST_LEFT_OUT, FEWER_LEFT_OUT = 5e-2, 2e-3, 0.5
MOST_LEFT_OUT = 1e-4  # whatever the tolerance
REDUCTION_SHARE = 0.5  # of the tolerance
ARRIVING = (
    1e-2  # share of the tolerance that a mode must keep over a stretch to count among those that arrive
)
WALL_COLUMNS = 2
REDUCTION_SAFETY = 2.0  # the reduction's error elsewhere in the band over that where it is checked
NODES = (
    (0.12, 4),
    (0.25, 5),
    (0.5, 7),
)  # relative width of the band up to which so many nodes serve: to 1e-6
LOOSE = 3e-4  # tolerance from which a node less serves: to 1e-4


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
        Discretisation to use, an index of `fem.discretize.refinement.LEVELS`; by the tolerance if not given.

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
    limits = lowest, highest
    middle = _between_nodes(lowest, highest, tolerance)

    def checked() -> SurfaceWave:
        return driven_wave(
            stator, transducers, frequency=middle, driven=driven, tolerance=tolerance, places=tuple(at)
        )

    def followed(resolution: Resolution) -> _Nodes:
        return _nodes_followed(stator, transducers, limits, resolution, driven, tolerance, at)

    expected = LEVELS[first_level(tolerance) + 1 if level is None else level]
    reference, nodes = side_by_side(lambda work: work(), (checked, lambda: followed(expected)))
    if level is None and reference.solution.resolution != expected:
        nodes = followed(reference.solution.resolution)
    band = _small_enough(stator, transducers, limits, nodes, driven, tolerance, at)
    answers = [(middle, reference.motion(at), reference.admittance), *nodes.answers]
    of_motion, of_admittance = (REDUCTION_SAFETY * error for error in _differences(band, answers, driven, at))
    return replace(
        band,
        relative_error=reference.relative_error + of_motion,
        admittance_error=reference.admittance_error + of_admittance,
        seconds=time.perf_counter() - begun,
    )


def _small_enough(stator, transducers, limits, nodes, driven, tolerance, at) -> Band:
    """Project on as few fields as give the full solutions at the nodes again."""
    kept = min(LARGEST_LEFT_OUT * tolerance, MOST_LEFT_OUT)
    while True:
        last = kept <= SMALLEST_LEFT_OUT * min(tolerance, 1e-3)
        band = _projected(stator, transducers, limits, nodes, kept)
        try:
            error = REDUCTION_SAFETY * max(_differences(band, nodes.answers, driven, at))
        except ConvergenceError:  # too few fields to close the ends with
            if last:
                raise
            error = np.inf
        if last or error <= REDUCTION_SHARE * tolerance:
            return band
        kept *= FEWER_LEFT_OUT


def _differences(band: Band, answers: list, driven: str, at: np.ndarray) -> tuple[float, float]:
    """Worst differences of a band's motion and admittance from known answers (frequency, motion, admittance)."""
    motions, admittances = [], []
    for frequency, motion, admittance in answers:
        wave = surface_wave(band.solution(frequency, driven=driven))
        motions.append(motion_difference(wave.motion(at), motion))
        admittances.append(float(abs(wave.admittance / admittance - 1)))
    return max(motions), max(admittances)


@dataclass(frozen=True, kw_only=True)
class _Nodes:
    """What the full lines give at the nodes of a band, before they are projected.

    Attributes
    ----------
    section : Section
    resolution : Resolution
    squares : ndarray
        omega^2.
    half_cells : dict
        By kind of finger: at every node the matrices of the rising and the falling half, and the width.
    walls : list of ndarray
        At every node, or empty.
    fields : tuple of ndarray
        Seen on the lines in mid-gap and in mid-finger.
    answers : list of (float, ndarray, complex)
        Frequency (Hz), motion at the places and admittance of the full solutions.
    """

    section: Section
    resolution: Resolution
    squares: np.ndarray
    half_cells: dict = field(repr=False)
    walls: list = field(repr=False)
    fields: tuple = field(repr=False)
    answers: list = field(repr=False)


def _nodes_followed(stator, transducers, limits, resolution, driven, tolerance, at) -> _Nodes:
    unit = slowest_wavelength(stator.solid, limits[1])
    scale = min(transducer.finger_width / 2 for transducer in transducers)
    section = discretise(stator, resolution, wavelength=unit, surface_scale=scale)
    squares = _nodes(*limits, tolerance)
    feeding = {0, len(squares) // 2, len(squares) - 1}  # nodes whose full solution feeds the basis
    kinds = list(dict.fromkeys(finger_key(each) for each in transducers))
    arriving = ARRIVING * tolerance

    def at_node(index: int):
        frequency = float(np.sqrt(squares[index]) / (2 * np.pi))
        halves = {}
        for key in kinds:
            shape = FingerShape(half_finger=key[0] / 2 / unit, half_gaps=(key[1] / 2 / unit,) * 2)
            halves[key] = half_cells(section, frequency, shape, resolution)
        walls = None if stator.ends == "absorbing" else _wall_matrices(section, frequency, stator, resolution)
        seen = answer = None
        if index in feeding:
            *seen, solution = snapshots(
                stator, transducers, section, frequency, halves, resolution, driven, arriving
            )
            wave = surface_wave(solution)
            answer = frequency, wave.motion(at), wave.admittance
        matrices = {key: (tuple(half.matrix for half in pair), pair[0].width) for key, pair in halves.items()}
        return matrices, walls, seen, answer

    nodes = side_by_side(at_node, range(len(squares)))
    seen = [each for _, _, each, _ in nodes if each is not None]
    gaps = np.hstack([gap for gap, _ in seen] + [section.constant_potential[:, None]])
    return _Nodes(
        section=section,
        resolution=resolution,
        squares=squares,
        half_cells={key: [matrices[key] for matrices, _, _, _ in nodes] for key in kinds},
        walls=[walls for _, walls, _, _ in nodes if walls is not None],
        fields=(gaps, np.hstack([finger for _, finger in seen])),
        answers=[answer for _, _, _, answer in nodes if answer is not None],
    )


def _projected(stator, transducers, limits, nodes: _Nodes, kept: float) -> Band:
    section = nodes.section
    bases = bases_of(nodes.fields, parity_groups(section, stator.ends == "clamped"), kept)
    odd = None
    if section.odd is not None:
        odd = np.array([section.odd[np.argmax(abs(column))] for column in bases[0].T])
    walls = [bases[0].T @ pair @ bases[0] for pair in nodes.walls]
    return Band(
        stator=stator,
        transducers=transducers,
        limits=limits,
        resolution=nodes.resolution,
        section=ReducedSection(full=section, basis=bases[0], odd=odd),
        half_cells={
            key: _projected_halves(pairs, bases, section.odd is None)
            for key, pairs in nodes.half_cells.items()
        },
        nodes=nodes.squares,
        walls=np.stack(walls) if walls else None,
    )


def _nodes(lowest: float, highest: float, tolerance: float) -> np.ndarray:
    """Chebyshev nodes of a band in omega^2, (rad/s)^2."""
    width = 2 * (highest - lowest) / (highest + lowest)
    count = next((count for widest, count in NODES if width <= widest), None)
    if count is None:
        raise ValueError(
            f"a band must not be wider than {NODES[-1][0]:g} of its middle, got {lowest:g} to {highest:g} Hz: split it"
        )
    count -= tolerance >= LOOSE
    angles = np.pi * (np.arange(count) + 0.5) / count
    return (2 * np.pi) ** 2 * (lowest**2 + (highest**2 - lowest**2) * (1 + np.cos(angles)) / 2)


def _between_nodes(lowest: float, highest: float, tolerance: float) -> float:
    """Frequency in Hz near the middle of a band where an interpolation over its nodes errs most."""
    count = len(_nodes(lowest, highest, tolerance))
    place = np.cos(np.pi * (count // 2 + count % 2) / count)
    return float(np.sqrt((lowest**2 + highest**2) / 2 + place * (highest**2 - lowest**2) / 2))


def _projected_halves(pairs: list[tuple[tuple, float]], bases, both: bool) -> HalfCell:
    gap, finger = bases
    n, r = gap.shape
    rising_frame, falling_frame = (np.zeros((2 * n + PORTS, 2 * r + PORTS)) for _ in range(2))
    for frame, (left, right) in ((rising_frame, (gap, finger)), (falling_frame, (finger, gap))):
        frame[:n, :r], frame[n : 2 * n, r : 2 * r] = left, right
        frame[2 * n :, 2 * r :] = np.eye(PORTS)
    rising = np.stack([rising_frame.T @ each[0] @ rising_frame for each, _ in pairs])
    falling = np.stack([falling_frame.T @ each[1] @ falling_frame for each, _ in pairs]) if both else None
    return HalfCell(rising=rising, falling=falling, width=pairs[0][1])


def _wall_matrices(section: Section, frequency: float, stator: Stator, resolution: Resolution) -> np.ndarray:
    """Left and right end pieces on their inner lines, shape (2, n, n); columns graded towards singular corners."""
    n = section.size
    layers = resolution.edge_layers if "clamped" in (stator.ends, stator.bottom) else 0
    widths = graded(WALL_WIDTH, layers, largest=WALL_WIDTH / WALL_COLUMNS, ratio=CORNER_RATIO)
    columns = {width: condensed(section, frequency, width=width, comb=None) for width in widths}
    rows = [[columns[width] for width in order] for order in (widths[::-1], widths)]
    outer = np.arange(n)
    if stator.ends == "clamped":
        outer = np.setdiff1d(outer, section.mechanical)
    walls = []
    for row, outward, inner in ((rows[0], 0, n), (rows[1], n, 0)):
        piece = reduce(joined, row).matrix[: 2 * n, : 2 * n]
        here, there = inner + np.arange(n), outward + outer
        back = np.linalg.solve(piece[np.ix_(there, there)], piece[np.ix_(there, here)])
        walls.append(piece[np.ix_(here, here)] - piece[np.ix_(here, there)] @ back)
    return np.stack(walls)
