"""Drive direction of a wave, and the reference speed for errors of the velocity."""

from contact.orbit import Orbit


def reference_speed(velocity: float, orbits: tuple[Orbit, ...]) -> float:
    """Return max(|v|, omega |u_x|/10) in m/s, the measure of velocity errors."""
    return speed_scale(velocity, max(o.omega * abs(o.tangential) for o in orbits))


def speed_scale(velocity: float, surface_speed: float) -> float:
    """Return the `reference_speed` where the peak speed of the surface along x, omega |u_x| in m/s, is known."""
    return max(abs(velocity), surface_speed / 10.0)


def relative_to_reference(difference: float, velocity: float, orbits: tuple[Orbit, ...]) -> float:
    """Return a velocity difference over the reference speed, or 1 for a nonzero difference if that speed is zero."""
    reference = reference_speed(velocity, orbits) or abs(difference)
    return float(abs(difference) / reference) if reference > 0.0 else 0.0


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
