"""Many contacts, whose segments span events, against few, whose segments end at every event: the same motion."""

from dataclasses import replace

import numpy as np
import pytest

from contact import FallingFriction, Orbit, burst, contact_history, steady
from contact.answers.rest_motion import rest, rest_problem
from contact.events import many_contacts
from tests.contact.motors import slider
from tests.seed_motor import BODY, DAMPERS

FEW = 8
HEIGHTS = tuple(0.4e-9 * np.sin(3.0 * np.arange(FEW)))


def waves(count):
    """Return so many different orbits, again and again after `FEW`."""
    which = np.arange(count) % FEW
    sizes, phases = 5e-9 * (1.0 + 0.1 * np.sin(which)), 2.0 * np.pi * (0.618 * which % 1.0)
    return tuple(
        Orbit(frequency=2.2e6, normal=a * np.exp(1j * p), tangential=-0.7j * a * np.exp(1j * p * 1.02))
        for a, p in zip(sizes, phases, strict=True)
    )


def motor(count, **changed):
    """Return a slider whose totals are shared among so many contacts."""
    share = count / FEW
    whole = {key: value * FEW * share for key, value in (BODY | DAMPERS).items()}
    load = {"load": changed.pop("load") * share} if "load" in changed else {}
    return slider(**whole, **load, heights=HEIGHTS * int(share), **changed)


CASES = pytest.mark.parametrize(
    "changed",
    [{}, {"load": 2e-4, "contact_damping": 2e-4}, {"shape": "punch", "radius": 5e-6}, {"reciprocal": True},
     {"friction_coefficient": 0.3, "friction": FallingFriction(sliding=0.15, speed=0.05)}],
    ids=["sphere", "loaded", "punch", "reciprocal", "falling"],
)  # fmt: skip


# Oracle: every contact twice, with twice of everything, is the same motion; below `MANY` the other solver makes it
@CASES
def test_a_burst_of_twice_the_contacts_is_the_same_motion(changed):
    assert FEW < many_contacts.MANY <= 2 * FEW
    runs = [
        burst(
            motor(n, **changed), waves(n), duration=12 / 2.2e6, after=1e-6, tolerance=1e-8, samples=12, method="exact"
        )
        for n in (FEW, 2 * FEW)
    ]
    few, many = runs
    reference = 2.2e6 * 2.0 * np.pi * 3.5e-9 / 10.0
    apart = np.abs(few.velocity - many.velocity)
    assert np.max(apart[:13]) < 1e-12 * reference  # at the ends of cycles
    assert np.max(apart) < 2e-9 * reference  # within a segment, on the surface at rest
    assert np.max(np.abs(few.position - many.position)) < 1e-11 * 5e-9
    assert np.abs(many.velocity_at_burst_end) > 1e-7
    for one, two in zip(few.ledger, many.ledger, strict=True):
        assert two == pytest.approx(2.0 * one, rel=1e-6, abs=1e-9 * many.ledger.wave)
    assert many.ledger.relative_residual < 1e-8


@CASES
def test_the_steady_state_of_twice_the_contacts_is_the_same(changed):
    # the second half moves a little more, for contacts that move alike are followed as one
    orbits = tuple(each.scaled(1.0 + 1e-13 * (k >= FEW)) for k, each in enumerate(waves(2 * FEW)))
    few, many = (steady(motor(n, **changed), orbits[:n], tolerance=1e-6) for n in (FEW, 2 * FEW))
    assert (few.method, many.method) == ("exact", "exact")
    assert many.velocity == pytest.approx(few.velocity, rel=1e-9)
    assert abs(few.velocity) > 1e-3
    for kind in ("contact", "release", "stick_to_slip", "slip_to_stick"):
        assert many.statistics[kind] == 2 * few.statistics[kind]
    assert many.ledger.relative_residual < 1e-8


@CASES
def test_contacts_that_are_equal_and_move_alike_are_followed_as_one(changed):
    if "friction" in changed:
        changed = {"law": "hysteretic"}
    few, many = (steady(motor(n, **changed), waves(n), tolerance=1e-6) for n in (FEW, 4 * FEW))
    for kind in ("contact", "release", "stick_to_slip", "slip_to_stick"):
        assert many.statistics[kind] == few.statistics[kind] > 0
    assert many.velocity == pytest.approx(few.velocity, rel=1e-9)
    assert many.ledger.wave == pytest.approx(4.0 * few.ledger.wave, rel=1e-6)
    assert many.ledger.relative_residual < 1e-8
    unequal = replace(motor(2 * FEW, **changed), heights=(*HEIGHTS, *(each + 1e-10 for each in HEIGHTS)))
    assert steady(unequal, waves(2 * FEW), tolerance=1e-6).statistics["release"] == 2 * few.statistics["release"]


def test_what_each_contact_does_is_the_same():
    few, many = (
        contact_history(motor(n), waves(n), stage="start", skip=2.3, cycles=1.4, points_per_cycle=40.0)
        for n in (FEW, 2 * FEW)
    )
    for name in ("approach", "deformation", "normal_force", "tangential_force"):
        one, two = getattr(few, name), getattr(many, name)
        assert np.max(np.abs(two[:, :FEW] - one)) < 1e-9 * np.max(np.abs(one))
        assert np.array_equal(two[:, FEW:], two[:, :FEW])
    assert np.array_equal(many.regime[:, :FEW], few.regime)
    assert np.max(np.abs(many.slider_velocity - few.slider_velocity)) < 1e-11
    gaps = [each.statistics["smallest_gap"] for each in (few, many)]
    # events of a contact and of its twin at one instant have no gap
    assert gaps[1] == pytest.approx(gaps[0], rel=1e-3)


