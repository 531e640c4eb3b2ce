"""A wave field as a file for other tools: VTK XML by meshio, complex fields as two arrays, names with their unit."""

from pathlib import Path

import numpy as np

from fem.results.field import WaveField

DISPLACEMENT, POTENTIAL = "displacement_m_per_V", "potential_V_per_V"
ENERGY, POWER = "strain_energy_J_per_m3_per_V2", "power_flow_W_per_m2_per_V2"


def write_vtu(wave_field: WaveField, path: str | Path) -> None:
    """Write a field as quadrilaterals with complex point data to a ``.vtu`` file, for ParaView and meshio."""
    moved, potential = wave_field.displacement, wave_field.potential
    data = _split(DISPLACEMENT, moved) | _split(POTENTIAL, potential)
    found = wave_field.densities
    if found is not None:
        data |= {ENERGY: found.strain_energy, POWER: _in_space(found.power_flow)}
        data |= _split(f"{ENERGY}_pulse", found.strain_energy_pulse)
        data |= _split(f"{POWER}_pulse", _in_space(found.power_flow_pulse))
    write_mesh(wave_field.x, wave_field.z, data, path, inside=wave_field.inside)


def write_instant(wave_field: WaveField, phase: float, path: str | Path) -> None:
    """Write a field with densities at one phase omega t of the wave (rad) to a ``.vtu`` file, in single precision."""
    turn, found = np.exp(1j * phase), wave_field.densities
    data = {
        DISPLACEMENT: (wave_field.displacement * turn).real,
        POTENTIAL: (wave_field.potential * turn).real,
        ENERGY: found.strain_energy + (found.strain_energy_pulse * turn**2).real,
        POWER: _in_space(found.power_flow + (found.power_flow_pulse * turn**2).real),
    }
    data = {name: values.astype(np.float32) for name, values in data.items()}
    write_mesh(wave_field.x, wave_field.z, data, path, inside=wave_field.inside)


def write_surface(x: np.ndarray, y: np.ndarray, motion: np.ndarray, path: str | Path) -> None:
    """Write the surface's motion in three dimensions as quadrilaterals with complex point data to a ``.vtu`` file.

    ``x``, ``y``: m; ``motion``: u_x, u_y and u_z in m per V, shape (3, nx, ny), as of `SurfaceBeam.motion`.
    """
    write_mesh(x, y, _split(DISPLACEMENT, np.moveaxis(motion, 0, -1)), path, axis=1)


def write_mesh(
    x: np.ndarray,
    z: np.ndarray,
    data: dict,
    path: str | Path,
    axis: int = 2,
    inside: np.ndarray | None = None,
) -> None:
    """Write fields (nx, nz, ...) on the grid of lines x and heights z (m; axis 1: lateral places) as quadrilaterals.

    ``inside``: nodes that are there, (nx, nz); quadrilaterals with another corner are left out.
    """
    import meshio

    nx, nz = len(x), len(z)
    points = np.zeros((nx, nz, 3))
    points[:, :, 0], points[:, :, axis] = x[:, None], z
    corner = (np.arange(nx - 1)[:, None] * nz + np.arange(nz - 1)).ravel()
    quads = np.stack([corner, corner + nz, corner + nz + 1, corner + 1], axis=1)
    if inside is not None:
        quads = quads[inside.reshape(-1)[quads].all(axis=1)]
    flat = {name: values.reshape(nx * nz, *values.shape[2:]) for name, values in data.items()}
    mesh = meshio.Mesh(points.reshape(-1, 3), [("quad", quads)], point_data=flat)
    meshio.write(str(path), mesh, file_format="vtu", binary=True)


def _split(name: str, values: np.ndarray) -> dict:
    return {f"{name}_real": values.real, f"{name}_imag": values.imag}


def _in_space(flow: np.ndarray) -> np.ndarray:
    """A flow along x and z as a vector with a y component, which other tools expect."""
    out = np.zeros((*flow.shape[:-1], 3), dtype=flow.dtype)
    out[..., [0, 2]] = flow
    return out
