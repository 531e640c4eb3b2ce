"""The content of a result's files: values in terms of JSON, and versions of the program and its packages.

Complex numbers become ``[re, im]``; a number that is not finite is refused, with its path.
"""

import json
import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from studies.refusal import RunError

PACKAGES = ("numpy", "scipy", "scikit-fem", "numba")


def plain(path: str, value):
    """Return a value in terms of JSON.

    Examples
    --------
    >>> plain("admittance_S", 1 + 2j)
    [1.0, 2.0]
    """
    if isinstance(value, Mapping):
        return {key: plain(f"{path}.{key}", entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(f"{path}.{index}", entry) for index, entry in enumerate(value)]
    if hasattr(value, "tolist"):
        return plain(path, value.tolist())
    if isinstance(value, complex):
        return [plain(path, value.real), plain(path, value.imag)]
    if isinstance(value, float) and not math.isfinite(value):
        raise RunError(f"the run gave {value} for {path}: the scene exceeds the range of floating-point numbers")
    return value


def write_json(file: Path, whole: dict) -> None:
    """Write what `plain` returned."""
    text = json.dumps(whole, indent=1, ensure_ascii=False, allow_nan=False)
    file.write_text(text + "\n", encoding="utf-8")


@cache
def provenance() -> dict:
    """Return the versions of the program, of Python and of the packages."""
    import platform  # 2 ms; where a result is written
    from importlib.metadata import PackageNotFoundError, version  # the same

    versions = {}
    for package in ("sawmotor", *PACKAGES):
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = "not installed"
    return {"version": versions.pop("sawmotor"), "python": platform.python_version(), **versions}
