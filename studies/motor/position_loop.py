"""A position loop of sensor, controller and drive around any motor model with the interface `Moving`."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from studies.motor.controllers import Command, MotorNumbers, Reading

BANDS = (1e-7, 1e-8, 2e-9)  # m: error bands for which a move states the settling time
SAMPLES = 10  # samples of the true motion per controller period
REST_SHARE = 0.2  # last fraction of an unsettled move over which the error at rest is averaged


class Moving(Protocol):
    """Interface of a motor model that can be integrated in time, such as `studies.export.motor_model.MotorState`."""

    time: float
    position: float
    velocity: float
    deformation: float

    def advance(self, duration: float, level: float, *, force: float, preload: float | None) -> None:
        """Integrate over a duration in s."""


@dataclass(frozen=True, kw_only=True)
class Loop:
    """Sensor, controller period and disturbances of a position loop."""

    resolution: float = 1e-9  # quantisation step of the sensor, m; 0 for none
    noise: float = 3e-10  # standard deviation of a reading, m
    delay: float = 0.0  # age of a reading, s; a whole number of periods is used
    period: float = 1e-4  # of the controller, s
    force: float = 0.0  # external, on the slider along +x, from `force_at` on, N
    force_at: float = 0.0  # s
    preload: float | None = None  # N; None: that of the scene
    limit: float = 1.0  # time limit of a move, s
    hold: float = 5e-3  # time for which the controller must stay settled before a move ends, s
    seed: int = 0  # of the noise


@dataclass(frozen=True, kw_only=True)
class Drives:
    """Data of a motor's drives for the loop."""

    powers: tuple[float, float] = (0.0, 0.0)  # of the first and of the second drive, W per squared unit of the level
    direction: float = 1.0  # sign of the velocity under the first drive
    one_way: bool = False  # True if there is no second drive
    frequency: float = 0.0  # of the wave, Hz: bursts are rounded to whole cycles; 0 for no rounding


@dataclass(frozen=True, kw_only=True)
class Move:
    """One move to a target. Positions are relative to the initial position of the motor."""

    start: float  # m
    target: float  # m
    time: np.ndarray = field(repr=False)  # s, shape (k,), as the three below
    position: np.ndarray = field(repr=False)  # m
    velocity: np.ndarray = field(repr=False)  # m/s
    level: np.ndarray = field(repr=False)  # of the drive up to each instant, V or m
    within: dict[float, float]  # settling time in s by error band in m; nan if the true position does not settle in it
    overshoot: float  # largest distance beyond the target, m
    error_at_rest: float  # mean of the true position at the end of the move minus the target, m
    ring: float  # half of the range of the true position at the end of the move, m
    bursts: dict[str, int]  # number of bursts by phase
    energy: float  # into the transducers, J
    cycles: float  # number of driven cycles of the wave
    settled: bool  # whether the controller was settled at the end


