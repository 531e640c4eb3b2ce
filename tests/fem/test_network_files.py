"""Touchstone files against scikit-rf, and motional circuits against a nodal evaluation of their netlists."""

import numpy as np
import pytest
import skrf

from fem import motional_model, touchstone


def parameters(ports: int, count: int = 5) -> np.ndarray:
    rng = np.random.default_rng(ports)
    return 0.3 * (rng.normal(size=(count, ports, ports)) + 1j * rng.normal(size=(count, ports, ports)))


FREQUENCY = np.linspace(1.9e6, 2.5e6, 5) + 1 / 3


@pytest.mark.parametrize("ports", [1, 2, 3, 4, 5])
def test_scikit_rf_reads_what_is_written(ports, tmp_path):
    """Bit for bit: all digits of a double are written; the order of ports is that of the standard."""
    values, file = parameters(ports), tmp_path / f"network.s{ports}p"
    file.write_text(touchstone(FREQUENCY, values, 75.0, ("ports: a, b", "made up")))
    read = skrf.Network(str(file))
    assert np.array_equal(read.f, FREQUENCY)
    assert np.array_equal(read.s, values)
    assert np.all(read.z0 == 75.0)


def netlist_admittance(text: str, name: str, frequency: float) -> complex:
    """Y between p and n of a subcircuit, by Kirchhoff's current law at every node of its netlist."""
    lines = text.split(f".subckt {name} p n\n")[1].split(".ends")[0].splitlines()
    elements = [line.split() for line in lines]
    nodes = sorted({node for _, a, b, _ in elements for node in (a, b)} - {"n"}, key=lambda node: node != "p")
    matrix, s = np.zeros((len(nodes), len(nodes)), dtype=complex), 2j * np.pi * frequency
    for label, a, b, value in elements:
        y = {"R": 1 / float(value), "L": 1 / (s * float(value)), "C": s * float(value)}[label[0]]
        for one, other in ((a, b), (b, a)):
            if one != "n":
                matrix[nodes.index(one), nodes.index(one)] += y
                if other != "n":
                    matrix[nodes.index(one), nodes.index(other)] -= y
    return 1 / np.linalg.solve(matrix, np.eye(len(nodes))[0])[0]


def row_of_fingers(frequency, pairs=10, middle=2.2e6):
    """A comb without reflections: G0 sinc^2 X, its Hilbert partner and a capacitance."""
    x = np.pi * pairs * (frequency - middle) / middle
    x = np.where(abs(x) < 1e-9, 1e-9, x)
    return 7e-3 * ((np.sin(x) / x) ** 2 + 1j * (np.sin(2 * x) - 2 * x) / (2 * x**2)) + 1j * 2e-9 * 2 * np.pi * frequency


@pytest.mark.parametrize(("branches", "within"), [(1, 0.1), (5, 0.02)])
def test_the_netlist_is_the_admittance_to_the_error_that_it_states(branches, within):
    f = np.linspace(1.9e6, 2.5e6, 121)
    y = row_of_fingers(f)
    model = motional_model(f, y, branches)
    text = model.spice("row")
    seen = np.array([netlist_admittance(text, "row", at) for at in f])
    assert seen == pytest.approx(model.admittance(f), rel=1e-8)
    worst = abs(seen - y).max() / abs(y).max()
    assert worst == pytest.approx(model.error, rel=1e-6)
    assert worst < within
    assert seen.real.min() > 0
    assert f"largest error {model.error:.2g}" in text


def test_a_circuit_of_one_branch_is_found_again():
    f = np.linspace(1.9e6, 2.5e6, 121)
    s = 2j * np.pi * f
    y = s * 2e-9 + 1 / 5e3 + 1 / (100.0 + s * 1e-4 + 1 / (s * 5.2e-11))
    model = motional_model(f, y)
    assert model.error < 1e-6
    assert model.capacitance == pytest.approx(2e-9, rel=1e-4)
    assert model.branches[0] == pytest.approx([100.0, 1e-4, 5.2e-11], rel=1e-4)
