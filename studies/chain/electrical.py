"""The block ``electrical`` of run.json: admittance, and where the sources' power goes, per V^2 of the source."""

from studies.scene import Scene


def electrical_block(scene: Scene, motion) -> dict:
    """Return admittance, voltages and powers of a `SurfaceMotion`."""
    circuit, balance = motion.circuit, motion.power
    block = {
        "admittance_S": circuit.admittance,
        "comb_voltage_per_volt": circuit.voltage,
        "power_W_per_V2": circuit.power,
        "power_dissipated_W_per_V2": balance.dissipated,
        "power_radiated_W_per_V2": balance.radiated,
        "power_residual": balance.residual,
        "admittance_relative_error": motion.wave.admittance_error,
        "power_solid_W_per_V2": balance.solid,
        "power_loads_W_per_V2": balance.loads,
        "power_radiated_left_W_per_V2": balance.left,
        "power_radiated_right_W_per_V2": balance.right,
    }
    if complex(scene.drive.source_impedance).real > 0:
        block["power_available_W_per_V2"] = circuit.network.available
    if scene.drive.source_impedance or scene.drive.match != "none":
        block["power_source_W_per_V2"] = circuit.network.in_sources
        block["power_network_W_per_V2"] = circuit.network.in_ladders
    block |= _recovered(scene, circuit)
    if len(circuit.sources) > 1:
        block["sources"] = {
            circuit.names[at]: {
                "voltage_per_volt": complex(circuit.voltages[at]),
                "current_A_per_V": complex(circuit.currents[at]),
            }
            for at in sorted(circuit.sources)
        }
    return block


def _recovered(scene: Scene, circuit) -> dict:
    """Return recovered power, what the source gives in the end, and the loop's gain, of a ``fem.circuit.Circuit``.

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
    recovered = {"power_recovered_W_per_V2": float(kept), "recovery_ratio": gain}
    if not recovery.circulation:
        return recovered
    if gain >= 1:
        rule = (
            f"must be below {recovery.efficiency / gain:.4g} with drive.recovery.circulation: "
            f"the loop's gain is {gain:.4g}, and it oscillates from 1 on; got {recovery.efficiency!r}"
        )
        scene.refuse("drive.recovery.efficiency", rule)
    return recovered | {"power_net_W_per_V2": float(circuit.power - kept)}


def with_powers(points: tuple[dict, ...], electrical: dict) -> tuple[dict, ...]:
    """Return the points, with the power that a source with a resistance could give, and what is recovered, in W.

    What is recovered is said where a slider takes part of the wave on its way to the receiver.
    """
    available, recovered = (electrical.get(f"power_{name}_W_per_V2") for name in ("available", "recovered"))
    found = []
    for point in points:
        own, square = {}, point["voltage_V"] ** 2 if "voltage_V" in point else 0.0
        if available is not None:
            own = {"voltage_V": point["voltage_V"], "available_power_W": available * square}
        if recovered is not None and "received_over_free" in point:
            own["recovered_power_W"] = recovered * abs(point["received_over_free"]) ** 2 * square
        found.append(own | point)
    return tuple(found)
