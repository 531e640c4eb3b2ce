"""A band of frequencies: full solutions at a few of them, a reduced model, and its error at the worst frequency.

Two errors add: the discretisation's, estimated from two levels at one frequency, and the reduction's, measured against
full solutions of the same discretisation at the nodes and between them.  Between reflecting ends resonances amplify
both by 1 / |1 - mu|, where mu is an eigenvalue of the segments' coupling (port_fields.py).  The errors measured at the
checked frequencies are therefore scaled to the sharpest resonance that the band can hold.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np

from fem.beam.line_source import LineSource, line_source
from fem.circuit import Circuit, Drive
from fem.condense.condensed_mesh import MeshedPiece
from fem.condense.electrode_conditions import is_port
from fem.condense.interpolated_piece import PieceSample, rational_piece
from fem.discretize.element_sizes import Resolution
from fem.discretize.mesh_refinement import GAIN, LEVELS, level_gain
from fem.exceptions import ConvergenceError, InputError
from fem.geometry import Stator, Transducer, outer_gaps
from fem.mesh.placement import is_step
from fem.parameters import refuse_if, refuses
from fem.reduce.projection import BandProblem, NodeSolutions, project, solve_at_nodes
from fem.reduce.reduced_model import ReducedModel
from fem.results.driven_answer import SurfaceWave, surface_wave
from fem.results.field_evaluation import surface_of
from fem.results.stator_solution import Solution, driven_solution
from fem.solve.driven_stator import (
    check_driven,
    driven_wave,
    motion_difference,
    refined_wave,
    solution_differences,
    solve_driven,
)
from fem.solve.full_band import FullModel
from fem.threads import one_blas_thread, side_by_side
from fem.waveguide.guided_modes import guided_modes
from fem.waveguide.line_force import LineForce
from fem.waveguide.port_fields import PortFields, StatorCascade, stator_cascade

# Singular values of the lines' fields below a share of the tolerance are dropped.  The share at the first attempt, at
# the last one, and the factor from one attempt to the next:
FIRST_TRUNCATION, LAST_TRUNCATION, TRUNCATION_STEP = 5e-2, 2e-4, 0.5
# Share of the error that one of two steps of the truncation must remove; without it the interpolation between the nodes
# decides, which further fields do not change.  A single step may add fields that do not matter alone.
GAIN_OF_STEP = 0.02
MAX_TRUNCATION = 1e-4  # relative singular value, for loose tolerances
REDUCTION_SHARE = 0.5  # of the tolerance, for the reduction's error; the rest is the discretisation's
# Up to this share of the tolerance in the discretisation's error, more nodes are tried before a finer discretisation
MAX_LEVEL_SHARE = 0.95
WHOLE_SHARE = 0.1  # of the tolerance, for the interpolation of a stator of one mesh
REDUCTION_SAFETY = 2.0  # a difference at a check counts so many times: between the checks the reduction may err more
# The estimate from two levels exceeds the true error by at least this factor: a level divides the error by 11 to 25,
# and the estimate counts on GAIN = 8 only.
ESTIMATE_EXCESS = 2.0
# Share of the gain between the two levels before that is expected of the next one, and the largest gain that is counted
# on: 11 to 25 were seen (`fem.discretize.mesh_refinement.GAIN`).  Errors of bands: `tests/benchmarks/band_error.py`
SEEN_SHARE, MAX_SEEN_GAIN = 0.5, 11.0
MAX_ROUNDS = 3  # discretisations that are tried
ROUNDING = 1e-12  # of sums of errors, over the tolerance


@refuses(InputError)
def refuse_outside(limits: tuple[float, float], frequency: float, *, ends: bool = True) -> Iterator[Any]:
    """Raise an InputError for a frequency outside a band, in Hz; ``ends``: True if the limits belong to it."""
    low, high = limits
    if not low <= frequency <= high or (frequency in limits and not ends):
        yield "frequency", f"must lie in the band, {low:g} to {high:g} Hz", frequency, "Hz"


@dataclass(frozen=True, kw_only=True)
class Band:
    """A stator prepared for any frequency of a band; make it with `frequency_band`.

    Attributes
    ----------
    model : ReducedModel
    relative_error, admittance_error : float
        Of the surface motion at the requested positions and of the admittance, at the worst frequency of the band.
    """

    model: ReducedModel | FullModel = field(repr=False)
    relative_error: float
    admittance_error: float

    @property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest frequency in Hz."""
        return self.model.limits

    @property
    def port_names(self) -> tuple[str, ...]:
        """Transducers that are ports, from left to right."""
        return tuple(each.name for each in self.model.transducers if is_port(each))

    def wave(self, frequency: float, drive: str | Drive) -> SurfaceWave:
        """Surface motion at a frequency of the band (Hz).

        The motion under a transducer or beside a free or clamped end, the interior field and the power balance are
        computed on first access, which takes the time of one condensation.
        """
        return surface_wave(
            driven_solution(self.port_fields(frequency), drive),
            relative_error=self.relative_error,
            admittance_error=self.admittance_error,
            solve=lambda: driven_solution(self.port_fields(frequency), drive),
        )

    def waves(self, frequencies: np.ndarray, drive: str | Drive) -> list[SurfaceWave]:
        """Surface motion at many frequencies of the band (Hz), in their order, side by side."""
        return side_by_side(lambda frequency: self.wave(float(frequency), drive), frequencies)

    def admittances(
        self, frequencies: np.ndarray, solve: Callable[[StatorCascade], PortFields] = StatorCascade.solved
    ) -> np.ndarray:
        """Admittance matrix of all ports in S at frequencies of the band (Hz), shape (frequencies, ports, ports).

        ``solve`` replaces the solver of the section's network, for instance by `fem.beam.reception.aperture_solver`.
        """

        def at(frequency: float) -> np.ndarray:
            return self.port_fields(float(frequency), solve=solve).admittances

        return np.array(side_by_side(at, frequencies))

    def forced(self, frequencies: np.ndarray, force: LineForce, drive: str | Drive) -> list[Circuit]:
        """Currents and voltages of the transducers, as in `port_names`, that a line force causes at each frequency.

        The sources of ``drive`` have zero voltage; their impedances, and the other terminations, stay.  By reciprocity
        the current into the driven transducer is the velocity at the force, per volt, times force and aperture.  It
        errs as that: by `relative_error`, if the force stands at one of the positions that the band was prepared for.
        """

        def at(frequency: float) -> Circuit:
            fields = self.port_fields(float(frequency), forces=(force,))
            return driven_solution(fields, drive, np.array([force.amplitude])).circuit

        return side_by_side(at, frequencies)

    def port_fields(
        self,
        frequency: float,
        forces: tuple[LineForce, ...] = (),
        solve: Callable[[StatorCascade], PortFields] = StatorCascade.solved,
    ) -> PortFields:
        """Fields of the ports at a frequency of the band (Hz), with line forces; ``solve`` as of `admittances`.

        Those of the reduced model or, if its few lines cannot represent the ends, of the full discretisation.
        """
        model = self.model
        refuse_outside(self.limits, frequency)
        try:
            return solve(model.cascade(frequency, forces))
        except ConvergenceError:
            stator, transducers = model.stator, model.transducers
            return solve(
                stator_cascade(stator, transducers, frequency=frequency, resolution=model.resolution, forces=forces)
            )


