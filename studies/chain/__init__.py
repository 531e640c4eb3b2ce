"""The chain from a scene to its record: field problems of the scene, stator, contact, velocity; and predictions of it.

``run`` answers a scene (`studies.chain.runs`), a `studies.chain.predictor.Predictor` the same scene for other values.
"""

__all__ = ["run"]  # noqa: F822 - `__getattr__` finds it


def __getattr__(name: str):
    """Import the run when it is first asked for: what only reads a scene imports no solver."""
    if name == "run":
        from studies.chain.runs import run

        return run
    raise AttributeError(f"module 'studies.chain' has no attribute {name!r}")
