"""Warnings about the heat of a drive, each with a remedy."""

from collections.abc import Iterator

import fem
from studies.record import Record
from studies.solve.heat import FAST, POLED, plate, thermal_constants


def heat_warnings(record: Record) -> Iterator[str]:
    """Yield what the heat of a continuous drive, or of bursts, asks for."""
    block, stator = record.heat, record.scene.stator
    ambient, curie = stator.ambient, thermal_constants(stator.material)["curie_temperature"]
    how = "a continuous drive" if block.duty is None else f"a drive with a duty of {100 * block.duty:.3g} %"
    highest, rate = block.highest_rise_K, block.heating_rate_K_per_s or 0.0
    if highest is not None and curie is not None and ambient + highest > POLED * curie:
        yield (
            f"{how} at {block.voltage_V:g} V warms the stator by {highest:.3g} K above "
            f"{ambient:g} degC at x = {1e3 * block.hottest_x_m:.3g} mm, more than half of its Curie "
            f"temperature of {curie:g} degC: the poling suffers; cool the stator or its ends, lower the voltage or "
            "drive in bursts (drive.duty)"
        )
    if block.burst_rise_K is not None:
        if block.burst_rise_K > FAST:
            yield (
                f"one burst at {block.voltage_V:g} V warms the stator by {block.burst_rise_K:.3g} K: shorten it, or "
                "glue the stator to metal (stator.cooling.bottom)"
            )
    elif rate > FAST:
        yield (
            f"at {block.voltage_V:g} V the stator warms by {rate:.3g} K in the first second: drive in bursts "
            "(drive.duty), or glue it to metal (stator.cooling.bottom)"
        )
    if (block.foldover_number or 0.0) > fem.FOLDOVER_LIMIT:
        yield (
            f"between reflecting ends the warm resonance has two stable temperatures at {block.voltage_V:g} V "
            f"(foldover number {block.foldover_number:.3g}, two states from 1.54 on): approach it from above where "
            "the frequency falls with temperature, from below where it rises, or follow the resonance"
        )
    body = plate(stator)
    if body is not None and body.bottom is None and body.biot_number > fem.MAX_BIOT_NUMBER:
        yield (
            f"the Biot number of the stator is {body.biot_number:.2g}: its temperatures differ through the thickness, "
            "which the stated ones leave out"
        )
