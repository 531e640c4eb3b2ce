"""How far a network analyser's file is from the prediction: resonance, G, C0, K2 and loss of each transducer.

Each transducer's input admittance, the other ports open, at the file's own frequencies.  Resonance: where G is largest.
C0, K2 and loss: of the circuit of C0 and one motional branch that fits best (`fem.motional_model`): K2 is C1/C0 times a
factor of the geometry, so only the ratio of two is said; the loss is the branch's 1/Q.  Where no circuit fits C0 is the
mean of Im Y/omega over the outer tenths of the band.
"""

import numpy as np

import fem
from studies.lab.network import NetworkData

EDGE = 0.1  # share of the band at either end from which C0 is taken


def deviations(seen: NetworkData, predicted: np.ndarray, names: list[str]) -> list[tuple[str, str]]:
    """Return what the file says beside the prediction, rows of a name and a line."""
    own = NetworkData(name="", frequency=seen.frequency, scattering=predicted, reference=seen.reference)
    gap = np.sqrt(np.mean(np.abs(seen.scattering - predicted) ** 2))
    span = f"{seen.frequency[0] / 1e6:.5g} to {seen.frequency[-1] / 1e6:.5g} MHz"
    rows = [("measured", f"{seen.name}: {len(seen.frequency)} frequencies, {span}; deviation of S {gap:.3g} rms")]
    for k, name in enumerate(names):
        measured, computed = (_input(each, k) for each in (seen, own))
        for key, unit, scale in (("resonance", "MHz", 1e-6), ("G", "mS", 1e3), ("C0", "pF", 1e12), ("K2", "", 1.0),
                                 ("loss", "", 1.0)):  # fmt: skip
            if key not in measured or key not in computed:
                continue
            a, b = measured[key], computed[key]
            if key == "K2":
                rows.append((name, f"K2 over the predicted {a / b:.4g}"))
                continue
            rows.append((name, f"{key} {a * scale:.5g} {unit} measured, {b * scale:.5g} {unit} predicted, "
                               f"{100 * (a / b - 1.0):+.3g} %"))  # fmt: skip
    return rows


def _input(data: NetworkData, port: int) -> dict[str, float]:
    """Return resonance, G there, C0, a measure of K2 and loss of the input admittance, the other ports open."""
    impedance = np.linalg.inv(data.admittance)[:, port, port]
    at, y = data.frequency, 1.0 / impedance
    top, edge = int(np.argmax(y.real)), max(1, round(EDGE * len(at)))
    susceptance = y.imag / (2.0 * np.pi * at)
    circuit = {"resonance": float(at[top]), "G": float(y.real[top]),
             "C0": float(np.mean(np.concatenate([susceptance[:edge], susceptance[-edge:]])))}  # fmt: skip
    if len(at) < 8 or top in (0, len(at) - 1):
        return circuit
    try:
        model = fem.motional_model(at, y, 1)
    except (fem.ConvergenceError, ValueError):
        return circuit
    resistance, inductance, capacitance = model.branches[0]
    quality = np.sqrt(inductance / capacitance) / resistance
    ratio = capacitance / model.capacitance
    return circuit | {"C0": float(model.capacitance), "K2": float(ratio), "loss": float(1.0 / quality)}
