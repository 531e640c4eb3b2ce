"""The hysteretic law: closed forms, a brute-force row of springs, passivity, and the motion that it gives."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contact import burst, contact_history, steady
from contact.answers.ledger import ledger
from contact.body import Point
from contact.codes import Regime, Status
from contact.events import event_driven
from contact.events.collocation import collocation
from contact.events.motion import Motion
from contact.exceptions import ConvergenceError
from contact.law import hysteretic
from contact.law.normal import SPHERE
from contact.problem import ContactParameters, scaled
from tests.contact.motors import FREQUENCY, orbit, slider
from tests.oracles.contact_springs import velocity_from_rest

C = 0.107
UNIT = ContactParameters(1.0, C, 1.0, 0.0, 0.0, SPHERE, 1.0, 1.0, hysteretic.mindlin_deresiewicz())
TABLE = collocation(12)
corners = st.lists(st.tuples(st.floats(0.3, 2.0), st.floats(-1.0, 1.0)), min_size=2, max_size=10)


class Contact:
    """One contact led along straight lines in (z, x), pressed on to z = 1 first; lengths and mu K are 1."""

    def __init__(self, unit=UNIT):
        self.memory, self.unit = hysteretic.blank(1, TABLE), unit
        self.regime, self.sign, self.z, self.x = Regime.SEPARATED, 1.0, -1.0, 0.0
        self.go(1.0, 0.0)

    def go(self, z, x):
        """Return Q after a line to (z, x)."""
        self.regime, self.sign, self.x = hysteretic.jump(
            self.memory, 0, self.regime, self.sign, Point(self.z, self.x, 0.0, 0.0), Point(z, x, 0.0, 0.0), self.unit
        )
        self.z = z
        return hysteretic.moment(
            self.memory, 0, self.regime, self.sign, z, self.x, self.unit.limit_slope, self.unit.normal
        )[0]

    def energy(self):
        return hysteretic.chain_energy(self.unit, self.memory, 0, self.regime, self.sign, self.z, self.x)


class Springs:
    """Oracle: the row of springs itself, each a stop; midpoints in sqrt(eta), so that their stiffness is even."""

    def __init__(self, number):
        self.root = (np.arange(number) + 0.5) * (1.5 / number)
        self.width, self.deflection = 1.5 / number, np.zeros(number)
        self.z, self.x = 1.0, 0.0

    def go(self, z, x, steps=400):
        """Return Q after a line to (z, x) in small steps."""
        eta = self.root**2
        dx = (x - self.x) / steps
        for k in range(1, steps + 1):
            limit = C * np.maximum(self.z + (z - self.z) * k / steps - eta, 0.0)
            self.deflection = np.clip(self.deflection + dx, -limit, limit)
        self.z, self.x = z, x
        return 1.5 / C * np.sum(self.deflection) * self.width


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9, 1.0])
def test_loop_loss_is_that_of_mindlin_and_deresiewicz(share):
    # Closed form at constant P: (9 mu^2 P^2/10 a G) {1 - (1-q)^(5/3) - (5q/6) [1 + (1-q)^(2/3)]}
    # with mu P/(a G) = 16 x_max/3
    q, z = share, 1.3
    contact = Contact()
    contact.go(z, 0.0)
    end = C * z * (1.0 - (1.0 - q) ** (2.0 / 3.0))
    assert contact.go(z, end) == pytest.approx(q * z**1.5, rel=1e-13)  # Cattaneo and Mindlin
    node, weight = np.polynomial.legendre.leggauss(40)
    part = 0.5 * (node + 1.0)
    work = 0.0
    for a, b in ((end, -end), (-end, end)):
        for p, w in zip(part, weight, strict=True):  # the root at the end of the branch becomes smooth
            work += (b - a) * (1.0 - p) * w * contact.go(z, a + (b - a) * (1.0 - (1.0 - p) ** 2))
        contact.go(z, b)
    published = 0.9 * 16.0 / 3.0 * C * z * z**1.5
    published *= 1.0 - (1.0 - q) ** (5 / 3) - 5.0 * q / 6.0 * (1.0 + (1.0 - q) ** (2 / 3))
    assert work == pytest.approx(published, rel=1e-12)


@given(corners)
@settings(max_examples=6, deadline=None, derandomize=True)
def test_force_is_that_of_a_row_of_springs(path):
    contact, springs = Contact(), Springs(3000)
    for z, share in path:
        q = contact.go(z, share * C * z)
        # midpoint rule over 3000 springs and 400 steps a line: 1e-3 of the largest force
        assert springs.go(z, share * C * z) == pytest.approx(q, abs=2e-3 * z**1.5)


@given(corners, st.lists(st.floats(0.01, 0.99), min_size=1, max_size=10))
@settings(max_examples=25, deadline=None, derandomize=True)
def test_a_line_in_pieces_is_the_same_line(path, stops):
    whole, pieces = Contact(), Contact()
    z0, x0 = 1.0, 0.0
    for z, share in path:
        x = share * C * z
        for p in sorted(stops):
            pieces.go(z0 + p * (z - z0), x0 + p * (x - x0))
        assert pieces.go(z, x) == pytest.approx(whole.go(z, x), abs=1e-12)
        z0, x0 = z, x


@given(corners)
@settings(max_examples=3, deadline=None, derandomize=True)
def test_no_closed_loop_gives_energy_out(path):
    contact = Contact()
    nodes, weights = np.polynomial.legendre.leggauss(2)
    work, worst, z0, x0 = 0.0, 0.0, 1.0, 0.0
    for z, share in [*path, (1.0, 0.0)]:
        x = share * C * z
        for k in range(40):
            for p, w in zip(nodes, weights, strict=True):
                t = (k + 0.5 * (p + 1.0)) / 40
                work += 0.5 * w / 40 * (x - x0) * contact.go(z0 + t * (z - z0), x0 + t * (x - x0))
        contact.go(z, x)
        z0, x0 = z, x
        lost = work - contact.energy()
        assert lost > worst - 1e-6, "loss must never fall"  # two-point rule in 40 parts over kinks
        worst = max(worst, lost)


def motion_of(s, A, nodes=16, truncation=1e-12):
    problem = scaled(s, (orbit(A),), direction=1.0, start=-0.5 * np.pi)
    motion = Motion(problem, grid=collocation(nodes), truncation=truncation)
    motion.set_state(-s.rest_approach(1) / problem.length, 0.0, 0.0, 0.0)
    return motion


@pytest.mark.parametrize("A", [1e-9, 3e-9, 10e-9])
def test_the_balance_of_a_run_closes_and_every_order_gives_the_same_velocity(A):
    s = slider(law="hysteretic")
    fine = motion_of(s, A)
    fine.begin()
    fine.turn(100)
    found = ledger(s, fine)
    assert found.relative_residual < 1e-9
    assert found.leak == 0.0
    rough = motion_of(s, A, nodes=10, truncation=1e-9)
    rough.turn(100)
    assert rough.state[2] == pytest.approx(fine.state[2], rel=1e-8)


@pytest.mark.parametrize("A", [0.75e-9, 1e-9, 3e-9, 10e-9])
def test_steady_cycles_balance_and_the_law_matters_most_at_small_amplitude(A):
    found = steady(slider(law="hysteretic"), orbit(A), tolerance=1e-6)
    assert found.status == "ok"
    assert found.ledger.relative_residual < 1e-8
    ratio = found.velocity / steady(slider(), orbit(A), tolerance=1e-6).velocity
    low, high = {0.75e-9: (6.0, 7.5), 1e-9: (1.8, 2.0), 3e-9: (1.1, 1.15), 10e-9: (1.03, 1.06)}[A]
    assert low < ratio < high


def test_the_steady_state_is_that_of_a_long_run():
    s = slider(law="hysteretic", tangential_damping=1.0, normal_damping=20.0)
    motion = motion_of(s, 3e-9, nodes=10, truncation=1e-8)
    rows = motion.turn(4000, stride=2000)
    found = steady(s, orbit(3e-9), tolerance=1e-8)
    assert rows[-1, 2] * motion.problem.speed == pytest.approx(found.velocity, rel=1e-6)


def test_held_cycles_repeat_and_lose_energy_without_gross_slip():
    found = steady(slider(law="hysteretic"), orbit(0.5e-9), tolerance=1e-6)
    assert (found.velocity, found.regime) == (0.0, "stick")
    assert found.ledger.slip > 0.0
    assert found.ledger.relative_residual < 1e-9


def test_contacts_apart_on_the_wave_keep_their_memories():
    trio = tuple(orbit(5e-9).scaled(np.exp(-2j * np.pi * k / 7.0)) for k in range(3))
    found = steady(slider(law="hysteretic"), trio, tolerance=1e-6)
    assert found.status == "ok"
    assert found.ledger.relative_residual < 1e-8


def test_contacts_apart_on_the_wave_keep_their_memories_when_the_wave_stops():
    # the surface falls to rest under the second contact, whose memory goes with it
    pair = (orbit(5e-9), orbit(5e-9).scaled(np.exp(1j)))
    found = burst(
        slider(law="hysteretic"), pair, duration=12 / FREQUENCY, after=5 / FREQUENCY, tolerance=1e-10, samples=2
    )
    assert found.after_ledger.relative_residual < 5e-11
    assert found.ledger.relative_residual < 5e-11


@pytest.mark.parametrize(("contacts", "gap"), [(2, 0.35e-3), (3, 0.5e-3)])
def test_contacts_apart_on_the_wave_move_as_rows_of_springs_do(contacts, gap):
    # The springs' own error at 400 springs and 400 steps is 6e-5 (2e-5 at 1000 of each)
    s, first = slider(law="hysteretic"), orbit(15e-9)
    phase = 2.0 * np.pi * FREQUENCY / 2170.0 * gap
    orbits = tuple(first.scaled(np.exp(-1j * phase * k)) for k in range(contacts))
    cycles = 40
    found = burst(s, orbits, duration=cycles / FREQUENCY, after=0.0, tolerance=1e-6, samples=2)
    springs = velocity_from_rest(
        [-1j * o.normal for o in orbits], [-1j * o.tangential for o in orbits], FREQUENCY,
        cycles=cycles, per_cycle=400, springs=400,
        slider={
            "radius": s.radius, "E": s.effective_modulus, "G": s.tangential_modulus, "mu": s.friction_coefficient,
            "mass": s.mass, "preload": s.preload, "load": s.load, "normal_damping": s.normal_damping,
            "tangential_damping": s.tangential_damping, "chi": s.contact_damping,
        },
    )  # fmt: skip
    assert found.status == "ok"
    assert found.velocity_at_burst_end == pytest.approx(springs, rel=1.5e-4)


def test_endless_events_get_advice_that_the_law_accepts(monkeypatch):
    monkeypatch.setattr(event_driven, "travel", lambda *_: Status.TOO_MANY)
    for law, advice in (("elastic", "stick_band"), ("hysteretic", "normal_damping")):
        with pytest.raises(ConvergenceError, match=f"follow each other without end; [^,]*{advice}"):
            motion_of(slider(law=law), 3e-9).turn(1)


def test_the_reciprocal_force_adds_nothing_to_a_law_with_a_potential():
    one, two = (steady(slider(law="hysteretic", reciprocal=r), orbit(3e-9), tolerance=1e-6) for r in (False, True))
    assert one.velocity == two.velocity


@pytest.mark.parametrize("changed", [{"law": "hysteretic"}, {"reciprocal": True}])
def test_bursts_and_histories_follow_every_law(changed):
    s = slider(**changed)
    found = burst(s, orbit(10e-9), duration=2e-5, after=1e-4, tolerance=1e-6, samples=20)
    assert (found.status, found.method) == ("ok", "exact")
    plain = burst(slider(), orbit(10e-9), duration=2e-5, after=0.0, tolerance=1e-6, samples=2)
    assert 1e-5 < abs(found.velocity_at_burst_end / plain.velocity_at_burst_end - 1.0) < 0.1
    with pytest.raises(ConvergenceError, match="elastic law"):
        burst(s, orbit(10e-9), duration=2e-5, after=0.0, tolerance=1e-6, samples=2, method="stepped")
    h = contact_history(s, orbit(10e-9), stage="steady", skip=0, cycles=1, points_per_cycle=400)
    assert np.mean(h.slider_velocity) == pytest.approx(steady(s, orbit(10e-9), tolerance=1e-6).velocity, rel=1e-6)
    assert ("partial" in h.regime) == (s.law == "hysteretic")
    assert np.all(np.abs(h.tangential_force) <= s.friction_coefficient * h.normal_force * (1.0 + 1e-12))


def test_the_ring_after_the_burst_is_damped_by_the_law_itself():
    # The seed's Fig. 7(b): the elastic ring goes on for ever, the hysteretic one dies, without any damper
    left = {}
    for law in ("elastic", "hysteretic"):
        s = slider(law=law, tangential_damping=0.0, normal_damping=5.0)
        found = burst(s, orbit(3e-9), duration=2e-5, after=6e-3, tolerance=1e-6, samples=1200)
        early = np.max(np.abs(found.velocity[(found.time > 1e-3) & (found.time < 2e-3)]))
        left[law] = np.max(np.abs(found.velocity[found.time > 5e-3])) / early
    assert left["elastic"] == pytest.approx(1.0, abs=0.02)
    assert left["hysteretic"] < 0.6


def test_a_full_memory_is_said():
    motion = motion_of(slider(law="hysteretic"), 3e-9)
    motion.memory.number[0] = hysteretic.PIECES
    with pytest.raises(ConvergenceError, match="memory full"):
        motion.turn(1)
