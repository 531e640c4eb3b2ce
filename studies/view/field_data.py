"""Write the field of a run for other tools: .vtu (complex field), .pvd (instants of a period) or .csv (nodes).

The whole section of a motor has several 100 000 nodes. The expected size of a large file is announced before it is
written. A .csv file with only the surface is about a thousand times smaller.
"""

import logging
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from fem import write_instant, write_vtu
from studies.record.files import write_columns
from studies.record.values import Columns
from studies.view.run_field import LINES, RunField

LOGGER = logging.getLogger(__name__)

ANNOUNCED_SIZE = 20e6  # bytes above which the size is announced before writing
# Bytes per number in a table, in a .vtu file (vectors have a third component), and in an instant (single precision)
TABLE, COMPLEX, INSTANT = 19.5, 9.0, 2.2


def save(
    run: RunField,
    file: str | Path,
    *,
    span: tuple[float, float] | None,
    instants: int,
    note: Callable[[str], None],
    surface: bool = False,
) -> None:
    """Write displacement, potential, strain energy and power flow of a run in a span (m) or in the whole section.

    The suffix of ``file`` selects the format:

    - ``.vtu``: real and imaginary parts of the field, and mean and pulsating parts of energy and power;
    - ``.pvd``: a list of instants of one period for the animation of ParaView; each instant is a .vtu file in a
      directory of the same name;
    - ``.csv``: one row per node, two columns per complex quantity; with ``surface``, only nodes on the surface.

    ``note`` receives a message with the expected size before a large file is written.
    """
    file, kind = Path(file), Path(file).suffix.lower()
    if span is not None:
        field = run.compute(span=span, per_wavelength=LINES, energies=not surface)
    else:
        field = run.field if surface else run.with_energies
    size = expected_size(field, file, instants)
    if size > ANNOUNCED_SIZE and not surface:
        advice = "--surface writes the surface alone, --span a part" if kind == ".csv" else "--span writes a part"
        note(f"writing about {size / 1e6:.0f} MB to {file}, {field.potential.size} nodes; {advice}")
    if surface:
        write_columns(file, surface_columns(field))
    elif kind == ".csv":
        write_columns(file, columns(field))
    elif kind == ".vtu":
        write_vtu(field, file)
    else:
        _write_series(field, file, instants)


def expected_size(field, file: Path, instants: int) -> float:
    """Return the approximate size in bytes of a file of a field, for a .pvd including all instants."""
    # numbers per node: x and z; complex u and potential; mean and complex pulse of energy and of two power components
    numbers = field.potential.size * (2 + 2 * 4 + 3 * 3)
    kind = file.suffix.lower()
    return numbers * (instants * INSTANT if kind == ".pvd" else TABLE if kind == ".csv" else COMPLEX)


def surface_columns(field) -> Columns:
    """Return displacement and potential of the surface as columns, one row for each surface node."""
    table = Columns(x_m=field.x)
    table |= {f"u_{axis}_m_per_V": field.displacement[:, -1, k] for k, axis in enumerate("xyz")}
    table |= {"potential_V_per_V": field.potential[:, -1]}
    return table


def columns(field) -> Columns:
    """Return a field with densities as columns, one row for each node, ordered by x and then by z."""
    x, z = np.meshgrid(field.x, field.z, indexing="ij")
    densities = field.densities
    table = dict(x_m=x, z_m=z)
    table |= {f"u_{axis}_m_per_V": field.displacement[..., k] for k, axis in enumerate("xyz")}
    table |= {
        "potential_V_per_V": field.potential,
        "strain_energy_J_per_m3_per_V2": densities.strain_energy,
        "strain_energy_pulse_J_per_m3_per_V2": densities.strain_energy_pulse,
    }
    for k, axis in enumerate("xz"):
        table[f"power_flow_{axis}_W_per_m2_per_V2"] = densities.power_flow[..., k]
        table[f"power_flow_{axis}_pulse_W_per_m2_per_V2"] = densities.power_flow_pulse[..., k]
    return Columns((name, values.ravel()) for name, values in table.items())


def _write_series(field, file: Path, instants: int) -> None:
    folder = file.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1", byte_order="LittleEndian")
    collection = ElementTree.SubElement(root, "Collection")
    for number in range(instants):
        LOGGER.info(f"instant {number + 1} of {instants}")
        name = f"{number:03d}.vtu"
        write_instant(field, 2 * np.pi * number / instants, folder / name)
        moment = repr(number / instants / field.frequency)
        ElementTree.SubElement(collection, "DataSet", timestep=moment, part="0", file=f"{folder.name}/{name}")
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(file, encoding="utf-8", xml_declaration=True)
