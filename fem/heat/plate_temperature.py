"""Temperature along a heated plate, steady and after a time.

    rho c A T_t = k A T_xx - g T + q'(x),    k A T_x = h A T at x = 0,    k A T_x = -h A T at x = L

with the loss g per length of `HeatedPlate` and sources q' per length (the fin of Carslaw and Jaeger, section 4.2).
Spectral elements of order 12 end where a source begins or ends and are no longer than two decay lengths; the error of
smooth sources is below 1e-9. Their inner nodes are eliminated first (static condensation), so that the cost grows with
the number of elements. The transient is a series of the modes of a rod with cooled ends (Carslaw and Jaeger, 3.9),

    phi = cos(m x) + (h/(k m)) sin(m x),    (m^2 - (h/k)^2) sin(m L) = 2 m (h/k) cos(m L),

each of which decays with rho c A/(k A m^2 + g).
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
from fem.parameters import refuse_if

ORDER = 12
MAX_DECAY_LENGTHS = 2.0  # of one element; e^2 within an element leaves 1e-10 at order 12
MAX_ELEMENTS = 400
# of the quadrature of a source in each element, or in each step of its scale; 4 err by 1e-4 at the seed, 8 by 1e-5
POINTS, POINTS_PER_SCALE = 16, 8
SAMPLES = 32  # in each element, where the highest temperature is looked for
# Modes of the transient: the last of a plate of PZT 160 mm long decays in 0.4 s, of a chip of LiNbO3 in 6 ms
MODES = 128
PER_MODE = 1  # pieces of the quadrature of a mode in each of its half waves, over the length


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
    """

    plate: HeatedPlate
    x: np.ndarray = field(repr=False)
    power: float
    steady: np.ndarray = field(repr=False)
    breakpoints: np.ndarray = field(repr=False)

    @cached_property
    def _wavenumbers(self) -> np.ndarray:
        """Wavenumbers m of the modes in 1/m, rising, by bisection: one in each interval of pi/L."""
        ratio, length = self.plate.film / self.plate.conductivity, self.plate.length
        number = np.arange(MODES)
        low, high = number * np.pi / length, (number + 1) * np.pi / length
        for _ in range(60):
            m = 0.5 * (low + high)
            above = (-1.0) ** number * ((m**2 - ratio**2) * np.sin(m * length) - 2 * m * ratio * np.cos(m * length)) > 0
            low, high = np.where(above, low, m), np.where(above, m, high)
        return high

    @property
    def time_constants(self) -> np.ndarray:
        """Of the modes, s, the slowest first, shape (`MODES`,)."""
        if self.plate.volumetric_heat is None:
            raise InputError("volumetric_heat", "is missing: the steady temperature needs none, its time does")
        return self.plate.volumetric_heat * self.plate.section / self._losses

    @property
    def _losses(self) -> np.ndarray:
        """Heat per length and kelvin that conduction and the faces take from each mode, W/(m K)."""
        return self.plate.conductivity * self.plate.section * self._wavenumbers**2 + self.plate.loss_per_length

    def _shapes(self, x: np.ndarray) -> np.ndarray:
        """Modes at positions in m, shape (positions, modes)."""
        m = self._wavenumbers
        phase = np.multiply.outer(x, m)
        return np.cos(phase) + self.plate.film / (self.plate.conductivity * m) * np.sin(phase)

    @cached_property
    def _content(self) -> np.ndarray:
        """Coefficients of the steady rise in the modes, K, shape (modes,)."""
        pieces = np.diff(self.breakpoints) * MODES * PER_MODE / self.plate.length
        ends = [
            np.linspace(*pair, int(np.ceil(n)) + 1)[:-1]
            for pair, n in zip(pairwise(self.breakpoints), pieces, strict=True)
        ]
        edges = np.append(np.concatenate(ends), self.breakpoints[-1])
        points, weights = np.polynomial.legendre.leggauss(POINTS_PER_SCALE)
        x = (edges[:-1, None] + 0.5 * np.diff(edges)[:, None] * (points + 1.0)).ravel()
        shapes, share = self._shapes(x), (0.5 * np.diff(edges)[:, None] * weights).ravel()
        return (share * self._steady_at(x)) @ shapes / (share @ shapes**2)

    def at(self, x: ArrayLike, time: float = np.inf) -> np.ndarray:
        """Return the rise in K at positions in m, the shape of ``x``, after a time in s from a cold start.

        Steady without a time.
        """
        positions = np.atleast_1d(np.asarray(x, dtype=float))
        refuse_if(
            positions.min() < 0.0 or positions.max() > self.plate.length * (1 + 1e-12),
            "x",
            f"must lie within the plate, 0 to {self.plate.length:g} m",
        )
        rises = self._steady_at(positions.ravel())
        if not np.isinf(time):
            rises = rises - self._shapes(positions.ravel()) @ (self._content * np.exp(-time / self.time_constants))
        return rises.reshape(np.shape(x))

    def _steady_at(self, positions: np.ndarray) -> np.ndarray:
        ends = self.breakpoints
        number = np.clip(np.searchsorted(ends, positions, side="right") - 1, 0, len(ends) - 2)
        local = (positions - ends[number]) / (ends[number + 1] - ends[number])
        nodes = number[:, None] * ORDER + np.arange(ORDER + 1)
        return (lagrange_values(ORDER, local) * self.steady[nodes]).sum(axis=1)

    def hottest(self, time: float = np.inf) -> tuple[float, float]:
        """Return the place in m and the size in K of the highest rise."""
        ends = self.breakpoints
        inside = ends[:-1, None] + np.diff(ends)[:, None] * np.linspace(0.0, 1.0, SAMPLES, endpoint=False)
        places = np.append(inside.ravel(), ends[-1])
        rises = self.at(places, time)
        return float(places[np.argmax(rises)]), float(rises.max())

    def heat_to_surroundings(self) -> float:
        """Return what all faces take in the steady state, W: the balance says that it is `power`."""
        values = self.steady
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
        ends = f"{each.start:g} to {each.stop:g} m"
        refuse_if(
            not 0.0 <= each.start < each.stop <= plate.length * (1 + 1e-12),
            "source",
            f"must lie within the plate, 0 to {plate.length:g} m, got {ends}",
        )
    breakpoints = _breakpoints(plate, sources)
    loads = sum((_load(each, breakpoints) for each in sources), np.zeros((len(breakpoints) - 1, ORDER + 1)))
    return TemperatureProfile(
        plate=plate, x=line_nodes(breakpoints, ORDER), power=float(sum(each.power for each in sources)),
        steady=_solved(plate, breakpoints, loads), breakpoints=breakpoints,
    )  # fmt: skip