def moved(
    motor: Moving, target: float, control: Callable[[Reading], Command], numbers: MotorNumbers, loop: Loop,
    drives: Drives,
) -> Move:  # fmt: skip
    """Simulate and return a move of a motor to a target; the state of the motor changes.

    Parameters
    ----------
    motor : Moving
        Where the motor is; advanced in place.
    target : float
        Position, m.
    control : callable
        The controller: called at the end of each burst, and otherwise each period, for the next `Command`. Its state is
        in ``reading.memory``, where it sets ``settled`` when the error needs no correction.
    numbers : MotorNumbers
        The motor's numbers for the controller.
    loop : Loop
    drives : Drives
    """
    random = np.random.default_rng(loop.seed)
    direction, frequency = drives.direction, drives.frequency
    delay_periods = round(loop.delay / loop.period)
    begin, start = motor.time, motor.position
    memory: dict = {}
    measured = [start] * (delay_periods + 1)
    bursts: dict = {}
    samples, energy, cycles, settled_time = [(0.0, start, motor.velocity, 0.0)], 0.0, 0.0, 0.0
    last = "rest"

    def advance(duration, level):
        nonlocal energy, cycles
        if duration <= 0.0:
            return
        steps = max(1, math.ceil(SAMPLES * duration / loop.period))
        for _ in range(steps):
            force = loop.force if motor.time >= loop.force_at else 0.0
            motor.advance(duration / steps, level * direction, force=force, preload=loop.preload)
            samples.append((motor.time - begin, motor.position, motor.velocity, level * direction))
        energy += drives.powers[int(level * direction < 0.0)] * level**2 * duration
        cycles += frequency * duration * (level != 0.0)

    while motor.time - begin < loop.limit:
        measured.append(motor.position)
        reading = measured[-1 - delay_periods] + loop.noise * random.standard_normal()
        if loop.resolution > 0.0:
            reading = loop.resolution * round(reading / loop.resolution)
        command = control(Reading(
            time=motor.time - begin, position=reading, target=target, period=loop.period, motor=numbers, memory=memory
        ))  # fmt: skip
        level = min(max(command.level, -numbers.level), numbers.level)
        if drives.one_way and level * direction < 0.0:
            level = 0.0  # no drive pushes the slider back
        duration = command.duration if frequency == 0.0 else round(command.duration * frequency) / frequency
        duration = duration if level != 0.0 else 0.0
        driven = level != 0.0 and duration > 0.0
        if driven and (command.phase in ("burst", "step") or last != command.phase):
            bursts[command.phase] = bursts.get(command.phase, 0) + 1
        last = command.phase if driven else "rest"
        advance(duration, level)
        # the controller is not called during a burst
        periods = max(1, math.ceil(duration / loop.period - 1e-9))
        advance(periods * loop.period - duration, 0.0)
        measured += [motor.position] * (periods - 1)
        settled_time = settled_time + loop.period if memory.get("settled") and not driven else 0.0
        if settled_time >= loop.hold:
            break
    return _evaluated(np.array(samples), target, bursts=bursts, energy=energy, cycles=cycles,
                      settled=bool(memory.get("settled")))  # fmt: skip


def replayed(motor: Moving, moves: tuple[Move, ...], loop: Loop) -> list[np.ndarray]:
    """Return the positions of another motor under the drive of successive moves; the state of that motor changes."""
    positions = []
    for move in moves:
        path = [motor.position]
        for duration, level in zip(np.diff(move.time), move.level[1:], strict=True):
            force = loop.force if motor.time >= loop.force_at else 0.0
            motor.advance(float(duration), float(level), force=force, preload=loop.preload)
            path.append(motor.position)
        positions.append(np.array(path))
    return positions


def _evaluated(samples: np.ndarray, target: float, *, settled: bool, **totals) -> Move:
    """Return a move with its settling times, overshoot, error at rest and ring from its samples, (k, 4)."""
    time, position, velocity, level = samples.T
    start = float(position[0])
    within = {}
    for band in BANDS:
        outside = np.flatnonzero(np.abs(position - target) > band)
        last = int(outside[-1]) + 1 if outside.size else 0
        within[band] = float(time[last]) if last < len(time) else math.nan
    tail = position[time >= time[-1] * (1.0 - REST_SHARE)] if len(time) > 1 else position
    if settled:  # average over the second half of the time since the last burst
        driven = np.flatnonzero(level != 0.0)
        undriven = position[(driven[-1] + 1 if driven.size else 0) :]
        tail = undriven[len(undriven) // 2 :]
    return Move(
        start=start, target=target, time=time, position=position, velocity=velocity, level=level, within=within,
        overshoot=max(0.0, float(np.max((position - target) * math.copysign(1.0, target - start)))),
        error_at_rest=float(np.mean(tail)) - target, ring=0.5 * float(np.ptp(tail)), settled=settled, **totals,
    )  # fmt: skip
