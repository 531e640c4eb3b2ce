"""The contacts of a scene with changed keys, on stators that are solved once and stored.

A change of the stator, its transducers or the frequency requires a new solution of the section and its circuit; a
change of the slider requires a new contact alone; voltage, power and burst require neither.
"""

import logging
import math
import time
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import fem
from studies.model import fem_objects
from studies.model.changed_scenes import ChangedScenes
from studies.model.contact import Contact
from studies.model.stator_alone import stator_alone
from studies.refusal import RunError, SceneError
from studies.scene import Scene
from studies.solve.contact_at_level import SHARE
from studies.solve.nearby_motion import POINTS
from studies.solve.ring_up import RingUp, ring_up
from studies.solve.solved_stator import SolvedStator
from studies.solve.spectrum import response
from studies.solve.surface_motion import SurfaceMotion, solved_motion, surface_motion
from studies.solve.travel import WaveAlong

LOGGER = logging.getLogger(__name__)
MAX_POSITIONS = 1_000_000  # of all solved stators in memory, about 300 MB
GAIN = 0.1  # tolerance of the stator at a step, over that of the step before
# Of the velocity's tolerance, for a stator solved in a band: a band that is one level finer costs half as much again,
# a second band costs twice as much
BAND_SHARE = 0.1


@dataclass(frozen=True, kw_only=True)
class Shared:
    """The positions and frequencies for which one solution of the stator, or of a band, is computed."""

    positions: tuple[tuple[float, float], ...] = ()  # (x, y) in m of all contacts
    # lowest and highest frequency in Hz, if there are enough of them to interpolate over a band
    limits: tuple[float, ...] = ()
    slider: bool | None = None  # True if it drives sliders; None: if the unchanged scene has one


