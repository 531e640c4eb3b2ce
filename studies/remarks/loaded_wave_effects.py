"""Estimates of the effects that the model of pillars on a loaded wave neglects, at each level of a run.

A size is a relative change of the velocity unless another quantity is named with it. The estimates hold to a factor of
about 2. Sources:

- overtones: reciprocity with the second harmonics of the contact forces;
- leakage: the limiting velocity of the bulk waves;
- compliance of the bodies: a half-space under a travelling pressure (Johnson, *Contact Mechanics*, section 13.2);
- scattering: Miller and Pursey, Proc. R. Soc. A 223 (1954) 521;
- adhesion: K. Kendall, J. Phys. D 4 (1971) 1186.
"""

import math
from collections.abc import Iterator
from contextlib import suppress

import numpy as np

import contact
import fem
from studies.model import pillars
from studies.model.model import model_of
from studies.model.wave_to_contact import Contact
from studies.record import Record
from studies.record.point import Point
from studies.remarks.ball_effects import LOAD, OVERTONES, point_admittance
from studies.remarks.ball_surface import ADHESION, CLEAN, DECIDES, WET
from studies.remarks.stator_effects import AMPLITUDE, Effects
from studies.solve.loaded_wave import wave_state
from studies.solve.solved_stator import contact_of_run

# Ratio of the compliance of silicon on 128YX lithium niobate under a pressure that travels with the wave to the static
# compliance 2/(E* k)
TRAVELLING = 1.62
# Relative decrease of the velocity divided by (dent of the mean plane / wave amplitude): for a free slider, and for a
# slider loaded with half of its stall force
DENT_FREE, DENT_HALF_STALL = 0.24, 0.65
# Isotropic half-space, nu = 1/4: Rayleigh over shear velocity, and shear modulus times the wave compliance Gamma
RAYLEIGH_OVER_SHEAR, SHEAR_TIMES_COMPLIANCE = 0.919402, 0.183486
SAMPLE = 0.18  # rms relative change of the velocity between random seeds, times sqrt(number of pillars)
MAX_COMPARED = 20_000  # largest number of pillars for which the motion is computed again with interaction
MARGIN = "the margin to bulk waves (it leaks from 100 % on)"


def effects_at_points(record: Record) -> list[list[tuple]]:
    """Return the neglected effects at each point of a run with pillars, each as fields of an `Effect`."""
    body, motion = contact_of_run(record), None
    effects: list[list[tuple]] = [[] for _ in record.points]
    for own, point in zip(effects, record.points, strict=True):
        with suppress(contact.ConvergenceError):
            if level := point.level:
                motion = wave_state(body, level, near=motion)
                own += _at_level(record, body, motion, point)
    return effects


def _at_level(record: Record, body: Contact, state, point: Point) -> Effects:
    motion, slider, level = state.loaded, record.scene.slider, point.level
    wave = motion.wave
    if body.misfit > 0.0:
        how = "rms misfit of two plane waves to the surface mode under the slider"
        yield "beating and spreading of the wave under the slider", AMPLITUDE, body.misfit, how
    how = "square of the contact resonance over the wave's frequency"
    resonance = math.sqrt(float(np.sum(body.slider.normal_stiffness)) / body.moving_slider.mass) / (2 * math.pi)
    yield "the slider's own vibration", "velocity", (resonance / wave.frequency) ** 2, how
    if wave.compliance > 0.0:
        if not motion.loading and motion.loading_number > 0.0:
            yield (LOAD, "velocity", motion.loading_number, "loading number 2 Gamma F/(w A), about the phase in rad")
        if motion.harmonics == 1:
            how = '|U_2/U_1| at the exit, first order; slider.loading = "harmonics" computes them'
            yield OVERTONES, "velocity", point.overtone_ratio, how
        yield from _scattering(motion)
    yield from _compliance(body, motion, slider)
    yield from leak(record, motion)
    if slider.pillars.height_scatter > 0.0:
        how = f"{SAMPLE:g} over the square root of the number of pillars, rms"
        yield "another seed of the heights", "velocity", SAMPLE / math.sqrt(motion.slider.number), how
    yield from _neighbours(body, state, slider, level)
    mean_radius = float(pillars.layout(slider).diameter.mean()) / 2
    pull_off = math.sqrt(8 * math.pi * mean_radius**3 * slider.effective_modulus * ADHESION) * motion.slider.number
    how = f"pull-off of flat punches, {ADHESION:g} J/m^2; a roughness of some nm removes it"
    yield "adhesion of perfectly flat pillars", "the preload", pull_off / slider.preload_force, how