# Truth: a difference quotient for every deformation; those of a few directions, and the averaged equations
def test_the_multipliers_of_many_contacts_are_those_of_every_difference(monkeypatch):
    from contact.averaged.event_equilibrium import balanced
    from contact.periodic import shooting

    balance = balanced(motor(2 * FEW, contact_damping=2e-4), waves(2 * FEW))
    found, velocities = [], []
    for averaged, few in ((True, FEW), (False, FEW), (False, 1000)):
        monkeypatch.setattr(shooting, "FEW_CONTACTS", few)
        if not averaged:
            monkeypatch.setattr(shooting, "averaged_jacobian", lambda balance, deformations: None)
        near = shooting.periodic(balance, nodes=16, truncation=1e-12)
        found.append(np.sort_complex(np.linalg.eigvals(near.jacobian.left @ near.jacobian.right.T))[-3:])
        velocities.append(near.speed)
        assert near.growth == pytest.approx(np.max(np.abs(found[-1])), rel=1e-12)
    assert found[1] == pytest.approx(found[2], abs=3e-7)
    assert abs(found[0]) == pytest.approx(abs(found[2]), abs=1e-7)
    assert found[0].imag == pytest.approx(found[2].imag, rel=1e-4)
    assert 0.99 < abs(found[2][-1]) < 1.0 - 1e-6
    assert velocities[:2] == pytest.approx([velocities[2]] * 2, rel=1e-10)


# Truth: differences of the event-driven map
def test_the_averaged_jacobian_is_that_of_a_cycle():
    from contact.averaged.event_equilibrium import balanced
    from contact.periodic import shooting

    balance = balanced(motor(2 * FEW, contact_damping=2e-4), waves(2 * FEW))
    near = shooting.periodic(balance, nodes=16, truncation=1e-12)
    left, right = shooting.averaged_jacobian(balance, near.state[3:])
    whole, y = shooting.CycleMap(balance.problem, 16, 1e-12), near.state
    start = whole(y)
    columns = np.column_stack([unit + (whole(y + 1e-7 * unit) - start) / 1e-7 for unit in np.eye(y.size)])
    own, own_of_x = columns[:3, :3], columns[:3, 3:]
    through_deformations = own + own_of_x @ columns[3:, :3]
    map_ = (left @ right.T)[:3, :3]
    assert map_[:2, :2] - np.eye(2) == pytest.approx(own[:2, :2] - np.eye(2), rel=1e-2, abs=1e-7)
    assert map_[2] - np.eye(3)[2] == pytest.approx(through_deformations[2] - np.eye(3)[2], rel=0.1)
    # a contact forgets by slip, which this sum over 64 phases meets within one of them
    most = np.max(np.abs(own_of_x[2]))
    assert most > 0.0
    assert (left @ right.T)[2, 3:] == pytest.approx(own_of_x[2], abs=0.1 * most)
    assert np.max(np.abs(own_of_x[:2])) < 2e-3 * most


def test_the_work_grows_as_the_contacts():
    # Sweeps over contacts: a segment spans the events of all
    sweeps = []
    for n in (16, 64):
        problem = rest_problem(motor(n), waves(n))
        motion = rest(motor(n), waves(n), problem, nodes=12, truncation=1e-10)
        motion.turn(10)
        sweeps.append(motion.events()["sweeps"])
    assert sweeps[1] < 1.2 * sweeps[0]


def test_segments_grow_again_after_a_rough_place():
    """A light slider at a fine tolerance: 100 segments and 51 halvings in three cycles; 270 if none grew again."""
    body = replace(motor(16), mass=1e-3 * motor(16).mass)
    motion = rest(body, waves(16), rest_problem(body, waves(16)), nodes=12, truncation=1e-11)
    motion.turn(3)
    found = motion.events()
    assert 60 < found["stretches"] < 150
    assert 20 < found["halvings"] < 0.7 * found["stretches"]


# Property: what is compiled from `COMPILED_CONTACTS` on is what Python does for fewer
def test_regimes_and_energies_of_many_contacts_are_those_of_few(monkeypatch):
    from contact.answers.rest_motion import rest_problem
    from contact.events import energy, transitions
    from contact.events.collocation import collocation
    from contact.events.motion import Motion

    body, many = motor(2 * FEW), waves(2 * FEW)
    motion = Motion(rest_problem(body, many), grid=collocation(8), truncation=1e-6)
    spread, found = np.linspace(-1.5, 1.5, 2 * FEW), []
    for least in (1, 1000):
        monkeypatch.setattr(transitions, "COMPILED_CONTACTS", least)
        monkeypatch.setattr(energy, "COMPILED_CONTACTS", least)
        motion.set_state(-0.6, 1e-3, 2e-3, spread * motion.problem.limit_slope)
        found.append((motion.regime.copy(), motion.sign.copy(), motion.state.copy(), motion.energy()))
    assert len(set(found[0][0])) == 3  # separated, stick and slip
    for one, other in zip(*found, strict=True):
        assert one == pytest.approx(other, rel=1e-13)
