"""What the model of pillars on a loaded wave leaves out, each effect with its size for one run at its largest level.

Sizes are relative changes of the velocity unless said; they hold to a factor of about 2. Sources: overtones,
reciprocity with the second harmonics of the forces; leak, the limiting velocity of the bulk waves; compliance of the
bodies, a half-space under a travelling pressure (Johnson, *Contact Mechanics*, section 13.2); scattering, Miller and
Pursey, Proc. R. Soc. A 223 (1954) 521; adhesion, K. Kendall, J. Phys. D 4 (1971) 1186.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import contact
from studies.chain import pillars
from studies.chain.bridge import DrivenContact
from studies.chain.pillar_points import PillarContact, bounce_ratio
from studies.chain.radiation import point_admittance
from studies.record import Record

# Compliance of silicon and 128YX niobate to a pressure that travels with the wave, over the static 2/(E* k)
TRAVELLING = 1.62
# Change of the velocity for one of the mean plane's dent over the amplitude: a free slider, and one at half its stall
DENT_FREE, DENT_HALF_STALL = 0.24, 0.65
RAYLEIGH_OVER_SHEAR, ISOTROPIC = 0.919402, 0.183486  # nu = 1/4
SAMPLE = 0.18  # rms difference of a sample of pillars from their distribution, times the root of their number
ADHESION = 0.05  # J/m^2, of clean oxides in air
MAX_COMPARED = 20_000  # pillars whose motion is computed once more with their neighbours
LOAD = "load of the slider on the wave"
OVERTONES = "overtones of the wave under the pillars"
Rows = Iterator[tuple[str, str, float, str]]


def pillar_rows(record: Record) -> Rows:
    """Yield effect, quantity, size and source for a run with pillars."""
    driven = DrivenContact.of_run(record)
    body, level = PillarContact.of(driven), max(record.scene.levels)
    if level == 0.0:
        return
    try:
        motion = body.motion(level)
    except contact.ConvergenceError:
        return
    wave, slider = motion.wave, record.scene.slider
    if body.misfit > 0.0:
        how = "what two surface waves of one wavelength leave of the surface mode there, rms"
        yield "beating and spreading of the wave under the slider", "u_z", body.misfit, how
    vibration = bounce_ratio(slider, wave.frequency) ** 2
    yield (
        "the slider's own vibration",
        "velocity",
        vibration,
        "square of its bounce over the wave's frequency",
    )
    if wave.compliance > 0.0:
        if not motion.loading and motion.loading_number > 0.0:
            yield (
                LOAD,
                "velocity",
                motion.loading_number,
                "loading number 2 Gamma F/(w A), about the phase in rad",
            )
        if motion.harmonics == 1:
            how = '|U_2/U_1| at the exit, first order; slider.loading = "harmonics" computes them'
            yield OVERTONES, "velocity", motion.overtone, how
        yield from _scattering(motion)
    yield from _compliance(body, motion, slider, level)
    yield from leak(record, motion)
    if slider.pillars.height_scatter > 0.0:
        share = SAMPLE / math.sqrt(motion.pillars.number)
        yield "another seed of the heights", "velocity", share, "0.18 over the root of the number, rms"
    yield from _neighbours(body, motion, slider, level)
    a = float(pillars.layout(slider)["diameter"].mean()) / 2
    pull = math.sqrt(8 * math.pi * a**3 * slider.effective_modulus * ADHESION) * motion.pillars.number
    how = f"pull-off of flat punches, {ADHESION:g} J/m^2; a roughness of some nm removes it"
    yield "adhesion, if the pillars were perfectly flat", "the preload", pull / slider.preload_force, how


def _compliance(body, motion, slider, level) -> Rows:
    """Yield what the bodies' own compliance at the wavelength does, free or under a load."""
    place, wave = pillars.layout(slider), motion.wave
    if wave.amplitude == 0.0 or place["x"].size < 2:
        return
    area = (float(np.ptp(place["x"])) + place["pitch"]) * pillars.strip_width(slider)
    pressure = float(np.abs(motion.first_normal).sum()) / area
    if body.driven.scene.wave is not None and body.driven.scene.wave.wavelength is None:
        return
    dent = TRAVELLING * 2 / slider.effective_modulus * pressure / wave.wavenumber / wave.amplitude
    share = DENT_FREE
    if motion.load != 0.0:
        stall = slider.friction_coefficient * slider.preload_force
        share += (DENT_HALF_STALL - DENT_FREE) * min(1.0, 2 * abs(motion.load) / stall)
    how = "first harmonic of the mean pressure on two half-spaces, at the wave's frequency and wavelength"
    yield "compliance of stator and slider at the wavelength", "velocity", -share * dent, how


