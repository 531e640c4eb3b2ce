"""A scene with some of its keys changed, resolved again only where a change requires it.

Most of many changed scenes share their blocks.  The blocks that were read, and the stators and sliders that were
resolved, are cached.
"""

from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

from studies.model import resolve
from studies.model.model import Model, at_one_volt
from studies.refusal import SceneError
from studies.scene import Scene
from studies.scene.block import keys_of
from studies.scene.drive import Drive
from studies.scene.override import replaced, value_at
from studies.scene.slider_keys import Slider
from studies.scene.stator_keys import Stator

MAX_BLOCKS = 10_000  # of each kind, in memory


class ChangedScenes:
    """The scene of a TOML document with some of its keys changed.

    Parameters
    ----------
    table : dict
        The TOML document.
    numbers : dict, optional
        The document with numbers for its automatic values.  With it, a change of one modulus of a named ball makes
        numbers of both; without it, such a change is refused.
    """

    def __init__(self, table: dict, numbers: dict | None = None) -> None:
        rules = {name: key.rule for name, key in keys_of(Scene).items()}
        for key in table:
            if key not in rules:
                raise SceneError(key, "is no key of a scene")
        self.table, self.numbers = table, table if numbers is None else numbers
        # functions, not methods: a cached method would refer to this object, and this cycle would hold the solved
        # stators of a subclass in memory until the next garbage collection
        self._read = partial(_read_block, table, rules)
        self._block, self._slider = lru_cache(MAX_BLOCKS)(self._read), lru_cache(MAX_BLOCKS)(resolve.resolved_slider)
        self._stator, self._drive = lru_cache(64)(_resolved_stator), lru_cache(MAX_BLOCKS)(_at_levels)

    def scene(self, changes: dict) -> Scene:
        """Return the scene with some of its keys changed; SceneError if it breaks a rule of the text."""
        own: dict[str, list] = {}
        blocks = {}
        for key, value in (self._moduli_for(changes) | changes).items():
            name, dot, _ = key.partition(".")
            if dot:
                own.setdefault(name, []).append((key, value))
        for name in self.table | own:
            try:
                blocks[name] = self._block(name, tuple(own.get(name, ())))
            except TypeError:  # a value that is a table is not hashable
                blocks[name] = self._read(name, tuple(own.get(name, ())))
            if isinstance(blocks[name], SceneError):
                raise blocks[name].with_traceback(None)
        return Scene(**blocks)

    def _moduli_for(self, changes: dict) -> dict:
        """Return the changes that replace a named ball by its moduli, if one of them is changed."""
        moduli = [f"slider.{key}" for key in resolve.MODULI]
        numbers = {key: value_at(self.numbers, key) for key in moduli}
        if not any(key in changes for key in moduli) or None in numbers.values():
            return {}
        return ({"slider.ball": None} if value_at(self.table, "slider.ball") is not None else {}) | numbers

    def model(self, changes: dict) -> Model:
        """Return the model of the scene with some of its keys changed, with numbers for automatic values."""
        scene = self.scene(changes)
        model, blocks = Model(scene), dict[str, Any]()
        if scene.stator is not None:
            computed_circuit = scene.drive.match == "auto" or scene.drive.recovery is not None
            spread = computed_circuit and model.diffracts
            # sources of own frequencies need a slider in the plane
            slider = scene.slider if scene.drive.source_frequencies else None
            stator = self._stator(scene.stator, scene.transducer, scene.piece, at_one_volt(scene.drive), slider, spread)
            drive = self._drive(stator.drive, scene.levels, scene.drive.burst, scene.drive.waveform, scene.drive.duty)
            blocks = {"stator": stator.stator, "transducer": stator.transducer, "drive": drive}
        if scene.slider is not None:
            # only the moduli of a named ball depend on the stator
            blocks["slider"] = self._slider(scene.slider, None if scene.slider.ball is None else scene.stator)
        if not all(getattr(scene, key) == each for key, each in blocks.items()):
            model = model.with_blocks(**blocks)
        if scene.slider is not None:
            resolve.check_slider(model)
        return model


def _read_block(scene: dict, rules: dict[str, Any], name: str, changes: tuple) -> Any:
    """Return a block of a scene's document with some keys changed, or why it is refused."""
    table = {name: scene[name]} if name in scene else {}
    try:
        for key, value in changes:
            table = replaced(table, key, value)
        return rules[name].read(name, table[name])
    except SceneError as error:
        return error.with_traceback(None)


def _at_levels(drive: Drive, levels: tuple, burst: Any, waveform: Any, duty: Any) -> Drive:
    return replace(drive, voltage=levels, burst=burst, waveform=waveform, duty=duty)


def _resolved_stator(
    stator: Stator, transducer: tuple, piece: tuple, drive: Drive, slider: Slider | None, spread: bool
) -> Scene:
    alone = Scene(stator=stator, transducer=transducer, piece=piece, drive=drive, slider=slider)
    return resolve.with_numbers(Model(alone), spread=spread).scene
