"""What drives a slider, which way, and how its velocity's error is measured."""

from contact.orbit import Orbit


def reference_speed(velocity: float, orbits: tuple[Orbit, ...]) -> float:
    """Return max(|v|, omega |u_x|/10) in m/s, the measure of velocity errors."""
    return max(abs(velocity), max(o.omega * abs(o.tangential) for o in orbits) / 10.0)


def relative_to_reference(difference: float, velocity: float, orbits: tuple[Orbit, ...]) -> float:
    """Return a velocity difference over the reference speed, or over itself where the reference is zero."""
    reference = reference_speed(velocity, orbits) or abs(difference)
    return float(abs(difference) / reference) if reference > 0.0 else 0.0


def drive_direction(orbits: tuple[Orbit, ...]) -> float:
    """Return +1 or -1, the direction in which the crests drive an unloaded slider (+1 if neither)."""
    return -1.0 if sum(orbit.crest_velocity for orbit in orbits) < 0.0 else 1.0


def towards_plus(orbits: tuple[Orbit, ...]) -> tuple[float, tuple[Orbit, ...]]:
    """Return the drive direction, and the orbits mirrored if need be so that their crests drive towards +x.

    Solving on one side only makes the answers of mirrored waves equal and opposite to the last bit.
    """
    side = drive_direction(orbits)
    return side, orbits if side > 0.0 else tuple(orbit.mirrored() for orbit in orbits)
