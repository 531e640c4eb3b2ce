"""Solved stators of one motor: each is solved once, and serves every slider and level that stands on it.

A change of the stator, its transducers or the frequency requires a new solution of the section and its circuit; a
change of the slider requires a new contact alone; voltage, power and burst require neither.
"""

import logging
import math
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import fem
from studies.model.model import Model
from studies.model.wave_to_contact import Contact
from studies.record.waveform import modulation
from studies.refusal import RunError, SceneError
from studies.scene import Scene
from studies.solve.motion_band import motion_bands, solved_in_bands
from studies.solve.nearby_motion import POINTS
from studies.solve.refinement import BAND_SHARE, SHARE
from studies.solve.ring_up import RingUp, ring_up
from studies.solve.solved_stator import SolvedStator
from studies.solve.surface_motion import SurfaceMotion, solved_motion
from studies.solve.travel import WaveAlong

LOGGER = logging.getLogger(__name__)
MAX_POSITIONS = 1_000_000  # of all solved stators in memory, about 300 MB
# What is stored as the outcome of a solution: an answer is refused or not found. What memory has ended may succeed
# later, and a defect keeps its traceback
STORED_ERRORS = (SceneError, RunError)
BAND_ERRORS = (*STORED_ERRORS, ValueError, ArithmeticError, fem.ConvergenceError)


@dataclass(frozen=True, kw_only=True)
class Shared:
    """The positions and frequencies for which one solution of the stator, or of a band, is computed."""

    positions: tuple[tuple[float, float], ...] = ()  # (x, y) in m of all contacts
    # lowest and highest frequency in Hz, if there are enough of them to interpolate over a band
    limits: tuple[float, ...] = ()
    frequencies: int = 0  # number of them
    slider: bool | None = None  # True if it drives sliders; None: if the unchanged scene has one


UNSHARED = Shared()


