"""The chain from a scene to its record: stator at its frequency, times the voltage, contact, velocity.

Only what the scene needs is imported and computed.  The tolerance bounds the last quantity.  The stator
begins with a quarter of it; where the contact turns out to multiply the stator's error (near the threshold
by 20), the stator is solved again, better.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

import fem
from studies.chain import bridge
from studies.chain.model_error import model_error
from studies.chain.neglected import diffraction_left_out, driven_left_out, free_left_out
from studies.chain.points import SliderAnswer, slider_answer
from studies.chain.ring_up import ring_up, ring_up_left_out
from studies.chain.source_powers import powers, recovered, recovery_left_out, with_available_power
from studies.chain.surface_motion import SurfaceMotion, solved_motion
from studies.chain.warnings import warnings_of
from studies.record import Record
from studies.refusal import RunError, SceneError
from studies.scene import Scene, resolved

__all__ = ["run", "slider_left_out"]

SHARE = 0.25  # of the tolerance, for the stator at first and for the contact
STALLED = (
    0.7  # of the motion's error: what is left then is the beam's own, which no finer section makes smaller
)
PER_WAVELENGTH = 12  # lines of surface.csv where no section lies along x
HOPELESS = 3  # tolerances of the beam's own error at the best point, beyond which no finer section is tried
ROUNDS = 3  # of the stator, each with the tolerance that the one before found to be needed


def run(
    scene: Scene | str | Path = "twente",
    *,
    tolerance: float = 1e-3,
    progress: Callable[[str], None] | None = None,
) -> Record:
    """Run the chain that a scene needs.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, its file, or the name of one that ships.
    tolerance : float
        Bound of the error of the last quantity: slider velocity over max(|v|, omega |u_x| / 10); without a
        slider surface amplitude, relative; for the free wave its velocity, relative.
    progress : callable, optional
        Told in a few words what is being done.

    Returns
    -------
    Record
        Its ``shortfall`` says why it is no answer within the tolerance, if it is none.

    Raises
    ------
    SceneError
        If the scene cannot be read, or is refused by the physics.
    RunError
        If there is nothing to record.

    Examples
    --------
    >>> run("rayleigh").wave["phase_velocity_m_per_s"]  # doctest: +ELLIPSIS
    2181...
    """
    if isinstance(tolerance, str) or not 0 < tolerance < 1:
        raise SceneError("tolerance", f"must be a number above 0 and below 1, got {tolerance!r}")
    begun = time.perf_counter()
    with fem.blas_on_one_thread():
        record = _run(scene if isinstance(scene, Scene) else Scene.load(scene), tolerance, progress)
    total = time.perf_counter() - begun
    parts = record.seconds | {"other": total - sum(record.seconds.values())}
    return replace(record, seconds={"total": total, **parts})


def _run(scene: Scene, tolerance: float, progress: Callable[[str], None] | None) -> Record:
    say = progress or (lambda text: None)
    scene = resolved.resolved(scene)
    if scene.wave is not None:
        record = _given(scene, tolerance, say)
    elif scene.transducer:
        record = _driven(scene, tolerance, say)
    else:
        record = _free(scene, tolerance)
    if scene.uncertain is not None:
        from studies.inverse.uncertainty import with_bands

        record = with_bands(record, progress=say)
    return replace(
        record,
        left_out=record.left_out + slider_left_out(scene),
        model_error=model_error(record),
        warnings=warnings_of(record),
    )


def _given(scene: Scene, tolerance: float, say) -> Record:
    begun = time.perf_counter()
    orbits, amplitudes = bridge.given_orbits(scene.wave), (1.0, scene.wave.tangential_ratio)
    answer = slider_answer(scene, orbits, amplitudes, stator_error=0.0, tolerance=tolerance, progress=say)
    return Record(
        scene=scene,
        tolerance=tolerance,
        wave={"frequency_Hz": scene.wave.frequency, "surface_ratio": scene.wave.tangential_ratio},
        **_slider_blocks(answer, tolerance),
        seconds={"contact": time.perf_counter() - begun},
        left_out=("stator, transducers and electric field: the surface motion is given",),
    )


def _free(scene: Scene, tolerance: float) -> Record:
    begun = time.perf_counter()
    try:
        wave = fem.free_wave(resolved.stator(scene.stator), frequency=scene.frequency, tolerance=tolerance)
    except fem.ConvergenceError as error:
        raise RunError(str(error)) from None
    names = ("u_x", "u_y", "u_z", "phi_V")
    columns = {"z_m": wave.depth}
    columns |= {f"{name}_per_m_of_u_z": wave.profile[:, k] for k, name in enumerate(names)}
    return Record(
        scene=scene,
        tolerance=tolerance,
        wave={
            "frequency_Hz": wave.frequency,
            "phase_velocity_m_per_s": wave.velocity,
            "surface_ratio": wave.surface_ratio,
            "attenuation_per_m": wave.attenuation,
        },
        error={"relative": wave.relative_error, "parts": {"stator": wave.relative_error}},
        seconds={"stator": time.perf_counter() - begun},
        left_out=free_left_out(resolved.stator(scene.stator)),
        surface=columns,
    )


def _driven(scene: Scene, tolerance: float, say) -> Record:
    begun = time.perf_counter()
    slider = scene.slider
    place = (scene.stator.length / 2, 0.0) if slider is None else slider.center
    places = (place,) if slider is None else tuple(dict.fromkeys((place, *slider.places)))

    # a motion that misses its goal is recorded with its error, which says whether it is good enough
    given = {"progress": say, "slider": slider is not None, "missed": True}
    motion = solved_motion(scene, places, tolerance=tolerance * (1 if slider is None else SHARE), **given)
    contact_seconds, ringing = 0.0, None

    def answered() -> SliderAnswer:
        nonlocal contact_seconds
        started = time.perf_counter()
        answer = _slider(scene, motion, tolerance, say, ringing)
        contact_seconds += time.perf_counter() - started
        return answer

    if slider is None:
        blocks = _amplitude_blocks(scene, motion, place, tolerance)
    else:
        ringing = _ring_up(scene, motion, place, say)
        answer = answered()
        for _ in range(ROUNDS - 1):
            before = motion.wave.relative_error
            whole = motion.relative_error(places)
            goal = _needed(answer, before, tolerance, 0.0 if ringing is None else ringing.error)
            if (
                goal is None
                or _beyond_the_section(answer, tolerance, 1 - before / whole) > HOPELESS * tolerance
            ):
                break
            try:
                motion = solved_motion(scene, places, tolerance=goal, **given)
            except RunError:
                break  # the answer that stands is recorded, with its error
            answer = answered()
            if motion.wave.relative_error >= before or motion.relative_error(places) > STALLED * whole:
                break
        blocks = _slider_blocks(answer, tolerance)
    wave = motion.wave
    if motion.beam is not None:
        scene = replace(scene, stator=replace(scene.stator, diffraction=True))
    circuit, balance, sources = motion.circuit, motion.power, powers(scene, motion)
    blocks["points"] = with_available_power(blocks["points"], sources)
    record = Record(
        scene=scene,
        tolerance=tolerance,
        wave=_wave_block(scene, motion, place)
        | ({} if ringing is None or ringing.found is None else {"settling_time_s": ringing.found.settling}),
        electrical={
            "admittance_S": circuit.admittance,
            "comb_voltage_per_volt": circuit.voltage,
            "power_W_per_V2": circuit.power,
            "power_dissipated_W_per_V2": balance.dissipated,
            "power_radiated_W_per_V2": balance.radiated,
            "power_residual": balance.residual,
            "admittance_relative_error": wave.admittance_error,
        }
        | sources
        | recovered(scene, circuit)
        | _several_sources(circuit),
        left_out=driven_left_out(resolved.stator(scene.stator), scene.frequency)
        + diffraction_left_out(scene, motion.beam is not None, motion.reason)
        + recovery_left_out(scene)
        + ring_up_left_out(scene, ringing, blocks.get("trajectories", ())),
        surface=_surface_columns(scene, motion),
        surface_motion=motion,
        **blocks,
    )
    seconds = {"stator": time.perf_counter() - begun - contact_seconds}
    return replace(record, seconds=seconds if slider is None else seconds | {"contact": contact_seconds})


def _several_sources(circuit) -> dict:
    """Return voltage and current of each driven transducer, per volt, where there are several."""
    if len(circuit.sources) < 2:
        return {}
    ports = {
        circuit.names[at]: {
            "voltage_per_volt": complex(circuit.voltages[at]),
            "current_A_per_V": complex(circuit.currents[at]),
        }
        for at in sorted(circuit.sources)
    }
    return {"sources": ports}


def _ring_up(scene: Scene, motion: SurfaceMotion, place: tuple[float, float], say):
    """Return the ring-up of a burst under the slider, or None where there is none to follow."""
    return None if scene.burst is None or motion.covered(place) else ring_up(scene, place, progress=say)


def _slider(scene: Scene, motion: SurfaceMotion, tolerance: float, say, ringing) -> SliderAnswer:
    slider = scene.slider
    tangential, _, normal = abs(motion.at([slider.center])[:, 0])
    return slider_answer(
        scene,
        bridge.orbits_per_volt(motion, slider),
        (float(normal), float(tangential)),
        stator_error=motion.relative_error(slider.places),
        tolerance=tolerance,
        progress=say,
        ringing=ringing,
        along=None if scene.burst is None else bridge.wave_along(motion, slider),
    )


def _needed(answer: SliderAnswer, reached: float, tolerance: float, ringing: float) -> float | None:
    """Return the stator's tolerance that would do, or None where it is good enough or cannot help.

    ``ringing`` is what the ring-up adds to the stator's part: no finer stator makes it smaller.
    """
    part = max((stator for stator, contact in answer.parts if stator + contact > tolerance), default=0.0)
    room = 0.5 * tolerance - ringing
    if part <= ringing or room <= 0:
        return None
    goal = reached * room / (part - ringing)
    return goal if goal < reached else None


def _beyond_the_section(answer: SliderAnswer, tolerance: float, share: float) -> float:
    """Return what the beam's share of the stator's error makes of the velocity's, at the best point above tolerance."""
    return share * min(
        (stator for stator, contact in answer.parts if stator + contact > tolerance), default=0.0
    )


