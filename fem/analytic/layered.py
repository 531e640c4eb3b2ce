"""Surface impedance of layers on a half-space, from below upwards, without growing exponentials.

Fields u(z) exp(i(omega t - k x)) as in stroh.py, with one pair of units for all solids. In a layer the partial waves
exp(-i k p z) are the eigenpairs (u, t) of Stroh's real matrix, traction k t. Those that decay downwards (Im p > 0, or
power downwards where p is real) are taken at the top of the layer, the others at its bottom: every factor is at most 1,

    E_d = exp(i k p_d h),  E_u = exp(-i k p_u h)
    R = -(T_u - Z A_u)^-1 (T_d - Z A_d) E_d                                                                (1)
    Z_top = (T_d + T_u E_u R) (A_d + A_u E_u R)^-1                                                         (2)

with the impedance Z of what lies below, A and T the parts u and t of the eigenvectors (the recursion of the impedance;
Rokhlin and Wang, J. Acoust. Soc. Am. 112 (2002) 822, for its stability). An electrode on the lower side of a layer is
the row phi = 0 in place of that of D in (1), and so is either side of a metal. A bond of stiffness K per area lets u
jump by the traction over K: Z <- Z (1 + S Z)^-1 with S = k stress_unit/K.

Below the slowest bulk wave of the half-space Z is Hermitian and falls with v between its poles.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fem.analytic.half_space import expanded
from fem.analytic.stroh import SurfaceImpedance, limiting_velocity
from fem.geometry import Layer
from fem.materials import VACUUM_PERMITTIVITY, Solid, fields
from fem.materials.medium import Medium, medium, units
from fem.parameters import InputError, positive

REAL = 1e-9  # |Im p| over the largest |p| below which a partial wave does not decay
ORDER = ("ux", "uy", "uz", "phi")


def _require_frequency(known: bool) -> None:
    if not known:
        raise InputError("frequency", "is missing: a thickness in m or a bond needs it")


@dataclass(frozen=True, kw_only=True, eq=False)
class PartialWaves:
    """The partial waves of a layer at some velocities, shape (v, fields, fields) unless stated."""

    down: np.ndarray  # A_d
    down_traction: np.ndarray  # T_d
    up: np.ndarray
    up_traction: np.ndarray
    wavenumber_down: np.ndarray  # p_d, shape (v, fields)
    wavenumber_up: np.ndarray
    depth: np.ndarray  # k h, shape (v,)

    @cached_property
    def factor_down(self) -> np.ndarray:
        """E_d, shape (v, 1, fields)."""
        return np.exp(1j * self.wavenumber_down * self.depth[:, None])[:, None, :]

    @cached_property
    def factor_up(self) -> np.ndarray:
        """E_u, shape (v, 1, fields)."""
        return np.exp(-1j * self.wavenumber_up * self.depth[:, None])[:, None, :]


class LayeredImpedance:
    """Impedance of layers on a half-space; all methods take velocities in m/s, shape (v,).

    Parameters
    ----------
    substrate : Solid
    layers : sequence of Layer
        From the substrate upwards.
    frequency : float or None
        Hz; needed for layers with a thickness in m and for bonds.

    Raises
    ------
    InputError
        For a missing frequency.
    """

    def __init__(self, substrate: Solid, layers: Sequence[Layer], *, frequency: float | None = None):
        absolute = any(each.thickness is not None or each.bond is not None for each in layers)
        _require_frequency(not absolute or frequency is not None)
        if frequency is not None:
            positive("frequency", frequency, "Hz")
        self.layers, self.omega = tuple(layers), None if frequency is None else 2.0 * np.pi * frequency
        self.absolute = absolute  # the impedance over k depends on the frequency, beside v
        self.solids = solids = (substrate, *(each.solid for each in layers))
        present = {name for each in solids for name in fields(each)}
        self.fields = tuple(name for name in ORDER if name in present)
        self.scales = units(substrate)
        self.bodies = [medium(each, self.fields, lossy=False, scales=self.scales) for each in solids]
        self.limits = [limiting_velocity(body) / float(np.sqrt(body.inertia[0])) for body in self.bodies]  # m/s
        self.limit = self.limits[0]
        self.displaced = self.bodies[0].displaced
        self.electric = "phi" in self.fields
        self.gap = VACUUM_PERMITTIVITY * self.scales[1] ** 2 / self.scales[0]
        self._substrate = SurfaceImpedance(self.bodies[0], "open")
        self._matrices = [_stroh_parts(body) for body in self.bodies]

    def slowest(self) -> float:
        """Velocity in m/s below which no mode exists: half of the slowest bulk wave of all solids."""
        return 0.5 * min(self.limits)

    def wavenumber(self, velocity: np.ndarray) -> np.ndarray:
        """Return omega/v in 1/m."""
        _require_frequency(self.omega is not None)
        return self.omega / velocity

    def half_space(self, velocity: np.ndarray) -> np.ndarray:
        """Impedance of the half-space, (v, fields, fields)."""
        unit = self._substrate.velocity_unit
        scale = self._substrate.stress_unit / self.scales[0]
        return scale * self._substrate.of_all_fields(velocity / unit)

    def partial_waves(self, number: int, velocity: np.ndarray) -> PartialWaves:
        """Partial waves of a layer, counted from the substrate from 0."""
        layer, n = self.layers[number], len(self.fields)
        p, vectors = np.linalg.eig(self._stroh(number, velocity))
        u, t = vectors[:, :n, :], -1j * vectors[:, n:, :]
        order = _downwards(p, vectors)
        rows = np.arange(len(velocity))[:, None, None]
        fields, up, down = np.arange(n)[:, None], order[:, None, :n], order[:, None, n:]
        if layer.wavelengths is not None:
            k_h = 2.0 * np.pi * layer.wavelengths * (velocity.conj() / velocity.real)  # k / Re k: 1 of a bound wave
        else:
            k_h = self.wavenumber(velocity) * (layer.thickness or 0.0)
        return PartialWaves(
            down=u[rows, fields, down], down_traction=t[rows, fields, down],
            up=u[rows, fields, up], up_traction=t[rows, fields, up],
            wavenumber_down=p[rows[:, 0], down[:, 0]], wavenumber_up=p[rows[:, 0], up[:, 0]],
            depth=k_h,
        )  # fmt: skip

    def _stroh(self, number: int, velocity: np.ndarray) -> np.ndarray:
        """Stroh's matrix of a layer, (v, 2 fields, 2 fields)."""
        still, inertia = self._matrices[number + 1]
        return still + velocity[:, None, None] ** 2 * inertia

    def joined(self, below: np.ndarray, number: int, velocity: np.ndarray) -> np.ndarray:
        """Impedance below a layer seen through its bond."""
        compliance = self.bond_compliance(number, velocity)
        if compliance is None:
            return below
        return _divided(below, np.eye(len(self.fields)) + compliance @ below)

    def bond_compliance(self, number: int, velocity: np.ndarray) -> np.ndarray | None:
        """S of a layer's bond, (v, fields, fields); None for a perfect joint."""
        bond = self.layers[number].bond
        if bond is None:
            return None
        per_area = {"ux": bond.tangential, "uy": bond.tangential, "uz": bond.normal, "phi": np.inf}
        soft = np.diag([self.scales[0] / per_area[name] for name in self.fields])
        return self.wavenumber(velocity)[:, None, None] * soft

    def stack(self, velocity: np.ndarray, shorted: int | np.ndarray | None = None) -> "Stack":
        """Return impedances and reflections of all layers.

        ``shorted``: number of layers above an electrode with phi = 0 at an interface, one or for each velocity; None
        for none.
        """
        below, parts = self.half_space(velocity), []
        for number in range(len(self.layers)):
            waves, reflection, displacement, below = self._through(below, number, velocity, shorted)
            parts.append((waves, reflection, displacement))
            below = 0.5 * (below + below.conj().swapaxes(1, 2))
        return Stack(impedance=below, parts=tuple(parts))

    def _through(self, below: np.ndarray, number: int, velocity: np.ndarray, shorted: int | np.ndarray | None):
        """Partial waves of a layer, R of (1), u at its top and the impedance there, from the impedance below it."""
        waves = self.partial_waves(number, velocity)
        joined = self.joined(below, number, velocity)
        up, down = waves.up_traction - joined @ waves.up, waves.down_traction - joined @ waves.down
        if self.electric:
            held = np.broadcast_to(self.grounded_below(number, shorted), len(velocity))
            up[held, -1], down[held, -1] = waves.up[held, -1], waves.down[held, -1]
        reflection = -np.linalg.solve(up, down * waves.factor_down)
        returned = waves.factor_up.swapaxes(1, 2) * reflection
        displacement = waves.down + waves.up @ returned
        traction = waves.down_traction + waves.up_traction @ returned
        return waves, reflection, displacement, _divided(traction, displacement)

    def grounded_below(self, number: int, shorted: int | np.ndarray | None) -> np.ndarray:
        """True if phi = 0 on the lower side of a layer: at a shorted electrode, or where one of the solids conducts."""
        conducts = any(each.conducting for each in self.solids[number : number + 2])
        return np.logical_or(conducts, np.equal(-1 if shorted is None else shorted, len(self.layers) - number))

    def on_metal(self, surface: str) -> bool:
        """True if phi = 0 at the top."""
        return surface == "metallised" or self.solids[-1].conducting

    def mechanical(self, impedance: np.ndarray, *, surface: str) -> np.ndarray:
        """Impedance of the displacements at the top under "vacuum", "open" or "metallised", (v, m, m)."""
        m = self.displaced
        stiff = impedance[:, m][:, :, m]
        if not self.electric or self.on_metal(surface):
            return stiff
        gap = self.gap if surface == "vacuum" else 0.0
        across, back = impedance[:, m][:, :, ~m], impedance[:, ~m][:, :, m]
        return stiff - across @ back / (impedance[:, -1:, -1:] - gap)

    def outgoing(self, velocity: complex, steps: int, *, surface: str) -> np.ndarray:
        """Impedance of the displacements at the top, (m, m), above the slowest bulk wave of the half-space.

        The partial waves of the half-space are those that decay, or carry power, downwards at the real velocity, each
        followed to the complex one in so many steps (0 for a real velocity); see `fem.analytic.leaky_wave`.
        """
        still, inertia = self._matrices[0]
        n, real = len(self.fields), complex(velocity).real
        p, vectors = np.linalg.eig(still + real**2 * inertia)
        chosen = _downwards(p[None], vectors[None])[0, n:]
        wanted = p[chosen]
        for share in np.arange(1, steps + 1) / steps if steps else ():
            at = real + share * (velocity - real)
            p, vectors = np.linalg.eig(still + at**2 * inertia)
            distance = abs(p[None, :] - wanted[:, None])
            chosen = distance.argmin(axis=1)
            wanted = p[chosen]
        below = _divided(-1j * vectors[None, n:, chosen], vectors[None, :n, chosen])
        at_velocity = np.array([velocity])
        for number in range(len(self.layers)):
            *_, below = self._through(below, number, at_velocity, None)
        return self.mechanical(below, surface=surface)[0]

    def mode(self, impedance: np.ndarray, index: int, *, surface: str) -> np.ndarray:
        """Amplitudes of all fields at the top, (fields,), where an eigenvalue of `mechanical` is zero."""
        m, amplitude = self.displaced, np.zeros(len(self.fields), dtype=complex)
        amplitude[m] = np.linalg.eigh(self.mechanical(impedance[None], surface=surface)[0])[1][:, index]
        if self.electric and not self.on_metal(surface):
            gap = self.gap if surface == "vacuum" else 0.0
            amplitude[~m] = -impedance[~m][:, m] @ amplitude[m] / (impedance[-1, -1] - gap)
        return amplitude

    def decayed(self, velocity: float, amplitude: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """Fields in the half-space at k times depths (n,) below its surface, (n, fields), from those at it."""
        from scipy.linalg import expm

        decay = self._substrate.decay(velocity / self._substrate.velocity_unit)
        return expm(1j * depth[:, None, None] * decay) @ amplitude

    def expanded(self, amplitudes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Displacement (..., 3) and potential (...) in V/m of scaled amplitudes (..., fields)."""
        return expanded(amplitudes, self.fields, self.scales[1])


@dataclass(frozen=True, kw_only=True, eq=False)
class Stack:
    """Impedance at the top, (v, fields, fields), and of each layer its partial waves, R of (1), and u at its top."""

    impedance: np.ndarray
    parts: tuple[tuple[PartialWaves, np.ndarray, np.ndarray], ...]

    @property
    def depth(self) -> np.ndarray:
        """Wavenumber times thickness of each layer, (layers, v)."""
        return np.array([waves.depth for waves, _, _ in self.parts])


def _divided(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return left right^-1 of stacks of matrices."""
    return np.linalg.solve(right.swapaxes(1, 2), left.swapaxes(1, 2)).swapaxes(1, 2)


def _downwards(p: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Order of partial waves (v, 2 fields) by their decay downwards, the last half downwards; or by their power."""
    u, t = np.split(vectors, 2, axis=1)
    real = abs(p.imag) < REAL * abs(p).max(axis=1, keepdims=True)
    power = np.einsum("vik,vik->vk", u.conj(), t).real
    rank = np.where(real, -np.sign(power) * 1e-300, p.imag)  # power upwards counts as decay upwards
    return np.argsort(rank, axis=1)


def _stroh_parts(body: Medium) -> tuple[np.ndarray, np.ndarray]:
    """Stroh's matrix of a solid at rest, and what the squared velocity in (m/s)^2 multiplies; (2 fields, 2 fields)."""
    inverse = np.linalg.inv(body.zz)
    upper, lower = -inverse @ body.xz.T, body.xz @ inverse @ body.xz.T - body.xx
    zero = np.zeros_like(upper)
    inertia = np.block([[zero, zero], [np.diag(body.inertia), zero]])
    return np.block([[upper, inverse], [lower, upper.T]]), inertia
