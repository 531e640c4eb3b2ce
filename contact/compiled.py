"""Compilation of the kernels, with a cache on disk that knows all their sources.

Numba's own cache looks at the file of the function alone: a kernel would go on using the old code of what it calls in
another file. Here the cache folder is named after a digest of every file that holds kernels or constants that they
freeze, so a change in any of them compiles anew and nothing stale is ever run.
"""

import hashlib
from functools import cache
from pathlib import Path

import numba

_FROZEN = ("collocation.py", "scaling.py")


def compiled(function):
    """Return the function compiled by numba, cached on disk; a decorator."""
    usual = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = _folder(usual)
    try:
        return numba.njit(cache=True, nogil=True)(function)
    finally:
        numba.config.CACHE_DIR = usual


@cache
def _folder(usual):
    here = Path(__file__).parent
    digest = hashlib.sha256()
    for path in sorted(here.glob("*.py")):
        text = path.read_bytes()
        if b"@compiled" in text or path.name in _FROZEN:
            digest.update(text)
    return str(Path(usual or here / "__pycache__") / f"kernels-{digest.hexdigest()[:16]}")
