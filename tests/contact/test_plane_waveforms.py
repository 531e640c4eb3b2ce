"""Bursts in the plane whose waves have a shape, against an integrator that shares nothing with the product."""

import math
from dataclasses import replace

import numpy as np
import pytest

from contact import Envelope
from contact.exceptions import InputError
from contact.plane import SurfaceWaves, burst, bursts, threshold_factor
from contact.plane.wave_shape import WaveShape
from tests.contact.plane_motors import R_X, ball, beams
from tests.oracles.contact_plane import in_steps

T = 1 / 2.2e6
CYCLES = 60
AT = np.linspace(0.0, CYCLES * T, 241)
LIGHT = ball(mass=1e-7, normal_damping=0.05)


def shaped(amplitude, phase=0.0, time=AT):
    return Envelope(time=time, amplitude=amplitude + 0.0 * time, phase=phase + 0.0 * time)


SHAPES = {
    "ramp": shaped(np.array([0.0, 1.0, 1.0, 0.2]), time=T * np.array([0.0, 20.0, 40.0, 60.0])),
    "modulated": shaped(1.0 + 0.5 * np.sin(2.0 * np.pi * AT / (15 * T))),
    "chirp": shaped(1.0, 2.0 * np.pi * (-0.03 * AT / T + 0.06 * (AT / T) ** 2 / (2 * CYCLES))),
    "two phases": shaped(1.0, np.array([0.0, 0.0, 0.5 * np.pi, 0.5 * np.pi]), T * np.array([0.0, 25.0, 30.0, 60.0])),
}


def by_oracle(slider, waves, shapes, cycles=CYCLES, sizes=(512, 1024, 2048)):
    """Return the rates after so many cycles, and their error; `shapes` of each frequency on one list of times."""
    own, n = slider.contacts(waves.count), waves.count
    body = (
        slider.mass, 0.0 if slider.freedom == "xy" else 1.0 / slider.inertia, slider.preload, *slider.load,
        slider.torque, slider.normal_damping, slider.tangential_damping, slider.contact_damping,
    )  # fmt: skip
    balls = np.stack([own.x, own.y, own.height, own.normal_stiffness * own.weight, own.limit_slope,
                      np.full(n, slider.friction_coefficient)], axis=1)  # fmt: skip
    start = np.zeros(8)
    start[0] = -slider.rest_approach(n)
    times, amplitude, phase = shapes[0].time, [each.amplitude for each in shapes], [each.phase for each in shapes]
    state, error = in_steps(
        cycles, waves.frequencies, waves.amplitudes, 0.0, body, balls, False, start, sizes,
        shape=(times, amplitude, phase),
    )  # fmt: skip
    return state[5:], error[5:]


@pytest.mark.parametrize("name", SHAPES)
def test_one_ball_under_two_waves_of_a_shape(name):
    waves, given = beams(2.5, 1.25, np.pi / 3), dict(duration=CYCLES * T, after=0.0, samples=1)
    true, of_oracle = by_oracle(LIGHT, waves, [SHAPES[name]])
    plain = burst(LIGHT, waves, tolerance=1e-3, method="exact", **given).velocity[-1]
    assert np.hypot(*(plain - true[:2])) > 5e-3 * np.hypot(*true[:2])  # the shape matters
    for method, tolerance in (("exact", 1e-3), ("exact", 1e-6), ("stepped", 1e-2)):
        run = burst(LIGHT, waves, tolerance=tolerance, method=method, envelope=SHAPES[name], **given)
        miss = np.hypot(*(run.velocity[-1] - true[:2]))
        assert miss <= 2.0 * np.hypot(*run.error[:2]) + np.hypot(*of_oracle[:2])
        assert run.relative_error < tolerance
        if method == "exact":
            assert run.ledger.relative_residual < 0.3 * tolerance


