"""The plan of a run: what the scene makes it compute, how large that is, what it will cost; nothing is solved."""

from dataclasses import dataclass

from studies.chain import slider_left_out
from studies.refusal import RunError
from studies.report import cost
from studies.report.parts import Part, contact_part, driven_parts, free_parts
from studies.scene import Scene, resolved

__all__ = ["Plan", "plan"]


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What a run would compute, its size and its cost."""

    scene: Scene
    tolerance: float
    parts: tuple[Part, ...]
    left_out: tuple[str, ...]
    seconds: float
    bytes: float
    speed: float

    def to_dict(self) -> dict:
        """Return the plan as plain numbers, text, lists and tables."""
        parts = [
            {"name": part.name, "equations": part.equations, "facts": part.facts, "seconds": part.seconds}
            | ({"levels": [vars(level) for level in part.levels]} if part.levels else {})
            for part in self.parts
        ]
        return {
            "title": self.scene.title,
            "scene": self.scene.to_table(),
            "tolerance": self.tolerance,
            "parts": parts,
            "left_out": list(self.left_out),
            "expected": {
                "seconds": self.seconds,
                "seconds_within": cost.TIME_WITHIN,
                "bytes": self.bytes,
                "bytes_within": cost.MEMORY_WITHIN,
                "operations_per_second": self.speed,
            },
        }


def plan(scene: Scene, *, tolerance: float) -> Plan:
    """Return the plan of a scene's run.

    Parameters
    ----------
    scene : Scene
    tolerance : float
        As of the run.

    Returns
    -------
    Plan

    Raises
    ------
    SceneError
        If the scene is refused by the physics.
    RunError
        If a run would refuse its size.
    """
    scene = resolved.resolved(scene)
    if scene.wave is None:
        from fem import ConvergenceError

        try:
            return _plan(scene, tolerance)
        except ConvergenceError as error:
            raise RunError(str(error)) from None
    return _plan(scene, tolerance)


def _plan(scene: Scene, tolerance: float) -> Plan:
    speed = 0.0 if scene.wave is not None else cost.machine_speed()
    if scene.wave is not None:
        parts, left_out = [], ["stator, transducers and electric field: the surface motion is given"]
    elif scene.transducer:
        parts, left_out = driven_parts(scene, tolerance, speed)
    else:
        parts, left_out = free_parts(scene, tolerance, speed)
    if scene.slider is not None:
        parts.append(contact_part(scene))
    kept = [level.megabytes * 1e6 for part in parts for level in part.levels]
    return Plan(
        scene=scene,
        tolerance=tolerance,
        parts=tuple(parts),
        left_out=(*left_out, *slider_left_out(scene)),
        seconds=cost.LOAD + sum(part.seconds for part in parts),
        bytes=cost.memory(
            kept,
            band=max((part.band_bytes for part in parts), default=0.0),
            law=None if scene.slider is None else scene.slider.law,
        ),
        speed=speed,
    )
