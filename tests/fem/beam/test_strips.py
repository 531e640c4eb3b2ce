"""Apodised and slanted transducers as strips along y.

Truths: drawn fingers; the same transducer cut into strips; the Fourier transform of the taps (impulse response of weak
coupling); reciprocity, also of spreading beams between static charges, power; the mean over periods.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from fem import (
    InputError,
    Stator,
    Transducer,
    frequency_band,
    material,
    p_matrix,
    port_admittance,
    rotated,
    strip_beam,
    strips_of,
)  # fmt: skip
from fem.beam.beam_of_section import aperture_beam, surface_beam
from fem.beam.surface_beam import BeamError
from fem.geometry import MAX_STRIPS
from fem.solve.driven_stator import driven_wave
from tests.oracles.fem_static_strips import charge_transform, static_charges

F = 2.2e6
PLATE = Stator(solid=rotated(material("PZT-8"), "Z"), length=14e-3, thickness=1.5e-3, ends="absorbing")
SENDER = Transducer(name="t", center=4e-3, finger_pairs=3, period=1e-3, metallisation=0.5, aperture=8e-3)
RECEIVER = replace(SENDER, name="r", center=11e-3, finger_pairs=2)
WINDOW = (0.25, 0.75, 1.0, 1.0, 0.75, 0.25)


@cache
def section(stator, transducers, drive, x):
    return driven_wave(stator, transducers, frequency=F, drive=drive, tolerance=5e-2, places=x)


def solve(stator, transducers, drive, x):
    return driven_wave(stator, transducers, frequency=F, drive=drive, tolerance=5e-2, places=x)


def beam(*transducers, spreads=False, stator=PLATE, drive="t"):
    return strip_beam(stator, transducers, frequency=F, drive=drive, solve=solve, places=(8e-3,), spreads=spreads)


def test_each_strip_has_the_fingers_that_are_drawn_there():
    """Fingers + come from above down to -a W/2, fingers - from below up to a W/2; dummies of the other electrode."""
    drawn = replace(SENDER, overlaps=(1.0, 0.5, 0.0, 1.0, 0.5, 1.0))  # signs + - + - + -
    strips = strips_of((drawn,))
    assert [(each.low, each.high) for each in strips] == [(-4e-3, -2e-3), (-2e-3, 2e-3), (2e-3, 4e-3)]
    signs = [each.transducers[0].signs for each in strips]
    # at y = -3 mm: the third finger (a = 0) and the fifth (0.5) of + have ended; at 3 mm the second one of -
    assert signs == ["+-----", "+-+-+-", "+++-+-"]
    assert [each.transducers[0].aperture for each in strips] == [2e-3, 4e-3, 2e-3]
    assert [each.transducers[0].center_y for each in strips] == pytest.approx([-3e-3, 0.0, 3e-3])
    narrow = replace(RECEIVER, aperture=4e-3)
    assert [[each.name for each in strip.transducers] for strip in strips_of((drawn, narrow))] == [
        ["t"],
        ["t", "r"],
        ["t"],
    ]
    slanted = replace(SENDER, slant=0.2, slant_strips=4)
    periods = [each.transducers[0].period for each in strips_of((slanted,))]
    np.testing.assert_allclose(periods, 1e-3 * (1 + 0.2 * np.array([-0.375, -0.125, 0.125, 0.375])))


def test_a_uniform_transducer_cut_into_strips_is_the_uniform_one():
    """A slant that changes nothing: admittances, circuit, motion in the section, and the sum of the strips' beams."""
    whole = section(PLATE, (SENDER, RECEIVER), "t", (8e-3,))
    cut = beam(replace(SENDER, slant=1e-12, slant_strips=4), RECEIVER)
    assert len(cut.strips) == 4
    assert cut.circuit.admittance == pytest.approx(whole.admittance, rel=1e-10)
    np.testing.assert_allclose(cut.circuit.voltages, whole.circuit.voltages, rtol=1e-9)
    np.testing.assert_allclose(cut.motion(8e-3, 0.3e-3)[[0, 2]], whole.motion(np.array([8e-3]))[:, 0], rtol=1e-9)
    spread, x, y = beam(replace(SENDER, slant=1e-12, slant_strips=4), RECEIVER, spreads=True), (7e-3, 8e-3), (0.0, 3e-3)
    expected = surface_beam(whole)
    np.testing.assert_allclose(spread.motion(x, y), expected.motion(x, y), atol=1e-6 * abs(expected.motion(x, y)).max())
    assert spread.circuit.admittance == pytest.approx(expected.circuit.admittance, rel=1e-8)
    assert cut.power.input == pytest.approx(whole.power.input, rel=1e-9)
    assert cut.power.left == pytest.approx(whole.power.left, rel=1e-8)
    without = aperture_beam(whole, whole.solution).motion(x, y)
    assert abs(without - expected.motion(x, y)).max() > 0.02 * abs(without).max()
    almost = beam(replace(SENDER, overlaps=(1.0 - 1e-12,) * 6), RECEIVER, spreads=True)
    np.testing.assert_allclose(almost.motion(x, y), expected.motion(x, y), atol=1e-6 * abs(expected.motion(x, y)).max())


