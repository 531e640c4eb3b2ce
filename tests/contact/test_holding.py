"""Balls of JKR and Maugis in time: event by event and in fixed steps, against an own integrator."""

import math
from dataclasses import replace

import numpy as np
import pytest

from contact import (
    Adhesion,
    AdhesiveBalls,
    AdhesiveSphere,
    InputError,
    Orbit,
    TabulatedForce,
    burst,
    load_line,
    mean_motion,
    release_factor,
    releases,
    riding_height,
    steady,
    threshold_factor,
)
from contact.averaged.event_equilibrium import balanced, trough
from contact.law import holding
from contact.law.maugis import MaugisSphere
from contact.orbit import as_orbits
from contact.periodic.shooting import fine_periodic
from contact.stepping import end_corrections
from tests.contact.motors import HEAVY, orbit, slider
from tests.oracles.contact_hold import LENGTH, TRAVEL, DugdaleBall, HoldingBall, Integration

WORK, PRELOAD = 0.05, 0.87309e-3
WAVE = 2.0 * math.pi * 2.2e6  # rad/s
# They open at a fold and close beyond it; the third opens as a point and closes beyond it, the last does both as a
# point. One set of kernels serves all.
RANGES = (None, 3e-10, 1.3e-9, 3e-9)


def ball(work=WORK, separation=None, **changed):
    """Return a ball of Maugis with a separation of the surfaces; of JKR without one."""
    model = "JKR" if separation is None else "Maugis"
    adhesion = Adhesion(model=model, work=work, separation=separation)
    return slider(**({"preload": PRELOAD, "adhesion": adhesion} | changed))


def same(body, wave, start=0.0) -> HoldingBall:
    """Return the ball for the oracle, with the wave at an angle at phase 0."""
    turn = complex(math.cos(start), math.sin(start))
    own = {
        "radius": body.radius, "modulus": body.effective_modulus, "tangential_modulus": body.tangential_modulus,
        "work": body.adhesion.work, "mu": body.friction_coefficient, "mass": body.mass, "preload": body.preload,
        "frequency": wave.frequency, "normal": wave.normal * turn, "tangential": wave.tangential * turn,
        "normal_damping": body.normal_damping, "tangential_damping": body.tangential_damping, "load": body.load,
    }  # fmt: skip
    if body.adhesion.model == "Maugis":
        return DugdaleBall(separation=body.adhesion.separation, **own)
    return HoldingBall(**own)


def known_means(body, wave, tolerance):
    """Return the heavy slider's motion by Gauss's points."""
    own = body.adhesion
    given = {} if own.separation is None else {"separation": own.separation}
    balls = AdhesiveBalls(replace(body, adhesion=None), work=own.work, model=own.model, **given)
    return balls.motion(wave, tolerance=tolerance)


@pytest.mark.parametrize("root", [1e-9, 1e-3, 0.1, 0.5, 10.0])
def test_depths_are_those_of_the_sphere(root):
    """Forwards z = d - S d^(1/4), and its inverse from the end of the contact on."""
    hold = holding.jkr(root)
    end = (0.25 * root) ** (4.0 / 3.0)
    assert hold.leave == pytest.approx(end - root * end**0.25, rel=1e-13)
    for d in end * np.geomspace(1.0 + 1e-4, 1e6, 12):
        z = d - root * d**0.25
        if z - hold.leave < 1e3 * holding.ROUNDING:
            continue
        rate = float(holding.depth_rate(d, hold))
        assert float(holding.depth(z, hold)) == pytest.approx(d, abs=1e-14 * d + 1e-15 * rate * (abs(z) + end))
        steps = [float(holding.work(each, hold)) for each in (d * (1.0 - 1e-5), d * (1.0 + 1e-5))]
        moved = [each - root * each**0.25 for each in (d * (1.0 - 1e-5), d * (1.0 + 1e-5))]
        force = d**1.5 - float(holding.attraction(d, 0.0, hold))
        assert (steps[1] - steps[0]) == pytest.approx(force * (moved[1] - moved[0]), abs=1e-9 * d**2.5)


