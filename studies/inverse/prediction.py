"""What a motor would show in a measurement, for many sets of its numbers at once.

A set of numbers makes one slider and one surface motion per unit of drive; stators are solved once for each set of the
keys that they depend on.  The steady states of all sets and levels go into one sweep (`contact.steady_sweep`); a point
that averaging does not know is solved by itself (`contact.steady`).
"""

import json
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from studies.chain.driven_contact import DrivenContact
from studies.chain.points import averaged
from studies.chain.surface_motion import solved_motion
from studies.inverse.data import Measurement
from studies.inverse.parameters import AMPLITUDE_FACTOR, AMPLITUDE_PER_VOLT
from studies.refusal import RunError, SceneError
from studies.scene import Scene
from studies.scene.override import replaced, value_at
from studies.scene.resolved import resolved

SHARE = 0.25  # of the tolerance, for the stator
TRUSTED = 1e-2  # error of an averaged steady state up to which it is taken
ALONE = 1e-5  # tolerance of the others
BURST_TOLERANCE, SAMPLES = 1e-3, 400
PLACES = ("slider.position", "slider.contacts")


class Predictor:
    """Predictions of one scene with changed numbers.

    Words such as "weight" and "auto" become numbers before anything is changed; ``tolerance`` is that of the velocity,
    for the stator.
    """

    def __init__(self, scene: Scene, *, tolerance: float = 1e-3, progress: Callable | None = None):
        if scene.slider is None:
            scene.refuse("slider", "is missing: without a slider there is no velocity")
        if scene.wave is None and not scene.transducer:
            scene.refuse("transducer", "is missing: nothing drives the slider")
        self.table = resolved(scene).to_table()
        self.tolerance, self.progress = tolerance, progress or (lambda text: None)
        self._driven, self._ring_ups, self._kept = {}, {}, {}

    @property
    def given_wave(self) -> bool:
        """Whether the surface motion is given."""
        return "wave" in self.table

    def solved(self, record) -> None:
        """Take the stator's answer from a run of the scene."""
        if not self.given_wave:
            self._driven["{}"] = DrivenContact.of_run(record)

    def contact(self, numbers: dict) -> DrivenContact:
        """Return slider and surface motion with some keys of the scene changed."""
        known = tuple(sorted((key, str(value)) for key, value in numbers.items()))
        if known not in self._kept:
            if len(self._kept) > 4096:
                self._kept.clear()
            self._kept[known] = self._contact(numbers)
        return self._kept[known]

    def value(self, key: str) -> float | None:
        """Return the scene's own value of a key; None where it has none."""
        if key == AMPLITUDE_FACTOR:
            return 1.0
        at = value_at(self.table, key)
        return at if isinstance(at, (int, float)) and not isinstance(at, bool) else None

    def needs_stator(self, key: str) -> bool:
        """Whether a change of the key asks for a new solution of the stator."""
        return not self.given_wave and (
            key in PLACES
            or (key.startswith(("stator.", "transducer.", "drive.")) and not key.endswith(".burst"))
        )

    def predict(self, asked: list[tuple[Measurement, dict]]) -> list[np.ndarray]:
        """Return the values of measurements, each with its own numbers; NaN where there is no answer."""
        answers, states = [None] * len(asked), []
        for k, (measurement, numbers) in enumerate(asked):
            numbers = numbers | measurement.settings
            contact = self.contact(numbers)
            factors = self._factors(measurement, numbers, contact)
            if measurement.quantity == "velocity":
                states.append((k, contact, factors))
            elif measurement.quantity == "amplitude":
                answers[k] = factors * contact.amplitude
            elif measurement.quantity == "burst":
                answers[k] = self._burst(measurement, contact, float(factors[0]))
            else:
                answers[k] = np.array([contact.slider.tangential_resonance(len(contact.orbits))])
        asked = [
            (contact.slider, contact.orbits, 0.0, float(f)) for _, contact, factors in states for f in factors
        ]
        rows = iter(averaged(asked))
        for k, contact, factors in states:
            answers[k] = np.array([_steady(contact, float(f), *next(rows)) for f in factors])
        return answers

    def _contact(self, numbers: dict) -> DrivenContact:
        table = self.table
        for key, value in numbers.items():
            if "." in key:
                table = replaced(table, key, list(value) if isinstance(value, tuple) else value)
        scene = resolved(Scene.from_table("", table))
        factor = numbers.get(AMPLITUDE_FACTOR, 1.0)
        if self.given_wave:
            return DrivenContact.given(scene)
        keys = {key: value for key, value in numbers.items() if self.needs_stator(key)}
        name = json.dumps(keys, default=str, sort_keys=True)
        if name not in self._driven:
            self.progress(f"stator {len(self._driven) + 1}")
            self._driven[name] = self._solved(scene)
        driven = self._driven[name]
        return replace(
            driven, scene=replace(scene, drive=replace(scene.drive, frequency=driven.scene.frequency)),
            orbits=driven.at(factor), amplitudes=tuple(each * factor for each in driven.amplitudes),
        )  # fmt: skip

    def _solved(self, scene: Scene) -> DrivenContact:
        """Solve the stator for the motion under the slider."""
        places = tuple(dict.fromkeys((scene.slider.center, *scene.slider.places)))
        motion = solved_motion(scene, places, tolerance=SHARE * self.tolerance)
        return DrivenContact.of_motion(scene, motion, stator_error=motion.relative_error(places))

    def _factors(self, measurement: Measurement, numbers: dict, contact: DrivenContact) -> np.ndarray:
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

    def _burst(self, measurement: Measurement, contact: DrivenContact, level: float) -> np.ndarray:
        """Return v at the instants of a burst."""
        import contact as library

        duration = contact.scene.burst
        if duration is None:
            key = "wave.burst" if self.given_wave else "drive.burst"
            raise SceneError(f"--data {measurement.name}", f'holds a burst: give {key}="0.1 s" with the file')
        envelope, fading = self._envelopes(contact.scene, duration)
        after = max(0.0, 1.01 * measurement.time[-1] - duration)
        try:
            found = library.burst(
                contact.slider, contact.at(level), duration=duration, envelope=envelope, tolerance=BURST_TOLERANCE,
                after=after if fading is None else (after, fading), samples=SAMPLES,
            )  # fmt: skip
        except library.ConvergenceError:
            return np.full(len(measurement.time), math.nan)
        return np.interp(measurement.time, found.time, found.velocity)

    def _envelopes(self, scene: Scene, duration: float) -> tuple:
        """Return how the surface's motion grows and fades, where that takes a share of the burst that matters."""
        if self.given_wave:
            return None, None
        from studies.chain.ring_up import ring_up

        plain = replace(scene, slider=None, drive=replace(scene.drive, voltage=(1.0,)))
        name = (plain, scene.slider.center)
        if name not in self._ring_ups:
            self._ring_ups[name] = ring_up(plain, scene.slider.center, progress=self.progress)
        found = self._ring_ups[name]
        if found.found is None or found.found.settling < 1e-2 * duration:
            return None, None
        return found.envelope, found.ring_down


def _steady(contact: DrivenContact, factor: float, velocity: float, regime: str, error: float, *_) -> float:
    """Return an averaged velocity that is good enough, or that of the motion itself."""
    import contact as library

    if regime != "unknown" and error < TRUSTED:
        return velocity
    try:
        found = library.steady(contact.slider, contact.at(factor), tolerance=ALONE)
    except library.ConvergenceError:
        return math.nan
    except ValueError as error:
        raise RunError(str(error)) from None
    return float(found.velocity)
