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
        if absolute and frequency is None:
            raise InputError("frequency", "is missing: a thickness in m or a bond needs it")
        if frequency is not None:
            positive("frequency", frequency, "Hz")
        self.layers, self.omega = tuple(layers), None if frequency is None else 2.0 * np.pi * frequency
        self.absolute = absolute  # the impedance over k depends on the frequency, beside v
        self.solids = solids = (substrate, *(each.solid for each in layers))
        present = {name for each in solids for name in fields(each)}
        self.fields = tuple(name for name in ORDER if name in present)
        self.scales = units(substrate)
        self.bodies = [medium(each, self.fields, lossy=False, scales=self.scales) for each in solids]
        self.limit = limiting_velocity(self.bodies[0]) / float(np.sqrt(self.bodies[0].inertia[0]))  # m/s
        self.displaced = self.bodies[0].displaced
        self.electric = "phi" in self.fields
        self.gap = VACUUM_PERMITTIVITY * self.scales[1] ** 2 / self.scales[0]
        self._substrate = SurfaceImpedance(self.bodies[0], "open")

    def slowest(self) -> float:
        """Velocity in m/s below which no mode exists: half of the slowest bulk wave of all solids."""
        return 0.5 * min(limiting_velocity(body) / float(np.sqrt(body.inertia[0])) for body in self.bodies)

    def wavenumber(self, velocity: np.ndarray) -> np.ndarray:
        """Return omega/v in 1/m."""
        if self.omega is None:
            raise InputError("frequency", "is missing: a thickness in m or a bond needs it")
        return self.omega / velocity

    def half_space(self, velocity: np.ndarray) -> np.ndarray:
        """Impedance of the half-space, (v, fields, fields)."""
        unit = self._substrate.velocity_unit
        scale = self._substrate.stress_unit / self.scales[0]
        return np.stack([scale * self._substrate.of_all_fields(each / unit) for each in velocity])

    def partial_waves(self, number: int, velocity: np.ndarray) -> PartialWaves:
        """Partial waves of a layer, counted from the substrate from 0."""
        body, layer, n = self.bodies[number + 1], self.layers[number], len(self.fields)
        p, vectors = np.linalg.eig(_stroh(body, velocity))
        u, t = vectors[:, :n, :], -1j * vectors[:, n:, :]
        real = abs(p.imag) < REAL * abs(p).max(axis=1, keepdims=True)
        power = np.einsum("vik,vik->vk", u.conj(), vectors[:, n:, :]).real
        rank = np.where(real, -np.sign(power) * 1e-300, p.imag)  # power upwards counts as decay upwards
        order = np.argsort(rank, axis=1)
        up, down = order[:, :n, None].swapaxes(1, 2), order[:, n:, None].swapaxes(1, 2)
        if layer.wavelengths is not None:
            k_h = np.full(len(velocity), 2.0 * np.pi * layer.wavelengths)
        else:
            k_h = self.wavenumber(velocity) * (layer.thickness or 0.0)
        return PartialWaves(
            down=np.take_along_axis(u, down, 2), down_traction=np.take_along_axis(t, down, 2),
            up=np.take_along_axis(u, up, 2), up_traction=np.take_along_axis(t, up, 2),
            wavenumber_down=np.take_along_axis(p, down[:, 0], 1), wavenumber_up=np.take_along_axis(p, up[:, 0], 1),
            depth=k_h,
        )  # fmt: skip

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

    def stack(self, velocity: np.ndarray, shorted: int | None = None) -> "Stack":
        """Return impedances and reflections of all layers.

        ``shorted``: number of layers above an electrode with phi = 0 at an interface; None for none, 0 is at the top.
        """
        below, parts = self.half_space(velocity), []
        for number in range(len(self.layers)):
            waves = self.partial_waves(number, velocity)
            joined = self.joined(below, number, velocity)
            up, down = waves.up_traction - joined @ waves.up, waves.down_traction - joined @ waves.down
            if self.electric and self.grounded_below(number, shorted):
                up[:, -1], down[:, -1] = waves.up[:, -1], waves.down[:, -1]
            reflection = -np.linalg.solve(up, down * waves.factor_down)
            returned = waves.factor_up.swapaxes(1, 2) * reflection
            displacement = waves.down + waves.up @ returned
            traction = waves.down_traction + waves.up_traction @ returned
            parts.append((waves, reflection, displacement))
            below = _divided(traction, displacement)
            below = 0.5 * (below + below.conj().swapaxes(1, 2))
        return Stack(impedance=below, parts=tuple(parts))

    def grounded_below(self, number: int, shorted: int | None) -> bool:
        """True if phi = 0 on the lower side of a layer: at a shorted electrode, or where one of the solids conducts."""
        conducts = any(each.conducting for each in self.solids[number : number + 2])
        return conducts or shorted == len(self.layers) - number

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
        across = impedance[:, m][:, :, ~m]
        return stiff - across @ across.conj().swapaxes(1, 2) / (impedance[:, -1:, -1:] - gap)

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


def _stroh(body: Medium, velocity: np.ndarray) -> np.ndarray:
    """Stroh's matrix at some velocities in m/s, shape (v, 2 fields, 2 fields)."""
    inverse = np.linalg.inv(body.zz)
    upper, lower = -inverse @ body.xz.T, body.xz @ inverse @ body.xz.T - body.xx
    n = len(upper)
    matrix = np.empty((len(velocity), 2 * n, 2 * n))
    matrix[:, :n, :n], matrix[:, :n, n:], matrix[:, n:, n:] = upper, inverse, upper.T
    matrix[:, n:, :n] = lower + velocity[:, None, None] ** 2 * np.diag(body.inertia)
    return matrix