def _scattering(motion) -> Rows:
    """Yield what the unequal forces scatter, as if each of them radiated by itself."""
    wave = motion.wave
    shear, speed = ISOTROPIC / wave.compliance, wave.frequency * wave.wavelength / RAYLEIGH_OVER_SHEAR
    admittance = point_admittance(wave.omega, shear, speed)
    size = np.abs(motion.first_normal)
    power = 0.5 * admittance * float(np.sum((size - size.mean()) ** 2))
    if motion.wave_power_in > 0.0:
        how = (
            f"{power:.2g} W, point loads on an isotropic half-space; a quarter of it over the incident power"
        )
        yield "scattering by unequal pillars", "velocity", -power / motion.wave_power_in / 4, how


def leak(record: Record, motion) -> Rows:
    """Yield how much of the advance that makes the wave leak is reached, and how exact that advance is."""
    length = float(np.ptp(motion.row_x))
    if record.scene.stator is None or not motion.loading or length == 0.0:
        return
    import fem
    from studies.chain import resolve

    stator = resolve.stator(record.scene.stator)
    half_space = fem.rayleigh(stator.solid, stator.bare_surface)
    margin = half_space.limiting_velocity / half_space.velocity - 1
    # about the phase's advance: the exit's angle is known to a turn
    advance = motion.loading_number / (motion.wave.wavenumber * length)
    how = f"the wave is faster by {100 * advance:.2g} %, bulk waves begin at {100 * margin:.2g} %"
    yield "leak into bulk waves", "the limit of bound waves", advance / margin, how
    wave, share = (
        motion.wave,
        float(np.mean(motion.pillars.tangential_stiffness / motion.pillars.normal_stiffness)),
    )
    normal = advance * wave.wavenumber / (wave.compliance * (1 + abs(wave.orbit) ** 2 * share))
    exact = fem.spring_shift(stator.solid, normal, share * normal, wave.frequency, stator.bare_surface)
    if exact is not None:
        how = "springs of the same advance on the half-space, exact root against first order in Gamma K/k"
        yield "first order in the load on the wave", "the phase's advance", -exact / advance - 1, how


def _neighbours(body, motion, slider, level) -> Rows:
    """Yield what the neighbours' stiffening does, by computing it."""
    place = pillars.layout(slider)
    share = float(place["diameter"].mean()) / 2 / place["pitch"]
    if slider.pillars.interaction or place["x"].size > MAX_COMPARED or place["x"].size < 4 or share > 0.4:
        return
    if motion.velocity == 0.0:
        return
    try:
        other = replace(body, pillars=pillars.pillars_of(slider, interaction=True)).motion(level)
    except contact.ConvergenceError:
        return
    how = "computed with slider.pillars.interaction = true"
    yield "stiffening of pillars by their neighbours", "velocity", other.velocity / motion.velocity - 1, how


def pillar_warnings(record: Record) -> Iterator[str]:
    """Yield a warning for what `studies.chain.warnings` does not know: effects that are no change of the velocity."""
    for row in record.model_error:
        if row["quantity"] == "the limit of bound waves" and row["size"] >= 1.0:
            yield f"the loaded wave leaks into bulk waves ({row['source']}): more or shorter strips, or less preload"
        if row["quantity"] == "the preload" and row["size"] >= 0.1:
            yield f"model error: {row['effect']} would add {100 * row['size']:.3g} % of the preload ({row['source']})"
    slider, block = record.scene.slider, record.scene.slider.pillars
    default_seed = block.height_scatter > 0.0 and block.seed == pillars.SEED
    if default_seed:
        yield f"the heights scatter with the seed {block.seed}, which is chosen where slider.pillars.seed is absent"
    if slider.damping.normal or slider.damping.contact:
        yield "slider.damping.normal and contact do nothing here: the averaged slider on pillars does not bounce"
