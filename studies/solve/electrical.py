"""The block ``electrical`` of run.json: admittance and power balance, powers per squared volt of the source.

Sources of different frequencies exchange no power on average: with several of them each power is the sum over the
frequencies, admittance and voltage are those of the first one's driven transducer.
"""

from collections.abc import Iterator, Sequence

from studies.record.blocks import ElectricalBlock
from studies.record.point import Point
from studies.scene.drive import Drive
from studies.solve.solved_stator import SolvedStator


def electrical_block(drive: Drive, motion, further: Sequence = ()) -> ElectricalBlock:
    """Return the admittance, the voltages and the powers of a `SurfaceMotion` for a source of 1 V.

    ``further``: the motions at the further frequencies of the drive, in their order.
    """
    block = _of_one_frequency(drive, motion)
    parts = [_of_one_frequency(drive, each) for each in further]
    for key, value in block.items():
        if key.startswith("power_") and key.endswith("_W_per_V2"):
            block |= ElectricalBlock(**{key: value + sum(part[key] for part in parts)})
    if parts:
        block |= ElectricalBlock(
            power_residual=max(part.power_residual for part in (block, *parts)),
            admittance_relative_error=max(part.admittance_relative_error for part in (block, *parts)),
        )
    whole = block | _recovered(drive.recovery, motion.circuit)
    sources = dict(_sources(drive, (motion, *further)))
    return whole | ElectricalBlock(sources=sources) if len(sources) > 1 else whole


def _of_one_frequency(drive: Drive, motion) -> ElectricalBlock:
    """Return the admittance and the powers of a motion at one frequency."""
    circuit, balance = motion.circuit, motion.power
    block = ElectricalBlock(
        admittance_S=circuit.admittance,
        comb_voltage_per_volt=circuit.voltage,
        power_W_per_V2=circuit.power,
        power_dissipated_W_per_V2=balance.dissipated,
        power_radiated_W_per_V2=balance.radiated,
        power_residual=balance.residual,
        admittance_relative_error=motion.wave.admittance_error,
        power_solid_W_per_V2=balance.solid,
        power_loads_W_per_V2=balance.loads,
        power_radiated_left_W_per_V2=balance.left,
        power_radiated_right_W_per_V2=balance.right,
    )
    if complex(drive.source_impedance).real > 0:
        block |= ElectricalBlock(power_available_W_per_V2=circuit.network.available)
    if drive.source_impedance or drive.match != "none":
        block |= ElectricalBlock(
            power_source_W_per_V2=circuit.network.in_sources, power_network_W_per_V2=circuit.network.in_ladders
        )
    return block


def _sources(drive: Drive, motions: Sequence) -> Iterator[tuple[str, dict]]:
    """Yield the name of each source, and its voltage, current and power from the motion at its frequency."""
    frequencies, own = drive.frequencies, dict(drive.source_frequencies or ())
    first = motions[0].circuit
    for name in (first.names[k] for k in sorted(first.sources)):
        frequency = own.get(name, drive.frequency)
        circuit = motions[frequencies.index(frequency) if frequency in frequencies else 0].circuit
        k = circuit.names.index(name)
        volts, amperes = circuit.voltages[k], circuit.currents[k]
        yield name, {
            "voltage_per_volt": complex(volts), "current_A_per_V": complex(amperes),
            "power_W_per_V2": float(0.5 * (volts * amperes.conjugate()).real),
        }  # fmt: skip


def _recovered(recovery, circuit) -> ElectricalBlock:
    """Return the recovered power, the loop gain and the net power of the source, of a ``fem.circuit.Circuit``.

    With circulation, the recovered power drives the transducers again. The powers of successive passes form a
    geometric series, which converges if the gain is below 1. The combiner is ideal: it matches the recovered power
    and reflects nothing, so that the source supplies the fraction 1 - gain of the power into the transducers.
    """
    if recovery is None:
        return ElectricalBlock()
    recovered_power = recovered(recovery, circuit.currents[circuit.names.index(recovery.receiver)])
    gain = float(recovered_power / circuit.power)
    block = ElectricalBlock(power_recovered_W_per_V2=float(recovered_power), recovery_ratio=gain)
    if not recovery.circulation:
        return block
    if gain >= 1:
        rule = (
            f"must be below {recovery.efficiency / gain:.4g} with drive.recovery.circulation: "
            f"the loop's gain is {gain:.4g}, and it oscillates from 1 on; got {recovery.efficiency!r}"
        )
        recovery.refuse("efficiency", rule)
    return block | ElectricalBlock(power_net_W_per_V2=float(circuit.power - recovered_power))


def recovered(recovery, current: complex) -> float:
    """Return the recovered power in W per V^2 for a current into the receiver, A per V; ``recovery``: of the drive."""
    return float(recovery.efficiency * 0.5 * abs(current) ** 2 * complex(recovery.load).real)


def source_power(drive: Drive, solved: SolvedStator) -> float:
    """Return the power that the source supplies to the transducers, W per V^2: with circulation the net power."""
    recovery = drive.recovery
    if recovery is None or not recovery.circulation:
        return solved.power
    return solved.power - recovered(recovery, solved.currents[recovery.receiver])


def with_powers(points: tuple[Point, ...], electrical: ElectricalBlock) -> tuple[Point, ...]:
    """Return the points with the available power of the source and the recovered power, both in W.

    The available power exists only for a source with a resistance. The recovered power is added only if the point has
    ``received_over_free``, because the slider then changes the wave on its way to the receiver.
    """
    available, recovered = electrical.power_available_W_per_V2, electrical.power_recovered_W_per_V2
    extended = []
    for point in points:
        powers = Point()
        if available is not None:
            powers = Point(voltage_V=point.voltage_V, available_power_W=available * point.voltage_V**2)
        if recovered is not None and point.received_over_free is not None:
            received = recovered * abs(point.received_over_free) ** 2 * point.voltage_V**2
            powers |= Point(recovered_power_W=received)
        extended.append(powers | point)
    return tuple(extended)
