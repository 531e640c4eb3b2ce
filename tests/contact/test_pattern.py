"""The last cycle's stretches as a guess: they save time and decide nothing."""

import numpy as np
import pytest

from contact.answers.rest_motion import rest, rest_problem
from contact.events.segment import SampleColumn
from tests.contact.motors import orbit, slider

# what depends on how the motion is cut into stretches; a curve of the memory is as long as its stretch
LAYOUT = ("stretches", "halvings", "sweeps", "wipe_out", "smallest_gap")


def run(A, cycles, at_once, contacts=1, **given):
    orbits = tuple(orbit(A).scaled(np.exp(0.3j * k)) for k in range(contacts))
    problem = rest_problem(slider(**given), orbits)
    motion = rest(slider(**given), orbits, problem, nodes=12, truncation=1e-10)
    for _ in range(cycles // at_once):
        motion.turn(at_once)
    return motion


# Oracle: the same motion without any pattern, cycle by cycle
@pytest.mark.parametrize(
    ("A", "given"),
    [(1e-9, {}), (5e-9, {}), (20e-9, {}), (5e-9, {"contacts": 2}), (5e-9, {"stick_band": 1e-4}),
     (5e-9, {"reciprocal": True}), (5e-9, {"law": "hysteretic"})],
)  # fmt: skip
def test_the_pattern_changes_nothing_but_the_work(A, given):
    alone, patterned = run(A, 200, 1, **given), run(A, 200, 200, **given)
    kinds = [name for name in alone.events() if name not in LAYOUT]
    assert {k: alone.events()[k] for k in kinds} == {k: patterned.events()[k] for k in kinds}
    assert patterned.state[2] == pytest.approx(alone.state[2], rel=1e-9, abs=0)
    assert patterned.state[:2] == pytest.approx(alone.state[:2], rel=1e-7, abs=1e-12)
    assert patterned.events()["sweeps"] < 0.85 * alone.events()["sweeps"]


def test_calls_that_start_from_the_last_ones_pattern_take_the_work_of_one_call():
    at_once, warm = run(5e-9, 40, 40), run(5e-9, 1, 1)
    for _ in range(39):
        warm.turn(1, warm=True)
    assert warm.state == pytest.approx(at_once.state, rel=1e-9, abs=1e-12)
    assert warm.events()["sweeps"] < 1.05 * at_once.events()["sweeps"]


@pytest.mark.parametrize("contacts", [1, 3, 20])
def test_the_mean_height_is_that_of_the_positions(contacts):
    motion = run(5e-9, 30, 30, contacts=contacts)
    other, phases = motion.copy(), 2 * np.pi * (np.arange(2000) + 0.5) / 2000
    motion.begin()
    motion.turn(1)
    approach = other.move(0.0, 2 * np.pi, phases)[:, 0, SampleColumn.APPROACH]  # of a contact of height 0
    assert motion.mean_height(1) == pytest.approx(approach.mean(), abs=1e-5 * np.ptp(approach))
