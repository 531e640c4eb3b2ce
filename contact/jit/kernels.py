"""Whether the compiled kernels lie on disk already, or the next motion has to wait for their compiler, once."""

import os
from pathlib import Path

__all__ = ["keeps", "ready"]


def keeps() -> bool:
    """Return whether compiled kernels can be kept on disk: where not, every process compiles them again."""
    from contact.jit import compiled

    folder = Path(compiled._folder())
    nearest = next((each for each in (folder, *folder.parents) if each.exists()), None)
    return nearest is not None and os.access(nearest, os.W_OK)


def ready() -> bool:
    """Return whether kernels of these sources lie compiled; those of the hysteretic law may still be missing."""
    from contact.jit import compiled

    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return True
    return any(Path(compiled._folder()).glob("*.o"))
