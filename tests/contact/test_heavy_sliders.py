"""Periodic motions of sliders so heavy that a cycle changes their velocity by 1e-7 to 1e-11 of itself."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from contact import Adhesion, Slider, steady
from contact.answers.ledger import ledger
from contact.averaged.event_equilibrium import balanced
from contact.codes import At
from contact.events.segment import advance_slider
from contact.orbit import as_orbits
from contact.periodic import shooting
from tests.contact.motors import orbit, slider

PRELOAD, DAMPING, AMPLITUDE = 7.2356e-5, 1e-4, 22.19e-9


def light_ball(**changed) -> Slider:
    """Return a slider whose only contact slips in one direction as long as it is closed."""
    known = {"radius": 0.2912e-3, "preload": PRELOAD, "tangential_damping": DAMPING, "mass": 7.03e-3}
    return slider(**(known | changed))


def drawn(seed):
    """Return a drawn motor that is 10 to 1e6 times as heavy as the seed's, on balls of every adhesion."""
    draw = np.random.default_rng(seed)

    def between(low, high):
        return float(np.exp(draw.uniform(math.log(low), math.log(high))))

    model = ("none", "DMT", "JKR", "Maugis")[seed % 4]
    work, separation = between(1e-3, 0.1), between(1e-10, 2e-9)
    adhesion = None
    if model != "none":
        adhesion = Adhesion(model=model, work=work, separation=separation if model == "Maugis" else None)
    body = slider(
        adhesion=adhesion, radius=between(2e-4, 2e-3), preload=between(3e-5, 3e-3),
        mass=between(1e-3, 1e2), normal_damping=between(0.05, 2.0), tangential_damping=between(1e-6, 1e-3),
    )  # fmt: skip
    return body, orbit(between(4e-9, 25e-9), draw.uniform(0.3, 1.0))


@pytest.mark.parametrize("tolerance", [1e-3, 1e-9])
@pytest.mark.parametrize("mass", [7.03e-3, 1.0, 100.0])
def test_a_slider_that_always_slips_has_the_velocity_of_a_brake(mass, tolerance):
    """Closed form: <Q> = mu p, so that v = mu p/R_t, whatever the wave and the mass."""
    body = light_ball(mass=mass)
    found = steady(body, orbit(AMPLITUDE), tolerance=tolerance, method="exact")
    assert found.statistics["stick_to_slip"] == 0
    assert found.velocity == pytest.approx(body.friction_coefficient * PRELOAD / DAMPING, rel=1e-12)
    assert found.answer.error < 1e-9 * found.velocity
    assert found.ledger.relative_residual < 1e-11


def test_many_balls_that_always_slip_have_the_velocity_of_a_brake():
    """The solver for many contacts moves the slider by moments of its forces."""
    waves = tuple(orbit(AMPLITUDE * (1.0 + 0.01 * k)) for k in range(16))
    body = light_ball(preload=16 * PRELOAD, tangential_damping=16 * DAMPING, mass=1.0)
    found = steady(body, waves, tolerance=1e-9, method="exact")
    assert found.statistics["stick_to_slip"] == 0
    assert found.velocity == pytest.approx(body.friction_coefficient * PRELOAD / DAMPING, rel=1e-12)
    assert found.ledger.relative_residual < 1e-10


@pytest.mark.parametrize("seed", range(12))
def test_energies_of_a_heavy_slider_balance(seed):
    """The kinetic energy is up to 1e11 times the work of a cycle."""
    body, wave = drawn(seed)
    found = steady(body, wave, tolerance=1e-3, method="exact")
    assert found.ledger.relative_residual < 1e-10
    assert found.answer.error < 1e-8 * max(abs(found.velocity), 0.1 * wave.omega * abs(wave.tangential))
    drag = found.ledger.tangential_damper * wave.frequency  # R_t <v^2>, and v is constant
    assert drag == pytest.approx(body.tangential_damping * found.velocity**2, rel=1e-6)


def test_a_search_that_ends_early_returns_the_cycle_of_its_state(monkeypatch):
    """The motion is that from the state, not from one Newton step before it."""
    monkeypatch.setattr(shooting, "MAX_STEPS", 2)
    body = light_ball()
    begin = balanced(body, as_orbits([orbit(AMPLITUDE)]))
    found = shooting.search_at(shooting.FINE, replace(begin, speed=1.01 * begin.speed))
    again = shooting.Motion(found.motion.problem, grid=found.motion.grid, truncation=found.motion.truncation)
    again.set_state(*found.state[: At.DEFORMATIONS], found.state[At.DEFORMATIONS :])
    again.begin()
    again.turn(1)
    assert np.array_equal(found.motion.begun.slider, found.state[: At.DEFORMATIONS])
    assert found.motion.state == pytest.approx(again.state, rel=1e-15, abs=1e-18)
    assert found.step > 1e-12
    assert ledger(body, found.motion).relative_residual < 1e-11


def test_the_sums_of_a_sliders_motion_keep_what_they_round_off():
    """Against exact sums of 10 000 changes of 1e-13 to 1e-9 of the state."""
    draw = np.random.default_rng(1)
    state = SimpleNamespace(slider=np.array([0.3, 0.0, 0.217]), lost=np.zeros(3))
    begin, changes = state.slider.copy(), [[], []]
    for _ in range(10_000):
        length, once, along = draw.uniform(0.1, 0.8), draw.normal() * 1e-9, 1e-11 * draw.uniform()
        advance_slider(state, length, once, 0.5 * once, along)
        changes[0].append(length * once)
        changes[1].append(length * along)
    for k, changed in zip((At.NORMAL_VELOCITY, At.VELOCITY), changes, strict=True):
        known = math.fsum([float(begin[k]), *changed])
        assert state.slider[k] == pytest.approx(known, rel=1e-16, abs=1e-30)
        remainder = math.fsum([float(begin[k]), *changed, -float(state.slider[k])])
        assert state.lost[k] == pytest.approx(remainder, abs=1e-21)
    assert abs(state.lost[At.VELOCITY]) > 0.0
