"""Contact-point histories: what the seed paper's Figs 6 and 7 show, and the laws at every instant."""

import numpy as np
import pytest

from contact import ConvergenceError, Orbit, contact_history, steady
from contact.answers import waveforms
from contact.averaged.event_equilibrium import balanced
from contact.law import elastic, normal
from contact.orbit import towards_plus
from contact.periodic import shooting
from contact.periodic.shooting import periodic
from tests.contact.motors import orbit, slider


def history(A, stage="steady", skip=0, cycles=2, points=200, **changed):
    return contact_history(slider(**changed), orbit(A), stage=stage, skip=skip, cycles=cycles, points_per_cycle=points)


@pytest.mark.parametrize("A", [3e-9, 10e-9])
@pytest.mark.parametrize("stage", ["start", "steady", "after"])
def test_forces_are_those_of_the_laws_at_every_instant(A, stage):
    s, h = slider(), history(A, stage)
    P = s.normal_stiffness * normal.load(h.approach, normal.SPHERE)
    friction = s.friction_coefficient * s.normal_stiffness
    Q = elastic.tangential_force(h.deformation, h.approach, friction, s.limit_slope, normal.SPHERE)
    assert h.normal_force == pytest.approx(P, rel=1e-9, abs=1e-9 * s.preload)
    assert h.tangential_force == pytest.approx(Q, rel=1e-6, abs=1e-6 * s.preload)  # square root at the slip limit


@pytest.mark.parametrize("A", [3e-9, 10e-9])
def test_regimes_mean_what_they_say(A):
    s, h = slider(), history(A, points=1000)
    friction = s.friction_coefficient * h.normal_force
    assert np.all(h.approach[h.regime == "separated"] <= 1e-15)
    assert np.all(h.normal_force[h.regime == "separated"] == 0.0)
    slip = h.regime == "slip"
    assert np.abs(h.tangential_force[slip]) == pytest.approx(friction[slip], rel=1e-12)
    assert np.all(np.abs(h.tangential_force) <= friction * (1.0 + 1e-12))
    dissipated = (h.tangential_force * (h.surface_velocity - h.slider_velocity[:, None]))[slip]
    assert np.mean(dissipated) > 0.0


def test_below_release_there_is_always_contact_and_above_it_is_intermittent():
    assert "separated" not in history(3e-9).regime
    assert set(np.unique(history(10e-9).regime)) == {"separated", "stick", "slip"}


def test_normal_force_is_largest_where_the_surface_moves_forward():
    # The paper on Fig 6(a): P has its maximum when v_t is positive; hence the mean traction drives
    h = history(3e-9, points=400)
    assert h.surface_velocity[np.argmax(h.normal_force)] > 0.0
    assert h.surface_velocity[np.argmin(h.normal_force)] < 0.0


def test_in_the_steady_state_cycles_repeat_and_the_mean_is_the_velocity():
    h = history(10e-9, cycles=2, points=100)
    for series in (h.approach, h.deformation, h.normal_force, h.tangential_force):
        assert series[100:] == pytest.approx(series[:100], rel=1e-7, abs=1e-9 * np.max(np.abs(series)))
    expected = steady(slider(), orbit(10e-9), tolerance=1e-8).velocity
    assert np.mean(h.slider_velocity[:100]) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("load", [0.0, 2e-5])
def test_a_held_slider_trembles_about_rest(load):
    """Property: steady states that velocity is 0; the wave shakes the slider, but its cycle mean is 0."""
    held = slider(load=load)
    assert steady(held, orbit(0.3e-9), tolerance=1e-6).velocity == 0.0
    h = history(0.3e-9, cycles=2, load=load)
    assert set(h.regime.ravel()) == {"stick"}
    trembling = abs(h.slider_velocity).max()
    assert trembling > 1e-9
    assert abs(np.mean(h.slider_velocity)) < 1e-6 * trembling


def test_after_the_wave_only_slip_remains_and_friction_is_constant_in_sign():
    # The paper on Fig 7(a): velocity difference, so slip with Q = mu P against the motion
    s, h = slider(), history(3e-9, "after", skip=20, cycles=200, points=1)
    assert np.all(h.regime == "slip")
    assert h.tangential_force == pytest.approx(-s.friction_coefficient * h.normal_force, rel=1e-12)
    assert np.all(h.surface_velocity == 0.0)


