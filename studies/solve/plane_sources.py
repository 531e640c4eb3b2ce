"""The waves of each source alone below a slider in the plane, and their sum."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import fem
from studies.model.model import Model
from studies.model.plane import StatorSurface, Sum
from studies.model.wave_to_contact import Contact
from studies.solve.mapped_surface import Mapped
from studies.solve.refinement import SHARE
from studies.solve.surface_motion import solved_motion


def waves_of_sources(driven: Contact, tolerance: float) -> dict[str, Any]:
    """Return the surface motion of each source alone for a level of 1, by name; of prescribed waves by number.

    ``tolerance``: of the velocity, of which the stator takes a share.
    """
    scene = driven.scene
    if scene.wave is not None:
        waves = driven.surface.waves
        return {f"wave {number}": replace(driven.surface, waves=(each,)) for number, each in enumerate(waves, start=1)}
    return {name: _of_source(driven.model, name, tolerance) for name, size in scene.drive.driven.items() if size}


def _of_source(model: Model, name: str, tolerance: float) -> Mapped:
    """Return the surface motion of one source of a stator per volt, the other sources at 0 V."""
    scene, drive = model.scene, model.scene.drive
    frequency = dict(drive.source_frequencies or ()).get(name, scene.frequency)
    alone = drive.at_frequency(frequency)
    alone = replace(alone, sources=tuple((each, size if each == name else 0.0) for each, size in alone.driven.items()))
    solve = fem.one_blas_thread(solved_motion)
    stator = model.alone_with(alone)
    motion = solve(stator, scene.positions, tolerance=SHARE * tolerance, slider=True, missed=True)
    surface = StatorSurface(center=scene.slider.center, frequencies=(frequency,), motions=(lambda: motion,))
    return Mapped(surface=surface, wavelength=abs(motion.wave.phase_velocity) / motion.wave.frequency)


def driven_by(sources: Mapping[str, Any], levels: Mapping[str, float]) -> Sum:
    """Return the surface motion of some sources, each at its level."""
    return Sum(parts=tuple((sources[name], level) for name, level in levels.items()))
