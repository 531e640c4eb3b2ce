"""A scene as objects of ``fem`` and ``contact``: each is made when it is first asked for, and once."""

from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any, Self

import fem
from studies.model import fem_objects
from studies.refusal import SceneError
from studies.scene import Scene
from studies.scene.drive import Drive
from studies.scene.stator_keys import Stator

MAX_DRIVES = 10_000  # in memory
MAX_STATORS = 64  # in memory, with the objects that were made of them
MAX_LATEST = 8  # the same, of whole scenes
POSITION_KEYS = ("slider.position", "slider.contacts")


def changes_stator(key: str) -> bool:
    """Return whether a change of a key requires a new solution of the section or its circuit."""
    in_stator = key.startswith(("stator.", "transducer.", "drive."))
    in_time = key.startswith(("drive.burst", "drive.duty", "drive.waveform"))
    return in_stator and not in_time and key not in ("drive.voltage", "drive.power")


@dataclass(frozen=True)
class Model:
    """A scene and the objects that its solvers take; two models of equal scenes are equal.

    `studies.model.resolve.build` makes that of a scene, with numbers for its automatic values. Before that, only the
    objects exist that do not depend on such a value.
    """

    scene: Scene
    written: Scene | None = field(default=None, compare=False, repr=False)  # before its automatic values became numbers

    def with_blocks(self, **blocks: Any) -> Self:
        """Return the model of the scene with some blocks replaced, which are not checked."""
        return replace(self, scene=replace(self.scene, **blocks))

    def at_temperature(self, temperature_degC: float | str | None) -> Self:
        """Return the model with its stator at a temperature in degC, at that of its own heat ("steady"), or cold."""
        return self.with_blocks(stator=replace(self.scene.stator, temperature=temperature_degC))

    def at_temperature_of(self, other: "Model") -> Self:
        """Return the model with its stator at the temperature of another model's; without a stator as it is."""
        return self if self.scene.stator is None else self.at_temperature(other.scene.stator.temperature)

    @property
    def cold(self) -> Self:
        """The model with the constants of its stator's solid as they are, without ``stator.temperature``."""
        stator = self.scene.stator
        return self if stator is None or stator.temperature is None else self.with_blocks(stator=stator.cold)

    @property
    def before_heat(self) -> Self:
        """The model with a cold stator where it is to be solved at its own steady temperature."""
        stator = self.scene.stator
        return self.cold if stator is not None and stator.is_steady else self

    @cached_property
    def solid(self) -> Any:
        """The ``fem.Solid`` of the stator's material."""
        return fem_objects.solid(self.scene.stator)

    @cached_property
    def plain(self) -> Any:
        """The ``fem.Stator`` without its meshed pieces, the fingers on its surface."""
        return fem_objects.stator(self.scene.stator)

    @property
    def surface_solid(self) -> Any:
        """The ``fem.Solid`` at the surface: that of the last layer, or of the stator."""
        return self.plain.solids[-1]

    @cached_property
    def pieces(self) -> tuple:
        """The ``fem.MeshPiece`` objects, one for each position."""
        if not self.scene.piece:
            return ()
        block = self.scene.stator
        return fem_objects.pieces(self.scene.piece, block.cut, block.length)

    @cached_property
    def stator(self) -> Any:
        """The ``fem.Stator`` with its meshed pieces and the plane of its fingers."""
        plane = next((int(each.plane) for each in self.scene.transducer if each.plane != "surface"), 0)
        below = fem_objects.stator(self.scene.stator, plane) if plane else self.plain
        return replace(below, pieces=self.pieces) if self.pieces else below

    @cached_property
    def transducers(self) -> tuple:
        """The ``fem.Transducer`` objects; their periods are numbers."""
        return fem_objects.transducers(self.scene.transducer)

    @property
    def section_transducers(self) -> tuple:
        """`transducers` for models with a single section along x; a SceneError if some lie on other lines."""
        if self.scene.crossed:
            rule = "must all have the angle 0 and y = 0 here: this answer is that of one section along x"
            raise SceneError("transducer", f"{rule}; sawmotor run, sweep and view accept rotated ones")
        if self.scene.in_strips:
            rule = "must be neither apodised nor slanted here: this answer is that of one section along x"
            raise SceneError("transducer", f"{rule}; sawmotor run, sweep and export of masks accept such ones")
        return self.transducers

    @property
    def driven(self) -> Any:
        """The ``fem.Transducer`` that is driven; the first one if there are several."""
        return next(each for each in self.transducers if each.name == self.scene.drive.transducer)

    @cached_property
    def drive(self) -> Any:
        """The ``fem.Drive`` of a scene with transducers."""
        return fem_objects.drive(self.scene.drive)

    @cached_property
    def groups(self) -> tuple:
        """The groups of parallel transducers (`fem.rows_of`) where some are rotated."""
        return fem.rows_of(self.plain, self.scene.stator.width, self.transducers, self.drive)

    @cached_property
    def wavelength(self) -> float:
        """Length in m of the wave under a bare surface without charge at the frequency of the source."""
        return self.wave_velocity(self.scene.frequency) / self.scene.frequency

    def wave_velocity(self, frequency: float) -> float:
        """Return the velocity of the wave under a bare surface without charge (D_n = 0) at a frequency in Hz, m/s."""
        return fem.bound_wave(self.plain, frequency, "open").velocity

    @property
    def diffracts(self) -> bool:
        """Whether finite apertures are computed, see `fem_objects.section_reason`."""
        slider = self.scene.slider
        return not self.scene.piece and self.spreads(None if slider is None else slider.contact_positions)

    def spreads(self, positions: tuple | None) -> bool:
        """Return True if finite apertures are computed for contacts at ``positions`` (x, y), m; None without slider."""
        return not self.section_reason(positions)

    def section_reason(self, positions: tuple | None) -> str:
        """Return why the plane section is used for contacts at ``positions``, as of `spreads`; empty if it is not."""
        return fem_objects.section_reason(self.scene.stator, self.plain, positions, self.scene.transducer)

    @property
    def alone(self) -> "Model":
        """The stator alone, at 1 V, without burst, waveform and duty: the same object for all sliders and levels on it.

        Of sources with several frequencies it has the first one.
        """
        drive = self.scene.drive
        return self.alone_with(drive.at_frequency(drive.frequencies[0]) if drive.source_frequencies else drive)

    def alone_with(self, drive: Drive) -> "Model":
        """Return the stator alone with another drive, as `alone`."""
        scene = self.scene
        blocks = scene.stator, scene.transducer, scene.piece, at_one_volt(drive)
        return _alone(*blocks) if scene.piece else _shared_alone(*blocks)  # a mesh file may change

    def first_section(self, point: tuple[float, float]) -> tuple[Self, float]:
        """Return the model of the section that the answers of a rotated scene refer to, and x of a point in it, m.

        ``point``: (x, y) in m on the stator.
        """
        if not self.scene.crossed:
            return self, point[0]
        group, drive = self.groups[0], self.scene.drive
        blocks = {each.name: each for each in self.scene.transducer}
        own = tuple(
            replace(blocks[each.name], center=each.center, angle=0.0, pattern=each.pattern)
            for each in group.transducers
        )
        if drive.sources is not None:
            names = [each.name for each in own]
            sources = tuple((name, size) for name, size in drive.driven.items() if name in names)
            drive = replace(drive, sources=sources, source_frequencies=None)
        section = replace(self.scene.stator, length=group.stator.length)
        return self.with_blocks(stator=section, transducer=own, drive=drive), float(group.local(*point)[0])

    def port_admittance(self, frequency: Any, tolerance: float, *, spread: bool | None = None) -> Any:
        """Return the `fem.PortAdmittance` at one or several frequencies in Hz.

        ``spread``: True for finite apertures; None as `diffracts` says.
        """
        if self.scene.in_strips:
            return fem.port_admittance(self.stator, self.transducers, frequency=frequency, tolerance=tolerance)
        return fem.port_admittance(
            self.stator, self.section_transducers, frequency=frequency, tolerance=tolerance,
            finite_apertures=self.diffracts if spread is None else spread, mirror_width=self.scene.stator.mirror_width,
        )  # fmt: skip


def model_of(scene: Scene) -> Model:
    """Return the model of a resolved scene, such as that of a record; the same object for the latest ones."""
    return Model(scene) if scene.piece else _latest(scene)


_latest = lru_cache(MAX_LATEST)(Model)


def _alone(stator: Stator, transducer: tuple, piece: tuple, drive: Drive) -> Model:
    return Model(Scene(stator=stator, transducer=transducer, piece=piece, drive=drive))


_shared_alone = lru_cache(MAX_STATORS)(_alone)


@lru_cache(MAX_DRIVES)
def at_one_volt(drive: Drive) -> Drive:
    """Return a drive at 1 V, without power, burst, waveform and duty."""
    voltage = (1.0,) if drive.levels else None
    return replace(drive, voltage=voltage, power=None, burst=None, waveform=None, duty=None)