def test_force_stiffness_and_loss_are_those_of_the_sphere():
    sphere = AdhesiveSphere(radius=1e-3, modulus=64e9, work=WORK, model="JKR")
    body = ball()
    hold, unit = body.profile.hold, body.stiffness_unit
    a = sphere.radius_under(PRELOAD)
    assert body.rest_approach(1) == pytest.approx(float(sphere.approach(a)), rel=1e-12)
    assert body.depth_under(PRELOAD, 1) == pytest.approx(a**2 / 1e-3, rel=1e-12)
    assert unit * holding.stiffness(a**2 / 1e-3, hold) == pytest.approx(float(sphere.stiffness(a)), rel=1e-12)
    assert body.normal_resonance(1) == pytest.approx(
        math.sqrt(float(sphere.stiffness(a)) / body.mass) / (2.0 * math.pi), rel=1e-12
    )
    assert unit * holding.stored(hold.end**4, hold) == pytest.approx(sphere.loss, rel=1e-12)
    assert hold.leave == pytest.approx(sphere.break_approach, rel=1e-12)
    friction = 0.08 * 4.0 / 3.0 * 64e9 * a**3 / 1e-3
    assert body.static_friction(1) == pytest.approx(friction, rel=1e-12)
    # the pressure in the middle of a contact of these authors
    middle = 2.0 * 64e9 * a / (math.pi * 1e-3) - math.sqrt(2.0 * WORK * 64e9 / (math.pi * a))
    assert float(body.pressure(body.rest_approach(1))) == pytest.approx(middle, rel=1e-10)


@pytest.mark.parametrize("separation", RANGES[1:])
def test_a_slider_at_rest_on_maugis_s_ball_is_that_of_the_sphere(separation):
    body, sphere = (
        ball(separation=separation),
        MaugisSphere(radius=1e-3, modulus=64e9, work=WORK, separation=separation),
    )
    a, z = sphere.radius_under(PRELOAD), sphere.approach_under(PRELOAD)
    assert body.rest_approach(1) == pytest.approx(z, rel=1e-12)
    low, high = (float(sphere.closed(z + each)[1]) for each in (-1e-13, 1e-13))
    assert body.normal_resonance(1) == pytest.approx(
        math.sqrt((high - low) / 2e-13 / body.mass) / (2.0 * math.pi), rel=1e-7
    )
    assert body.static_friction(1) == pytest.approx(0.08 * 4.0 / 3.0 * 64e9 * a**3 / 1e-3, rel=1e-11)
    # the pressure in the middle: Maugis (1992), equation 7 at r = 0
    c = math.sqrt(a**2 + ((a**2 / 1e-3 - z) * 64e9 / (2.0 * sphere.traction)) ** 2)
    middle = 2.0 * 64e9 * a / (math.pi * 1e-3) - 2.0 * sphere.traction / math.pi * math.acos(a / c)
    assert float(body.pressure(z)) == pytest.approx(middle, rel=1e-9)


@pytest.mark.parametrize(
    ("u", "load", "separation"),
    [
        *((u, load, None) for u in (3e-9, 10e-9, 20e-9) for load in (0.0, 2e-5)),
        *((u, load, each) for u, load in ((10e-9, 0.0), (20e-9, 2e-5)) for each in RANGES[1:]),
        (10e-9, 6.5e-5, None),  # moves it back
    ],
)
def test_a_heavy_slider_has_the_averaged_motion(u, load, separation):
    """Cycle means from event to event, and by Gauss's points between closing and opening."""
    body = ball(load=load, tangential_damping=1e-3, separation=separation)
    found = steady(body, orbit(u), tolerance=1e-3, method="averaged")
    known = known_means(body, orbit(u), 1e-5)
    assert found.velocity == pytest.approx(known.velocity.value, abs=2.0 * known.velocity.error)
    assert found.height == pytest.approx(known.height, rel=1e-10)
    assert found.regime == known.regime
    assert found.ledger.relative_residual < 1e-10
    cycle = 1.0 / orbit(u).frequency
    assert found.ledger.wave_normal == pytest.approx(known.normal_power * cycle, abs=1e-10 * found.ledger.wave)
    assert found.ledger.adhesion >= known.lost_power * cycle * (1.0 - 1e-12)
    assert found.ledger.adhesion == pytest.approx(known.lost_power * cycle, rel=1e-2)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("u", "load"), [(1.0e-9, 2e-6), (3e-9, 2e-6), (3e-9, 6e-5), (1.5e-9, 6e-5)])
@pytest.mark.parametrize("separation", RANGES[:2])
def test_without_work_a_loaded_slider_moves_as_on_a_smooth_ball(u, load, side, separation):
    """Below and above what friction holds, forward and back, by cycle means and by the full equations."""
    body, wave = ball(1e-18, separation, load=load), Orbit(frequency=2.2e6, normal=u, tangential=-0.7j * u * side)
    assert body.profile.hold is not None
    for method, close in (("averaged", 1e-4), ("exact", 1e-8)):  # the first to its steps, the second to sqrt(work)
        found, known = (
            steady(each, wave, tolerance=1e-4, method=method) for each in (body, replace(body, adhesion=None))
        )
        assert found.velocity == pytest.approx(known.velocity, abs=close * max(abs(known.velocity), 0.07 * WAVE * u))
        assert found.regime == known.regime