@pytest.mark.parametrize("other", [{"overlaps": WINDOW}, {"overlaps": (0.4, 0.6, 1.0, 1.0, 0.6, 0.6)}])
def test_straight_fingers_with_the_charges_of_the_section_are_the_strips_about_the_middle_line(other):
    """Two ways to the even part: a section of each strip, and one section with potentials that change along y."""
    found, x, y = beam(replace(SENDER, **other), spreads=True), (7e-3, 8e-3), np.array([0.0, 3e-3])
    (straight,) = found.straightened
    bare = replace(found, straightened=())
    even = (bare.motion(x, y) + bare.motion(x, -y) * np.array([1, -1, 1])[:, None]) / 2
    np.testing.assert_allclose(straight.plane.motion(x, y), even, atol=1e-9 * abs(even).max())
    assert abs(found.motion(x, y) - bare.motion(x, y)).max() > 1e-3 * abs(even).max()
    assert found.charge_error(x, y) == pytest.approx(
        0.15 * abs((found.motion(x, y) - bare.motion(x, y))[2]) / abs(found.motion(x, y)[2])
    )
    assert found.power.residual < 1e-9


def test_half_an_overlap_is_half_a_transducer():
    """Beyond the tips all metal is of one electrode: no waves, no charge; the middle is as if it stood alone."""
    half = beam(replace(SENDER, overlaps=(0.5,) * 6), RECEIVER)
    narrow = section(PLATE, (replace(SENDER, aperture=4e-3), RECEIVER), "t", (8e-3,))
    assert half.circuit.admittance == pytest.approx(narrow.admittance, rel=2e-2)  # loaded by another receiver
    # beside the middle only the receiver sends what its open electrodes make of the wave that it receives
    assert abs(half.motion(8e-3, 3e-3)).max() < 0.02 * abs(half.motion(8e-3, 0.0)).max()
    single = beam(replace(SENDER, overlaps=(0.5,) * 6))
    assert not np.any(single.motion(8e-3, 3e-3))
    alone = section(PLATE, (SENDER,), "t", (8e-3,))
    assert single.circuit.admittance == pytest.approx(alone.admittance / 2, rel=1e-10)
    np.testing.assert_allclose(single.motion(8e-3, 1e-3)[[0, 2]], alone.motion(np.array([8e-3]))[:, 0], rtol=1e-9)


@pytest.mark.parametrize("other", [{"overlaps": (0.4, 0.6, 1.0, 0.6)}, {"slant": 0.2, "slant_strips": 3}])
def test_reciprocity_and_power(other):
    """Of two transducers that are both not uniform, at any load."""
    pair = replace(SENDER, overlaps=WINDOW), replace(RECEIVER, **other, termination=60.0)
    ports = port_admittance(PLATE, pair, frequency=F, tolerance=5e-2)
    assert abs(ports.matrix - ports.matrix.T).max() < 1e-10 * abs(ports.matrix).max()
    found = beam(*pair)
    assert found.power.residual < 1e-9
    assert found.power.loads > 0.0
    volts = found.circuit.voltages
    np.testing.assert_allclose(ports.matrix @ volts, found.circuit.currents, rtol=1e-2)  # another level of accuracy
    assert beam(*pair, drive="r").circuit.names == ("t", "r")


