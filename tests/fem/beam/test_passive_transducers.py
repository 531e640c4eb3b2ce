"""Spectra of charges, open reflectors, short apertures, clipped gaps, bands, images, places off the axis."""

from dataclasses import replace
from unittest.mock import MagicMock

import numpy as np
import pytest

from fem.beam.beam_of_charges import Emitter
from fem.beam.beam_of_section import aperture_beam, surface_beam
from fem.beam.crossed_beam import interpolated_on_grid
from fem.beam.electrode_charges import ElectrodeCharges, electrode_charges
from fem.beam.lateral import PLANE
from fem.beam.line_source import Branch
from fem.beam.reception import aperture_solver
from fem.condense.transducer import finger_ports
from fem.discretize.element_sizes import Resolution
from fem.discretize.mesh_refinement import LEVELS, refine
from fem.exceptions import ActivePortError, ConvergenceError, InputError
from fem.solve.band_solution import Band, frequency_band
from fem.solve.port_admittance import port_admittance
from fem.waveguide.port_fields import check_passive, stator_cascade
from tests.fem.beam.test_crossed_beam import LEFT, crossed, turned
from tests.fem.stators import FREQUENCY, comb, cut, plate, solution, wave_of

STATOR = plate(cut("PZT-8", "Z", quality=60.0), length=24.0, thickness=1.3)


def test_lumps_keep_charge_dipole_and_spread_of_any_finger():
    """Also of one without charge, an open strip, and of complex charges."""
    rng = np.random.default_rng(2)
    x = np.sort(rng.uniform(0.0, 3e-4, 7))
    charge = rng.normal(size=(2, 7)) + 1j * rng.normal(size=(2, 7))
    charge[1] -= charge[1].mean()
    both = ElectrodeCharges(x=np.append(x, x + 1e-3), charge=charge.ravel(), finger=np.repeat([3, 5], 7))
    places, lumps = both.sheets(1e-3, 0.0)[0].fingers.lumps
    assert places.min() > -1e-3
    assert places.max() < 2e-3
    for power in range(3):
        for near in (places < 6e-4, places > 6e-4):
            mine = both.x < 6e-4 if near[0] else both.x > 6e-4
            expected = np.sum(both.charge[mine] * both.x[mine] ** power)
            np.testing.assert_allclose(np.sum(lumps[near] * places[near] ** power), expected, rtol=1e-9, atol=1e-14)


def test_an_open_reflector_in_the_beam():
    """Behind it and before it, far from the ends of fingers 400 wavelengths long: what the section has."""
    pair = (
        comb(STATOR, "a", 6.0, finger_pairs=2, aperture=0.4),
        comb(STATOR, "r", 14.0, finger_pairs=3, pattern="oooooo", aperture=0.4),
    )
    beam = surface_beam(wave_of(solution(STATOR, pair, order=6)))
    assert abs(beam.charges[1].charge).max() > 0
    x = np.array([pair[1].extent[0] - 1.3e-3, pair[1].extent[1] + 2.1e-3])
    section, without = beam.wave.motion(x), wave_of(solution(STATOR, pair[:1], order=6)).motion(x)
    assert abs(section[1] - without[1])[1] > 0.05 * abs(section[1][1])
    assert abs(beam.motion(x)[2] / section[1] - 1).max() < 0.02


def test_an_aperture_below_half_a_wavelength_is_refused():
    short = comb(STATOR, "a", 6.0, finger_pairs=2, aperture=0.45e-3)
    wave = wave_of(solution(STATOR, (short,)))
    with pytest.raises(InputError, match=r"transducer 'a'.aperture must be at least half a wavelength, 0.000"):
        surface_beam(wave)
    with pytest.raises(InputError, match="half a wavelength"):
        port_admittance(STATOR, (short,), frequency=FREQUENCY, tolerance=0.1, finite_apertures=True)