@one_blas_thread
def frequency_band(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    *,
    lowest: float,
    highest: float,
    drive: str | Drive,
    tolerance: float,
    places: tuple[float, ...] = (),
    charges: bool = False,
) -> Band:
    """Prepare a driven stator for the frequencies of a band.

    Parameters
    ----------
    stator : Stator
    transducers : tuple of Transducer
        Each needs half a gap of bare surface on either side.
    lowest, highest : float
        Hz.
    drive : str or Drive
        The error is estimated for this drive; `Band.wave` takes any other.
    tolerance : float
        Relative, of the surface motion at ``places`` at every frequency of the band.
    places : tuple of float
        m; mid-stator if empty.
    charges : bool
        True interpolates the charges on the fingers too, for `fem.beam_band`.

    Raises
    ------
    ConvergenceError
        If the tolerance is not met; its ``reached`` is the band with the error that it has.
    """
    refuse_if(
        not 0 < lowest < highest < np.inf,
        "band",
        f"must run from a lower to a higher frequency, got {lowest!r} to {highest!r} Hz",
    )
    check_driven(stator, transducers, highest, tolerance)
    transducers = tuple(sorted(transducers, key=lambda transducer: transducer.center))
    _refuse_narrow_gaps(stator, transducers)
    problem = BandProblem(
        stator=stator,
        transducers=transducers,
        limits=(lowest, highest),
        drive=drive,
        tolerance=tolerance,
        positions=np.array(places or (stator.length / 2,)),
        charges=charges,
    )
    placed = stator.placement
    steps = any(end is not None and is_step(end, stator.depth) for end in placed.ends)
    unreduced = steps or placed.whole is not None
    level_share = (1 - REDUCTION_SHARE) * tolerance
    level_tolerance = tolerance
    solved: dict[Resolution, Solution] = {}
    for _ in range(MAX_ROUNDS):
        if unreduced:
            band, level_error = _unreduced_attempt(problem, level_tolerance)
        else:
            band, level_error = _attempt(problem, level_tolerance, solved)
        if band.relative_error <= tolerance:
            return band
        if not (unreduced or problem.more_nodes) and level_error <= MAX_LEVEL_SHARE * tolerance:
            problem, solved = replace(problem, more_nodes=True), {}
            continue
        if level_error <= level_share:
            break  # a finer discretisation would not help
        level_tolerance *= level_share / level_error
    raise ConvergenceError(
        f"the stator's surface motion in the band is known to {band.relative_error:.4g} only, {tolerance:g} was "
        "asked for: ask for less, give the solid a lower mechanical_quality, or solve one frequency at a time",
        reached=band,
    )


