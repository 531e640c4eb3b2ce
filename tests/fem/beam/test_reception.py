"""Reception of a beam by transducers of finite aperture."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import hankel2

from fem.beam import reception
from fem.beam.beam_of_section import surface_beam
from fem.beam.electrode_charges import electrode_charges
from fem.beam.reception import aperture_coupling, with_apertures
from fem.discretize.element_sizes import Resolution
from fem.solve.port_admittance import port_admittance
from fem.waveguide.port_fields import stator_cascade
from tests.fem.stators import FREQUENCY, comb, cut, plate, solution, wave_of


def test_coupling_of_two_apertures_is_a_double_integral_of_a_hankel_function():
    k, sender, receiver, distance = 6300.0 - 30j, 5e-3, 2e-3, 12e-3
    (y, outer), (other, inner) = (np.polynomial.legendre.leggauss(n) for n in (40, 80))
    lateral = np.subtract.outer(receiver / 2 * y, sender / 2 * other)
    mean = outer / 2 @ (hankel2(0, k * np.hypot(distance, lateral)) @ (inner * sender / 2))
    expected = k / 2 * mean * np.exp(1j * k * distance)
    assert aperture_coupling(np.array([k]), sender, receiver, distance)[0] == pytest.approx(expected, rel=1e-7)
    images = [
        hankel2(0, k * np.hypot(distance, lateral + number * 6e-3)) @ (inner * sender / 2) for number in range(-90, 91)
    ]
    expected = k / 2 * (outer / 2 @ sum(images)) * np.exp(1j * k * distance)
    found = aperture_coupling(np.array([k]), sender, receiver, distance, 6e-3)[0]
    assert found == pytest.approx(expected, rel=1e-6)


def stator_of_three(apertures, centers=(6.0, 20.0, 33.0), pairs=(3, 4, 2)):
    """Apertures in m, centres in wavelengths."""
    stator = plate(cut("PZT-8", "Z", quality=200.0), length=centers[-1] + 7.0, thickness=1.3)
    three = [
        comb(stator, name, at, finger_pairs=count, aperture=aperture)
        for name, at, count, aperture in zip("abc", centers, pairs, apertures, strict=True)
    ]
    return solution(stator, tuple(three))


def test_reciprocity_of_unequal_apertures():
    section = stator_of_three((20e-3, 8e-3, 8e-3)).fields
    found = with_apertures(section).admittances
    np.testing.assert_allclose(found, found.T, atol=1e-9 * abs(found[0, 1]))
    assert abs(found[0, 1] - section.admittances[0, 1]) > 0.01 * abs(found[0, 1])


def test_port_admittances_of_finite_apertures():
    """At one frequency and over a band: those of the beam's own circuit, which the power balance closes."""
    stator = plate(cut("PZT-8", "Z", quality=200.0), length=30.0, thickness=1.3)
    two = tuple(
        comb(stator, name, at, finger_pairs=2, aperture=aperture, termination=600.0)
        for name, at, aperture in (("a", 6.0, 8e-3), ("b", 20.0, 5e-3))
    )
    given = {"tolerance": 1e-2, "finite_apertures": True}
    one = port_admittance(stator, two, frequency=FREQUENCY, **given)
    band = port_admittance(stator, two, frequency=[0.98 * FREQUENCY, FREQUENCY], **given)
    beam = surface_beam(wave_of(solution(stator, two, order=8, layers=3)))
    largest = abs(beam.solution.fields.admittances).max()
    assert abs(one.matrix - beam.solution.fields.admittances).max() < 1e-2 * largest
    assert abs(band.matrix[1] - one.matrix).max() < 1e-2 * largest
    plane = port_admittance(stator, two, frequency=FREQUENCY, tolerance=1e-2)
    assert abs(plane.matrix - one.matrix).max() > 0.05 * abs(one.matrix[0, 1])
    power = beam.power
    assert power.loads > 1e-5 * power.input
    loaded = beam.circuit.voltages[1] * beam.circuit.currents[1].conj()
    assert power.loads == pytest.approx(-0.5 * loaded.real, rel=1e-9)
    assert power.residual < 1e-9
    assert power.solid + power.loads + power.radiated == pytest.approx(power.input, rel=1e-9)


