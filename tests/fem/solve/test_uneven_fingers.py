"""Chirped transducers and cells of unidirectional ones: fingers, and what they radiate.

Truths: drawn geometry; the plain solver `tests/fem/direct.py` on a mesh of its own; reciprocity, power and time
reversal; the impulse response of a weakly coupled cut, as delta functions and from static charges; coupled modes for
the directivity.
"""

from dataclasses import replace

import numpy as np
import pytest

from fem import InputError, Stator, Transducer, frequency_band, material, rayleigh, rotated, surface_beam, surface_named
from fem.beam.beam_of_section import aperture_beam
from fem.discretize.element_sizes import Resolution
from fem.discretize.mesh_refinement import LEVELS
from fem.materials.christoffel import slowest_wavelength
from fem.solve.driven_stator import driven_wave, solve_driven
from fem.solve.p_matrix_from_field import p_matrix_on_level
from tests.fem.direct import direct_solution
from tests.oracles.fem_static_strips import charge_transform, static_charges

ROW = Transducer(name="t", center=0.0, finger_pairs=3, period=1e-3, metallisation=0.5, aperture=20e-3)
KINDS = [
    {"chirp": 0.3}, {"chirp": -0.2, "split": True}, {"cell": "DART"}, {"cell": "EWC", "mirrored": True},
    {"cell": "DART", "chirp": 0.2, "metallisation": 0.4, "pattern": "-+-" "-0-" "-+-"},
]  # fmt: skip


def plate(quality=np.inf, loss=0.0):
    solid = replace(rotated(material("PZT-8"), "Z"), mechanical_quality=quality, dielectric_loss=loss)
    return Stator(solid=solid, length=12e-3, thickness=0.6e-3, bottom="free", ends="absorbing")


def lone(stator, row, frequency, every_mode=True, level=0):
    length = (row.finger_pairs + 2) * row.period
    alone, own = replace(stator, length=length, ends="absorbing"), replace(row, center=length / 2)
    return p_matrix_on_level(alone, own, frequency, LEVELS[level], every_mode=every_mode)


def test_a_dart_cell_is_eighths_of_its_period():
    """Fingers of 1, 1 and 3 eighths with gaps of one; the same from the right if mirrored."""
    eighths = np.array([[0.5, 1.5], [2.5, 3.5], [4.5, 7.5]])
    drawn = replace(ROW, cell="DART", finger_pairs=2)
    expected = np.concatenate([eighths, eighths + 8]) / 8 * 1e-3 - 1e-3
    np.testing.assert_allclose(drawn.fingers, expected, atol=1e-15)
    np.testing.assert_allclose(replace(drawn, mirrored=True).fingers, -expected[::-1, ::-1], atol=1e-15)
    assert (drawn.signs, replace(drawn, mirrored=True).signs) == ("-+--+-", "-+--+-")
    assert drawn.finger_width == pytest.approx(1e-3 / 8)
    assert drawn.half_gap == pytest.approx(1e-3 / 16)
    # every edge moves alike: a finger and the wide one grow by the same length
    grown = replace(drawn, metallisation=0.6).fingers - drawn.fingers
    np.testing.assert_allclose(grown, np.tile([-1, 1], (6, 1)) * 0.1 / 8 * 1e-3, atol=1e-15)
    wide = replace(drawn, cell="EWC").fingers
    np.testing.assert_allclose(np.ptp(wide, axis=1)[:3] * 1e3, [1 / 8, 1 / 8, 1 / 4], atol=1e-12)
    middles = wide.mean(axis=1)
    assert middles[2] - middles[1] == pytest.approx(3e-3 / 8)  # from the sources to the reflections


def test_a_chirp_changes_the_period_linearly_and_keeps_the_length():
    even, chirped = replace(ROW, finger_pairs=40), replace(ROW, finger_pairs=40, chirp=0.2)
    middles = chirped.fingers.mean(axis=1)
    spacing = np.diff(middles)
    np.testing.assert_allclose(spacing, np.linspace(spacing[0], spacing[-1], len(spacing)), rtol=1e-9)
    assert spacing[0] == pytest.approx(0.5e-3 * 0.9, rel=5e-3)
    assert spacing[-1] == pytest.approx(0.5e-3 * 1.1, rel=5e-3)
    assert np.ptp(chirped.extent) == pytest.approx(np.ptp(even.extent), rel=2e-3)
    widths = np.ptp(chirped.fingers, axis=1)
    np.testing.assert_allclose(widths[1:-1], 0.25 * (spacing[1:] + spacing[:-1]), rtol=1e-3)  # metallised by a half
    np.testing.assert_allclose(replace(ROW, chirp=1e-12).fingers, ROW.fingers, atol=1e-14)


