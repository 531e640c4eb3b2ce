r"""After a burst the surface rings down under the slider: the last of the wave, in fixed steps, until it is spent."""

import math

import numpy as np

from contact.answers.methods import STEPS, why_not_stepped
from contact.convergence import ConvergenceError
from contact.envelope import Envelope

# of the largest factor: what is left stands still; and the steps per cycle that are wanted
SPENT, WANTED = 1e-3, 64


def ring_down(slider, problem, motion, envelope: Envelope, *, frequency: float, longest: float, rows: int):
    """Move a slider through the ring-down; return (times in s from its start, about `rows` rows (v, z_s, mean v)).

    `motion` stands at the end of the burst of the problem, at phase 0, and its state is moved; the time of the
    envelope starts there. `frequency` of the wave in Hz, `longest` the most to follow, s. Where fixed steps do not
    apply, a ConvergenceError has the status "not applicable".
    """
    from contact.solve.time_stepping import steps

    serving = [n for n, _ in STEPS if n >= WANTED and not why_not_stepped(slider, problem, n)]
    if not serving:
        reason = why_not_stepped(slider, problem, STEPS[-1][0])
        raise ConvergenceError("not applicable", f"a ring-down needs fixed steps: {reason}")
    loud = np.flatnonzero(envelope.amplitude > SPENT * np.max(envelope.amplitude))
    until = min(float(envelope.time[loud[-1]]) if loud.size else 0.0, longest)
    cycles = max(0, math.ceil(until * frequency))
    stride = max(1, cycles // max(1, rows))
    cycles -= cycles % stride
    if cycles == 0:
        return np.empty(0), np.empty((0, 3))
    shape = envelope.at(np.arange(cycles + 1) / frequency)
    found = steps(problem, motion.state, cycles, serving[0], stride=stride, envelope=shape)
    return stride * np.arange(1, len(found) + 1) / frequency, found
