"""What a motor would show in a measurement, for many sets of its numbers at once.

The steady states of all sets and levels go into one sweep (`contact.steady_sweep`); a point that averaging does not
know is solved by itself (`contact.steady`).
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from studies.chain.bridge import DrivenContact
from studies.chain.points import averaged
from studies.chain.predictor import PLACE_KEYS, Driven, Predictor, of_stator
from studies.chain.resolve import resolved
from studies.inverse.parameters import AMPLITUDE_FACTOR, AMPLITUDE_PER_VOLT
from studies.record.measured import Measurement
from studies.refusal import RunError, SceneError
from studies.scene import Scene
from studies.scene.override import value_at

TRUSTED = 1e-2  # error of an averaged steady state up to which it is taken
ALONE = 1e-5  # tolerance of the others
BURST_TOLERANCE, SAMPLES = 1e-3, 400


class MeasurementPredictor(Predictor):
    """Predictions of measurements of one scene with changed numbers.

    Words such as "weight" and "auto" become numbers before anything is changed; ``tolerance`` is that of the velocity,
    for the stator.
    """

    def __init__(self, scene: Scene, *, tolerance: float = 1e-3, progress: Callable | None = None):
        if scene.slider is None:
            scene.refuse("slider", "is missing: without a slider there is no velocity")
        if scene.wave is None and not scene.transducer:
            scene.refuse("transducer", "is missing: nothing drives the slider")
        super().__init__(resolved(scene).to_table(), tolerance=tolerance, progress=progress)

    @property
    def given_wave(self) -> bool:
        """Whether the surface motion is given."""
        return "wave" in self.table

    def contact(self, changes: dict, step: int = 0) -> Driven:
        """Return the contact with some keys changed; ``amplitude_factor`` among them multiplies its motion."""
        found, factor = super().contact(changes, step), changes.get(AMPLITUDE_FACTOR, 1.0)
        amplitudes = tuple(each * factor for each in found.amplitudes)
        return replace(found, orbits=found.at(factor), amplitudes=amplitudes)

    def value(self, key: str) -> float | None:
        """Return the scene's own value of a key; None where it has none."""
        at = 1.0 if key == AMPLITUDE_FACTOR else value_at(self.table, key)
        return at if isinstance(at, (int, float)) and not isinstance(at, bool) else None

    def needs_stator(self, key: str) -> bool:
        """Whether a change of the key asks for a new solution of the stator."""
        return not self.given_wave and (key in PLACE_KEYS or of_stator(key))

    def predict(self, asked: list[tuple[Measurement, dict]]) -> list[np.ndarray]:
        """Return the values of measurements, each with its own numbers; NaN where there is no answer."""
        answers, states = [], []
        for measurement, numbers in asked:
            numbers = numbers | measurement.settings
            contact = self.contact(numbers)
            factors = self._factors(measurement, numbers, contact)
            if measurement.quantity == "velocity":
                answers.append(slice(len(states), len(states) + len(factors)))
                states += [(contact, float(factor)) for factor in factors]
            elif measurement.quantity == "amplitude":
                answers.append(factors * contact.amplitude)
            elif measurement.quantity == "burst":
                answers.append(self._burst(measurement, contact, float(factors[0])))
            else:
                answers.append(np.array([contact.slider.tangential_resonance(len(contact.orbits))]))
        speeds = steady_velocities(states)
        return [speeds[each] if isinstance(each, slice) else each for each in answers]

    def _factors(self, measurement: Measurement, numbers: dict, contact: Driven) -> np.ndarray:
        """Return the factors on the contact's orbits at the levels of a measurement."""
        if not measurement.levels:
            return np.array([max(contact.scene.levels)])
        levels = np.array(measurement.levels)
        if measurement.level_key == "normal_amplitude_m":
            return levels / contact.amplitude
        if not self.given_wave:
            return levels
        if AMPLITUDE_PER_VOLT not in numbers:
            raise SceneError(
                f"--data {measurement.name}",
                "holds voltages, and a given [wave] has none: give amplitude_per_volt=LENGTH with the file, or free it",
            )
        return levels * numbers[AMPLITUDE_PER_VOLT]

    def _burst(self, measurement: Measurement, contact: Driven, level: float) -> np.ndarray:
        """Return v at the instants of a burst."""
        import contact as library

        duration = contact.scene.burst
        if duration is None:
            key = "wave.burst" if self.given_wave else "drive.burst"
            raise SceneError(f"--data {measurement.name}", f'holds a burst: give {key}="0.1 s" with the file')
        ringing, envelope, fading = self.ring_up(contact), None, None
        if ringing is not None and ringing.found is not None and ringing.found.settling >= 1e-2 * duration:
            envelope, fading = ringing.envelope, ringing.ring_down
        after = max(0.0, 1.01 * measurement.time[-1] - duration)
        try:
            found = library.burst(
                contact.slider, contact.at(level), duration=duration, envelope=envelope, tolerance=BURST_TOLERANCE,
                after=after if fading is None else (after, fading), samples=SAMPLES,
            )  # fmt: skip
        except library.ConvergenceError:
            return np.full(len(measurement.time), math.nan)
        return np.interp(measurement.time, found.time, found.velocity)


def steady_velocities(asked: list[tuple[DrivenContact, float]]) -> np.ndarray:
    """Return the steady velocity of each contact at a factor on its orbits, m/s; NaN where there is none.

    An averaged velocity that is good enough is taken, else that of the motion itself.
    """
    import contact as library

    found = []
    rows = averaged([(contact.slider, contact.orbits, 0.0, factor) for contact, factor in asked])
    for (contact, factor), (velocity, regime, error, *_) in zip(asked, rows, strict=True):
        if regime == "unknown" or error >= TRUSTED:
            try:
                velocity = library.steady(contact.slider, contact.at(factor), tolerance=ALONE).velocity
            except library.ConvergenceError:
                velocity = math.nan
            except library.InputError as error:
                raise RunError(str(error)) from None
        found.append(float(velocity))
    return np.array(found)
