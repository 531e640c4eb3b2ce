"""Ports: which transducers have one, which potentials they stand for, and how charges become currents."""

from dataclasses import replace

import numpy as np
import pytest

from fem.condense.electrode_conditions import electrode_potentials, transducer_ports
from fem.geometry import Transducer
from fem.waveguide.port_fields import charge_currents

A = Transducer(name="a", center=0.1, finger_pairs=1, period=1e-3, metallisation=0.5, aperture=0.02)


def potentials_of(transducer, floating):
    return electrode_potentials(transducer, transducer_ports(transducer, not floating))


def test_electrodes():
    """Half a volt either way; the mean is another degree of freedom where the section is grounded."""
    assert np.array_equal(potentials_of(A, True), [[0.5], [-0.5]])
    assert np.array_equal(potentials_of(A, False), [[0.5, 1.0], [-0.5, 1.0]])


def test_one_electrode_has_no_voltage():
    """A shorted reflector is one conductor, an open one none."""
    shorted, open_circuited = replace(A, pattern="++"), replace(A, pattern="oo")
    assert potentials_of(shorted, True).shape == potentials_of(open_circuited, False).shape == (2, 0)
    assert np.array_equal(potentials_of(shorted, False), [[1.0], [0.0]])


def test_charges_become_currents():
    """I = i omega Q aperture with Q = -q; the narrower beam is shared."""
    q = np.array([[-2e-10, 1e-11], [1e-11, -3e-10]])
    shared = np.array([[0.02, 0.02], [0.02, 0.05]])
    y = charge_currents(q * shared, 1e6)
    omega = 2e6 * np.pi
    assert y[0, 0] == pytest.approx(1j * omega * 2e-10 * 0.02, rel=1e-14)
    assert y[1, 1] == pytest.approx(1j * omega * 3e-10 * 0.05, rel=1e-14)
    assert y[0, 1] == y[1, 0] == pytest.approx(-1j * omega * 1e-11 * 0.02, rel=1e-14)
