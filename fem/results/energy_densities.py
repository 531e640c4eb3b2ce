"""Strain energy and power flow of a harmonic field, node by node from its gradients.

The product of two harmonic quantities is a mean and a part at twice the frequency; both are kept, so that

    instant value = mean + Re(pulse exp(2 i omega t)).

Strain energy density S : c^E : S / 2, and the power flow -T . v + phi dD/dt (Auld, *Acoustic Fields and Waves in
Solids*, vol. 1, section 5), with T = c S + e^T grad phi and D = e S - eps grad phi.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fem.discretize.spectral import gll_nodes, lagrange
from fem.materials import Solid

# components of the stress on a face whose normal is x and z, for the velocities along x, y and z (Voigt)
_FACE_X, _FACE_Z = (0, 5, 4), (4, 3, 2)
_LINES = 512  # at a time: all at once takes a gigabyte for a whole stator


@dataclass(frozen=True, kw_only=True)
class Densities:
    """Energy and power of a field per V^2 of the source, or per m^2 of u_z at the surface of a free wave.

    Attributes
    ----------
    strain_energy : ndarray, shape (nx, nz)
        Mean over a cycle, J/m^3.
    strain_energy_pulse : ndarray, shape (nx, nz), complex
        At twice the frequency, J/m^3.
    power_flow : ndarray, shape (nx, nz, 2)
        Along x and z, mean over a cycle, W/m^2.
    power_flow_pulse : ndarray, shape (nx, nz, 2), complex
        At twice the frequency, W/m^2.
    """

    strain_energy: np.ndarray = field(repr=False)
    strain_energy_pulse: np.ndarray = field(repr=False)
    power_flow: np.ndarray = field(repr=False)
    power_flow_pulse: np.ndarray = field(repr=False)


def densities(solid: Solid, frequency: float, values: np.ndarray, along: np.ndarray, upward: np.ndarray) -> Densities:
    """Return energy and power of a field that does not vary along y; ``solid`` with its losses, frequency in Hz.

    ``values``, ``along``, ``upward``: u_x, u_y, u_z in m and phi in V, and their derivatives with respect to x and z,
    shape (nx, nz, 4).
    """
    blocks = [slice(first, first + _LINES) for first in range(0, len(values), _LINES)]
    parts = [_densities(solid, frequency, values[b], along[b], upward[b]) for b in blocks]
    return Densities(**{name: np.concatenate([part[name] for part in parts]) for name in Densities.__annotations__})


def layered_densities(
    solids: Sequence[Solid | None], frequency: float, values: np.ndarray, along: np.ndarray, ends: np.ndarray
) -> Densities:
    """Return energy and power of a field in layers, whose derivatives along z jump at interfaces.

    Parameters
    ----------
    solids : sequence of Solid or None
        Of each element from the bottom up; None for a bond, which has no volume.
    frequency : float
        Hz.
    values, along : ndarray, shape (nx, elements * order + 1, 4)
        As in `densities`.
    ends : ndarray, shape (elements + 1,)
        z of the elements' ends, m.

    Returns
    -------
    Densities
        At an interface the mean of both sides.
    """
    order, out = (values.shape[1] - 1) // len(solids), None
    first = 0
    while first < len(solids):
        stop = first + 1
        while stop < len(solids) and solids[stop] == solids[first]:
            stop += 1
        solid, nodes = solids[first], slice(first * order, stop * order + 1)
        if solid is not None:
            upward = upward_slope(values[:, nodes], order, np.diff(ends[first : stop + 1]))
            own = vars(densities(solid, frequency, values[:, nodes], along[:, nodes], upward))
            if out is None:
                out = {
                    name: np.zeros((*values.shape[:2], *each.shape[2:]), dtype=each.dtype) for name, each in own.items()
                }
            for name, each in own.items():
                if first > 0 and solids[first - 1] is not None:
                    each[:, 0] = 0.5 * (each[:, 0] + out[name][:, nodes.start])
                out[name][:, nodes] = each
        first = stop
    if out is None:
        raise ValueError("a field needs a solid")
    return Densities(**out)


def _densities(solid, frequency, values, along, upward) -> dict:
    omega = 2 * np.pi * frequency
    nothing = np.zeros(values.shape[:2], dtype=complex)
    shear = upward[..., 0] + along[..., 2]
    strain = np.stack([along[..., 0], nothing, upward[..., 2], upward[..., 1], shear, along[..., 1]], axis=-1)
    gradient = np.stack([along[..., 3], nothing, upward[..., 3]], axis=-1)
    elastic = strain @ np.real(solid.stiffness)
    stress = strain @ solid.stiffness_lossy + gradient @ solid.coupling
    flux = strain @ solid.coupling.T - gradient @ solid.permittivity_lossy
    velocity = 1j * omega * values[..., :3]

    def flow(half_velocity, half_current):
        """Half of -T v + phi dD/dt of a (conjugated or not) velocity and displacement current."""
        faces = (
            values[..., 3] * half_current[..., axis] - np.sum(stress[..., face] * half_velocity, axis=-1)
            for axis, face in ((0, _FACE_X), (2, _FACE_Z))
        )
        return 0.5 * np.stack(list(faces), axis=-1)

    current = 1j * omega * flux
    return {
        "strain_energy": 0.25 * np.sum(np.conj(strain) * elastic, axis=-1).real,
        "strain_energy_pulse": 0.25 * np.sum(strain * elastic, axis=-1),
        "power_flow": flow(np.conj(velocity), np.conj(current)).real,
        "power_flow_pulse": flow(velocity, current),
    }


def flattened(parts: list[Densities]) -> Densities:
    """Return densities of several fields (nx, nz, ...), one behind the other, (nodes, ...)."""

    def joined(name: str) -> np.ndarray:
        rest = {"power_flow": (2,), "power_flow_pulse": (2,)}.get(name, ())
        return np.concatenate([getattr(each, name).reshape(-1, *rest) for each in parts])

    return Densities(**{name: joined(name) for name in Densities.__annotations__})


def upward_slope(values: np.ndarray, order: int, heights: np.ndarray) -> np.ndarray:
    """Return d/dz of nodal values (nx, elements * order + 1, ...) by the elements' polynomials, heights in m.

    At a node shared by two elements, whose slopes differ by the error of the discretisation, it is their mean.
    """
    _, slope = lagrange(order, gll_nodes(order))
    parts = [
        np.einsum("ij,xj...->xi...", slope / height, values[:, part * order : (part + 1) * order + 1])
        for part, height in enumerate(heights)
    ]
    return shared(np.stack(parts, axis=1), axis=1)


def shared(parts: np.ndarray, *, axis: int) -> np.ndarray:
    """Return values (..., elements, order + 1, ...) of neighbouring elements on its nodes: the mean where two meet."""
    parts = np.moveaxis(parts, (axis, axis + 1), (0, 1))
    elements, order = parts.shape[0], parts.shape[1] - 1
    out = np.empty((elements * order + 1, *parts.shape[2:]), dtype=parts.dtype)
    out[:-1] = parts[:, :-1].reshape(-1, *parts.shape[2:])
    out[-1] = parts[-1, -1]
    out[order:-1:order] = 0.5 * (parts[1:, 0] + parts[:-1, -1])
    return np.moveaxis(out, 0, axis)
