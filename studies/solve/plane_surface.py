"""The waves below a slider in the plane on a stator: one solution of the stator for each frequency of its sources."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import Any

import fem
from studies.model.model import Model, model_of
from studies.model.plane import StatorSurface
from studies.model.wave_to_contact import Contact
from studies.record import Record
from studies.solve.refinement import SHARE
from studies.solve.surface_motion import SurfaceMotion, solved_motion

Solve = Callable[[Model], SurfaceMotion]  # returns the motion of a stator with one frequency


def with_surface(driven: Contact, solve: Solve) -> Contact:
    """Return a contact on a stator with the waves about its slider.

    Its error is the largest over the frequencies; ``solve`` is called once for each, the first time that its motion is
    needed.
    """
    surface, solved = _surface(driven.model, solve), driven.solved
    further = [motion() for motion in surface.motions[1:]]
    errors = [each.relative_error(driven.scene.positions) for each in further]
    if solved is not None and further:
        solved = replace(solved, power=solved.power + sum(each.circuit.power for each in further))
    return replace(driven, surface=surface, solved=solved, stator_error=max([driven.stator_error, *errors]))


def surface_of_run(record: Record) -> StatorSurface:
    """Return the waves about the slider of a run; those that its record does not hold are solved."""
    model = model_of(record.scene)
    known = dict(zip(_stators(model), record.surface_motions, strict=False))

    def solve(stator: Model) -> SurfaceMotion:
        if stator in known:
            return known[stator]
        goal = SHARE * record.tolerance
        return fem.one_blas_thread(solved_motion)(stator, record.scene.positions, tolerance=goal, slider=True)

    return _surface(model, solve)


def further_motions(model: Model, tolerance: float) -> list[SurfaceMotion]:
    """Return the motions of a stator at the further frequencies of its sources, solved to a relative tolerance."""
    positions, further = model.scene.positions, _stators(model)[1:]
    return [solved_motion(each, positions, tolerance=tolerance, slider=True, missed=True) for each in further]


def _surface(model: Model, solve: Solve) -> StatorSurface:
    motions = tuple(_kept(partial(solve, each)) for each in _stators(model))
    center, frequencies = model.scene.slider.center, model.scene.drive.frequencies
    return StatorSurface(center=center, frequencies=frequencies, motions=motions)


def _stators(model: Model) -> tuple[Model, ...]:
    """Return the stator alone with each frequency of its sources."""
    drive = model.scene.drive
    return (model.alone, *(model.alone_with(drive.at_frequency(each)) for each in drive.frequencies[1:]))


def _kept(solve: Callable[[], Any]) -> Callable[[], Any]:
    """Return a function that keeps what a function without arguments returns first."""
    return cache(solve)