def test_a_vanishing_chirp_is_the_even_transducer():
    """The same numbers on two ways through the code, at the rounding of a finger's shape."""
    stator = plate()
    even, chirped = (lone(stator, replace(ROW, chirp=chirp), 2.2e6) for chirp in (0.0, 1e-13))
    assert chirped.admittance == pytest.approx(even.admittance, rel=1e-7)
    np.testing.assert_allclose(chirped.excitation, even.excitation, atol=1e-7 * abs(even.excitation).max())


@pytest.mark.parametrize("ends", ["absorbing", "free"])
def test_a_vanishing_chirp_has_the_beam_of_the_even_transducer(ends):
    """At 1e-12, and to first order in the chirp at 1e-4; a chirp of 0.2 changes u_z by a tenth and more."""
    stator, x, y = replace(plate(quality=60.0), ends=ends), np.array([7e-3, 9e-3]), np.array([0.0, 2e-3])

    def beam(chirp):
        row = replace(ROW, center=3e-3, aperture=6e-3, chirp=chirp)
        return surface_beam(driven_wave(stator, (row,), frequency=2.2e6, drive="t", tolerance=0.3)).motion(x, y)

    even, less, more = beam(0.0), beam(-1e-4), beam(1e-4)
    scale = abs(even).max()
    assert abs(beam(1e-12) - even).max() < 1e-8 * scale
    assert abs(more - even).max() < 1e-3 * scale
    assert abs(less + more - 2 * even).max() < 1e-2 * abs(more - even).max()
    assert abs(beam(0.2) - even).max() > 0.1 * scale


@pytest.mark.parametrize("kind", [{"chirp": 0.3}, {"cell": "DART"}, {"cell": "EWC", "mirrored": True}])
def test_the_mean_of_the_beam_between_mirrors_is_the_wave_of_the_section(kind):
    """The part at k_y = 0 of waves that the section's charges send: aperture over distance of the mirrors times it."""
    stator = replace(plate(quality=60.0), length=16e-3)
    row = replace(ROW, center=4e-3, aperture=6e-3, **kind)
    wave = driven_wave(stator, (row,), frequency=2.2e6, drive="t", tolerance=0.3)
    x, y = np.array([8e-3, 9e-3, 13e-3]), (np.arange(64) / 64 - 0.5) * 10e-3
    mean = aperture_beam(wave, wave.solution, mirror_width=10e-3).motion(x[:, None], y).mean(axis=2)
    sent = 0.6 * wave.motion(x)
    assert abs(mean[[0, 2]] - sent).max() < 1e-8 * abs(sent).max()
    plain = driven_wave(stator, (replace(ROW, center=4e-3),), frequency=2.2e6, drive="t", tolerance=0.3)
    assert abs(wave.motion(x) - plain.motion(x)).max() > 0.1 * abs(sent).max()


@pytest.mark.parametrize("kind", KINDS)
def test_the_stator_is_that_of_a_plain_solver(kind):
    """All columns in one sparse system of scikit-fem, on a mesh of other columns."""
    stator = replace(plate(quality=60.0, loss=0.01), length=4e-3, ends="free")
    row = replace(ROW, center=1.8e-3, finger_pairs=3 if "pattern" in kind else 1, **kind)
    resolution, unit = Resolution(order=5, edge_layers=2), slowest_wavelength(stator.solid, 2.2e6)
    ours = solve_driven(stator, (row,), frequency=2.2e6, drive="t", resolution=resolution)
    plain = direct_solution(stator, (row,), frequency=2.2e6, resolution=resolution, wavelength=unit)
    assert ours.circuit.admittance == pytest.approx(complex(plain.admittances[0, 0]), rel=2e-4)
    even = solve_driven(
        stator,
        (replace(row, cell="plain", mirrored=False, chirp=0.0, pattern=None),),
        frequency=2.2e6,
        drive="t",
        resolution=resolution,
    )
    assert abs(ours.circuit.admittance / even.circuit.admittance - 1) > 5e-3


