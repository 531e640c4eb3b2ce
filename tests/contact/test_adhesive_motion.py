"""A heavy slider on balls of Johnson, Kendall and Roberts: limits, an independent integration in time, refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest

from contact import (
    Adhesion,
    AdhesiveBalls,
    AdhesiveSphere,
    ConvergenceError,
    InputError,
    Orbit,
    adhesive_motion,
    mean_forces,
    mean_motion,
    release_factor,
    threshold_factor,
)
from tests.contact.motors import orbit, slider

R, E, MU, PRELOAD = 1e-3, 64e9, 0.08, 0.87309e-3
BALL = slider(preload=PRELOAD, mass=math.inf, normal_damping=0.0, tangential_damping=0.0)


@pytest.mark.parametrize("u", [2e-9, 3e-9, 10e-9])
@pytest.mark.parametrize("work", [0.05, 0.1])
def test_with_the_other_model_it_is_the_motion_of_the_slider(u, work):
    found = adhesive_motion(BALL, orbit(u, 0.67), work=work, model="DMT", tolerance=1e-7)
    known = mean_motion(replace(BALL, adhesion=Adhesion(model="DMT", work=work)), orbit(u, 0.67))
    assert found.velocity.status == "ok"
    assert found.velocity.value == pytest.approx(float(known.velocity), abs=found.velocity.error)
    assert found.velocity.value == pytest.approx(float(known.velocity), rel=1e-5)
    assert found.height == pytest.approx(float(known.height), rel=2e-6)
    assert found.lost_power == 0.0


@pytest.mark.parametrize("model", ["JKR", "DMT"])
@pytest.mark.parametrize("u", [2e-9, 10e-9])
def test_without_work_it_is_hertz(u, model):
    found = adhesive_motion(BALL, orbit(u), work=1e-24, model=model, tolerance=1e-9)
    known = mean_motion(BALL, orbit(u))
    assert found.velocity.value == pytest.approx(float(known.velocity), rel=1e-9)
    assert found.height == pytest.approx(float(known.height), rel=1e-9)


@pytest.mark.parametrize("model", ["JKR", "DMT"])
def test_without_work_the_limits_are_those_of_smooth_balls(model):
    balls, unit = AdhesiveBalls(BALL, work=1e-24, model=model), orbit(1e-9)
    assert balls.release(unit) == pytest.approx(release_factor(BALL, unit), rel=1e-9)
    # the nodes of the cycle find the phase of first slip to the square of their distance
    assert balls.threshold(unit) == pytest.approx(threshold_factor(BALL, unit), rel=1e-6)


@pytest.mark.parametrize(("model", "work"), [("JKR", 0.05), ("JKR", 0.144), ("Maugis", 0.05), ("Maugis", 0.02)])
@pytest.mark.parametrize("u", [5e-9, 10e-9, 20e-9])
def test_the_surface_s_normal_work_is_lost_by_closing_and_opening(model, work, u):
    """The ledger by cycle means of P du_z/dt, against the loss of both branches in closed form or by a quadrature."""
    found = adhesive_motion(BALL, orbit(u), work=work, model=model, tolerance=1e-3)
    assert abs(found.normal_power - found.lost_power) < 1e-10 * found.tangential_power
    assert found.hops == (found.lost_power > 0.0)
    assert found.tangential_power > 0.0


def test_several_balls_have_one_height_and_share_the_preload():
    """Two equal balls under twice the preload are one; a third ball beside the wave's crest takes its own part."""
    wave = orbit(4e-9)
    pair = replace(BALL, preload=2.0 * PRELOAD)
    one = adhesive_motion(BALL, wave, work=0.05)
    two = adhesive_motion(pair, (wave, wave), work=0.05)
    assert two.velocity.value == pytest.approx(one.velocity.value, rel=1e-9)
    assert two.height == pytest.approx(one.height, rel=1e-9)
    # without work two balls on unlike waves are those of the smooth solver
    unlike = (wave, Orbit(frequency=2.2e6, normal=0.6 * wave.normal, tangential=0.5j * wave.tangential))
    found = adhesive_motion(pair, unlike, work=1e-24, model="DMT", tolerance=1e-7)
    known = mean_motion(pair, unlike)
    assert found.height == pytest.approx(float(known.height), rel=1e-9)
    assert found.velocity.value == pytest.approx(float(known.velocity), rel=1e-6)


@pytest.mark.parametrize(("load", "way"), [(0.0, 1.0), (2e-6, -1.0)])
def test_below_the_threshold_the_slider_rests_and_above_it_moves(load, way):
    balls = AdhesiveBalls(replace(BALL, load=load), work=0.05, model="JKR")
    factor = balls.threshold(orbit(1e-9))
    below, above = (balls.motion(orbit(share * factor * 1e-9), tolerance=1e-9) for share in (0.999, 1.003))
    assert (below.regime, above.regime) == ("stick", "slip")
    assert below.velocity.value == 0.0 < way * above.velocity.value


