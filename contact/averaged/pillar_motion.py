"""Steady velocity, wave loading and load line of a slider on many pillars or balls, averaged over the wave's cycle."""

import math
from dataclasses import replace

from contact import parameter_check
from contact.averaged.pillar_results import PillarLoadLine, PillarMotion
from contact.averaged.pillar_slider import PillarSlider
from contact.averaged.pillars import PassingWave, Pillars
from contact.error_estimate import richardson
from contact.exceptions import ConvergenceError, InputError

HARMONICS = "harmonics"  # value of `loading` that includes the overtones of the wave
# Numbers of harmonics to try, until the error of the velocity by those left out is below OVERTONE_ERROR. It falls with
# the square of the number.
NUMBERS = (8, 16, 32, 64)
OVERTONE_ERROR = 5e-4  # half of the default tolerance


def pillar_motion(
    pillars: Pillars, wave: PassingWave, *, load: float = 0.0, loading: bool | str | None = None,
    near: PillarMotion | None = None,
) -> PillarMotion:  # fmt: skip
    """Return the steady motion of a slider on pillars.

    Parameters
    ----------
    pillars : Pillars
    wave : PassingWave
    load : float
        Force against the direction of the unloaded motion, N, zero or positive.
    loading : bool or "harmonics", optional
        True if the pillars act back on the wave. None means True if the loading number is above 0.05. "harmonics" also
        includes the overtones that the contact forces radiate; on a bare crystal, which has no dispersion, they add up
        in phase along the slider.
    near : PillarMotion, optional
        A motion of pillars at the same positions on a similar wave, from which the search starts. With "harmonics" its
        number of harmonics is used if it has overtones.

    Returns
    -------
    PillarMotion

    Raises
    ------
    ValueError
        If the load drags the slider backwards.
    ConvergenceError
        If the search for the equilibrium does not converge.

    Examples
    --------
    Ten thousand pillars of 20 um on 5 mm x 5 mm:

    >>> import numpy as np
    >>> x, y = (each.ravel() for each in np.meshgrid(np.arange(100) * 50e-6 - 2.475e-3, np.arange(100) * 50e-6))
    >>> slider = Pillars(
    ...     x=x, y=y, normal_stiffness=1.8e6, tangential_stiffness=1.52e6, friction_coefficient=0.18, preload=30.0
    ... )
    >>> wave = PassingWave(
    ...     frequency=9.61e6, wavelength=414.05e-6, ratio=0.88995, forward=20e-9,
    ...     compliance=2.5078e-12, strip_width=5e-3,
    ... )
    >>> round(pillar_motion(slider, wave, loading=False).velocity, 8)
    -0.92621972
    >>> loaded = pillar_motion(slider, wave)
    >>> bool(abs(loaded.ledger_residual) < 1e-12)
    True
    """
    load = parameter_check.non_negative("load", load, "N")
    if loading != HARMONICS:
        return truncated_motion(pillars, wave, load, loading, near, 1)
    if pillars.backing == "soft" or pillars.shape != "punch":
        raise InputError("loading", 'must not be "harmonics" with a soft backing or with balls', loading)
    if near is not None and near.harmonics > 1:
        return truncated_motion(pillars, wave, load, True, near, near.harmonics)
    try:
        motion = truncated_motion(pillars, wave, load, True, near, 1)
    except InputError:  # the slider cannot carry the load without the overtones, but perhaps with them
        motion = truncated_motion(pillars, wave, load, True, None, NUMBERS[0])
    truncation_error = 0.0
    for number in NUMBERS:
        coarser = motion
        try:
            motion = truncated_motion(pillars, wave, load, True, coarser, number)
        except ConvergenceError:  # this number has no equilibrium within reach of `coarser`; perhaps the next has
            if number == NUMBERS[-1]:
                raise
            continue
        truncation_error = richardson(abs(motion.velocity - coarser.velocity) / motion.speed_scale, 2.0, 2)
        if truncation_error < OVERTONE_ERROR:
            break
    return replace(motion, relative_error=motion.relative_error + truncation_error, truncation=truncation_error)


