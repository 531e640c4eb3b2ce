"""The passband of a scene's driven transducer: the frequencies that a study computes, and a closed-form estimate."""

from pathlib import Path

import numpy as np

import fem
from studies.chain import resolve
from studies.scene import Scene

LOBES = 1.5  # bandwidths 1/N either side of the middle: the main lobe and half of its neighbours
MAX_HALF_BAND = 0.45  # over the middle frequency, for transducers of few fingers
MAX_FREQUENCIES = 2000  # that a study takes by default


def driven_scene(scene: str | Path | Scene) -> Scene:
    """Return a scene as resolved; refuse one without a transducer."""
    loaded = Scene.load(scene)
    if not loaded.transducer:
        loaded.refuse("transducer", "is missing: the study drives one")
    return resolve.resolved(loaded)


def place(scene: Scene) -> tuple[float, float]:
    """Return where the motion is evaluated, x and y in m: under the slider, or in the middle of the stator."""
    return (scene.stator.length / 2, 0.0) if scene.slider is None else scene.slider.center


def waves_return(scene: Scene) -> bool:
    """Return whether transducers or ends send waves back to the driven transducer."""
    return len(scene.transducer) > 1 or scene.stator.ends != "absorbing"


def frequencies(scene: Scene, count: int | None, least: int = 2):
    """Return frequencies in Hz, evenly spaced about v / period of the driven transducer.

    Without a count they are at least so many, and follow the ripple of waves that return: 4 in v / (2 length).
    """
    driven = scene.driven_transducer
    velocity = fem.rayleigh(resolve.solid(scene.stator), "open").velocity
    middle = velocity / driven.period
    half = middle * min(LOBES / driven.finger_pairs, MAX_HALF_BAND)
    if count is None:
        ripples = 2 * half / (velocity / (2 * scene.stator.length)) if waves_return(scene) else 0.0
        count = int(np.clip(np.ceil(4 * ripples) + 1, least, max(least, MAX_FREQUENCIES)))
    return np.linspace(middle - half, middle + half, count)


def group_delay(at, transfer, way: float):
    """Return the group delay -d(phase)/d(omega) in s of a transfer function; ``way`` is its approximate delay.

    The phase turns by 2 pi ``way`` df from one frequency to the next, often more than half a turn: what is left of it
    after that delay is unwrapped.

    Examples
    --------
    >>> at = np.linspace(1.9e6, 2.5e6, 11)
    >>> np.round(group_delay(at, np.exp(-2j * np.pi * at * 59e-6), 55e-6)[0] * 1e6, 6)
    np.float64(59.0)
    """
    left = np.unwrap(np.angle(transfer * np.exp(2j * np.pi * at * way)))
    return way - np.gradient(left, 2 * np.pi * at)


def expected(scene: Scene):
    """Return the ``fem.TransducerEstimate`` of the driven transducer: no reflections, bulk waves, bottom or ends."""
    stator = resolve.stator(scene.stator)
    return fem.transducer_estimate(stator.solid, resolve.driven(scene), stator.bare_surface)
