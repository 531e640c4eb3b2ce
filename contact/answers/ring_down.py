"""The ring-down of the surface after a burst: an envelope on the wave that the slider follows in fixed time steps."""

import math

import numpy as np

from contact.answers.stepped_burst import STEPS, stepped_refusals
from contact.choice import refused
from contact.stepping.along_track import steps_along
from contact.stepping.time_stepping import steps

ENVELOPE_OUT = "leave the envelope out, or give the elastic law without reciprocal force and stick band, and more mass"
# SPENT: a ring-down ends when the amplitude is below this fraction of the envelope's maximum. A wave that is cut there
# shifts the final position, by up to 4.2 times its amplitude (`error_estimate.CUT`).
# RINGING_STEPS: minimum number of steps per cycle during the ring-down.
SPENT, RINGING_STEPS = 1e-7, 80


def ring_down(slider, motion, envelope, *, longest=math.inf, samples=0, least=RINGING_STEPS, track=None, start=0.0):
    """Move the slider in fixed time steps while the surface rings down.

    Returns (times in s from the end of the burst, record) of about `samples` samples, or one per cycle if it is 0; with
    a `track` (`Scaled`) on which the slider is displaced by `start` at first, also the motion along it (`Followed`).
    """
    frequency = motion.problem.omega / (2.0 * math.pi)
    number = shaped_steps(slider, motion.problem, least)
    cycles = max(0, math.ceil(min(spent(envelope), longest) * frequency))
    stride = max(1, cycles // samples) if samples else 1
    cycles -= cycles % stride
    if track is not None:
        way = steps_along(
            motion.problem, motion.state, track, cycles, number, stride=stride, envelope=envelope, start=start
        )
        return stride * np.arange(1, len(way.record) + 1) / frequency, way.record, way
    record = steps(motion.problem, motion.state, cycles, number, stride=stride, envelope=envelope)
    return stride * np.arange(1, len(record) + 1) / frequency, record


def shaped_steps(slider, problem, least: int) -> int:
    """Return the smallest number of steps per cycle, from `least` and `STEPS`, that can follow an envelope."""
    for number in (least, *(number for number, _ in STEPS if number > least)):
        reasons = stepped_refusals(slider, problem, number)
        if not reasons:
            return number
    raise refused("an envelope", {"stepped": reasons}, ENVELOPE_OUT)


def spent(envelope):
    """Return the time in s at which an envelope has fallen to SPENT of its maximum for good, or its last time."""
    level = SPENT * np.max(envelope.amplitude)
    loud = np.flatnonzero(envelope.amplitude > level)
    if loud.size == 0:
        return 0.0
    last = loud[-1]
    if last + 1 == envelope.time.size:
        return float(envelope.time[last])
    ends = envelope.amplitude[last + 1], envelope.amplitude[last]
    return float(np.interp(level, ends, (envelope.time[last + 1], envelope.time[last])))
