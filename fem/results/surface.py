"""Motion of the surface: complex u_x and u_z per volt of the source, anywhere along the stator.

Under a transducer the motion is a polynomial in every column; between transducers it is a sum of modes, so that it
is known at once at any x.  The Rayleigh part is the surface mode's share of that sum.  With exp(+i omega t) a
wave that runs to +x has u_x = +i r u_z: retrograde, at the crest the surface moves against the wave.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fem.discretize.spectral import lagrange

MOST_SAMPLES = 50_000  # along the whole surface


@dataclass(frozen=True, kw_only=True)
class Stretch:
    """A uniform stretch: amplitudes of the modes.

    Attributes
    ----------
    start, stop : float
        m; infinite where the section goes on for ever.
    right, left : ndarray, shape (modes,)
        Amplitudes at the start of those going right, and at the stop of those going left; metres per volt.
    wavenumbers, backwards : ndarray, shape (modes,)
        rad/m.
    right_shapes, left_shapes : ndarray, shape (2, modes)
        u_x and u_z of each mode at the surface.
    rayleigh : ndarray of int
        Indices of the surface wave's modes.
    """

    start: float
    stop: float
    right: np.ndarray = field(repr=False)
    left: np.ndarray = field(repr=False)
    wavenumbers: np.ndarray = field(repr=False)
    backwards: np.ndarray = field(repr=False)
    right_shapes: np.ndarray = field(repr=False)
    left_shapes: np.ndarray = field(repr=False)
    rayleigh: np.ndarray

    def motion(self, x: np.ndarray, *, only: np.ndarray | None = None) -> np.ndarray:
        """u_x and u_z at places in the stretch (m), shape (2, places), of all modes or of some."""
        chosen = slice(None) if only is None else only
        total = np.zeros((2, len(x)), dtype=complex)
        if np.any(self.right):
            phases = np.exp(-1j * np.outer(self.wavenumbers[chosen], x - self.start))
            total += (self.right_shapes[:, chosen] * self.right[chosen]) @ phases
        if np.any(self.left):
            phases = np.exp(-1j * np.outer(self.backwards[chosen], x - self.stop))
            total += (self.left_shapes[:, chosen] * self.left[chosen]) @ phases
        return total


@dataclass(frozen=True, kw_only=True)
class Covered:
    """The surface under a transducer: nodal values column by column.

    Attributes
    ----------
    edges : ndarray, shape (columns + 1,)
        m.
    recover : callable
        Finds the values when they are first asked for.
    """

    edges: np.ndarray = field(repr=False)
    recover: Callable[[], np.ndarray] = field(repr=False)

    @cached_property
    def values(self) -> np.ndarray:
        """u_x and u_z at the columns' nodes, shape (columns, order + 1, 2)."""
        return self.recover()

    @property
    def start(self) -> float:
        """Left edge in m."""
        return float(self.edges[0])

    @property
    def stop(self) -> float:
        """Right edge in m."""
        return float(self.edges[-1])

    def motion(self, x: np.ndarray) -> np.ndarray:
        """u_x and u_z at places under the transducer (m), shape (2, places)."""
        columns = np.clip(np.searchsorted(self.edges, x, side="right") - 1, 0, len(self.values) - 1)
        local = (x - self.edges[columns]) / (self.edges[columns + 1] - self.edges[columns])
        basis, _ = lagrange(self.values.shape[1] - 1, local)
        return np.einsum("pi,pif->fp", basis, self.values[columns])


