"""Extremes of every parameter: an answer within its error, one that says it is not, or a refusal with the reason."""

import math
from dataclasses import replace

import numpy as np
import pytest

from contact import ConvergenceError, burst, steady, threshold_amplitude, threshold_factor
from contact.answers.rest_motion import rest_problem
from contact.answers.thresholds import release_amplitude
from contact.averaged.event_equilibrium import opposed
from contact.error_estimate import reference_speed
from contact.events.collocation import collocation
from contact.events.motion import Motion
from contact.orbit import towards_plus
from studies.evidence.stability import extreme_contacts as part
from studies.evidence.stability.cross_check import cross_check
from studies.evidence.stability.extreme_contacts import CORNERS, SWEPT, VARIED, built, motor
from studies.evidence.stability.verdict import VERDICTS, Case, cases_of, judge
from tests.contact.motors import orbit, slider
from tests.motors import CORNER_RANGES


def outcome(varied, value):
    return judge(part, Case(part="contact", varied=varied, value=value, unit=""))


@pytest.mark.parametrize(
    ("varied", "value", "verdict"),
    [
        ("mass", 1.0, "right"),
        ("mass", 1e-8, "right"),
        ("mass", 1e-12, "refused"),
        ("preload", 1e3, "right"),
        ("amplitude", 1e-5, "right"),
        ("friction_coefficient", 0.0, "right"),
        ("friction_coefficient", 5.0, "right"),
        ("radius", 1e-9, "right"),
        ("frequency", 1.0, "flagged"),  # no reference can follow it
        ("frequency", 1e10, "right"),
        ("load", 1e3, "right"),
        ("corner", 55, "flagged"),  # the height wanders and acts on a velocity that settles within 1e6 cycles
        pytest.param("normal_damping", 1e6, "right", marks=pytest.mark.slow),
    ],
)
def test_an_extreme_is_answered_within_its_error_or_refused(varied, value, verdict):
    found = outcome(varied, value)
    assert found.verdict == verdict, found.guard
    assert found.guard or verdict == "right"


@pytest.mark.slow
def test_no_case_of_the_sweep_is_wrong():
    outcomes = [(case, judge(part, case)) for case in cases_of("contact", VARIED)]
    wrong = [(case, found) for case, found in outcomes if found.verdict == "WRONG"]
    assert not wrong
    # flagged: mostly cases in which the reference cannot follow the motion (195 right, 25 flagged, 16 refused)
    assert sum(found.verdict == "right" for _, found in outcomes) > 0.75 * len(outcomes)
    assert sum(found.verdict == "refused" for _, found in outcomes) < 0.1 * len(outcomes)


def test_cases_cover_every_range_to_its_ends():
    cases = cases_of("contact", VARIED)
    assert {case.varied for case in cases} == {*SWEPT, "corner"} >= set(CORNER_RANGES)
    for name, (low, high) in CORNER_RANGES.items():
        values = [case.value for case in cases if case.varied == name]
        assert max(values) >= min(high, 1e3)
        assert min(values) <= low or name in ("load", "friction_coefficient")
    assert all(outcome in VERDICTS for outcome in ("right", "WRONG"))
    drawn = [motor(case) for case in cases if case.varied == "corner"]
    assert {s.law for s, _ in drawn} == {"elastic", "hysteretic"}
    assert {len(orbits) for _, orbits in drawn} == {1, 3}


@pytest.mark.parametrize("A", [pytest.param(1e-9, marks=pytest.mark.slow), 5e-9])
def test_a_cross_check_agrees_and_sees_a_wrong_answer(A):
    found = steady(slider(), orbit(A), tolerance=1e-6)
    other = cross_check(found)
    reference = reference_speed(found.velocity, found.orbits)
    assert other.method == "stepped"
    assert abs(other.velocity - found.velocity) / reference < 3e-5
    # a velocity that is a hundredth off is pointed back to the true one
    for factor in (0.99, 1.02):
        wrong = replace(found.answer, value=factor * found.velocity)
        doubted = cross_check(replace(found, answer=wrong))
        assert abs(doubted.velocity - found.velocity) < doubted.error
        assert doubted.velocity == pytest.approx(found.velocity, rel=3e-3)


