"""Where the sources' power goes: available, lost before the electrodes, and behind them."""

from studies.scene import Scene


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


def recovered(scene: Scene, circuit) -> dict:
    """Return recovered power, what the source gives in the end, and the loop's gain, of a ``fem.Circuit``.

    With circulation the returned power comes back each time round: the sum of a geometric series, which exists for a
    gain below 1.  An ideal combiner (a coupler that passes just what the loop lets through) reflects nothing then, and
    the source gives 1 - gain of the power into the transducers.
    """
    recovery = scene.drive.recovery
    if recovery is None:
        return {}
    at = circuit.names.index(recovery.receiver)
    load = 0.5 * abs(circuit.currents[at]) ** 2 * complex(recovery.load).real
    kept = recovery.efficiency * load
    gain = float(kept / circuit.power)
    found = {"power_recovered_W_per_V2": float(kept), "recovery_ratio": gain}
    if not recovery.circulation:
        return found
    if gain >= 1:
        rule = (
            f"must be below {recovery.efficiency / gain:.4g} with drive.recovery.circulation: "
            f"the loop's gain is {gain:.4g}, and it oscillates from 1 on; got {recovery.efficiency!r}"
        )
        scene.refuse("drive.recovery.efficiency", rule)
    return found | {"power_net_W_per_V2": float(circuit.power - kept)}


def recovery_left_out(scene: Scene) -> tuple[str, ...]:
    """Return what the model of the recovery leaves out."""
    recovery, reasons = scene.drive.recovery, []
    if recovery is None:
        return ()
    if recovery.rectifier is not None:
        reasons.append("harmonics of the rectifier and its diodes' drop: a resistance for sinusoidal current")
    if recovery.circulation:
        reasons.append("errors of phase and reflections in the return path: its combiner is ideal")
    return tuple(reasons)


def with_available_power(points: tuple[dict, ...], electrical: dict) -> tuple[dict, ...]:
    """Return the points, with the power that a source with a resistance could give at each voltage."""
    available = electrical.get("power_available_W_per_V2")
    if available is None:
        return points
    return tuple(
        {"voltage_V": point["voltage_V"], "available_power_W": available * point["voltage_V"] ** 2} | point
        for point in points
    )
