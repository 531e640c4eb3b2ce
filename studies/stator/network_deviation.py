"""Deviation of a network analyser's file from the prediction: resonance, G, C0, K2 and loss of each transducer.

They are those of the input admittance, the other ports open, at the frequencies of the file.  Resonance: where G is
largest.  C0, K2 and loss: of the best circuit of C0 and one motional branch (`fem.motional_model`); K2 is C1/C0 times
a factor of the geometry, so that only the ratio to the prediction is stated; the loss is 1/Q of the branch.  If no
circuit fits, C0 is the mean of Im Y/omega over the outer tenths of the band.
"""

from dataclasses import replace

import numpy as np

import fem
from studies.lab.network import NetworkData

UNITS = {"resonance": ("MHz", 1e-6), "G": ("mS", 1e3), "C0": ("pF", 1e12), "K2": ("", 1.0), "loss": ("", 1.0)}
EDGE = 0.1  # share of the band at either end from which C0 is taken


def deviations(measured: NetworkData, predicted: np.ndarray, names: list[str]) -> list[tuple[str, str]]:
    """Return lines of the answer, label and text: deviation of predicted S-parameters from a file."""
    gap = np.sqrt(np.mean(np.abs(measured.scattering - predicted) ** 2))
    at = measured.frequency
    span = f"{at[0] / 1e6:.5g} to {at[-1] / 1e6:.5g} MHz"
    lines = [("measured", f"{measured.name}: {len(at)} frequencies, {span}; deviation of S {gap:.3g} rms")]
    for k, name in enumerate(names):
        ours, theirs = (_input(each, k) for each in (replace(measured, scattering=predicted), measured))
        for key in (key for key in UNITS if key in ours and key in theirs):
            (unit, scale), a, b = UNITS[key], theirs[key], ours[key]
            text = (
                f"{key} {a * scale:.5g} {unit} measured, {b * scale:.5g} {unit} predicted, {100 * (a / b - 1):+.3g} %"
            )
            lines.append((name, f"K2 over the predicted {a / b:.4g}" if key == "K2" else text))
    return lines


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
