"""Bursts that would not end: the cycles of the wave that the contact must follow, and what that takes."""

from studies.refusal import SceneError
from studies.scene import Scene

MAX_SECONDS = 3600.0  # s of one burst on one processor
# Seconds per cycle of the wave, measured on a 2-core x86_64 machine.
CYCLE = {"hysteretic": 6e-4, "exact": 1.4e-4, "stepped": 4.5e-6, "averaged": 5e-7}


def refuse_endless_burst(scene: Scene, frequency: float) -> None:
    """Refuse a burst that takes longer than an hour to follow, naming the longest that is; ``frequency``: Hz."""
    slider = scene.slider
    every_event = slider.law != "elastic" or slider.reciprocal or slider.stick_band > 0
    method = slider.method if slider.method in CYCLE else "averaged" if scene.wave is not None else "stepped"
    if every_event and method != "stepped":
        method = "hysteretic" if slider.law == "hysteretic" else "exact"
    longest = MAX_SECONDS / CYCLE[method] / frequency
    if scene.burst > longest:
        block = "wave" if scene.wave is not None else "drive"
        cycles = scene.burst * frequency
        hours = cycles * CYCLE[method] / 3600
        rule = f"must be at most {longest:.3g} s: {cycles:.3g} cycles would take {hours:.3g} hours"
        raise SceneError(f"{block}.burst", f"{rule}, got {scene.burst:g} s; the steady state needs no burst")