@pytest.mark.parametrize("kind", KINDS)
def test_reciprocity_power_and_time_reversal(kind):
    """S = S^T; d = -2 p; |p|^2 = Re Y; S p* = -p of a lossless one: the waves that it sends, played backwards."""
    found = lone(plate(), replace(ROW, **kind), 2.2e6)
    p, s, scale = found.excitation, found.scattering, abs(found.excitation).max()
    assert abs(s - s.T).max() < 1e-10
    assert abs(found.detection + 2 * p).max() < 1e-10 * scale
    assert np.sum(abs(p) ** 2) == pytest.approx(found.admittance.real, rel=1e-9)
    assert abs(s @ p.conj() + p).max() < 1e-9 * scale


def test_a_mirror_image_sends_to_the_other_side():
    stator, modes = plate(), 2
    for kind in ({"cell": "DART"}, {"chirp": 0.3}):
        own = lone(stator, replace(ROW, **kind), 2.2e6)
        other = {"mirrored": True} if "cell" in kind else {"chirp": -0.3, "pattern": "-+" * 3}
        image = lone(stator, replace(ROW, **kind | other), 2.2e6)
        assert image.admittance == pytest.approx(own.admittance, rel=1e-8)
        size = abs(own.excitation)
        modes = len(size) // 2
        np.testing.assert_allclose(abs(image.excitation), np.roll(size, modes), rtol=1e-7)
        assert abs(size[0] / size[modes] - 1) > 1e-3  # it is no symmetric one


def test_a_chirp_in_a_weakly_coupled_cut_is_a_sum_of_delta_functions():
    """|sum V_k rho(k p_k) exp(i k x_k)| over the band, rho of fingers in a row of the local pitch (m = 1/2).

    The outermost fingers have no neighbours on one side: 4 % of 12 fingers, 3 % of 24.

    Engan, IEEE Trans. Sonics Ultrason. 22 (1975) 395: rho ~ sin(pi s) P_n(cos pi m) / P_-s(-cos pi m).
    """
    from scipy.special import eval_legendre

    quartz = replace(rotated(material("quartz"), "ST-X"), mechanical_quality=np.inf, dielectric_loss=0.0)
    stator = Stator(solid=quartz, length=1.0, thickness=np.inf, ends="absorbing")
    row = Transducer(name="t", center=0.5, finger_pairs=6, period=31.6e-6, metallisation=0.5, aperture=1e-3, chirp=0.4)
    at = np.linspace(0.75, 1.25, 7) * 1e8
    found = [lone(stator, row, float(f), every_mode=False) for f in at]
    measured = np.array([np.sqrt(np.prod(abs(each.excitation)) / f) for each, f in zip(found, at, strict=True)])
    velocity = 2 * np.pi * at[0] / found[0].wavenumbers[0].real
    x, signs = row.fingers.mean(axis=1) - row.center, np.tile([0.5, -0.5], 6)
    pitch = np.gradient(x)

    def model(f):
        k = 2 * np.pi * f / velocity
        s = k * pitch / (2 * np.pi)
        rho = np.sin(np.pi * s) / eval_legendre(-s, 0.0)  # order 0 and cos pi m = 0
        return abs(np.sum(signs * rho * np.exp(1j * k * x)))

    expected = np.array([model(f) for f in at])
    measured, expected = measured / np.linalg.norm(measured), expected / np.linalg.norm(expected)
    np.testing.assert_allclose(measured, expected, atol=0.05 * expected.max())
    unchirped = abs(np.sinc(6 * (at / (velocity / 31.6e-6) - 1)))
    assert abs(measured - unchirped / np.linalg.norm(unchirped)).max() > 0.2 * measured.max()