def test_three_balls_turn_under_two_frequencies_with_shapes_of_their_own():
    x, y = np.array([3e-3, -2e-3, -1.5e-3]), np.array([0.5e-3, 2.5e-3, -2e-3])
    slider = ball(
        x=x, y=y, heights=[0.0, 0.3e-9, -0.2e-9], radius=[1e-3, 0.8e-3, 1.2e-3], preload=2.2e-3, mass=2e-7,
        freedom="xy yaw", inertia=1.5e-12, normal_damping=0.1, contact_damping=0.02,
    )  # fmt: skip
    rows = [[[-1j * R_X * a, 0.1 * a, a * np.exp(1j * p)] for a, p in ((3e-9, 0.0), (2.5e-9, 0.4), (3.5e-9, -0.3))],
            [[0.2 * a, -1j * R_X * a, a] for a in (2e-9, 1.5e-9, 2.5e-9)]]  # fmt: skip
    waves = SurfaceWaves(frequencies=[2.2e6, 2.4e6], amplitudes=rows)
    own = {2.2e6: SHAPES["modulated"], 2.4e6: SHAPES["chirp"]}
    run = burst(slider, waves, duration=36 * T, after=0.0, tolerance=1e-5, samples=1, method="exact", envelope=own)
    true, of_oracle = by_oracle(slider, waves, list(own.values()), cycles=36)
    scale = np.array([1.0, 1.0, 3.2e-3])
    miss, stated, oracle = (np.linalg.norm(scale * each) for each in (run.rates[-1] - true, run.error, of_oracle))
    assert miss <= 2.0 * stated + oracle
    assert oracle < 2e-5 * waves.peak_speed


def test_phases_and_places_counted_anew_keep_the_shape():
    """After 300 cycles phases count anew, of the knots too: against fixed steps, which never do."""
    slider, waves = ball(mass=0.089e-3, normal_damping=0.5), beams(10, 6, 0.5)
    time = np.linspace(0.0, 1500 * T, 400)
    wave = shaped(1.0 + 0.6 * np.sin(2.0 * np.pi * 4e3 * time), 3.0 * np.cos(2.0 * np.pi * 3e3 * time), time)
    given = dict(duration=1000 * T, after=500 * T, samples=5, envelope=wave, ring_down=shaped(0.3, 0.0, time))
    exact = burst(slider, waves, tolerance=1e-5, method="exact", **given)
    stepped = burst(slider, waves, tolerance=1e-2, method="stepped", **given)
    assert np.all(np.abs(exact.velocity - stepped.velocity) <= 2 * (exact.error + stepped.error)[:2])
    assert exact.relative_error < 1e-5


def test_a_wave_that_fades_after_the_burst_moves_on():
    """A burst of half the time with the other half in its ring-down is the whole one."""
    waves, shape = beams(2.5, 1.25, np.pi / 3), SHAPES["modulated"]
    half = 0.5 * CYCLES * T
    later = shape.time >= half
    rest = Envelope(time=shape.time[later] - half, amplitude=shape.amplitude[later], phase=shape.phase[later])
    given = dict(tolerance=1e-5, samples=4, method="exact")
    whole = burst(LIGHT, waves, duration=2 * half, after=0.0, envelope=shape, **given)
    fading = burst(LIGHT, waves, duration=half, after=half, envelope=shape, ring_down=rest, **given)
    assert np.hypot(*(whole.velocity[-1] - fading.velocity[-1])) < 1e-4 * np.hypot(*whole.velocity[-1])
    stopped = burst(LIGHT, waves, duration=half, after=half, envelope=shape, **given)
    assert np.hypot(*(whole.velocity[-1] - stopped.velocity[-1])) > 0.1 * np.hypot(*whole.velocity[-1])


