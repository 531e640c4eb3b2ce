"""The periodic wave: velocity and shape of the surface wave in one wavelength of a meshed half-space.

Find (u, phi), periodic in x, with the weak form of forms.py on the cell of periodic_cell.py,

    K(v, u) = omega^2 M(v, u),

and take the pair nearest the named shift.  Real sines and cosines come in pairs, of which one combination
travels as exp(-i k x); the velocity is that of the mean of the pair.

Limits: errors of the velocity are O(h^(2 order)) plus exp(-2 decay depth).  Without loss.  Depth and grid
are in wavelengths: a half-space has no dispersion, so the wavelength sets the frequency only.  Low orders
lock as nu goes to 1/2 (order 2: 1 %), order 8 does not; the floor is then the rounding of the stiffness
itself.
"""

from dataclasses import dataclass, field

import numpy as np

from fem.analytic.half_space import rayleigh, surface_named
from fem.convergence import ConvergenceError
from fem.materials import Solid, fields
from fem.materials.medium import medium
from studies.evidence.peers.periodic_cell import PeriodicCell, graded_heights

_DECAYED = 17.0  # nepers of amplitude; its square, 2e-15, times a factor below 1e3 reaches the velocity
_SHIFT = 0.999  # of the velocity of the half-space: near, but no eigenvalue
_RITZ_VECTORS = 6
_ITERATIONS = 60
_LARGEST_RESIDUAL = 1e-5  # relative; a spurious Ritz vector is off by order one
_LARGEST_BACKWARD = 0.3  # two vectors that are not sine and cosine of one wave leave order one


@dataclass(frozen=True, kw_only=True)
class PeriodicWave:
    """A surface wave of the periodic cell, normalised to u_z = 1 at the surface.

    Attributes
    ----------
    solid : Solid
    surface : str
        "open" (D_n = 0), "metallised" (phi = 0) or "vacuum".
    wavelength : float
        m.
    velocity : float
        m/s.
    displacement : ndarray, shape (3,), complex
        u_x, u_y, u_z at the surface.
    potential : complex
        V per m of u_z at the surface.
    residual : float
        |K x - omega^2 M x| / |omega^2 M x| of the eigenpair.
    relative_error : float
        Of the velocity: its distance from the half-space without a mesh.
    backward : float
        Amplitude of exp(+i k x) in the wave, relative to exp(-i k x).
    unknowns : int
        Of the eigenproblem.
    """

    solid: Solid
    surface: str
    wavelength: float
    velocity: float
    displacement: np.ndarray
    potential: complex
    relative_error: float
    residual: float
    backward: float
    unknowns: int
    _cell: PeriodicCell = field(repr=False)
    _shape: np.ndarray = field(repr=False)

    @property
    def frequency(self) -> float:
        """Hz."""
        return self.velocity / self.wavelength

    @property
    def surface_ratio(self) -> float:
        """|u_x / u_z| at the surface."""
        return float(abs(self.displacement[0]))

    def profile(self, depth) -> tuple[np.ndarray, np.ndarray]:
        """Return displacement and potential against depth, on the elements' own polynomials.

        Parameters
        ----------
        depth : array_like, shape (n,)
            Below the surface, in wavelengths; not below the cell.

        Returns
        -------
        displacement : ndarray, shape (n, 3), complex
        potential : ndarray, shape (n,), complex
            V per m of u_z at the surface.
        """
        return self._cell.at_depth(self._shape, depth)


