"""The driven wave with its error: convergence over levels, honest estimates, refusals in words."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from fem.discretize.depth_mesh import discretise
from fem.discretize.mesh_refinement import EXPECTED, LEVELS
from fem.exceptions import ConvergenceError
from fem.geometry import Stator, Transducer
from fem.materials import material
from fem.solve.driven_stator import driven_wave, motion_difference, solve_driven
from tests.fem.stators import FREQUENCY, comb, cut, lossless, plate, wave_of

SOLID = cut("PZT-8", "Z")
STATOR = plate(SOLID, length=7.0, thickness=0.7, ends="free")
PAIR = (comb(STATOR, "a", 1.6, finger_pairs=2), comb(STATOR, "b", 5.2, period=0.9))


def level(number, stator, transducers, *, drive="a"):
    return wave_of(solve_driven(stator, transducers, frequency=FREQUENCY, drive=drive, resolution=LEVELS[number]))


@cache
def known(number):
    """The pair on its stator, at a level."""
    return level(number, STATOR, PAIR)


def test_levels_converge():
    """A level divides the distance to the finest of four by 5 and more (6.7 per edge layer, and the order)."""
    waves = [known(number) for number in range(4)]
    at = np.array([0.5 * STATOR.length])
    for errors in (
        [abs(wave.admittance / waves[-1].admittance - 1) for wave in waves[:-1]],
        [motion_difference(wave.motion(at), waves[-1].motion(at)) for wave in waves[:-1]],
    ):
        assert errors[-1] < 2e-3
        for coarse, fine in pairwise(errors):
            assert fine < coarse / 5


def test_answer_carries_its_error_cost_and_power(caplog):
    with caplog.at_level("DEBUG", logger="fem"):
        wave = driven_wave(STATOR, PAIR, frequency=FREQUENCY, drive="a", tolerance=1e-2)
    fine = known(3)
    at = np.array([0.5 * STATOR.length])
    assert motion_difference(wave.motion(at), fine.motion(at)) < 2 * wave.relative_error
    assert abs(wave.admittance / fine.admittance - 1) < 2 * wave.admittance_error
    assert 0 < wave.relative_error <= 1e-2
    assert wave.admittance_error < 30 * abs(wave.admittance / fine.admittance - 1)
    assert wave.power_residual < 1e-6
    assert wave.circuit.power == pytest.approx(0.5 * wave.admittance.real, rel=1e-9)
    assert wave.power.dissipated == pytest.approx(wave.circuit.power, rel=1e-9)
    assert wave.power.radiated == 0
    assert len([each for each in caplog.messages if each.startswith("order ")]) >= 2
    assert wave.comb_voltage_per_volt == 1
    assert wave.frequency == FREQUENCY


def test_an_infinite_tolerance_is_the_coarsest_level_without_an_error():
    wave, coarse = (driven_wave(STATOR, PAIR, frequency=FREQUENCY, drive="a", tolerance=np.inf), level(0, STATOR, PAIR))
    assert wave.relative_error == wave.admittance_error == np.inf
    assert wave.admittance == pytest.approx(coarse.admittance, rel=1e-12)
    assert abs(wave.admittance / known(3).admittance - 1) < 0.2


def test_absorbing_ends_radiate():
    stator = replace(STATOR, ends="absorbing", solid=lossless("PZT-8", "Z"))
    wave = driven_wave(stator, PAIR, frequency=FREQUENCY, drive="a", tolerance=1e-2)
    assert wave.power.radiated == pytest.approx(wave.circuit.power, rel=1e-9)
    assert abs(wave.power.dissipated) < 1e-9 * wave.circuit.power


def test_the_difference_of_orbits_counts_their_phase():
    """A common phase moves the clock, not the orbit."""

    class Turned:
        def __init__(self, wave, phase):
            self.wave, self.phase = wave, phase

        def motion(self, x):
            return self.wave.motion(x) * self.phase

    wave = level(0, STATOR, PAIR)
    at = np.array([0.3, 0.5]) * STATOR.length
    turned = motion_difference(Turned(wave, np.exp(0.7j)).motion(at), wave.motion(at))
    assert turned == pytest.approx(2 * np.sin(0.35), rel=1e-12)
    assert motion_difference(wave.motion(at), Turned(wave, 1.01).motion(at)) == pytest.approx(0.01, rel=0.02)


VARIED = {
    "clamped ends": (plate(SOLID, length=6.0, thickness=0.6, ends="clamped"), {}),
    "thick": (plate(SOLID, length=6.0, thickness=5.0), {}),
    "thin": (plate(SOLID, length=6.0, thickness=0.25, ends="free"), {}),
    "grounded": (plate(SOLID, length=6.0, bottom="grounded"), {}),
    "clamped": (plate(SOLID, length=6.0, bottom="clamped", ends="free"), {}),
    "narrow fingers": (plate(SOLID, length=6.0), {"metallisation": 0.25}),
    "wide fingers": (plate(SOLID, length=6.0), {"metallisation": 0.9}),
    "long period": (plate(SOLID, length=6.0, ends="free"), {"period": 1.7}),
    "short period": (plate(SOLID, length=6.0), {"period": 0.5}),
    "YZ lossless": (plate(lossless("LiNbO3 (Warner)", "YZ"), length=6.0), {}),
    "128YX": (plate(cut("LiNbO3 (Kovacs)", "128YX"), length=6.0, ends="free"), {}),
    "ST-X": (plate(cut("quartz (Bechmann)", "ST-X"), length=6.0), {}),
    "X-poled": (plate(cut("PZT-5H", "X"), length=6.0), {}),
    "under vacuum": (plate(SOLID, length=6.0, above="vacuum"), {}),
    "high Q": (plate(cut("PZT-8", "Z", quality=1e5, loss=1e-4), length=6.0, ends="free"), {}),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", VARIED)
def test_error_estimate_is_honest(name):
    """True error, against the finest level, at most twice the estimate: motion and admittance, 1e-2 and 1e-3."""
    stator, rest = VARIED[name]
    transducer = comb(stator, "a", 2.0, finger_pairs=2, **rest)
    finest = level(5, stator, (transducer,))
    at = np.array([0.75 * stator.length])
    for tolerance in (1e-2, 3e-3 if name.startswith("clamped") else 1e-3):
        wave = driven_wave(stator, (transducer,), frequency=FREQUENCY, drive="a", tolerance=tolerance, places=tuple(at))
        assert motion_difference(wave.motion(at), finest.motion(at)) < 2 * wave.relative_error
        assert abs(wave.admittance / finest.admittance - 1) < 2 * wave.admittance_error


@pytest.mark.slow
@pytest.mark.parametrize(("name", "orientation"), [("PZT-8", "Z"), ("LiNbO3 (Warner)", "YZ")])
def test_half_space_does_not_know_where_its_absorber_begins(name, orientation, monkeypatch):
    """The half-space ends two wavelengths down and then three: the same motion, to the error reported."""
    stator = plate(lossless(name, orientation), length=6.0, thickness=np.inf)
    transducer, at = comb(stator, "a", 2.0), np.array([0.75 * stator.length])
    near = drive(stator, (transducer,), places=tuple(at))
    monkeypatch.setitem(discretise.__kwdefaults__, "least_depth", 3.0)
    far = drive(stator, (transducer,), places=tuple(at))
    assert motion_difference(near.motion(at), far.motion(at)) < near.relative_error + far.relative_error
    assert near.power_residual < 1e-6


def test_levels_and_expectations_match():
    assert len(LEVELS) == len(EXPECTED)
    assert all(fine.order > coarse.order for coarse, fine in pairwise(LEVELS))


def drive(stator=STATOR, transducers=PAIR, **changes):
    return driven_wave(stator, transducers, **({"frequency": FREQUENCY, "drive": "a", "tolerance": 1e-2} | changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"drive": "c"}, r"sources must name transducers of the stator, a, b, got 'c'"),
        ({"frequency": np.nan}, r"frequency must be positive and finite, got nan Hz"),
        ({"frequency": -2e6}, r"frequency must be positive and finite, got -2000000\.0 Hz"),
        ({"transducers": (PAIR[0], PAIR[0])}, "name must differ from the others"),
        (
            {"transducers": (PAIR[0], replace(PAIR[0], name="b", center=1.2 * PAIR[0].center))},
            "fingers of 'b' off those of 'a'",
        ),
        (
            {"transducers": (replace(PAIR[0], center=STATOR.length),)},
            "'a'.center must keep the fingers on the stator, 0 to",
        ),
        (
            {"stator": replace(STATOR, solid=material("steel"))},
            "transducer needs a piezoelectric stator, and steel is not piezoelectric",
        ),
        ({"places": (1.0,)}, "x must lie on the stator"),
    ],
)
def test_refusals(changes, message):
    with pytest.raises(ValueError, match=message):
        drive(**changes)


def test_an_impossible_tolerance_is_refused(monkeypatch):
    """With the next step to try, and what is known; two levels instead of six, to be quick."""
    monkeypatch.setattr("fem.discretize.mesh_refinement.LEVELS", LEVELS[:2])
    monkeypatch.setattr("fem.discretize.mesh_refinement.EXPECTED", EXPECTED[:2])
    stator = plate(SOLID, length=2.0, thickness=0.15)
    with pytest.raises(ConvergenceError, match=r"is known to \d\.\de-\d+ only, 1\.0e-14 was asked for: ask for less"):
        drive(stator, (comb(stator, "a", 1.0),), tolerance=1e-14)


def test_units_do_not_matter():
    """A stator a thousand times larger at a thousandth of the frequency: the same admittance, for equal aperture."""
    small = drive()
    scale = 1000.0
    large_stator = Stator(solid=SOLID, length=STATOR.length * scale, thickness=STATOR.thickness * scale, ends="free")
    large: tuple[Transducer, ...] = tuple(
        replace(each, center=each.center * scale, period=each.period * scale) for each in PAIR
    )
    other = drive(large_stator, large, frequency=FREQUENCY / scale)
    assert other.admittance * scale == pytest.approx(small.admittance, rel=1e-9)
    assert other.motion(0.5 * large_stator.length) == pytest.approx(small.motion(0.5 * STATOR.length), rel=1e-8)
