"""The intermediate numbers of a run, from drive to contact, each with its error or its origin."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from studies.model.wave_to_contact import contact_slider
from studies.record import Record
from studies.record.prefixes import si

CLOSED = "closed form"
SPECIFIED = "as specified or resolved"


class Number(NamedTuple):
    """An intermediate number: stage (drive, stator, contact), name, value with unit, and error or its origin."""

    stage: str
    name: str
    value: str
    error: str


def intermediate_numbers(record: Record) -> tuple[Number, ...]:
    """Return the numbers between the scene and the answer, from drive to contact."""
    stages = {"drive": _drive(record)}
    if record.surface_wave is not None:
        stages["stator"] = _stator(record)
    elif record.scene.stator is not None:
        stages["stator"] = _free(record)
    if record.scene.slider is not None:
        stages["contact"] = _contact(record)
    return tuple(Number(stage, *entry) for stage, entries in stages.items() for entry in entries)


def _error(size: float) -> str:
    return f"{size:.1e}"


def _drive(record: Record):
    yield "frequency", si(record.scene.frequency, "Hz", 9), SPECIFIED
    for each in record.scene.transducer:
        yield f"period of transducer {each.name}", si(each.wavelength, "m", 8), SPECIFIED


def _stator(record: Record):
    wave, electrical, wave_solution = record.wave, record.electrical, record.surface_wave
    motion, electrical_error = _error(wave.relative_error), electrical.admittance_relative_error
    comb_voltage, power_residual = electrical.comb_voltage_per_volt, _error(electrical.power_residual)
    sizes = f"{wave_solution.resolution}, {wave_solution.unknowns} unknowns"
    yield "discretisation", sizes, "that of the numbers below"
    # eigenvalues and modes converge faster than the driven motion, whose error is therefore an upper bound
    yield "phase velocity of the surface mode", si(wave.phase_velocity_m_per_s, "m/s", 9), motion
    yield "|u_x/u_z| of the surface mode", f"{wave.surface_ratio:.6g}", motion
    yield "admittance", _complex(electrical.admittance_S, "S"), _error(electrical_error)
    # V = 1/(1 + Z Y) behind a source impedance Z: a relative error e of Y changes V relatively by |1 - V| e
    error = _error(electrical_error * abs(1 - comb_voltage))
    yield "voltage between the electrodes, per volt", _complex(comb_voltage, "V"), error
    for name, power in (
        ("delivered by the source", electrical.power_W_per_V2),
        ("lost in the solid and absorbed", electrical.power_dissipated_W_per_V2),
        ("radiated through the ends", electrical.power_radiated_W_per_V2),
    ):
        yield f"power {name}", si(power, "W/V\u00b2"), f"residual of the balance {power_residual}"
    for name, size in (
        ("u_z at the slider's position, per volt", wave.normal_m_per_V),
        ("u_x at the slider's position, per volt", wave.tangential_m_per_V),
        ("part of the surface mode in u_z", wave.rayleigh_normal_m_per_V),
    ):
        if size is not None:
            yield name, _polar(size), motion
    ratio, error = wave.standing_wave_ratio, _error(2 * wave_solution.relative_error)
    where = "middle" if record.scene.slider is None else "slider"
    yield f"standing-wave ratio near the {where}", f"{ratio:.5g}", f"of the order of {error}"


def _free(record: Record):
    wave = record.wave
    yield "velocity", si(wave.phase_velocity_m_per_s, "m/s", 9), _error(record.error.relative)
    yield "|u_x/u_z|", f"{wave.surface_ratio:.6g}", "not estimated"
    yield "attenuation", si(wave.attenuation_per_m, "1/m"), "not estimated"


def _contact(record: Record):
    block, slider = record.scene.slider, contact_slider(record.scene.slider.along_x)
    slider = replace(slider, mass=block.mass / block.share)
    contacts = max(block.computed_contacts, slider.count)
    depths, normal_force = slider.rest_approaches(contacts), slider.preload / contacts
    depth = float(max(depths))
    average_note, highest_note = ("", "") if slider.level else (" on average", ", of the highest contact")
    resonance_functions = (slider.normal_resonance, slider.tangential_resonance) if normal_force > 0 else ()
    resonances = [si(each(contacts), "Hz") for each in resonance_functions] or ["0 Hz", "0 Hz"]
    # `sawmotor check` prints the moduli of the two surfaces alone
    compliant = block.pillars is not None and block.pillars.height is not None
    bodies = " with the compliance of a pillar's height" if compliant else ""
    moduli, radius = (slider.effective_modulus, slider.tangential_modulus), np.mean(slider.radius)
    if moduli[0] is None:  # those of a contact of the mean stiffnesses and radius
        moduli = np.mean(slider.normal_stiffness) / (2 * radius), np.mean(slider.tangential_stiffness) / (8 * radius)
    yield f"modulus E*{bodies}", si(moduli[0], "Pa"), SPECIFIED
    yield f"modulus G*{bodies}", si(moduli[1], "Pa"), SPECIFIED
    yield f"normal force on a contact at rest{average_note}", si(normal_force, "N"), CLOSED
    yield f"approach at rest{highest_note}", si(depth, "m"), CLOSED
    yield "radius of the contact at rest", si(float(np.max(slider.contact_radius(depths))), "m"), CLOSED
    largest = "mean" if slider.shape == "punch" else "largest"
    yield f"{largest} pressure at rest", si(float(np.max(slider.pressure(depths))), "Pa"), CLOSED
    yield "slip limit of the deformation at rest", si(float(np.max(slider.limit_slope * depths)), "m"), CLOSED
    yield "bounce and ring at rest", ", ".join(resonances), CLOSED
    stator = record.wave.relative_error or 0.0
    limits = record.summary
    for amplitude, voltage, event in (
        (limits.threshold_amplitude_m, limits.threshold_voltage_V, "slider begins to slip"),
        (limits.release_amplitude_m, limits.release_voltage_V, "contact is first lost"),
    ):
        if amplitude is not None:
            value = si(amplitude, "m") + ("" if voltage is None else f" at {si(voltage, 'V')}")
            error = CLOSED + (f", of the stator {_error(stator)}" if stator else "")
            yield f"amplitude from which the {event}", value, error


def _complex(value: complex, unit: str) -> str:
    sign = "\u2212" if value.imag < 0 else "+"
    return f"{si(value.real, unit)} {sign} i {si(abs(value.imag), unit)}"


def _polar(motion: complex) -> str:
    """Return amplitude and phase of a motion in m per volt."""
    return f"{si(abs(motion), 'm/V')}, phase {math.degrees(math.atan2(motion.imag, motion.real)):.2f}\u00b0"
