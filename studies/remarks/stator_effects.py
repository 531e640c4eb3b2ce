"""Estimates of the effects on u_z and on the power that the model of a driven stator neglects.

Each function takes the record of a run and yields the fields of an `Effect`, with the largest size over the drive's
frequencies.  The size of the finite aperture is that of a ripple; its sign may be wrong in cuts in which a beam hardly
spreads.

Sources:

- side faces: `fem.surface_beam`;
- finite aperture: `fem.surface_beam` where it is left out by choice, else `fem.Slowness`, the spectrum of a slit;
- mass and stiffness of the electrodes, and a coating: perturbation theory (Auld, Acoustic Fields and Waves in Solids,
  vol. 2, 1973, chapter 12), `fem.film_shift`.
"""

import math
from collections.abc import Iterable, Iterator
from contextlib import suppress

import numpy as np

import fem
from studies.model.model import model_of
from studies.model.solid_of_material import frequency_coefficient, thermal_table
from studies.record import Record
from studies.scene.stator_keys import Transducer

# Relative error of |u_z| if the charge is assumed uniform along the fingers. Measured on PZT-8 for 3 to 30 finger
# pairs and apertures of 5 to 30 wavelengths: 2.6 to 10 % at the worst of 80 points, 0.9 to 3.7 % rms
# (tests/fem/beam/test_finger_ends.py).
UNIFORM_CHARGE = 0.05
# Relative error of |u_z| that remains with the static charge at the finger ends: the minimum, and the increase per
# finger pair. Measured on PZT-8, rms over 80 points: 0.9 to 1.1 % with 2 to 10 pairs, 4.7 % with 30
# (tests/fem/beam/test_finger_ends.py).
UNEVEN_CHARGE, UNEVEN_PER_PAIR = 0.01, 0.0016
# Change of |u_z| by the vacuum over its share of the permittivity times K2, the largest measured: 2.4 in twente-left,
# 4.0 in twente, 1.3 in lithium-niobate-128yx, 3.4 in lithium-niobate-yz (sawmotor run SCENE --set
# stator.above=vacuum).
VACUUM_FACTOR = 4.0
# Relative change of a solid's stiffness over its strain, 3 + C111/C11 in size: 2 to 15 (M. A. Breazeale and J. Philip,
# Physical Acoustics 17 (1984) 1). From LISTED on the effect is stated; hard PZT breaks at a third of that strain.
NONLINEARITY, LISTED = 5.0, 0.01
# Velocity of a prescribed wave without a wavelength, m/s: 2100 to 2300 in PZT, 3100 to 4000 in quartz and lithium
# niobate (the free waves of the scenes rayleigh and lithium-niobate-*)
USUAL_VELOCITY = 3000.0
FILM, COATING = 100e-9, "AlN"  # thickness in m of the electrodes and of a coating, and the coating's material

Effects = Iterator[tuple]  # values of the fields of `studies.record.blocks.Effect`
AMPLITUDE = "u_z"  # the quantity that most effects change: the normal amplitude under the slider


def stator_effects(record: Record) -> Effects:
    """Yield the neglected effects on u_z; they do not depend on the level."""
    beam = _left_out_beam(record)
    yield from _aperture(record, beam)
    yield from _finger_ends(record, beam)
    yield from vacuum_effect(record)
    yield from _electrodes(record)
    yield from _thermal_stress(record)


def _left_out_beam(record: Record):
    """Return the beam that ``stator.diffraction = false`` leaves out, where it takes less than a second, or None."""
    block = record.scene.stator
    if (
        record.surface_motion.beam is not None
        or block.diffraction is not False
        or block.ends != "absorbing"
        or record.scene.crossed
        or record.scene.in_strips
        or record.scene.piece
    ):
        return None
    if not fem.isotropic_about_normal(model_of(record.scene).solid):
        return None
    with suppress(fem.BeamError, fem.ConvergenceError):
        return fem.surface_beam(record.surface_wave, mirror_width=block.mirror_width)
    return None


def wavelength(record: Record) -> float:
    """Return the wavelength of the surface wave, m."""
    return record.wave.phase_velocity_m_per_s / record.wave.frequency_Hz


