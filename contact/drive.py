"""Drive direction of a wave."""

from contact.orbit import Orbit


def drive_direction(orbits: tuple[Orbit, ...]) -> float:
    """Return +1 or -1, the direction of the surface velocity at the wave crests (+1 if it is zero)."""
    return -1.0 if sum(orbit.crest_velocity for orbit in orbits) < 0.0 else 1.0


def towards_plus(orbits: tuple[Orbit, ...]) -> tuple[float, tuple[Orbit, ...]]:
    """Return (drive direction, orbits mirrored if necessary so that their crests drive towards +x).

    All problems are solved for a drive towards +x, so that the answers of mirrored waves are equal and opposite to the
    last bit.
    """
    side = drive_direction(orbits)
    return side, orbits if side > 0.0 else tuple(orbit.mirrored() for orbit in orbits)
