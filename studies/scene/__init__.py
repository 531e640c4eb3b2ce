"""A scene: what is modelled, no more.  A block that is absent is left out of the model.

``Scene.load("motor.toml")`` equals the ``Scene(...)`` built from the same blocks in Python.  The checks here
are those of the text alone; what the physics must be asked (an automatic period, a material) is in
``resolved``.
"""

import tomllib
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, ClassVar, Self

from studies.refusal import SceneError, nearest, shown
from studies.scene.block import Block, Blocks, Within
from studies.scene.blocks import Drive, Slider, Stator, Transducer, Wave
from studies.scene.rule import Text

__all__ = ["Scene", "read_table", "scene_path", "shipped_scenes"]

SHIPPED = Path(__file__).parents[1] / "scenes"


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
    """

    block: ClassVar[str] = ""
    title: Annotated[str, Text()] = ""
    stator: Annotated[Stator | None, Within(Stator)] = None
    transducer: Annotated[tuple[Transducer, ...], Blocks(Transducer)] = ()
    drive: Annotated[Drive | None, Within(Drive)] = None
    wave: Annotated[Wave | None, Within(Wave)] = None
    slider: Annotated[Slider | None, Within(Slider)] = None

    @classmethod
    def load(cls, source: str | Path) -> Self:
        """Read a scene file, or a scene that ships, by its name.

        Raises
        ------
        SceneError
            If it cannot be read or breaks a rule.
        """
        return cls.from_table("", read_table(source))

    def check(self):
        """Refuse blocks that contradict each other."""
        if self.wave is not None:
            self._check_given_wave()
        elif self.stator is None:
            self.refuse(
                "stator", "is missing: a scene needs a [stator] with a [drive], or a [wave] with a [slider]"
            )
        else:
            self._check_drive()
            self._check_transducers()
            self._check_slider()

    @property
    def levels(self) -> tuple[float, ...]:
        """Peak voltages in V, or given normal amplitudes in m; empty for a free wave."""
        return self.wave.normal_amplitude if self.wave is not None else self.drive.voltage or ()

    @property
    def frequency(self) -> float | str:
        """Of the drive or the given wave, in Hz."""
        return (self.wave or self.drive).frequency

    @property
    def burst(self) -> float | None:
        """Length of the driven interval in s; None for the steady state alone."""
        return (self.wave or self.drive).burst

    def _check_given_wave(self):
        for key in ("stator", "transducer", "drive"):
            if getattr(self, key):
                self.refuse("wave", f"must not stand beside [{key}]: the surface motion is given or computed")
        if self.slider is None:
            self.refuse("slider", "is missing: a given [wave] without a slider leaves nothing to compute")
        if self.slider.position is not None:
            self.refuse(
                "slider.position", "must be absent with [wave]: the motion is given where the slider is"
            )
        if self.slider.ball is not None:
            self.refuse(
                "slider.ball", "must not be given with [wave]: there is no stator; give both moduli in Pa"
            )
        if not isinstance(self.slider.contacts, int):
            self.refuse(
                "slider.contacts", "must be a number with [wave]: offsets need a wavelength, of a [stator]"
            )

    def _check_drive(self):
        if self.drive is None:
            self.refuse("drive", "is missing: a [stator] needs the [drive] block with its frequency")
        names = [transducer.name for transducer in self.transducer]
        for key in ("transducer", "voltage"):
            given = getattr(self.drive, key) is not None
            if given and not names:
                self.refuse(f"drive.{key}", "must be absent without a [[transducer]]: nothing is driven")
            if names and not given:
                self.refuse(f"drive.{key}", "is required and missing: the scene has transducers")
        if names and self.drive.transducer not in names:
            rule = f"must name one of the transducers, got {shown(self.drive.transducer)}"
            self.refuse("drive.transducer", rule + nearest(self.drive.transducer, names))
        for index, transducer in enumerate(self.transducer):
            if transducer.name == self.drive.transducer and not transducer.has_two_combs:
                rule = f"must have + and - fingers on the driven transducer, got {shown(transducer.pattern)}"
                self.refuse(f"transducer.{index}.pattern", rule)
        if self.drive.frequency == "center":
            if not names:
                self.refuse("drive.frequency", 'must be a number in Hz without a transducer, got "center"')
            for index, transducer in enumerate(self.transducer):
                if transducer.period == "auto":
                    rule = 'must be a length in m where drive.frequency is "center", got "auto"'
                    self.refuse(f"transducer.{index}.period", rule)

    def _check_transducers(self):
        names = [transducer.name for transducer in self.transducer]
        for index, name in enumerate(names):
            if name in names[:index]:
                self.refuse(
                    f"transducer.{index}.name", f"must differ from the others, got {shown(name)} twice"
                )
        placed = []
        for index, transducer in enumerate(self.transducer):
            known = 0.0 if transducer.period == "auto" else transducer.period
            gap = (1 - transducer.metallisation) * transducer.finger_pairs / transducer.fingers
            half = known * (transducer.finger_pairs - gap) / 2
            left, right = transducer.center - half, transducer.center + half
            if left <= 0 or right >= self.stator.length:
                rule = f"must keep the fingers on the stator, 0 to {self.stator.length:g} m, got"
                where = f"{transducer.center:g} m with fingers from {left:g} to {right:g} m"
                self.refuse(f"transducer.{index}.center", f"{rule} {where}")
            placed.append((left, right, transducer.name))
        for (_, end, first), (start, _, second) in pairwise(sorted(placed)):
            if end >= start:
                rule = f"must not overlap: {first!r} ends at {end:g} m, {second!r} begins at {start:g} m"
                self.refuse("transducer", rule)

    def _check_slider(self):
        if self.slider is None:
            return
        if not self.transducer:
            self.refuse("slider", "must be absent without a [[transducer]] or a [wave]: nothing drives it")
        if self.slider.position is None:
            self.refuse(
                "slider.position", "is required and missing: where on the [stator] the slider stands, in m"
            )
        places = [self.slider.position + offset for offset in self.slider.offsets]
        for place in (min(places), max(places)):
            if not 0 <= place <= self.stator.length:
                rule = f"must keep the contacts on the stator, 0 to {self.stator.length:g} m"
                self.refuse(
                    "slider.position", f"{rule}, got {self.slider.position:g} m, a contact at {place:g} m"
                )


def shipped_scenes() -> dict[str, Path]:
    """Return the files of the scenes that ship, by name."""
    return {path.stem: path for path in sorted(SHIPPED.glob("*.toml"))}


def scene_path(source: str | Path) -> Path:
    """Return the file of a scene, given its path or the name of one that ships."""
    shipped = shipped_scenes()
    if Path(source).is_file():
        return Path(source)
    if str(source) in shipped:
        return shipped[str(source)]
    raise SceneError(
        "", f"no scene file or shipped scene is named {shown(str(source))}{nearest(source, shipped)}"
    )


def read_table(source: str | Path) -> dict:
    """Return the TOML document of a scene, not yet checked.

    Raises
    ------
    SceneError
        If the file cannot be found, opened, decoded or parsed.
    """
    path = scene_path(source)
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise SceneError("", f"the scene {str(path)!r} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise SceneError("", f"the scene {str(path)!r} cannot be read: it is not UTF-8 text") from None
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
        raise SceneError("", f"the scene {str(path)!r} is not TOML: {str(error)[:200]}") from None