def _refuse_narrow_gaps(stator: Stator, transducers: tuple[Transducer, ...]) -> None:
    """Raise an InputError for uneven fingers, or less than half a gap of bare surface beside a transducer."""
    for transducer in transducers:
        if not (transducer.even and transducer.uniform_along_y):
            rule = "must have equal fingers, equally spaced, in a band of frequencies: solve one at a time"
            raise InputError("transducer", rule, owner=transducer.name)
    for transducer, gaps in zip(transducers, outer_gaps(stator, transducers), strict=True):
        refuse_if(
            min(gaps) < (1 - 1e-9) * transducer.half_gap,
            "transducer",
            f"needs in a band half a gap of bare surface on either side, {transducer.half_gap:g} m, and has "
            f"{min(gaps):g} m",
            owner=transducer.name,
        )


def _unreduced_attempt(problem: BandProblem, level_tolerance: float) -> tuple[Band, float]:
    """Band without reduced lines, for a step of thickness or a stator of one mesh, and its discretisation's error.

    The discretisation is the finest of those that meet the tolerance at three frequencies.
    """
    (low, high), drive, stator = problem.limits, problem.drive, problem.stator
    options = {"drive": drive, "tolerance": level_tolerance, "places": tuple(problem.positions)}
    waves = [
        driven_wave(stator, problem.transducers, frequency=frequency, **options)
        for frequency in (low, (low + high) / 2, high)
    ]
    finest = max((wave.solution.fields.resolution for wave in waves), key=lambda resolution: resolution.order)
    model = FullModel(stator=stator, transducers=problem.transducers, limits=problem.limits, resolution=finest)
    if stator.placement.whole is None:
        checks = [_Check.of(problem, wave.solution) for wave in waves]
        here, worst = [check.here for check in checks], max(check.worst for check in checks)
    else:
        fields = (wave.solution.fields for wave in waves)
        here, worst = _closed_amplification(
            [each if each.resolution == finest else model.cascade(each.frequency).solved() for each in fields]
        )
    growth = [max(1.0, worst / each / ESTIMATE_EXCESS) for each in here]
    level_error, admittance_error = (
        max(more * getattr(wave, name) for more, wave in zip(growth, waves, strict=True))
        for name in ("relative_error", "admittance_error")
    )
    interpolation_error = 0.0
    if stator.placement.whole is not None and level_error <= problem.tolerance:
        potentials = waves[0].solution.fields.network.scatterers[0].potentials
        model, interpolation_error = model.interpolated(potentials, problem.positions, WHOLE_SHARE * problem.tolerance)
    band = Band(
        model=model,
        relative_error=level_error + interpolation_error,
        admittance_error=admittance_error + interpolation_error,
    )
    return band, level_error


def _closed_amplification(nodes: list[PortFields]) -> tuple[list[float], float]:
    """Resonant amplification of a stator of one mesh at some frequencies, and the largest between them.

    Near a resonance p of omega^2 the motion goes as 1 / (p - omega^2), so that a relative error of p has
    |p / (p - omega^2)| times the effect.
    """
    scatterers = [each.network.scatterers[0] for each in nodes]
    pieces = [each.piece for each in scatterers if isinstance(each.piece, MeshedPiece)]
    frame = scatterers[0].potentials
    samples = [PieceSample.of(each, frame) for each in pieces]
    resonances = rational_piece(pieces[0], frame, 0, samples).resonances
    squares = np.array([(2 * np.pi * each.frequency) ** 2 for each in nodes])
    nearest = np.clip(resonances.real, squares.min(), squares.max())

    def amplification(square: np.ndarray | float) -> float:
        with np.errstate(divide="ignore"):
            return float(np.max(abs(resonances / (resonances - square)), initial=1.0))

    return [amplification(square) for square in squares], amplification(nearest)


