"""The stored cases of the study `stability`: random corners of the contact, and references of the driven stator.

`python -m tests.stability_cases` writes `corners.json` and `stator_references.csv` beside the study (about 2 min of one
processor); `tests/studies/test_stability.py` compares them with what this module makes.
"""

import json
from functools import cache

import numpy as np

from fem import Resolution, slowest_wavelength, solve_circuit
from studies.evidence.stability import reference_solutions, stator
from studies.record.text import csv_text
from tests.fem.direct import direct_solution
from tests.motors import corner

CORNERS = 120
STORED = [
    (name, float(value)) for name, (_, values, _, kind) in stator.VARIED.items() if kind != "finer" for value in values
]


def whole_section(motor) -> tuple[complex, np.ndarray]:
    """Return admittance in S and motion in m per volt by one sparse matrix, at a fixed resolution, short elements."""
    solution = direct_solution(
        motor.stator,
        motor.transducers,
        frequency=motor.frequency,
        resolution=Resolution(order=6, edge_layers=2),
        wavelength=slowest_wavelength(motor.stator.solid, motor.frequency),
        segment_size=0.25,
        segment_layers=3,
    )
    circuit = solve_circuit(solution.admittances, solution.names, motor.transducers, motor.drive, motor.frequency)
    return circuit.admittance, solution.surface(np.array([motor.position]))[:, 0] @ circuit.voltages


@cache
def _small() -> tuple[complex, np.ndarray]:
    return whole_section(stator.small_motor())


def of_size(_) -> tuple[complex, np.ndarray]:
    """Return the answer at 2.2 MHz: scaled with its wavelength, a motor has the same motion per volt and admittance.

    At the same voltage the charge per aperture is the same, and so is the frequency times the aperture.
    """
    return _small()


def behind_impedance(motor) -> tuple[complex, np.ndarray]:
    """Return the answer without source impedance behind a voltage divider."""
    admittance, motion = _small()
    return admittance, motion / (1 + motor.source_impedance * admittance)


KINDS = {"direct": whole_section, "size": of_size, "circuit": behind_impedance}


def stator_reference(name: str, value: float) -> tuple[complex, np.ndarray]:
    """Return admittance and motion of a case."""
    _, _, motor_of, kind = stator.VARIED[name]
    return KINDS[kind](motor_of(value))


def corners() -> list[dict]:
    """Return the random corners of the contact."""
    return [corner(number) for number in range(CORNERS)]


def main() -> None:
    """Write both files."""
    rows = []
    for name, value in STORED:
        admittance, (u_x, u_z) = stator_reference(name, value)
        numbers = {"admittance_S": admittance, "u_x_m_per_V": u_x, "u_z_m_per_V": u_z}
        rows.append(
            {"varied": name, "value": repr(value)} | {key: f"{complex(each):.12e}" for key, each in numbers.items()}
        )
    reference_solutions.STORED.write_text(csv_text(rows), encoding="utf-8")
    lines = ",\n".join(json.dumps(each) for each in corners())
    reference_solutions.STORED.with_name("corners.json").write_text(f"[\n{lines}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main()
