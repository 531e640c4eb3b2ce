"""The frequencies of a study, and the estimated answer of the driven transducer.

The frequencies are those of a band START:STOP:N of the user (in MHz without a unit; `studies.scene.ranges` reads its
text), or by default those of the driven transducer's passband.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import fem
from studies.model.model import Model
from studies.model.resolve import build
from studies.refusal import refuse_if
from studies.scene import Scene
from studies.scene.ranges import read_range

LOBES = 1.5  # bandwidths 1/N either side of the middle: the main lobe and half of its neighbours
MAX_HALF_BAND = 0.45  # over the middle frequency, for transducers of few fingers
MAX_FREQUENCIES = 2000  # that a study takes by default
DEFAULT_COUNT, MAX_COUNT = 401, 100_000  # frequencies of a network: by default, and at most


def driven_model(scene: str | Path | Scene) -> Model:
    """Return the model of a scene; refuse one without a transducer."""
    loaded = Scene.load(scene)
    if not loaded.transducer:
        loaded.refuse("transducer", "is missing: the study drives one")
    return build(loaded)


def waves_return(scene: Scene) -> bool:
    """Return whether transducers or ends send waves back to the driven transducer."""
    return len(scene.transducer) > 1 or scene.stator.ends != "absorbing"


def frequencies(model: Model, count: int | None, least: int = 2):
    """Return frequencies in Hz, evenly spaced about the drive's, or about v / period if that is outside the main lobe.

    Without a ``count`` there are at least ``least``, and 4 in each ripple v / (2 length) of returning waves.
    """
    scene, driven = model.scene, model.scene.driven_transducer
    velocity = model.wave_velocity(scene.frequency)
    center = velocity / driven.wavelength  # with the velocity of the bare surface; fingers slow the wave by a few %
    middle = scene.frequency if abs(scene.frequency - center) < center / driven.finger_pairs else center
    half = middle * min(LOBES / driven.finger_pairs, MAX_HALF_BAND)
    if count is None:
        ripples = 2 * half / (velocity / (2 * scene.stator.length)) if waves_return(scene) else 0.0
        count = int(np.clip(np.ceil(4 * ripples) + 1, least, max(least, MAX_FREQUENCIES)))
    return np.linspace(middle - half, middle + half, count)


def band_frequencies(model: Model, band: Any = None, count: int | None = None) -> np.ndarray:
    """Return the frequencies in Hz of START:STOP:N (MHz without a unit), or of the driven transducer's passband."""
    if band is None:
        return frequencies(model, count, DEFAULT_COUNT)
    if not isinstance(band, str):
        return np.asarray(band, dtype=float)
    values = read_range("--band", band, "Hz", bare=1e6)
    refuse_if(
        not (0 < values[0] < values[-1] and 2 <= len(values) <= MAX_COUNT),
        "--band",
        f"must rise from START above 0 to STOP in 2 to {MAX_COUNT} values, got {band!r}",
    )
    return np.array(values)


def group_delay(at, transfer, approximate: float):
    """Return the group delay -d(phase)/d(omega) in s of a transfer function at frequencies ``at`` in Hz.

    The phase changes from one frequency to the next by 2 pi df times the delay, often by more than pi. Therefore it is
    unwrapped after the phase of the ``approximate`` delay in s has been removed.

    Examples
    --------
    >>> at = np.linspace(1.9e6, 2.5e6, 11)
    >>> np.round(group_delay(at, np.exp(-2j * np.pi * at * 59e-6), 55e-6)[0] * 1e6, 6)
    np.float64(59.0)
    """
    remainder = np.unwrap(np.angle(transfer * np.exp(2j * np.pi * at * approximate)))
    return approximate - np.gradient(remainder, 2 * np.pi * at)


def expected(model: Model):
    """Return the ``fem.TransducerEstimate`` of the driven transducer: no reflections, bulk waves, bottom or ends.

    Of an apodised or slanted one, that of its strips in parallel.
    """
    stator, frequency = model.stator, model.scene.frequency
    if not model.scene.in_strips:
        return fem.layered_estimate(stator, model.driven, frequency)
    own = [each for strip in fem.strips_of(model.transducers) for each in strip.transducers]
    own = [each for each in own if each.name == model.driven.name and {"+", "-"} <= set(each.signs)]
    return Parallel(parts=tuple(fem.layered_estimate(stator, each, frequency) for each in own))


@dataclass(frozen=True)
class Parallel:
    """Estimates of transducers that are connected in parallel."""

    parts: tuple

    @property
    def capacitance(self) -> float:
        """Sum of the capacitances, F."""
        return sum(each.capacitance for each in self.parts)

    def conductance(self, frequency):
        """Return the sum of the radiation conductances in S at frequencies in Hz."""
        return sum(each.conductance(frequency) for each in self.parts)