@pytest.mark.parametrize("after", [0.0, 1e-3])
def test_waves_that_end_at_once_do_not_add_to_the_lag_of_the_height(after):
    """Their end counted as a ramp of some microseconds: an error of several times the velocity was stated."""
    slider, waves = ball(mass=0.089e-3, normal_damping=0.5), beams(10, 6, 0.5)
    rises = Envelope(time=[0.0, 1e-3, 4e-3], amplitude=[0.0, 1.0, 1.0], phase=[0.0] * 3)
    fading = np.linspace(0.0, 1e-4, 41)
    given = dict(
        duration=4e-3, after=after, samples=8, envelope=rises, ring_down=shaped(np.exp(-fading / 1e-5), 0.0, fading)
    )
    averaged = burst(slider, waves, tolerance=1e-1, method="averaged", **given)
    exact = burst(slider, waves, tolerance=1e-3, method="exact", **given)
    assert averaged.relative_error < 5e-2
    assert np.all(np.abs(averaged.velocity - exact.velocity) <= 2 * (averaged.error + exact.error)[:2])


RAMP = Envelope(time=[0.0, 1e-3, 3e-3, 4e-3], amplitude=[0.0, 1.0, 1.0, 0.0], phase=[0.0] * 4)
SLOW = np.linspace(0.0, 4e-3, 401)
PAUSES = shaped(1.0 + np.sin(2.0 * np.pi * 500.0 * SLOW), 0.0, SLOW)  # below the threshold for a while


@pytest.mark.parametrize(("shape", "mass"), [(RAMP, 0.089e-3), (PAUSES, 5e-6)])
def test_the_averaged_motion_follows_slow_shapes_within_its_error(shape, mass):
    slider, waves = ball(mass=mass, normal_damping=0.5), beams(10, 6, 0.5)
    given = dict(duration=4e-3, after=0.0, samples=8, envelope=shape)
    exact = burst(slider, waves, tolerance=1e-3, method="exact", **given)
    mean = burst(slider, waves, tolerance=1e-2, method="averaged", **given)
    miss = np.abs(mean.rates - exact.rates).max(axis=0)[:2]
    assert np.all(miss <= 2.0 * (mean.error + exact.error)[:2])
    assert np.hypot(*miss) > 3.0 * np.hypot(*exact.error[:2])  # another computation
    assert np.all(np.abs(mean.pose - exact.pose).max(axis=0) <= 2.0 * (mean.pose_error + exact.pose_error))


def test_a_slider_waits_until_a_slow_ramp_reaches_its_threshold():
    """Held by friction before, it moves when the amplitude passes the threshold of steady waves."""
    slider, waves = ball(mass=0.089e-3, normal_damping=20.0), beams(3, 0)
    factor = threshold_factor(slider, waves)
    ramp = Envelope(time=[0.0, 0.04], amplitude=[0.0, 0.8], phase=[0.0, 0.0])
    run = burst(slider, waves, duration=0.04, after=0.0, tolerance=1e-2, samples=400, method="averaged", envelope=ramp)
    begins = run.time[np.flatnonzero(run.velocity[:, 0] > 1e-4 * run.velocity[-1, 0])[0]]
    assert 0.1 < factor < 0.7
    assert factor <= 0.8 * begins / 0.04 <= factor + 0.015


def test_the_method_follows_from_how_fast_the_waves_change(monkeypatch):
    monkeypatch.setattr(bursts, "MAX_EXACT", 1000)
    slider, waves = ball(mass=0.089e-3, normal_damping=20.0), beams(10, 6, 0.5)
    time = np.linspace(0.0, 2e-3, 401)
    given = dict(duration=2e-3, after=0.0, tolerance=5e-2, samples=1)
    slow = shaped(np.minimum(time / 1.5e-3, 1.0), 0.0, time)
    fast = shaped(1.0 + 0.5 * np.sin(2.0 * np.pi * 9e3 * time), 0.0, time)  # near the resonance of the contacts
    assert burst(slider, waves, envelope=slow, **given).method == "averaged"
    assert burst(slider, waves, envelope=fast, **given).method == "exact"
    forced = burst(slider, waves, envelope=fast, method="averaged", **given)
    assert forced.status == "above tolerance"


