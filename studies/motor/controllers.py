"""Controllers of a position loop, which convert a sensor reading into a command of the drive.

A controller is called once per period with a `Reading` and returns a `Command`: a signed level (positive levels push
the slider towards +x) and its duration. There are four kinds:

- ``two_phase``: full drive until friction alone stops the slider just before the target, then bursts. The length of a
  burst follows from the error and from the distances of earlier bursts.
- ``burst_length``: such bursts from the beginning.
- ``dead_zone_pi``: continuous drive by a proportional-integral controller with compensation of the dead zone, in which
  the wave does not move the slider (the method of Kurosawa's group, applied to the amplitude of the wave).
- ``FILE.py:FUNCTION``: a user's function of a `Reading` that returns a level, or a level and a duration in s.
"""

import math
import runpy
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from pathlib import Path

from studies.refusal import SceneError, nearest, refuse_if, refuse_unknown

MAX_BURST = 0.05  # longest burst, s


@dataclass(frozen=True, kw_only=True)
class MotorNumbers:
    """Numbers of a motor that a controller uses."""

    level: float  # largest level of the drive, V or m
    dead_zone: float  # threshold level, below which the slider does not move
    acceleration: float  # from rest at the largest level, m/s^2
    braking: float  # deceleration by friction without a wave, m/s^2
    delay: float  # from the drive to the wave under the slider, s
    speed_per_level: float  # steady speed at the largest level, divided by the excess of this level over the dead zone


@dataclass(kw_only=True)
class Reading:
    """Input of a controller."""

    time: float  # s
    position: float  # measured by the sensor, with delay and quantisation, m
    target: float  # m
    period: float  # of the controller, s
    motor: MotorNumbers
    memory: dict = field(default_factory=dict)  # the controller's own state: the same object at every call


@dataclass(frozen=True, kw_only=True)
class Command:
    """Command of the drive: ``level`` towards +x (V or m, signed) for ``duration`` s, then nothing."""

    level: float
    duration: float
    phase: str = ""  # coarse, burst, step or rest; only for the record


@dataclass(frozen=True, kw_only=True)
class TwoPhase:
    """Controller with a coarse continuous drive followed by bursts."""

    coarse: float = 1e-6  # error above which the drive is continuous, m
    tolerance: float = 1e-9  # error that needs no correction, m
    single: float = 2e-8  # error below which a burst counts as a single step, m
    readings: int = 20  # averaged before each burst, because the slider rings with little damping
    settle: float = 1e-3  # waiting time after a burst before the readings, s
    gain: float = 0.9  # fraction of the error that a burst corrects
    # Level of single steps over the threshold level. The largest level is unsuitable for small errors: a short burst of
    # a large wave makes the slider bounce, and a few cycles move it by more than the error.
    fine: float = 5.0

    def __call__(self, reading: Reading) -> Command:
        """Return the command of a reading."""
        memory, motor = reading.memory, reading.motor
        if memory.setdefault("phase", "coarse") == "coarse":
            command = self._coarse(reading, memory, motor)
            if command is not None:
                return command
        return self._burst(reading, memory, motor)

    def _coarse(self, reading: Reading, memory: dict, motor: MotorNumbers) -> Command | None:
        """Drive until friction will stop the slider just before the target; return None after its stop."""
        error = reading.target - reading.position
        last_position = memory.get("last")
        memory["last"] = reading.position
        speed = 0.0 if last_position is None else (reading.position - last_position) / reading.period
        direction = math.copysign(1.0, error)
        if "start" not in memory and abs(error) <= self.coarse:
            memory["phase"] = "burst"
            return None
        memory.setdefault("start", direction)
        if not memory.get("off"):
            # stopping distance: travel until the next decision takes effect and the wave has decayed, then braking by
            # friction
            reaction_time = reading.period + motor.delay
            speed_then = abs(speed) + motor.acceleration * reaction_time
            stopping_distance = speed_then * reaction_time + speed_then**2 / (2.0 * motor.braking)
            if abs(error) > stopping_distance + 0.5 * self.coarse and direction == memory["start"]:
                return Command(level=direction * motor.level, duration=reading.period, phase="coarse")
            memory["off"] = reading.time
        time_off = reading.time - memory["off"]
        if time_off < abs(speed) / motor.braking + self.settle + motor.delay:
            return Command(level=0.0, duration=reading.period, phase="coarse")
        memory["phase"] = "burst"
        return None

    def _burst(self, reading: Reading, memory: dict, motor: MotorNumbers) -> Command:
        """Average some readings, then return a burst whose length follows from the error."""
        no_drive = Command(level=0.0, duration=reading.period, phase="rest")
        if reading.time < memory.get("until", 0.0):
            return no_drive
        readings = memory.setdefault("readings", [])
        readings.append(reading.position)
        if len(readings) < self.readings:
            return no_drive
        position = sum(readings) / len(readings)
        memory["readings"] = []
        self._learn(position, memory, motor)
        error = reading.target - position
        memory["settled"] = abs(error) <= self.tolerance
        if memory["settled"]:
            return no_drive
        phase = "step" if abs(error) < self.single else "burst"
        level = min(self.fine * motor.dead_zone, motor.level) if phase == "step" and motor.dead_zone else motor.level
        gain = memory["gains"].get(phase, memory["gains"]["burst"])
        length = min(math.sqrt(self.gain * abs(error) / gain), MAX_BURST)
        memory |= {"from": position, "burst": (phase, length, math.copysign(1.0, error))}
        braking_time = length * motor.acceleration / motor.braking
        memory["until"] = reading.time + self.settle + length + motor.delay + braking_time
        return Command(level=math.copysign(level, error), duration=length, phase=phase)

    def _learn(self, position: float, memory: dict, motor: MotorNumbers) -> None:
        """Update the gain of distance = gain length^2 from the last burst; each phase has a separate gain."""
        a, b = motor.acceleration, motor.braking
        gains = memory.setdefault("gains", {"burst": 0.5 * a * (1.0 + a / b)})
        if "from" not in memory:
            return
        phase, length, direction = memory["burst"]
        old_gain = gains.get(phase, gains["burst"])
        distance = (position - memory.pop("from")) * direction
        # use only the square root of the ratio, because the contact springs change steps of a few nm
        gains[phase] = old_gain * min(max(distance / (old_gain * length**2), 0.25), 4.0) ** 0.5


