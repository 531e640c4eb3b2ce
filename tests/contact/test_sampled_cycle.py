"""Contacts in the plane over one cycle: against the line, against fixed steps, and against the load they balance."""

import math

import numpy as np
import pytest

from contact import ConvergenceError, InputError, Orbit, contact_history
from contact.plane import SurfaceWaves, contact_cycle, steady
from tests.contact.plane_motors import MU, R_X, F, ball, beams, drawn

LINE = {"radius": 1e-3, "preload": F, "freedom": "x"}


@pytest.mark.parametrize(("amplitude", "load"), [(3, 0.0), (10, 1e-6)], ids=["never opens", "opens"])
def test_along_x_it_is_the_history_of_a_heavy_slider(amplitude, load):
    orbit = Orbit(frequency=2.2e6, tangential=-1j * R_X * amplitude * 1e-9, normal=amplitude * 1e-9)
    heavy = ball(**LINE, mass=8.9e-3, load=load)  # the history differs by 1e-7, as 1/mass
    line = contact_history(heavy, orbit, stage="steady", skip=0, cycles=1, points_per_cycle=200)
    cycle = contact_cycle(ball(**LINE, load=load), beams(amplitude, 0), points_per_cycle=200)
    assert np.abs(line.time - cycle.time).max() < 1e-20
    assert np.array_equal(line.regime, cycle.regime)
    for found, expected in (
        (cycle.approach, line.approach),
        (cycle.deformation[..., 0], line.deformation),
        (cycle.normal_force, line.normal_force),
        (cycle.tangential_force[..., 0], line.tangential_force),
        (cycle.surface_velocity[..., 0], line.surface_velocity),
    ):
        assert np.abs(found - expected).max() < 2e-7 * np.abs(expected).max()
    assert np.abs(cycle.deformation[..., 1]).max() < 1e-12 * cycle.limit.max()


@pytest.mark.parametrize(
    "waves", [beams(10, 10, math.pi / 2), beams(4, 10, 0.3, (2.2e6, 1.65e6)), beams(2, 2, 1.0)],
    ids=["crossed", "two frequencies", "never opens"],
)  # fmt: skip
def test_its_deformation_is_that_of_fixed_steps_with_projection(waves):
    """Moreau's catching-up scheme on the closed forms of approach and surface speed, of first order in the step."""
    slider = ball(load=(0.01 * MU * F, 0.0))
    steps, periods = 8000, 1 if waves.frequencies.size == 1 else 4
    cycle = contact_cycle(slider, waves, points_per_cycle=steps)
    t = cycle.time
    turning = np.exp(2j * np.pi * waves.frequencies * (t[:, None] + _begin(waves)))
    u = (turning @ waves.amplitudes[:, 0]).real
    assert np.abs(cycle.displacement[:, 0] - u).max() < 1e-12 * np.abs(u).max()
    lift = np.mean(cycle.approach[:, 0])  # u_z has no mean
    assert np.abs(cycle.approach[:, 0] - (u[:, 2] + lift)).max() < 1e-12 * np.abs(u).max()
    step = u[:, :2] - np.roll(u[:, :2], 1, axis=0) - cycle.velocity * t[0]
    limit = (
        cycle.limit[0, 0] / cycle.approach[0, 0] if cycle.approach[0, 0] > 0 else (cycle.limit / cycle.approach).max()
    )
    e, found = np.zeros(2), np.zeros((len(t), 2))
    for _ in range(12):  # of a contact that never opens some cycles are needed
        for k in range(len(t)):
            e = e + step[k]
            size, most = math.hypot(*e), limit * max(u[k, 2] + lift, 0.0)
            e = e * (most / size) if size > most else e
            found[k] = e
    assert np.abs(found - cycle.deformation[:, 0]).max() < 4e-3 * np.abs(found).max()
    assert len(t) == steps * periods


def _begin(waves):
    """Return the time at which u_z of the fastest wave crosses zero upwards."""
    fastest = np.argmax(waves.frequencies)
    phase = (-0.5 * np.pi - np.angle(waves.amplitudes[fastest, 0, 2])) % (2.0 * np.pi)
    return phase / (2.0 * np.pi * waves.frequencies[fastest])


@pytest.mark.parametrize("seed", [seed for seed in range(12) if seed not in (3, 9)])  # those two are held
def test_its_mean_force_is_the_load_it_balances_within_twice_the_error(seed):
    slider, waves = drawn(seed)[:2]
    cycle = contact_cycle(slider, waves, points_per_cycle=400)
    state = steady(slider, waves, tolerance=1e-6, method="averaged")
    assert np.abs(cycle.velocity - state.velocity).max() <= 2e-6 * state.reference
    assert cycle.yaw_rate == pytest.approx(state.yaw_rate, abs=1e-6 * abs(state.yaw_rate))
    friction = slider.friction_coefficient * slider.preload
    if slider.freedom != "axle":
        balance = np.array(slider.load) + slider.tangential_damping * cycle.velocity
        assert (np.abs(cycle.mean_force - balance) <= 2.0 * cycle.force_error).all()
        assert (cycle.force_error < 1e-4 * friction).all()
    mean = cycle.tangential_force.sum(axis=1).mean(axis=0)
    assert np.abs(mean - cycle.mean_force).max() < 2e-3 * friction  # 400 points
    assert cycle.normal_force.sum(axis=1).mean() == pytest.approx(slider.preload, rel=2e-3)
    size = np.linalg.norm(cycle.deformation, axis=2)
    assert (size <= cycle.limit * (1.0 + 1e-9)).all()
    slips = cycle.regime == "slip"
    assert np.abs(size - cycle.limit)[slips].max(initial=0.0) < 1e-9 * cycle.limit.max()
    assert np.array_equal(cycle.regime == "separated", cycle.approach <= 0.0)
    full = slider.friction_coefficient * cycle.normal_force
    assert np.linalg.norm(cycle.tangential_force, axis=2)[slips] == pytest.approx(full[slips], rel=1e-9)


def test_a_slider_at_rest_and_bad_parameters_are_refused():
    with pytest.raises(ConvergenceError, match="not applicable: friction holds the slider"):
        contact_cycle(ball(), beams(0.1, 0.1), points_per_cycle=8)
    with pytest.raises(InputError, match="points_per_cycle"):
        contact_cycle(ball(), beams(10, 10), points_per_cycle=0)
    with pytest.raises(InputError, match="hysteretic law has one direction"):
        contact_cycle(ball(law="hysteretic"), beams(10, 10), points_per_cycle=8)
    with pytest.raises(InputError, match="amplitudes"):
        contact_cycle(ball(), SurfaceWaves(frequencies=[2.2e6], amplitudes=[[[1e-9]]]), points_per_cycle=8)
