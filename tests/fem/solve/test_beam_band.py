"""Bands of beams against full solutions and their beams at frequencies where nothing was fitted or checked."""

from dataclasses import replace

import numpy as np
import pytest

from fem.beam.beam_of_section import surface_beam
from fem.beam.electrode_charges import all_charges
from fem.beam.reception import aperture_solver
from fem.beam.surface_beam import BeamError
from fem.discretize.mesh_refinement import LEVELS
from fem.exceptions import ConvergenceError
from fem.geometry import Stator, Transducer
from fem.materials import material, rotated
from fem.reduce.projection import BandProblem, project, solve_at_nodes
from fem.results.driven_answer import surface_wave
from fem.results.stator_solution import driven_solution
from fem.solve import beam_band as beam_band_module
from fem.solve.band_solution import frequency_band
from fem.solve.beam_band import beam_band, beam_differences
from fem.solve.driven_stator import solve_driven
from tests.fem.stators import FREQUENCY, comb, cut, plate

STATOR = plate(cut("PZT-8", "Z", quality=60.0), length=24.0, thickness=1.3)
ROW = (
    comb(STATOR, "a", 5.0, finger_pairs=2, aperture=4e-3),
    comb(STATOR, "b", 20.0, finger_pairs=2, pattern="+-o+", aperture=3e-3),
)
LIMITS = {"lowest": 0.98 * FREQUENCY, "highest": 1.02 * FREQUENCY}
PLACES = ((11e-3, 0.0), (8.7e-3, 0.9e-3))  # between the transducers, at unequal distances, on and off the axis
# far from the nodes of the band and the checked frequencies
UNSEEN = (0.9807 * FREQUENCY, 1.0055 * FREQUENCY)


def stated_and_true(stator, tolerance, mirror_width=None):
    """Reduction's error of motion and admittance of a band, and the largest differences at the unseen frequencies."""
    options = {"drive": "a", "tolerance": tolerance, "places": PLACES, "mirror_width": mirror_width}
    band = beam_band(stator, ROW, **LIMITS, **options)
    true = []
    for frequency in UNSEEN:
        full = solve_driven(stator, ROW, frequency=frequency, drive="a", resolution=band.band.model.resolution)
        wave = surface_wave(full, relative_error=0.0, admittance_error=0.0)
        beam = band.beam(frequency, "a")
        assert beam.wave.relative_error == band.relative_error + band.band.relative_error <= 2 * tolerance
        true.append(beam_differences(surface_beam(wave, mirror_width=mirror_width), beam, np.array(PLACES).T))
    return (band.relative_error, band.admittance_error), np.max(true, axis=0)


@pytest.mark.parametrize(
    ("ends", "tolerance", "mirror_width"),
    [
        ("absorbing", 2e-2, None),
        pytest.param("absorbing", 1e-3, None, marks=pytest.mark.slow),
        pytest.param("absorbing", 2e-2, 6e-3, marks=pytest.mark.slow),
        pytest.param("free", 5e-2, None, marks=pytest.mark.slow),
        pytest.param("clamped", 5e-2, None, marks=pytest.mark.slow),
    ],
)
def test_beams_of_a_band_are_those_of_full_solutions(ends, tolerance, mirror_width):
    stated, true = stated_and_true(replace(STATOR, ends=ends), tolerance, mirror_width)
    assert max(true) > 1e-12  # computed from other lines
    assert true[0] < max(2 * stated[0], 1e-6)
    assert true[1] < max(2 * stated[1], 1e-6)
    assert stated[0] < tolerance


@pytest.mark.parametrize(("name", "orientation"), [("PZT-8", "Z"), ("PZT-8", "X"), ("LiNbO3 (Warner)", "YZ")])
def test_interpolated_charges_are_those_of_half_cells_on_full_lines(name, orientation):
    """Mirror images with an even and an odd potential, and none; an open strip and both electrodes."""
    block = Stator(solid=rotated(material(name), orientation), length=0.012, thickness=1e-3, ends="absorbing")
    middle = 2.15e6 if name == "PZT-8" else 3.4e6
    row = (
        Transducer(
            name="a", center=5e-3, finger_pairs=2, pattern="+-o-", period=1e-3, metallisation=0.4, aperture=0.02
        ),
    )
    problem = BandProblem(
        stator=block, transducers=row, limits=(0.98 * middle, 1.02 * middle), drive="a", tolerance=1e-2,
        positions=np.array([0.009]), charges=True,
    )  # fmt: skip
    model = project(problem, solve_at_nodes(problem, LEVELS[1]), 1e-5)
    lifted = replace(model, half_cells={shape: replace(each, reactions=()) for shape, each in model.half_cells.items()})
    known, expected = (
        all_charges(driven_solution(each.cascade(1.007 * middle).solved(), "a"))[0] for each in (model, lifted)
    )
    np.testing.assert_allclose(known.x, expected.x, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(known.finger, expected.finger)
    largest = abs(expected.charge).max()
    assert 0 < abs(known.charge - expected.charge).max() < 1e-4 * largest
    assert abs(expected.charge.real).min() < 1e-2 * largest  # the open strip has charges too, without a sum


def test_a_cut_off_within_a_band_does_not_spoil_its_finite_apertures():
    """A plate mode begins at 2.24 MHz, where no polynomial follows the potentials of a finite aperture."""
    thick = Stator(solid=rotated(material("PZT-8"), "Z"), length=0.024, thickness=5e-3, ends="absorbing")
    row = (Transducer(name="a", center=0.01, finger_pairs=2, period=0.95e-3, metallisation=0.5, aperture=5e-3),)
    limits = (2.15e6, 2.25e6)
    band = frequency_band(thick, row, lowest=limits[0], highest=limits[1], drive="a", tolerance=5e-2, places=(0.018,))
    at = np.array([2.16e6, 2.236e6, 2.2455e6])
    found = band.admittances(at, aperture_solver(thick, limits=limits))
    expected = band.admittances(at, aperture_solver(thick))
    plain = band.admittances(at)
    assert abs(plain / expected - 1).max() > 1e-3
    assert 0 < abs(found / expected - 1).max() < 1e-5


def test_a_band_of_beams_refuses_what_it_does_not_compute():
    options = {"drive": "a", "tolerance": 2e-2, "places": PLACES}
    cuts = replace(STATOR, solid=rotated(material("LiNbO3 (Warner)"), "YZ"))
    with pytest.raises(BeamError, match="isotropic about z: solve one frequency at a time"):
        beam_band(cuts, ROW, **LIMITS, **options)


def test_a_band_whose_beams_miss_the_tolerance_is_tried_again_and_refused_with_its_error(monkeypatch):
    """Beams that are off by 5 %, which counts twice at least, whatever the band of the section."""
    solved, tried = frequency_band, []

    def noted(*given, **options):
        tried.append(options["tolerance"])
        return solved(*given, **options)

    monkeypatch.setattr(beam_band_module, "frequency_band", noted)
    monkeypatch.setattr(beam_band_module, "beam_differences", lambda fine, coarse, places: (0.05, 0.05))
    with pytest.raises(ConvergenceError, match="one frequency at a time") as refused:
        beam_band(STATOR, ROW, **LIMITS, drive="a", tolerance=2e-2, places=PLACES)
    error = refused.value.reached.relative_error
    assert error >= 0.1
    assert tried == pytest.approx([2e-2, 2e-2 * 0.5 * 2e-2 / error])