def test_attraction_raises_the_threshold_as_a_preload_would():
    """DMT without hops is a preload: the approach grows by ((F + F_a)/F)^(2/3)."""
    smooth, pulled = (AdhesiveBalls(BALL, work=work, model="DMT").threshold(orbit(1e-9)) for work in (1e-24, 0.05))
    grown = ((PRELOAD + 2.0 * math.pi * 0.05 * R) / PRELOAD) ** (2.0 / 3.0)
    assert pulled / smooth == pytest.approx(grown, rel=1e-6)


@pytest.mark.parametrize("work", [0.02, 0.05, 0.1, 0.144])
def test_hops_begin_at_the_release_amplitude_and_lose_the_work_of_both_branches(work):
    ball = AdhesiveSphere(radius=R, modulus=E, work=work, model="JKR")
    amplitude = ball.release_amplitude(PRELOAD)
    below, above = (adhesive_motion(BALL, orbit(share * amplitude), work=work) for share in (0.9999, 1.0001))
    assert (below.hops, above.hops) == (False, True)
    assert below.lost_power == 0.0
    assert above.lost_power == pytest.approx(2.2e6 * ball.loss, rel=1e-12)


def in_time(work, wave, steps=40_000):
    """Return (mean P, mean Q) at a height and velocity: a ball in equal steps, closed from z = 0 to its end."""
    a = np.geomspace(1e-9, 2e-5, 200_000)
    z_of = a**2 / R - np.sqrt(2.0 * math.pi * work * a / E)
    least = int(np.argmin(z_of))
    phi = 2.0 * math.pi * np.arange(steps) / steps
    u_z = (wave.normal * np.exp(1j * phi)).real
    u_x = (wave.tangential * np.exp(1j * phi)).real
    c = MU * E / (4.0 * 12e9)

    def means(h, v):
        z = h + u_z
        radius = np.interp(z, z_of[least:], a[least:])
        force = 4.0 * E * radius**3 / (3.0 * R) - np.sqrt(8.0 * math.pi * work * E * radius**3)
        moved = np.diff(u_x, prepend=u_x[-1]) - v / wave.omega * 2.0 * math.pi / steps
        closed, x, normal, tangential = False, 0.0, 0.0, 0.0
        for cycle in range(2):
            for k in range(steps):
                if not closed and z[k] > 0.0:
                    closed, x = True, 0.0
                elif closed and z[k] < z_of[least]:
                    closed = False
                elif closed:
                    x += moved[k]
                if closed:
                    delta = radius[k] ** 2 / R
                    x = min(max(x, -c * delta), c * delta)
                    if cycle == 1:
                        left = max(delta - abs(x) / c, 0.0)
                        normal += force[k]
                        spring = 4.0 / 3.0 * E * math.sqrt(R) * (delta**1.5 - left**1.5)
                        tangential += MU * math.copysign(spring, x)
        return normal / steps, tangential / steps

    return means


@pytest.mark.parametrize("work", [0.05, 0.144])
def test_a_hopping_ball_moves_as_in_an_integration_in_time(work):
    wave = orbit(10e-9, 0.67)
    found = adhesive_motion(BALL, wave, work=work)
    assert found.hops
    means = in_time(work, wave)
    assert means(found.height, found.velocity.value)[0] == pytest.approx(PRELOAD, rel=1e-3)
    slower, faster = (means(found.height, (1.0 + each) * found.velocity.value)[1] for each in (-2e-3, 2e-3))
    assert slower > 0.0 > faster


def test_any_phase_of_the_wave_is_the_same_motion():
    wave = orbit(8e-9)
    turned = Orbit(frequency=2.2e6, normal=1j * wave.normal, tangential=1j * wave.tangential)
    one, other = (adhesive_motion(BALL, each, work=0.05).velocity.value for each in (wave, turned))
    assert one == pytest.approx(other, rel=1e-12)
    mirrored = Orbit(frequency=2.2e6, normal=wave.normal, tangential=-wave.tangential)
    assert adhesive_motion(BALL, mirrored, work=0.05).velocity.value == pytest.approx(-one, rel=1e-10)


def test_a_load_slows_the_slider():
    slowed = adhesive_motion(replace(BALL, load=1e-5), orbit(10e-9), work=0.05).velocity.value
    assert 0.0 < slowed < adhesive_motion(BALL, orbit(10e-9), work=0.05).velocity.value


@pytest.mark.parametrize("u", [3e-9, -3e-9])
def test_a_load_beyond_the_drive_moves_the_slider_back(u):
    """Without work as on smooth balls; beyond full friction it runs away, or is held by a damper."""
    wave = Orbit(frequency=2.2e6, normal=abs(u), tangential=-0.67j * u)
    loaded = replace(BALL, load=0.9 * MU * PRELOAD)
    known = float(mean_motion(loaded, wave).velocity)
    assert adhesive_motion(loaded, wave, work=1e-24, tolerance=1e-9).velocity.value == pytest.approx(known, rel=1e-9)
    assert known * float(mean_motion(BALL, wave).velocity) < 0.0
    heavy = replace(BALL, load=2.0 * MU * PRELOAD)
    with pytest.raises(ConvergenceError, match="friction cannot balance the load"):
        adhesive_motion(heavy, wave, work=1e-24)
    damped = adhesive_motion(replace(heavy, tangential_damping=1e-3), wave, work=1e-24).velocity.value
    assert damped == pytest.approx(math.copysign(MU * PRELOAD / 1e-3, known), rel=1e-6)


