"""Predictions of measurements of one motor, for many sets of its numbers at once.

The steady states of all sets and levels are solved together, as all other steady states
(`studies.solve.steady_states`); a burst is followed as in a run.
"""

import logging
import math
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

import contact
from studies.inverse.free_parameters import (
    AMPLITUDE_FACTOR,
    AMPLITUDE_PER_VOLT,
    BANDWIDTH,
    SAMPLING,
    TIME_OFFSET,
    WAVE_VELOCITY_FACTOR,
)
from studies.lab.encoder import recorded, travelled_distance
from studies.lab.measurement import Measurement
from studies.lab.s_parameters import NetworkData
from studies.lab.scan import Scan
from studies.model.model import POSITION_KEYS, Model, changes_stator
from studies.model.resolve import following, resolved
from studies.model.wave_to_contact import Contact
from studies.progress import Countdown
from studies.record.quantities import quantity
from studies.record.values import as_array
from studies.refusal import SceneError, refuse_if
from studies.scene import Scene
from studies.scene.override import value_at
from studies.solve.loaded_wave import wave_velocity
from studies.solve.plane_rates import PlaneRates, plane_rates
from studies.solve.predictor import Predictor
from studies.solve.ripple import Known, NearbyContact, ripples
from studies.solve.scan_prediction import at_other_velocity, network_prediction, placed, predicted_scan
from studies.solve.slider_burst import followed_burst
from studies.solve.steady_states import steady_answers
from studies.solve.wave_ripple import mean_velocity

LOGGER = logging.getLogger(__name__)

MAX_RATES = 10_000  # motions in the plane in memory
MAX_FIELDS = 64  # predictions of scans and networks in memory, each of one stator

IN_PLANE = ("velocity", "lateral velocity", "yaw rate")  # quantities of `PlaneRates`