def test_heavier_sliders_come_to_the_averaged_motion():
    """The exact motion differs by (f_n/f)^2 in the velocity, which falls with the mass."""
    mean = float(mean_motion(ball(), orbit(10e-9)).velocity)
    gaps = [
        abs(steady(ball(mass=mass * 89e-6), orbit(10e-9), tolerance=1e-7, method="exact").velocity / mean - 1.0)
        for mass in (1.0, 10.0)
    ]
    assert gaps[0] < 1e-5
    assert gaps[1] == pytest.approx(0.1 * gaps[0], rel=0.3)


@pytest.mark.parametrize(("work", "separation"), [(0.02, None), (0.144, None), *((0.05, each) for each in RANGES[1:])])
def test_a_periodic_motion_with_hops_is_one_of_an_integration_in_time(work, separation):
    """The state returns, with the same mean velocity and energies, by DOP853 from event to event."""
    body, wave = ball(work, separation), orbit(12e-9, 0.67)
    listed = as_orbits([wave])
    found = fine_periodic(balanced(body, listed))
    problem, units = found.motion.problem, np.array([1.0, found.motion.problem.omega, found.motion.problem.omega, 1.0])
    start = found.state * problem.length * units
    run = Integration(same(body, wave, trough(listed)), start, closed=False, tolerance=1e-11)
    run.until(2.0 * math.pi)
    assert run.hops == 1
    assert np.all(np.abs(run.state - start) <= 1e-9 * problem.length * units)
    speed = run.y[TRAVEL] * LENGTH * run.ball.omega / (2.0 * math.pi)
    assert speed == pytest.approx(found.speed * problem.speed, rel=1e-9)
    state = steady(body, wave, tolerance=1e-9, method="exact")
    books = state.ledger
    normal, tangential, slip, _ = run.energies
    assert normal == pytest.approx(books.wave_normal, rel=1e-7, abs=1e-10 * books.wave)
    # 1e-6 between tolerances of 1e-9 and 1e-12: events lie on the integrator's dense output
    assert tangential == pytest.approx(books.wave_tangential, rel=5e-6)
    assert slip == pytest.approx(books.slip, rel=1e-7)
    given = {"radius": 1e-3, "modulus": 64e9, "work": work}
    sphere = (
        AdhesiveSphere(model="JKR", **given) if separation is None else MaugisSphere(separation=separation, **given)
    )
    assert books.adhesion == pytest.approx(sphere.loss + run.lost, rel=1e-9, abs=1e-40)
    assert books.relative_residual < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("separation", RANGES)
def test_a_start_from_rest_is_that_of_an_integration_in_time(separation):
    """Six cycles of a hopping ball, event by event and in fixed steps, within the stated errors."""
    body, wave = ball(separation=separation), orbit(14e-9)
    cycles = 6.0 / wave.frequency
    begin = [-body.rest_approach(1), 0.0, 0.0, 0.0]
    upward = math.pi * 1.5 - float(np.angle(wave.normal))
    run = Integration(same(body, wave, upward), begin, closed=True, tolerance=1e-11)
    run.until(12.0 * math.pi)
    assert run.hops >= 4
    exact = burst(body, wave, duration=cycles, after=0.0, tolerance=1e-9, samples=2, method="exact")
    reference = max(abs(exact.velocity_at_burst_end), 0.1 * wave.omega * abs(wave.tangential))
    assert abs(exact.velocity_at_burst_end - run.state[2]) < 1e-10 * reference
    assert exact.ledger.relative_residual < 1e-10
    for tolerance in (1e-3, 1e-5):
        stepped = burst(body, wave, duration=cycles, after=0.0, tolerance=tolerance, samples=2, method="stepped")
        assert stepped.status == "ok"
        error = abs(stepped.velocity_at_burst_end - run.state[2]) / reference
        assert error < 2.0 * stepped.relative_error + 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("u", [5e-9, 10e-9])
@pytest.mark.parametrize("separation", RANGES)
def test_a_longer_burst_in_steps_is_the_exact_one(u, separation):
    body, wave = ball(separation=separation), orbit(u)
    options = {"duration": 2e-4, "after": 0.0, "samples": 4}
    exact = burst(body, wave, tolerance=1e-9, method="exact", **options)
    assert exact.ledger.relative_residual < 1e-10
    reference = max(abs(exact.velocity[-1]), 0.1 * wave.omega * abs(wave.tangential))
    for tolerance in (1e-3, 1e-5):
        stepped = burst(body, wave, tolerance=tolerance, method="stepped", **options)
        errors = np.abs(stepped.velocity - exact.velocity) / reference
        assert float(np.max(errors)) < min(2.0 * stepped.relative_error + 1e-9, tolerance)


