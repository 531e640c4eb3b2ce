"""Compile the contact's kernels ahead of the tests that need them: ``python -m tests.kernels PART``."""

import sys

from contact import burst, mean_motion
from contact.answers.load_and_stall import blocked_thrust
from contact.events.many_contacts import MANY
from tests.contact.motors import orbit, slider

WAVE = orbit(5e-9)


def compile_part(part: str) -> None:
    """Call each kernel of a part once; ``events`` and ``averages`` take about as long as each other."""
    once = {"duration": 2e-6, "after": 0.0, "samples": 2}
    if part == "events":
        burst(slider(law="hysteretic"), WAVE, tolerance=1e-3, method="exact", **once)
        burst(slider(), WAVE, tolerance=1e-2, method="stepped", **once)
        burst(slider(), tuple(WAVE.scaled(1.0 + 0.01 * k) for k in range(MANY)), tolerance=1e-3, method="exact", **once)
    else:
        mean_motion(slider(), WAVE)
        blocked_thrust(slider(), (WAVE,))
        burst(slider(), WAVE, tolerance=1e-3, method="exact", **once)
        burst(slider(), WAVE, tolerance=1e-2, method="averaged", **once)


if __name__ == "__main__":
    compile_part(sys.argv[1])