def _attempt(problem: BandProblem, level_tolerance: float, solved: dict[Resolution, Solution]) -> tuple[Band, float]:
    """Band on the discretisation that meets a tolerance at one frequency, and that discretisation's largest error.

    ``solved``: the solutions at this frequency.
    """
    while True:
        wave = refined_wave(
            problem.stator,
            problem.transducers,
            frequency=problem.between_nodes,
            drive=problem.drive,
            tolerance=level_tolerance,
            places=tuple(problem.positions),
            solved=solved,
        )
        between = _Check.of(problem, wave.solution)
        level_error = between.growth(between.worst) * wave.relative_error
        if level_error <= problem.tolerance or wave.solution.fields.resolution == LEVELS[-1]:
            break
        # no nodes are solved on a discretisation that is too coarse already by this one frequency
        level_tolerance *= (1 - REDUCTION_SHARE) * problem.tolerance / level_error
    nodes = solve_at_nodes(problem, wave.solution.fields.resolution)
    checks = [between, *(_Check.of(problem, solution) for solution in nodes.solutions)]
    worst = max(check.worst for check in checks)
    errors = level_bounds(problem, checks, (wave.relative_error, wave.admittance_error))
    known = errors_by_finer_level(problem, checks)
    reach = level_gain(problem.stator) * problem.tolerance
    errors = sharpened(errors, problem.tolerance, reach, known)
    model, motion_error, admittance_error = reduced_model(
        problem, nodes, checks, worst, problem.tolerance - errors[:, 0].max()
    )
    # an error of a piece's matrix acts through the waves that the piece sends back
    piece_error = max(1.0, worst / between.here) * model.piece_error
    # the bounds are lowered no further than the reduction's error requires: between the checks the error may be larger
    limit = remaining(problem.tolerance, motion_error, piece_error)
    seen, attainable = bounds_by_gain_seen(problem, checks, errors), limit * (MAX_SEEN_GAIN - 1) / (GAIN - 1)
    errors = sharpened(errors, limit, attainable, seen, least=limit)
    errors = sharpened(errors, limit, reach, known, least=limit)
    level_error, level_admittance_error = errors.max(axis=0)
    band = Band(
        model=model,
        relative_error=level_error + motion_error + piece_error,
        admittance_error=level_admittance_error + admittance_error + piece_error,
    )
    return band, float(level_error)


def remaining(tolerance: float, *errors: float) -> float:
    """What errors leave of a tolerance, smaller by a little, so that its sum with them never exceeds the tolerance.

    Without that, rounding would decide whether bounds that are lowered to this value meet the tolerance.

    Examples
    --------
    >>> 1e-4 - 8.1e-6 + 8.1e-6 > 1e-4, remaining(1e-4, 8.1e-6) + 8.1e-6 > 1e-4
    (True, False)
    """
    return tolerance * (1 - ROUNDING) - sum(errors)


def level_differences(problem: BandProblem, check: "_Check", other: int) -> np.ndarray:
    """Differences in motion and admittance of a check's solution from that of the level number ``other``."""
    solution = solve_driven(
        problem.stator,
        problem.transducers,
        frequency=check.solution.fields.frequency,
        drive=problem.drive,
        resolution=LEVELS[other],
    )
    pair = (check.solution, check.motion), (solution, surface_of(solution).motion(problem.positions))
    return np.array(solution_differences(*pair))


def level_bounds(problem: BandProblem, checks: list["_Check"], between: tuple[float, float]) -> np.ndarray:
    """Upper bounds of the discretisation's errors, shape (checks, 2), motion and admittance at the worst frequency.

    ``between``: errors at the first check; at the others the level before is solved too, because the motion may be
    small there.
    """
    worst, gain = max(check.worst for check in checks), level_gain(problem.stator)
    before = LEVELS.index(checks[0].solution.fields.resolution) - 1
    estimates = side_by_side(lambda check: level_differences(problem, check, before) / (gain - 1), checks[1:])
    return np.array(
        [check.growth(worst) * np.array(each) for check, each in zip(checks, [between, *estimates], strict=True)]
    )


