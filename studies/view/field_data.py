"""A run's field as data for other tools: .vtu of the complex field, .pvd of a period's instants, .csv of the nodes."""

from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from studies.refusal import RunError, SceneError
from studies.report.files import write_columns
from studies.view.run_field import LINES, RunField

__all__ = ["FORMATS", "check", "save"]

FORMATS = (".vtu", ".pvd", ".csv")


def check(file: str | Path) -> None:
    """Refuse a file of an unknown format.

    Raises
    ------
    SceneError
        If it is none of `FORMATS`.
    """
    if Path(file).suffix.lower() not in FORMATS:
        raise SceneError("--data", f"must end in one of {', '.join(FORMATS)}, got {str(file)!r}")


def save(
    found: RunField,
    file: str | Path,
    *,
    span: tuple[float, float] | None,
    instants: int,
    progress: Callable[[str], None],
) -> None:
    """Write displacement, potential, strain energy and power flow of a run.

    Parameters
    ----------
    found : RunField
    file : str or Path
        ``.vtu``: the complex field, two arrays each, and means and pulses of energy and power.  ``.pvd``: a list of
        instants of one period, each a .vtu beside it in a directory of the same name, for ParaView's clock.  ``.csv``:
        a row for each node, complex columns as two.
    span : tuple of float or None
        m; the whole section if None.
    instants : int
        Of a .pvd.
    progress : callable
        Told what is being done.

    Raises
    ------
    SceneError, RunError
        If the format is unknown or the file cannot be written.
    """
    check(file)
    file = Path(file)
    whole = span is None
    field = (
        found.whole(energies=True) if whole else found.compute(span=span, per_wavelength=LINES, energies=True)
    )
    try:
        if file.suffix.lower() == ".csv":
            write_columns(file, columns(field))
        elif file.suffix.lower() == ".vtu":
            from fem import write_vtu

            write_vtu(field, file)
        else:
            _series(field, file, instants, progress)
    except OSError as error:
        raise RunError(f"the data file {str(file)!r} cannot be written: {error.strerror or error}") from None


def columns(field) -> dict[str, np.ndarray]:
    """Return a field with densities as columns, a row for each node, line by line from the bottom up."""
    x, z = np.meshgrid(field.x, field.z, indexing="ij")
    found = field.densities
    table = {"x_m": x, "z_m": z}
    table |= {f"u_{axis}_m_per_V": field.displacement[..., k] for k, axis in enumerate("xyz")}
    table |= {
        "potential_V_per_V": field.potential,
        "strain_energy_J_per_m3_per_V2": found.strain_energy,
        "strain_energy_pulse_J_per_m3_per_V2": found.strain_energy_pulse,
    }
    for k, axis in enumerate("xz"):
        table[f"power_flow_{axis}_W_per_m2_per_V2"] = found.power_flow[..., k]
        table[f"power_flow_{axis}_pulse_W_per_m2_per_V2"] = found.power_flow_pulse[..., k]
    return {name: values.ravel() for name, values in table.items()}


def _series(field, file: Path, instants: int, progress) -> None:
    from fem import write_instant

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