@pytest.mark.parametrize("mass", [0.089e-3, 1.0])
def test_a_cross_check_sees_that_a_slider_does_not_stick(mass):
    """One of 1 kg, from rest, has 1e-4 of the reference speed after 20000 cycles."""
    found = steady(slider(mass=mass), orbit(5e-9), tolerance=1e-3)
    doubted = cross_check(replace(found, answer=replace(found.answer, value=0.0)))
    reference = reference_speed(0.0, found.orbits)
    assert abs(doubted.velocity) > 2.0 * doubted.error + 5e-3 * reference
    assert math.copysign(1.0, doubted.velocity) == math.copysign(1.0, found.velocity)


@pytest.mark.parametrize("changes", [{}, {"preload": 100.0}, {"mass": 1.0}])
def test_a_cross_check_agrees_that_a_slider_sticks(changes):
    """At a large preload the contacts are elastic over a way that takes a tenth of a second at the reference speed."""
    found = steady(slider(**changes), orbit(5e-10), tolerance=1e-3)
    assert found.velocity == 0.0
    other, reference = cross_check(found), reference_speed(0.0, found.orbits)
    assert abs(other.velocity) < 1e-3 * reference
    assert 0.0 < other.error < 1.001e-2 * reference


def test_without_friction_nothing_slows_a_slider_and_nothing_says_that_it_sticks():
    found = steady(slider(friction_coefficient=0.0, tangential_damping=0.0), orbit(5e-9), tolerance=1e-3)
    assert found.velocity == 0.0
    with pytest.raises(ConvergenceError, match=r"starts at 0\.01 of the reference speed has 0\.01 of it"):
        cross_check(found)


def test_a_cross_check_by_events_where_steps_do_not_apply():
    found = steady(slider(stick_band=1e-3, reciprocal=True), orbit(5e-9), tolerance=1e-6)
    other = cross_check(found)
    assert other.method == "exact"
    assert abs(other.velocity - found.velocity) < other.error
    assert other.velocity == pytest.approx(found.velocity, rel=1e-3)


def test_without_friction_nothing_divides_by_the_slip_limit():
    found = burst(
        slider(friction_coefficient=0.0), orbit(5e-9), duration=1e-5, after=0.0, tolerance=1e-3, samples=2,
        method="exact",
    )  # fmt: skip
    assert found.velocity_at_burst_end == 0.0


@pytest.mark.parametrize("method", ["exact", "stepped"])
def test_a_load_opposes_the_unloaded_motion_in_a_burst_as_in_the_steady_state(method):
    # a wave that drives against its crests: tangential motion well out of quadrature
    from contact import Orbit

    wave = Orbit(frequency=2.2e6, normal=6e-9, tangential=5e-9 * np.exp(0.2j))
    free = steady(slider(tangential_damping=5e-3), wave, tolerance=1e-6)
    assert math.copysign(1.0, free.velocity) == -math.copysign(1.0, wave.crest_velocity)
    s = slider(load=1e-5, tangential_damping=5e-3)
    assert opposed(s, towards_plus((wave,))[1]) == -1.0
    loaded = steady(s, wave, tolerance=1e-6)
    assert abs(loaded.velocity) < abs(free.velocity)
    cycles = 2000
    ends = [
        burst(x, wave, duration=cycles / 2.2e6, after=0.0, tolerance=1e-4, samples=2, method=method)
        for x in (slider(tangential_damping=5e-3), s)
    ]
    pushed = ends[1].velocity_at_burst_end - ends[0].velocity_at_burst_end
    assert math.copysign(1.0, pushed) == -math.copysign(1.0, free.velocity)
    # the load's impulse, less what the friction gives back
    assert 0.2 < abs(pushed) / (s.load * cycles / 2.2e6 / s.mass) < 1.05


@pytest.mark.parametrize(
    "changed",
    [
        pytest.param({"law": "hysteretic"}, marks=pytest.mark.slow),
        {"reciprocal": True},
        {"law": "hysteretic", "load": 1e-5},
    ],
)
def test_the_slider_starts_at_the_threshold_of_its_law(changed):
    s = slider(**changed)
    edge = threshold_amplitude(s, orbit(1e-9))
    elastic = threshold_amplitude(replace(s, law="elastic", reciprocal=False), orbit(1e-9))
    assert edge < elastic
    below, above = (steady(s, orbit(k * edge), tolerance=1e-2).velocity for k in (1.0 - 1e-4, 1.0 + 1e-4))
    assert below == 0.0
    assert above != 0.0  # with a load it walks backwards
    assert threshold_factor(s, orbit(0.5 * edge)) == pytest.approx(2.0, rel=3e-5)


