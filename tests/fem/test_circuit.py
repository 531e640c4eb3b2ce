"""The circuit: terminations of a passive reciprocal network, in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fem.circuit import Drive, Element, best_match, carried, matched_load, rectifier_resistance, solve_circuit
from fem.geometry import Transducer

A = Transducer(name="a", center=0.1, finger_pairs=1, period=1e-3, metallisation=0.5, aperture=0.02)
B = replace(A, name="b", center=0.2)
FREQUENCY = 2.2e6
Y = np.array([[3e-3 + 8e-3j, -1e-3 + 5e-4j], [-1e-3 + 5e-4j, 2e-3 + 6e-3j]])


def seen(termination, source_impedance=0.0, matrix=Y):
    drive = Drive(sources={"a": 1.0}, impedance=source_impedance)
    return solve_circuit(matrix, ("a", "b"), (A, replace(B, termination=termination)), drive, FREQUENCY)


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


SOURCES = {"a": 0.7 - 0.2j, "b": 0.5j}


@pytest.mark.parametrize("impedance", [0.0, 50.0 + 10.0j])
def test_two_sources_are_the_sum_of_two_runs(impedance):
    """Each source alone, the other one's voltage zero but its impedance there: their sum is both at once."""
    both = solve_circuit(Y, ("a", "b"), (A, B), Drive(sources=SOURCES, impedance=impedance), FREQUENCY)
    alone = [
        solve_circuit(
            Y,
            ("a", "b"),
            (A, B),
            Drive(sources=dict.fromkeys(SOURCES, 0) | {name: 1.0}, impedance=impedance),
            FREQUENCY,
        )
        for name in SOURCES
    ]
    summed = sum(amplitude * each.voltages for amplitude, each in zip(SOURCES.values(), alone, strict=True))
    assert both.voltages == pytest.approx(summed, rel=1e-13)
    taken = 0.5 * np.sum((both.voltages * both.currents.conj()).real)
    assert both.power == pytest.approx(taken, rel=1e-13)


def test_a_source_of_zero_is_a_load():
    """Amplitude 0 behind an impedance is that impedance; the admittance is that of the source that is on."""
    drive = Drive(sources={"b": 0.0, "a": 1.0}, impedance=50.0)
    found, loaded = solve_circuit(Y, ("a", "b"), (A, B), drive, FREQUENCY), seen(50.0, 50.0)
    assert found.voltages == pytest.approx(loaded.voltages, rel=1e-14)
    assert found.admittance == pytest.approx(loaded.admittance, rel=1e-13)
    assert found.aperture == A.aperture


@pytest.mark.parametrize(
    ("sources", "message"),
    [
        ({}, "at least one amplitude that is not 0, got {}"),
        ({"a": np.nan}, r"sources\.a must be a finite number, real or complex, got nan"),
        ({"a": 0.0}, "at least one amplitude that is not 0"),
    ],
)
def test_impossible_sources_are_refused(sources, message):
    with pytest.raises(ValueError, match=message):
        Drive(sources=sources)


def test_only_transducers_with_two_electrodes_are_driven():
    with pytest.raises(ValueError, match="must name transducers that have two electrodes, but 'b' has not"):
        solve_circuit(Y[:1, :1], ("a",), (A, replace(B, pattern="++")), "b", FREQUENCY)
    with pytest.raises(ValueError, match=r"sources must name transducers of the stator, a, b, got 'c'"):
        solve_circuit(Y, ("a", "b"), (A, B), "c", FREQUENCY)


LADDERS = [
    (),
    (Element(place="series", kind="L", value=2.6e-6, quality=80.0), Element(place="shunt", kind="C", value=1e-9)),
    (
        Element(place="shunt", kind="R", value=300.0),
        Element(place="series", kind="C", value=2e-9, quality=200.0),
        Element(place="shunt", kind="L", value=3e-6, quality=50.0),
    ),
]


@pytest.mark.parametrize("ladder", LADDERS)
@pytest.mark.parametrize("impedance", [50.0, 20.0 - 70.0j, 0.0])
def test_a_ladder_is_the_nodal_equations_of_its_elements(ladder, impedance):
    """Against Kirchhoff's current law at every node, the source as its Norton equivalent behind 1e-9 ohm at least."""
    source = impedance or 1e-9
    admittance = seen("open").admittance
    nodes, at = np.zeros((len(ladder) + 1, len(ladder) + 1), dtype=complex), 0
    nodes[0, 0] = 1 / source
    for element in ladder:
        y = 1 / element.impedance(2 * np.pi * FREQUENCY)
        if element.place == "shunt":
            nodes[at, at] += y
        else:
            nodes[at : at + 2, at : at + 2] += y * np.array([[1, -1], [-1, 1]])
            at += 1
    nodes[at, at] += admittance
    potentials = np.linalg.solve(nodes[: at + 1, : at + 1], np.eye(at + 1)[0] / source)
    drive = Drive(sources={"a": 1.0}, impedance=impedance, match=ladder)
    found = solve_circuit(Y, ("a", "b"), (A, B), drive, FREQUENCY)
    assert found.voltages[0] == pytest.approx(potentials[at], rel=1e-6)
    assert found.admittance == pytest.approx(admittance, rel=1e-12)


