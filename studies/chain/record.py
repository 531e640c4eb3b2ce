"""The record of a run: what ``run.json`` holds, and the arrays beside it.

Complex numbers become ``[re, im]``; a number that is not finite never leaves: it is refused here, by its
path.
"""

import math
from dataclasses import dataclass, field

from studies.refusal import RunError
from studies.scene import Scene

__all__ = ["Record", "plain", "provenance"]

PACKAGES = ("numpy", "scipy", "scikit-fem", "numba")


@dataclass(frozen=True, kw_only=True)
class Record:
    """What a run found; blocks that do not apply are empty.

    Attributes
    ----------
    scene : Scene
        As resolved: it runs again to the same numbers at the same tolerance.
    tolerance : float
        What was asked for.
    wave, electrical, summary : dict
        As in run.json.
    points : tuple of dict
        One per voltage or given amplitude.
    error : dict
        ``relative`` and its ``parts``, those of the worst point.
    seconds : dict
        By part of the chain.
    left_out : tuple of str
        What the model does without, and why.
    warnings : tuple of str
        What a user should know before trusting or building it, each with its number and a remedy.
    measured : dict
        Measured points beside the predicted ones, where a file of them was given.
    shortfall : str
        Why this is no answer within its tolerance; empty when it is one.
    surface : dict of str to array
        Columns of surface.csv (driven stator) or of profile.csv (free wave).
    trajectories : tuple of (level, contact.Trajectory)
        With a burst.
    surface_wave : fem.SurfaceWave or None
        The stator's answer itself, from which the interior field can be rebuilt.
    """

    scene: Scene
    tolerance: float
    wave: dict = field(default_factory=dict)
    electrical: dict = field(default_factory=dict)
    points: tuple[dict, ...] = ()
    summary: dict = field(default_factory=dict)
    error: dict = field(default_factory=dict)
    seconds: dict = field(default_factory=dict)
    left_out: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    measured: dict = field(default_factory=dict)
    shortfall: str = ""
    surface: dict = field(default_factory=dict, repr=False)
    trajectories: tuple = field(default=(), repr=False)
    surface_wave: object = field(default=None, repr=False, compare=False)

    @property
    def level(self) -> str:
        """Key of the points that says how hard the motor is driven."""
        return "normal_amplitude_m" if self.scene.wave is not None else "voltage_V"

    @property
    def at_rest(self) -> bool:
        """Whether the slider sticks at every point: then there is no velocity that could have an error."""
        return bool(self.points) and all(point.get("regime") == "stick" for point in self.points)

    def to_dict(self) -> dict:
        """Return what run.json holds: plain numbers, text, lists and tables, all finite.

        Raises
        ------
        RunError
            Naming the first value that is not finite.
        """
        whole = {
            "title": self.scene.title,
            "scene": self.scene.to_table(),
            "tolerance": self.tolerance,
            "wave": self.wave,
            "electrical": self.electrical,
            "points": self.points,
            "summary": self.summary,
            "measured": self.measured,
            "error": self.error,
            "warnings": self.warnings,
            "seconds": self.seconds,
            "left_out": self.left_out,
            "provenance": provenance(),
        }
        return {key: plain(key, value) for key, value in whole.items() if key == "title" or value}


def plain(path: str, value):
    """Return a value in terms of JSON.

    Examples
    --------
    >>> plain("admittance_S", 1 + 2j)
    [1.0, 2.0]
    """
    if isinstance(value, dict):
        return {key: plain(f"{path}.{key}", entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(f"{path}.{index}", entry) for index, entry in enumerate(value)]
    if hasattr(value, "tolist"):
        return plain(path, value.tolist())
    if isinstance(value, complex):
        return [plain(path, value.real), plain(path, value.imag)]
    if isinstance(value, float) and not math.isfinite(value):
        raise RunError(f"the run gave {value} for {path}: the scene lies beyond what the numbers can hold")
    return value


def provenance() -> dict:
    """Return the versions behind a result."""
    import platform
    from importlib.metadata import PackageNotFoundError, version

    found = {}
    for package in ("sawmotor", *PACKAGES):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return {"version": found.pop("sawmotor"), "python": platform.python_version(), **found}