def test_a_passive_transducer_never_gives_out_power():
    """Two ports of positive conductances whose product of mutual ones is larger: a source, named by its port."""
    passive = np.array([[2.0, 1.0], [1.0, 1.0]]) * 1e-4 + 5e-4j * np.eye(2)
    check_passive(passive, ["a", "b"], 1e6)
    check_passive(np.zeros((0, 0)), [], 1e6)
    with pytest.raises(ActivePortError, match=r"transducer 'b' would give out power at 1.5 MHz"):
        check_passive(passive + np.array([[0.0, 1e-4], [1e-4, 0.0]]), ["a", "b"], 1.5e6)


def test_a_coarse_mesh_with_a_negative_conductance_is_refined():
    """Near the zero of three finger pairs the first mesh gives -2 % of |Y|, which is within its error of 15 %."""
    block = replace(plate(cut("PZT-8", "Z"), length=14.0, thickness=2.0), length=14e-3, thickness=2e-3)
    row = (comb(block, "left", 4.0, finger_pairs=3, aperture=0.02),)
    row = (replace(row[0], center=4e-3, period=0.98e-3),)
    with pytest.raises(ActivePortError):
        aperture_solver(block)(stator_cascade(block, row, frequency=1.606e6, resolution=LEVELS[0]))
    ports = [
        port_admittance(block, row, frequency=1.606e6, tolerance=tolerance, finite_apertures=True)
        for tolerance in (0.3, 1e-3)
    ]
    coarse, fine = (each.matrix[0, 0] for each in ports)
    assert fine.real > 0.02 * abs(fine)
    assert abs(coarse - fine) < ports[0].relative_error * abs(fine) < 1e-2 * abs(fine)


@pytest.mark.parametrize("passive_from", [0, 2, 4, 9])
def test_an_active_port_is_refused_only_where_no_mesh_is_passive(passive_from):
    """Two meshes must be passive, since their difference is the error; an active one at every mesh stays refused."""
    solved = []

    def at_level(level: int) -> float:
        solved.append(level)
        if level < passive_from:
            raise ActivePortError("a source")
        return 1.0 + 10.0**-level

    def answer():
        differences = {"differences": lambda fine, coarse: (abs(fine - coarse),), "gain": 8.0, "tolerance": 1e-9}
        return refine(at_level, range(5), start=0, **differences)

    if passive_from < 4:
        assert answer().level == 4
    else:
        with pytest.raises(ActivePortError):
            answer()
    assert solved == list(range(4 if passive_from >= 4 else 5))


def pair_of(gap: float):
    """Two unequal transducers whose fingers are a gap apart, in gaps of the first."""
    one = comb(STATOR, "a", 8.0, finger_pairs=2, aperture=4e-3)
    other = comb(STATOR, "b", 0.0, finger_pairs=1, period=0.9, metallisation=0.4, aperture=2.5e-3)
    width = other.extent[1] - other.extent[0]
    return one, replace(other, center=one.extent[1] + gap * 2 * one.half_gap + width / 2)


@pytest.mark.parametrize("finite", [False, True])
def test_clipped_gaps_are_reciprocal(finite):
    pair = pair_of(0.6)
    row = stator_cascade(STATOR, pair, frequency=FREQUENCY, resolution=Resolution(order=5, edge_layers=1))
    found = (aperture_solver(STATOR)(row) if finite else row.solved()).admittances
    assert found[0, 1] == pytest.approx(found[1, 0], rel=1e-9)
    assert abs(found[0, 1]) > 0.03 * abs(found[1, 1])


def test_finite_apertures_in_a_band_are_those_at_one_frequency():
    """Unequal numbers of fingers, without mirror symmetry: the sign of a mirrored half cell's dipole."""
    row = (comb(STATOR, "a", 8.0, finger_pairs=2, pattern="+-+o", aperture=3e-3),)
    limits = {"lowest": 0.98 * FREQUENCY, "highest": 1.02 * FREQUENCY}
    band = frequency_band(STATOR, row, **limits, drive="a", tolerance=1e-4)
    solve, at = aperture_solver(STATOR), 1.006 * FREQUENCY
    full = stator_cascade(STATOR, row, frequency=at, resolution=band.model.resolution)
    one, plain = solve(full).admittances, full.solved().admittances
    found = band.admittances(np.array([at]), solve)[0]
    assert abs(plain / one - 1).max() > 3e-3
    assert abs(found / one - 1).max() < 1e-4