@pytest.mark.parametrize("u", [3e-9, 10e-9])
def test_without_work_maugis_is_hertz(u):
    """The first order in the work is the work itself, as the contact closes and opens as a point."""
    smooth = steady(slider(preload=PRELOAD), orbit(u), tolerance=1e-8, method="exact")
    for work, close in ((1e-24, 1e-15), (1e-10, 1e-8), (1e-8, 1e-6), (1e-6, 1e-4)):
        found = steady(ball(work, 3e-10), orbit(u), tolerance=1e-8, method="exact")
        assert found.velocity == pytest.approx(smooth.velocity, rel=close)
        assert found.height == pytest.approx(smooth.height, rel=max(close, 1e-8))
        assert found.ledger.relative_residual < 1e-10


@pytest.mark.parametrize("u", [3e-9, 10e-9])
def test_a_short_range_is_jkr_and_a_long_one_dmt(u):
    """The first order is 1/lambda on one side, and the root of lambda on the other."""
    known = {model: slider(preload=PRELOAD, adhesion=Adhesion(model=model, work=WORK)) for model in ("JKR", "DMT")}
    jkr, dmt = (steady(known[model], orbit(u), tolerance=1e-7, method="exact").velocity for model in ("JKR", "DMT"))
    near, far = (
        steady(ball(separation=each), orbit(u), tolerance=1e-7, method="exact").velocity for each in (1e-13, 1e-5)
    )
    assert near == pytest.approx(jkr, rel=1e-5)
    assert far == pytest.approx(dmt, rel=1e-2)


@pytest.mark.parametrize("u", [3e-9, 10e-9])
def test_without_work_it_is_hertz(u):
    """The first order in the work is its root: 2e-9 at 1e-18 J/m^2, and none where the branches are one in rounding."""
    smooth = steady(slider(preload=PRELOAD), orbit(u), tolerance=1e-8, method="exact")
    for work, close in ((1e-24, 1e-15), (1e-18, 4e-9), (1e-16, 4e-8), (1e-14, 4e-7)):
        found = steady(ball(work), orbit(u), tolerance=1e-8, method="exact")
        assert found.velocity == pytest.approx(smooth.velocity, rel=close)
        assert found.height == pytest.approx(smooth.height, rel=max(close, 1e-8))
        assert found.ledger.relative_residual < 1e-10


def test_three_unlike_balls_share_one_height():
    waves = (orbit(10e-9), orbit(9e-9), orbit(7e-9))
    turned = Orbit(frequency=waves[2].frequency, normal=1j * waves[2].normal, tangential=1j * waves[2].tangential)
    waves = (*waves[:2], turned)
    body = ball(preload=3.0 * PRELOAD, mass=3.0 * 89e-6)
    found = steady(body, waves, tolerance=1e-8, method="exact")
    assert found.velocity == pytest.approx(float(mean_motion(body, waves).velocity), rel=1e-5)
    assert found.height == pytest.approx(riding_height(body, waves), rel=1e-4)
    assert found.ledger.relative_residual < 1e-10
    assert found.statistics["release"] == 3
    each = releases(body, tuple(wave.scaled(0.1) for wave in waves))
    factors = [one.value for one in each]
    assert factors == sorted(factors)
    assert factors[0] == pytest.approx(release_factor(body, tuple(wave.scaled(0.1) for wave in waves)), rel=1e-9)


def test_equal_balls_are_one_with_its_part():
    one = steady(ball(), orbit(10e-9), tolerance=1e-8, method="exact")
    two = ball(preload=2.0 * PRELOAD, mass=2.0 * 89e-6, normal_damping=1.0, tangential_damping=2e-4)
    single = ball(normal_damping=0.5, tangential_damping=1e-4)
    found = steady(two, (orbit(10e-9),) * 2, tolerance=1e-8, method="exact")
    assert found.velocity == pytest.approx(
        steady(single, orbit(10e-9), tolerance=1e-8, method="exact").velocity, rel=1e-9
    )
    assert found.ledger.adhesion == pytest.approx(2.0 * one.ledger.adhesion, rel=1e-4)