def drift(s, A, cycles):
    """Return how far a slider moves in two stretches of time, event by event from rest, scaled."""
    problem = rest_problem(s, (orbit(A),))
    motion = Motion(problem, grid=collocation(10), truncation=1e-8)
    motion.set_state(-s.rest_approach(1) / problem.length, 0.0, 0.0)
    rows = motion.turn(2 * cycles, stride=1)[:, 2]
    return float(np.mean(rows[:cycles])), float(np.mean(rows[cycles:]))


def test_a_hysteretic_contact_walks_below_the_elastic_threshold_by_the_motion_itself():
    # Not by averages: from rest, 10 % below the elastic threshold (0.892 of it is where it starts)
    s = slider(law="hysteretic", normal_damping=5.0, tangential_damping=1e-2)
    elastic = threshold_amplitude(replace(s, law="elastic", reciprocal=False), orbit(1e-9))
    _, held = drift(s, 0.80 * elastic, 600)
    _, walking = drift(s, 0.97 * elastic, 600)
    _, seed = drift(slider(normal_damping=5.0, tangential_damping=1e-2), 0.97 * elastic, 600)
    assert abs(held) < 0.1 * walking
    assert abs(seed) < 0.1 * walking


def test_release_with_the_reciprocal_force_is_where_contact_is_lost():
    s = slider(reciprocal=True)
    edge = release_amplitude(s, orbit(1e-9))
    assert edge < release_amplitude(replace(s, reciprocal=False), orbit(1e-9))
    regimes = [steady(s, orbit(k * edge), tolerance=1e-3).regime for k in (0.9999, 1.0001)]
    assert regimes == ["slip", "intermittent"]


@pytest.mark.slow
def test_a_height_that_is_not_forgotten_needs_no_settling():
    # the damper of the contacts keeps the start's height for 8e4 cycles; runs that start at the answer stay there
    body, waves = built(CORNERS[88])
    answer = steady(body, waves, tolerance=1e-3)
    other = cross_check(answer)
    assert abs(other.velocity - answer.velocity) < 2.0 * other.error < 1e-4 * answer.velocity
    # and lead back to it from a velocity and a height that are wrong
    doubted = cross_check(replace(answer, height=1.01 * answer.height, answer=replace(answer.answer, value=0.36)))
    assert abs(doubted.velocity - answer.velocity) < 2.0 * doubted.error < 1e-2 * answer.velocity


@pytest.mark.parametrize(
    "numbers",
    [
        {"mass": 1.0},  # keeps its velocity for 1e8 cycles
        {"mass": 1e-10},  # hops
        {"friction_coefficient": 5.0},
        {"contact_damping": 1e5},  # keeps its height
        {"normal_damping": 1e4},
        {"frequency": 9e3},  # repeats after four cycles
        {"tangential_ratio": 1e3},  # too fast for the steps
        {"corner": 14},  # flies, and nothing decides its height
    ],
)
def test_an_answer_that_is_a_fiftieth_off_is_wrong(monkeypatch, numbers):
    ((varied, value),) = numbers.items()
    assert outcome(varied, value).verdict == "right"

    def off(*given, **options):
        found = steady(*given, **options)
        shift = 0.02 * reference_speed(found.velocity, found.orbits)
        return replace(found, answer=replace(found.answer, value=found.velocity + shift))

    monkeypatch.setattr("contact.steady", off)
    assert outcome(varied, value).verdict == "WRONG"


def test_a_velocity_that_nothing_decides_is_no_cross_check():
    found = steady(slider(friction_coefficient=0.0, tangential_damping=0.0), orbit(5e-9), tolerance=1e-3)
    with pytest.raises(ConvergenceError, match="not settled"):
        cross_check(replace(found, answer=replace(found.answer, value=0.1)))


def test_a_deviation_that_does_not_decay_is_no_cross_check(monkeypatch):
    # a hundredth of the amplitude leads this slider to another motion, a ten-thousandth does not
    body, waves = built({"frequency": 9e3})
    answer = steady(body, waves, tolerance=1e-3)
    monkeypatch.setattr("studies.evidence.stability.cross_check.TRIALS", ((1e-2, 0),))
    with pytest.raises(ConvergenceError, match="a deviation from the answer is 1 times as large"):
        cross_check(answer)