class Stators:
    """Solved stators, and the contacts of resolved scenes on them.

    A stator is the model of a stator alone (`Model.alone`), a goal the allowed relative error of its section. A
    solution that misses its goal is used, with its error.

    Parameters
    ----------
    tolerance : float
        Of the velocity, over its reference speed; without a slider, of the amplitude.
    slider : bool
        True if the stators drive sliders.
    shared : Shared
        What one solution of the stator is computed for.
    coarse : bool
        True takes the stator's coarsest discretisation.
    """

    def __init__(self, *, tolerance: float, slider: bool, shared: Shared = UNSHARED, coarse: bool = False) -> None:
        self.tolerance, self.slider, self.coarse = tolerance, slider, coarse
        self.positions, self.limits, self.frequencies = shared.positions, shared.limits, shared.frequencies
        self.nearby = False  # True evaluates the motion also within a quarter of a wavelength about each contact
        self.seconds = 0.0  # spent on stators
        self._count = 0
        self._solved: dict[tuple, SolvedStator | Exception] = {}
        self._latest: tuple[tuple | None, SurfaceMotion | Any] = (None, None)
        self._ring_up, self._bands = lru_cache(64)(ring_up), lru_cache(4)(_motion_bands)
        self._solved_in_bands = lru_cache(1024)(solved_in_bands)
        self._others = lru_cache(4)(self._solved_motion)  # at further frequencies of the sources

    def contact(self, model: Model, goal: float | None = None) -> Contact:
        """Return the contact of a resolved scene on its stator or its prescribed wave.

        ``goal``: of the section; by default `first_goal`. RunError if the stator has no solution.
        """
        if model.scene.wave is not None:
            return Contact.prescribed(model)
        stator, own, positions = model.alone, model.scene.positions, self.shared_positions(model.scene)
        try:
            solved = self._solution(stator, positions, goal, missed=positions == own)
        except RunError:  # a position at a node of the wave must not fail the others
            if positions == own:
                raise
            positions = own
            solved = self._solution(stator, own, goal)
        missed = positions == own or bool(self.limits)  # of a band the solution is not that of `motion`
        driven = Contact.of_stator(model, solved, lambda: self.motion(stator, positions, goal, missed))
        if model.scene.planar:
            from studies.solve.plane_surface import with_surface

            def solve(one: Model) -> SurfaceMotion:
                if one is stator:
                    return self.motion(one, positions, goal, missed)
                return self._others(one, positions, goal)

            return with_surface(driven, solve)
        return driven

    def motion(self, stator: Model, positions: Any, goal: float | None = None, missed: bool = True) -> SurfaceMotion:
        """Return the surface motion of a stator at positions (x, y) in m; only the latest is stored.

        ``missed``: True returns a motion that misses its goal, with its error; False raises RunError.
        """
        arguments = stator, positions, self.first_goal(stator, positions) if goal is None else goal, missed
        latest, motion = self._latest  # read once: a worker may have several threads
        if latest != arguments:
            self._count += 1
            LOGGER.info("stator" if self._count == 1 else f"stator {self._count}")
            motion = self._solved_motion(*arguments)
            self._latest = arguments, motion
        return motion

    def _solved_motion(self, stator: Model, positions: Any, goal: float | None, missed: bool = True) -> SurfaceMotion:
        start_time, solve = time.perf_counter(), fem.one_blas_thread(solved_motion)
        goal = self.first_goal(stator, positions) if goal is None else goal
        try:
            return solve(stator, positions, tolerance=goal, slider=self.slider, missed=missed)
        finally:
            self.seconds += time.perf_counter() - start_time

    def motion_under(self, driven: Contact) -> SurfaceMotion:
        """Return the surface motion from which a contact on a stator was made."""
        solved = driven.solved
        positions = tuple(solved.at)
        return self.motion(driven.model.alone, positions, solved.goal, positions == driven.scene.positions)

    def bursting(self, driven: Contact) -> Contact:
        """Return a contact with the ring-up of its burst and the orbits along the slider's travel."""
        scene, along = driven.scene, None
        if scene.burst is None or driven.solved is None:
            return driven
        if scene.planar:
            return self._rising(driven)
        motion = None if scene.slider.travel is False else self.motion_under(driven)
        start_time = time.perf_counter()
        if motion is not None:
            along = WaveAlong.under(driven.model, motion)
        ringing = self.ring_up(driven)
        self.seconds += time.perf_counter() - start_time
        return replace(driven, ringing=ringing, along=along)

    def _rising(self, driven: Contact) -> Contact:
        """Return the contact of a slider in the plane with the ring-up of each frequency of its sources."""
        from studies.solve.plane_burst import Rise

        center, drive, start_time = driven.scene.slider.center, driven.scene.drive, time.perf_counter()
        if driven.solved.at[driven.scene.positions[0]].covered:
            _refuse_waveform(driven)
            return driven
        rings = []
        for each in (driven.model.alone_with(drive.at_frequency(frequency)) for frequency in drive.frequencies):
            bursting = each.with_blocks(drive=replace(each.scene.drive, burst=drive.burst, waveform=drive.waveform))
            rings.append(self._ring_up(bursting, center))
        self.seconds += time.perf_counter() - start_time
        shaped = () if modulation(driven.scene) is None else drive.frequencies
        return replace(driven, ringing=Rise(rings=tuple(rings), duration=driven.scene.burst, shaped=shaped))

    def ring_up(self, driven: Contact) -> RingUp | None:
        """Return the ring-up of a burst; None under a transducer."""
        center, alone = driven.scene.slider.center, driven.model.alone
        if driven.solved.at[center].covered:
            _refuse_waveform(driven)
            return None
        drive = replace(alone.scene.drive, burst=driven.scene.burst, waveform=driven.scene.drive.waveform)
        return self._ring_up(alone.with_blocks(drive=drive), center)

    def know(self, stator: Model, positions: Any, motion: SurfaceMotion) -> None:
        """Take a solved motion at positions (x, y) in m as the solution for the first goal."""
        goal = self.first_goal(stator, positions)
        self._latest = (stator, positions, goal, True), motion
        self._solution(stator, positions, goal)

    def solve_together(self, many: Iterable[tuple[Model, float | None]]) -> None:
        """Solve the frequencies of one geometry side by side, where they make a band.

        ``many``: resolved model and goal of each contact.
        """
        if len(self._solved) * max(1, len(self.positions)) * (POINTS if self.nearby else 1) > MAX_POSITIONS:
            self._solved.clear()
        groups: dict = {}
        keys_met: set[tuple] = set()
        for model, goal in many if self.limits else ():
            stator, positions = model.alone, self.shared_positions(model.scene)
            goal = self.first_goal(stator, positions) if goal is None else goal
            key = self._key(stator, positions, goal, positions == model.scene.positions)
            if key in self._solved or key in keys_met:
                continue
            keys_met.add(key)
            if self._in_band(stator, positions):
                drive = replace(stator.scene.drive, frequency=self.limits[0])
                group = stator.with_blocks(drive=drive), positions, goal
                groups.setdefault(group, {})[stator.scene.frequency] = key
        for (fixed, positions, goal), keys in groups.items():
            start_time = time.perf_counter()
            # a band that fails leaves each of its stators to be solved alone, which says why it fails
            with suppress(*BAND_ERRORS):
                solved = self._solved_together(fixed, positions, goal, list(keys))
                self._solved.update(zip(keys.values(), solved, strict=True))
            self.seconds += time.perf_counter() - start_time

    def _solved_together(
        self, stator: Model, positions: Any, goal: float, frequencies: list[float]
    ) -> list[SolvedStator]:
        """Return the solutions of a stator at several frequencies in Hz, from its bands."""
        motion = self._bands(stator, self.limits, positions, goal, self.slider)
        if isinstance(motion, Exception):
            raise motion.with_traceback(None)

        def solved(frequency: float) -> SolvedStator:
            return SolvedStator.of(motion(frequency), positions, goal=goal, nearby=self.nearby)

        return fem.side_by_side(solved, frequencies)

    def shared_positions(self, scene: Scene) -> tuple:
        """Return the positions for which the stator of a scene is solved: the shared ones if they contain its own."""
        own = scene.positions
        if scene.slider is None:
            return own
        # with all balls on the axis the plane section may be used, which has no motion off the axis
        off_axis, length = any(y for _, y in own), scene.stator.length
        shared = tuple((x, y) for x, y in self.positions if 0.0 <= x <= length and (off_axis or not y))
        return shared if set(own) <= set(shared) else own

    def first_goal(self, stator: Model, positions: Any) -> float:
        """Return the goal of the first solution of a stator."""
        if self.coarse:
            return math.inf
        share = BAND_SHARE if self._in_band(stator, positions) else SHARE
        return self.tolerance * (share if self.slider else 1.0)

    def _solution(self, stator: Model, positions: Any, goal: float | None, missed: bool = True) -> SolvedStator:
        """Return the stored solution of a stator, solved by `motion` if necessary, or raise its stored error."""
        goal = self.first_goal(stator, positions) if goal is None else goal
        key = self._key(stator, positions, goal, missed)
        if key not in self._solved:
            try:
                motion = self.motion(stator, positions, goal, missed)
                self._solved[key] = SolvedStator.of(
                    motion, positions, goal=goal, coarse=self.coarse, nearby=self.nearby
                )
            except STORED_ERRORS as error:
                self._solved[key] = error
        solution = self._solved[key]
        if isinstance(solution, Exception):
            raise solution.with_traceback(None)
        return solution

    def _key(self, stator: Model, positions: Any, goal: float, missed: bool) -> tuple:
        return stator, positions, goal, missed, self.nearby

    def _in_band(self, stator: Model, positions: Any) -> bool:
        """Return whether a stator is solved as one of a band of frequencies."""
        if not self.limits:
            return False
        return self._solved_in_bands(stator, positions, slider=self.slider, frequencies=self.frequencies)


def _motion_bands(
    stator: Model, limits: tuple[float, ...], positions: Any, goal: float, slider: bool
) -> Callable[[float], SurfaceMotion] | Exception:
    """Return `motion_bands`, or why there are none, so that what fails is tried once."""
    try:
        return motion_bands(stator, limits, positions, tolerance=goal, slider=slider)
    except BAND_ERRORS as error:
        return error


def _refuse_waveform(driven: Contact) -> None:
    """Raise a SceneError where a burst has a waveform and the response under the slider is not known over a band."""
    if driven.scene.drive.waveform is not None:
        rule = "must be absent where the slider stands over a transducer or a meshed piece"
        driven.scene.refuse("drive.waveform", f"{rule}: the response there is not computed over a band")
