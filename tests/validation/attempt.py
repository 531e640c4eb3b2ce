"""One contender on the driven stator, run alone in a process of its own: answer, CPU time, peak memory.

One thread each: libraries that thread are told so before they are loaded, and none shares a process with another (two
thread pools in one process slow each other).  The time is that of the CPU: on a machine that others use too, wall time
measures them.  ``seconds`` is what one more frequency costs after ``setup_seconds``.
"""

import time
from dataclasses import dataclass, field

import numpy as np

from studies.evidence.own_process import alone, peak_memory
from tests.validation.contenders import CURVES, Problem

__all__ = ["Attempt", "attempted"]


@dataclass(frozen=True, kw_only=True)
class Attempt:
    """What a contender found.

    Attributes
    ----------
    curve : str
    setting : str
    unknowns : int
    setup_seconds, seconds : float
        CPU time before the first frequency, and of one more.
    peak_bytes : int
        Of the process.
    admittance : complex
        S.
    motion : ndarray, shape (2,)
        u_x and u_z per volt, m.
    """

    curve: str
    setting: str
    unknowns: int
    setup_seconds: float
    seconds: float
    peak_bytes: int
    admittance: complex
    motion: np.ndarray = field(repr=False)

    def errors(self, reference: tuple[complex, np.ndarray]) -> tuple[float, float]:
        """Relative errors of the admittance and of u_z, both complex."""
        admittance, motion = reference
        return abs(self.admittance / admittance - 1), abs(self.motion[1] / motion[1] - 1)


def attempted(curve: str, problem: Problem, setting: dict, *, repeats: int = 1) -> Attempt:
    """Run one contender in a fresh process.

    Parameters
    ----------
    curve : str
        Of `CURVES`.
    problem : Problem
    setting : dict
        Its resolution.
    repeats : int
        Frequencies after the first; their median time counts.  None: the first counts (nothing is reused).

    Returns
    -------
    Attempt

    Raises
    ------
    RunError
        If its process was ended, as happens where memory is short.
    """
    return alone(f"{curve}, {_words(setting)}", measured, curve, problem, setting, repeats)


def _words(setting: dict) -> str:
    return ", ".join(f"{key.replace('_', ' ')} {value}" for key, value in setting.items())


def measured(curve: str, problem: Problem, setting: dict, repeats: int) -> Attempt:
    begun = time.process_time()
    once = CURVES[curve][0](problem, **setting)
    admittance, motion, unknowns = once() if repeats else (None, None, 0)
    ready = time.process_time()
    times = []
    for _ in range(max(repeats, 1)):
        start = time.process_time()
        admittance, motion, unknowns = once()
        times.append(time.process_time() - start)
    return Attempt(
        curve=curve,
        setting=_words(setting),
        unknowns=unknowns,
        setup_seconds=ready - begun,
        seconds=float(np.median(times)),
        peak_bytes=peak_memory(),
        admittance=admittance,
        motion=np.asarray(motion),
    )