def _slider_blocks(answer: SliderAnswer, tolerance: float) -> dict:
    """Return the record's blocks of a slider, the error that of the worst point."""
    failed = [point for point in answer.points if not point["status"].startswith(("ok", "above tolerance"))]
    known = [index for index, point in enumerate(answer.points) if "relative_error" in point]
    blocks = {"points": answer.points, "summary": answer.summary, "trajectories": answer.trajectories}
    if known:
        worst = max(known, key=lambda index: sum(answer.parts[index]))
        stator, contact = answer.parts[worst]
        blocks["error"] = {"relative": stator + contact, "parts": {"stator": stator, "contact": contact}}
        if stator + contact > tolerance:
            reached = (
                f"the velocity's error is {stator + contact:.1e} (stator {stator:.1e}, contact {contact:.1e})"
            )
            blocks["shortfall"] = (
                f"{reached}, {tolerance:.1e} was asked for: see error.parts, or ask for less"
            )
    if failed:
        blocks["shortfall"] = (
            f"{len(failed)} of {len(answer.points)} points have no answer: {failed[0]['status']}"
        )
    return blocks


def _amplitude_blocks(scene: Scene, motion: SurfaceMotion, place, tolerance: float) -> dict:
    """Return the record's blocks where the wave field is the result."""
    tangential, _, normal = (float(size) for size in abs(motion.at([place])[:, 0]))
    error = motion.relative_error([place])
    points = tuple(
        {
            "voltage_V": voltage,
            "normal_amplitude_m": normal * voltage,
            "tangential_amplitude_m": tangential * voltage,
            "relative_error": error if voltage else 0.0,
            "status": "ok",
        }
        for voltage in scene.levels
    )
    short = f"the surface amplitude's error is {error:.1e}, {tolerance:.1e} was asked for: ask for less"
    return {
        "points": points,
        "error": {"relative": error, "parts": {"stator": error}},
        "shortfall": short if error > tolerance else "",
    }


