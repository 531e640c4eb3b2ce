"""A wave field as a file for other tools: VTK XML by meshio, complex fields as two arrays, names with their unit."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from fem.results.field import PieceField, WaveField

DISPLACEMENT, POTENTIAL = "displacement_m_per_V", "potential_V_per_V"
ENERGY, POWER = "strain_energy_J_per_m3_per_V2", "power_flow_W_per_m2_per_V2"


def write_vtu(wave_field: WaveField, path: str | Path) -> None:
    """Write a field as quadrilaterals with complex point data to a ``.vtu`` file, for ParaView and meshio.

    A meshed piece is written on its own elements, in the place of the grid.
    """

    def data(part: WaveField | PieceField) -> dict:
        own = _split(DISPLACEMENT, part.displacement) | _split(POTENTIAL, part.potential)
        found = part.densities
        if found is not None:
            own |= {ENERGY: found.strain_energy, POWER: _in_space(found.power_flow)}
            own |= _split(f"{ENERGY}_pulse", found.strain_energy_pulse)
            own |= _split(f"{POWER}_pulse", _in_space(found.power_flow_pulse))
        return own

    _write(wave_field, data, path)


def write_instant(wave_field: WaveField, phase: float, path: str | Path) -> None:
    """Write a field with densities at one phase omega t of the wave (rad) to a ``.vtu`` file, in single precision."""
    turn = np.exp(1j * phase)

    def data(part: WaveField | PieceField) -> dict:
        found = part.densities
        own = {
            DISPLACEMENT: (part.displacement * turn).real,
            POTENTIAL: (part.potential * turn).real,
            ENERGY: found.strain_energy + (found.strain_energy_pulse * turn**2).real,
            POWER: _in_space(found.power_flow + (found.power_flow_pulse * turn**2).real),
        }
        return {name: values.astype(np.float32) for name, values in own.items()}

    _write(wave_field, data, path)


def _write(wave_field: WaveField, data: Callable[[WaveField | PieceField], dict], path: str | Path) -> None:
    """Write the grid, and each meshed piece on its own elements; ``data``: point data of one of them by name."""
    x, z = wave_field.x, wave_field.z
    points, quads = _grid(x, z)
    middle = points[quads, 0].mean(axis=1)
    kept = np.ones(len(quads), dtype=bool)
    for low, high in (piece.span for piece in wave_field.pieces):
        kept &= (middle < low) | (middle > high)
    flat = {name: values.reshape(len(points), *values.shape[2:]) for name, values in data(wave_field).items()}
    parts = [(points, quads[kept], flat)]
    for piece in wave_field.pieces:
        own = np.insert(piece.points, 1, 0.0, axis=1)
        middle = own[piece.quads, 0].mean(axis=1)
        parts.append((own, piece.quads[(middle >= x[0]) & (middle <= x[-1])], data(piece)))
    first = np.cumsum([0, *(len(each) for each, _, _ in parts)])
    quads = np.concatenate([each + start for (_, each, _), start in zip(parts, first, strict=False)])
    used, numbers = np.unique(quads, return_inverse=True)
    together = {name: np.concatenate([each[name] for _, _, each in parts])[used] for name in flat}
    every = np.concatenate([each for each, _, _ in parts])
    _write_quads(every[used], numbers.reshape(quads.shape), together, path)


def write_surface(x: np.ndarray, y: np.ndarray, motion: np.ndarray, path: str | Path) -> None:
    """Write the surface's motion in three dimensions as quadrilaterals with complex point data to a ``.vtu`` file.

    ``x``, ``y``: m; ``motion``: u_x, u_y and u_z in m per V, shape (3, nx, ny), as of `SurfaceBeam.motion`.
    """
    points, quads = _grid(x, y, axis=1)
    moved = np.moveaxis(motion, 0, -1).reshape(-1, 3)
    _write_quads(points, quads, _split(DISPLACEMENT, moved), path)


def _grid(x: np.ndarray, z: np.ndarray, axis: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Points (nx nz, 3) and quadrilaterals of lines x and heights z (axis 1: lateral places), m."""
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


def _in_space(flow: np.ndarray) -> np.ndarray:
    """A flow along x and z as a vector with a y component, which other tools expect."""
    out = np.zeros((*flow.shape[:-1], 3), dtype=flow.dtype)
    out[..., [0, 2]] = flow
    return out
