"""A run's field as data for other tools: .vtu of the complex field, .pvd of a period's instants, .csv of the nodes.

The whole section of a motor has several 100 000 nodes.  The size of a large file is said before it is written; a .csv
of the surface alone is a thousandth of it.
"""

from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from fem import write_instant, write_vtu
from studies.record.files import write_columns
from studies.view.run_field import LINES, RunField

LARGE = 20e6  # bytes: from here on the size is said before it is written
# bytes per number: of a table; of a .vtu, whose vectors have a third component; of an instant, in single precision
TABLE, COMPLEX, INSTANT = 19.5, 9.0, 2.2


def save(
    run: RunField,
    file: str | Path,
    *,
    span: tuple[float, float] | None,
    instants: int,
    progress: Callable[[str], None],
    note: Callable[[str], None],
    surface: bool = False,
) -> None:
    """Write displacement, potential, strain energy and power flow of a run, in the span (m) or the whole section.

    ``.vtu``: the complex field, two arrays each, and means and pulses of energy and power.  ``.pvd``: a list of
    instants of one period, each a .vtu beside it in a directory of the same name, for ParaView's clock.  ``.csv``: a
    row for each node, complex columns as two; with ``surface`` of the surface alone.  ``note`` is told the size of a
    large file before it is written.
    """
    file = Path(file)
    energies = not surface
    if span is None:
        field = run.with_energies if energies else run.field
    else:
        field = run.compute(span=span, per_wavelength=LINES, energies=energies)
    size = expected_size(field, file, instants)
    if size > LARGE and not surface:
        less = (
            "--surface writes the surface alone, --span a part"
            if file.suffix.lower() == ".csv"
            else "--span writes a part"
        )
        note(f"writing about {size / 1e6:.0f} MB to {file}, {field.potential.size} nodes; {less}")
    if surface:
        write_columns(file, surface_columns(field))
    elif file.suffix.lower() == ".csv":
        write_columns(file, columns(field))
    elif file.suffix.lower() == ".vtu":
        write_vtu(field, file)
    else:
        _series(field, file, instants, progress)


def expected_size(field, file: Path, instants: int) -> float:
    """Return about how many bytes a file of a field will have; of a .pvd with all its instants."""
    # x and z; u and potential, complex; strain energy and the two parts of power flow, each a mean and a complex pulse
    numbers = field.potential.size * (2 + 2 * 4 + 3 * 3)
    kind = file.suffix.lower()
    return numbers * (instants * INSTANT if kind == ".pvd" else TABLE if kind == ".csv" else COMPLEX)


def surface_columns(field) -> dict[str, np.ndarray]:
    """Return displacement and potential of the surface as columns, a row for each line of nodes."""
    table = {"x_m": field.x}
    table |= {f"u_{axis}_m_per_V": field.displacement[:, -1, k] for k, axis in enumerate("xyz")}
    return table | {"potential_V_per_V": field.potential[:, -1]}


def columns(field) -> dict[str, np.ndarray]:
    """Return a field with densities as columns, a row for each node, line by line from the bottom up."""
    x, z = np.meshgrid(field.x, field.z, indexing="ij")
    run = field.densities
    table = {"x_m": x, "z_m": z}
    table |= {f"u_{axis}_m_per_V": field.displacement[..., k] for k, axis in enumerate("xyz")}
    table |= {
        "potential_V_per_V": field.potential,
        "strain_energy_J_per_m3_per_V2": run.strain_energy,
        "strain_energy_pulse_J_per_m3_per_V2": run.strain_energy_pulse,
    }
    for k, axis in enumerate("xz"):
        table[f"power_flow_{axis}_W_per_m2_per_V2"] = run.power_flow[..., k]
        table[f"power_flow_{axis}_pulse_W_per_m2_per_V2"] = run.power_flow_pulse[..., k]
    return {name: values.ravel() for name, values in table.items()}


def _series(field, file: Path, instants: int, progress) -> None:
    folder = file.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1", byte_order="LittleEndian")
    collection = ElementTree.SubElement(root, "Collection")
    for number in range(instants):
        progress(f"instant {number + 1} of {instants}")
        name = f"{number:03d}.vtu"
        write_instant(field, 2 * np.pi * number / instants, folder / name)
        moment = repr(number / instants / field.frequency)
        ElementTree.SubElement(collection, "DataSet", timestep=moment, part="0", file=f"{folder.name}/{name}")
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(file, encoding="utf-8", xml_declaration=True)
