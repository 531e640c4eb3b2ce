"""Three methods to compute the motion during a burst, and the choice among them.

Each method starts from a slider at rest at phase 0. It returns the motion at the end of the burst, its record (v, z_s),
the error of the last v (`error_estimate`) and statistics. A method refuses a problem to which it does not apply.
"""

import numpy as np

from contact.answers.burst_question import Burst
from contact.answers.event_driven_burst import EXACT_CYCLES, MAX_EXACT_CYCLES, ORDERS, exact_burst, exact_refusals
from contact.answers.rest_motion import rest
from contact.answers.stepped_burst import STEPS, stepped_burst, stepped_refusals
from contact.averaged.burst import averaged_run, refusals
from contact.choice import Choice, Method, Result, choose
from contact.codes import At, Recorded
from contact.error_estimate import averaged_burst_error
from contact.exceptions import ConvergenceError

# The first cycles in which the exact method checks the averaged one. Where averaging fails it fails in the first cycles
# too: 24 to 256 of them find no more (`tests/benchmarks/averaging_error.py`, `--checked`).
CHECKED = 16


def _averaged(burst):
    """Integrate the averaged equations, checked by the exact method in the first cycles."""
    nodes, truncation, _, _ = ORDERS[0 if burst.tolerance >= 1e-5 else 1]
    motion = rest(burst.slider, burst.orbits, burst.problem, nodes=nodes, truncation=truncation)
    motion.turn(1)
    checked = np.arange(2, min(CHECKED, burst.cycles - 1) + 1)
    try:  # from the segments of the first cycle on
        first = motion.copy().turn(checked.size, stride=1, warm=True)[:, Recorded.VELOCITY]
    except ConvergenceError:  # the estimate remains without check
        first = None
    motion, record, error, (velocities, stated), statistics = averaged_run(burst, motion, checked)
    true = None if first is None else float(np.max(np.abs(velocities - first)))
    error, velocity = averaged_burst_error(error, true, stated), float(motion.state[At.VELOCITY])
    return Result((motion, record), error, burst.allowed(velocity), statistics)


def _averaged_refusals(burst):
    reasons = refusals(burst.slider, burst.orbits)
    if burst.envelope is not None:
        reasons += ("it takes no envelope",)
    if burst.track is not None:
        reasons += ("it takes no track",)
    return (*reasons, f"{burst.cycles} cycles are too few") if burst.cycles < 3 else reasons


# The cheapest method comes first.
BURST_METHODS = {
    "averaged": Method(_averaged, _averaged_refusals),
    "stepped": Method(stepped_burst, lambda burst: stepped_refusals(burst.slider, burst.problem, STEPS[-2][0])),
    "exact": Method(exact_burst, exact_refusals),
}
METHODS = ("auto", *BURST_METHODS)


def run(method: str, burst: Burst) -> Choice:
    """Return the run (motion at the end, record) of a burst, its error and the method used.

    Method "auto" uses the exact method up to `EXACT_CYCLES` cycles; if it fails, and for longer bursts, the cheapest
    one within the tolerance. Only the exact method accumulates the energies in the motion's sums.
    """
    way = "leave the envelope out and use method exact" if burst.envelope is not None else "shorten the burst"
    fixed = burst.track is None  # along a track, fixed steps follow the orbits better than the events do
    return choose(
        BURST_METHODS, burst, method, what="a burst", exact=fixed and burst.cycles <= MAX_EXACT_CYCLES,
        exact_first=fixed and burst.cycles <= EXACT_CYCLES, way=way,
    )  # fmt: skip