def _aperture(record: Record, left_out) -> Effects:
    """Yield the largest effect at the contacts on u_z of the finite aperture or, in a beam model, of the side faces.

    ``left_out``: the beam that a plane section leaves out by choice, or None.  It spreads the echoes of other
    transducers too, which have gone farther; the angular spectrum is of the driven aperture's own wave alone.
    """
    motion, block = record.surface_motion, record.scene.stator
    positions = record.scene.contact_positions
    if record.scene.piece:
        # a meshed piece has no guided modes to test; compare with the extents of the transducers
        extents = [each.extent for each in model_of(record.scene).transducers]
        covered = any(left <= x <= right for x, _ in positions for left, right in extents)
    else:
        covered = any(map(motion.covered, positions))
    if covered:
        return
    section = abs(motion.at(positions)[2])
    if left_out is not None and section.all():
        x, y = zip(*positions, strict=True)
        with suppress(fem.BeamError, fem.ConvergenceError):
            worst = max(abs(left_out.motion(x, y)[2]) / section - 1, key=abs)
            how = "the beam of the finite aperture, computed for this line, over the plane section"
            yield "finite aperture", AMPLITUDE, float(worst), how
            return
    if motion.beam is None or (record.scene.in_strips and not motion.spreads):
        spreads = [_spread(record, each, *zip(*positions, strict=True)) for each in record.scene.driven_transducers]
        worst = max(np.concatenate(spreads) - 1, key=abs)
        how = "angular spectrum of the driven aperture, on the cut's slowness curve"
        yield "finite aperture", AMPLITUDE, float(worst), how
        return
    if record.scene.crossed:
        yield from _crossed(record, positions)
        return
    beam, at = motion.beam, tuple(zip(*positions, strict=True))
    if record.scene.in_strips:
        images = beam.first_images(*at, block.width) / abs(beam.motion(*at)[2])
        how = "first images of the strips' beams in both side faces, which are assumed to reflect everything in phase"
        yield "side faces", AMPLITUDE, float(images.max()), how
        return
    changes = []
    for each in record.surface_motions:
        other = each.beam.with_side_faces(None if block.mirror_width else block.width)
        changes.append(abs(other.motion(*at)[2] / each.at(positions)[2]) - 1)
    worst = max(np.concatenate(changes), key=abs)
    how = "the beam with side faces that reflect like mirrors, compared with the beam without side faces"
    yield "side faces", AMPLITUDE, float(worst), how


def _crossed(record: Record, positions) -> Effects:
    """Yield the neglected effects of crossing beams: images in the side faces, and metal of transducers they pass.

    Both are changes of the root mean square of u_z over all frequencies, without the nodes of the beams' interference.
    """
    beams, (x, y) = [each.beam for each in record.surface_motions], zip(*positions, strict=True)
    amplitude = _root_sum_square(each.incoherent_amplitude(x, y) for each in beams)
    images = _root_sum_square(each.first_images(x, y) for each in beams)
    how = "first images of the beams in the faces along them, which are assumed to reflect everything in phase"
    yield "side faces", AMPLITUDE, float((images / amplitude).max()), how
    solid = model_of(record.scene).solid
    bare, metal = (fem.rayleigh(solid, surface).velocity for surface in ("open", "metallised"))
    shadows = _root_sum_square(each.shadowed(1 - metal / bare) for each in beams)
    phase_shift = float(shadows / amplitude.min())
    how = "phase change of a beam along the fingers that it crosses, from the velocities with and without metal"
    yield "metal of the transducers in the way of crossing beams", AMPLITUDE, phase_shift, how


def _root_sum_square(values: Iterable) -> np.ndarray:
    return np.sqrt(sum(np.square(each) for each in values))


def _spread(record: Record, driven: Transducer, x, y) -> np.ndarray:
    """Return the amplitude radiated by the aperture of a driven transducer, relative to a plane wave.

    ``x`` is measured from the left end of the stator and ``y`` from its axis, both in m.
    """
    stator = model_of(record.scene).plain
    wave, frequency = record.wave, record.wave.frequency_Hz
    try:
        if stator.layers:
            raise fem.ConvergenceError("the slowness curve of layers is not computed")
        curve = fem.Slowness.of_half_space(stator.solid, frequency, stator.bare_surface)
    except fem.ConvergenceError:
        # some directions have no surface wave: assume the velocity along x in all directions
        curve = fem.Slowness.circle(2 * math.pi * frequency / wave.phase_velocity_m_per_s)
    return curve.spectrum(driven.aperture, np.subtract(x, driven.center_xy[0]), y)


