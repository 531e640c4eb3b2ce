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

from studies.chain import bridge
from studies.chain.driven_contact import DrivenContact, given_contact
from studies.chain.surface_motion import driven_motion
from studies.inverse.data import Measurement
from studies.inverse.parameters import AMPLITUDE_FACTOR, AMPLITUDE_PER_VOLT
from studies.refusal import RunError, SceneError
from studies.scene import Scene
from studies.scene.override import replaced, value_at
from studies.scene.resolved import resolved

__all__ = ["Predictor"]

SHARE = 0.25  # of the tolerance, for the stator
TRUSTED = 1e-2  # error of an averaged steady state up to which it is taken
ALONE = 1e-5  # tolerance of the others
BURST_TOLERANCE, SAMPLES = 1e-3, 400
PLACES = ("slider.position", "slider.contacts")


class Predictor:
    """Predictions of one scene with changed numbers.

    Parameters
    ----------
    scene : Scene
        With a slider; words such as "weight" and "auto" become numbers before anything is changed.
    tolerance : float
        Of the velocity, for the stator.
    progress : callable, optional
        Told what is being done.
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
        for (k, _, _), found in zip(states, self._steady(states), strict=True):
            answers[k] = found
        return answers

    def _contact(self, numbers: dict) -> DrivenContact:
        table = self.table
        for key, value in numbers.items():
            if "." in key:
                table = replaced(table, key, list(value) if isinstance(value, tuple) else value)
        scene = resolved(Scene.from_table("", table))
        factor = numbers.get(AMPLITUDE_FACTOR, 1.0)
        if self.given_wave:
            return given_contact(scene)
        keys = {key: value for key, value in numbers.items() if self.needs_stator(key)}
        name = json.dumps(keys, default=str, sort_keys=True)
        if name not in self._driven:
            self.progress(f"stator {len(self._driven) + 1}")
            self._driven[name] = self._solved(scene)
        driven = self._driven[name]
        return replace(
            driven, scene=replace(scene, drive=replace(scene.drive, frequency=driven.scene.frequency)),
            slider=bridge.contact_slider(scene.slider), orbits=bridge.scaled(driven.orbits, factor),
            amplitude=driven.amplitude * factor,
        )  # fmt: skip

    def _solved(self, scene: Scene) -> DrivenContact:
        """Solve the stator for the motion under the slider."""
        import fem

        places = tuple(dict.fromkeys((scene.slider.center, *scene.slider.places)))
        try:
            motion = driven_motion(scene, places, tolerance=SHARE * self.tolerance)
        except fem.BeamError as error:
            scene.refuse("stator.diffraction", f"must be false or absent: {error}")
        except fem.ConvergenceError as error:
            raise RunError(str(error)) from None
        return DrivenContact(
            scene=scene, slider=None, orbits=bridge.orbits_per_volt(motion, scene.slider),
            amplitude=float(abs(motion.at([scene.slider.center])[2, 0])), stator_error=motion.relative_error(places),
            record=None,
        )  # fmt: skip

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

    def _steady(self, states: list) -> list[np.ndarray]:
        """Return the steady velocities of (number, contact, factors)."""
        import contact as library

        groups, answers = {}, [None] * len(states)
        for at, (_, contact, _) in enumerate(states):
            groups.setdefault(len(contact.orbits), []).append(at)
        for members in groups.values():
            waves, which, factors = {}, [], []
            for row, at in enumerate(members):
                _, contact, own = states[at]
                wave = waves.setdefault(contact.orbits, len(waves))
                which += [(row, wave)] * len(own)
                factors += list(own)
            sliders = [states[at][1].slider for at in members]
            found = library.steady_sweep(
                sliders, list(waves), which=np.array(which), factors=np.array(factors),
                wave_errors=np.zeros(len(waves)),
            )  # fmt: skip
            good = (found.regime != "unknown") & (found.relative_error < TRUSTED)
            velocity, first = np.where(good, found.velocity, math.nan), 0
            for at in members:
                _, contact, own = states[at]
                answers[at] = velocity[first : first + len(own)].copy()
                for k in np.flatnonzero(np.isnan(answers[at])):
                    answers[at][k] = _alone(contact, float(own[k]))
                first += len(own)
        return answers

    def _burst(self, measurement: Measurement, contact: DrivenContact, level: float) -> np.ndarray:
        """Return v at the instants of a burst."""
        import contact as library

        duration = contact.scene.burst
        if duration is None:
            key = "wave.burst" if self.given_wave else "drive.burst"
            raise SceneError(f"--data {measurement.name}", f'holds a burst: give {key}="0.1 s" with the file')
        try:
            found = library.burst(
                contact.slider, bridge.scaled(contact.orbits, level), duration=duration,
                after=max(0.0, 1.01 * measurement.time[-1] - duration), tolerance=BURST_TOLERANCE, samples=SAMPLES,
                envelope=self._envelope(contact.scene, duration),
            )  # fmt: skip
        except library.ConvergenceError:
            return np.full(len(measurement.time), math.nan)
        return np.interp(measurement.time, found.time, found.velocity)

    def _envelope(self, scene: Scene, duration: float):
        """Return how the surface's motion grows, where it does so within a share of the burst that matters."""
        if self.given_wave:
            return None
        from studies.chain.ring_up import ring_up

        plain = replace(scene, slider=None, drive=replace(scene.drive, voltage=(1.0,)))
        name = (plain, scene.slider.center[0])
        if name not in self._ring_ups:
            self._ring_ups[name] = ring_up(plain, scene.slider.center[0], progress=self.progress)
        found = self._ring_ups[name]
        if found.found is None or found.found.settling < 1e-2 * duration:
            return None
        return found.envelope


def _alone(contact: DrivenContact, factor: float) -> float:
    import contact as library

    try:
        found = library.steady(contact.slider, bridge.scaled(contact.orbits, factor), tolerance=ALONE)
    except library.ConvergenceError:
        return math.nan
    except ValueError as error:
        raise RunError(str(error)) from None
    return float(found.velocity)
