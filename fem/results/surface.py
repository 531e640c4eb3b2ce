"""Motion of the surface: complex u_x and u_z per volt of the drive, anywhere along the stator.

On a condensed piece the motion is a polynomial in every element; between pieces it is a sum of guided
modes, so that it is known at once at any x.  The Rayleigh part is the surface mode's share of that sum.  With
exp(+i omega t) a wave that runs to +x has u_x = +i r u_z: retrograde, at the crest the surface moves against the wave.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fem.exceptions import ConvergenceError, InputError
from fem.geometry import on_stator

MAX_SAMPLES = 50_000  # along the whole surface
PER_WAVELENGTH = 12  # samples of the surface that a file and a picture show
# m per V; a resonant PZT stator reaches 1e-8: beyond this an answer is a numerical artefact
MAX_MOTION_PER_VOLT = 1e-6
FINER = 64  # points of the interpolation between two samples


@dataclass(frozen=True, kw_only=True)
class UniformSegment:
    """A uniform segment: amplitudes of the guided modes."""

    # start, stop: m; infinite if the segment is semi-infinite
    start: float
    stop: float
    # right, left: shape (modes,): amplitudes of modes to the right at ``start`` and to the left at ``stop``, m per V
    right: np.ndarray = field(repr=False)
    left: np.ndarray = field(repr=False)
    # wavenumbers, backwards: shape (modes,); k_x of the modes to the right and of those to the left, rad/m
    wavenumbers: np.ndarray = field(repr=False)
    backwards: np.ndarray = field(repr=False)
    # right_shapes, left_shapes: shape (2, modes); u_x and u_z of each mode at the surface
    right_shapes: np.ndarray = field(repr=False)
    left_shapes: np.ndarray = field(repr=False)
    rayleigh: np.ndarray  # indices of the surface wave's modes
    beyond: bool = False  # behind a step of thickness: another section

    def motion(self, x: np.ndarray, *, only: np.ndarray | None = None) -> np.ndarray:
        """u_x and u_z at positions in the segment (m), shape (2, positions), of all modes or of some."""
        modes = slice(None) if only is None else only
        total = np.zeros((2, len(x)), dtype=complex)
        if np.any(self.right):
            phases = np.exp(-1j * np.outer(self.wavenumbers[modes], x - self.start))
            total += (self.right_shapes[:, modes] * self.right[modes]) @ phases
        if np.any(self.left):
            phases = np.exp(-1j * np.outer(self.backwards[modes], x - self.stop))
            total += (self.left_shapes[:, modes] * self.left[modes]) @ phases
        return total


@dataclass(frozen=True, kw_only=True)
class CondensedPiece:
    """A part of the surface on a condensed piece: under a transducer, on a mesh, or an end of the stator."""

    # start, stop: m
    start: float
    stop: float
    # returns the motion as a function of x (m), shape (2, positions); called on first use
    recover: Callable[[], Callable[[np.ndarray], np.ndarray]] = field(repr=False)
    # for an end without mesh: the uniform segment next to it, whose surface mode is the Rayleigh part here too
    beside: UniformSegment | None = field(default=None, repr=False)
    transducer: bool = True  # True if fingers lie on it
    index: int = 0  # number of the scatterer, or of the end (`fem.results.field_evaluation.ENDS`)

    @cached_property
    def _motion(self) -> Callable[[np.ndarray], np.ndarray]:
        return self.recover()

    def motion(self, x: np.ndarray) -> np.ndarray:
        """u_x and u_z at positions in the piece (m), shape (2, positions)."""
        return self._motion(x)


@dataclass(frozen=True, kw_only=True)
class Surface:
    """Motion of the whole surface at one frequency, per volt of the drive (peak).

    Attributes
    ----------
    frequency : float
        Hz.
    length : float
        Length of the stator, m.
    pieces : tuple of UniformSegment and CondensedPiece
        Parts of the surface, from left to right.
    phase_velocity : float
        Velocity of the surface mode on the bare surface, m/s.
    surface_ratio : float
        |u_x / u_z| of the surface mode.
    """

    frequency: float
    length: float
    pieces: tuple = field(repr=False)
    phase_velocity: float
    surface_ratio: float

    def motion(self, x: float | np.ndarray) -> np.ndarray:
        """u_x and u_z in m per V at positions x (m, from the left end), shape (2, *x.shape).

        Raises
        ------
        InputError
            If a position lies outside the stator.
        ConvergenceError
            If an amplitude is larger than any stator can reach.
        """
        return self._gather(x, lambda piece, at: piece.motion(at))

    def rayleigh_motion(self, x: float | np.ndarray) -> np.ndarray:
        """Part of the motion in the bare surface's mode, m per V, shape (2, *x.shape).

        Raises an InputError under a transducer or on a meshed piece, and the errors of `motion`.
        """

        def part(piece, at):
            segment = piece.beside if isinstance(piece, CondensedPiece) else piece
            if segment is None:
                where = "under a transducer" if piece.transducer else "on a meshed piece"
                raise InputError("x", f"= {at[0]:g} m lies {where}: the Rayleigh part is not defined there")
            return segment.motion(at, only=segment.rayleigh)

        return self._gather(x, part)

    def covered(self, x: float) -> bool:
        """True if a position lies under a transducer or on a meshed piece."""
        return any(
            isinstance(piece, CondensedPiece) and piece.beside is None and piece.start <= x <= piece.stop
            for piece in self.pieces
        )

    @property
    def meshed_pieces(self) -> tuple[tuple[float, float], ...]:
        """Ends along x in m of each meshed piece without fingers, from left to right."""
        return tuple(
            (each.start, each.stop)
            for each in self.pieces
            if isinstance(each, CondensedPiece) and each.beside is None and not each.transducer
        )

    @property
    def transfer_length(self) -> float:
        """Distance in m over which the surface wave moves to the other face: half a beat of its two plate modes.

        Infinite if the surface wave is a single mode, because of a different bottom or in a plate thinner than the
        wave.
        """
        for piece in self.pieces:
            if isinstance(piece, UniformSegment) and len(piece.rayleigh) > 1:
                one, other = piece.wavenumbers[piece.rayleigh[:2]].real
                return float(np.pi / abs(one - other)) if one != other else np.inf
        return np.inf

    def normal_at(self, x: float | np.ndarray) -> np.ndarray:
        """u_z in m per V at x (m)."""
        return self.motion(x)[1]

    def standing_wave_ratio(self, x: float) -> float:
        """Largest over smallest |u_z| within one wavelength either side of x."""
        reach = abs(self.phase_velocity) / self.frequency  # of a backward plate mode it is negative
        positions = np.linspace(max(0.0, x - reach), min(self.length, x + reach), 401)
        return standing_wave_ratio(self.normal_at(positions))

    def samples(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions along the whole surface (m), sparser on a very long one, and the motion there: (n,) and (2, n)."""
        return self._samples

    @cached_property
    def _samples(self) -> tuple[np.ndarray, np.ndarray]:
        step = max(self.phase_velocity / self.frequency / PER_WAVELENGTH, self.length / MAX_SAMPLES)
        positions = []
        for piece in self.pieces:
            start, stop = max(piece.start, 0.0), min(piece.stop, self.length)
            positions.append(np.linspace(start, stop, max(2, int(np.ceil((stop - start) / step))), endpoint=False))
        x = np.append(np.concatenate(positions), self.length)
        return x, self.motion(x)

    def _gather(self, x, part):
        """Motion ``part(piece, positions)`` of the pieces at positions x, with the errors that `motion` raises."""
        x = np.asarray(x, dtype=float)
        if rule := on_stator(x, self.length):
            raise InputError("x", rule, x[()], "m")
        flat = x.reshape(-1)
        out = np.zeros((2, flat.size), dtype=complex)
        starts = np.array([piece.start for piece in self.pieces[1:]])
        owner = np.searchsorted(starts, flat, side="right")
        for index in set(owner.tolist()):
            here = owner == index
            out[:, here] = part(self.pieces[index], flat[here])
        largest = abs(out).max(initial=0.0)
        if not largest <= MAX_MOTION_PER_VOLT:
            raise ConvergenceError(
                f"the surface would move by {largest:.3g} m per V, more than {MAX_MOTION_PER_VOLT:g} m per V: "
                "give the solid a mechanical_quality, or change the frequency slightly"
            )
        return out.reshape(2, *x.shape)