def test_a_band_falls_back_where_the_reduced_model_fails(monkeypatch):
    row = (comb(STATOR, "a", 8.0, finger_pairs=2, aperture=3e-3),)
    limits = {"lowest": 0.99 * FREQUENCY, "highest": 1.01 * FREQUENCY}
    band = frequency_band(STATOR, row, **limits, drive="a", tolerance=1e-2)

    class Failing:
        def __init__(self, model):
            self.stator, self.transducers, self.resolution = model.stator, model.transducers, model.resolution
            self.limits = model.limits

        def cascade(self, frequency, forces=()):
            raise ConvergenceError("too few lines")

    again = Band(model=Failing(band.model), relative_error=1e-2, admittance_error=1e-2)
    x = np.array([4e-3, 12e-3])
    np.testing.assert_allclose(again.wave(FREQUENCY, "a").motion(x), band.wave(FREQUENCY, "a").motion(x), rtol=1e-2)


def test_images_in_both_side_faces():
    """Mirrors at +-width/2 repeat the field of the same charges at width - y, -width - y and so on."""
    lossy = plate(cut("PZT-8", "Z", quality=15.0), length=24.0, thickness=1.3)
    one = comb(lossy, "a", 6.0, finger_pairs=2, aperture=3e-3)
    wave, width = wave_of(solution(lossy, (one,), order=5)), 7e-3
    alone, between = (aperture_beam(wave, wave.solution, each) for each in (None, width))
    x, y = one.extent[1] + 6e-3, np.array([0.9e-3, -2.2e-3])
    total = alone.motion(x, y).copy()
    for number in range(1, 9):
        for side in (1, -1):
            image = side * number * width + (-1) ** number * y
            total += alone.motion(x, image) * np.array([1, (-1) ** number, 1])[:, None]
    found = between.motion(x, y)
    assert abs(found - total)[[1, 2]].max() < 2e-3 * abs(total).max()
    assert abs(total[2] / alone.motion(x, y)[2] - 1).min() > 0.01


def test_many_places_near_turned_fingers():
    """More than are evaluated one by one, on both sides of the fingers and under them."""
    found = crossed(turned(LEFT, 0.3))
    rng = np.random.default_rng(4)
    x, y = rng.uniform(2e-3, 0.03, 1500), rng.uniform(-0.015, 0.013, 1500)
    few = slice(None, 400)
    expected = found.motion(x[few], y[few])
    s, t = found.rows[0].local(x[few], y[few])
    own = found.rows[0].transducers[0]
    near = (s > own.extent[0] - 1e-3) & (s < own.extent[1] + 1e-3) & (abs(t - own.center_y) < 2e-3)
    assert near.sum() > 5
    assert abs(found.motion(x, y)[:, few] - expected).max() < 1e-4 * abs(expected).max()
    assert interpolated_on_grid(lambda s, t: np.array([s * t]), s, t, 2e-4)[0] == pytest.approx(s * t, abs=1e-10)


def test_the_stated_error_in_an_interference_minimum(monkeypatch):
    """Relative to the small amplitude there, not to the largest one on the line."""
    from fem.beam import lateral

    beam = surface_beam(
        replace(
            wave_of(solution(STATOR, (comb(STATOR, "a", 6.0, finger_pairs=2, aperture=6e-3),), order=5)),
            relative_error=0.0,
        )
    )
    monkeypatch.setattr(lateral, "SPACING", 1.1)  # coarse, so that the integral's error decides
    monkeypatch.setattr("fem.beam.beam_of_charges.MAX_HALVINGS", 0)
    x, y = 12e-3, np.linspace(0.0, 9e-3, 181)
    motion, stated = beam.motion_and_error(x, y)
    size = abs(motion[[0, 2]]).max(axis=0)
    least = int(np.argmin(size))
    monkeypatch.undo()
    true = abs(beam.motion(x, y) - motion).max(axis=0)
    assert size[least] < 0.1 * size.max()
    assert true[least] < 2 * stated[least] * size[least]
    assert stated[least] > 3 * stated[int(np.argmax(size))]


