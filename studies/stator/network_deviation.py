"""Deviation of a network analyser's file from the prediction: resonance, G, C0, K2 and loss of each transducer.

They are those of the input admittance at the frequencies of the file, the other ports open, or at the reference
impedance where the file does not hold all S-parameters.  Resonance: where G is
largest.  C0, K2 and loss: of the best circuit of C0 and one motional branch (`fem.motional_model`); K2 is C1/C0 times
a factor of the geometry, so that only the ratio to the prediction is stated; the loss is 1/Q of the branch.  If no
circuit fits, C0 is the mean of Im Y/omega over the outer tenths of the band.
"""

from dataclasses import replace
from itertools import permutations

import numpy as np

import fem
from studies.lab.s_parameters import NetworkData

UNITS = {"resonance": ("MHz", 1e-6), "G": ("mS", 1e3), "C0": ("pF", 1e12), "K2": ("", 1.0), "loss": ("", 1.0)}
# Deviation after an exchange of ports over the one before, below which the exchange is remarked
EXCHANGED = 0.5
MIN_GAP = 1e-3  # rms deviation of S below which no exchange is looked for
MAX_PERMUTED = 4  # ports whose orders are all tried
EDGE = 0.1  # share of the band at either end from which C0 is taken


def deviations(measured: NetworkData, predicted: np.ndarray, names: list[str]) -> list[tuple[str, str]]:
    """Return lines of the answer, label and text: deviation of predicted S-parameters from a file."""
    gap, at = _gap(measured, predicted), measured.frequency
    span = f"{at[0] / 1e6:.5g} to {at[-1] / 1e6:.5g} MHz"
    lines = [("measured", f"{measured.name}: {len(at)} frequencies, {span}; deviation of S {gap:.3g} rms")]
    lines += [("", remark) for remark in (*measured.remarks, *_exchanged(measured, predicted, gap))]
    for k, name in enumerate(names):
        ours, theirs = (_input(each, k) for each in (replace(measured, scattering=predicted), measured))
        for key in (key for key in UNITS if key in ours and key in theirs):
            (unit, scale), a, b = UNITS[key], theirs[key], ours[key]
            text = (
                f"{key} {a * scale:.5g} {unit} measured, {b * scale:.5g} {unit} predicted, {100 * (a / b - 1):+.3g} %"
            )
            lines.append((name, f"K2 over the predicted {a / b:.4g}" if key == "K2" else text))
    return lines


def _gap(measured: NetworkData, predicted: np.ndarray) -> float:
    """Return the rms deviation of the measured S-parameters."""
    return float(np.sqrt(np.mean(np.abs(measured.scattering - predicted)[:, measured.elements] ** 2)))


def _exchanged(measured: NetworkData, predicted: np.ndarray, gap: float) -> list[str]:
    """Return a remark on ports in another order that would agree much better."""
    if not measured.complete or measured.ports > MAX_PERMUTED or gap < MIN_GAP:
        return []
    orders = list(permutations(range(measured.ports)))[1:]
    gaps = [_gap(measured, predicted[:, order][:, :, order]) for order in orders]
    if not gaps or min(gaps) > EXCHANGED * gap:
        return []
    order = ", ".join(str(each + 1) for each in orders[int(np.argmin(gaps))])
    return [f"are ports exchanged? With the file's ports as transducers {order} the deviation is {min(gaps):.3g} rms"]


def _input(data: NetworkData, port: int) -> dict[str, float]:
    """Return resonance, G there, C0, a measure of K2 and loss of an input admittance; nothing if it is unknown."""
    at, s = data.frequency, data.scattering
    if data.ports > 1 and data.complete:
        one = np.eye(data.ports)
        try:
            y = 1.0 / (data.reference * np.linalg.solve(one - s, one + s)[:, port, port])
        except np.linalg.LinAlgError:  # without an impedance matrix
            return {}
    elif data.elements[port, port]:
        with np.errstate(divide="ignore", invalid="ignore"):  # a short has no admittance
            y = (1.0 - s[:, port, port]) / (1.0 + s[:, port, port]) / data.reference
    else:
        return {}
    at, y = at[np.isfinite(y)], y[np.isfinite(y)]
    if not len(at):
        return {}
    top, edge = int(np.argmax(y.real)), max(1, round(EDGE * len(at)))
    susceptance = y.imag / (2.0 * np.pi * at)
    circuit = {"resonance": float(at[top]), "G": float(y.real[top]),
             "C0": float(np.mean(np.concatenate([susceptance[:edge], susceptance[-edge:]])))}  # fmt: skip
    if len(at) < 8 or top in (0, len(at) - 1) or y.real[top] <= 0.0:
        return circuit
    try:
        model = fem.motional_model(at, y, 1)
    except (fem.ConvergenceError, ValueError):
        return circuit
    resistance, inductance, capacitance = model.branches[0]
    quality = np.sqrt(inductance / capacitance) / resistance
    ratio = capacitance / model.capacitance
    return circuit | {"C0": float(model.capacitance), "K2": float(ratio), "loss": float(1.0 / quality)}