def _compliance(body, motion, slider) -> Effects:
    """Yield the effect of the elastic deformation of stator and slider on the scale of the wavelength."""
    layout, wave = pillars.layout(slider), motion.wave
    prescribed = body.scene.wave
    if wave.amplitude == 0.0 or layout.x.size < 2 or (prescribed is not None and prescribed.wavelength is None):
        return
    area = (float(np.ptp(layout.x)) + layout.pitch) * pillars.strip_width(slider)
    pressure = float(np.abs(motion.forces.first_normal).sum()) / area
    dent = TRAVELLING * 2 / slider.effective_modulus * pressure / wave.wavenumber / wave.amplitude
    half_stall = slider.friction_coefficient * slider.preload_force / 2
    over_half_stall = min(1.0, abs(motion.load) / half_stall) if motion.load else 0.0
    slope = DENT_FREE + (DENT_HALF_STALL - DENT_FREE) * over_half_stall
    how = "first harmonic of the mean pressure on two half-spaces, at the wave's frequency and wavelength"
    yield "compliance of stator and slider at the wavelength", "velocity", -slope * dent, how


def _scattering(motion) -> Effects:
    """Yield the effect of the power scattered by unequal pillar forces, taken as independent point sources."""
    wave, forces = motion.wave, np.abs(motion.forces.first_normal)
    shear, speed = SHEAR_TIMES_COMPLIANCE / wave.compliance, wave.frequency * wave.wavelength / RAYLEIGH_OVER_SHEAR
    power = 0.5 * point_admittance(wave.omega, shear, speed) * float(np.sum((forces - forces.mean()) ** 2))
    if motion.wave_power_in > 0.0:
        how = f"{power:.2g} W, point loads on an isotropic half-space; a quarter of it over the incident power"
        yield "scattering by unequal pillars", "velocity", -power / motion.wave_power_in / 4, how


def leak(record: Record, motion) -> Effects:
    """Yield how close the loaded wave is to leaking, and the error of the first-order phase advance.

    Pillars stiffen the surface and make the wave faster. Above the limiting velocity of the bulk waves it leaks.
    """
    length = float(np.ptp(motion.row_x))
    if record.scene.stator is None or not motion.loading or length == 0.0:
        return
    stator = model_of(record.scene).plain
    half_space = fem.bound_wave(stator, motion.wave.frequency)
    margin = half_space.limiting_velocity / half_space.velocity - 1
    # The loading number approximates the phase advance. The angle of exit_over_entry cannot replace it because it is
    # known only modulo 2 pi.
    advance = motion.loading_number / (motion.wave.wavenumber * length)
    how = f"the load makes the wave faster by {100 * advance:.2g} %, bulk waves begin at {100 * margin:.2g} %"
    yield "speed-up of the wave by its load", MARGIN, advance / margin, how
    if stator.layers:
        return
    wave, body = motion.wave, motion.slider
    stiffness_ratio = float(np.mean(body.tangential_stiffness / body.normal_stiffness))
    # springs per area whose first-order shift of the wavenumber, Gamma (K_n + |orbit|^2 K_t), is the pillars' advance
    normal_stiffness = advance * wave.wavenumber / (wave.compliance * (1 + abs(wave.orbit) ** 2 * stiffness_ratio))
    exact = fem.spring_shift(
        stator.solid, normal_stiffness, stiffness_ratio * normal_stiffness, wave.frequency, stator.bare_surface
    )
    if exact is not None:
        how = "springs of the same advance on the half-space, exact root against first order in Gamma K/k"
        yield "first order in the load on the wave", "the phase's advance", -exact / advance - 1, how


def _neighbours(body, state, slider, level) -> Effects:
    """Yield the effect of the elastic interaction of neighbouring pillars, by solving the motion again with it."""
    layout = pillars.layout(slider)
    computable = 4 <= layout.x.size <= MAX_COMPARED and float(layout.diameter.mean()) / 2 / layout.pitch <= 0.4
    if slider.pillars.interaction or not computable or state.velocity == 0.0:
        return
    try:
        other = wave_state(body, level, near=state, slider=pillars.slider_of(slider, interaction=True))
    except contact.ConvergenceError:
        return
    how = "computed with slider.pillars.interaction = true"
    yield "stiffening of pillars by their neighbours", "velocity", other.velocity / state.velocity - 1, how


def wave_warnings(record: Record) -> Iterator[str]:
    """Yield the warnings about neglected effects of a loaded wave that do not change the velocity.

    `studies.remarks.run_warnings` covers those that do.
    """
    for each in record.model_error:
        quantity, size, source = each.quantity, each.size, each.source
        if quantity == MARGIN and size >= 1.0:
            remedy = "a smaller preload, a larger area of pillars or a larger amplitude keeps it slower"
            yield f"the loaded wave leaks into bulk waves, which is neglected ({source}): {remedy}"
        if quantity == "the preload" and size >= DECIDES and each.effect not in (CLEAN, WET):  # those of `smooth_balls`
            yield f"model error: {each.effect} would add {100 * size:.3g} % of the preload ({source})"
