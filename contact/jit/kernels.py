"""Whether the compiled kernels lie on disk already, or the next motion has to wait for their compiler."""

import os
from pathlib import Path

__all__ = ["how_often", "ready"]


def ready() -> bool:
    """Return True if kernels of these sources lie compiled; those of the hysteretic law may still be missing."""
    from contact.jit import compiled

    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return True
    return any(True for folder in compiled.cache_folders() for _ in Path(folder).glob("*.o"))


def how_often() -> str:
    """Return how often the kernels are compiled that are not there yet, in words."""
    from contact.jit import compiled

    return "once" if compiled.cache_folder() is not None else "at every start, for no folder can be written to"
