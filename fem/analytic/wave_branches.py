"""Bound waves of layers against their thickness: each followed from where it is bound to where it leaks.

At neighbouring thicknesses waves belong together whose motion through the depth is alike, by the largest sum of the
overlaps |int u* . u'| of all pairs; where two velocities come close and part again (an avoided crossing), the motion
thus decides, not the order.  Where a wave begins or ends to be bound its velocity is that of the slowest bulk wave of
the half-space, and the thickness is halved for.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fem.analytic.layered_wave import LayeredWave, layered_waves
from fem.exceptions import ConvergenceError
from fem.geometry import Layer
from fem.materials import Solid
from fem.parameters import InputError

DEPTHS = np.linspace(0.0, 4.0, 161)  # wavelengths below the top at which motions are compared
LEAST_OVERLAP = 0.3  # of motions that may belong to one wave; steps of a fifth of the thickness have 0.9 and more
HALVINGS = 12  # of the last step, at an end


@dataclass(frozen=True, kw_only=True)
class WaveBranch:
    """One wave at rising thicknesses of its layers.

    Attributes
    ----------
    name : str
        Of the wave where it is first bound, as in `LayeredWave`; a second wave that begins so has a number.
    factors : ndarray, shape (n,)
        Of the thicknesses of all layers.
    waves : tuple of LayeredWave
        At these factors.
    begins, ends : float or None
        Factors below and beyond which it leaks; None where it is bound at the first, or the last, factor.
    """

    name: str
    factors: np.ndarray
    waves: tuple[LayeredWave, ...]
    begins: float | None
    ends: float | None


def wave_branches(
    substrate: Solid,
    layers: Sequence[Layer],
    factors: Sequence[float],
    *,
    surface: str = "vacuum",
    frequency: float | None = None,
) -> tuple[WaveBranch, ...]:
    """Return the bound waves of layers whose thicknesses are multiplied by rising factors, each followed.

    Parameters
    ----------
    substrate : Solid
        In the stator's frame.
    layers : sequence of Layer
        From the substrate upwards.
    factors : sequence of float
        Positive and rising, of all thicknesses; at least two.
    surface, frequency
        As in `layered_waves`.

    Raises
    ------
    ConvergenceError
        If no wave is bound at any of the thicknesses.

    Examples
    --------
    >>> import fem
    >>> film = fem.Layer(solid=fem.material("PZT-8"), wavelengths=1.0)
    >>> silicon = fem.material("silicon (cubic)")
    >>> branches = fem.wave_branches(silicon, [film], [0.1, 0.2, 0.3])
    >>> [(each.name, len(each.waves)) for each in branches]
    [('Rayleigh', 3), ('Sezawa', 3), ('sagittal 3', 1)]
    """
    rising = np.array(factors, dtype=float)
    if len(rising) < 2 or np.any(np.diff(rising, prepend=0.0) <= 0.0):
        raise InputError("factors", "must be at least two that are positive and rise", list(factors))

    def waves_at(factor: float) -> tuple[LayeredWave, ...]:
        scaled = [_scaled(each, factor) for each in layers]
        try:
            return layered_waves(substrate, scaled, surface=surface, frequency=frequency)
        except ConvergenceError:
            return ()

    rows: list[list[tuple[float, LayeredWave]]] = []
    begun: list[float | None] = []
    ended: list[float | None] = []
    before: list[int] = []  # branches at the last factor, in the order of its waves
    waves_before: tuple[LayeredWave, ...] = ()
    for number, factor in enumerate(rising):
        waves = waves_at(float(factor))
        pairs = _pairs(waves_before, waves)
        new = [k for k in range(len(waves)) if k not in pairs]
        now = [before[pairs[k]] if k in pairs else len(rows) + new.index(k) for k in range(len(waves))]
        last = float(rising[number - 1]) if number else None
        for k in new:
            rows.append([])
            begun.append(None if last is None else _end(waves_at, waves[k], last, float(factor)))
            ended.append(None)
        for branch in set(before) - set(now):
            ended[branch] = _end(waves_at, rows[branch][-1][1], float(factor), float(last or 0.0))
        for branch, wave in zip(now, waves, strict=True):
            rows[branch].append((float(factor), wave))
        before, waves_before = now, waves
    if not rows:
        thinnest = [_scaled(each, float(rising[0])) for each in layers]
        layered_waves(substrate, thinnest, surface=surface, frequency=frequency)  # raises, and says why
    names = _distinct([row[0][1].name for row in rows])
    return tuple(
        WaveBranch(
            name=name, factors=np.array([factor for factor, _ in row]), waves=tuple(wave for _, wave in row),
            begins=begins, ends=ends,
        )
        for name, row, begins, ends in zip(names, rows, begun, ended, strict=True)
    )  # fmt: skip


def _scaled(layer: Layer, factor: float) -> Layer:
    if layer.wavelengths is not None:
        return replace(layer, wavelengths=factor * layer.wavelengths)
    return replace(layer, thickness=factor * (layer.thickness or 0.0))


def _overlaps(before: Sequence[LayeredWave], after: Sequence[LayeredWave]) -> np.ndarray:
    """Return |int u* . u'| of normalised motions, (before, after)."""
    motions = []
    for waves in (before, after):
        u = np.array([each.profile(DEPTHS)[0].ravel() for each in waves])
        motions.append(u / np.linalg.norm(u, axis=1, keepdims=True))
    return abs(motions[0].conj() @ motions[1].T)


def _pairs(before: Sequence[LayeredWave], after: Sequence[LayeredWave]) -> dict[int, int]:
    """Return which of the waves before each of the waves after continues."""
    from scipy.optimize import linear_sum_assignment

    if not before or not after:
        return {}
    overlaps = _overlaps(before, after)
    rows, columns = linear_sum_assignment(overlaps, maximize=True)
    return {int(k): int(j) for j, k in zip(rows, columns, strict=True) if overlaps[j, k] > LEAST_OVERLAP}


def _end(waves_at: Callable, wave: LayeredWave, without: float, bound: float) -> float:
    """Return the factor between one where a wave leaks and one where it is bound, by halving."""
    for _ in range(HALVINGS):
        middle = 0.5 * (without + bound)
        waves = waves_at(middle)
        alike = _pairs((wave,), waves)
        if alike:
            bound, wave = middle, waves[next(iter(alike))]
        else:
            without = middle
    return 0.5 * (without + bound)


def _distinct(names: Sequence[str]) -> list[str]:
    """Return names with a number where they repeat."""
    distinct = []
    for at, name in enumerate(names):
        earlier = names[:at].count(name)
        distinct.append(f"{name} ({earlier + 1})" if earlier else name)
    return distinct