class ChangedContacts(ChangedScenes):
    """The contacts of one scene with some of its keys changed.

    Parameters
    ----------
    table, numbers
        As of `ChangedScenes`.
    tolerance : float
        Of the velocity, over its reference speed.
    shared : Shared
        What one solution of the stator is computed for.
    coarse : bool
        True takes the stator's coarsest discretisation.
    as_run : bool
        True accepts a stator that misses its tolerance, with its error.
    """

    def __init__(
        self, table: dict, *, tolerance: float, shared: Shared = Shared(), coarse: bool = False, as_run: bool = False,
        numbers: dict | None = None,
    ) -> None:  # fmt: skip
        super().__init__(table, numbers)
        self.tolerance, self.coarse, self.as_run = tolerance, coarse, as_run
        self.slider = "slider" in table if shared.slider is None else shared.slider
        self.positions, self.limits = shared.positions, shared.limits
        self.nearby = False  # True evaluates the motion also within a quarter of a wavelength about each contact
        self.seconds = 0.0  # spent on stators
        self._count = 0
        self._solved: dict[tuple, SolvedStator | Exception] = {}
        self._latest: tuple[tuple | None, SurfaceMotion | Any] = (None, None)
        self._ring_up, self._band = lru_cache(64)(ring_up), lru_cache(4)(response)

    def contact(self, changes: dict, step: int = 0) -> Contact:
        """Return the contact with some keys changed; its stator is solved at a step, unless a solution is known.

        Raises
        ------
        SceneError
            If the text or the physics refuses a value.
        RunError
            If the stator misses its tolerance, or the model does not resolve the motion under a contact.
        """
        scene, stator = self.resolved(changes)
        if stator is None:
            return Contact.prescribed(scene)
        positions, shared = scene.positions, self.shared_positions(scene)
        try:
            solved = self._solution(stator, shared, step)
        except RunError:  # a position at a node of the wave must not fail the others
            if shared == positions:
                raise
            solved = self._solution(stator, positions, step)
        refusals = [solved.at[position].refusal for position in positions if solved.at[position].refusal]
        if refusals and scene.slider is not None:
            raise RunError(refusals[0])
        motion = self.motion(stator, positions, self._goal(stator, positions, step)) if scene.on_pillars else None
        return Contact.of_stator(scene, solved, motion)

    def motion(self, stator: Scene, positions: Any, goal: float) -> SurfaceMotion:
        """Return the surface motion of a `stator_alone` at positions (x, y) in m; only the latest is stored.

        ``goal``: allowed relative error.  RunError where it is missed, except in a run, which accepts the motion.
        """
        arguments = stator, positions, goal
        latest, motion = self._latest  # read once: a worker may have several threads
        if latest != arguments:
            self._count += 1
            LOGGER.info("stator" if self.as_run else f"stator {self._count}")  # a run has one
            start_time, solve = time.perf_counter(), fem.one_blas_thread(solved_motion)
            try:
                motion = solve(stator, positions, tolerance=goal, slider=self.slider, missed=self.as_run)
            finally:
                self.seconds += time.perf_counter() - start_time
            self._latest = arguments, motion
        return motion

    def motion_of(self, driven: Contact, step: int = 0) -> SurfaceMotion | None:
        """Return the surface motion along which a slider may travel; None if it may not, or on a prescribed wave."""
        if driven.solved is None or driven.scene.slider.travel is False:
            return None
        stator, positions = stator_alone(driven.scene), tuple(driven.solved.at)
        return self.motion(stator, positions, self._goal(stator, positions, step))

    def bursting(self, driven: Contact, motion: SurfaceMotion | None) -> Contact:
        """Return a contact with the ring-up of its burst and, given a motion, the orbits along the slider's travel."""
        slider, along = driven.scene.slider, None
        if motion is not None and driven.scene.burst is not None and slider.travel is not False:
            along = WaveAlong.under(driven.scene, motion)
        return replace(driven, ringing=self.ring_up(driven), along=along)

    def ring_up(self, driven: Contact) -> RingUp | None:
        """Return the ring-up of a burst; None with a prescribed wave and under a transducer."""
        center = driven.scene.slider.center
        if driven.scene.burst is None or driven.solved is None or driven.solved.at[center].covered:
            return None
        alone = stator_alone(driven.scene)
        bursting = replace(alone, drive=replace(alone.drive, burst=driven.scene.burst))
        return self._ring_up(bursting, center)

    def solve_together(self, many: Iterable[dict], step: int) -> None:
        """Solve the frequencies of one geometry side by side, where they make a band."""
        if len(self._solved) * max(1, len(self.positions)) * (POINTS if self.nearby else 1) > MAX_POSITIONS:
            self._solved.clear()
        groups: dict = {}
        for changes in many if self.limits else ():
            with suppress(SceneError):  # raised again when the point is answered
                scene, stator = self.resolved(changes)
                positions = self.shared_positions(scene)
                if self._in_band(stator, positions) and (stator, positions, step, self.nearby) not in self._solved:
                    fixed = replace(stator, drive=replace(stator.drive, frequency=self.limits[0]))
                    groups.setdefault((fixed, positions), {})[stator.frequency] = stator
        for (fixed, positions), stators in groups.items():
            start_time = time.perf_counter()
            # a band that fails leaves each of its stators to be solved alone, which says why it fails
            with suppress(RunError, ValueError, ArithmeticError, fem.ConvergenceError):
                along, goal = tuple(dict.fromkeys(x for x, _ in positions)), self._goal(fixed, positions, step)
                band = self._band(fixed, *self.limits, positions=along, tolerance=goal)
                waves = band.waves(list(stators), fem_objects.drive(fixed))
                for stator, wave in zip(stators.values(), waves, strict=True):
                    motion = surface_motion(wave, stator.stator, positions, slider=self.slider)
                    key = stator, positions, step, self.nearby
                    self._solved[key] = SolvedStator.of(motion, positions, nearby=self.nearby)
            self.seconds += time.perf_counter() - start_time

    def shared_positions(self, scene: Scene) -> tuple:
        """Return the positions for which the stator of a scene is solved: the shared ones if they contain its own."""
        own = scene.positions
        if scene.slider is None:
            return own
        # with all balls on the axis the plane section may be used, which has no motion off the axis
        off_axis, length = any(y for _, y in own), scene.stator.length
        shared = tuple((x, y) for x, y in self.positions if 0.0 <= x <= length and (off_axis or not y))
        return shared if set(own) <= set(shared) else own

    def _solution(self, stator: Scene, positions: Any, step: int) -> SolvedStator:
        """Return the stored solution of a stator, solved by `motion` if necessary, or raise its stored error."""
        key = stator, positions, step, self.nearby
        if key not in self._solved:
            try:
                motion = self.motion(stator, positions, self._goal(*key[:3]))
                self._solved[key] = SolvedStator.of(motion, positions, coarse=self.coarse, nearby=self.nearby)
            except Exception as error:
                self._solved[key] = error
        solution = self._solved[key]
        if isinstance(solution, Exception):
            raise solution.with_traceback(None)
        return solution

    def _in_band(self, stator: Scene, positions: Any) -> bool:
        """Return whether a stator is solved as one of a band: with frequency limits and without finite apertures."""
        plain = bool(self.limits) and not (stator.crossed or stator.piece)
        return plain and not fem_objects.spreads(stator.stator, positions if self.slider else None)

    def _goal(self, stator: Scene, positions: Any, step: int) -> float:
        """Return the allowed relative error of a stator at a step."""
        if self.coarse:
            return math.inf
        share = BAND_SHARE if self._in_band(stator, positions) else SHARE
        return self.tolerance * (share * GAIN**step if self.slider else 1.0)
