"""A wave field as a file for other tools: VTK XML by meshio, complex fields as two arrays, names with their unit."""

from pathlib import Path

import numpy as np

from fem.results.densities import Densities
from fem.results.field import WaveField

DISPLACEMENT, POTENTIAL = "displacement_m_per_V", "potential_V_per_V"
ENERGY, POWER = "strain_energy_J_per_m3_per_V2", "power_flow_W_per_m2_per_V2"


def write_vtu(wave_field: WaveField, path: str | Path) -> None:
    """Write a field as quadrilaterals with complex point data, for ParaView and meshio.

    Parameters
    ----------
    wave_field : WaveField
    path : str or Path
        A ``.vtu`` file.
    """
    moved, potential = wave_field.displacement, wave_field.potential
    data = _split(DISPLACEMENT, moved) | _split(POTENTIAL, potential)
    found = wave_field.densities
    if found is not None:
        data |= {ENERGY: found.strain_energy, POWER: _in_space(found.power_flow)}
        data |= _split(f"{ENERGY}_pulse", found.strain_energy_pulse)
        data |= _split(f"{POWER}_pulse", _in_space(found.power_flow_pulse))
    write_mesh(wave_field.x, wave_field.z, data, path)


def write_instant(wave_field: WaveField, phase: float, path: str | Path) -> None:
    """Write the field as it is at one phase of the wave (rad), in single precision.

    Parameters
    ----------
    wave_field : WaveField
        With its densities.
    phase : float
        omega t.
    path : str or Path
        A ``.vtu`` file.
    """
    turn, found = np.exp(1j * phase), wave_field.densities
    data = {
        DISPLACEMENT: (wave_field.displacement * turn).real,
        POTENTIAL: (wave_field.potential * turn).real,
        ENERGY: found.strain_energy + (found.strain_energy_pulse * turn**2).real,
        POWER: _in_space(found.power_flow + (found.power_flow_pulse * turn**2).real),
    }
    data = {name: values.astype(np.float32) for name, values in data.items()}
    write_mesh(wave_field.x, wave_field.z, data, path)


def write_surface(x: np.ndarray, y: np.ndarray, motion: np.ndarray, path: str | Path) -> None:
    """Write the surface's motion in three dimensions as quadrilaterals with complex point data.

    Parameters
    ----------
    x, y : ndarray, shapes (nx,) and (ny,)
        m.
    motion : ndarray, shape (3, nx, ny)
        u_x, u_y and u_z in m per V, as of `SurfaceBeam.motion`.
    path : str or Path
        A ``.vtu`` file.
    """
    write_mesh(x, y, _split(DISPLACEMENT, np.moveaxis(motion, 0, -1)), path, axis=1)


def write_mesh(x: np.ndarray, z: np.ndarray, data: dict, path: str | Path, axis: int = 2) -> None:
    """Write fields (nx, nz, ...) on the grid of lines x and heights z (m; axis 1: lateral places) as quadrilaterals."""
    import meshio

    nx, nz = len(x), len(z)
    points = np.zeros((nx, nz, 3))
    points[:, :, 0], points[:, :, axis] = x[:, None], z
    corner = (np.arange(nx - 1)[:, None] * nz + np.arange(nz - 1)).ravel()
    quads = np.stack([corner, corner + nz, corner + nz + 1, corner + 1], axis=1)
    flat = {name: values.reshape(nx * nz, *values.shape[2:]) for name, values in data.items()}
    mesh = meshio.Mesh(points.reshape(-1, 3), [("quad", quads)], point_data=flat)
    meshio.write(str(path), mesh, file_format="vtu", binary=True)


def read_vtu(path: str | Path, *, frequency: float) -> WaveField:
    """Read a field that `write_vtu` wrote.

    Parameters
    ----------
    path : str or Path
    frequency : float
        Hz; the file does not hold it.

    Returns
    -------
    WaveField
        With densities if the file has them.
    """
    import meshio

    mesh = meshio.read(str(path), file_format="vtu")
    x, z = np.unique(mesh.points[:, 0]), np.unique(mesh.points[:, 2])
    data = {
        name: values.reshape(len(x), len(z), *values.shape[1:]) for name, values in mesh.point_data.items()
    }
    found = None
    if ENERGY in data:
        found = Densities(
            strain_energy=data[ENERGY],
            strain_energy_pulse=_joined(f"{ENERGY}_pulse", data),
            power_flow=data[POWER][..., [0, 2]],
            power_flow_pulse=_joined(f"{POWER}_pulse", data)[..., [0, 2]],
        )
    return WaveField(
        x=x,
        z=z,
        displacement=_joined(DISPLACEMENT, data),
        potential=_joined(POTENTIAL, data),
        frequency=frequency,
        densities=found,
    )


def _split(name: str, values: np.ndarray) -> dict:
    return {f"{name}_real": values.real, f"{name}_imag": values.imag}


def _joined(name: str, data: dict) -> np.ndarray:
    return data[f"{name}_real"] + 1j * data[f"{name}_imag"]


def _in_space(flow: np.ndarray) -> np.ndarray:
    """A flow along x and z as a vector with a y component, which other tools expect."""
    out = np.zeros((*flow.shape[:-1], 3), dtype=flow.dtype)
    out[..., [0, 2]] = flow
    return out