@pytest.mark.parametrize("method", ["exact", "averaged"])
def test_a_phase_that_grows_steadily_is_a_wave_of_another_frequency(method):
    waves, by_mean = beams(2.5, 1.25, np.pi / 3), method == "averaged"
    slider = ball(mass=5e-6, normal_damping=5.0) if by_mean else LIGHT
    duration, begin = (4e-3, ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))) if by_mean else (CYCLES * T, None)
    time = np.array([0.0, duration])
    higher, there = (
        shaped(1.0, 2.0 * np.pi * 0.05 * time / T, time),
        replace(waves, frequencies=waves.frequencies * 1.05),
    )
    given = dict(
        duration=duration, after=0.0, samples=1, start=begin, method=method, tolerance=1e-2 if by_mean else 1e-6
    )
    one, other = burst(slider, waves, envelope=higher, **given), burst(slider, there, **given)
    assert one.velocity[-1] == pytest.approx(other.velocity[-1], rel=1e-3 if by_mean else 1e-6)
    plain = burst(slider, waves, **given)
    assert np.hypot(*(plain.velocity[-1] - one.velocity[-1])) > 5e-3 * np.hypot(*one.velocity[-1])


def test_a_free_tilt_is_that_of_the_shaped_waves():
    """A factor of 1/2 on the waves is the burst of waves of half the amplitude."""
    x, y = np.array([3e-3, -2e-3, -1.5e-3]), np.array([0.5e-3, 2.5e-3, -2e-3])
    slider = ball(x=x, y=y, preload=2.2e-3, mass=2e-7, normal_damping=0.1, tilt="free", preload_at=(1e-4, 2e-4))
    waves = SurfaceWaves(frequencies=[2.2e6], amplitudes=[[[-1j * R_X * a, 0.0, a] for a in (9e-9, 3e-9, 5e-9)]])
    given = dict(duration=20 * T, after=0.0, samples=1, tolerance=1e-6, method="exact")
    half = burst(slider, waves, envelope=shaped(0.5), **given)
    assert half.rates[-1] == pytest.approx(burst(slider, waves.scaled(0.5), **given).rates[-1], rel=1e-7, abs=1e-15)


def test_corners_and_parts_of_a_shape():
    shape = WaveShape.of(beams(1, 0), 4e-3, RAMP, None)
    assert shape.corners(1e-6) == pytest.approx([1e-3, 3e-3])
    assert shape.corners(1.0).size == 0
    assert shape.parts(0.0, 1e-3) == pytest.approx(np.linspace(0.0, 1e-3, 5), rel=1e-6)
    assert shape.root_mean_square == pytest.approx([math.sqrt((2.0 / 3.0 + 2.0) / 4.0)])
    assert shape.factors(0.5e-3) == pytest.approx([0.5])
    assert not shape.on(beams(1, 0), 4e-3, True).amplitudes.any()
    assert not WaveShape.of(beams(1, 0), 2e-3, RAMP, None).on(beams(1, 0), 2e-3, True).amplitudes.any()
    turns = (
        shaped(1.0, np.array([0.0, 7.0]), np.array([0.0, 4e-3])),
        shaped(1.0, np.array([0.7, 1.0]), np.array([0, 1e-3])),
    )
    joined = WaveShape.of(beams(1, 0), 4e-3, *turns)  # phases of a ring-down are known but for whole turns
    assert joined.phase[0, -2:] == pytest.approx(np.array([0.7, 1.0]) + 2.0 * np.pi)


def test_shapes_that_do_not_fit_are_refused():
    given = dict(duration=1e-4, after=0.0, tolerance=1e-3, samples=1)
    with pytest.raises(InputError, match="rise_time must be 0 with an envelope"):
        burst(LIGHT, beams(3, 0), envelope=SHAPES["ramp"], rise_time=1e-5, **given)
    with pytest.raises(InputError, match="ring_down needs an envelope"):
        burst(LIGHT, beams(3, 0), ring_down=SHAPES["ramp"], **given)
    with pytest.raises(InputError, match="envelope must have an Envelope for each frequency"):
        burst(LIGHT, beams(3, 0), envelope={1e6: SHAPES["ramp"]}, **given)
