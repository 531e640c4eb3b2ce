"""A slider that moves through the field: against the burst followed in steps under the envelope of its own path."""

import numpy as np
import pytest

import contact
from studies import run
from studies.chain.travel import WaveAlong, travelled, with_travel
from studies.inverse.prediction import MeasurementPredictor
from studies.lab.measurement import Measurement

WAVELENGTH = 1e-3
BASE = contact.Orbit(frequency=2.2e6, normal=8e-9, tangential=5e-9j)
SLIDER = contact.Slider(
    radius=1e-3, mass=8.9e-5, preload=8.9e-5 * 9.81, load=0.0, friction_coefficient=0.08, effective_modulus=64e9,
    tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0,
    normal_damping=0.5, tangential_damping=1e-4,
)  # fmt: skip


def wave(factor, limits=(-0.05, 0.05)) -> WaveAlong:
    """A field whose amplitude is ``factor`` of the displacement."""
    return WaveAlong(
        wavelength=WAVELENGTH,
        limits=limits,
        orbits=lambda places: [(BASE.scaled(float(factor(place))),) for place in places],
    )


def fading(place):
    return 1.0 + place / 8e-4


def burst(duration, envelope=None):
    return contact.burst(
        SLIDER, BASE, duration=duration, after=0.01, tolerance=1e-3, samples=400, method="stepped", envelope=envelope
    )


def test_a_uniform_field_changes_nothing():
    found = travelled(SLIDER, wave(lambda place: 1.0), 1.0, 0.02, -1e-4)
    assert abs(found.change) < 1e-15
    assert found.error < 1e-15
    assert found.velocity[-1] < 0


def test_against_the_envelope_of_its_own_path():
    """The stepped burst under e(t) = factor(X(t)) knows nothing of tables or averages."""
    duration = 0.03
    found = travelled(SLIDER, wave(fading), 1.0, duration, -2e-4)
    path = contact.Envelope(
        time=found.time, amplitude=fading(found.displacement), phase=np.zeros(len(found.time))
    )  # fmt: skip
    plain, shaped = burst(duration), burst(duration, path)
    moved = with_travel(plain, found)
    change = shaped.velocity_at_burst_end - plain.velocity_at_burst_end
    assert abs(change) > 0.03 * abs(plain.velocity_at_burst_end)
    assert found.change == pytest.approx(change, rel=0.05)
    assert moved.velocity_at_burst_end == pytest.approx(shaped.velocity_at_burst_end, rel=3e-3)
    early = moved.time < duration
    followed = np.interp(moved.time[early], shaped.time, shaped.velocity)
    assert abs(moved.velocity[early] - followed).max() < 5e-3 * abs(followed).max()
    slide = moved.velocity[moved.time > duration]
    expected = np.interp(moved.time[moved.time > duration], shaped.time, shaped.velocity)
    assert abs(slide - expected).max() < 0.02 * abs(followed).max()


def test_it_stops_at_the_end_of_the_stator():
    found = travelled(SLIDER, wave(lambda place: 1.0, limits=(-1e-4, 0.01)), 1.0, 0.05, -1e-3)
    assert found.ended
    assert found.displacement[-1] == pytest.approx(-1e-4, abs=2e-5)
    assert found.time[-1] < 0.05


def test_the_load_works_against_the_drive():
    free = travelled(SLIDER, wave(fading), 1.0, 0.02, -1e-4)
    held = SLIDER.__class__(**{**vars(SLIDER), "load": 1e-4})
    loaded = travelled(held, wave(fading), 1.0, 0.02, -1e-4)
    expected = 1e-4 / SLIDER.mass * 0.02
    assert loaded.velocity[-1] - free.velocity[-1] == pytest.approx(expected, rel=0.2)


def test_a_run_says_how_far_it_went(small):
    scene = small.replace(drive={"burst": "1 ms", "voltage": "120 V"}, slider={"travel": True})
    moved, still = (run(each, tolerance=0.05) for each in (scene, scene.replace(slider={"travel": False})))
    travel = moved.points[0]["travel_m"]
    _, trajectory = still.trajectories[0]
    on = trajectory.time <= trajectory.duration
    assert travel == pytest.approx(np.trapezoid(trajectory.velocity[on], trajectory.time[on]), rel=0.1)
    assert moved.points[0]["velocity_at_burst_end_m_per_s"] == pytest.approx(
        still.points[0]["velocity_at_burst_end_m_per_s"], rel=0.05
    )
    # a fit predicts the burst of the run, whatever factor its amplitude is the product of
    time = (3e-4, 6e-4, 1e-3)  # instants that a trajectory holds
    measured = Measurement(name="trace", quantity="burst", time=time)
    halved = scene.replace(drive={"voltage": "60 V"})
    for each, numbers in ((scene, {}), (halved, {"amplitude_factor": 2.0})):
        (predicted,) = MeasurementPredictor(each, tolerance=0.05).predict([(measured, numbers)])
        of_moved, of_still = (
            np.interp(time, path.time, path.velocity) for _, path in (moved.trajectories[0], still.trajectories[0])
        )
        assert abs(predicted - of_moved).max() < 0.01 * abs(of_moved - of_still).max()
    assert "travel_m" not in still.points[0]
    assert any("slider.travel is false" in each for each in still.left_out)
    absent = run(small.replace(drive={"burst": "1 ms", "voltage": "120 V"}), tolerance=0.05)
    assert absent.points == still.points  # less than a tenth of a wavelength: bit-equal