def truncated_motion(pillars, wave, load, loading, near, harmonics) -> PillarMotion:
    """Return the motion of a wave whose harmonics above a fixed number are left out.

    ``harmonics`` counts the driven wave as the first, so that 1 leaves out all overtones. The other parameters are
    those of `pillar_motion`, ``loading`` True, False or None.
    """
    slider = PillarSlider(pillars, wave, loading, harmonics)
    if near is not None:
        slider.begin_at(near)
    # the load with the sign of the unloaded motion, which it opposes
    signed_load = slider.directed(load) if near is None or near.velocity == 0.0 else math.copysign(load, near.velocity)
    equilibrium = None  # remains so if the load accelerates the slider without end
    try:
        equilibrium = slider.under(signed_load)
    except ConvergenceError as error:
        if error.status != "runaway" or load == 0.0:
            raise
    moves_backwards = equilibrium is not None and load > 0.0 and equilibrium.w * signed_load < 0.0
    if equilibrium is None or moves_backwards:
        stall, max_load = slider.stall(math.copysign(1.0, signed_load))
        raise InputError(
            "load",
            f"must be at most {max_load:.6g} N, above which it drags the slider backwards (in motion this carries "
            f"{stall:.6g} N, its stall)", load, "N",
        )  # fmt: skip
    return slider.motion(equilibrium, signed_load)


def pillar_load_line(
    pillars: Pillars, wave: PassingWave, *, points: int = 20, loading: bool | str | None = None
) -> PillarLoadLine:
    """Return the load line of a slider on pillars, with loads in equal steps from zero to the stall.

    `points` is the number of motions, at least 2. The other parameters are those of `pillar_motion`.
    """
    points = parameter_check.count("points", points, 2)
    free = pillar_motion(pillars, wave, loading=loading)
    if free.held:
        raise ConvergenceError("not applicable", "the slider is at rest without a load: it has no load line")
    slider = PillarSlider(pillars, wave, free.loading, free.harmonics)
    slider.begin_at(free)
    direction, motions = math.copysign(1.0, free.velocity), [free]
    unloaded = slider.equilibrium.unknowns.copy()
    stall, max_held_load = slider.stall(direction)
    slider.equilibrium.unknowns = unloaded  # the search for the stall has moved them
    for number in range(1, points - 1):
        load = direction * stall * number / (points - 1)
        motions.append(slider.motion(slider.under(load), load))
    last = slider.rest(direction, direction * stall)
    motions.append(slider.motion(last, direction * stall))
    return PillarLoadLine(motions=tuple(motions), stall=stall, held_up_to=max_held_load)


def pillar_traction(
    pillars: Pillars, wave: PassingWave, *, load: float = 0.0, loading: bool | None = None,
    near: PillarMotion | None = None,
):  # fmt: skip
    """Return a function traction(velocity in m/s, factor on the wave amplitude) that gives <sum Q> in N.

    It serves the averaged motion as a function of time, with height and tilts in equilibrium at all times. `load` in N
    has the sign of the motion that it opposes; it tilts the slider if it acts at a height. Each call starts from the
    result of the last one, and the first call starts from `near`. If `near` has overtones, they are included.
    """
    if near is None:
        slider = PillarSlider(pillars, wave, loading)
    else:
        slider = PillarSlider(pillars, wave, near.loading, near.harmonics)
        slider.begin_at(near)
    cycle, equilibrium = slider.cycle, slider.equilibrium
    full_incident, last_factor = cycle.incident.copy(), 1.0

    def traction(velocity: float, factor: float = 1.0) -> float:
        nonlocal last_factor
        cycle.incident = full_incident * factor
        # the search starts from the amplitudes of the last call, scaled to this wave
        change = factor / last_factor
        cycle.forward, cycle.backward = cycle.forward * change, cycle.backward * change
        last_factor = factor
        side = math.copysign(1.0, load) if velocity == 0.0 else math.copysign(1.0, velocity)
        return equilibrium.solve(load, velocity / wave.omega, side).traction

    return traction
