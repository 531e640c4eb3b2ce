"""The wave field of a run that was left: read from its field.vtu, or computed anew from its scene."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from studies import resolved
from studies.chain import run
from studies.refusal import RunError, SceneError, shown
from studies.scene import Scene

__all__ = ["RunField", "run_field"]

LINES = 24  # per wavelength of a free wave, which is shown over a few of them
FREE_WAVELENGTHS = 10


@dataclass(frozen=True, kw_only=True)
class RunField:
    """A field and what stands on it.

    Attributes
    ----------
    field : fem.WaveField
        In m per V, or over u_z at the surface of a free wave.
    wavelength : float
        Of the surface wave, m.
    close : tuple of (str, float)
        What to show from near: its name and its place in m.
    fingers : dict
        Edges of the electrodes in m by sign: "+" and "-" the combs, "o" open strips.
    balls : tuple of float
        Places of the contacts, m.
    radius : float
        Of the balls, m.
    title, span, drive, label : str
        The scene's title, how much of the section it is, what the field is relative to, and the name and
        unit of the coloured quantity.
    scale : float
        From the field's u_z to that unit.
    """

    field: object = field(repr=False)
    wavelength: float
    close: tuple
    fingers: dict
    balls: tuple[float, ...]
    radius: float
    title: str
    span: str
    drive: str
    label: str
    scale: float


def run_field(folder: str | Path, *, progress: Callable[[str], None]) -> RunField:
    """Return the field of a run.

    Parameters
    ----------
    folder : str or Path
        What ``sawmotor run`` left.
    progress : callable
        Told what is being done.

    Raises
    ------
    SceneError
        If the directory holds no run, or the run has no stator.
    """
    folder = Path(folder)
    try:
        record = json.loads((folder / "run.json").read_text(encoding="utf-8"))
        tolerance = float(record["tolerance"])
    except (OSError, ValueError, KeyError, TypeError):
        raise SceneError("", f"{shown(str(folder))} is no directory that sawmotor run left") from None
    scene = Scene.load(folder / "scene.toml")
    if scene.stator is None:
        raise SceneError(
            "", f"the run in {shown(str(folder))} has no wave field: its scene gives the surface motion"
        )
    if scene.transducer:
        return _driven(folder, scene, record, tolerance, progress)
    return _free(scene, tolerance)


def _driven(folder: Path, scene: Scene, record: dict, tolerance: float, progress) -> RunField:
    import fem

    kept = folder / "field.vtu"
    if kept.is_file():
        progress("reading the field")
        field = fem.read_vtu(kept, frequency=scene.frequency)
    else:
        progress("computing the field")
        field = fem.wave_field(run(replace(scene, slider=None), tolerance=tolerance).surface_wave)
    slider = scene.slider
    driven = next(each for each in scene.transducer if each.name == scene.drive.transducer)
    close = [(f"driven transducer {driven.name!r}", driven.center)]
    close.append(("mid-stator", scene.stator.length / 2) if slider is None else ("slider", slider.position))
    rows = resolved.transducers(scene)
    return RunField(
        field=field,
        wavelength=record["wave"]["phase_velocity_m_per_s"] / scene.frequency,
        close=tuple(close),
        fingers={sign: [tuple(edges) for row in rows for edges in row.strips(sign)] for sign in "+-o"},
        balls=()
        if slider is None
        else tuple(slider.position + offset for offset in dict.fromkeys(slider.offsets)),
        radius=0.0 if slider is None else slider.radius,
        title=scene.title,
        span="the whole section",
        drive="per volt",
        label="u_z (nm per V)",
        scale=1e9,
    )


def _free(scene: Scene, tolerance: float) -> RunField:
    import numpy as np

    import fem

    try:
        wave = fem.free_wave(resolved.stator(scene.stator), frequency=scene.frequency, tolerance=tolerance)
    except fem.ConvergenceError as error:
        raise RunError(str(error)) from None
    wavelength = wave.velocity / wave.frequency
    length = min(scene.stator.length, FREE_WAVELENGTHS * wavelength)
    x = np.linspace(0, length, max(int(LINES * length / wavelength), 2) + 1)
    travelling = np.exp(-(2j * np.pi / wavelength + wave.attenuation) * x)
    motion = travelling[:, None, None] * wave.profile
    return RunField(
        field=fem.WaveField(
            x=x,
            z=wave.depth,
            displacement=motion[:, :, :3],
            potential=motion[:, :, 3],
            frequency=wave.frequency,
        ),
        wavelength=wavelength,
        close=(),
        fingers={},
        balls=(),
        radius=0.0,
        title=scene.title,
        span=f"{length / wavelength:.3g} wavelengths",
        drive="free wave",
        label="u_z, relative",
        scale=1.0,
    )
