"""Sliders that move in the plane: two directions, several waves, yaw.

A `contact.Slider` whose `freedom` is "xy", "xy yaw" or "axle" on `SurfaceWaves`, the motion of the surface under each
of its contacts, or on a field of waves such as `PlaneWaves`. The law is the stop operator whose limit is a disc of
radius c z (Moreau's sweeping process); with one direction it is the law of `contact.steady`.
"""

from importlib import import_module

_PUBLIC = {
    "plane_threshold": "threshold_factor",
    "scaling": "beats_slowly common_period",
    "averaged_path": "turned",
    "each_contact": "contact_forces ContactForces",
    "bursts": "burst spring_back",
    "sampled_cycle": "contact_cycle ContactCycle",
    "stalling": "drift_per_degree spin_moment stall stall_curve stall_torque StallCurve yaw_stability",
    "state": "Band PlaneState Powers",
    "steady_state": "mean_forces mean_motion MeanPlaneForces steady",
    "burst_path": "PlaneTrajectory",
    "plane_waves": "from_upward_zero PlaneWave PlaneWaves SurfaceWaves places",
}
_HOME = {name: module for module, names in _PUBLIC.items() for name in names.split()}
__all__ = sorted(_HOME)


def __getattr__(name: str):
    """Import a public name from its module when it is first used."""
    if name not in _HOME:
        raise AttributeError(f"module 'contact.plane' has no attribute {name!r}")
    return getattr(import_module(f"contact.plane.{_HOME[name]}"), name)


def __dir__():
    return __all__