@pytest.mark.parametrize(
    ("load", "model", "side"), [(1e-7, "JKR", 1.0), (2e-6, "JKR", -1.0), (2e-6, "Maugis", 1.0), (6e-5, "JKR", 1.0)]
)
def test_without_work_a_slider_starts_under_a_load_as_on_smooth_balls(load, model, side):
    """In either direction: the load moves it back at 0.684 times the wave, the wave forward again at 0.848."""
    loaded, wave = replace(BALL, load=load), Orbit(frequency=2.2e6, normal=1e-9, tangential=-0.7e-9j * side)
    body = replace(loaded, adhesion=Adhesion(model=model, work=1e-18))  # below 1e-19 none is computed
    assert body.profile.hold is not None
    known = threshold_factor(loaded, wave)
    assert threshold_factor(body, wave) == pytest.approx(known, rel=1e-6)
    for factor in (0.99 * known, 1.01 * known, 1.2 * known, 3.0):  # below, above, and forward again under small loads
        mean, hertz = mean_motion(body, wave.scaled(factor)), mean_motion(loaded, wave.scaled(factor))
        reference = wave.omega * factor * 0.7e-10
        assert float(mean.velocity) == pytest.approx(float(hertz.velocity), abs=float(mean.relative_error) * reference)
        assert (float(mean.velocity) == 0.0) == (factor < known) == (mean.regime == "stick")
        assert mean.load_sign == hertz.load_sign == 1.0


@pytest.mark.parametrize("u", [3e-9, 10e-9])
@pytest.mark.parametrize("turn", [1.0, 1.0j])
def test_forces_of_a_cycle_are_those_of_hertz_without_work_and_do_the_work_of_the_surface(u, turn):
    wave = orbit(u).scaled(turn)
    smooth = mean_forces(BALL, wave, mean_motion(BALL, wave))
    for work in (1e-18, 0.05, 0.144):
        body = replace(BALL, adhesion=Adhesion(model="JKR", work=work))
        found = mean_forces(body, wave, mean_motion(body, wave))
        assert float(found.normal[0]) == pytest.approx(PRELOAD, rel=1e-9)
        if work < 1e-9:
            assert abs(found.first_normal - smooth.first_normal)[0] < 1e-7 * PRELOAD
            assert abs(found.first_tangential - smooth.first_tangential)[0] < 1e-5 * MU * PRELOAD
            continue
        motion = AdhesiveBalls(BALL, work=work, model="JKR").motion(wave, tolerance=1e-6)
        powers = [
            0.5 * (force[0] * np.conj(1j * wave.omega * along)).real
            for force, along in ((found.first_normal, wave.normal), (found.first_tangential, wave.tangential))
        ]
        assert powers[0] == pytest.approx(motion.lost_power, rel=1e-9, abs=1e-9 * motion.tangential_power)
        assert powers[1] == pytest.approx(motion.tangential_power, rel=1e-4)
        assert abs(found.first_normal[0]) > 1.01 * abs(smooth.first_normal[0])


def test_unlike_balls_start_at_the_first_of_several_factors():
    """The load moves them back from 0.427 on; at some larger factors friction holds them again, up to 0.901."""
    waves = [
        Orbit(frequency=2.2e6, normal=size, tangential=size * ratio)
        for size, ratio in ((0.45e-9, 1.1 + 1.6j), (1.25e-9, 0.75 + 0.7j))
    ]
    pair = replace(BALL, preload=2.0 * PRELOAD, load=9e-6)
    factor = AdhesiveBalls(pair, work=1e-24, model="JKR").threshold(waves)
    assert factor == pytest.approx(threshold_factor(pair, waves), rel=1e-5)


@pytest.mark.parametrize(
    ("changed", "given", "sentence"),
    [
        ({"law": "hysteretic"}, {}, r"slider\.law"),
        ({"shape": "punch", "radius": 1e-6}, {}, "slider must stand on equal smooth balls"),
        ({"radius": [1e-3, 2e-3]}, {}, "slider must stand on equal smooth balls"),
        ({"heights": (0.0, 1e-9)}, {}, r"slider\.heights must all be 0"),
        ({"preload": 0.0}, {}, r"slider\.preload"),
        ({}, {"work": -1.0}, r"adhesion\.work"),
        ({}, {"model": "jkr"}, r"adhesion\.model"),
        ({}, {"model": "Maugis", "separation": 0.0}, r"adhesion\.separation"),
        ({}, {"tolerance": 0.0}, "tolerance"),
    ],
)
def test_refusals(changed, given, sentence):
    with pytest.raises(InputError, match=sentence):
        adhesive_motion(slider(**changed), orbit(5e-9), **({"work": 0.05} | given))
