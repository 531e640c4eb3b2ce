"""Answers of another version of the program for 300 drawn motors, stored in `tests/data/drawn_motors.npz`.

The file holds those of commit dc062ab3, in which balls and pillars were two sliders with two equilibria. To make it
anew from a checkout of that commit:

    mkdir mixed && ln -s THIS/tests mixed/tests && ln -s OTHER/contact mixed/contact
    cd mixed && python -m tests.contact.drawn_motors THIS/tests/data/drawn_motors.npz
"""

import math
import sys
from pathlib import Path

import numpy as np

import contact
from contact import ConvergenceError, InputError, Orbit, PassingWave, Slider, mean_motion, steady
from tests.motors import balls_on_orbits, contacts_on_a_wave

COUNT = 150  # of each kind
STORED = Path(__file__).parents[1] / "data" / "drawn_motors.npz"
TOLERANCE = 1e-6  # of `steady`
AVERAGED = "velocity", "first_order", "height", "relative_error", "blocked_thrust"
# of a slider on a passing wave: velocity, its relative error, approach, tilts, U_exit/U_entry, loss to friction (in the
# stored version with the leak of a ball's law in it), share of the contacts that touch
COLUMNS = "velocity", "error", "approach", "pitch", "roll", "exit", "exit_imag", "friction_power", "share"


def on_orbits(number: int) -> list[float]:
    """Return `AVERAGED` of a drawn slider, then velocity and relative error of its full motion; NaN where refused."""
    body, orbits = balls_on_orbits(number)
    slider, orbits = Slider(**body), tuple(Orbit(**each) for each in orbits)
    averaged = [math.nan] * len(AVERAGED)
    try:
        found = mean_motion(slider, orbits)
        averaged = [float(getattr(found, name)) for name in AVERAGED]
    except ConvergenceError:
        pass
    try:
        full = steady(slider, orbits, tolerance=TOLERANCE)
    except ConvergenceError:
        return [*averaged, math.nan, math.nan]
    return [*averaged, full.velocity, full.relative_error]


def on_a_wave(number: int) -> list[float]:
    """Return `COLUMNS` of a drawn slider on a passing wave; NaN where refused."""
    body, wave, question = contacts_on_a_wave(number)
    try:
        found = contact.pillar_motion(contact.Pillars(**body), PassingWave(**wave), **question)
    except (ConvergenceError, InputError):
        return [math.nan] * len(COLUMNS)
    return [
        found.velocity, found.relative_error, found.approach, *found.tilt, found.exit_over_entry.real,
        found.exit_over_entry.imag, found.friction_power + found.leak_power, found.share_in_contact,
    ]  # fmt: skip


if __name__ == "__main__":
    numbers = range(COUNT)
    np.savez_compressed(
        sys.argv[1], on_orbits=[on_orbits(k) for k in numbers], on_a_wave=[on_a_wave(k) for k in numbers]
    )