def standing_wave_ratio(samples: np.ndarray) -> float:
    """Return the largest over the smallest amplitude of a wave along a line, including minima between the samples.

    Parameters
    ----------
    samples : ndarray, shape (n,), complex
        At equal distances, ten or more of them to a wavelength.  A polynomial of degree 7 through the nearest samples
        interpolates them; between its points the smallest size is the distance of the origin from the chord.

    Examples
    --------
    >>> phase = np.linspace(-2 * np.pi, 2 * np.pi, 49)
    >>> round(standing_wave_ratio(np.exp(-1j * phase) + 0.99 * np.exp(1j * (phase + 1.0))), 1)
    199.0
    """
    count, degree = len(samples), min(7, len(samples) - 1)
    first = np.clip(np.arange(count - 1) - degree // 2, 0, count - 1 - degree)  # of the samples for each interval
    window = np.arange(degree + 1)
    coefficients = np.linalg.solve(np.vander(window, increasing=True), samples[first + window[:, None]])
    within = (np.arange(count - 1) - first)[:, None] + np.arange(FINER) / FINER
    fine = np.einsum("kij,ki->ij", within ** window[:, None, None], coefficients)
    fine = np.append(fine.ravel(), samples[-1])
    chord = np.diff(fine)
    squares = np.maximum(abs(chord) ** 2, np.finfo(float).tiny)
    nearest = np.clip(-(fine[:-1].conj() * chord).real / squares, 0.0, 1.0)
    largest, smallest = abs(fine).max(), abs(fine[:-1] + nearest * chord).min()
    return float(largest / max(smallest, np.finfo(float).eps * largest))
