"""Estimates of the effects that the model of a slider on balls neglects, as fields of `studies.record.blocks.Effect`.

Sources:

- load of the contacts on the wave: reciprocity with the surface wave (Auld, Acoustic Fields and Waves in Solids,
  vol. 2, 1973, chapter 10);
- radiation of a contact: G. F. Miller and H. Pursey, Proc. R. Soc. A 223 (1954) 521; for Poisson's ratio 1/4, all
  waves together.
"""

import math
from dataclasses import replace

import numpy as np

import contact
import fem
from studies.model.model import model_of
from studies.model.wave_to_contact import contact_slider
from studies.record import Record
from studies.record.point import Point
from studies.remarks.stator_effects import AMPLITUDE, Effects, amplitude_per_power, wavelength

POINT_ADMITTANCE = 0.93  # Re(v/F) over omega^2 / (2 pi mu c_T) of a point load on a half-space
NO_FRICTION = 1e-9  # coefficient of a frictionless contact: the averaged equilibrium requires a positive one
LOADS = 5  # levels of a run at which the load on the wave is computed, 6 ms each; linear in the voltage between them
NODE = 1e-6  # |u_z|/|u_x| below which u_z is a node: waves from both sides cancel
# Names of effects, here and in `loaded_wave_effects`
LOAD, OVERTONES = "load of the slider on the wave", "overtones of the wave under the pillars"


def point_admittance(omega: float, shear_modulus: float, shear_speed: float) -> float:
    """Return Re(v/F) in m/(N s) of a load normal to a half-space's surface at an angular frequency in rad/s."""
    return POINT_ADMITTANCE * omega**2 / (2 * math.pi * shear_modulus * shear_speed)


def radiation(record: Record) -> Effects:
    """Yield the power that a contact radiates into the stator, relative to its elastic force."""
    slider = record.scene.slider
    if slider is None or not slider.preload_force > 0:
        return
    solid, contacts = model_of(record.scene).surface_solid, slider.computed_contacts
    omega, body = 2 * math.pi * record.wave.frequency_Hz, contact_slider(slider.along_x)
    stiffness = (2 * math.pi * body.normal_resonance(contacts)) ** 2 * body.mass / contacts
    shear = float(solid.stiffness[4, 4])
    radiated = stiffness * point_admittance(omega, shear, math.sqrt(shear / solid.density)) / omega
    effect, how = "radiation of a contact into the stator", "point load on an isotropic half-space, nu = 1/4"
    yield effect, "the contact's elastic force", radiated, how


def loads_on_wave(record: Record) -> list[list[tuple]]:
    """Return for each point a list with the effect of the contacts' load on the wave, empty where there is none."""
    slider = record.scene.slider
    none: list[list[tuple]] = [[] for _ in record.points]
    if slider is None or not slider.preload_force > 0:
        return none
    tangential, _, normal = abs(record.surface_motion.at(list(slider.contact_positions)))
    if normal.max() < NODE * tangential.max() or amplitude_per_power(record) is None:
        return none
    how = "averaged equilibrium of the contacts on a wave that they load (elastic law)"
    voltages = [point.voltage_V for point in record.points]
    positive = sorted({voltage for voltage in voltages if voltage > 0.0})
    if not positive:
        return none
    some = [positive[number] for number in sorted({round(at) for at in np.linspace(0, len(positive) - 1, LOADS)})]
    sizes = np.interp(voltages, some, wave_load(record, some))
    return [
        [(LOAD, AMPLITUDE, float(size), how)] if voltage > 0.0 else []
        for voltage, size in zip(voltages, sizes, strict=True)
    ]


def wave_load(record: Record, voltages) -> list[float]:
    """Return the relative changes of a wave that passes below the slider, in a strip as wide as the aperture.

    If the averaged equilibrium does not converge, the change is the loading number, which approximates the phase that
    the contacts add to the wave.
    """
    slider, stator = record.scene.slider, model_of(record.scene).plain
    body = contact_slider(slider.along_x)
    offsets = [x - slider.center[0] for x, _ in slider.contact_positions]
    # A loaded wave takes dry contacts and the elastic law with Coulomb's friction alone. Each computed contact stands
    # for slider.share contacts; the body bears 1/share of the slider's preload.
    balls = replace(
        body, law="elastic", reciprocal=False, stick_band=0.0, friction=None, mass=math.inf, load=0.0, adhesion=None,
        friction_coefficient=body.static_coefficient or NO_FRICTION, preload=body.preload * slider.share,
        x=offsets, weights=slider.share,
    )  # fmt: skip
    tangential, _, normal = abs(record.surface_motion.at(list(slider.contact_positions)))
    strongest = int(np.argmax(normal))  # the centre may be a node of the wave
    at_one_volt = contact.PassingWave(
        frequency=record.wave.frequency_Hz, wavelength=wavelength(record), forward=float(normal[strongest]),
        ratio=float(tangential[strongest] / normal[strongest]), strip_width=record.scene.driven_transducer.aperture,
        compliance=fem.bound_compliance(stator, record.wave.frequency_Hz), loading=True,
    )  # fmt: skip
    changes, near = [], None
    for voltage in voltages:
        wave = replace(at_one_volt, forward=at_one_volt.forward * float(voltage))
        try:
            near = contact.steady(balls, wave, tolerance=1.0, near=near)
            changes.append(abs(near.loaded.exit_over_entry - 1.0))
        except contact.ConvergenceError:
            changes.append(wave.loading_number(balls.preload))
    return changes


def travel_over_ripple(record: Record, point: Point) -> Effects:
    """Yield the effect of a burst's travel at a point, where it is computed at a fixed position."""
    scene, ratio = record.scene, record.wave.standing_wave_ratio
    if scene.slider is None or scene.burst is None or point.travel_m is not None:
        return
    if abs(point.velocity_m_per_s or 0.0) * scene.burst > wavelength(record) / 4:
        how = "standing-wave ratio, over a travel of more than a quarter of a wavelength"
        effect = "travel of the slider along the rippled field"
        yield effect, AMPLITUDE, (ratio - 1) / (ratio + 1), how
