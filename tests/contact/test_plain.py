"""The kernels as plain Python and compiled: the same answers to rounding."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from contact import PassingWave, Pillars, UserLaw, mean_motion, pillar_motion
from contact.answers.rest_motion import rest, rest_problem
from contact.averaged.averaged_state import Span
from contact.averaged.riding import quadrature
from contact.averaged.transient import response
from contact.stepping.time_stepping import steps
from tests.contact.motors import orbit, slider

PUNCH = {"shape": "punch", "radius": 1e-6}
# as in test_user_law.py, for which the same kernels are compiled
OWN = "def sliding(approach, normal_force, slip_speed, contact): return normal_force * (0.15 + 0.4 * slip_speed)"
PAIR = (orbit(8e-9), orbit(6e-9).scaled(np.exp(0.7j)))


def events(cycles, A=8e-9, contacts=1, **given):
    """Return state, counts and sums after some cycles from rest, every event followed."""
    orbits = PAIR if contacts == 2 else (orbit(A),)
    problem = rest_problem(slider(**given), orbits)
    motion = rest(slider(**given), orbits, problem, nodes=9, truncation=1e-7)
    motion.turn(cycles)
    return [*motion.state, *motion.tally, *motion.energy()]


def stepped(**given):
    """Return state and rows after some cycles of fixed steps."""
    problem = rest_problem(slider(**given), PAIR)
    motion = rest(slider(**given), PAIR, problem, nodes=9, truncation=1e-7)
    rows = steps(problem, motion.state, 20, 32)
    return [*motion.state, *np.ravel(rows)]


def averaged(**given):
    """Return the averaged equilibrium of second order."""
    found = mean_motion(slider(**given), PAIR)
    return [found.velocity, found.first_order, found.height, found.relative_error]


def transient():
    """Return the averaged equations' state and rows after 300 cycles."""
    problem = rest_problem(slider(), (orbit(5e-9),))
    at, rows = 2.0 * np.pi * np.array([100.0, 200.0]), np.zeros((2, 2))
    state = np.array([-slider().rest_approach(1) / problem.length, 0.0, 0.0])
    span = Span(2.0 * np.pi * 300, 1e-4, 8, quadrature(8), 1, at, rows)
    response(problem, state, span, 8)
    return [*state, *np.ravel(rows)]


def pillars():
    """Return velocity, tilt, fields and powers of a scattered slider that loads waves from both sides."""
    x, y = np.repeat(np.arange(6) * 50e-6, 2), np.tile([0.0, 7e-5], 6)
    slider = Pillars(
        x=x - x.mean(), y=y - y.mean(), heights=5e-9 * np.cos(3.0 * np.arange(12)), normal_stiffness=1.8e6,
        tangential_stiffness=1.52e6, friction_coefficient=0.18, preload=0.03, tilt="free",
    )  # fmt: skip
    passing = PassingWave(
        frequency=9.6e6, wavelength=414e-6, ratio=0.89, forward=20e-9, backward=5e-9j, compliance=2.5e-12,
        strip_width=1e-4,
    )  # fmt: skip
    found = pillar_motion(slider, passing, load=2e-4)
    ends = found.exit_over_entry, found.reflected_over_entry
    return [found.velocity, *found.tilt, *(part for z in ends for part in (z.real, z.imag)), found.friction_power]


CASES = {
    "events": lambda: events(2),
    "events, two contacts": lambda: events(2, contacts=2),
    "events, stick band": lambda: events(2, stick_band=1e-3),
    "events, reciprocal force": lambda: events(2, reciprocal=True),
    "events, hysteretic": lambda: events(2, law="hysteretic"),
    "events, user law": lambda: events(2, friction=UserLaw("own.py", OWN)),
    "events, punch": lambda: events(2, **PUNCH),
    "events, heights": lambda: events(1, contacts=2, heights=(0.0, -2e-9)),
    "stepped": stepped,
    "stepped, heights": lambda: stepped(heights=(0.0, -2e-9)),
    "stepped, user law": lambda: stepped(friction=UserLaw("own.py", OWN)),
    "stepped, punch": lambda: stepped(**PUNCH),
    "averaged": averaged,
    "averaged, punch": lambda: averaged(**PUNCH),
    "averaged transient": transient,
    "pillars": pillars,
}


@pytest.fixture(scope="module")
def plain():
    """Return the answers of another process, whose kernels are plain Python."""
    code = "import json; from tests.contact.test_plain import CASES, listed; print(json.dumps(listed()))"
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    return json.loads(done.stdout)


def listed():
    """Return the answers of all cases as lists of numbers."""
    return {name: [float(x) for x in case()] for name, case in CASES.items()}


@pytest.mark.parametrize("name", CASES)
def test_plain_and_compiled_kernels_agree(plain, name):
    # Property: one source, two ways to run it
    # the pillars' equilibrium is iterated to 1e-12
    near = 1e-10 if name == "pillars" else 1e-13
    assert [float(x) for x in CASES[name]()] == pytest.approx(plain[name], rel=near, abs=1e-15)
