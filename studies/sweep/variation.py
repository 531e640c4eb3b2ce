"""The scenes of a sweep's points, built from blocks that are read once for each set of their own values."""

from dataclasses import replace
from functools import lru_cache

from studies.refusal import SceneError
from studies.scene import Scene
from studies.scene.block import keys_of
from studies.scene.blocks import Drive
from studies.scene.override import replaced
from studies.scene.resolved import resolved, resolved_slider
from studies.sweep.design import Question

KEPT = 10_000  # blocks of a kind in memory


class Variation:
    """Scenes by the values of a question's keys."""

    def __init__(self, question: Question):
        self.question = question
        known = {name: key.rule for name, key in keys_of(Scene).items()}
        for key in question.table:
            if key not in known:
                raise SceneError(key, "is no key of a scene")
        heads = [key.split(".")[0] for key in question.keys]
        self._places = {}
        self._read = {}
        for name in dict.fromkeys([*question.table, *heads]):
            self._places[name] = tuple(k for k, head in enumerate(heads) if head == name)
            self._read[name] = self._reader(name, known[name])
        self._resolved_slider = lru_cache(KEPT)(resolved_slider)
        self._resolved_source = lru_cache(64)(_resolved_source)

    def scene(self, values: tuple) -> Scene:
        """Return the scene of a point; SceneError if it breaks a rule of the text."""
        scene = Scene(**self._blocks(values))
        if scene.wave is not None or scene.transducer:
            if len(scene.levels) != 1:
                key = "wave.normal_amplitude" if scene.wave is not None else "drive.voltage"
                raise SceneError(key, f"must be one value at a point, got {len(scene.levels)}")
        return scene

    def resolved(self, values: tuple) -> Scene:
        """Return the scene of a point with its automatic values found; SceneError if the physics refuses it."""
        scene, found = self.scene(values), {}
        if scene.burst is not None:
            return resolved(scene)
        if scene.stator is not None:
            source = self._resolved_source(*_source_blocks(scene))
            found["transducer"] = source.transducer
            if scene.transducer:
                found["drive"] = replace(source.drive, voltage=scene.levels, burst=scene.drive.burst)
        if scene.slider is not None:
            stator = None if scene.slider.ball is None else scene.stator
            found["slider"] = self._resolved_slider(scene.slider, stator)
        return (
            replace(scene, **found)
            if any(getattr(scene, key) != each for key, each in found.items())
            else scene
        )

    def source(self, values: dict) -> Scene:
        """Return the resolved scene of a stator's answer: without slider, at one volt.

        ``values``: of the keys that the answer depends on; those of the slider are left out.
        """
        table = {name: part for name, part in self.question.table.items() if name != "slider"}
        for key, value in values.items():
            if not key.startswith("slider."):
                table = replaced(table, key, value)
        table = replaced(replaced(table, "drive.voltage", 1.0), "title", "")
        for key in ("burst", "power"):
            table["drive"].pop(key, None)
        return resolved(Scene.from_table("", table))

    def _blocks(self, values) -> dict:
        found = {}
        for name, places in self._places.items():
            block = self._read[name](tuple(values[k] for k in places))
            if isinstance(block, SceneError):
                raise block
            found[name] = block
        return found

    def _reader(self, name, rule):
        table = {name: self.question.table[name]} if name in self.question.table else {}
        keys = [self.question.keys[k] for k in self._places[name]]

        @lru_cache(KEPT)
        def read(own):
            changed = table
            try:
                for key, value in zip(keys, own, strict=True):
                    changed = replaced(changed, key, value)
                return rule.read(name, changed[name])
            except SceneError as error:
                return error.with_traceback(None)

        return read


def _source_blocks(scene: Scene) -> tuple:
    return scene.stator, scene.transducer, _at_one_volt(scene.drive)


@lru_cache(KEPT)
def _at_one_volt(drive: Drive) -> Drive:
    return replace(drive, voltage=(1.0,) if drive.levels else None, power=None, burst=None)


def _resolved_source(stator, transducer, drive) -> Scene:
    return resolved(Scene(stator=stator, transducer=transducer, drive=drive))