@pytest.mark.parametrize("pattern", ["+-+-+-", "oo+-oo"])
def test_nodal_charges_have_the_totals_and_moments_of_each_finger(pattern):
    """On every sheet, those that the coupled system gave to the finger as a whole."""
    row = (
        comb(STATOR, "a", 6.0, finger_pairs=2, aperture=6e-3),
        comb(STATOR, "b", 14.0, finger_pairs=3, pattern=pattern, aperture=5e-3),
    )
    wave = wave_of(solution(STATOR, row, order=6))
    found = surface_beam(wave).solution
    section = found.fields.section
    unit = -section.solid.stress_unit / section.solid.potential_unit
    for number, (transducer, sheets) in enumerate(zip(row, found.fields.sheets, strict=True)):
        charges = electrode_charges(found, number)
        plain = wave.solution.fields.network.scatterers[number].piece
        fingers, dipoles = finger_ports(plain, transducer.signs.replace("0", ""))
        assert len(sheets) > 1
        for sheet, charge in zip(sheets, (charges.charge, *(q for _, q in charges.steps)), strict=True):
            charged = np.flatnonzero([sign in "+-" for sign in transducer.signs])
            for finger in np.delete(np.unique(charges.finger), charged):  # open strips: polarised, without net charge
                own = charge[charges.finger == finger]
                assert abs(own.sum()) < 1e-9 * abs(own).sum()
            for finger, total, moment in zip(
                np.unique(charges.finger)[charged],
                unit * (fingers.matrix[-len(charged) :] @ sheet.sides @ found.circuit.voltages),
                unit * section.length_unit * ((dipoles @ sheet.sides + sheet.dipoles) @ found.circuit.voltages),
                strict=True,
            ):
                own = charges.finger == finger
                arms = charges.x[own] - (charges.x[own][0] + charges.x[own][-1]) / 2
                scale = abs(charge).max()
                np.testing.assert_allclose(charge[own].sum(), total, rtol=1e-9, atol=1e-9 * scale)
                np.testing.assert_allclose(charge[own] @ arms, moment, rtol=1e-7, atol=1e-9 * scale * arms[-1])


def test_spectra_are_the_sum_over_charges_and_modes_whatever_their_length():
    """Beyond the charges and between them, with modes longer and much shorter than a finger."""
    rng = np.random.default_rng(3)
    x = np.sort(np.concatenate([start + rng.uniform(0.0, 2e-4, 5) for start in (0.0, 5e-4, 1e-3)]))
    charge = rng.normal(size=(2, 15)) + 1j * rng.normal(size=(2, 15))
    both = ElectrodeCharges(x=x, charge=charge[0], finger=np.repeat([0, 1, 2], 5), steps=((1e-3, charge[1]),))
    emitter = Emitter(MagicMock(), both.sheets(2e-3, 0.0))
    along = np.multiply.outer([3e3, 8e3, 9e4], [1.0, 0.8]) * (1 - 0.01j)
    motion, shapes = rng.normal(size=(3, 3, 2)), rng.normal(size=(2, 2))
    positions = np.array([3e-4, 5e-4 + 1e-4, 2e-3])
    for side in (1, -1):
        expected = np.zeros((3, 3, 2), dtype=complex)
        for number, place in enumerate(positions):
            upstream = side * x < side * place
            waves = np.exp(-1j * np.multiply.outer(along, abs(place - x[upstream])))  # (modes, n, charges)
            sent = np.einsum("mnj,sj,sn->mn", waves, charge[:, upstream], shapes)
            expected[number] = np.einsum("cmn,mn->cn", motion, sent)
        found = emitter.spectra(Branch(side, PLANE, along, motion, ()), positions, shapes)
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)