def periodic_wave(
    solid: Solid,
    wavelength: float,
    *,
    order: int,
    surface: str = "open",
    elements: tuple[int, int | None] = (1, None),
    depth: float | None = None,
    grading: float = 8.0,
    shift: float | None = None,
) -> PeriodicWave:
    """Return the surface wave of a periodic cell one wavelength long.

    Parameters
    ----------
    solid : Solid
        In the frame x along the propagation, z out of the surface; its losses are ignored.
    wavelength : float
        m.
    order : int
        Polynomial order of the elements in both directions.
    surface : str
        "open", "metallised", "vacuum" or "free".
    elements : (int, int or None)
        Columns along half a wavelength and layers through the depth; layers of two wavelengths on average, at
        least 4, if absent.
    depth : float, optional
        Of the cell, in wavelengths; where the wave of the half-space has decayed to 4e-8 if absent.
    grading : float
        Lowest layer over uppermost layer: the total ratio, however many layers.
    shift : float, optional
        Velocity in m/s near which to look; just below that of the half-space without a mesh if absent.

    Returns
    -------
    PeriodicWave

    Raises
    ------
    ValueError
        For a grid or a wavelength that is not positive, or an unknown surface.
    ConvergenceError
        If no eigenpair near the shift has a small residual and the form of a travelling wave.
    """
    guess = rayleigh(solid, surface_named(surface))
    shift = _SHIFT * guess.velocity if shift is None else shift
    depth = _DECAYED / guess.slowest_decay if depth is None else depth
    scales = {"wavelength": (wavelength, "m"), "depth": (depth, "wavelengths"), "shift": (shift, "m/s")}
    for name, (value, unit) in (scales | {"grading": (grading, "")}).items():
        if not (np.isfinite(value) and value > 0):
            raise ValueError(f"{name} must be positive and finite, got {value!r} {unit}".rstrip())
    columns, layers = elements
    layers = max(4, int(np.ceil(depth / 2))) if layers is None else layers
    for name, value in {"order": order, "columns": columns, "layers": layers}.items():
        if value < 1 or int(value) != value:
            raise ValueError(f"{name} must be an integer of at least 1, got {value!r}")
    surface = guess.surface
    names = fields(solid)
    body = medium(solid, names, lossy=False)
    cell = PeriodicCell(body, surface, order, columns, graded_heights(layers, depth, grading))
    unit = np.sqrt(1.0 / body.inertia[0])  # m/s
    stiffness, inertia = cell.matrices()
    if stiffness.shape[0] < 2 * _RITZ_VECTORS or order * columns < 2:
        raise ValueError(f"order, columns and layers give too few unknowns, got {order}, {columns}, {layers}")
    eigenvalue, pair, residual = _pair_near(stiffness, inertia, (2 * np.pi * shift / unit) ** 2)
    shape, backward = cell.travelling(pair)
    if residual > _LARGEST_RESIDUAL or backward > _LARGEST_BACKWARD:
        raise ConvergenceError(
            f"no wave near {shift:.6g} m/s: residual {residual:.1e} (allowed {_LARGEST_RESIDUAL:g}), "
            f"backward part {backward:.1e} (allowed {_LARGEST_BACKWARD:g}); try a nearer shift or finer grid"
        )
    at_surface, potential = cell.at_depth(shape, [0.0])
    scale = at_surface[0, 2]
    velocity = float(np.sqrt(eigenvalue) * unit / (2 * np.pi))
    return PeriodicWave(
        solid=solid,
        surface=surface,
        wavelength=wavelength,
        velocity=velocity,
        displacement=at_surface[0] / scale,
        potential=complex(potential[0] / scale),
        relative_error=abs(velocity / guess.velocity - 1),
        residual=residual,
        backward=backward,
        unknowns=stiffness.shape[0],
        _cell=cell,
        _shape=shape / scale,
    )


def _pair_near(stiffness, inertia, shift: float) -> tuple[float, np.ndarray, float]:
    """Mean eigenvalue, vectors (n, 2) and residual of the pair nearest a shift, by inverse iteration."""
    from scipy.linalg import eigh
    from scipy.sparse.linalg import splu

    factors = splu(
        (stiffness - shift * inertia).tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.01,
        options={"SymmetricMode": True},
    )
    rng = np.random.default_rng(20)
    vectors = rng.standard_normal((stiffness.shape[0], _RITZ_VECTORS))
    before = np.inf
    for _ in range(_ITERATIONS):
        vectors = factors.solve(inertia @ vectors)
        vectors = np.linalg.qr(vectors)[0]
        values, combination = eigh(vectors.T @ (stiffness @ vectors), vectors.T @ (inertia @ vectors))
        nearest = np.argsort(abs(values - shift))[:2]
        vectors = vectors @ combination
        now = values[nearest].mean()
        if abs(now - before) < 1e-14 * abs(now):
            break
        before = now
    pair = vectors[:, nearest]
    inertial = inertia @ (pair * values[nearest])
    residual = float(np.linalg.norm(stiffness @ pair - inertial) / np.linalg.norm(inertial))
    return now, pair, residual