def test_a_slanted_transducer_is_the_mean_over_its_periods():
    ports = port_admittance(PLATE, (replace(SENDER, slant=0.3, slant_strips=3),), frequency=F, tolerance=5e-2)
    each = [
        port_admittance(PLATE, (replace(SENDER, period=1e-3 * (1 + change)),), frequency=F, tolerance=5e-2).matrix
        for change in (-0.1, 0.0, 0.1)
    ]
    assert complex(ports.matrix[0, 0]) == pytest.approx(complex(np.mean(each)), rel=1e-10)


def test_each_strip_of_a_slanted_transducer_sends_the_wave_of_its_period():
    """Without a spread of the waves, beside the middle of each strip; the neighbours differ by a twentieth and more."""
    found = beam(replace(SENDER, slant=0.3, slant_strips=3))
    sent = []
    for strip in found.strips:
        y = (strip.low + strip.high) / 2
        own = section(PLATE, (replace(SENDER, period=1e-3 * (1 + 0.3 * y / SENDER.aperture)),), "t", (8e-3,))
        sent.append(own.motion(np.array([8e-3]))[:, 0])
        np.testing.assert_allclose(found.motion(8e-3, y)[[0, 2]], sent[-1], rtol=1e-9)
    assert np.all(abs(np.diff(sent, axis=0)).max(axis=1) > 0.05 * abs(np.array(sent)).max())


def test_the_default_number_of_strips_resolves_a_slant():
    """`SLANT_STRIPS`: half as many, and twice as many, over 10 periods."""
    row, stator = replace(SENDER, finger_pairs=10, center=7e-3, slant=0.2), PLATE
    found = [
        complex(port_admittance(stator, (replace(row, slant_strips=n),), frequency=F, tolerance=0.1).matrix[0, 0])
        for n in (4, 8, 16)
    ]
    changes = abs(np.diff(found)) / abs(found[-1])
    assert changes[1] < 3e-4
    assert 2.0 < changes[0] / changes[1] < 8.0  # of second order in the width


def test_an_apodised_transducer_sends_the_transform_of_its_taps():
    """Its surface wave, mean over y, over that of the uniform one: sum a_k s_k exp(i k x_k) / sum s_k exp(i k x_k).

    The mean of a finger's potential along y is a_k V_k, and the element factor is common.  ST-X quartz, K2 0.1 %: no
    reflections to speak of; the outermost fingers, with neighbours on one side alone, count 1 to 2 %.
    """
    quartz = rotated(material("quartz"), "ST-X")
    stator = Stator(solid=quartz, length=0.7e-3, thickness=np.inf, ends="absorbing")
    row = Transducer(name="a", center=0.3e-3, finger_pairs=8, period=31.6e-6, metallisation=0.5, aperture=1e-3)
    overlaps = tuple(np.repeat((0.2, 0.2, 0.6, 1.0, 1.0, 0.6, 0.2, 0.2), 2).tolist())
    x = 0.65e-3
    for f in (0.93e8, 1.0e8, 1.07e8):

        def of_quartz(stator, transducers, drive, places, f=f):
            return driven_wave(stator, transducers, frequency=f, drive=drive, tolerance=0.2, places=places)

        own = replace(row, overlaps=overlaps)
        found = strip_beam(stator, (own,), frequency=f, drive="a", solve=of_quartz, places=(x,), spreads=False)
        pairs = zip(found.strips, found.waves, strict=True)
        sent = sum((strip.high - strip.low) / 1e-3 * wave.rayleigh_motion(x)[1] for strip, wave in pairs)
        uniform = of_quartz(stator, (row,), "a", (x,)).rayleigh_motion(x)[1]
        k = 2 * np.pi * f / found.wave.phase_velocity
        taps = np.tile([1, -1], 8) * np.exp(1j * k * (row.fingers.mean(axis=1) - row.center))
        assert sent / uniform == pytest.approx(taps @ np.array(overlaps) / taps.sum(), rel=0.025), f


