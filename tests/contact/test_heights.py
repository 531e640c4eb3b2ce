"""Contacts at different heights: statics by hand, rows of springs, Greenwood and Williamson's sum, every door."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from contact import burst, contact_history, mean_motion, release_factor, riding_height, steady, step, threshold_factor
from contact.law import elastic
from tests.contact.motors import FREQUENCY, slider, steady_map
from tests.contact.test_punch import PUNCH, trio
from tests.oracles.contact_springs import velocity_from_rest
from tests.seed_motor import PRELOAD

HEIGHTS = (0.0, 1e-9, -2e-9)
APART = (0.0, -50e-9, 0.5e-9)  # the second never touches


def without_second(orbits):
    return orbits[0], orbits[2]


def test_two_punches_at_rest_by_hand():
    # K (h + h1) + K (h + h2) = preload, and K (h + h2) = preload where the first does not touch
    s = slider(heights=(-1e-9, 0.4e-9), **PUNCH)
    k = 2.0 * s.radius * s.effective_modulus
    assert s.rest_approach(2) == pytest.approx((s.preload / k + 0.6e-9) / 2.0, rel=1e-13)
    s = slider(heights=(-5e-9, 0.4e-9), **PUNCH)
    assert s.rest_approach(2) == pytest.approx(s.preload / k - 0.4e-9, rel=1e-13)
    assert s.normal_resonance(2) == pytest.approx(np.sqrt(k / s.mass) / (2.0 * np.pi), rel=1e-13)


@pytest.mark.parametrize("shape", [{}, PUNCH])
def test_contacts_at_rest_carry_preload_and_load(shape):
    # The load: by the tangential law of each contact at the common displacement, found by root finding
    s = slider(heights=HEIGHTS, load=0.6 * 0.08 * PRELOAD, **shape)
    z, c = s.rest_approaches(3), s.limit_slope
    friction, kind = s.friction_coefficient * s.normal_stiffness, s.profile

    def carried(x):
        return sum(elastic.tangential_force(x, a, friction, c, kind) for a in z)

    common = brentq(lambda x: carried(x) - s.load, 0.0, c * np.max(z), xtol=1e-24, rtol=1e-14)
    assert s.rest_deformations(3) == pytest.approx(np.minimum(common, c * z), rel=1e-10)
    assert carried(c * np.max(z)) == pytest.approx(s.friction_coefficient * s.preload, rel=1e-13)


def test_a_common_height_shifts_the_slider_and_nothing_else():
    plain = steady(slider(), trio(5e-9), tolerance=1e-6)
    raised = steady(slider(heights=(3e-9,) * 3), trio(5e-9), tolerance=1e-6)
    assert raised.velocity == pytest.approx(plain.velocity, rel=1e-9)
    assert raised.height == pytest.approx(plain.height - 3e-9, rel=1e-8)
    assert raised.regime == plain.regime


@pytest.mark.parametrize("changed", [{}, PUNCH, {"reciprocal": True}, {"law": "hysteretic"}])
def test_a_contact_that_never_touches_carries_nothing(changed):
    three, two = slider(heights=APART, **changed), slider(heights=APART[::2], **changed)
    found, expected = (
        steady(three, trio(5e-9), tolerance=1e-6), steady(two, without_second(trio(5e-9)), tolerance=1e-6)
    )  # fmt: skip
    assert found.velocity == pytest.approx(expected.velocity, rel=1e-8)
    assert (found.regime, found.status) == (expected.regime, "ok")
    h = contact_history(three, trio(5e-9), stage="steady", skip=0, cycles=1, points_per_cycle=50)
    assert np.all(h.normal_force[:, 1] == 0.0)
    assert np.all(h.approach[:, 1] < 0.0)
    assert set(h.regime[:, 1]) == {"separated"}


@pytest.mark.parametrize("method", ["exact", "stepped", "averaged"])
def test_a_burst_passes_over_a_contact_that_never_touches(method):
    found, expected = (
        burst(s, o, duration=1e-4, after=1e-4, tolerance=1e-5, samples=8, method=method)
        for s, o in (
            (slider(heights=APART), trio(5e-9)), (slider(heights=APART[::2]), without_second(trio(5e-9)))
        )
    )  # fmt: skip
    assert found.velocity == pytest.approx(expected.velocity, rel=1e-6, abs=1e-12)
    # a turning point of the position is as exact as the whole path, not as its own small value
    path = np.max(np.abs(expected.position))
    assert found.position == pytest.approx(expected.position, rel=1e-6, abs=1e-8 * path)


def test_a_step_ends_though_a_contact_never_touches():
    found, expected = (
        step(s, o, cycles=40)
        for s, o in (
            (slider(heights=APART), trio(5e-9)), (slider(heights=APART[::2]), without_second(trio(5e-9)))
        )
    )  # fmt: skip
    assert found.displacement == pytest.approx(expected.displacement, rel=1e-6)


@pytest.mark.parametrize("changed", [{"law": "hysteretic"}, PUNCH])
def test_contacts_of_different_height_move_as_rows_of_springs_do(changed):
    s, cycles = slider(heights=HEIGHTS, **changed), 40
    found = burst(s, trio(15e-9), duration=cycles / FREQUENCY, after=0.0, tolerance=1e-6, samples=2)
    punch = s.shape == "punch"
    springs = velocity_from_rest(
        [-1j * o.normal for o in trio(15e-9)], [-1j * o.tangential for o in trio(15e-9)], FREQUENCY, cycles=cycles,
        per_cycle=6400 if punch else 400, springs=1 if punch else 400, heights=HEIGHTS,
        slider={
            "radius": s.radius, "E": s.effective_modulus, "G": s.tangential_modulus, "mu": s.friction_coefficient,
            "mass": s.mass, "preload": s.preload, "load": 0.0, "normal_damping": s.normal_damping,
            "tangential_damping": s.tangential_damping, "chi": s.contact_damping, "punch": punch,
        },
    )  # fmt: skip
    assert found.status == "ok"
    assert found.velocity_at_burst_end == pytest.approx(springs, rel=1e-5 if punch else 1.5e-4)


@pytest.mark.parametrize(("shape", "power"), [({}, 1.5), (PUNCH, 1.0)])
def test_the_force_follows_greenwood_and_williamson_to_one_over_root_n(shape, power):
    # P(d)/n K = int max(d + s t, 0)^a phi(t) dt (Greenwood and Williamson, Proc. R. Soc. A 295 (1966) 300)
    spread, approach, rng = 4e-9, 1e-9, np.random.default_rng(3)
    density = quad(
        lambda t: (approach + spread * t) ** power * np.exp(-0.5 * t * t), -approach / spread, 12.0, epsrel=1e-10
    )[0] / np.sqrt(2.0 * np.pi)  # fmt: skip

    def scatter(n):
        """Return the root mean square of the relative deviation over some sets of heights."""
        found = []
        for _ in range(100):
            s = slider(heights=tuple(spread * rng.standard_normal(n)), **shape)
            force = n * s.normal_stiffness * density
            # the force at the approach, from the approach under the force that the sum predicts
            slope = (s.approach_under(1.001 * force, n) - s.approach_under(force, n)) / (1e-3 * force)
            found.append((approach - s.approach_under(force, n)) / slope / force)
        return np.sqrt(np.mean(np.square(found)))

    few, many = scatter(50), scatter(800)
    assert few / many == pytest.approx(4.0, rel=0.25)
    # one contact's own scatter over root n
    square = quad(
        lambda t: (approach + spread * t) ** (2.0 * power) * np.exp(-0.5 * t * t), -approach / spread, 12.0,
        epsrel=1e-10,
    )[0] / np.sqrt(2.0 * np.pi)  # fmt: skip
    assert many == pytest.approx(np.sqrt((square / density**2 - 1.0) / 800.0), rel=0.2)


def test_riding_on_a_wave_the_mean_force_is_the_preload():
    s, orbits = slider(heights=HEIGHTS, preload=3e-3), trio(5e-9)
    h, phase = riding_height(s, orbits), 2.0 * np.pi * np.arange(20_000) / 20_000
    z = [h + up + (o.normal * np.exp(1j * phase)).real for up, o in zip(HEIGHTS, orbits, strict=True)]
    force = s.normal_stiffness * sum(np.mean(np.maximum(each, 0.0) ** 1.5) for each in z)
    assert force == pytest.approx(s.preload, rel=1e-9)
    factor = release_factor(s, orbits)
    scaled = tuple(o.scaled(factor) for o in orbits)
    left = riding_height(s, scaled) + np.array(HEIGHTS) - np.array([abs(o.normal) for o in scaled])
    # riding still through the cycle is of first order: (f_n/f)^2 of the approach
    ratio = s.normal_resonance(3) / orbits[0].frequency
    assert np.min(left) == pytest.approx(0.0, abs=ratio**2 * s.rest_approach(3))


@pytest.mark.parametrize("heights", [HEIGHTS, ()])
def test_the_threshold_is_where_the_averaged_slider_starts(heights):
    # The two solvers share no integration: events on interpolants, and closed events of a given path
    s = slider(heights=heights)
    factor = threshold_factor(s, trio(5e-9))
    held = [mean_motion(s, tuple(o.scaled(k * factor) for o in trio(5e-9))).first_order == 0.0 for k in (0.999, 1.001)]
    assert held == [True, False]


def test_every_door_has_the_same_steady_state():
    s = slider(heights=HEIGHTS, load=1e-5)
    mean = mean_motion(s, trio(5e-9))
    found = steady(s, trio(5e-9), tolerance=1e-6)
    assert found.velocity == pytest.approx(mean.velocity, rel=1e-8)
    assert found.ledger.relative_residual < 1e-8
    mapped = steady_map(s, trio(5e-9), factors=np.ones(1), preloads=np.array([s.preload]))
    assert mapped.velocity[0, 0] == mean.velocity


def test_heights_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match=r"slider\.heights must hold one height per contact, 3, got 2"):
        steady(slider(heights=(0.0, 1e-9)), trio(5e-9), tolerance=1e-6)
    with pytest.raises(ValueError, match=r"slider\.heights must be finite"):
        slider(heights=(0.0, float("nan")))
    with pytest.raises(ValueError, match=r"slider\.heights must be a list"):
        slider(heights=1e-9)
