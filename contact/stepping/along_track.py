r"""Fixed steps of a slider that travels along a wave whose orbits depend on its place.

The steps are those of `time_stepping`. At the end of each cycle the orbits are interpolated for the place to which the
slider will have come there, by Lagrange's polynomial through six nodes of a `Track`. Within the cycle they are linear,
u = Re(U(phi) e(phi) exp(i phi)), with the envelope e of the burst as in `time_stepping`. A slider passes 1e-4
wavelengths in a cycle, so that a quadratic part of U would be 1e-8 of it.
"""

from typing import NamedTuple

import numpy as np

from contact.codes import At, Recorded
from contact.exceptions import ConvergenceError
from contact.jit.compiled import compiled, native
from contact.stepping.time_stepping import (
    StepContact,
    StepSlider,
    SurfaceRow,
    Task,
    Work,
    begin_steps,
    factor,
    knots_of,
    one_step,
)
from contact.track import BLOCK, NODES, Track

AHEAD = 3 * BLOCK  # nodes on either side of the slider that are given to the kernel at a time
ENDED, FULL_WINDOW, OVERFLOW = 0, 1, 2  # why the kernel returned


class Way(NamedTuple):
    """The part of a track about the slider, and where the slider is on it; scaled."""

    place: np.ndarray  # (5,): displacement, that of the last cycle, cycles passed, 1.0 once begun, knot of the envelope
    first: float  # displacement of the first node
    step: float
    low: float  # displacements at which the kernel returns
    high: float
    nodes: np.ndarray  # (2, n, k): U_x and U_z
    wave: np.ndarray  # (2, 2, n): the same at the start and the end of a cycle
    circle: np.ndarray  # (2, steps + 1): cosine and sine of the phase
    travelled: np.ndarray  # (samples,): displacement at each sample


@compiled
def _at_place(way, displacement):
    """Make the amplitudes at a displacement, by six nodes, those of the end of the cycle.

    Those of its end so far become those of its start.
    """
    t = (displacement - way.first) / way.step
    base = min(max(int(np.floor(t)) - 2, 0), way.nodes.shape[2] - NODES)
    for part in range(2):
        for i in range(way.wave.shape[2]):
            way.wave[0, part, i] = way.wave[1, part, i]
            way.wave[1, part, i] = 0.0
    for k in range(NODES):
        weight = 1.0
        for j in range(NODES):
            if j != k:
                weight *= (t - base - j) / (k - j)
        for part in range(2):
            for i in range(way.wave.shape[2]):
                way.wave[1, part, i] += weight * way.nodes[part, i, base + k]


@compiled
def _tabulate(way, per_cycle, cycle, envelope, table):
    """Fill the surface's displacement and velocity at the steps of a cycle whose ends have the amplitudes `way.wave`.

    The table is in the order of `time_stepping.SurfaceRow`.
    """
    h = 2.0 * np.pi / per_cycle
    # the last knot of a cycle may lie at its end, where the next cycle begins
    j = max(int(way.place[4]) - 1, 0)
    for k in range(per_cycle + 1):
        e, e_rate, j = factor(envelope, 2.0 * np.pi * cycle + h * k, j)
        turn = complex(way.circle[0, k], way.circle[1, k])
        for part in range(2):
            place, speed = (SurfaceRow.U_X, SurfaceRow.W_X) if part == 0 else (SurfaceRow.U_Z, SurfaceRow.W_Z)
            for i in range(way.wave.shape[2]):
                change = way.wave[1, part, i] - way.wave[0, part, i]
                here = way.wave[0, part, i] + change * (k / per_cycle)
                u = e * here * turn
                w = (e_rate * here + e * change / (2.0 * np.pi)) * turn
                table[place, k, i] = u.real
                table[speed, k, i] = w.real - u.imag
    way.place[4] = j


@native(
    "t f1 t t t",
    {
        "problem.paths.height": "n", "problem.factors.stiffness": "n", "problem.factors.limit_slope": "n",
        "state": "3+n", "task.record": "m 3", "task.envelope.at": "e", "task.envelope.amplitude": "e",
        "task.envelope.angle": "e", "way.place": "5", "way.nodes": "2 n k",
        "way.wave": "2 2 n", "way.circle": "2 s", "way.travelled": "m", "work.table": "4 s n", "work.contact": "3 n",
        "work.slider": "9",
    },
)  # fmt: skip
def _follow(problem, state, task, way, work):
    """Go on until all cycles are done or the slider leaves the window; return why it ended."""
    per_cycle, slider, envelope, place = task.per_cycle, work.slider, task.envelope, way.place
    if place[3] == 0.0:
        for _ in range(2):  # both ends of a cycle without change
            _at_place(way, place[0])
        _tabulate(way, per_cycle, 0, envelope, work.table)
        begin_steps(problem, state, per_cycle, work)
        place[3] = 1.0
    why = ENDED
    for cycle in range(int(place[2]), task.number):
        ahead = place[0] + place[1]
        if ahead < way.low or ahead > way.high:
            why = FULL_WINDOW
            break
        _at_place(way, ahead)
        _tabulate(way, per_cycle, cycle, envelope, work.table)
        slider[StepSlider.TRAVELLED] = 0.0
        for k in range(per_cycle):
            one_step(problem, k, work)
        if not np.isfinite(
            slider[StepSlider.POSITION] + slider[StepSlider.NORMAL_VELOCITY] + slider[StepSlider.VELOCITY]
        ):
            return OVERFLOW
        place[0] += slider[StepSlider.TRAVELLED]
        place[1], place[2] = slider[StepSlider.TRAVELLED], cycle + 1.0
        if task.stride > 0 and (cycle + 1) % task.stride == 0:
            row = (cycle + 1) // task.stride - 1
            recorded = task.record[row]
            recorded[Recorded.VELOCITY] = slider[StepSlider.VELOCITY]
            recorded[Recorded.POSITION] = slider[StepSlider.POSITION]
            recorded[Recorded.MEAN_VELOCITY] = slider[StepSlider.TRAVELLED] / (2.0 * np.pi)
            way.travelled[row] = place[0]
    state[At.POSITION], state[At.NORMAL_VELOCITY] = slider[StepSlider.POSITION], slider[StepSlider.NORMAL_VELOCITY]
    state[At.VELOCITY] = slider[StepSlider.VELOCITY]
    for i in range(work.contact.shape[1]):
        state[At.DEFORMATIONS + i] = work.contact[StepContact.X, i]
    return why


