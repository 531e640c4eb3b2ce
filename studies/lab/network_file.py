"""Files of network analysers: Touchstone, or the table of an impedance analyser."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from studies.lab.analyser_csv import network_of_text
from studies.lab.csv_columns import above_zero
from studies.lab.s_parameters import NetworkData, gains
from studies.lab.touchstone import TOUCHSTONE, TouchstoneFile, read_touchstone
from studies.lab.waves import in_ohm, scattering


def read_network(path: Path, option: str) -> NetworkData:
    """Return the data of a Touchstone file, or of the CSV of an impedance analyser.

    Raises
    ------
    SceneError
        If it cannot be read, is neither of these, or its frequencies do not rise.
    """
    if not TOUCHSTONE.fullmatch(path.suffix):
        return network_of_text(path, option)
    file = read_touchstone(path, option)
    file.refuse_if(not file.frequency, f"must hold S-parameters of {file.ports} ports, got none")
    return network_of(file)


def network_of(file: TouchstoneFile) -> NetworkData:
    """Return the S-parameters of a Touchstone file with the real part of its first reference, and remarks."""
    at, values, references = np.array(file.frequency), file.matrices(), file.impedance()
    remarks = ["noise parameters are left out"] if file.has_noise else []
    file.refuse_if(np.any(np.diff(at) <= 0.0) or at[0] < 0.0, "must have rising frequencies above 0 Hz")
    if at[0] == 0.0:
        kept = above_zero(at, file.error)
        at, values, references = at[kept], values[kept], references[kept]
        remarks.append("the point at 0 Hz is left out")
    measured = np.any(values != 0.0, axis=0)
    name, target = file.path.name, float(references[0, 0].real)
    if not np.all(measured):
        missing = ", ".join(f"{file.kind.upper()}{i + 1}{j + 1}" for i, j in np.argwhere(~measured))
        equal = np.all(references == target)
        file.refuse_if(
            file.kind != "s" or not equal or not np.any(measured),
            f"holds zeros only in {missing}: not measured, and no S-parameters follow from the rest",
        )
        remarks.append(f"{missing} of zeros only: taken as not measured")
    if file.kind != "s" and file.version == 1:
        file.refuse_if(
            np.any(references.imag != 0.0), "must have a real reference, to which version 1 normalises its parameters"
        )
        values = in_ohm(file.kind, values, references.real)
    if file.kind == "s" and np.any(references != target):
        wave = file.wave or ("traveling" if file.impedances else "power")
        complex_references = bool(np.any(references.imag != 0.0))
        remarks.append(
            f"its references are changed to {target:g} ohm" + (f", {wave} waves" if complex_references else "")
        )
    try:
        wave = file.wave or ("traveling" if file.impedances else "power")
        found = scattering(file.kind, values, target, references, wave)
    except np.linalg.LinAlgError:
        raise file.error("has parameters to which no S-parameters belong") from None
    data = NetworkData(name=name, frequency=at, scattering=found, reference=target,
                       measured=None if np.all(measured) else measured, remarks=tuple(remarks))  # fmt: skip
    return replace(data, remarks=(*data.remarks, *gains(data)))
