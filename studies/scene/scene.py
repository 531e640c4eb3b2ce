"""A scene: its blocks, how it is read, checked and changed, and what follows from several blocks."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

import fem
from studies.refusal import SceneError
from studies.scene import consistency
from studies.scene.block import Block, Blocks, Within
from studies.scene.drive import Drive, Wave
from studies.scene.file import SceneFile
from studies.scene.override import merged
from studies.scene.rule import TEXT
from studies.scene.slider_keys import Slider
from studies.scene.stator_keys import Piece, Stator, Transducer
from studies.scene.uncertain import Uncertain, split_tolerances


@dataclass(frozen=True, kw_only=True)
class Scene(Block):
    """A stator with its transducers and drive, or a prescribed wave, and perhaps a slider.

    A block that is absent is None. Its type includes Any, so that code behind a check for its presence needs no second
    check for None.
    """

    block: ClassVar[str] = ""
    title: Annotated[str, TEXT, "Title of the results."] = ""
    stator: Annotated[Stator | Any, Within(Stator), "The block of material that carries the wave."] = None
    transducer: Annotated[
        tuple[Transducer, ...],
        Blocks(Transducer),
        "The transducers on the surface of the stator. Absent: the result is the free wave of the section.",
    ] = ()
    piece: Annotated[tuple[Piece, ...], Blocks(Piece), "Parts of the stator's section, each a mesh."] = ()
    drive: Annotated[Drive | Any, Within(Drive), "The source; required with a stator."] = None
    wave: Annotated[
        Wave | Any, Within(Wave), "A prescribed surface motion, instead of stator, transducers and drive."
    ] = None
    slider: Annotated[Slider | Any, Within(Slider), "The slider. Absent: the result is the wave."] = None
    uncertain: Annotated[
        tuple | None,
        Uncertain(),
        "Tolerances (95 %) of numbers of the scene, for uncertainty intervals of the velocity. method: linear (half"
        " of the difference between the ends of each tolerance, added in quadrature) or sampled (percentiles of a "
        "Latin hypercube). Without method: sampled if the answer is nonlinear within a tolerance and no sample "
        "needs a new solution of the stator, otherwise linear.",
    ] = None

    @classmethod
    def load(cls, source: "Scene | str | Path") -> "Scene":
        """Read a scene file, or a scene that ships, by its name; a `Scene` is returned as it is.

        Raises
        ------
        SceneError
            If it cannot be read or breaks a rule; its ``problems`` are all the faults, each with its line.
        """
        return source if isinstance(source, Scene) else cls.from_file(SceneFile.read(source))

    def replace(self, **blocks: Any) -> Self:
        """Return the scene with some keys changed; what is not named stays.

        Parameters
        ----------
        **blocks
            Block to keys and values, as in a scene file: numbers in SI units or text with a unit.  ``None`` removes
            a block.  ``transducer`` takes names to keys and values, or a whole list.  ``title`` is a text.

        Raises
        ------
        SceneError
            If the new scene breaks a rule.

        Examples
        --------
        >>> motor = Scene.load("twente").replace(slider={"preload": "5 mN"}, drive={"voltage": "5:60:12"})
        >>> motor.slider.preload, motor.drive.voltage[:2]
        (0.005, (5.0, 10.0))
        >>> motor.replace(transducer={"left": {"finger_pairs": 5}}).transducer[0].finger_pairs
        5
        >>> Scene.load("twente").replace(slider=None).slider is None
        True
        """
        return type(self).from_table("", merged(self.to_table(), blocks))

    @classmethod
    def from_file(cls, file: SceneFile) -> Self:
        """Build the scene from the document of a file; refusals name file and line."""
        with file.located():
            try:
                return cls.from_table("", file.table)
            except SceneError as error:
                raise SceneError.together([error, *_unknown_solids(file.table)]) from None

    @classmethod
    def from_table(cls, path: Any, table: Any) -> Any:
        """Build the scene from its TOML document; ``"0.08 +- 0.02"`` at a key is a tolerance of [uncertain]."""
        return super().from_table(path, split_tolerances(table) if isinstance(table, dict) else table)

    checks = consistency.CHECKS

    @property
    def crossed(self) -> bool:
        """Whether one section along x does not suffice: a transducer is rotated, or its centre has y != 0."""
        return any(each.turned for each in self.transducer)

    @property
    def in_strips(self) -> bool:
        """Whether a transducer is apodised or slanted: its answers are sums of strips along y."""
        return any(not each.uniform_along_y for each in self.transducer)

    def refuse_pillars(self, rule: str) -> None:
        """Raise a SceneError with a rule if there is a slider on pillars."""
        if self.on_pillars:
            self.refuse("slider.pillars", rule)

    @property
    def on_pillars(self) -> bool:
        """Whether there is a slider on pillars."""
        return self.slider is not None and self.slider.pillars is not None

    @property
    def planar(self) -> bool:
        """Whether there is a slider that moves in the plane or turns."""
        return self.slider is not None and self.slider.planar

    @property
    def driven_obliquely(self) -> bool:
        """Whether no driven transducer radiates along x."""
        driven = [each for each in self.transducer if self.drive.driven.get(each.name)]
        return bool(driven) and all(each.angle % 180 for each in driven)

    @property
    def source(self) -> Drive | Wave | Any:
        """The block that sets frequency, levels and burst: the drive, or the prescribed wave."""
        return self.drive if self.wave is None else self.wave

    @property
    def level_key(self) -> str:
        """Key of the levels."""
        return "drive.voltage" if self.wave is None else "wave.normal_amplitude"

    @property
    def level_column(self) -> str:
        """Column of the levels in the points of a run."""
        return "voltage_V" if self.wave is None else "normal_amplitude_m"

    def named(self, level: float) -> str:
        """Return a level with its unit."""
        return f"{level:.4g} V" if self.wave is None else f"{level * 1e9:.4g} nm"

    def with_source(self, **keys: Any) -> Self:
        """Return the scene with keys of its `source` replaced by values in SI units, which are not checked.

        A waveform is that of one burst: another burst, or none, is without it.
        """
        keys = ({"waveform": None} if "burst" in keys else {}) | keys
        source: dict[str, Any] = {self.source.block: replace(self.source, **keys)}
        return replace(self, **source)

    def at_level(self, level: float) -> Self:
        """Return the scene at one voltage in V or amplitude in m, without drive.power and [uncertain]."""
        keys: dict[str, Any] = {"normal_amplitude": (level,)}
        if self.wave is None:
            keys = {"voltage": (level,), "power": None}
        return replace(self.with_source(**keys), uncertain=None)

    @property
    def levels(self) -> tuple[float, ...]:
        """Peak voltages in V, or prescribed normal amplitudes in m; empty for a free wave."""
        return self.drive.levels if self.wave is None else self.wave.normal_amplitude

    @property
    def contact_positions(self) -> tuple[tuple[float, float], ...]:
        """Positions (x, y) of the contacts on the stator, m; without a slider, the middle of the stator."""
        return ((self.stator.length / 2, 0.0),) if self.slider is None else self.slider.contact_positions

    @property
    def positions(self) -> tuple[tuple[float, float], ...]:
        """Positions (x, y) in m at which the motion is computed: the slider's centre, then the contacts.

        In the plane those of the contacts alone: a rotor has none at its centre.
        """
        first = () if self.slider is None or self.planar else (self.slider.center,)
        return tuple(dict.fromkeys((*first, *self.contact_positions)))

    @property
    def driven_transducer(self) -> Transducer:
        """The driven transducer; of several the first."""
        return next(each for each in self.transducer if each.name == self.drive.transducer)

    @property
    def driven_transducers(self) -> tuple[Transducer, ...]:
        """The transducers whose source has an amplitude that is not 0, that of `driven_transducer` first."""
        first, driven = self.driven_transducer, self.drive.driven
        others = (each for each in self.transducer if driven.get(each.name) and each is not first)
        return (first, *others)

    @property
    def frequency(self) -> float:
        """Frequency of the drive or the prescribed wave, Hz; "center" must have been resolved."""
        frequency = self.source.frequency
        if isinstance(frequency, str):
            self.refuse("drive.frequency", f"must be a number in Hz here, got {frequency!r}")
        return frequency

    @property
    def burst(self) -> float | Any:
        """Length of the driven interval in s; None for the steady state alone."""
        return self.source.burst


def _unknown_solids(table: dict) -> Iterator[SceneError]:
    """Yield refusals of solids that the catalogue lacks, so that they appear together with the faults of the text."""
    for block, key in (("stator", "material"), ("slider", "ball")):
        name = table[block].get(key) if isinstance(table.get(block), dict) else None
        if isinstance(name, str) and not (key == "material" and name.endswith(".toml")):
            try:
                fem.material(name)
            except fem.InputError as error:
                yield SceneError(f"{block}.{key}", error.rule)