@pytest.mark.parametrize("ladder", LADDERS)
def test_the_sources_powers_add_up(ladder):
    """Given = lost in source and ladder + into the transducers; what is available bounds what is delivered."""
    drive = Drive(sources=SOURCES, impedance=50.0 + 10.0j, match=ladder)
    found = solve_circuit(Y, ("a", "b"), (A, B), drive, FREQUENCY)
    powers = found.network
    assert powers.delivered == pytest.approx(powers.in_sources + powers.in_ladders + found.power, rel=1e-13)
    assert powers.available == pytest.approx((abs(0.7 - 0.2j) ** 2 + 0.25) / 400.0, rel=1e-14)
    assert powers.in_ladders > 0 or not ladder
    assert found.power < powers.available


@given(
    resistance=st.floats(1, 500),
    reactance=st.floats(-300, 300),
    conductance=st.floats(1e-5, 0.1),
    susceptance=st.floats(-0.1, 0.1),
)
def test_the_best_match_delivers_all_available_power(resistance, reactance, conductance, susceptance):
    source, load = complex(resistance, reactance), complex(conductance, susceptance)
    ladder = best_match(source, load, FREQUENCY)
    assert len(ladder) <= 2
    voltage, current, lost = carried(ladder, 2 * np.pi * FREQUENCY, 1.0, load)
    assert lost == 0
    assert voltage / current == pytest.approx(source.conjugate(), rel=1e-9)


@pytest.mark.parametrize(
    ("load", "elements"),
    [
        (7.27e-3 + 26.98e-3j, ("shunt_L", "series_L")),  # either order stores the load's reactive power
        (0.88e-3 + 7.77e-3j, ("shunt_L", "series_L")),
        (1 / complex(10.0, 400.0), ("series_C", "shunt_C")),
        (1 / 200.0, ("series_L", "shunt_C")),  # dual: series_C, shunt_L
        (1 / 10.0, ("shunt_C", "series_L")),
    ],
)
def test_matches_of_equal_energy_are_decided_by_a_rule_not_by_rounding(load, elements):
    """No series capacitor, then smaller elements: the same section for loads that differ by rounding."""
    for part in np.linspace(-4e-13, 4e-13, 41):
        ladder = best_match(50 + 0j, load * (1 + part + 0.3j * part), FREQUENCY)
        assert tuple(f"{each.place}_{each.kind}" for each in ladder) == elements


def test_a_match_needs_a_resistance_and_a_load():
    with pytest.raises(ValueError, match="needs a source with a resistance, got 0"):
        best_match(0j, 1e-3 + 1e-3j, FREQUENCY)
    with pytest.raises(ValueError, match="needs a load that takes power"):
        best_match(50 + 0j, 1e-3j, FREQUENCY)


def gains(load, source):
    """Power in the load at b over the largest that a source of an impedance at a could give, and over what enters."""
    row = (A, replace(B, termination=load))
    found = solve_circuit(Y, ("a", "b"), row, Drive(sources={"a": 1.0}, impedance=source), FREQUENCY)
    taken = 0.5 * abs(found.currents[1]) ** 2 * load.real
    return taken / found.network.available, taken / found.power


def test_a_matched_load_takes_the_most():
    drive = Drive(sources={"a": 1.0}, impedance=50.0 + 20.0j)
    best = matched_load(Y, ("a", "b"), (A, B), drive, "b", FREQUENCY)
    taken = gains(best, drive.impedance)[0]
    for part in (0.02, -0.02, 0.02j, -0.02j):
        assert gains(best * (1 + part), drive.impedance)[0] < taken


def test_matched_at_both_ends_the_gain_is_rolletts():
    """G = 1 / (K + (K^2 - 1)^1/2), K = (2 Re y11 Re y22 - Re y12 y21) / |y12 y21| (Rollett 1962)."""
    best = matched_load(
        Y, ("a", "b"), (A, B), Drive(sources={"a": 1.0}, impedance=50.0), "b", FREQUENCY, source_matched=True
    )
    product = Y[0, 1] * Y[1, 0]
    stability = (2 * Y[0, 0].real * Y[1, 1].real - product.real) / abs(product)
    assert gains(best, 50.0)[1] == pytest.approx(1 / (stability + np.sqrt(stability**2 - 1)), rel=1e-12)


def test_a_rectifier_is_the_resistance_of_its_fundamental():
    """A sinusoidal current into a bridge of +-V, whose mean drives V through the resistance: power and fundamental."""
    angle = (np.arange(100_000) + 0.5) * 2 * np.pi / 100_000
    current, resistance = 3.0, 80.0
    direct = np.mean(abs(current * np.sin(angle)))
    square = direct * resistance * np.sign(np.sin(angle))
    fundamental = 2 * np.mean(square * np.sin(angle))
    assert fundamental / current == pytest.approx(rectifier_resistance(resistance), rel=1e-8)
    assert direct**2 * resistance == pytest.approx(0.5 * current**2 * rectifier_resistance(resistance), rel=1e-8)