class Scaled(NamedTuple):
    """A track in the units of a problem, for a slider that is driven towards +x."""

    track: Track
    side: float  # -1.0 where the problem is the mirror image of the track
    turn: complex  # factor on the amplitudes: the phase at which the problem begins, over its unit of length
    length: float  # m

    @property
    def limits(self) -> tuple[float, float]:
        """Displacements at which it ends, scaled and rising."""
        low, high = sorted(self.side * each / self.length for each in self.track.limits)
        return low, high

    @property
    def step(self) -> float:
        """Distance of two nodes, scaled."""
        return self.track.step / self.length

    def nodes(self, first: int, last: int) -> np.ndarray:
        """Return U_x and U_z at nodes from the lower end on, scaled, shape (2, n, last - first)."""
        if self.side > 0.0:
            return np.ascontiguousarray(self.turn * self.track.values(first, last))
        count = self.track.count
        mirrored = self.track.values(count - last, count - first)[:, :, ::-1]
        return np.ascontiguousarray(self.turn * np.array([-mirrored[0], mirrored[1]]))

    def at(self, place: float) -> np.ndarray:
        """Return U_x and U_z at a displacement, scaled, shape (2, n)."""
        u_x, u_z = self.turn * self.track.at([self.side * place * self.length])[:, :, 0]
        return np.array([self.side * u_x, u_z])

    def window(self, place: float) -> tuple[float, np.ndarray, tuple[float, float]]:
        """Return (first displacement, nodes, ends) of the part about a displacement."""
        low, high = self.limits
        middle, count = int((place - low) / self.step), self.track.count
        begin, end = max(0, middle - AHEAD), min(count, middle + AHEAD)
        ends = (
            low if begin == 0 else low + (begin + BLOCK) * self.step,
            high if end == count else low + (end - BLOCK) * self.step,
        )
        return low + begin * self.step, self.nodes(begin, end), ends


class Followed(NamedTuple):
    """A motion along a track; scaled."""

    record: np.ndarray  # (samples, len(`Recorded`)), of the cycles that were followed
    displacement: np.ndarray  # (samples,)
    cycles: int  # fewer than asked if the slider came to an end of the track
    place: float  # displacement at the end
    ended: bool  # whether it came to an end of the track


def steps_along(problem, state, scaled, number, per_cycle, *, stride=1, envelope=None, start=0.0) -> Followed:
    """Move the slider through whole cycles of equal steps along a track, until it ends.

    `state`, `stride` and `envelope` as in `time_stepping.steps`; `scaled`: `Scaled`; `start`: the displacement at the
    beginning.
    """
    n = problem.contacts
    work = Work(
        np.empty((len(SurfaceRow), per_cycle + 1, n)), np.empty((len(StepContact), n)), np.zeros(len(StepSlider))
    )
    samples = number // stride if stride else 0
    record = np.empty((samples, len(Recorded)))
    task = Task(number, per_cycle, stride, record, knots_of(problem, envelope))
    place, (low, high) = np.array([start, 0.0, 0.0, 0.0, 0.0]), scaled.limits
    first, nodes, ends = scaled.window(start)
    phase = 2.0 * np.pi / per_cycle * np.append(np.arange(per_cycle), 0)
    way = Way(
        place, first, scaled.step, ends[0], ends[1], nodes, np.empty((2, 2, n), complex),
        np.array([np.cos(phase), np.sin(phase)]), np.empty(samples),
    )  # fmt: skip
    while True:
        why = _follow(problem, state, task, way, work)
        if why == OVERFLOW:
            raise ConvergenceError("not finite", "the stepped motion overflowed; use method exact")
        if why == ENDED or not low < place[0] + place[1] < high:
            break
        first, nodes, ends = scaled.window(place[0])
        way = way._replace(first=first, nodes=nodes, low=ends[0], high=ends[1])
    cycles = int(place[2])
    done = cycles // stride if stride else 0
    return Followed(record[:done], way.travelled[:done], cycles, float(place[0]), cycles < number)
