"""Steps of bursts of a few cycles: largest displacement, remaining displacement and scatter."""

import logging
import math
from dataclasses import replace

import numpy as np

import contact
from studies.export.motor_model import AveragedMotor
from studies.model.model import changes_stator
from studies.model.resolve import resolved
from studies.model.wave_to_contact import Contact
from studies.scene import Scene
from studies.scene.keys import LEVELS, tolerances
from studies.solve.burst_steps import Steps
from studies.solve.predictor import Predictor
from studies.solve.uncertainty import sampled, without_level

LOGGER = logging.getLogger(__name__)

TIME_STEP = 2e-6  # s, between the positions of which the largest is taken after a burst
DRAWS = 24  # number of random motors within the tolerances, for the scatter
SCATTER_CYCLES = 100


def short_bursts(driven: Contact, motor: AveragedMotor, cycles: tuple[int, ...]) -> dict:
    """Return the steps of short bursts at the largest level, from the exact contact model and from the averaged motor.

    The keys are columns over ``cycles``, the elastic deformation of the contacts in m, and the largest ``difference``
    between the steps of both models in m.
    """
    bursts = Steps.of(driven)
    level, drive = motor.levels[-1], motor.drives[0]
    frequency = drive.orbits[0].frequency
    decay_time = 0.0 if drive.response is None else drive.response_step * len(drive.response)
    exact = [bursts.step(level, number) for number in cycles]
    largest, remaining = [], []
    for number in cycles:
        state = motor.start()
        state.advance(number / frequency, level)
        distance = 0.0
        for _ in range(math.ceil((decay_time + 2e-4) / TIME_STEP)):
            state.advance(TIME_STEP, 0.0)
            distance = max(distance, abs(state.position))
        state.advance(0.02, 0.0)
        largest.append(math.copysign(distance, exact[-1].displacement))
        remaining.append(state.position + state.deformation)
    displacements, averaged = np.array([each.displacement for each in exact]), np.array(remaining)
    return {
        "cycles": np.array(cycles), "exact_m": displacements, "averaged_m": averaged,
        "farthest_m": np.array(largest), "ring_m": np.array([each.ring for each in exact]),
        "elastic_m": motor.slip_deformation,
        "difference": float(np.max(np.abs(averaged - displacements))),
    }  # fmt: skip


def step_scatter(scene: Scene, motor: AveragedMotor) -> tuple[float, float] | None:
    """Return mean and standard deviation in m of the step of a burst, over random motors within [uncertain]."""
    if scene.uncertain is None:
        return None
    LOGGER.info("positioning: scatter by the tolerances")
    inputs = tuple(each for each in tolerances(resolved(scene)) if each.key in LEVELS or not changes_stator(each.key))
    if not inputs:
        return None
    predictor = Predictor(resolved(replace(scene, uncertain=None)).to_table(), tolerance=1e-2)
    steps = []
    for sample in sampled(inputs, DRAWS):  # as if the inputs varied from step to step by their uncertainty
        factor, changes = without_level(sample)
        driven = predictor.contact(changes)
        step = contact.step(driven.slider, driven.at(factor * motor.levels[-1]), cycles=SCATTER_CYCLES)
        steps.append(step.displacement)
    return float(np.mean(steps)), float(np.std(steps, ddof=1))


def steps_in_words(steps: dict, difference: float, scatter: tuple[float, float] | None) -> list[tuple[str, str]]:
    """Return label and text of each line on short bursts."""
    lines = [("elastic", f"the contacts deform by {steps['elastic_m'] * 1e9:.3g} nm before they slip")]
    elastic = np.flatnonzero(np.abs(steps["exact_m"]) < steps["elastic_m"])
    if elastic.size:
        k = int(elastic[-1])
        farthest, remaining = (f"{steps[key][k] * 1e9:+.3g} nm" for key in ("farthest_m", "exact_m"))
        text = f"{steps['cycles'][k]} cycles move the slider by up to {farthest}; it moves back to {remaining}"
        lines.append(("", text))
    lines.append(("", f"the averaged motor's steps differ by at most {difference * 1e9:.2g} nm from the exact ones"))
    if scatter is not None:
        mean, deviation = (f"{value * 1e9:.{digits}g}" for value, digits in zip(scatter, (4, 3), strict=True))
        lines.append(("scatter", f"{SCATTER_CYCLES} cycles: {mean} +- {deviation} nm due to [uncertain]"))
    return lines
