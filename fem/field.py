"""The whole field of a driven stator on a mesh, rebuilt on demand, and its file.

The lines of the mesh are the nodes of the columns under the transducers and evenly spaced ones in the stretches,
where the field is a sum of modes; through the depth the nodes are the section's own, so that nothing is averaged.
In the file (VTK XML, by meshio) complex fields are two arrays, and names carry the unit.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from fem.readout import column_fields
from fem.solution import Solution
from fem.surface import Covered, SurfaceWave

DISPLACEMENT, POTENTIAL = "displacement_m_per_V", "potential_V_per_V"


@dataclass(frozen=True, kw_only=True)
class WaveField:
    """Complex field per volt of the source on a grid of the section.

    Attributes
    ----------
    x : ndarray, shape (nx,)
        m from the left end.
    z : ndarray, shape (nz,)
        m, 0 at the surface, negative below, increasing.
    displacement : ndarray, shape (nx, nz, 3)
        u_x, u_y, u_z in m per V.
    potential : ndarray, shape (nx, nz)
        V per V.
    frequency : float
        Hz.
    """

    x: np.ndarray
    z: np.ndarray
    displacement: np.ndarray = field(repr=False)
    potential: np.ndarray = field(repr=False)
    frequency: float


def wave_field(wave: SurfaceWave, *, per_wavelength: int = 16) -> WaveField:
    """Rebuild the interior of a driven stator.

    Parameters
    ----------
    wave : SurfaceWave
    per_wavelength : int
        Lines per surface wavelength in the stretches.

    Returns
    -------
    WaveField
    """
    solution: Solution = wave.solution
    section = solution.section
    body = slice(section.bottom, section.surface + 1)
    step = wave.phase_velocity / wave.frequency / per_wavelength
    places, values, offset = [], [], 0.0
    transducer = 0
    for piece in wave.pieces:
        if isinstance(piece, Covered):
            x, part = _under(solution, transducer, body)
            transducer += 1
        else:
            start, stop = max(piece.start, 0.0), min(piece.stop, wave.length)
            x = np.linspace(start, stop, max(3, int(np.ceil((stop - start) / step)) + 1))
            part = _between(solution, piece, x, body, first=not transducer)
            if transducer:
                offset_here, offset = offset, offset + _gauge_step(solution, piece)
                part[:, :, 3] += offset_here
        if isinstance(piece, Covered):
            part[:, :, 3] += offset
        first = 1 if places else 0  # the line shared with the piece before
        places.append(x[first:])
        values.append(part[first:])
    everything = np.concatenate(values)
    return WaveField(
        x=np.concatenate(places),
        z=section.nodes[body],
        displacement=everything[:, :, :3],
        potential=everything[:, :, 3] * section.solid.potential_unit,
        frequency=wave.frequency,
    )


def _constant_shape(solution: Solution) -> tuple[int, complex, complex] | None:
    """Index of the mode of constant potential, its potential going right and left; None where it is grounded."""
    modes = solution.modes
    constant = np.flatnonzero(modes.wavenumbers == 0)
    if not len(constant):
        return None
    index, surface = int(constant[0]), solution.section.surface_dofs["phi"]
    return index, complex(modes.right[surface, index]), complex(modes.left[surface, index])


def _gauge_step(solution: Solution, piece) -> complex:
    """Mean potential of the transducer after a stretch against that of the one before, scaled."""
    constant = _constant_shape(solution)
    if constant is None or not np.isfinite(piece.stop):
        return 0.0
    index, rightwards, leftwards = constant
    return rightwards * piece.right[index] - leftwards * piece.left[index]


def _between(solution: Solution, piece, x: np.ndarray, body: slice, *, first: bool) -> np.ndarray:
    section, modes = solution.section, solution.modes
    right, left = piece.right.copy(), piece.left.copy()
    constant = _constant_shape(solution)
    if constant is not None:
        # Potentials refer to the transducer on the left; before the first one, to that.
        (right if first else left)[constant[0]] = 0.0
    phases = np.exp(-1j * np.outer(piece.wavenumbers, x - piece.start)) if np.any(right) else 0.0
    lines = modes.right @ (right[:, None] * phases) if np.any(right) else 0.0
    if np.any(left):
        lines = lines + modes.left @ (left[:, None] * np.exp(-1j * np.outer(piece.backwards, x - piece.stop)))
    out = np.zeros((len(x), len(section.dofs), 4), dtype=complex)
    exists = section.dofs >= 0
    out[:, exists] = np.moveaxis(lines[section.dofs[exists]], 0, 1)
    return out[:, body]


def _under(solution: Solution, index: int, body: slice) -> tuple[np.ndarray, np.ndarray]:
    from fem.spectral import gll_nodes

    unit, order = solution.section.length_unit, solution.section.order
    places, values = [], []
    for recovery, starts, sides in column_fields(solution, index):
        inside = gll_nodes(order)[:-1] * recovery.column.width * unit
        fields = np.moveaxis(recovery.values(sides)[:, body], -1, 0)
        places.append((starts[:, None] + inside).ravel())
        values.append(fields[:, :-1].reshape(-1, *fields.shape[2:]))
        last = int(np.argmax(starts))
        places.append(starts[[last]] + recovery.column.width * unit)
        values.append(fields[[last], -1])
    x, everything = np.concatenate(places), np.concatenate(values)
    order_x = np.argsort(x, kind="stable")
    x, everything = x[order_x], everything[order_x]
    distinct = np.append(True, np.diff(x) > 1e-9 * unit)
    return x[distinct], everything[distinct]


def write_vtu(wave_field: WaveField, path: str | Path) -> None:
    """Write a field as quadrilaterals with complex point data, for ParaView and meshio.

    Parameters
    ----------
    wave_field : WaveField
    path : str or Path
        A ``.vtu`` file.
    """
    import meshio

    nx, nz = len(wave_field.x), len(wave_field.z)
    points = np.zeros((nx, nz, 3))
    points[:, :, 0], points[:, :, 2] = wave_field.x[:, None], wave_field.z
    corner = (np.arange(nx - 1)[:, None] * nz + np.arange(nz - 1)).ravel()
    quads = np.stack([corner, corner + nz, corner + nz + 1, corner + 1], axis=1)
    moved, potential = wave_field.displacement.reshape(-1, 3), wave_field.potential.reshape(-1)
    mesh = meshio.Mesh(
        points.reshape(-1, 3),
        [("quad", quads)],
        point_data={
            f"{DISPLACEMENT}_real": moved.real,
            f"{DISPLACEMENT}_imag": moved.imag,
            f"{POTENTIAL}_real": potential.real,
            f"{POTENTIAL}_imag": potential.imag,
        },
        field_data={},
    )
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
    """
    import meshio

    mesh = meshio.read(str(path), file_format="vtu")
    x, z = np.unique(mesh.points[:, 0]), np.unique(mesh.points[:, 2])
    shape = (len(x), len(z))
    data = mesh.point_data
    moved = data[f"{DISPLACEMENT}_real"] + 1j * data[f"{DISPLACEMENT}_imag"]
    potential = data[f"{POTENTIAL}_real"] + 1j * data[f"{POTENTIAL}_imag"]
    return WaveField(
        x=x,
        z=z,
        displacement=moved.reshape(*shape, 3),
        potential=potential.reshape(shape),
        frequency=frequency,
    )
