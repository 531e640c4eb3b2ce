"""Bursts along a track: against an independent integrator at the slider's own place, mirrored, at the track's end."""

from dataclasses import replace

import numpy as np
import pytest

from contact import Envelope, InputError, Orbit, Slider, Track, burst, reference_speed
from tests.frozen import frozen
from tests.motors import on_a_track
from tests.oracles.contact_travel import Traveller

SCENE = Traveller(
    mass=2e-5, preload=1.5e-3, frequency=2e6, wavelength=1.1e-3, amplitude=12e-9, reflection=0.45 * np.exp(0.7j),
    ratio=0.7, balls=(0.0, 0.41e-3), mu=0.2, normal_damping=0.4, tangential_damping=1e-4,
)  # fmt: skip
CYCLES = 3000


def along(scene, cycles, limits=(-20e-3, 20e-3), *, side=1.0, after=0.0, **options):
    """Return the burst of a scene, or of its mirror image."""
    slider = Slider(
        radius=scene.radius, mass=scene.mass, preload=scene.preload, load=0.0, friction_coefficient=scene.mu,
        effective_modulus=scene.E, tangential_modulus=scene.G, law=options.pop("law", "elastic"), reciprocal=False,
        stick_band=0.0, contact_damping=0.0, normal_damping=scene.normal_damping,
        tangential_damping=scene.tangential_damping,
    )  # fmt: skip

    def amplitudes(displacements):
        u_x, u_z = scene.orbits_at(side * np.asarray(displacements))
        return np.array([side * u_x, u_z])

    track = Track(amplitudes=amplitudes, spacing=scene.wavelength / 32, limits=tuple(sorted(side * x for x in limits)))
    orbits = tuple(
        Orbit(frequency=scene.frequency, normal=complex(z), tangential=complex(x))
        for x, z in amplitudes([0.0])[:, :, 0].T
    )
    options = {"tolerance": 1e-3, "samples": 300} | options
    return burst(slider, orbits, duration=cycles / scene.frequency, after=after, track=track, **options)


def compared(scene, cycles, per_cycle):
    """Return (true error, stated error, difference of two runs of the oracle) over the reference speed."""
    return against(along(scene, cycles), followed(scene, cycles, per_cycle))


