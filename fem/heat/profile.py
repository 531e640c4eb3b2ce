"""Temperature along a heated plate, steady and after a time.

    rho c A T_t = k A T_xx - g T + q'(x),    k A T_x = h A T at x = 0,    k A T_x = -h A T at x = L

with the loss g per length of `HeatedPlate` and sources q' per length (the fin of Carslaw and Jaeger, section 4.2).
Spectral elements of order 12 end where a source begins or ends and are no longer than two decay lengths; the error of
smooth sources is below 1e-9. The transient is the sum over the modes of these elements, exact in time.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from fem.discretize.spectral import lagrange_values, line_nodes, reference_matrices
from fem.exceptions import InputError
from fem.heat.plate import HeatedPlate

ORDER = 12
MAX_DECAY_LENGTHS = 2.0  # of one element; e^2 within an element leaves 1e-10 at order 12
MAX_ELEMENTS = 400
POINTS, POINTS_PER_SCALE = 16, 4  # of the quadrature of a source in each element, or in each step of its scale
SAMPLES = 32  # in each element, where the highest temperature is looked for


@dataclass(frozen=True, kw_only=True)
class HeatSource:
    """A source of heat between two places.

    Attributes
    ----------
    start, stop : float
        m from the left end of the plate.
    power : float
        W, of the whole source.
    density : callable, optional
        Shape along x of the power per length at positions in m (k,) -> (k,), in any unit: it is scaled to ``power``.
        Uniform without it.
    scale : float, optional
        Length over which ``density`` changes, m: the steps of its quadrature. Those of the elements without it.
    """

    start: float
    stop: float
    power: float
    density: Callable[[np.ndarray], np.ndarray] | None = None
    scale: float | None = None


@dataclass(frozen=True, kw_only=True)
class TemperatureProfile:
    """Temperature rise along a plate.

    Attributes
    ----------
    plate : HeatedPlate
    x : ndarray, shape (n,)
        Nodes of the elements, m.
    power : float
        Of all sources, W.
    steady : ndarray, shape (n,)
        Steady rise at the nodes, K.
    breakpoints : ndarray, shape (elements + 1,)
        Ends of the elements, m.
    conduction, storage : ndarray, shape (n, n)
        Matrices of conduction and losses, W/K, and of the length, m.
    """

    plate: HeatedPlate
    x: np.ndarray = field(repr=False)
    power: float
    steady: np.ndarray = field(repr=False)
    breakpoints: np.ndarray = field(repr=False)
    conduction: np.ndarray = field(repr=False)
    storage: np.ndarray = field(repr=False)

    @cached_property
    def _modes(self) -> tuple[np.ndarray, np.ndarray]:
        """Rates of decay times storage in W/(m K), shape (n,), and mass-normalised modes (n, n)."""
        from scipy.linalg import eigh

        return eigh(self.conduction, self.storage)

    @property
    def time_constants(self) -> np.ndarray:
        """Of the modes, s, the slowest first, shape (n,)."""
        if self.plate.volumetric_heat is None:
            raise InputError("volumetric_heat", "is missing: the steady temperature needs none, its time does")
        return self.plate.volumetric_heat * self.plate.section / self._modes[0]

    def nodal(self, time: float = np.inf) -> np.ndarray:
        """Return the rise at the nodes in K, shape (n,), after a time in s from a cold start; steady without one."""
        if np.isinf(time):
            return self.steady
        _, modes = self._modes
        decayed = np.exp(-time / self.time_constants)
        return self.steady - modes @ (decayed * (modes.T @ (self.storage @ self.steady)))

    def at(self, x: ArrayLike, time: float = np.inf) -> np.ndarray:
        """Return the rise in K at positions in m, the shape of ``x``; as `nodal`."""
        positions = np.atleast_1d(np.asarray(x, dtype=float))
        if positions.min() < 0.0 or positions.max() > self.plate.length * (1 + 1e-12):
            raise InputError("x", f"must lie within the plate, 0 to {self.plate.length:g} m")
        ends, values = self.breakpoints, self.nodal(time)
        number = np.clip(np.searchsorted(ends, positions, side="right") - 1, 0, len(ends) - 2)
        local = (positions - ends[number]) / (ends[number + 1] - ends[number])
        basis = lagrange_values(ORDER, local)
        nodes = number[:, None] * ORDER + np.arange(ORDER + 1)
        return (basis * values[nodes]).sum(axis=1).reshape(np.shape(x))

    def hottest(self, time: float = np.inf) -> tuple[float, float]:
        """Return the place in m and the size in K of the highest rise."""
        ends = self.breakpoints
        inside = ends[:-1, None] + np.diff(ends)[:, None] * np.linspace(0.0, 1.0, SAMPLES, endpoint=False)
        places = np.append(inside.ravel(), ends[-1])
        rises = self.at(places, time)
        return float(places[np.argmax(rises)]), float(rises.max())

    def heat_to_surroundings(self) -> float:
        """Return what all faces take in the steady state, W: the balance says that it is `power`."""
        values = self.nodal()
        widths = np.diff(self.breakpoints)
        weights = reference_matrices(ORDER).mass.sum(axis=0)
        integral = sum(
            width * float(weights @ values[k * ORDER : (k + 1) * ORDER + 1]) for k, width in enumerate(widths)
        )
        return self.plate.loss_per_length * integral + self.plate.end_loss * float(values[0] + values[-1])


def temperature_profile(plate: HeatedPlate, sources: Sequence[HeatSource]) -> TemperatureProfile:
    """Return the temperature along a plate with sources of heat.

    Raises
    ------
    InputError
        For a source that does not lie within the plate, or has a density without a positive integral.
    """
    for each in sources:
        if not 0.0 <= each.start < each.stop <= plate.length * (1 + 1e-12):
            ends = f"{each.start:g} to {each.stop:g} m"
            raise InputError("source", f"must lie within the plate, 0 to {plate.length:g} m, got {ends}")
    breakpoints = _breakpoints(plate, sources)
    count, elements = (len(breakpoints) - 1) * ORDER + 1, len(breakpoints) - 1
    reference, stiffness, mass, load = reference_matrices(ORDER), *np.zeros((2, count, count)), np.zeros(count)
    for k in range(elements):
        width, nodes = breakpoints[k + 1] - breakpoints[k], slice(k * ORDER, (k + 1) * ORDER + 1)
        mass[nodes, nodes] += width * reference.mass
        stiffness[nodes, nodes] += plate.conductivity * plate.section / width * reference.stiffness
    stiffness += plate.loss_per_length * mass
    stiffness[[0, -1], [0, -1]] += plate.end_loss
    for each in sources:
        load += _load(each, breakpoints, count)
    return TemperatureProfile(
        plate=plate, x=line_nodes(breakpoints, ORDER), power=float(sum(each.power for each in sources)),
        steady=np.linalg.solve(stiffness, load), breakpoints=breakpoints, conduction=stiffness, storage=mass,
    )  # fmt: skip


def _breakpoints(plate: HeatedPlate, sources: Sequence[HeatSource]) -> np.ndarray:
    """Return the ends of the elements: of the plate and the sources, and between them at most two decay lengths."""
    marks = {0.0, plate.length}
    for each in sources:
        marks |= {min(each.start, plate.length), min(each.stop, plate.length)}
    longest = max(MAX_DECAY_LENGTHS * plate.decay_length, plate.length / MAX_ELEMENTS)
    ends = [0.0]
    for start, stop in pairwise(sorted(marks)):
        if stop - start < 1e-9 * plate.length:
            continue
        pieces = int(np.ceil((stop - start) / longest))
        ends += (start + (stop - start) * np.arange(1, pieces + 1) / pieces).tolist()
    ends[-1] = plate.length
    return np.array(ends)


def _load(source: HeatSource, breakpoints: np.ndarray, count: int) -> np.ndarray:
    """Return the integrals of a source's power per length with the basis functions, shape (count,)."""
    points, weights = np.polynomial.legendre.leggauss(POINTS if source.scale is None else POINTS_PER_SCALE)
    load, total = np.zeros(count), 0.0
    tiny = 1e-9 * (breakpoints[-1] - breakpoints[0])
    for k, (start, stop) in enumerate(pairwise(breakpoints)):
        if start < source.start - tiny or stop > source.stop + tiny:
            continue
        steps = 1 if source.scale is None else int(np.ceil((stop - start) / source.scale))
        local = ((np.arange(steps)[:, None] + 0.5 * (points + 1.0)) / steps).ravel()
        share = np.tile(0.5 * weights / steps, steps)
        density = 1.0 if source.density is None else np.asarray(source.density(start + (stop - start) * local))
        load[k * ORDER : (k + 1) * ORDER + 1] += (stop - start) * (share * density) @ lagrange_values(ORDER, local)
        total += (stop - start) * float((share * density).sum())
    if not total > 0.0:
        raise InputError("source.density", "must have a positive integral")
    return load * (source.power / total)
