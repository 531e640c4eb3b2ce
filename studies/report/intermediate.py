"""The intermediate numbers of a run, from drive to contact, each with its error and where that comes from."""

import math
from typing import NamedTuple

from studies.chain import bridge
from studies.record import Record

__all__ = ["Number", "intermediate_numbers", "si"]

PREFIXES = {-18: "a", -15: "f", -12: "p", -9: "n", -6: "\u00b5", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
CLOSED = "closed form"
GIVEN = "as given or resolved"


class Number(NamedTuple):
    """A number of the chain: stage (drive, stator, contact), value with unit, relative error or why there is none."""

    stage: str
    name: str
    value: str
    error: str


def si(value: float, unit: str, digits: int = 5) -> str:
    """Return a number with an SI prefix.

    Examples
    --------
    >>> si(2.394e-10, "m/V"), si(0.0, "N"), si(-1.5, "m/s"), si(3e-25, "J")
    ('239.4 pm/V', '0 N', '-1.5 m/s', '3e-25 J')
    """
    if value == 0:
        return f"0 {unit}"
    power = 3 * math.floor(math.log10(abs(value)) / 3)
    if power not in PREFIXES:
        return f"{value:.{digits}g} {unit}"
    return f"{value / 10.0**power:.{digits}g} {PREFIXES[power]}{unit}"


def intermediate_numbers(record: Record) -> tuple[Number, ...]:
    """Return the numbers between the scene and the answer, in the order of the chain."""
    rows = _drive(record)
    if record.surface_wave is not None:
        rows += _stator(record)
    elif record.scene.stator is not None:
        rows += _free(record)
    if record.scene.slider is not None:
        rows += _contact(record)
    return tuple(Number(*row) for row in rows)


def _error(size: float) -> str:
    return f"{size:.1e}"


def _drive(record: Record) -> list[tuple]:
    scene = record.scene
    rows = [("drive", "frequency", si(scene.frequency, "Hz", 9), GIVEN)]
    for each in scene.transducer:
        rows.append(("drive", f"period of transducer {each.name}", si(each.period, "m", 8), GIVEN))
    return rows


def _stator(record: Record) -> list[tuple]:
    wave, electrical, stator = record.wave, record.electrical, "stator"
    fine = record.surface_wave
    admittance, motion = electrical["admittance_S"], _error(wave["relative_error"])
    of_charge, residual = electrical["admittance_relative_error"], electrical["power_residual"]
    comb = electrical["comb_voltage_per_volt"]
    # an eigenvalue and its mode converge faster than the driven motion: its error bounds theirs
    return [
        (stator, "discretisation", f"{fine.resolution}, {fine.unknowns} unknowns", "that of what follows"),
        (stator, "phase velocity of the surface mode", si(wave["phase_velocity_m_per_s"], "m/s", 9), motion),
        (stator, "|u_x/u_z| of the surface mode", f"{wave['surface_ratio']:.6g}", motion),
        (stator, "admittance", _complex(admittance, "S"), _error(of_charge)),
        (stator, "voltage between the combs, per volt", _complex(comb, "V"), _error(of_charge * abs(1 - comb))),
        *(
            (stator, f"power {name}", si(electrical[key], "W/V\u00b2"), f"balance missed by {_error(residual)}")
            for name, key in (
                ("given by the source", "power_W_per_V2"),
                ("lost in the solid and absorbed", "power_dissipated_W_per_V2"),
                ("sent out through the ends", "power_radiated_W_per_V2"),
            )
        ),
        *(
            (stator, name, _polar(wave[key], "m/V"), motion)
            for name, key in (
                ("u_z at the slider's place, per volt", "normal_m_per_V"),
                ("u_x at the slider's place, per volt", "tangential_m_per_V"),
                ("of u_z the surface mode's", "rayleigh_normal_m_per_V"),
            )
            if key in wave
        ),
        (
            stator, "standing-wave ratio about there", f"{wave['standing_wave_ratio']:.5g}",
            "of the order of " + _error(2 * fine.relative_error),
        ),
    ]  # fmt: skip


def _free(record: Record) -> list[tuple]:
    wave, velocity = record.wave, record.error["relative"]
    return [
        ("stator", "velocity", si(wave["phase_velocity_m_per_s"], "m/s", 9), _error(velocity)),
        ("stator", "|u_x/u_z|", f"{wave['surface_ratio']:.6g}", "not estimated"),
        ("stator", "attenuation", si(wave["attenuation_per_m"], "1/m"), "not estimated"),
    ]


def _contact(record: Record) -> list[tuple]:
    block, name = record.scene.slider, "contact"
    slider = bridge.contact_slider(block)
    contacts = 1 if isinstance(block.contacts, int) else len(block.contacts)
    depth = max(slider.rest_approaches(contacts))
    radius, pressure = slider.contact_radius(depth), slider.pressure(depth)
    share, alike = slider.preload / contacts, " on average" if block.heights else ""
    largest = "mean" if slider.shape == "punch" else "largest"
    bounce = slider.normal_resonance(contacts) if share > 0 else 0.0
    ring = slider.tangential_resonance(contacts) if share > 0 else 0.0
    rows = [
        (name, "modulus E*", si(slider.effective_modulus, "Pa"), GIVEN),
        (name, "modulus G*", si(slider.tangential_modulus, "Pa"), GIVEN),
        (name, f"normal force on a contact at rest{alike}", si(share, "N"), CLOSED),
        (name, "approach at rest" + ", of the highest contact" * bool(block.heights), si(depth, "m"), CLOSED),
        (name, "radius of the contact at rest", si(radius, "m"), CLOSED),
        (name, f"{largest} pressure at rest", si(pressure, "Pa"), CLOSED),
        (name, "slip limit of the deformation at rest", si(slider.limit_slope * depth, "m"), CLOSED),
        (name, "bounce and ring at rest", f"{si(bounce, 'Hz')}, {si(ring, 'Hz')}", CLOSED),
    ]  # fmt: skip
    stator = record.wave.get("relative_error", 0.0)
    for key, what in (("threshold", "slider begins to slip"), ("release", "contact is first lost")):
        amplitude = record.summary.get(f"{key}_amplitude_m")
        voltage = record.summary.get(f"{key}_voltage_V")
        if amplitude is not None:
            value = si(amplitude, "m") + ("" if voltage is None else f" at {si(voltage, 'V')}")
            error = CLOSED + (f", of the stator {_error(stator)}" if stator else "")
            rows.append((name, f"amplitude from which the {what}", value, error))
    return rows


def _complex(value: complex, unit: str) -> str:
    sign = "\u2212" if value.imag < 0 else "+"
    return f"{si(value.real, unit)} {sign} i {si(abs(value.imag), unit)}"


def _polar(value: complex, unit: str) -> str:
    return f"{si(abs(value), unit)}, phase {math.degrees(math.atan2(value.imag, value.real)):.2f}\u00b0"
