"""Velocity of the slider for each drive voltage.

Method: the chain of the scene (``twente`` by default): the stator at the drive frequency, multiplied by the voltage,
and the steady motion of the slider. Expected: rest below a threshold voltage; above it a velocity towards the driven
transducer that increases through slip to intermittent contact. Run time: about 3 s.
"""

from studies.record import Record
from studies.record.run_pictures import velocity
from studies.runs import run as run_chain
from studies.scene import Scene

QUICK = {"tolerance": 1e-2}


def run(scene: str | Scene = "twente", *, tolerance: float = 1e-3) -> Record:
    """Return the record of a scene with a slider.

    Parameters
    ----------
    scene : str or Scene
        A path, a shipped name or a scene.
    tolerance : float
        Of the velocity, relative to max(|v|, omega |u_x| / 10).
    """
    loaded = Scene.load(scene)
    if loaded.slider is None:
        loaded.refuse("slider", "is missing: without a slider there is no velocity")
    return run_chain(loaded, tolerance=tolerance)


def figure(record: Record, ax):
    """Draw velocity against voltage, or against amplitude for a scene with a [wave]."""
    return velocity(record, ax)