def _wave_block(scene: Scene, motion: SurfaceMotion, place: tuple[float, float]) -> dict:
    wave, places = motion.wave, [place] if scene.slider is None else [place, *scene.slider.places]
    found = motion.at(places)
    tangential, lateral, normal = found[:, 0]
    block = {
        "frequency_Hz": wave.frequency,
        "normal_m_per_V": complex(normal),
        "tangential_m_per_V": complex(tangential),
    }
    if motion.beam is not None:
        block["lateral_m_per_V"] = complex(lateral)
        block["largest_lateral_ratio"] = float((abs(found[1]) / abs(found[0])).max())
        in_section = map(complex, wave.motion(motion.in_section(place)))
        block |= zip(("section_tangential_m_per_V", "section_normal_m_per_V"), in_section, strict=True)
    if not motion.covered(place):
        block["rayleigh_normal_m_per_V"] = motion.surface_mode_at(place)
    return block | {
        "standing_wave_ratio": motion.standing_wave_ratio(place),
        "phase_velocity_m_per_s": wave.phase_velocity,
        "surface_ratio": wave.surface_ratio,
        "relative_error": motion.relative_error(places),
        "resolution": wave.resolution,
    }


def _surface_columns(scene: Scene, motion: SurfaceMotion) -> dict:
    if scene.driven_obliquely:  # no section lies along x
        reach = motion.wave.phase_velocity / scene.frequency / PER_WAVELENGTH
        x = np.linspace(0.0, scene.stator.length, int(scene.stator.length / reach) + 1)
        tangential, _, normal = motion.along(x, 0.0)
    else:
        x, (tangential, normal) = motion.wave.samples()
    return {"x_m": x, "u_x_m_per_V": tangential, "u_z_m_per_V": normal}


