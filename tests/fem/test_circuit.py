"""The circuit: terminations of a passive reciprocal network, in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fem.circuit import circuit, port_admittances, ports_of
from fem.geometry import Transducer

A = Transducer(name="a", center=0.1, finger_pairs=1, period=1e-3, metallisation=0.5, aperture=0.02)
B = replace(A, name="b", center=0.2)
FLOATING = [ports_of(A, True)] * 2
GROUNDED = [ports_of(A, False)] * 2
Y = np.array([[3e-3 + 8e-3j, -1e-3 + 5e-4j], [-1e-3 + 5e-4j, 2e-3 + 6e-3j]])


def seen(termination, source_impedance=0.0, matrix=Y):
    return circuit(
        matrix,
        (A, replace(B, termination=termination)),
        FLOATING,
        driven="a",
        source_impedance=source_impedance,
    )


def test_open_and_short():
    """Open: no current, Y11 - Y12^2/Y22 is seen; short: no voltage, Y11 is seen."""
    opened, shorted = seen("open"), seen("short")
    assert abs(opened.currents[1]) < 1e-18
    assert opened.admittance == pytest.approx(Y[0, 0] - Y[0, 1] ** 2 / Y[1, 1], rel=1e-14)
    assert shorted.voltages[1] == 0
    assert shorted.admittance == pytest.approx(Y[0, 0], rel=1e-14)
    assert opened.voltages[0] == shorted.voltages[0] == 1


@given(real=st.floats(0, 1e4), imaginary=st.floats(-1e4, 1e4))
def test_impedance(real, imaginary):
    """V = -Z I at the load: Y11 - Y12^2 Z/(1 + Z Y22); the source's power is the field's plus nothing."""
    z = complex(real, imaginary)
    loaded = seen(z)
    assert loaded.voltages[1] == pytest.approx(-z * loaded.currents[1], rel=1e-9, abs=1e-15)
    assert loaded.admittance == pytest.approx(Y[0, 0] - Y[0, 1] ** 2 * z / (1 + z * Y[1, 1]), rel=1e-9)


def test_limits_of_the_impedance():
    assert seen(0j).admittance == seen("short").admittance
    assert seen(1e-9).admittance == pytest.approx(seen("short").admittance, rel=1e-9)
    assert seen(1e13).admittance == pytest.approx(seen("open").admittance, rel=1e-9)


@pytest.mark.parametrize("impedance", [50.0, 20.0 - 70.0j, 1e6])
def test_source_impedance_divides_the_voltage(impedance):
    """V = 1/(1 + Z Y): what the combs get; the admittance seen does not change."""
    bare, behind = seen("open"), seen("open", impedance)
    assert behind.admittance == pytest.approx(bare.admittance, rel=1e-12)
    assert behind.voltages[0] == pytest.approx(1 / (1 + impedance * bare.admittance), rel=1e-12)
    assert behind.power == pytest.approx(0.5 * bare.admittance.real * abs(behind.voltages[0]) ** 2, rel=1e-12)


def test_power_splits_between_field_and_load():
    """Re(V I*)/2 of both ports is what the field takes; the load takes |I|^2 R/2 of it."""
    loaded = seen(40.0 + 9.0j)
    field = 0.5 * np.sum((loaded.voltages * loaded.currents.conj()).real)
    load = 0.5 * 40.0 * abs(loaded.currents[1]) ** 2
    assert loaded.power == pytest.approx(field + load, rel=1e-12)
    assert field > 0


def test_grounded_sections_have_a_mean_port():
    """No transducer, driven or terminated in any way, carries a net charge."""
    random = np.random.default_rng(5)
    matrix = random.normal(size=(4, 4)) * 1e-4 + 1j * random.normal(size=(4, 4)) * 1e-3
    matrix = matrix + matrix.T + np.diag([8e-3j, 9e-3j, 7e-3j, 9e-3j])
    for termination in ("open", "short", 30.0 + 1j):
        found = circuit(
            matrix,
            (A, replace(B, termination=termination)),
            GROUNDED,
            driven="b" if termination == "open" else "a",
            source_impedance=0.0,
        )
        driven, other = (2, 0) if termination == "open" else (0, 2)
        assert found.driven == driven
        assert found.voltages[driven] == pytest.approx(1, rel=1e-14)
        assert abs(found.currents[driven + 1]) < 1e-16
        assert abs(found.currents[other + 1]) < 1e-16
    assert ports_of(A, True).potentials.shape == (2, 1)
    assert ports_of(A, False).potentials.shape == (2, 2)
    assert np.array_equal(ports_of(A, False).potentials[:, 0], [0.5, -0.5])


def test_one_comb_has_no_voltage():
    """A shorted reflector is one conductor, an open one none; neither can be driven."""
    shorted, opened = replace(A, pattern="++"), replace(A, pattern="oo")
    assert ports_of(shorted, True).kinds == ports_of(opened, False).kinds == ()
    assert ports_of(shorted, False).kinds == ("mean",)
    assert np.array_equal(ports_of(shorted, False).potentials[:, 0], [1.0, 0.0])
    wiring = [ports_of(A, True), ports_of(shorted, True)]
    with pytest.raises(ValueError, match="must have two combs, but 'b' has not"):
        circuit(Y[:1, :1], (A, replace(shorted, name="b")), wiring, driven="b", source_impedance=0.0)


def test_charges_become_currents():
    """I = i omega Q aperture with Q = -q; the narrower beam is shared."""
    q = np.array([[-2e-10, 1e-11], [1e-11, -3e-10]])
    wide = replace(B, aperture=0.05)
    y = port_admittances(q, (A, wide), FLOATING, 1e6)
    omega = 2e6 * np.pi
    assert y[0, 0] == pytest.approx(1j * omega * 2e-10 * 0.02, rel=1e-14)
    assert y[1, 1] == pytest.approx(1j * omega * 3e-10 * 0.05, rel=1e-14)
    assert y[0, 1] == y[1, 0] == pytest.approx(-1j * omega * 1e-11 * 0.02, rel=1e-14)


def test_unknown_transducer_is_refused():
    with pytest.raises(ValueError, match=r"drive\.transducer must be one of a, b, got 'c'"):
        circuit(Y, (A, B), FLOATING, driven="c", source_impedance=0.0)
