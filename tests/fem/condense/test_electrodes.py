"""Electrical conditions of electrodes: each condition, put back into the matrix it was imposed on, holds."""

import numpy as np
import pytest

from fem.condense.electrode_conditions import charged, equipotential, is_port, open_circuit, terminated, uncharged
from tests.fem.stators import comb, lossless, plate

RNG = np.random.default_rng(5)
PORT = 2


def symmetric(size):
    """Complex symmetric matrix without further structure."""
    matrix = RNG.normal(size=(size, size)) + 1j * RNG.normal(size=(size, size))
    return matrix + matrix.T


def test_an_open_electrode_has_no_charge():
    """The potential that is recovered makes its reaction zero, and the others are those of the reduced matrix."""
    matrix, others = symmetric(6), RNG.normal(size=(6, 3)) + 0j
    opened, with_potential = open_circuit(matrix, PORT)
    unknowns = with_potential(others)
    reactions = matrix @ unknowns
    assert abs(reactions[PORT]).max() < 1e-13 * abs(reactions).max()
    assert opened @ others == pytest.approx(reactions, abs=1e-12)
    assert not opened[PORT].any()
    assert not opened[:, PORT].any()
    kept = np.delete(np.arange(6), PORT)
    assert (unknowns[kept] == others[kept]).all()


def test_an_equipotential_electrode_keeps_the_energy():
    """u^T A u with the nodes at the electrode's potential, and the charge of all of them at the electrode."""
    matrix, nodes = symmetric(6), np.array([0, 4])
    unknowns = RNG.normal(size=6) + 1j * RNG.normal(size=6)
    unknowns[nodes] = unknowns[PORT]
    tied = equipotential(matrix, nodes, PORT)
    assert unknowns @ tied @ unknowns == pytest.approx(unknowns @ matrix @ unknowns, rel=1e-13)
    reactions = matrix @ unknowns
    assert (tied @ unknowns)[PORT] == pytest.approx(reactions[[PORT, *nodes]].sum(), rel=1e-13)


@pytest.mark.parametrize("termination", ["open", "short", 50.0 - 20.0j])
def test_a_termination_is_obeyed(termination):
    """V = 0, I = 0 or V + Z I = 0 at a port that receives a current J, where I = Y V + J."""
    admittance, received = 0.02 + 0.01j, 0.3 - 0.2j
    a, b = terminated(termination, admittance)
    voltage = -b * received / (a + b * admittance)
    current = admittance * voltage + received
    impedance = {"open": np.inf, "short": 0.0}.get(termination, termination)
    if termination == "open":
        assert abs(current) < 1e-15
        assert abs(voltage) > 1.0
    else:
        assert voltage == pytest.approx(-impedance * current, rel=1e-13, abs=1e-15)


def test_no_transducer_has_a_net_charge():
    """Charges at the means vanish for every voltage and force; the voltages are those of the excitation."""
    voltage = np.array([True, False, True, False])
    charges = RNG.normal(size=(4, 5)) + 1j * RNG.normal(size=(4, 5))
    weights = uncharged(charges, voltage)
    assert abs(charges[~voltage] @ weights).max() < 1e-13
    assert (weights[[0, 2, 4]] == np.eye(3)).all()


def test_fingers_and_ports_of_a_pattern():
    """Omitted and open fingers have no electrode; a transducer of one electrode has no port."""
    stator = plate(lossless("PZT-8", "Z"), length=6.0, thickness=0.6)
    assert charged("+0o-").tolist() == [True, False, False, True]
    both, one = (comb(stator, "a", 3.0, finger_pairs=2, pattern=signs) for signs in ("+0o-", "+++o"))
    assert is_port(both)
    assert not is_port(one)