def slider_left_out(scene: Scene) -> tuple[str, ...]:
    """Return what the contact does without in this scene."""
    if scene.slider is None:
        return ("slider and contact: the scene has none",)
    slider, reasons = scene.slider, []
    if isinstance(slider.contacts, int) and slider.contacts > 1:
        reasons.append(f"{slider.contacts - 1} of {slider.contacts} contacts: in phase they move as one")
    if scene.burst is None:
        reasons.append("motion from rest: no burst, the periodic state is found without waiting for it")
    if slider.law == "elastic":
        reasons.append("contact memory: the law is elastic, Q depends on z and x alone")
    if not slider.reciprocal:
        reasons.append("the tangential spring's reaction on the normal motion: reciprocal is false")
    for key, force in (("contact", "R_n1"), ("normal", "R_n2"), ("tangential", "R_t")):
        if getattr(slider.damping, key) == 0:
            reasons.append(f"{force}: slider.damping.{key} is zero")
    if scene.stator is not None:
        from studies.scene.modulus import direction_dependence

        sizes = direction_dependence(resolved.solid(scene.stator))
        if sizes:
            reasons.append(f"the contact's dependence on direction: {sizes}")
    if scene.burst is not None and scene.stator is not None and slider.travel is False:
        reasons.append("the slider's travel along the wave field: slider.travel is false")
    reasons.append("the slider's reaction on the wave")
    return tuple(reasons)
