"""300 drawn motors answer as they did when balls and pillars were two sliders (regression; see `drawn_motors`)."""

import numpy as np
import pytest

from tests.contact.drawn_motors import AVERAGED, COLUMNS, COUNT, STORED, on_a_wave, on_orbits
from tests.motors import balls_on_orbits, contacts_on_a_wave

NUMBERS = [range(0, 8), *(range(first, first + 30) for first in range(0, COUNT, 30))]


def reference(velocity, orbits):
    """Return the speed over which errors are stated, m/s."""
    largest = max(2.0 * np.pi * each["frequency"] * abs(each["tangential"]) for each in orbits)
    return max(abs(velocity), largest / 10.0)


@pytest.mark.parametrize("numbers", NUMBERS, ids=lambda numbers: f"{numbers.start} to {numbers.stop - 1}")
def test_balls_on_their_orbits_answer_as_before(numbers):
    stored = np.load(STORED)["on_orbits"]
    for number in numbers:
        before, now = stored[number], np.array(on_orbits(number))
        body, orbits = balls_on_orbits(number)
        assert np.array_equal(np.isnan(before), np.isnan(now)), number
        velocity, first, height, error, thrust = before[: len(AVERAGED)]
        if np.isfinite(velocity):
            unit = reference(velocity, orbits)
            assert now[1] == pytest.approx(first, rel=0.0, abs=1e-9 * unit), number
            assert now[0] == pytest.approx(velocity, rel=0.0, abs=(error + now[3] + 1e-12) * unit), number
            assert now[2] == pytest.approx(height, rel=1e-9), number
            assert now[4] == pytest.approx(thrust, rel=1e-9, abs=1e-12 * body["preload"]), number
        full, stated = before[len(AVERAGED) :]
        if np.isfinite(full):
            close = (stated + now[-1] + 1e-12) * reference(full, orbits)
            assert now[-2] == pytest.approx(full, rel=0.0, abs=close), number


@pytest.mark.parametrize("numbers", NUMBERS, ids=lambda numbers: f"{numbers.start} to {numbers.stop - 1}")
def test_contacts_on_a_passing_wave_answer_as_before(numbers):
    stored = np.load(STORED)["on_a_wave"]
    for number in numbers:
        before, now = (
            dict(zip(COLUMNS, stored[number], strict=True)),
            dict(zip(COLUMNS, on_a_wave(number), strict=True)),
        )
        body, wave, question = contacts_on_a_wave(number)
        assert np.isnan(before["velocity"]) == np.isnan(now["velocity"]), number
        if np.isnan(before["velocity"]):
            continue
        speed = 2.0 * np.pi * wave["frequency"] * wave["forward"]
        # overtones: as many as the stated error asks for
        close = 1e-9 if question["loading"] != "harmonics" else before["error"] + now["error"]
        units = {
            "velocity": speed, "approach": wave["forward"], "pitch": wave["forward"] / max(np.ptp(body["x"]), 1e-9),
            "roll": wave["forward"] / max(np.ptp(body["y"]), 1e-9), "exit": 1.0, "exit_imag": 1.0,
            "friction_power": speed * body["friction_coefficient"] * body["preload"], "share": 1.0,
        }  # fmt: skip
        for name, unit in units.items():
            assert now[name] == pytest.approx(before[name], rel=close, abs=close * unit), (number, name)