@pytest.mark.parametrize(("cell", "other"), [("DART", "EWC"), ("EWC", "DART")])
def test_cells_in_a_weakly_coupled_cut_send_the_waves_of_their_static_charges(cell, other):
    """|p|^2 = omega W (dv/v) eps |q(k)|^2 / 2 to each side, q the transform of the charges over eps at 1 V.

    The impulse-response limit, without reflections: Datta, Surface Acoustic Wave Devices (1986), ch. 4; Morgan, Surface
    Acoustic Wave Filters (2007), eq. (5.44).  Charges of the drawn fingers by an own electrostatic solution.
    """
    quartz = replace(rotated(material("quartz"), "ST-X"), mechanical_quality=np.inf, dielectric_loss=0.0)
    stator = Stator(solid=quartz, length=1.0, thickness=np.inf, ends="absorbing")
    row = Transducer(name="t", center=0.5, finger_pairs=4, period=31.6e-6, metallisation=0.5, aperture=1e-3, cell=cell)
    at = np.array([0.85, 0.95, 1.05, 1.25]) * 1e8
    found = [lone(stator, row, float(f), every_mode=False, level=1) for f in at]
    sent = np.array([abs(each.excitation) for each in found])
    np.testing.assert_allclose(sent[:, 0], sent[:, 1], atol=0.01 * sent.max())
    bare, metallised = (rayleigh(quartz, surface_named(name)).velocity for name in ("open", "metallised"))
    permittivity = np.sqrt(quartz.permittivity[0, 0] * quartz.permittivity[2, 2] - quartz.permittivity[0, 2] ** 2)

    def of_charges(drawn):
        fingers = drawn.fingers - drawn.center
        charges = static_charges(fingers, [0.5 if sign == "+" else -0.5 for sign in drawn.signs])
        q = np.array([abs(charge_transform(fingers, charges, 2 * np.pi * f / bare)) for f in at])
        return np.sqrt(np.pi * at * row.aperture * (1 - metallised / bare) * permittivity) * q

    ratio = sent.mean(axis=1) / of_charges(row)
    # 1.25e8 Hz lies near a zero, 35 dB down: reflections count there, and the other cell sends another amplitude
    assert np.all(abs(ratio - 1) < [0.02, 0.02, 0.02, 0.1]), ratio
    assert abs(sent.mean(axis=1) / of_charges(replace(row, cell=other)) - 1).max() > 0.2


@pytest.mark.parametrize("cell", ["DART", "EWC"])
def test_the_directivity_is_that_of_coupled_modes(cell):
    """At the centre of the stop band of a row in best phase |p_1 / p_2| = exp(kappa L) with |S_11| = tanh(kappa L).

    Hartmann, Wright, Kansy and Garber, Proc. IEEE Ultrasonics Symp. 1982, 40 (natural directivity by coupled modes).
    Massless electrodes on 128YX: the reflections are electrical alone, and weak.
    """
    solid = replace(rotated(material("LiNbO3"), "128YX"), mechanical_quality=np.inf, dielectric_loss=0.0)
    stator = Stator(solid=solid, length=1.0, thickness=np.inf, ends="absorbing", above="vacuum")
    row = Transducer(name="t", center=0.5, finger_pairs=12, period=40e-6, metallisation=0.5, aperture=1e-3, cell=cell)
    best = None
    for f in np.linspace(94.4e6, 97.4e6, 6):
        found = lone(stator, row, float(f), every_mode=False)
        if best is None or abs(found.scattering[0, 0]) > abs(best.scattering[0, 0]):
            best = found
    ratio = np.log(abs(best.excitation[0] / best.excitation[1]))
    kappa_length = np.arctanh(abs(best.scattering[0, 0]))
    assert kappa_length > 0.04
    assert abs(ratio) == pytest.approx(kappa_length, rel=0.1)


def test_what_uneven_fingers_do_not_take_is_refused():
    stator = replace(plate(quality=60.0), length=10e-3)
    row = replace(ROW, center=3e-3, chirp=0.1)
    with pytest.raises(InputError, match="equal fingers, equally spaced, in a band"):
        frequency_band(stator, (row,), lowest=2.1e6, highest=2.2e6, drive="t", tolerance=0.1)
    for wrong, rule in (
        ({"cell": "DART", "split": True}, "split must be absent with the cell DART"),
        ({"mirrored": True}, "mirrored must be absent with the cell plain"),
        ({"cell": "DART", "pattern": "+-"}, "must have 9 signs, three for each of the 3 finger_pairs"),
        ({"chirp": 1.5}, "chirp must be between -1 and 1"),
        ({"cell": "dart"}, "cell must be"),
    ):
        with pytest.raises(InputError, match=rule):
            replace(ROW, **wrong)
