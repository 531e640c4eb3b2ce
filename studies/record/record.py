"""The record of a run: the content of ``run.json`` as arrays, tables, pictures and files.

The modules that draw and write are imported when they are needed.
"""

from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from studies.record.blocks import (
    Effect,
    ElectricalBlock,
    ErrorBlock,
    HeatBlock,
    SummaryBlock,
    UncertaintyBlock,
    WaveBlock,
)
from studies.record.point import Point
from studies.record.quantities import quantity
from studies.record.text import answer, notebook_table
from studies.record.values import Columns, Values, as_array
from studies.refusal import EXIT_INEXACT, EXIT_NO_ANSWER, needed, refuse_unknown
from studies.results import Origin, result_directory
from studies.results.content import plain, provenance
from studies.scene import Scene
from studies.scene.toml import document

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes


# Blocks of run.json in their order, which are attributes of a record
BLOCKS = (
    "tolerance", "wave", "electrical", "points", "summary", "heat", "uncertainty", "measured", "error", "model_error",
    "warnings", "seconds", "left_out", "shortfall",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True, repr=False)
class Record:
    """The answer of a run; blocks that do not apply are empty.

    Attributes
    ----------
    scene : Scene
        As resolved: it runs again to the same numbers at the same tolerance.
    tolerance : float
        Bound of the relative error of the last quantity.
    wave, electrical, summary, heat, error : studies.record.blocks
        As in run.json: quantities in SI units, named with their unit; ``record.wave.frequency_Hz``, as of a dict
        ``record.wave["frequency_Hz"]``.  ``error``: ``relative`` and its ``parts``, those of the worst point.
    points : tuple of studies.record.point.Point
        One per voltage or prescribed amplitude; read as the blocks.
    seconds : dict
        Of each part of the chain and in ``total``.
    left_out : tuple of str
        Effects that the model neglects, and why.
    warnings : tuple of str
        Doubts about the answer, each with its number and a remedy.
    model_error : tuple of studies.record.blocks.Effect
        Neglected effects, each with its estimated ``size`` for this scene; not part of ``error``.
    uncertainty : studies.record.blocks.UncertaintyBlock
        With [uncertain]: the method of the bands, the tolerances and the effect of each on the velocity.
    measured : dict
        Measured points beside the predicted ones, from a file of measurements.
    shortfall : str
        Why this is no answer within its tolerance; empty if it is one.
    refused : bool
        True if the shortfall holds for the whole answer: a node of the wave, a field that the model does not resolve,
        or a neglected effect as large as the answer; False after `load`.
    surface : studies.record.values.Columns
        Columns of surface.csv (driven stator) or of profile.csv (free wave).
    pillars, slider_wave : studies.record.values.Columns
        Columns of pillars.csv and slider_wave.csv at the last level (slider on pillars).
    trajectories : tuple of (level, contact.Trajectory or Motion)
        With a burst.
    surface_motion : studies.solve.surface_motion.SurfaceMotion or None
        The stator's answer itself, with ``wave``, from which the interior field can be rebuilt; None after `load`.
    further_motions : tuple of studies.solve.surface_motion.SurfaceMotion
        The stator's answers at the further frequencies of its sources; empty after `load`.
    meshed_pieces : tuple of (float, float)
        Ends along x of each meshed piece without fingers, m; empty after `load`.
    versions : dict
        Of the program and its packages; those of this process when empty.

    Examples
    --------
    >>> from studies import Scene, run
    >>> contact = Scene.load("twente-contact").replace(wave={"normal_amplitude": ["0.5 nm", "10 nm"]})
    >>> record = run(contact)
    >>> [str(regime) for regime in record.regime]
    ['stick', 'intermittent']
    >>> float(record.velocity[0]), bool(record.velocity[1] > 0.05)
    (0.0, True)
    """

    scene: Scene
    tolerance: float
    wave: WaveBlock = field(default_factory=WaveBlock)
    electrical: ElectricalBlock = field(default_factory=ElectricalBlock)
    points: tuple[Point, ...] = ()
    summary: SummaryBlock = field(default_factory=SummaryBlock)
    heat: HeatBlock = field(default_factory=HeatBlock)
    error: ErrorBlock = field(default_factory=ErrorBlock)
    seconds: dict = field(default_factory=dict)
    left_out: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    model_error: tuple[Effect, ...] = ()
    uncertainty: UncertaintyBlock = field(default_factory=UncertaintyBlock)
    measured: dict = field(default_factory=dict)
    shortfall: str = ""
    refused: bool = field(default=False, repr=False, compare=False)
    surface: Columns = field(default_factory=Columns, repr=False)
    pillars: Columns = field(default_factory=Columns, repr=False)
    slider_wave: Columns = field(default_factory=Columns, repr=False)
    trajectories: tuple = field(default=(), repr=False)
    surface_motion: Any = field(default=None, repr=False, compare=False)
    further_motions: tuple = field(default=(), repr=False, compare=False)
    meshed_pieces: tuple[tuple[float, float], ...] = field(default=(), repr=False, compare=False)
    versions: dict = field(default_factory=dict, compare=False)

    def __post_init__(self) -> None:
        for each in fields(self):
            if isinstance(each.type, type) and issubclass(each.type, (Values, Columns)):  # a dict is taken too
                object.__setattr__(self, each.name, each.type.read(getattr(self, each.name)))
        object.__setattr__(self, "points", tuple(map(Point.read, self.points)))
        object.__setattr__(self, "model_error", tuple(map(Effect.read, self.model_error)))

    @property
    def level(self) -> str:
        """Key of the points for the level: voltage or amplitude."""
        return self.scene.level_column

    @property
    def moving_levels(self) -> list[float]:
        """The levels at which the slider moves, rising."""
        return sorted({point.level for point in self.points if point.velocity_m_per_s})

    def limit(self, name: str) -> float | None:
        """Return the level at the "threshold" or the "release"; None where there is none."""
        return self.summary.get(f"{name}_{self.level.removeprefix('normal_')}")

    @property
    def surface_wave(self) -> Any:
        """Plane section of the driven stator, a fem.SurfaceWave; None without one."""
        return None if self.surface_motion is None else self.surface_motion.wave

    @property
    def surface_motions(self) -> tuple:
        """Motions of the driven stator at all frequencies of its sources."""
        return (self.surface_motion, *self.further_motions)

    @property
    def at_rest(self) -> bool:
        """Whether the slider sticks at every point, so that no velocity has an error."""
        return bool(self.points) and all(point.regime == "stick" for point in self.points)

    @property
    def exit_code(self) -> int:
        """Exit code of the command: 0, 1 for an answer that misses its tolerance, 3 for no answer."""
        if not self.shortfall:
            return 0
        answered = not self.points or any(point.answered for point in self.points)
        return EXIT_INEXACT if answered else EXIT_NO_ANSWER

    @property
    def remark(self) -> str:
        """The shortfall, under the name of the same attribute of a `StudyRecord`."""
        return self.shortfall

    def to_dict(self) -> dict:
        """Return what run.json holds: plain numbers, text, lists and tables, all finite.

        Raises
        ------
        RunError
            Naming the first value that is not finite.
        """
        whole = {"title": self.scene.title, "scene": self.scene.to_table()}
        whole |= {key: getattr(self, key) for key in BLOCKS} | {"provenance": self.versions or provenance()}
        return {key: plain(key, value) for key, value in whole.items() if key == "title" or value}

    @property
    def voltage(self) -> np.ndarray:
        """Peak voltage of the source at each point, V; NaN with a prescribed wave."""
        return as_array(point.voltage_V for point in self.points)

    @property
    def normal_amplitude(self) -> np.ndarray:
        """Normal amplitude of the surface under the slider (without one: at mid-stator) at each point, m."""
        return as_array(point.normal_amplitude_m for point in self.points)

    @property
    def tangential_amplitude(self) -> np.ndarray:
        """Tangential amplitude of the surface at the same position, m."""
        return as_array(point.tangential_amplitude_m for point in self.points)

    @property
    def velocity(self) -> np.ndarray:
        """Steady velocity of the slider at each point, m/s; NaN where a point has no answer."""
        return as_array(point.velocity_m_per_s for point in self.points)

    @property
    def relative_error(self) -> np.ndarray:
        """Estimated error of each point in the sense of the tolerance; NaN where a point has no answer."""
        return as_array(point.relative_error for point in self.points)

    @property
    def regime(self) -> np.ndarray:
        """``stick``, ``slip`` or ``intermittent`` at each point; empty where a point has no answer."""
        return np.array([point.regime or "" for point in self.points], dtype=str)

    @property
    def status(self) -> np.ndarray:
        """``ok`` at each point, or why it has no answer within the tolerance."""
        return np.array([point.status or "" for point in self.points], dtype=str)

    def column(self, key: str) -> np.ndarray:
        """Return a number of every point, NaN where a point has none.

        Parameters
        ----------
        key : str
            As in the points of run.json, such as ``velocity_at_burst_end_m_per_s``.

        Raises
        ------
        SceneError
            If no point of any run has that key as a number.
        """
        words = (str, list, tuple)
        known = {name for point in self.points for name, value in point.items() if not isinstance(value, words)}
        usual = (
            quantity.voltage_V, quantity.normal_amplitude_m, quantity.tangential_amplitude_m,
            quantity.velocity_m_per_s, quantity.relative_error,
        )  # fmt: skip
        known |= {each.column for each in usual}
        refuse_unknown(key, sorted(known), key, "is no number of the points")
        return as_array(point.get(key) for point in self.points)

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the points as a pandas table, a row each; columns are the keys of ``points`` in run.json.

        Raises
        ------
        RunError
            If pandas is not installed.
        """
        return needed("pandas", "to_dataframe").DataFrame(list(self.points))

    def to_xarray(self) -> "xr.Dataset":
        """Return the points over the drive's level and the surface over x as an xarray Dataset, each with its units.

        ``scene`` of its attributes is the resolved scene, as in scene.toml. Complex numbers are two variables,
        ``..._re`` and ``..._im``, the tilts ``..._0`` and ``..._1``, as in velocity.csv.

        Raises
        ------
        RunError
            If xarray is not installed.

        Examples
        --------
        >>> from studies import run
        >>> data = run("twente-contact", tolerance=1e-2).to_xarray()
        >>> data["velocity_m_per_s"].attrs["units"], data["normal_amplitude_m"].attrs["units"]
        ('m/s', 'm')
        """
        from studies.record.files import flat, labelled_column  # imports this module

        points = [flat(point) for point in self.points]
        data = {
            key: (self.level, *labelled_column(key, [point.get(key) for point in points]))
            for key in dict.fromkeys(key for point in points for key in point)
        }
        places = {self.level: data.pop(self.level)} if data else {}
        along = quantity.x_m.column
        surface = {key: (along, *labelled_column(key, each.tolist())) for key, each in flat(self.surface).items()}
        if along in surface:
            places[along] = surface.pop(along)
            data |= surface
        about = {"title": self.scene.title, "tolerance": self.tolerance, "scene": document(self.scene.to_table())}
        return needed("xarray", "to_xarray").Dataset(data, places, about)

    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the main result: velocity over voltage, without a slider the surface, else the wave's profile.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            A new figure's without it.

        Returns
        -------
        matplotlib Axes
        """
        from studies.record.run_pictures import pictures  # imports this module

        if ax is None:
            from matplotlib import pyplot

            ax = pyplot.subplots(layout="constrained")[1]
        return next(iter(pictures(self).values()))(ax)

    def save(self, folder: str | Path, *, field: bool = False, pictures: bool = False) -> list[str]:
        """Write the files of the run into a directory; files of the user stay there.

        Parameters
        ----------
        folder : path
        field : bool
            True also writes the interior field, ``field.vtu``, which is rebuilt for it.
        pictures : bool
            True also draws the pictures.

        Returns
        -------
        list of str
            Sentences on files that were replaced, renamed or left.

        Raises
        ------
        SceneError
            If the directory cannot be written, or holds something else.
        RunError
            If another run writes there, or the disk is full.
        """
        from studies.record.files import write_run  # imports this module
        from studies.record.run_pictures import draw_run  # imports this module

        with result_directory(folder, Origin(kind="run", name=self.scene.title or "untitled")) as result:
            write_run(self, result.folder, field=field)
            result.commit()
            if pictures:
                draw_run(self, result.folder)
                result.commit()
        return result.notes

    @classmethod
    def load(cls, folder: str | Path) -> Self:
        """Read the record of a run from its directory, without the stator's field.

        Raises
        ------
        RunError
            If the directory holds no run.
        """
        from studies.record.files import read_run  # imports this module

        return cls(**read_run(Path(folder)))

    def __str__(self) -> Any:
        """Return what `sawmotor run` prints."""
        return answer(self)

    def __repr__(self) -> Any:
        """Return title, size and range of the answer on one line."""
        return f"Record({', '.join([repr(self.scene.title or 'untitled'), *self._in_short()])})"

    def _in_short(self) -> list[str]:
        parts = []
        if self.points:
            levels = [point.level for point in self.points]
            speeds = [point.velocity_m_per_s for point in self.points if point.velocity_m_per_s is not None]
            parts.append(f"{len(levels)} points, {quantity(self.level).interval(min(levels), max(levels))}")
            if speeds:
                parts.append(f"velocity {quantity.velocity_m_per_s.interval(min(speeds), max(speeds))}")
        elif self.wave.phase_velocity_m_per_s is not None:
            parts.append(f"free wave, {quantity.phase_velocity_m_per_s.with_unit(self.wave.phase_velocity_m_per_s)}")
        if self.error:
            parts.append(f"relative error {self.error.relative:.1e}")
        return [*parts, self.shortfall] if self.shortfall else parts

    def _repr_html_(self) -> str:
        """Return the points as a table for a notebook."""
        return notebook_table(self, "; ".join([self.scene.title or "untitled", *self._in_short()]))