def _solved(plate: HeatedPlate, breakpoints: np.ndarray, loads: np.ndarray) -> np.ndarray:
    """Return the steady rise at all nodes in K, of loads in W at the nodes of each element (elements, order + 1)."""
    reference, widths = reference_matrices(ORDER), np.diff(breakpoints)[:, None, None]
    matrices = plate.conductivity * plate.section / widths * reference.stiffness
    matrices = matrices + plate.loss_per_length * widths * reference.mass
    matrices[[0, -1], [0, -1], [0, -1]] += plate.end_loss
    ends, inner = [0, ORDER], np.arange(1, ORDER)
    across = matrices[:, inner[:, None], ends]
    inside = np.linalg.solve(matrices[:, inner[:, None], inner], np.dstack([across, loads[:, inner, None]]))
    whole, right = np.zeros((len(breakpoints), len(breakpoints))), np.zeros(len(breakpoints))
    schur = matrices[:, ends][:, :, ends] - across.transpose(0, 2, 1) @ inside[:, :, :2]
    known = loads[:, ends] - (across * inside[:, :, 2:]).sum(axis=1)
    for k in range(len(widths)):
        whole[k : k + 2, k : k + 2] += schur[k]
        right[k : k + 2] += known[k]
    lines = np.linalg.solve(whole, right)
    between = inside[:, :, 2] - inside[:, :, 0] * lines[:-1, None] - inside[:, :, 1] * lines[1:, None]
    return np.append(np.column_stack([lines[:-1], between]).ravel(), lines[-1])


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


def _load(source: HeatSource, breakpoints: np.ndarray) -> np.ndarray:
    """Return the integrals of a source's power per length with each element's basis, W, (elements, order + 1)."""
    points, weights = np.polynomial.legendre.leggauss(POINTS if source.scale is None else POINTS_PER_SCALE)
    load, total = np.zeros((len(breakpoints) - 1, ORDER + 1)), 0.0
    tiny = 1e-9 * (breakpoints[-1] - breakpoints[0])
    for k, (start, stop) in enumerate(pairwise(breakpoints)):
        if start < source.start - tiny or stop > source.stop + tiny:
            continue
        steps = 1 if source.scale is None else int(np.ceil((stop - start) / source.scale))
        local = ((np.arange(steps)[:, None] + 0.5 * (points + 1.0)) / steps).ravel()
        share = np.tile(0.5 * weights / steps, steps)
        density = 1.0 if source.density is None else np.asarray(source.density(start + (stop - start) * local))
        load[k] = (stop - start) * (share * density) @ lagrange_values(ORDER, local)
        total += (stop - start) * float((share * density).sum())
    refuse_if(not total > 0.0, "source.density", "must have a positive integral")
    return load * (source.power / total)