@dataclass(frozen=True, kw_only=True)
class SurfaceWave:
    """The driven stator's answer at one frequency, per volt of the source (peak).

    Attributes
    ----------
    frequency : float
        Hz.
    length : float
        Of the stator, m.
    pieces : tuple of Stretch and Covered, from left to right
    phase_velocity : float
        Of the surface mode on the bare surface, m/s.
    surface_ratio : float
        Its |u_x / u_z|.
    admittance : complex
        Of the driven transducer, S.
    comb_voltage_per_volt : complex
        Between the driven combs.
    power_input, power_dissipated, power_radiated : float
        W per V^2 of the source (peak), over the aperture of the driven transducer: given, sent out through the
        ends, and the rest, lost in the solid (and to an absorbing bottom and the other transducers' loads).
    power_residual : float
        Worst imbalance of a transducer's audit over the source's apparent power.
    relative_error : float
        Of the surface motion at the places asked for, from two discretisations.
    admittance_error : float
        Relative, likewise.
    unknowns : int
        Of the discretised problem that was condensed.
    resolution : str
    seconds : float
    left_out : tuple of str
    solution : object
        What `fem.field` needs to rebuild the interior.
    """

    frequency: float
    length: float
    pieces: tuple = field(repr=False)
    phase_velocity: float
    surface_ratio: float
    admittance: complex
    comb_voltage_per_volt: complex
    power_input: float
    power_dissipated: float
    power_radiated: float
    power_residual: float
    relative_error: float
    admittance_error: float
    unknowns: int
    resolution: str
    seconds: float
    left_out: tuple[str, ...]
    solution: object = field(repr=False, compare=False)

    def motion(self, x: float | np.ndarray) -> np.ndarray:
        """u_x and u_z in m per V at places x (m, from the left end), shape (2, *x.shape)."""
        return self._gather(x, lambda piece, at: piece.motion(at))

    def rayleigh_motion(self, x: float | np.ndarray) -> np.ndarray:
        """Part of the motion in the surface mode, shape (2, *x.shape).

        Raises
        ------
        ValueError
            Under a transducer, where the surface mode of the bare surface is not a solution.
        """

        def part(piece, at):
            if isinstance(piece, Covered):
                raise ValueError(
                    f"x = {at[0]:g} m lies under a transducer: the Rayleigh part is not defined there"
                )
            return piece.motion(at, only=piece.rayleigh)

        return self._gather(x, part)

    def covered(self, x: float) -> bool:
        """Whether a place lies under a transducer."""
        return any(isinstance(piece, Covered) and piece.start <= x <= piece.stop for piece in self.pieces)

    @property
    def transfer_length(self) -> float:
        """Distance in m over which the surface wave passes to the other face, half a beat of its two plate modes.

        Infinite where one mode makes up the surface wave: another bottom, or a plate thinner than it.
        """
        for piece in self.pieces:
            if isinstance(piece, Stretch) and len(piece.rayleigh) > 1:
                one, other = piece.wavenumbers[piece.rayleigh[:2]].real
                return float(np.pi / abs(one - other)) if one != other else np.inf
        return np.inf

    def normal_at(self, x: float | np.ndarray) -> np.ndarray:
        """u_z in m per V at x (m)."""
        return self.motion(x)[1]

    def tangential_at(self, x: float | np.ndarray) -> np.ndarray:
        """u_x in m per V at x (m)."""
        return self.motion(x)[0]

    def standing_wave_ratio(self, x: float) -> float:
        """Largest over smallest |u_z| within one wavelength either side of x."""
        reach = self.phase_velocity / self.frequency
        places = np.linspace(max(0.0, x - reach), min(self.length, x + reach), 401)
        size = abs(self.normal_at(places))
        return float(size.max() / size.min())

    def samples(self, per_wavelength: int = 12) -> tuple[np.ndarray, np.ndarray]:
        """Places along the whole surface (m), fewer on a very long one, and the motion there: (n,) and (2, n)."""
        step = max(self.phase_velocity / self.frequency / per_wavelength, self.length / MOST_SAMPLES)
        places = []
        for piece in self.pieces:
            start, stop = max(piece.start, 0.0), min(piece.stop, self.length)
            places.append(
                np.linspace(start, stop, max(2, int(np.ceil((stop - start) / step))), endpoint=False)
            )
        x = np.append(np.concatenate(places), self.length)
        return x, self.motion(x)

    def _gather(self, x, part):
        x = np.asarray(x, dtype=float)
        if not np.all((x >= 0) & (x <= self.length)):
            raise ValueError(f"x must lie on the stator, 0 to {self.length:g} m, got {x[()]!r} m")
        flat = x.reshape(-1)
        out = np.zeros((2, flat.size), dtype=complex)
        starts = np.array([piece.start for piece in self.pieces[1:]])
        owner = np.searchsorted(starts, flat, side="right")
        for index in np.unique(owner):
            here = owner == index
            out[:, here] = part(self.pieces[index], flat[here])
        return out.reshape(2, *x.shape)