def test_wide_apertures_are_the_section():
    """The middle transducer scatters what passes between the outer ones; the difference falls about as 1 / W."""
    left = []
    for aperture in (0.8, 1.6):
        section = stator_of_three(3 * (aperture,), (3.0, 7.0, 10.0), (1, 2, 1)).fields
        change = abs(with_apertures(section).admittances / section.admittances - 1)
        left.append(change.max())
    assert left[1] < 1e-3
    assert left[1] == pytest.approx(left[0] / 2, rel=0.1)


def test_an_open_transducer_sees_the_mean_of_the_beam():
    """Its voltage, over the section's, is the mean over its aperture of the wave that one driven transducer sends."""
    stator = plate(cut("PZT-8", "Z", quality=60.0), length=30.0, thickness=np.inf)
    driven = comb(stator, "a", 6.0, aperture=5e-3)
    far = comb(stator, "b", 22.0, aperture=3e-3)
    both = surface_beam(wave_of(solution(stator, (driven, far))))
    alone = surface_beam(wave_of(solution(stator, (driven,)))).surface_mode
    alone = replace(alone, charges=(electrode_charges(alone.wave.solution, 0),))  # the section's
    y, weights = np.polynomial.legendre.leggauss(20)
    mean = alone.motion(far.center, 1.5e-3 * y)[2] @ weights / 2
    expected = mean / alone.wave.rayleigh_motion(far.center)[1]
    shares = aperture_coupling(alone.source.wavenumbers, 5e-3, 3e-3, far.center - driven.center)
    assert shares.mean() == pytest.approx(expected, abs=1e-3)
    found = both.circuit.voltages[1] / both.wave.circuit.voltages[1]
    assert found == pytest.approx(expected, abs=0.08)  # bulk waves and own apertures take part
    assert abs(found - 1) > 0.2


def test_a_limit_of_the_waves_leaves_out_those_that_decay_before_steps_of_the_charge(monkeypatch):
    """Half the waves by the limit: the same motion; fewer steps: within the stated error."""
    stator = plate(cut("PZT-8", "Z", quality=200.0), length=40.0, thickness=1.3, bottom="absorbing")
    two = tuple(
        comb(stator, name, at, finger_pairs=2, aperture=4e-3, termination="short")
        for name, at in (("a", 6.0), ("b", 33.0))
    )
    wave, x, found = wave_of(solution(stator, two)), stator.length * np.array([0.3, 0.5, 0.7]), {}
    for most in (3000, 1200, 700):
        monkeypatch.setattr(reception, "MAX_WAVES", most)
        beam = surface_beam(wave)
        u_z = abs(beam.motion(x)[2])
        found[most] = [len(each.steps) for each in beam.charges], u_z, beam.charge_error(x) * u_z
    assert found[3000][0] == found[1200][0] == [6, 6]
    assert found[1200][1] == pytest.approx(found[3000][1], rel=1e-6)
    assert found[700][0] == [4, 4]
    off = abs(found[700][1] - found[3000][1])
    assert off.max() > 0.005 * found[700][1][0]
    assert np.all(off < 1.2 * found[700][2])


@pytest.mark.parametrize("other", [{"finger_pairs": 3}, {"metallisation": 0.7}])
@pytest.mark.parametrize("turned", [False, True])
def test_over_a_band_each_transducer_has_its_own_coupling(other, turned):
    """Transducers of one aperture that differ in one thing, in either order: a band gives what a frequency gives."""
    stator = plate(cut("PZT-8", "Z", quality=100.0), length=24.0, thickness=1.3)
    row = tuple(
        comb(stator, name, at, **({"finger_pairs": 2, "aperture": 6e-3} | given))
        for name, at, given in zip("ab", (6.0, 17.0), ({}, other)[:: -1 if turned else 1], strict=True)
    )
    cascade = stator_cascade(stator, row, frequency=FREQUENCY, resolution=Resolution(order=5, edge_layers=0))
    one = reception.aperture_solver(stator)(cascade).admittances
    band = reception.aperture_solver(stator, limits=(0.98 * FREQUENCY, 1.02 * FREQUENCY))(cascade).admittances
    assert abs(band / one - 1).max() < 1e-6
