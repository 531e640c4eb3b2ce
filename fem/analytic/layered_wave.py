"""Bound waves of layers on a half-space: all of them, named, with their motion against depth.

Each eigenvalue of the surface's impedance (layered.py) falls with v and jumps from -inf to +inf at a pole, where the
stack resonates with its top held. On a circle that joins -inf to +inf all eigenvalues turn one way, and each passage
through zero is a wave (the count of Wittrick and Williams, Q. J. Mech. Appl. Math. 24 (1971) 263). Intervals are halved
until the eigenvalues turn little in each; so no wave is missed, and none is found at a pole. Only waves slower than the
slowest bulk wave of the half-space are bound; a faster one leaks and is refused.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from fem.analytic.half_space import BELOW_LIMIT, HalfSpaceWave, automatic_period, rayleigh, surface_named
from fem.analytic.layered import LayeredImpedance, Stack
from fem.exceptions import ConvergenceError
from fem.geometry import Layer, Stator
from fem.materials import Solid
from fem.parameters import InputError, non_negative

# velocities of the first search: in all, and of layers; 16 a wavelength missed the second wave of three of gold on Si
GRID, GRID_PER_WAVELENGTH, MAX_GRID = 48, 128, 8000
SHORTED_GRID, LOWEST_SHORTED = 5, 0.8  # velocities of the search for a shorted wave, and their range below the free one
SHORTEST = 1e-9  # rad: shorter intervals with a wave beside a pole are not searched any further
SCALE, NOISE = 0.3, 1e-12  # typical eigenvalue, and rounding of one, over the half-space's stiffest modulus
MAX_ROTATION = 1.5  # of the eigenvalues within an interval, rad
MAX_RISE = 3.0  # of an eigenvalue at a fixed frequency, rad per rad; aluminium on 128YX: 0.4
MAX_INTERVALS = 50_000  # of one pass; more are not narrowed by halving
NOT_SHORTED = -1  # in place of the number of layers above an electrode
MAX_WAVELENGTHS = 3.0  # a thicker layer holds the whole wave


@dataclass(frozen=True, kw_only=True)
class LayeredWave:
    """A wave bound to layers on a half-space, normalised to u_z = 1 at the top (u_y = 1 for a transverse wave).

    Attributes
    ----------
    name : str
        "Rayleigh", "Sezawa" and "sagittal 3" and so on; "Love", "Love 2" and so on; from slow to fast.
    surface : str
        "vacuum", "open" or "metallised".
    shorted : int or None
        Number of layers above an electrode that is shorted at an interface.
    velocity : float
        m/s.
    limiting_velocity : float
        Of the slowest bulk wave of the half-space along the surface, m/s.
    displacement : ndarray, shape (3,), complex
        u_x, u_y, u_z at the top.
    potential : complex
        V per m of displacement, at the top.
    impedance, stack : LayeredImpedance, Stack
        Of the layers, and at this velocity.
    amplitude : ndarray, shape (fields,), complex
        Scaled fields at the top.
    """

    name: str
    surface: str
    shorted: int | None
    velocity: float
    limiting_velocity: float
    displacement: np.ndarray
    potential: complex
    impedance: LayeredImpedance = field(repr=False, compare=False)
    stack: Stack = field(repr=False, compare=False)
    amplitude: np.ndarray = field(repr=False, compare=False)

    @property
    def surface_ratio(self) -> float:
        """|u_x / u_z| at the top."""
        return float(abs(self.displacement[0] / self.displacement[2]))

    @property
    def thickness(self) -> float:
        """Of all layers, in wavelengths."""
        return float(self.stack.depth.sum() / (2.0 * np.pi))

    def profile(self, depth) -> tuple[np.ndarray, np.ndarray]:
        """Return displacement (n, 3) and potential (n,) in V/m at depths (n,) below the top, in wavelengths."""
        depth = np.atleast_1d(np.asarray(depth, dtype=float))
        non_negative("depth", depth.min(initial=0.0), "wavelengths")
        impedance, top = self.impedance, self.amplitude
        remaining = 2.0 * np.pi * depth  # k times the depth below the top of the layer at hand
        values, inside = np.zeros((len(depth), len(top)), dtype=complex), np.ones(len(depth), dtype=bool)
        velocity = np.array([self.velocity])
        for number, (waves, reflection, displacement) in reversed(list(enumerate(self.stack.parts))):
            down = np.linalg.solve(displacement[0], top)
            up, height = reflection[0] @ down, waves.depth[0]
            here = inside & (remaining <= height)
            below = np.exp(1j * waves.wavenumber_down[0] * remaining[here, None]) * down
            above = np.exp(-1j * waves.wavenumber_up[0] * (height - remaining[here, None])) * up
            values[here] = below @ waves.down[0].T + above @ waves.up[0].T
            inside, remaining = inside & ~here, remaining - height
            bottom = waves.down[0] @ (waves.factor_down[0, 0] * down) + waves.up[0] @ up
            traction = waves.down_traction[0] @ (waves.factor_down[0, 0] * down) + waves.up_traction[0] @ up
            compliance = impedance.bond_compliance(number, velocity)
            top = bottom if compliance is None else bottom - compliance[0] @ traction
        values[inside] = impedance.decayed(self.velocity, top, remaining[inside])
        return impedance.expanded(values)


def layered_waves(
    substrate: Solid,
    layers: Sequence[Layer],
    *,
    surface: str = "vacuum",
    shorted: int | None = None,
    frequency: float | None = None,
    number: int | None = None,
) -> tuple[LayeredWave, ...]:
    """Return all bound waves of layers on a half-space, from slow to fast.

    Parameters
    ----------
    substrate : Solid
        In the frame x along the propagation, z out of the surface; losses are ignored.
    layers : sequence of Layer
        From the substrate upwards; the last is the surface.
    surface : str
        "vacuum" (or "free"), "open" (D_n = 0), "metallised" (phi = 0) at the top.
    shorted : int, optional
        An electrode with phi = 0 below so many layers; 0 is the same as ``surface="metallised"``.
    frequency : float, optional
        Hz; needed for layers with a thickness in m and for bonds.
    number : int, optional
        Only so many of the slowest waves.

    Raises
    ------
    InputError
        For an unknown surface, an electrode that is at no interface, or a missing frequency.
    ConvergenceError
        If no wave is bound: what propagates leaks into the half-space.
    """
    surface = surface_named(surface)
    if shorted == 0:
        surface, shorted = "metallised", None
    if shorted is not None and not 1 <= shorted <= len(layers):
        raise InputError("shorted", f"must be the number of layers above the electrode, 0 to {len(layers)}", shorted)
    impedance = LayeredImpedance(substrate, layers, frequency=frequency)

    def eigenvalues(velocity: np.ndarray, plane: np.ndarray) -> np.ndarray:
        top = impedance.stack(velocity, plane).impedance
        return np.linalg.eigvalsh(impedance.mechanical(top, surface=surface))

    waves_across = float(impedance.stack(np.array([impedance.slowest()])).depth.sum()) / (2.0 * np.pi)
    points = min(GRID + int(GRID_PER_WAVELENGTH * waves_across), MAX_GRID)
    plane = NOT_SHORTED if shorted is None else shorted
    found = _brackets(eigenvalues, impedance, impedance.slowest(), impedance.limit, points, (plane,))
    brackets = sorted(found)[:number]
    if not brackets:
        thickest = max(layers, key=lambda each: each.thickness or each.wavelengths or 0.0, default=None)
        what = "" if thickest is None else f" {thickest.solid.name} on"
        raise ConvergenceError(
            f"no bound wave:{what} {substrate.name} makes every wave faster than the half-space's slowest bulk wave, "
            f"{impedance.limit:.1f} m/s: it leaks. A thinner or slower layer, or another orientation, helps"
        )
    roots = sorted(zip(_roots(eigenvalues, brackets), (index for _, _, index, _ in brackets), strict=True))
    return tuple(_named([_wave(impedance, velocity, index, surface, shorted) for velocity, index in roots]))


def shorted_velocity(wave: LayeredWave, shorted: int) -> float:
    """Return the velocity in m/s of a free wave once an electrode below so many layers holds phi = 0; 0 is at the top.

    See `shorted_velocities`.
    """
    return float(shorted_velocities(wave, (shorted,))[0])


def shorted_velocities(wave: LayeredWave, planes: Sequence[int]) -> np.ndarray:
    """Return the velocities in m/s of a free wave with an electrode that holds phi = 0 in each of some planes alone.

    ``planes``: numbers of layers above the electrode, 0 at the top.  A short lowers every wave, at most to the velocity
    of the one below it (interlacing of a problem with one constraint more), and so is looked for just below.

    Raises
    ------
    ConvergenceError
        If no wave lies within a fifth below the free one.
    """
    impedance = wave.impedance
    if not impedance.electric:
        return np.full(len(planes), wave.velocity)

    def eigenvalues(velocity: np.ndarray, planes: np.ndarray) -> np.ndarray:
        top = impedance.stack(velocity, planes).impedance
        free, held = (impedance.mechanical(top, surface=each) for each in (wave.surface, "metallised"))
        return np.linalg.eigvalsh(np.where(planes[:, None, None] == 0, held, free))

    highest = min(wave.velocity * (1.0 + 1e-12), impedance.limit * (1.0 - BELOW_LIMIT))
    lowest = LOWEST_SHORTED * wave.velocity
    brackets = _brackets(eigenvalues, impedance, lowest, highest, SHORTED_GRID, planes)
    if missing := set(planes) - {plane for *_, plane in brackets}:
        where = f"with an electrode below {min(missing)} layers" if min(missing) else "with a metallised surface"
        raise ConvergenceError(f"no wave {where} within a fifth below the free one, {wave.velocity:.6g} m/s")
    return _roots(eigenvalues, [max(each for each in brackets if each[-1] == plane) for plane in planes])


def principal_wave(waves: Sequence[LayeredWave]) -> LayeredWave:
    """Return the first wave with sagittal motion, which for a vanishing film is the Rayleigh wave.

    Raises
    ------
    ConvergenceError
        If there are transverse waves alone.
    """
    for each in waves:
        if not each.name.startswith("Love"):
            return each
    raise ConvergenceError("only transverse (Love) waves are bound: the wave with sagittal motion leaks")


def _brackets(
    eigenvalues: Callable, impedance: LayeredImpedance, low: float, high: float, points: int, planes: Sequence[int]
) -> list[tuple[float, float, int, int]]:
    """Return intervals in m/s with one wave each, the index of the eigenvalue that is zero there, and the plane.

    ``eigenvalues``: of velocities (v,) in m/s and the plane of the electrode for each, see `shorted_velocities`.
    """
    # At a fixed wavenumber every eigenvalue falls with the velocity, by its kinetic energy.  At a fixed frequency a
    # slower wave sees thicker layers, and an eigenvalue may rise: through zero for a wave whose energy runs backwards.
    limit, rise = impedance.limit, MAX_RISE if impedance.absolute else 0.0
    # in the angle whose sine is v over the limit the impedance is smooth up to the limit
    first, last = np.arcsin(low / limit), np.arcsin(min(high / limit, 1.0 - BELOW_LIMIT))
    angles = np.linspace(first, last, points)
    if impedance.absolute:  # resonances of a layer follow each other evenly in 1/v
        slowness = np.linspace(1.0 / np.sin(last), 1.0 / np.sin(first), points)
        angles = np.union1d(angles, np.arcsin(1.0 / slowness[1:-1]))
    values = eigenvalues(limit * np.sin(np.tile(angles, len(planes))), np.repeat(planes, len(angles)))
    todo, found = [], []
    for plane, of_plane in zip(planes, values.reshape(len(planes), len(angles), -1), strict=True):
        todo += [(*each, plane) for each in zip(angles[:-1], angles[1:], of_plane[:-1], of_plane[1:], strict=True)]
    while todo:
        cut = []
        for a, b, at_a, at_b, plane in todo:
            poles, rotation = _poles(at_a, at_b, rise * (b - a))
            below = int(np.sum(at_a < 0.0))
            crossings = int(np.sum(at_b < 0.0)) - below + poles
            ends = limit * np.sin(a), limit * np.sin(b)
            if rotation < MAX_ROTATION and (crossings == 0 or (abs(crossings) == 1 and poles == 0)):
                if crossings:
                    found.append((*ends, below if crossings > 0 else below - 1, plane))
            elif b - a > SHORTEST:
                cut.append((a, b, at_a, at_b, plane))
            elif poles == 0:  # waves that coincide
                found += [(*ends, below + k, plane) for k in range(crossings)]
        if len(cut) > MAX_INTERVALS:
            raise ConvergenceError(f"the waves between {low:.6g} and {high:.6g} m/s could not be told apart")
        middles = np.array([0.5 * (a + b) for a, b, *_ in cut])
        between = eigenvalues(limit * np.sin(middles), np.array([each[-1] for each in cut])) if cut else ()
        todo = []
        for (a, b, at_a, at_b, plane), middle, at_middle in zip(cut, middles, between, strict=True):
            todo += [(a, middle, at_a, at_middle, plane), (middle, b, at_middle, at_b, plane)]
    return found


def _poles(before: np.ndarray, after: np.ndarray, rise: float) -> tuple[int, float]:
    """Return how many eigenvalues jumped from -inf to +inf between two velocities, and their rotation altogether.

    Eigenvalues are points arctan(value/SCALE) on a circle of circumference pi, which all turn one way as the velocity
    rises, but for ``rise`` in rad. The least number of jumps is taken for which every other eigenvalue falls; it is
    right where the rotation is small.
    """
    count, (start, end) = len(before), np.arctan(np.stack([before, after]) / SCALE)
    allowed = NOISE / SCALE + rise
    poles = next(q for q in range(count + 1) if np.all(end[: count - q] <= start[q:] + allowed))
    return poles, float(np.sum(start - end) + np.pi * poles)


def bound_wave(stator: Stator, frequency: float, surface: str | None = None) -> HalfSpaceWave | LayeredWave:
    """Return the wave that a stator guides at its surface as if its solid were a half-space: `rayleigh`, with layers.

    Parameters
    ----------
    stator : Stator
        In which the absorption of its solids is ignored.
    frequency : float
        Hz; without layers it does not matter.
    surface : str, optional
        "vacuum", "open" (D_n = 0) or "metallised"; by default that of the bare surface.

    Raises
    ------
    ConvergenceError
        If no wave with sagittal motion is bound.
    """
    surface = surface or stator.bare_surface
    if not stator.layers:
        return rayleigh(stator.solid, surface)
    return _bound_wave(stator.solid, stator.layers, frequency, surface)


def bound_period(stator: Stator, frequency: float, metallisation: float) -> float:
    """Return the period in m that fingers on a stator need at a frequency in Hz: `automatic_period`, with layers.

    It is the wavelength of the bound wave whose velocity is (metallisation v_shorted + (1 - metallisation) v_vacuum),
    shorted in the plane of the fingers.
    """
    if not stator.layers:
        return automatic_period(stator.solid, frequency, metallisation)
    wave = _bound_wave(stator.solid, stator.layers, frequency, "vacuum")
    shorted = shorted_velocity(wave, stator.plane)
    return (metallisation * shorted + (1 - metallisation) * wave.velocity) / frequency


@lru_cache(maxsize=256)
def _bound_wave(substrate: Solid, layers: tuple[Layer, ...], frequency: float, surface: str) -> LayeredWave:
    return principal_wave(layered_waves(substrate, layers, surface=surface, frequency=frequency))


def _roots(eigenvalues: Callable, brackets: Sequence[tuple[float, float, int, int]]) -> np.ndarray:
    """Return the velocities in m/s at which the eigenvalues of some of `_brackets` are zero, (n,)."""
    from scipy.optimize.elementwise import find_root

    def of_index(velocity: np.ndarray, index: np.ndarray, plane: np.ndarray) -> np.ndarray:
        return np.take_along_axis(eigenvalues(velocity, plane), index[:, None], 1)[:, 0]

    low, high, *labels = map(np.array, zip(*brackets, strict=True))
    tolerances = {"xatol": 0.0, "xrtol": 4e-15, "fatol": 0.0, "frtol": 0.0}
    return find_root(of_index, (low, high), args=tuple(labels), tolerances=tolerances).x


def _wave(impedance: LayeredImpedance, velocity: float, index: int, surface: str, shorted: int | None) -> LayeredWave:
    stack = impedance.stack(np.array([velocity]), shorted)
    amplitude = impedance.mode(stack.impedance[0], index, surface=surface)
    displacement, potential = impedance.expanded(amplitude)
    transverse = 2.0 * abs(displacement[1]) ** 2 > np.linalg.norm(displacement) ** 2
    scale = displacement[1 if transverse else 2]
    return LayeredWave(
        name="Love" if transverse else "Rayleigh", surface=surface, shorted=shorted, velocity=velocity,
        limiting_velocity=impedance.limit, displacement=displacement / scale, potential=complex(potential / scale),
        impedance=impedance, stack=stack, amplitude=amplitude / scale,
    )  # fmt: skip


def _named(waves: Sequence[LayeredWave]):
    """Yield the waves with names: the sagittal ones are Rayleigh, Sezawa, sagittal 3 and so on."""
    counts = {"Love": 0, "Rayleigh": 0}
    for each in waves:
        counts[each.name] += 1
        number = counts[each.name]
        if each.name == "Love":
            yield replace(each, name="Love" if number == 1 else f"Love {number}")
        else:
            yield replace(each, name=("Rayleigh", "Sezawa")[number - 1] if number < 3 else f"sagittal {number}")
