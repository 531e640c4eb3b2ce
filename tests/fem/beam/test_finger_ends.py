"""Charge along fingers of finite length: against many equal steps, and what its variation does at the seed's ball."""

from dataclasses import replace

import numpy as np
import pytest

import fem
from fem.beam import own_aperture
from fem.beam.beam_of_section import aperture_beam, surface_beam
from fem.beam.electrode_charges import electrode_charges
from fem.beam.reception import with_apertures
from fem.discretize.mesh_refinement import LEVELS
from fem.results.stator_solution import Solution
from fem.solve.driven_stator import solve_driven
from studies.remarks.stator_effects import UNEVEN_CHARGE, UNEVEN_PER_PAIR
from tests.fem.stators import wave_of

SOLID = fem.rotated(fem.material("PZT-8"), "Z")
PERIOD = fem.automatic_period(SOLID, 2.2e6, 0.5)


def comb_wave(pairs: int, aperture: float, thickness: float = 5e-3, **given):
    """A driven transducer, its aperture in periods; one discretisation."""
    stator = fem.Stator(solid=SOLID, length=0.15, thickness=thickness, ends="absorbing")
    one = fem.Transducer(
        name="a",
        center=0.015,
        finger_pairs=pairs,
        period=PERIOD,
        metallisation=0.5,
        aperture=aperture * PERIOD,
        **given,
    )
    found = solve_driven(stator, (one,), frequency=2.2e6, drive="a", resolution=LEVELS[1])
    return wave_of(found)


def with_steps(monkeypatch, wave, count: int):
    """The beam of charges in many equal steps along half a finger, and some short ones at its end."""
    one = wave.solution.fields.transducers[0]
    equal = one.aperture / 2 / PERIOD / count * np.arange(1, count)
    monkeypatch.setattr(own_aperture, "STEPS", (tuple(np.sort([0.01, 0.03, 0.06, *equal])),))
    monkeypatch.setattr(own_aperture, "SHORTEST_SHEET", 0.0)
    monkeypatch.setattr(own_aperture, "MAX_UNKNOWNS", 10**6)
    fields = with_apertures(wave.solution.fields)
    monkeypatch.undo()
    return aperture_beam(wave, Solution(fields=fields, circuit=replace(wave.circuit)))


@pytest.mark.parametrize(
    ("pairs", "aperture", "steps", "given", "limits"),
    [
        (2, 6.0, 24, {"pattern": "+-o-"}, (0.006, 0.0025, 2e-3)),
        pytest.param(3, 5.0, 40, {}, (0.004, 0.002, 3e-3), marks=pytest.mark.slow),
        pytest.param(10, 20.0, 64, {}, (0.006, 0.002, 3e-4), marks=pytest.mark.slow),
        pytest.param(30, 15.0, 64, {}, (0.012, 0.005, 8e-4), marks=pytest.mark.slow),
        pytest.param(5, 8.0, 40, {"split": True}, (0.006, 0.002, 2e-3), marks=pytest.mark.slow),
    ],
)
def test_many_steps_of_the_charge(monkeypatch, pairs, aperture, steps, given, limits):
    """Worst and rms over 80 places of |u_z| over the section's, and the admittance; the stated rest bounds it."""
    wave = comb_wave(pairs, aperture, **given)
    one, rng = wave.solution.fields.transducers[0], np.random.default_rng(7)
    x = rng.uniform(one.extent[1] + 3e-3, 0.14, 80)
    y = rng.uniform(-0.6, 0.6, 80) * one.aperture
    true, found = with_steps(monkeypatch, wave, steps), surface_beam(wave)
    section = abs(wave.motion(x)[1])
    expected, here = (abs(each.motion(x, y)[2]) for each in (true, found))
    off = abs(here - expected) / section
    assert off.max() < limits[0]
    assert np.sqrt(np.mean(off**2)) < limits[1]
    admittance, own = (each.solution.fields.admittances.item() for each in (true, found))
    assert abs(own / admittance - 1) < limits[2]
    stated = found.charge_error(x, y) * here / section
    assert np.mean(off < 2 * stated + 1e-3) >= 0.95
    fields = with_apertures(wave.solution.fields, fineness=len(own_aperture.STEPS))
    uniform = aperture_beam(wave, Solution(fields=fields, circuit=wave.circuit))
    assert abs(abs(uniform.motion(x, y)[2]) - expected).max() > 3 * limits[0] * section.max()
    plain = replace(found, solution=wave.solution, charges=(electrode_charges(wave.solution, 0),))
    if "split" not in given and "pattern" not in given:
        longer = plain.with_longer_fingers(fem.end_excess(SOLID)).motion(x, y)[2]
        rest = np.sqrt(np.mean((abs(longer) / here - 1) ** 2))
        assert rest < 1.2 * max(UNEVEN_CHARGE, UNEVEN_PER_PAIR * pairs)
        assert np.sqrt(np.mean((abs(plain.motion(x, y)[2]) / here - 1) ** 2)) > rest


def test_the_ball_of_the_seed():
    """At (80 mm, 0) charges that are uniform along the fingers give 5 % more (three-dimensional boundary elements)."""
    wave = comb_wave(10, 0.02 / PERIOD)
    found = surface_beam(wave)
    fields = with_apertures(wave.solution.fields, fineness=len(own_aperture.STEPS))
    uniform = aperture_beam(wave, Solution(fields=fields, circuit=wave.circuit))
    more = abs(uniform.motion(0.08)[2] / found.motion(0.08)[2]) - 1
    assert more == pytest.approx(0.052, abs=0.004)
    stated = found.charge_error(0.08, np.linspace(0.0, 5e-3, 26))
    assert stated[0] < 0.01
    assert stated.min() > 0.2 * stated.max()  # also where fewer steps give the same |u_z| by chance


def test_reciprocity_of_charges_that_vary_along_the_fingers():
    """Two transducers of unequal apertures, beside one another, with unequal numbers of fingers."""
    stator = fem.Stator(solid=SOLID, length=0.05, thickness=2e-3, ends="absorbing")
    one = fem.Transducer(
        name="a", center=0.01, finger_pairs=2, period=PERIOD, metallisation=0.5, aperture=8 * PERIOD, pattern="+-+0"
    )
    other = replace(one, name="b", center=0.03, center_y=2e-3, aperture=5 * PERIOD, finger_pairs=1, pattern=None)
    fields = solve_driven(stator, (one, other), frequency=2.2e6, drive="a", resolution=LEVELS[1]).fields
    found = with_apertures(fields)
    assert len(found.sheets[0]) != len(found.sheets[1])
    matrix, section = found.admittances, fields.admittances
    assert matrix[0, 1] == pytest.approx(matrix[1, 0], rel=1e-9)
    assert abs(matrix[0, 1] / section[0, 1] - 1) > 0.02