def errors_by_finer_level(problem: BandProblem, checks: list["_Check"]) -> Callable[[int], np.ndarray]:
    """Function of a check's number: errors as in `level_bounds`, from the finer level; each is solved once at most."""
    worst, gain = max(check.worst for check in checks), level_gain(problem.stator)
    finer = LEVELS.index(checks[0].solution.fields.resolution) + 1

    @cache
    def known(number: int) -> np.ndarray:
        if finer == len(LEVELS):
            return np.full(2, np.inf)
        amplified = max(1.0, worst / checks[number].here)
        return amplified * level_differences(problem, checks[number], finer) * gain / (gain - 1)

    return known


def bounds_by_gain_seen(
    problem: BandProblem, checks: list["_Check"], bounds: np.ndarray
) -> Callable[[int], np.ndarray]:
    """Function of a check's number: its ``bounds``, that of the motion with the gain of the levels seen at the check.

    It takes the level before the two that are known, a fraction of the time of the finer one.  With
    |a_1 - a_2| >= |a_1 - a_3| - |a_2 - a_3| the gain seen is at least |a_1 - a_3| / |a_2 - a_3| - 1; half of it is
    expected of the next level.  Only for stators whose levels have the usual gain.
    """
    coarser = LEVELS.index(checks[0].solution.fields.resolution) - 2
    worst = max(check.worst for check in checks)

    @cache
    def by_gain_seen(number: int) -> np.ndarray:
        motion, admittance = bounds[number]
        if coarser < 0 or level_gain(problem.stator) < GAIN:
            return np.array([motion, admittance])
        check = checks[number]
        last = (GAIN - 1) * motion / check.growth(worst)  # |a_2 - a_3|
        seen = level_differences(problem, check, coarser)[0] / last - 1
        gain = float(np.clip(SEEN_SHARE * seen, GAIN, MAX_SEEN_GAIN))
        return np.array([motion * (GAIN - 1) / (gain - 1), admittance])

    return by_gain_seen


def sharpened(
    bounds: np.ndarray, limit: float, reach: float, known: Callable[[int], np.ndarray], least: float = 0.0
) -> np.ndarray:
    """Bounds of `level_bounds`, of which those of the motion above a limit are replaced by what a finer level shows.

    The difference from the finer level (``known``) is the error itself, where that from the level before is its upper
    bound.  The finer level is solved at one check after the other, the worst first, as long as the limit can be met:
    not for bounds above ``reach``.  An error that it shows counts as ``least`` at least, if its bound is above that.
    """
    errors = bounds.copy()
    for _ in errors:
        largest = int(np.argmax(errors[:, 0]))
        if not limit < errors[largest, 0] < reach or known(largest)[0] >= errors[largest, 0]:
            break
        errors[largest] = np.minimum(errors[largest], np.maximum(known(largest), least))
    return errors


@dataclass(frozen=True, kw_only=True)
class _Check:
    """A full solution that the reduced model must reproduce.

    ``here`` and ``worst``: resonant amplification at its frequency and at the worst frequency near it.
    """

    solution: Solution
    motion: np.ndarray
    here: float
    worst: float

    @classmethod
    def of(cls, problem: BandProblem, solution: Solution) -> "_Check":
        here, worst = resonant_amplification(solution, problem.limits)
        return cls(solution=solution, motion=surface_of(solution).motion(problem.positions), here=here, worst=worst)

    def growth(self, worst: float) -> float:
        """Factor from an estimate of two levels at this frequency to where resonances amplify by ``worst``."""
        return max(1.0, worst / self.here / ESTIMATE_EXCESS)


def resonant_amplification(solution: Solution, limits: tuple[float, float]) -> tuple[float, float]:
    """Resonant amplification at one of the checked frequencies of a band, and at the worst frequency near it.

    The checks lie in the middle and near both ends: no frequency is farther than a third of the band from one.
    """
    surface, (low, high) = surface_of(solution), limits
    phase_range = 2 * np.pi * (high - low) / 3 * surface.length / surface.phase_velocity
    return solution.fields.amplification(min(phase_range, np.pi))


def reduction_growth(here: float, worst: float) -> float:
    """Factor from the difference of reduced and full model at a frequency to the error of the reduced one in a band.

    ``here``, ``worst``: how much resonances amplify at that frequency, and at most in the band.
    """
    return worst / min(here, worst / REDUCTION_SAFETY)


