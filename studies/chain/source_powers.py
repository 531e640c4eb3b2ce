"""Where the sources' power goes: available, lost before the electrodes, and behind them."""

from studies.scene import Scene

__all__ = ["powers", "with_available_power"]


def powers(scene: Scene, motion) -> dict:
    """Return the powers of a `SurfaceMotion` as columns of run.json's ``electrical``, W per V^2 of the source."""
    balance, network = motion.power, motion.circuit.network
    found = {
        "power_solid_W_per_V2": balance.solid,
        "power_loads_W_per_V2": balance.loads,
        "power_radiated_left_W_per_V2": balance.left,
        "power_radiated_right_W_per_V2": balance.right,
    }
    if complex(scene.drive.source_impedance).real > 0:
        found["power_available_W_per_V2"] = network.available
    if scene.drive.source_impedance or scene.drive.match != "none":
        found["power_source_W_per_V2"] = network.in_sources
        found["power_network_W_per_V2"] = network.in_ladders
    return found


def with_available_power(points: tuple[dict, ...], electrical: dict) -> tuple[dict, ...]:
    """Return the points, with the power that a source with a resistance could give at each voltage."""
    available = electrical.get("power_available_W_per_V2")
    if available is None:
        return points
    return tuple(
        {"voltage_V": point["voltage_V"], "available_power_W": available * point["voltage_V"] ** 2} | point
        for point in points
    )