class MeasurementPredictor(Predictor):
    """Predictions of measurements of one scene with changed numbers.

    Words such as "auto" become numbers before any key is changed; a preload of "weight" and the moduli of a named ball
    follow the changed keys (`studies.model.resolve.following`).  ``tolerance``: of the velocity, for the stator.
    """

    def __init__(self, scene: Scene, *, tolerance: float = 1e-3):
        if scene.wave is None and not scene.transducer:
            scene.refuse("transducer", "is missing: a driven stator or a [wave] is needed")
        numbers = resolved(scene)
        table = following(numbers, scene).to_table()
        super().__init__(table, tolerance=tolerance, rounds=1, numbers=numbers.to_table())
        self._fields: dict = {}  # data and prediction of scans and networks, by (stator, identity of the data)
        self._rates: dict[tuple, PlaneRates] = {}  # of motions in the plane, by the numbers of the motor and level
        self._last_rates: dict[float, PlaneRates] = {}  # by level
        self._countdown: Countdown | None = None
        self._done, self._last_report = 0, 0.0

    def begin(self, stage: str, total: int = 0) -> None:
        """Report a stage and count its predictions from 0; ``total``: their number, 0 if it is unknown."""
        self._countdown = Countdown(stage, total, "predictions")
        self._done, self._last_report = 0, time.monotonic()
        LOGGER.info(stage)

    def _count_one(self) -> None:
        """Count a prediction, and report the number of them about once a second."""
        self._done += 1
        if self._countdown is not None and time.monotonic() > self._last_report + 1.0:
            self._last_report = time.monotonic()
            LOGGER.info(self._countdown.text(self._done))

    @property
    def prescribed_wave(self) -> bool:
        """True if the scene prescribes the surface motion by its [wave]."""
        return "wave" in self.scenes.table

    @property
    def slider(self) -> bool:
        """True if the scene has a slider."""
        return self.stators.slider

    def contact(self, changes: dict, goal: float | None = None) -> Contact:
        """Return the contact with some keys changed; ``amplitude_factor`` among them multiplies its motion."""
        driven, factor = super().contact(changes, goal), changes.get(AMPLITUDE_FACTOR, 1.0)
        surface = driven.surface if driven.surface is None or factor == 1.0 else driven.surface_at(factor)
        amplitudes = tuple(each * factor for each in driven.amplitudes)
        return replace(driven, orbits=driven.at(factor), amplitudes=amplitudes, surface=surface)

    @property
    def one_by_one(self) -> bool:
        """True on pillars, where velocities are solved one by one (0.06 s for 2500 pillars) and not in one loop."""
        return "pillars" in self.scenes.table.get("slider", {})

    @property
    def costly(self) -> bool:
        """True where a velocity takes up to 0.1 s: on pillars, and in the plane on waves of several frequencies."""
        return self.one_by_one or (self.slider and self.scene({}).planar)

    def value(self, key: str) -> float | None:
        """Return the scene's own value of a key as a number; None where it has none."""
        if key in (AMPLITUDE_FACTOR, WAVE_VELOCITY_FACTOR):
            return 1.0
        value = value_at(self.scenes.numbers, key) if "." in key else None
        return value if isinstance(value, (int, float)) and not isinstance(value, bool) else None

    def needs_stator(self, key: str) -> bool:
        """Return whether a change of the key requires a new solution of the stator."""
        return not self.prescribed_wave and (key in POSITION_KEYS or changes_stator(key))

    def predict(self, questions: list[tuple[Measurement, dict]], *, travelling: bool = True) -> list[np.ndarray]:
        """Return the values of measurements, each with its own numbers by key; NaN where there is no answer.

        ``travelling``: False leaves the slider of a burst at its position, on a wave without ring-up.

        The steady velocities of all questions are solved together at the end.
        """
        answers: list[np.ndarray | slice] = []  # a slice: of the velocities of ``states``
        states: list[tuple[Contact, float]] = []
        for measurement, numbers in questions:
            self._count_one()
            numbers = numbers | measurement.settings
            data = measurement.network or measurement.scan
            if data is not None:
                answers.append(self._field(measurement, data, numbers))
                continue
            self.stators.nearby = self.stators.nearby or measurement.quantity == "mean velocity"
            driven = self.contact(numbers)
            factors = self._factors(measurement, numbers, driven)
            if measurement.quantity in IN_PLANE and (driven.scene.planar or measurement.quantity != "velocity"):
                answers.append(self._in_plane(measurement, driven, factors, numbers))
            elif measurement.quantity == "velocity" and self.one_by_one:
                answers.append(self.velocities([(driven, float(factor)) for factor in factors]))
            elif measurement.quantity == "velocity":
                answers.append(slice(len(states), len(states) + len(factors)))
                states += [(driven, float(factor)) for factor in factors]
            elif measurement.quantity == "mean velocity":
                answers.append(self._mean_velocities(driven, factors, numbers))
            elif measurement.quantity == "amplitude":
                answers.append(factors * driven.amplitude)
            elif measurement.quantity in ("burst", "position"):
                answers.append(self._burst(measurement, driven, float(factors[0]), numbers, travelling))
            elif measurement.quantity == "ring-down frequency":
                answers.append(np.array([driven.moving_slider.tangential_resonance(driven.contacts)]))
            else:
                raise ValueError(f"no prediction of the quantity {measurement.quantity!r}")
        velocities = self.velocities(states) if states else np.empty(0)
        return [velocities[each] if isinstance(each, slice) else each for each in answers]

    def _field(self, measurement: Measurement, data: NetworkData | Scan, numbers: dict) -> np.ndarray:
        """Return the values of a scan or of a network analyser's file; complex ones as real, then imaginary parts.

        The phase of a scan has an arbitrary origin: the prediction is multiplied by the phase factor that fits best.
        """
        model = self.scenes.model(numbers)
        if model.scene.stator is None:
            raise SceneError(f"measurements {measurement.name}", "needs a scene with a stator")
        stator = model.alone
        if isinstance(data, NetworkData):
            scattering = self._once(stator, data, partial(network_prediction, model, data, tolerance=self.tolerance))
            return data.flat(scattering)
        scan = placed(model.scene, data, "measurements")
        motion = self._once(stator, data, partial(predicted_scan, model, scan, tolerance=self.tolerance))
        motion = motion * numbers.get(AMPLITUDE_FACTOR, 1.0)
        motion = at_other_velocity(model, scan, motion, numbers.get(WAVE_VELOCITY_FACTOR, 1.0))
        if not scan.is_complex:
            return np.abs(motion)
        if measurement.values:
            motion = motion * np.exp(1j * np.angle(np.vdot(motion, scan.values)))
        return np.concatenate([motion.real, motion.imag])

    def _once(self, stator: Model, data: NetworkData | Scan, predict: Callable[[], Any]) -> Any:
        """Return a prediction that is computed once for each stator and data."""
        key = stator, id(data)
        if key not in self._fields:
            if len(self._fields) > MAX_FIELDS:
                self._fields.clear()
            self._fields[key] = data, predict()  # with the data, so that no other object takes their identity
        return self._fields[key][1]

    def _factors(self, measurement: Measurement, numbers: dict, driven: Contact) -> np.ndarray:
        """Return the factors on the contact's orbits at the levels of a measurement."""
        if not measurement.levels:
            return np.array([max(driven.scene.levels)])
        levels = np.array(measurement.levels)
        if measurement.level_key == quantity.normal_amplitude_m.column:
            return levels / driven.amplitude
        if not self.prescribed_wave:
            return levels
        refuse_if(
            AMPLITUDE_PER_VOLT not in numbers,
            f"measurements {measurement.name}",
            "holds voltages, and a [wave] has none: state amplitude_per_volt=LENGTH after the file, or free it",
        )
        return levels * numbers[AMPLITUDE_PER_VOLT]

    def velocities(self, states: list[tuple[Contact, float]]) -> np.ndarray:
        """Return the steady velocity of each contact at a level, m/s; NaN where there is none."""
        if self.one_by_one:
            return np.array([wave_velocity(driven, level) for driven, level in states])
        answers = steady_answers(states, self.tolerance)
        return as_array(answer.point.velocity_m_per_s for answer in answers)

    def _in_plane(self, measurement: Measurement, driven: Contact, levels: np.ndarray, numbers: dict) -> np.ndarray:
        """Return one component of the motion in the plane at levels; NaN where there is none.

        A motion is measured in up to three quantities: those that are known are kept, and the last one of a level is
        where the search for the next begins.
        """
        slider, quantity_of = driven.scene.slider, measurement.quantity
        refuse_if(
            not driven.scene.planar or (quantity_of == "yaw rate" and not slider.turns),
            f"measurements {measurement.name}",
            f"holds a {quantity_of}: it needs a slider that moves in the plane, or turns",
        )
        rule = f"holds a {quantity_of}: a slider on an axle has a yaw rate alone, yaw_rate_rad_per_s"
        refuse_if(slider.axis is not None and quantity_of != "yaw rate", f"measurements {measurement.name}", rule)
        motor, found = repr(sorted(numbers.items(), key=lambda each: each[0])), []
        for level in levels:
            key = motor, float(level)
            if key not in self._rates:
                if len(self._rates) > MAX_RATES:
                    self._rates.clear()
                near = self._last_rates.get(key[1])
                self._rates[key] = self._last_rates[key[1]] = plane_rates(driven, key[1], self.tolerance, near)
            found.append(self._rates[key][IN_PLANE.index(quantity_of)])
        return np.array(found)

    def _mean_velocities(self, driven: Contact, levels: np.ndarray, numbers: dict) -> np.ndarray:
        """Return the mean velocities over place about the slider's position; NaN where there is none."""
        velocities = self.velocities([(driven, float(level)) for level in levels])
        if self.prescribed_wave:
            return velocities
        if self.one_by_one:
            return np.array(
                [mean_velocity(driven, *each, self.tolerance) for each in zip(levels, velocities, strict=True)]
            )
        # the motion about the position is that of the stator: a factor on the amplitudes is one on the level
        plain, factor = super().contact(numbers), numbers.get(AMPLITUDE_FACTOR, 1.0)
        keys = (levels * factor).tolist()
        known = {key: Known(v, 1.0) for key, v in zip(keys, velocities, strict=True) if math.isfinite(v)}
        nearby = NearbyContact.of(plain, self.tolerance)
        found = {} if nearby is None else ripples(nearby, known)
        return np.array([found[key].mean if key in found else math.nan for key in keys])

    def _burst(
        self, measurement: Measurement, driven: Contact, level: float, numbers: dict, travelling: bool
    ) -> np.ndarray:
        """Return velocity or position at the measured instants of a burst, with its ring-up and travel.

        The instrument's bandwidth, sampling and origin of time are applied to the prediction.
        """
        refuse_if(
            driven.scene.planar, f"measurements {measurement.name}",
            "holds a burst, which is predicted of a slider along x alone: give steady velocities",
        )  # fmt: skip
        duration = driven.scene.burst
        if duration is None:
            key = f"{driven.scene.source.block}.burst"
            raise SceneError(
                f"measurements {measurement.name}", f'holds a burst: state its duration after the file, {key}="0.1 s"'
            )
        if travelling:
            driven = self.stators.bursting(driven)
        if driven.along is not None:
            driven = replace(driven, along=driven.along.scaled(numbers.get(AMPLITUDE_FACTOR, 1.0)))
        (steady,) = self.velocities([(driven, level)])
        offset = float(numbers.get(TIME_OFFSET, 0.0))
        after = max(0.0, 1.01 * (measurement.time[-1] - offset) - duration)  # a little beyond the last instant
        try:
            trajectory, _ = followed_burst(driven, level, steady, self.tolerance, after=after)
        except contact.ConvergenceError:
            return np.full(len(measurement.time), math.nan)
        if trajectory.ended and trajectory.time[-1] < measurement.time[-1] - offset:
            return np.full(len(measurement.time), math.nan)  # the slider has come to fingers or the stator's end
        curve = trajectory.velocity
        if measurement.quantity == "position":
            curve = travelled_distance(trajectory.time, curve)
        encoder = {name: float(numbers[name]) for name in (BANDWIDTH, SAMPLING) if name in numbers}
        return recorded(trajectory.time, curve, np.array(measurement.time) - offset, **encoder)