def followed(scene, cycles, per_cycle):
    """Return the oracle's velocity and place at the end, its largest place, and the difference of its two runs, SI."""
    (coarse, _), (truth, places) = scene.run(cycles, per_cycle // 2), scene.run(cycles, per_cycle)
    return np.array([truth[-1], places[-1], abs(places).max(), abs(coarse - truth).max()])


def against(found, truth):
    """Return what `compared` does, of a burst and what the oracle `followed`."""
    velocity, place, farthest, apart = truth
    speed = reference_speed(velocity, found.orbits)
    assert found.displacement[-1] == pytest.approx(place, abs=2e-3 * farthest + 1e-10)
    return abs(found.velocity_at_burst_end - velocity) / speed, found.relative_error, apart / speed


# Oracle: fixed steps at the slider's own place
@frozen([()])
def own_place():
    """What the oracle `followed` of the scene, and its velocity with the wave of the first place alone, m/s."""
    first, _ = replace(SCENE, wavelength=1.0).run(CYCLES, 600)
    return np.array([*followed(SCENE, CYCLES, 1200), first[-1]])


def test_a_slider_on_its_way_has_the_orbits_of_its_own_place():
    *truth, at_first_place = own_place()
    true, stated, own = against(along(SCENE, CYCLES), truth)
    assert own < 1e-3
    assert true <= 2.0 * stated + own
    assert stated < 5e-3
    # the wave at the first place alone gives another answer
    assert abs(at_first_place / truth[0] - 1.0) > 0.05


@pytest.mark.slow
@pytest.mark.parametrize("number", range(14))
def test_stated_errors_along_drawn_standing_waves(number):
    true, stated, own = compared(Traveller(**on_a_track(number)), 30_000, 2400)
    assert stated <= 0.05
    assert own <= 0.01
    assert true <= 2.0 * stated + own


@pytest.mark.parametrize("options", [{}, {"method": "exact"}, {"after": 2e-4}])
def test_the_mirror_image_runs_the_other_way(options):
    cycles = 200 if "method" in options else 1000
    one, other = (along(SCENE, cycles, side=side, **options) for side in (1.0, -1.0))
    np.testing.assert_allclose(other.velocity, -one.velocity, rtol=0, atol=1e-12)
    np.testing.assert_allclose(other.displacement, -one.displacement, rtol=0, atol=1e-15)
    assert other.relative_error == pytest.approx(one.relative_error, rel=1e-6)


def test_events_and_fixed_steps_agree():
    # a track on which the slider passes much of the pattern within few cycles
    scene = replace(SCENE, wavelength=2e-5, balls=(0.0, 6e-6))
    stepped, exact = (along(scene, 1000, method=method, tolerance=1e-4) for method in ("stepped", "exact"))
    assert exact.method == "exact"
    assert abs(stepped.displacement[-1]) > 0.05 * scene.wavelength
    difference = abs(stepped.velocity_at_burst_end - exact.velocity_at_burst_end)
    assert difference <= 2.0 * (stepped.answer.error + exact.answer.error)
    assert difference < 2e-3 * abs(exact.velocity_at_burst_end)


RISING = Envelope(time=[0.0, 3.31e-4, 7.77e-4], amplitude=[0.2, 0.7, 1.0], phase=[0.0, 0.4, 0.1])


@pytest.mark.parametrize("envelope", [None, RISING])
def test_a_uniform_track_changes_nothing(envelope):
    scene = replace(SCENE, wavelength=1e6, balls=(0.0,))
    options = {"tolerance": 1e-3, "samples": 300, "method": "stepped", "envelope": envelope}
    moved = along(scene, CYCLES, **options)
    still = burst(moved.slider, moved.orbits, duration=moved.duration, after=0.0, **options)
    np.testing.assert_allclose(moved.velocity, still.velocity, rtol=0, atol=1e-9 * abs(still.velocity).max())
    assert still.displacement is None
    assert moved.displacement[-1] == pytest.approx(np.trapezoid(still.velocity, still.time), rel=1e-2)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_motion_stops_where_the_track_ends(side):
    whole = along(SCENE, CYCLES, side=side)
    way = 0.5 * abs(whole.displacement[-1])
    cut = along(SCENE, CYCLES, (-way, way), side=side)
    assert cut.ended
    assert not whole.ended
    assert 0.97 * way < abs(cut.displacement[-1]) <= way
    assert cut.cycles < whole.cycles
    assert cut.time[-1] == cut.duration
    there = np.interp(cut.duration, whole.time, whole.velocity)
    assert cut.velocity_at_burst_end == pytest.approx(there, rel=5e-3)


def test_a_slide_after_the_burst_stops_there_too():
    free = along(SCENE, CYCLES, after=3e-4)
    at_end = np.interp(free.duration, free.time, free.displacement)
    way = 0.5 * (at_end + free.displacement[-1])
    cut = along(SCENE, CYCLES, (-way, way) if way > 0 else (way, -way), after=3e-4)
    assert cut.cycles == CYCLES
    assert cut.ended
    assert free.duration < cut.time[-1] < free.time[-1]
    assert abs(cut.displacement).max() <= abs(way)


def test_the_ring_down_follows_the_track():
    fading = Envelope(time=[0.0, 5e-4], amplitude=[1.0, 0.0], phase=[0.0, 0.0])
    one, other = (along(SCENE, 1000, side=side, after=(1e-3, fading)) for side in (1.0, -1.0))
    assert one.rang == pytest.approx(5e-4, rel=1e-3)
    np.testing.assert_allclose(other.displacement, -one.displacement, rtol=0, atol=1e-15)
    apart = one.displacement[-1] - np.trapezoid(one.velocity, one.time)
    assert abs(apart) < 0.02 * abs(one.displacement[-1])


def test_nodes_are_shared_and_checked():
    track = Track(amplitudes=SCENE.orbits_at, spacing=SCENE.wavelength / 32, limits=(-5e-3, 3e-3))
    at = np.array([-5e-3, -1.234e-3, 0.0, 2.99e-3])
    np.testing.assert_allclose(track.at(at), SCENE.orbits_at(at), rtol=0, atol=2e-5 * SCENE.amplitude)
    np.testing.assert_allclose(track.at(at[1:3]), SCENE.orbits_at(at[1:3]), rtol=0, atol=2e-6 * SCENE.amplitude)
    np.testing.assert_array_equal(track.scaled(2.0).at(at), 2.0 * track.at(at))
    with pytest.raises(InputError, match=r"track\.limits"):
        replace(track, limits=(0.0, 1e-3))
    with pytest.raises(InputError, match=r"track\.spacing"):
        replace(track, spacing=0.0)