def test_the_ring_starts_at_the_slip_limit():
    # Closed form: stick begins at |x| = x_max; R_t = 0 and a bounce that has died
    changed = {"tangential_damping": 0.0, "normal_damping": 5.0}
    h = history(3e-9, "after", skip=0, cycles=60000, points=0.5, **changed)
    first = int(np.argmax(h.regime[:, 0] == "stick"))
    assert h.regime[first - 1, 0] == "slip"
    s = slider(**changed)
    limit = s.limit_slope * s.rest_approach(1)
    assert np.max(np.abs(h.deformation[first:])) == pytest.approx(limit, rel=1e-6)  # nearest sample


@pytest.mark.parametrize("A", [3e-9, 10e-9])
def test_mirrored_wave_mirrors_the_tangential_history(A):
    right = history(A)
    left = contact_history(slider(), orbit(A).mirrored(), stage="steady", skip=0, cycles=2, points_per_cycle=200)
    assert np.array_equal(left.deformation, -right.deformation)
    assert np.array_equal(left.tangential_force, -right.tangential_force)
    assert np.array_equal(left.slider_velocity, -right.slider_velocity)
    assert np.array_equal(left.approach, right.approach)


def test_start_begins_at_rest():
    h = history(3e-9, "start", points=2000, cycles=1)
    assert h.approach[0, 0] == pytest.approx(slider().rest_approach(1), rel=5e-3)  # half a thousandth of a cycle on
    assert abs(h.slider_velocity[0]) < 1e-9


def test_a_wave_without_normal_part_is_drawn_from_the_same_instant():
    # Independent: a wave with a very small normal part moves the slider the same way
    none, small = (
        contact_history(
            slider(), Orbit(frequency=2.2e6, normal=normal, tangential=-2e-9j), stage="steady", skip=0, cycles=1,
            points_per_cycle=100,
        )
        for normal in (0.0, 1e-16)
    )  # fmt: skip
    top = np.max(np.abs(small.tangential_force))
    assert none.tangential_force == pytest.approx(small.tangential_force, abs=1e-5 * top)
    assert none.surface_velocity == pytest.approx(small.surface_velocity, rel=1e-6, abs=1e-9)
    assert abs(np.mean(none.tangential_force)) < 1e-4 * top


def test_what_is_drawn_as_steady_is_the_motion_that_is_reached():
    # Light slider at f_n/f = 0.4: the motion that repeats every cycle is stable, but from rest it hops irregularly
    s = slider(mass=2e-6, preload=2e-4, normal_damping=1e-3, tangential_damping=1e-4)
    motion = orbit(10e-9, frequency=s.normal_resonance(1) / 0.4)
    h = contact_history(s, motion, stage="steady", skip=0, cycles=600, points_per_cycle=20)
    touched = np.max(h.normal_force.reshape(600, 20), axis=1) > 0.0
    assert 0.0 < np.mean(touched) < 0.9, "the periodic motion touches in every cycle"


def test_a_history_has_the_periodic_motion_that_shooting_finds_only_after_some_cycles():
    # Newton's method does not converge from the averaged equilibrium; the full motion is followed for 200 cycles first
    s = slider(
        radius=5.35e-7, mass=0.0258, load=1.46e-9, effective_modulus=1.969e10, tangential_modulus=3.69e9,
        reciprocal=True, contact_damping=1.069e5,
    )  # fmt: skip
    motion = Orbit(frequency=5094.0, normal=5e-9, tangential=1.375e-8 + 3.913e-8j)
    with pytest.raises(ConvergenceError):
        periodic(balanced(s, towards_plus((motion,))[1]), nodes=16, truncation=1e-12)
    h = contact_history(s, motion, stage="steady", skip=0, cycles=1, points_per_cycle=100)
    assert np.mean(h.slider_velocity) == pytest.approx(steady(s, motion, tolerance=1e-3).velocity, rel=1e-6)


@pytest.mark.parametrize("stage", ["start", "steady", "after"])
def test_a_history_states_the_error_of_its_velocities(stage):
    asked = {"stage": stage, "skip": 2.25, "cycles": 1.5, "points_per_cycle": 12}
    history = contact_history(slider(), orbit(3e-9), **asked)
    assert history.answer.value == history.slider_velocity[-1]
    assert (history.status, history.answer.message) == ("ok", f"stage {stage}")
    assert 0.0 < history.answer.error < 1e-9
    # the true error, of the same instants at a third order, is no more than twice as much
    other = contact_history_at(waveforms, asked, (14, 1e-11, 1.0, 1e-12))
    assert np.max(np.abs(other - history.slider_velocity)) <= 2.0 * history.answer.error


def contact_history_at(module, asked, order):
    """Return the slider's velocities at an order of one's own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "FINE", order)
        patch.setattr(shooting, "FINE", order)
        return contact_history(slider(), orbit(3e-9), **asked).slider_velocity
