"""The steady approach for callers in Python, as machine code: numba alone takes four times as long to compile it."""

import numpy as np

from contact.jit.compiled import native
from studies.export.reduced_motor import bounce


def steady_approach(p: np.ndarray, tables: np.ndarray, drive: int, s: float, preload: float, hops: int) -> float:
    """Return the mean approach in m at which <P> is the preload, as `bounce.steady_approach`."""
    found = np.empty(1)
    _write_steady_approach(p, tables, drive, float(s), float(preload), hops, found)
    return float(found[0])


@native("f1 f1 i f f i f1", {"found": "1"})
def _write_steady_approach(p, tables, drive, s, preload, hops, found):
    found[0] = bounce.steady_approach(p, tables, drive, s, preload, hops)
    return 0