def test_any_phase_and_the_mirror_image_are_the_same_motion():
    wave = orbit(10e-9)
    turned = Orbit(frequency=wave.frequency, normal=1j * wave.normal, tangential=1j * wave.tangential)
    mirrored = Orbit(frequency=wave.frequency, normal=wave.normal, tangential=-wave.tangential)
    one, other, back = (
        steady(ball(), each, tolerance=1e-8, method="exact").velocity for each in (wave, turned, mirrored)
    )
    assert one == pytest.approx(other, rel=1e-9)
    assert one == pytest.approx(-back, rel=1e-9)


@pytest.mark.parametrize("separation", RANGES)
def test_threshold_and_release_are_those_of_the_motion(separation):
    body = ball(separation=separation)
    start, leave = threshold_factor(body, orbit(1e-9)), release_factor(body, orbit(1e-9))
    if separation is None:
        assert leave == pytest.approx(5.6963, rel=1e-4)  # of an independent program
    states = [
        steady(body, orbit(factor * 1e-9), tolerance=1e-4, method="exact")
        for factor in (0.99 * start, 1.01 * start, 0.999 * leave, 1.001 * leave)
    ]
    assert [each.regime for each in states] == ["stick", "slip", "slip", "intermittent"]
    assert [each.ledger.adhesion > 0.0 for each in states] == [False, False, False, separation != RANGES[-1]]


@pytest.mark.parametrize("separation", RANGES[:2])
def test_a_load_line_ends_at_the_stall(separation):
    line = load_line(ball(separation=separation), orbit(10e-9), points=3, tolerance=1e-4)
    assert line.status == "ok"
    assert np.all(np.diff(line.velocity) < 0.0)
    loaded = ball(separation=separation, load=0.999 * line.blocked_thrust)
    near = steady(loaded, orbit(10e-9), tolerance=1e-6, method="exact").velocity
    assert 0.0 < near < 0.02 * line.velocity[0]


def test_a_slider_at_rest_under_a_load_keeps_it():
    """A load of half the friction deforms the spring of a contact at rest, without a wave."""
    body = ball()
    held = replace(body, load=0.5 * body.static_friction(1))
    (x,) = held.rest_deformations(1)
    assert held.tangential_force(x, held.rest_approach(1)) == pytest.approx(held.load, rel=1e-12)
    still = burst(held, orbit(1e-15), duration=1e-5, after=0.0, tolerance=1e-6, samples=2, method="exact")
    assert abs(still.velocity_at_burst_end) < 1e-9


@pytest.mark.parametrize("theta", [0.0, 0.3, 1.0])
def test_hurwitz_zeta_of_one_half(theta):
    """By the sum and the midpoint rule for its rest, from 4000 terms on."""
    number = 4000
    k = np.arange(number) + theta
    end = number + theta - 0.5
    known = np.sum(np.sqrt(k)) - end**1.5 / 1.5 + 1.0 / (48.0 * math.sqrt(end))
    assert end_corrections.zeta_one_half(theta) == pytest.approx(known, abs=1e-8)
    assert end_corrections.zeta_one_half(1.0) == pytest.approx(-0.2078862249773546, abs=1e-8)


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"stick_band": 1e-3}, r"slider\.stick_band must be 0 with slider\.adhesion\.model = \"JKR\""),
        ({"normal_law": TabulatedForce.of(lambda z: 2.7e9 * z**1.5, scale=1e-9, end=1e-6)}, r"slider\.normal_law"),
        ({"law": "hysteretic"}, r"slider\.adhesion has no hysteretic law"),
        ({"reciprocal": True}, r"slider\.reciprocal cannot be true where balls attract"),
        ({"heights": (0.0, 1e-9)}, r"slider\.heights must all be 0"),
        ({"radius": [1e-3, 2e-3]}, r"slider\.radius must be equal"),
        ({"weights": [2.0, 1.0]}, r"slider\.weights must be 1"),
    ],
)
def test_refusals(changed, sentence):
    with pytest.raises(InputError, match=sentence):
        ball(**changed)


def test_work_is_required_and_positive():
    with pytest.raises(InputError, match=r"adhesion\.work is required"):
        Adhesion(model="JKR")
    with pytest.raises(InputError, match=r"adhesion\.work must be positive"):
        Adhesion(model="JKR", work=-1.0)


def test_a_heavy_body_does_not_bounce():
    """The mass alone takes the exact motion to the averaged one, 1e-9 at 1e4 kg."""
    found = steady(ball(mass=HEAVY, tangential_damping=0.0), orbit(8e-9), tolerance=1e-6, method="averaged")
    mean = float(mean_motion(ball(mass=HEAVY, tangential_damping=0.0), orbit(8e-9)).velocity)
    assert found.velocity == pytest.approx(mean, rel=1e-6)