def _finger_ends(record: Record, left_out) -> Effects:
    """Yield the effect of the charge distribution along the fingers.

    The section, and a beam at a covered point, take the charge as uniform. Other beams represent it by steps or by the
    static charge at the finger ends; the remaining error is yielded, the largest over contacts and frequencies. The
    beam that a plane section leaves out, with its steps, is the line on the finite aperture, beside which the same
    error remains.
    """
    positions, effect = record.scene.contact_positions, "charge at the finger ends"
    ceramic = "in lead zirconate titanate"
    motion, motions, at = record.surface_motion, record.surface_motions, tuple(zip(*positions, strict=True))
    covered = any(map(motion.covered, positions))
    beams = [each.beam or left_out for each in motions]
    if not covered and None not in beams:
        errors = [each.charge_error(*at) for each in beams]
        if all(each is not None for each in errors):
            of_strips = "share of what the ends and tips of the fingers change"
            how = of_strips if record.scene.in_strips else "change by fewer steps of the charge along the fingers"
            yield effect, AMPLITUDE, float(np.max(errors)), how
            return
    if motion.beam is None or covered or record.scene.crossed or record.scene.in_strips:
        yield effect, AMPLITUDE, UNIFORM_CHARGE, f"fingers whose charge varies along them, {ceramic}"
        return
    stator = model_of(record.scene).plain
    excess = fem.end_excess(stator.solid, stator.bare_surface)
    longer = [each.with_longer_fingers(excess).motion(*at)[2] for each in beams]
    changes = [abs(ends) / abs(each.at(positions)[2]) - 1 for ends, each in zip(longer, motions, strict=True)]
    worst = float(max(np.concatenate(changes), key=abs))
    yield effect, AMPLITUDE, worst, "static charge at the ends of fingers in a long row"
    most = max(each.finger_pairs for each in record.scene.driven_transducers)
    remainder = max(UNEVEN_CHARGE, UNEVEN_PER_PAIR * most)
    how = f"error that remains with static charge at the ends, {ceramic}"
    yield "ripple of the charge along the fingers", AMPLITUDE, remainder, how


def vacuum_effect(record: Record) -> Effects:
    """Yield the effect of the field in the vacuum on u_z, which is of second order.

    The charges grow by the share eps_0 / eps_p, and the potential of the wave, to which they couple, falls by as much.
    """
    if record.scene.stator.above == "none":
        stator, frequencies = model_of(record.scene).stator, record.scene.drive.frequencies
        share = fem.VACUUM_PERMITTIVITY / stator.solids[-1].sagittal_permittivity
        try:
            size = VACUUM_FACTOR * share * max(_bound_coupling(stator, each) for each in frequencies)
            how = "eps_0 over the permittivity of the solid, times the coupling K2 of the surface wave"
        except fem.ConvergenceError:
            size, how = share, "eps_0 over the permittivity of the solid: K2 of a leaky wave is not known"
        yield "vacuum above the surface", AMPLITUDE, size, how


def _bound_coupling(stator, frequency: float) -> float:
    """Return the coupling K2 of the bound wave of a stator at a frequency in Hz."""
    bare, metal = (fem.bound_wave(stator, frequency, each).velocity for each in ("open", "metallised"))
    return 2 * (bare - metal) / bare


def amplitude_per_power(record: Record) -> float | None:
    """Return the constant C of u_z = C (P / (W f))^(1/2) in SI units, or None if it cannot be determined.

    P is half of the power that the transducer takes in, W the aperture and f the frequency. u_z is the amplitude of the
    surface mode half a wavelength outside the driven fingers. C is unknown if the ends of the stator reflect, if
    several sources drive, or if that point is covered by electrodes.
    """
    scene, wave, power = record.scene, record.surface_wave, record.electrical.power_W_per_V2
    driven = model_of(scene).driven
    if scene.crossed:  # the group of the driven transducer has its own axes
        transducers = record.surface_motion.beam.rows[0].transducers
        driven = next(each for each in transducers if scene.drive.driven.get(each.name))
    (left, right), half_wavelength = driven.extent, wavelength(record) / 2
    sample_x = right + half_wavelength if driven.center < wave.length / 2 else left - half_wavelength
    is_free = 0 <= sample_x <= wave.length and not wave.covered(sample_x)
    several = record.electrical.sources is not None
    if several or scene.in_strips or scene.stator.ends != "absorbing" or not is_free or not power > 0:
        return None
    per_width = power / 2 / driven.aperture
    return float(abs(wave.rayleigh_motion(sample_x)[1])) / math.sqrt(per_width / record.wave.frequency_Hz)