def reduced_model(
    problem: BandProblem, nodes: NodeSolutions, checks: list[_Check], worst: float, motion_allowance: float
) -> tuple[ReducedModel, float, float]:
    """Project on the fewest fields that reproduce the checks; return the model and its errors of motion and admittance.

    ``motion_allowance``: tolerance minus the error of the discretisation.  If it is not positive, a finer
    discretisation will follow, and the usual share of the tolerance is used.
    """
    share = REDUCTION_SHARE * problem.tolerance
    allowed = np.array([motion_allowance if motion_allowance > 0 else share, share])
    truncation, size = min(FIRST_TRUNCATION * problem.tolerance, MAX_TRUNCATION), 0
    reached: list[np.ndarray] = []
    while True:
        last = truncation <= LAST_TRUNCATION * min(problem.tolerance, 1e-3)
        model = project(problem, nodes, truncation)
        truncation *= TRUNCATION_STEP
        if model.section.size == size and not last:
            continue
        size = model.section.size
        try:
            errors = np.array(reduction_errors(model, problem, checks, worst))
            sent = sent_wave_error(model, problem, checks, worst) if problem.charges else 0.0
        except ConvergenceError:  # too few fields to represent the ends
            if last:
                raise
            errors, sent = np.full(2, np.inf), 0.0
        too_large = errors > allowed
        *_, before, last_but_one = np.full(2, np.inf), np.full(2, np.inf), *reached
        stagnant = np.minimum(errors, last_but_one) > (1 - GAIN_OF_STEP) * before
        # the error by a spurious mode does not stagnate: the mode comes and goes with the number of fields
        if last or (stagnant[too_large].all() and sent <= allowed[0]):
            return model, max(float(errors[0]), sent), float(errors[1])
        reached.append(errors)


def sent_wave_error(model: ReducedModel, problem: BandProblem, checks: list[_Check], worst: float) -> float:
    """Largest relative error of the motion at the positions by line charges, 1 on fingers "+" and -1 on fingers "-".

    The charges lie on the bare surface in the middle of each finger.  The section's own motion does not show this
    error, because charges and modes are there those of the same reduced lines.  In a beam each charge sends the modes
    at any angle, so that their shapes count, which err more than their wavenumbers, and spurious modes of the reduced
    lines, which the section does not have.
    """
    errors = [0.0]
    for each in checks:
        full = each.solution.fields.modes
        sources = [line_source(modes, "charge") for modes in (full, guided_modes(model.section, full.frequency))]
        for transducer in problem.transducers:
            charges = np.array([{"+": 1.0, "-": -1.0}.get(sign, 0.0) for sign in transducer.signs])
            distances = abs(np.subtract.outer(problem.positions, transducer.fingers.mean(axis=1)))
            if charges.any():
                motions = (_plane_motion(source, distances, charges) for source in sources)
                errors.append(reduction_growth(each.here, worst) * motion_difference(*motions))
    return max(errors)


def _plane_motion(source: LineSource, distances: np.ndarray, charges: np.ndarray) -> np.ndarray:
    """u_x and u_z in the section, (2, positions), by line charges at distances (positions, charges) on one side."""
    waves = np.exp(-1j * np.multiply.outer(source.wavenumbers, distances)) @ charges
    return np.array([source.tangential, source.normal]) @ waves


def reduction_errors(
    model: ReducedModel, problem: BandProblem, checks: list[_Check], worst: float
) -> tuple[float, float]:
    """Relative errors of a reduced model's motion and admittance at the worst frequency of the band.

    Each check compares the model with a full solution at its frequency, where resonances amplify by ``check.here``; at
    the worst frequency they amplify by ``worst``.  A difference counts at least `REDUCTION_SAFETY` times.  Between the
    resonances most of the admittance is that of the static capacitance, and hides the resonant part's error: at a
    resonance the admittance may err by the square of the amplification, but not more than the motion does.
    """
    both = []
    for check in checks:
        solution = driven_solution(model.cascade(check.solution.fields.frequency).solved(), problem.drive)
        reduced = solution, surface_of(solution).motion(problem.positions)
        growth = reduction_growth(check.here, worst)
        of_motion, of_admittance = (
            growth * each for each in solution_differences(reduced, (check.solution, check.motion))
        )
        hidden = min(of_admittance * max(1.0, worst / check.here), of_motion)
        both.append((of_motion, max(of_admittance, hidden)))
    motion_error, admittance_error = (float(error) for error in np.max(both, axis=0))
    return motion_error, admittance_error