@dataclass(frozen=True, kw_only=True)
class BurstLength(TwoPhase):
    """Controller that uses only bursts, whose length follows from the error."""

    coarse: float = math.inf


@dataclass(frozen=True, kw_only=True)
class DeadZonePI:
    """Continuous drive with level = dead zone + |u| in the direction of u, u = proportional e + integral (int e dt)."""

    proportional: float = 0.0  # level per m; 0: the steady speed is 100/s times the error
    integral: float = 0.0  # level per m and s; 0: 20/s times `proportional`
    tolerance: float = 1e-9  # error below which the drive is off, m
    windup: float = 0.2  # largest magnitude of the integral part, relative to the largest level

    def __call__(self, reading: Reading) -> Command:
        """Return the command of a reading."""
        memory, motor = reading.memory, reading.motor
        error = reading.target - reading.position
        memory["settled"] = abs(error) <= self.tolerance
        if memory["settled"]:
            return Command(level=0.0, duration=reading.period, phase="rest")
        proportional = self.proportional or 100.0 / motor.speed_per_level
        bound = self.windup * motor.level
        integral = self.integral or 20.0 * proportional
        total = memory.get("integral", 0.0) + integral * error * reading.period
        memory["integral"] = min(max(total, -bound), bound)
        u = proportional * error + memory["integral"]
        level = min(motor.dead_zone + abs(u), motor.level)
        return Command(level=math.copysign(level, u), duration=reading.period, phase="continuous")


CONTROLLERS = {"two_phase": TwoPhase, "burst_length": BurstLength, "dead_zone_pi": DeadZonePI}


def controller(name: str, settings: dict[str, float]) -> Callable[[Reading], Command]:
    """Return a controller by name with changed parameters, or a user's function ``FILE.py:FUNCTION``.

    Raises
    ------
    SceneError
        If there is no such controller, or it has no such parameter.
    """
    if ":" in name and name.partition(":")[0].endswith(".py"):
        if settings:
            raise SceneError("--loop", f"{next(iter(settings))} is no number of the loop, and {name} takes none")
        return _user_controller(name)
    refuse_unknown(name, [*CONTROLLERS, "FILE.py:FUNCTION"], "--controller")
    known = [each.name for each in fields(CONTROLLERS[name])]
    for key in settings:
        refuse_unknown(key, known, "--loop", f"{key} is no number of the loop or of {name}")
    return CONTROLLERS[name](**{key: int(each) if key == "readings" else each for key, each in settings.items()})


def _user_controller(name: str) -> Callable[[Reading], Command]:
    """Return a user's function as a controller."""
    file, _, function = name.rpartition(":")
    path = Path(file)
    refuse_if(not path.is_file(), "--controller", f"{file!r} is no file")
    try:
        content = runpy.run_path(file, run_name=f"sawmotor_controller_{path.stem}")
    except Exception as error:
        reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
        raise SceneError("--controller", f"{file!r} cannot be run: {reason}") from None
    user_function = content.get(function)
    if not callable(user_function):
        known = [name for name, each in content.items() if callable(each) and not name.startswith("_")]
        raise SceneError("--controller", f"{file!r} has no function {function!r}{nearest(function, known)}")

    def command(reading: Reading) -> Command:
        try:
            answer = user_function(reading)
        except Exception as error:
            reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
            raise SceneError("--controller", f"{name} failed at {reading.time:g} s: {reason}") from None
        level, duration = answer if isinstance(answer, tuple) else (answer, reading.period)
        are_numbers = all(isinstance(each, (int, float)) for each in (level, duration))
        rule = "must return a finite level, or a level and a duration in s"
        refuse_if(
            not (are_numbers and math.isfinite(level) and duration >= 0.0),
            "--controller",
            f"{name} {rule}, got {answer!r}",
        )
        return Command(level=float(level), duration=min(float(duration), MAX_BURST), phase="own")

    return command
