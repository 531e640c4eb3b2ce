"""A wave field as a file for other tools: VTK XML by meshio, complex fields as two arrays, names with their unit.

Strain energy and power flow have a mean over the cycle and a part at twice the frequency, whose name ends in ``_pulse``
(energy_densities.py).
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from fem.exceptions import InputError
from fem.results.interior_field import PieceField, WaveField

DISPLACEMENT, POTENTIAL = "displacement_m_per_V", "potential_V_per_V"
ENERGY, POWER = "strain_energy_J_per_m3_per_V2", "power_flow_W_per_m2_per_V2"


def write_vtu(wave_field: WaveField, path: str | Path) -> None:
    """Write a field as quadrilaterals with complex point data to a ``.vtu`` file, for ParaView and meshio.

    A meshed piece is written on its own elements instead of on the grid.
    """

    def data(part: WaveField | PieceField) -> dict:
        arrays = _split(DISPLACEMENT, part.displacement) | _split(POTENTIAL, part.potential)
        densities = part.densities
        if densities is not None:
            arrays |= {ENERGY: densities.strain_energy, POWER: _three_components(densities.power_flow)}
            arrays |= _split(f"{ENERGY}_pulse", densities.strain_energy_pulse)
            arrays |= _split(f"{POWER}_pulse", _three_components(densities.power_flow_pulse))
        return arrays

    _write(wave_field, data, path)


def write_instant(wave_field: WaveField, phase: float, path: str | Path) -> None:
    """Write a field with densities at one phase omega t of the wave (rad) to a ``.vtu`` file, in single precision."""
    factor = np.exp(1j * phase)

    def data(part: WaveField | PieceField) -> dict:
        densities = part.densities
        if densities is None:
            raise InputError("densities", "must have been computed with the field")
        arrays = {
            DISPLACEMENT: (part.displacement * factor).real,
            POTENTIAL: (part.potential * factor).real,
            ENERGY: densities.strain_energy + (densities.strain_energy_pulse * factor**2).real,
            POWER: _three_components(densities.power_flow + (densities.power_flow_pulse * factor**2).real),
        }
        return {name: values.astype(np.float32) for name, values in arrays.items()}

    _write(wave_field, data, path)


def _write(wave_field: WaveField, data: Callable[[WaveField | PieceField], dict], path: str | Path) -> None:
    """Write the grid outside meshed pieces, and each meshed piece on its own elements.

    ``data``: returns the point data of the grid or of a piece by name.
    """
    x = wave_field.x
    grid_points, grid_quads = _grid(x, wave_field.z)
    centre = grid_points[grid_quads, 0].mean(axis=1)
    outside = np.ones(len(grid_quads), dtype=bool)
    for low, high in (piece.span for piece in wave_field.pieces):
        outside &= (centre < low) | (centre > high)
    grid_data = {name: values.reshape(len(grid_points), *values.shape[2:]) for name, values in data(wave_field).items()}
    parts = [(grid_points, grid_quads[outside], grid_data)]
    for piece in wave_field.pieces:
        points = np.insert(piece.points, 1, 0.0, axis=1)  # y = 0
        centre = points[piece.quads, 0].mean(axis=1)
        parts.append((points, piece.quads[(centre >= x[0]) & (centre <= x[-1])], data(piece)))
    points, quads, columns = zip(*parts, strict=True)
    first_point = np.cumsum([0, *(len(each) for each in points[:-1])])
    all_quads = np.concatenate([each + first for each, first in zip(quads, first_point, strict=True)])
    used, renumbered = np.unique(all_quads, return_inverse=True)  # the other points are dropped
    point_data = {name: np.concatenate([each[name] for each in columns])[used] for name in grid_data}
    _write_quads(np.concatenate(points)[used], renumbered.reshape(all_quads.shape), point_data, path)


def write_surface(x: np.ndarray, y: np.ndarray, motion: np.ndarray, path: str | Path) -> None:
    """Write the surface's motion in three dimensions as quadrilaterals with complex point data to a ``.vtu`` file.

    ``x``, ``y``: m; ``motion``: u_x, u_y and u_z in m per V, shape (3, nx, ny), as of `SurfaceBeam.motion`.
    """
    points, quads = _grid(x, y, axis=1)
    moved = np.moveaxis(motion, 0, -1).reshape(-1, 3)
    _write_quads(points, quads, _split(DISPLACEMENT, moved), path)


def _grid(x: np.ndarray, z: np.ndarray, axis: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Points (nx nz, 3) and quadrilaterals of a grid of x and z, or of x and y with axis 1, in m."""
    nx, nz = len(x), len(z)
    points = np.zeros((nx, nz, 3))
    points[:, :, 0], points[:, :, axis] = x[:, None], z
    corner = (np.arange(nx - 1)[:, None] * nz + np.arange(nz - 1)).ravel()
    return points.reshape(-1, 3), np.stack([corner, corner + nz, corner + nz + 1, corner + 1], axis=1)


def _write_quads(points: np.ndarray, quads: np.ndarray, data: dict, path: str | Path) -> None:
    import meshio

    mesh = meshio.Mesh(points, [("quad", quads)], point_data=data)
    meshio.write(str(path), mesh, file_format="vtu", binary=True)


def _split(name: str, values: np.ndarray) -> dict:
    return {f"{name}_real": values.real, f"{name}_imag": values.imag}


def _three_components(flow: np.ndarray) -> np.ndarray:
    """Return a flow along x and z with a y component of zero, because other tools expect three components."""
    out = np.zeros((*flow.shape[:-1], 3), dtype=flow.dtype)
    out[..., [0, 2]] = flow
    return out