def _electrodes(record: Record) -> Effects:
    """Yield the effect of the electrodes' mass and stiffness, and of a hard coating where no layer is given."""
    stator = model_of(record.scene).stator
    try:
        shifts = [
            [fem.film_shift(stator, fem.material(name), FILM, each) for each in record.scene.drive.frequencies]
            for name in ("aluminium", COATING)
        ]
        metal, coating = (max(each, key=abs) for each in shifts)
    except fem.ConvergenceError:  # no wave is bound, so that none is known to be perturbed
        return
    driven = record.scene.driven_transducer
    if amplitude_per_power(record) is not None:
        # phase accumulated from the middle of the transducer to its end
        phase = math.pi * driven.finger_pairs * driven.metallisation * metal
        how = "first-order perturbation of the velocity under the fingers, over half of the row"
        yield "mass and stiffness of 100 nm aluminium on the fingers", AMPLITUDE, phase, how
    if not stator.layers:
        how = "first-order perturbation by a film of the stiffest usual coating, in proportion to its thickness"
        yield f"coating of 100 nm {COATING}, if there is one", "the phase velocity", coating, how


def _thermal_stress(record: Record) -> Effects:
    """Yield what the stress of layers that expand otherwise than the stator's material does to their stiffness."""
    block = record.scene.stator
    temperature = (
        block.temperature if record.heat.steady_temperature_degC is None else record.heat.steady_temperature_degC
    )
    if not block.layer or temperature is None or frequency_coefficient(block) is not None:
        return
    along = fem.expansion_along(thermal_table(block.material), block.cut, temperature)
    strains = [fem.expansion_along(thermal_table(each.material), each.cut, temperature) - along for each in block.layer]
    worst = max(strains, key=abs)
    how = f"strain of {worst:.2g} along x, times the nonlinearity parameter of solids, about {NONLINEARITY:g}"
    yield "thermal stress of the layers", "their stiffness", NONLINEARITY * worst, how


def surface_strain(record: Record, level: float) -> float:
    """Return the largest strain of the wave along the surface, k |u_x|, at a level in V, or m of a prescribed wave.

    Of a prescribed wave it is the larger of strain and slope, k |u_z|, because its ratio may be any number.
    """
    wave = record.scene.wave
    if wave is not None:
        velocity = USUAL_VELOCITY if wave.wavelength is None else wave.wavelength * wave.frequency
        return 2 * math.pi * wave.frequency / velocity * level * max(1.0, wave.tangential_ratio)
    return 2 * math.pi / wavelength(record) * level * float(abs(record.surface.u_x_m_per_V).max())


def large_strain(record: Record, level: float) -> Effects:
    """Yield the effect of a strain beyond linear elasticity, from `LISTED` on."""
    strain = surface_strain(record, level)
    if NONLINEARITY * strain >= LISTED:
        name = "k |u_x|" if record.scene.wave is None else "k |u|"
        how = f"the strain {name} = {strain:.2g}, times the nonlinearity parameter of solids, about {NONLINEARITY:g}"
        yield "nonlinear elasticity", AMPLITUDE, NONLINEARITY * strain, how


def heating(record: Record) -> Effects:
    """Yield the highest rise of the drive's temperature, or the power where no temperature is known.

    A run at its own steady temperature leaves nothing out.
    """
    if record.heat.steady_temperature_degC is not None:
        return
    if record.heat.highest_rise_K is not None:
        block = record.heat
        where = f"at x = {1e3 * block.hottest_x_m:.3g} mm"
        drive = "continuous drive" if block.duty is None else f"duty of {100 * block.duty:.3g} %"
        how = f"{drive} at {block.voltage_V:g} V, highest {where}, its effect on the wave left out"
        yield "heating of the stator", how, block.highest_rise_K, "temperature", "K"
        return
    if record.heat.burst_rise_K is not None:
        how = f"mean rise by one burst at {record.heat.voltage_V:g} V, its effect on the wave left out"
        yield "heating of the stator", how, record.heat.burst_rise_K, "temperature", "K"
        return
    highest = max(record.scene.levels, default=0.0)
    power = record.electrical.power_W_per_V2 * highest**2
    yield "heating of the stator", f"the whole power taken in at {highest:g} V", power, "admittance", "W"
