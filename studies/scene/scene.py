"""The whole scene: its blocks, and what they must not say together."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, ClassVar, Self

from studies.refusal import SceneError, nearest, shown
from studies.scene.block import Block, Blocks, Within
from studies.scene.blocks import Drive, Slider, Stator, Transducer, Wave
from studies.scene.file import SceneFile
from studies.scene.rule import Text
from studies.scene.uncertain import Uncertain, parted

ALONG = 0.7  # cosine of the angle from x up to which a driven transducer may stand alone


@dataclass(frozen=True, kw_only=True)
class Scene(Block):
    """A stator with its transducers and drive, or a given wave, and perhaps a slider.

    Attributes
    ----------
    title : str
        Shown on results.
    stator, transducer, drive
        The field problem; ``transducer`` is a tuple, empty for the free wave.
    wave
        The surface motion, given instead of those.
    slider
        Absent: the wave field is the result.
    uncertain
        Tolerances of the scene's numbers; needs a slider.
    """

    block: ClassVar[str] = ""
    title: Annotated[str, Text(), "Shown on results."] = ""
    stator: Annotated[Stator | None, Within(Stator), "The block of material that carries the wave."] = None
    transducer: Annotated[
        tuple[Transducer, ...],
        Blocks(Transducer),
        "The transducers on its surface; none: the free wave of the section is the result.",
    ] = ()
    drive: Annotated[Drive | None, Within(Drive), "The source; required with a stator."] = None
    wave: Annotated[
        Wave | None, Within(Wave), "A given surface motion, instead of stator, transducers and drive."
    ] = None
    slider: Annotated[Slider | None, Within(Slider), "The slider; absent: the wave is the result."] = None
    uncertain: Annotated[
        tuple | None,
        Uncertain(),
        "Tolerances (95 %) of the scene's numbers, from which follow bands of the velocity: linear (half the "
        "difference between the ends of each, added in quadrature) or sampled (percentiles of a Latin hypercube).",
    ] = None

    @classmethod
    def load(cls, source: str | Path) -> Self:
        """Read a scene file, or a scene that ships, by its name.

        Raises
        ------
        SceneError
            If it cannot be read or breaks a rule; its ``problems`` are all the faults, each with its line.
        """
        return cls.from_file(SceneFile.read(source))

    def replace(self, **blocks) -> Self:
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
        table = self.to_table()
        for name, changes in blocks.items():
            if changes is None:
                table.pop(name, None)
            elif name == "transducer" and isinstance(changes, dict):
                table[name] = _changed_transducers(table.get(name, []), changes)
            elif isinstance(changes, dict):
                table[name] = _changed(table.get(name, {}), changes)
            else:
                table[name] = changes
        return type(self).from_table("", table)

    @classmethod
    def from_file(cls, file: SceneFile) -> Self:
        """Build the scene from the document of a file; refusals name file and line."""
        with file.located():
            try:
                return cls.from_table("", file.table)
            except SceneError as error:
                raise SceneError.together([error, *_unknown_solids(file.table)]) from None

    @classmethod
    def from_table(cls, path, table):
        """Build the scene from its TOML document; ``"0.08 +- 0.02"`` at a key is a tolerance of [uncertain]."""
        return super().from_table(path, parted(table) if isinstance(table, dict) else table)

    def contradictions(self, unread):
        """Yield what contradicts between blocks, as far as they could be read."""
        if self.uncertain is not None and not {"uncertain", "slider"} & unread and self.slider is None:
            yield self.refusal("uncertain", "needs a [slider]: its bands are those of the velocity")
        if "wave" in unread:
            return
        if self.wave is not None:
            yield from self._with_given_wave(unread)
        elif "stator" in unread:
            return
        elif self.stator is None:
            rule = "is missing: a scene needs a [stator] with a [drive], or a [wave] with a [slider]"
            yield self.refusal("stator", rule)
        else:
            if not unread & {"drive", "transducer"}:
                yield from self._of_drive()
            if "transducer" not in unread:
                yield from self._of_transducers()
                yield from self._of_turned(unread)
            if "slider" not in unread and self.slider is not None:
                yield from self._of_slider(unread)

    @property
    def crossed(self) -> bool:
        """Whether a transducer is turned or stands beside the middle line."""
        return any(each.turned for each in self.transducer)

    @property
    def driven_obliquely(self) -> bool:
        """Whether no driven transducer sends along x."""
        driven = [each for each in self.transducer if self.drive.driven.get(each.name)]
        return bool(driven) and all(each.angle % 180 for each in driven)

    @property
    def levels(self) -> tuple[float, ...]:
        """Peak voltages in V, or given normal amplitudes in m; empty for a free wave."""
        return self.wave.normal_amplitude if self.wave is not None else self.drive.levels

    @property
    def driven_transducer(self) -> Transducer:
        """The driven transducer; of several the first."""
        return next(each for each in self.transducer if each.name == self.drive.transducer)

    @property
    def frequency(self) -> float | str:
        """Of the drive or the given wave, in Hz."""
        return (self.wave or self.drive).frequency

    @property
    def burst(self) -> float | None:
        """Length of the driven interval in s; None for the steady state alone."""
        return (self.wave or self.drive).burst

    def _with_given_wave(self, unread) -> Iterator[SceneError]:
        for key in ("stator", "transducer", "drive"):
            if key not in unread and getattr(self, key):
                yield self.refusal(
                    "wave", f"must not stand beside [{key}]: the surface motion is given or computed"
                )
        if "slider" in unread:
            return
        slider = self.slider
        if slider is None:
            rule = "is missing: a given [wave] without a slider leaves nothing to compute"
            yield self.refusal("slider", rule)
            return
        if slider.position is not None:
            rule = "must be absent with [wave]: the motion is given where the slider is"
            yield self.refusal("slider.position", rule)
        if slider.ball is not None:
            rule = "must not be given with [wave]: there is no stator; give both moduli in Pa"
            yield self.refusal("slider.ball", rule)
        if not isinstance(slider.contacts, int):
            rule = "must be a number with [wave]: offsets need a wavelength, of a [stator]"
            yield self.refusal("slider.contacts", rule)

    def _of_drive(self) -> Iterator[SceneError]:
        drive = self.drive
        if drive is None:
            rule = "is missing: a [stator] needs the [drive] block with its frequency"
            yield self.refusal("drive", rule)
            return
        names = [transducer.name for transducer in self.transducer]
        level = "voltage" if drive.power is None else "power"
        if drive.match != "none" and not names:
            yield self.refusal("drive.match", "must be absent without a [[transducer]]: nothing is driven")
        for key in ("transducer", level):
            given = getattr(drive, key) is not None
            if given and not names and not (key == "transducer" and drive.sources is not None):
                rule = "must be absent without a [[transducer]]: nothing is driven"
                yield self.refusal(f"drive.{key}", rule)
            if names and not given:
                wanted = (
                    f"one of {', '.join(map(shown, names))}" if key == "transducer" else "peak values in V"
                )
                rule = f"is required and missing: the scene has transducers; give {wanted}"
                yield self.refusal(f"drive.{key}", rule)
        key = "drive.transducer" if drive.sources is None else "drive.sources"
        if drive.sources is not None and not names:
            yield self.refusal(key, "must be absent without a [[transducer]]: nothing is driven")
        for name in drive.driven if names else ():
            if name not in names:
                rule = f"must name one of the transducers, got {shown(name)}"
                yield self.refusal(key, rule + nearest(name, names))
        for index, transducer in enumerate(self.transducer):
            if transducer.name in drive.driven and not transducer.has_two_combs:
                rule = f"must have + and - fingers on the driven transducer, got {shown(transducer.pattern)}"
                yield self.refusal(f"transducer.{index}.pattern", rule)
        yield from self._of_recovery(names)
        if drive.frequency != "center":
            return
        if not names:
            rule = 'must be a number in Hz without a transducer, got "center"'
            yield self.refusal("drive.frequency", rule)
        for index, transducer in enumerate(self.transducer):
            if isinstance(transducer.period, str):
                rule = (
                    f'must be a length in m where drive.frequency is "center", got {shown(transducer.period)}'
                )
                yield self.refusal(f"transducer.{index}.period", rule)

    def _of_turned(self, unread) -> Iterator[SceneError]:
        """Refuse turned transducers where their waves do not spread, or drive the slider across."""
        if not self.crossed:
            return
        what = "where a transducer is turned or stands beside the middle line"
        for key, allowed in (("ends", "absorbing"), ("sides", "absorbing")):
            if getattr(self.stator, key) != allowed:
                got = shown(getattr(self.stator, key))
                yield self.refusal(f"stator.{key}", f"must be {allowed} {what}, got {got}")
        if self.stator.diffraction is False:
            yield self.refusal(
                "stator.diffraction", f"must be true or absent {what}: a plane section has no y"
            )
        for index, transducer in enumerate(self.transducer):
            if not transducer.has_two_combs:
                rule = f"must have + and - fingers {what}, got {shown(transducer.pattern)}"
                yield self.refusal(f"transducer.{index}.pattern", rule)
        if self.slider is None or {"slider", "drive"} & unread or self.drive is None:
            return
        driven = [each for each in self.transducer if self.drive.driven.get(each.name)]
        if driven and all(abs(math.cos(math.radians(each.angle))) < ALONG for each in driven):
            names = ", ".join(f"{each.name!r} at {each.angle:g} deg" for each in driven)
            rule = "must drive a transducer within 45 deg of x: the contact is one-dimensional, and the slider would"
            key = "transducer" if self.drive.sources is None else "sources"
            yield self.refusal(f"drive.{key}", f"{rule} be moved across by {names}")

    def _of_recovery(self, names) -> Iterator[SceneError]:
        recovery, key = self.drive.recovery, "drive.recovery.receiver"
        if recovery is None:
            return
        if recovery.receiver not in names or recovery.receiver in self.drive.driven:
            others = [name for name in names if name not in self.drive.driven]
            rule = f"must name a transducer that is not driven, got {shown(recovery.receiver)}"
            yield self.refusal(key, rule + nearest(recovery.receiver, others))
            return
        index = names.index(recovery.receiver)
        receiver = self.transducer[index]
        if not receiver.has_two_combs:
            rule = f"must have + and - fingers on the receiving transducer, got {shown(receiver.pattern)}"
            yield self.refusal(f"transducer.{index}.pattern", rule)
        if receiver.termination not in ("open", recovery.load):
            rule = "must be absent on the receiving transducer: drive.recovery has its load"
            yield self.refusal(f"transducer.{index}.termination", rule)

    def _of_transducers(self) -> Iterator[SceneError]:
        names, placed = [transducer.name for transducer in self.transducer], []
        for index, transducer in enumerate(self.transducer):
            at = f"transducer.{index}"
            if transducer.name in names[:index]:
                rule = f"must differ from the others, got {shown(transducer.name)} twice"
                yield self.refusal(f"{at}.name", rule)
            if transducer.aperture > self.stator.width:
                rule = f"must be at most stator.width, {self.stator.width:g} m, got {transducer.aperture:g} m"
                yield self.refusal(f"{at}.aperture", rule)
            if transducer.turned:
                continue  # seen from above: studies/scene/resolved.py
            known = 0.0 if isinstance(transducer.period, str) else transducer.period
            gap = (1 - transducer.metallisation) * transducer.finger_pairs / transducer.fingers
            half = known * (transducer.finger_pairs - gap) / 2
            center = transducer.place[0]
            left, right = center - half, center + half
            if left <= 0 or right >= self.stator.length:
                rule = f"must keep the fingers on the stator, 0 to {self.stator.length:g} m, got"
                where = f"{center:g} m with fingers from {left:g} to {right:g} m"
                yield self.refusal(f"{at}.center", f"{rule} {where}")
            placed.append((left, right, transducer.name))
        for (_, end, first), (start, _, second) in pairwise(sorted(placed)):
            if end >= start:
                rule = f"must not overlap: {first!r} ends at {end:g} m, {second!r} begins at {start:g} m"
                yield self.refusal("transducer", rule)

    def _of_slider(self, unread) -> Iterator[SceneError]:
        if "transducer" not in unread and not self.transducer:
            rule = "must be absent without a [[transducer]] or a [wave]: nothing drives it"
            yield self.refusal("slider", rule)
        if self.slider.position is None:
            rule = "is required and missing: where on the [stator] the slider stands, in m"
            yield self.refusal("slider.position", rule)
            return
        places = [x for x, _ in self.slider.places]
        for place in sorted({min(places), max(places)}):
            if not 0 <= place <= self.stator.length:
                rule = f"must keep the contacts on the stator, 0 to {self.stator.length:g} m"
                got = f"got {self.slider.center[0]:g} m, a contact at {place:g} m"
                yield self.refusal("slider.position", f"{rule}, {got}")
        beside = max((y for _, y in self.slider.places), key=abs)
        half = self.stator.width / 2
        if abs(beside) > half:
            rule = f"must keep the contacts on the stator, y from -{half:g} to {half:g} m"
            yield self.refusal("slider.position", f"{rule}, got a contact at y = {beside:g} m")


def _changed(table: dict, changes: dict) -> dict:
    """Return a block's table with some keys changed, those of a block within it one by one."""
    nested = {
        key: _changed(table[key], value)
        for key, value in changes.items()
        if isinstance(value, dict) and isinstance(table.get(key), dict)
    }
    return table | changes | nested


def _changed_transducers(tables: list[dict], changes: dict[str, dict]) -> list[dict]:
    names = [each["name"] for each in tables]
    for name in changes:
        if name not in names:
            raise SceneError("transducer", f"has none of the name {shown(name)}{nearest(name, names)}")
    return [_changed(each, changes.get(each["name"], {})) for each in tables]


def _unknown_solids(table: dict) -> Iterator[SceneError]:
    """Yield the names of solids that the catalogue lacks, to be said beside the faults of the text."""
    from fem import material

    for block, key in (("stator", "material"), ("slider", "ball")):
        name = table[block].get(key) if isinstance(table.get(block), dict) else None
        if isinstance(name, str):
            try:
                material(name)
            except ValueError as error:
                yield SceneError(f"{block}.{key}", str(error).removeprefix("material "))