def received(found, row, side):
    """Charge times potential over a transducer that the beam meets: its static charges at 1 V, and u_z for a potential.

    ``side``: 1 for waves that run to +x.  Factors that all beams have in common are left out.
    """
    k, total = 2 * np.pi * F / found.wave.phase_velocity, 0.0
    nodes, weights = np.polynomial.legendre.leggauss(6)
    for strip in strips_of((row,)):
        (own,) = strip.transducers
        fingers, half = own.fingers, (strip.high - strip.low) / 2
        charges = static_charges(fingers - own.center, [0.5 if sign == "+" else -0.5 for sign in own.signs])
        parts = [
            charge_transform([each - each.mean()], charge[None], -side * k)
            for each, charge in zip(fingers, charges, strict=True)
        ]
        y = (strip.low + strip.high) / 2 + half * nodes
        x, y = np.broadcast_arrays(fingers.mean(axis=1)[:, None], y)
        total = total + half * np.sum(np.array(parts)[:, None] * found.motion(x, y)[2] * weights)
    return total


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({"overlaps": WINDOW}, {"slant": 0.15, "slant_strips": 4}),
        ({"slant": 0.3, "slant_strips": 6}, {"overlaps": (0.4, 0.6, 1.0, 0.6)}),
        ({"slant": 0.3, "slant_strips": 6}, {"slant": -0.2, "slant_strips": 4}),
    ],
)
def test_reciprocity_under_spreading_beams(one, other):
    """What each receives of the other's spreading surface wave is equal: charges by an own electrostatic solution.

    Coupling of a tenth, so that static charges send and receive.  Apertures of 3 and a way of 10 wavelengths: plane
    sections of the strips give another amplitude.  Without the charges at the ends and tips of fingers, which are not
    in `received`.
    """
    solid = material("PZT-8")
    stator = Stator(
        solid=replace(solid, coupling=0.1 * solid.coupling), length=20e-3, thickness=1.5e-3, ends="absorbing"
    )
    rows = [
        replace(SENDER, center=5e-3, aperture=3e-3, **one), replace(RECEIVER, center=15e-3, aperture=3e-3, **other),
    ]  # fmt: skip

    def of(row, spreads):
        return strip_beam(stator, (row,), frequency=F, drive=row.name, solve=solve, places=(10e-3,), spreads=spreads)

    sent = [replace(of(row, True).surface_mode, straightened=()) for row in rows]
    there, back = received(sent[0], rows[1], 1.0), received(sent[1], rows[0], -1.0)
    assert there == pytest.approx(back, rel=0.015)
    assert abs(received(of(rows[0], False), rows[1], 1.0) / there - 1) > 0.15


def test_what_strips_do_not_take_is_refused():
    apodised = replace(SENDER, overlaps=WINDOW)
    one_section = "must be uniform along y in one section"
    with pytest.raises(InputError, match=one_section):
        driven_wave(PLATE, (apodised,), frequency=F, drive="t", tolerance=0.1)
    with pytest.raises(InputError, match=one_section):
        p_matrix(PLATE, replace(SENDER, slant=0.1), frequency=F, tolerance=0.1)
    with pytest.raises(InputError, match="equal fingers"):
        frequency_band(PLATE, (apodised,), lowest=2.1e6, highest=2.3e6, drive="t", tolerance=0.1)
    with pytest.raises(InputError, match="uniform along y with finite apertures"):
        port_admittance(PLATE, (apodised,), frequency=F, tolerance=0.1, finite_apertures=True)
    with pytest.raises(InputError, match="must lie along x on the middle line"):
        strips_of((apodised, replace(RECEIVER, angle=0.3)))
    many = replace(SENDER, finger_pairs=MAX_STRIPS, overlaps=tuple(np.linspace(0, 1, 2 * MAX_STRIPS)))
    with pytest.raises(InputError, match="strips of different fingers"):
        strips_of((many,))
    with pytest.raises(BeamError, match="free"):
        beam(apodised, spreads=True, stator=replace(PLATE, ends="free"))
    with pytest.raises(InputError, match="overlaps must be 6 numbers from 0 to 1"):
        replace(SENDER, overlaps=(0.5, 1.0))
    with pytest.raises(InputError, match="overlaps must be 6 numbers from 0 to 1"):
        replace(SENDER, overlaps=(0.5, 1.0, 1.2, 1.0, 1.0, 1.0))
