"""The plan of a run without solving it: sizes, memory, time and neglected effects.

Unknowns, lines and pieces follow from the geometry and are those of the run. The final discretisation of the stator is
known only after the run; the plan assumes the one that ordinary layouts need. The time of the stator is the number of
operations of its dense linear algebra divided by a measured speed. The time of a contact point grows with the number of
contacts at different positions. An event-driven burst takes about 5e-5 s per cycle of the wave.
"""

import textwrap
from dataclasses import replace
from typing import Any

import numpy as np

import contact
import fem
from studies.model.fem_objects import section_reason
from studies.model.model import Model
from studies.model.resolve import build
from studies.model.scene_errors import as_run_errors
from studies.model.wave_to_contact import contact_slider
from studies.record.text import labelled, table
from studies.remarks.neglected_effects import left_out
from studies.report.contents import section
from studies.scene import Scene
from studies.solve.contact_at_level import SHARE
from studies.solve.ring_up import RingUp
from studies.solve.spectrum import groups

TIME_WITHIN, MEMORY_WITHIN = 3.0, 2.0  # observed factors between prediction and measurement
SPEED = 2.5e10  # real operations per second of the stator's linear algebra on one x86_64 core of 2026
# s: interpreter and imports of a run, and those that a mesh needs; compilation of the contact kernels if not cached
START, MESH_START, COMPILE = 0.22, 0.25, 15.0
SEARCH = 2.3  # s: search for drive.frequency = "center", measured for 10 finger pairs on twente-left
# Time of a point with one contact in s, and exponent of the number of contacts. Measured: 1, 4, 16 and 64 balls take
# 0.05, 0.04, 0.4 and 6 s.
POINT, CONTACTS = 0.02, 1.2
# s per pillar and level, model error included, and bytes per pillar. Measured: 10^4 pillars at 6 levels take 4.6 s and
# 126 MB.
PILLAR, PILLAR_BYTES = 8e-5, 1.2e4
# s per level of a slider in the plane, with the places about it, and without: on waves of one frequency, and of more.
# Measured, CPU time: rotor 0.7 and 0.1 s, twente-planar 3.3 and 0.9 s
PLANE, PLANE_ALONE = (0.7, 3.3), (0.1, 0.9)
AVERAGED_POINT = 3e-4  # s per point of a sweep with averaged contacts, which run in a compiled loop
JOIN, MODES = 51, 100  # real operations over n^3 for joining two pieces and for computing n guided modes
# Real operations for a complex one in a meshed piece, whose matrices are smaller than those of the section.  Measured:
# 0.09 to 3.4 s for pieces of 6500 to 98700 unknowns.
MESH = 7
# operations of the beam model: in a plate isotropic about its normal, over an absorbing bottom or in a half-space,
# whose modes need three times as many lateral wavenumbers, and in other cuts
BEAM, ABSORBED_BEAM, CUT_BEAM = 1.5e10, 7.5e10, 3.5e10
BEAM_BYTES = 30e6  # of the beam model, for each transducer
BAND = 10  # number of solutions that equals the work for a band of frequencies
PROCESS, MEMORY_FACTOR = 90e6, 1.35  # bytes of Python with its libraries; total memory over that of the stored blocks
MINUTE = 60.0  # s
WIDTH = 110  # characters per line of the list of neglected effects
HEADS = {
    "order": "order", "edge_layers": "edge layers", "elements": "elements in depth", "line": "line, modes",
    "columns": "columns", "condensed": "condensed", "joins": "joins", "unknowns": "unknowns", "megabytes": "MB",
}  # fmt: skip


def plan(scene: Scene, *, tolerance: float) -> dict:
    """Return the plan of a run as JSON-compatible data.

    Returns
    -------
    dict
        ``title``, ``scene`` and ``tolerance``; ``parts``: the solution method of each part of the motor and the sizes
        of its discretisations; ``left_out``; ``expected``: time in s and memory in bytes with their uncertainty
        factors.

    Raises
    ------
    SceneError
        If the physics does not permit the scene.
    RunError
        If a run would refuse the scene because of its size.
    """
    searched = bool(scene.transducer) and scene.drive.frequency == "center"
    model = build(scene).before_heat
    scene = model.scene
    parts: list[dict] = []
    left_out_options: dict[str, Any] = {}
    operations, block_bytes, seconds = 0.0, 0.0, START + MESH_START * bool(scene.piece) + SEARCH * searched
    if scene.transducer:
        with as_run_errors():
            parts, left_out_options, operations, block_bytes = _driven(model, tolerance)
    elif scene.wave is None:
        facts = [_stator_text(scene), "guided modes of the bare section: an eigenproblem through the depth alone"]
        parts = [{"name": "free wave", "facts": facts}]
    if scene.slider is not None:
        slider, levels = scene.slider, "voltages" if scene.wave is None else "amplitudes"
        body = contact_slider(slider.along_x)
        placed = np.size(body.x) if np.ndim(body.x) else 0  # contacts with places of their own
        number = placed or len(slider.offsets)
        seconds += PILLAR * placed * len(scene.levels)
        block_bytes += PILLAR_BYTES * placed / MEMORY_FACTOR
        contacts = len(set(slider.offsets))  # contacts at the same position move identically
        facts = [f"{slider.tangential_law} law, {_counted(number, 'contact')}, {len(scene.levels)} {levels}"]
        seconds += POINT * len(scene.levels) * contacts**CONTACTS
        seconds += PLANE[_beats(scene)] * len(scene.levels) * scene.planar
        if scene.burst is not None:
            facts.append(f"a burst of {scene.burst * scene.frequency:.4g} cycles of the wave at each")
        if not contact.kernels.ready():
            facts.append(f"its kernels are compiled first, {contact.kernels.how_often()}: about {COMPILE:g} s")
            seconds += COMPILE
        parts.append({"name": "contact", "facts": facts})
    stator_seconds = operations / SPEED
    expected = {
        "seconds": seconds + stator_seconds, "stator_seconds": stator_seconds, "seconds_within": TIME_WITHIN,
        "bytes": PROCESS + MEMORY_FACTOR * block_bytes, "bytes_within": MEMORY_WITHIN,
    }  # fmt: skip
    return {
        "title": scene.title, "scene": scene.to_table(), "tolerance": tolerance, "parts": parts,
        "left_out": left_out(model, **left_out_options), "expected": expected,
    }  # fmt: skip


def expected_seconds(scene: Scene, *, tolerance: float) -> float:
    """Return the expected time of a run in s."""
    return plan(scene, tolerance=tolerance)["expected"]["seconds"]


def long_wait(expected: float) -> tuple[str, ...]:
    """Return the sentence of `announced` for a command with --explain."""
    return announced(expected, " (--explain lists the parts)")


def long_sweep(scene: Scene, *, tolerance: float, stators: int, points: int) -> tuple[str, ...]:
    """Return the sentence of `long_wait` for a sweep; the arguments are those of `sweep_seconds`."""
    seconds = sweep_seconds(scene, tolerance=tolerance, stators=stators, points=points)
    return long_wait(seconds)


def sweep_seconds(scene: Scene, *, tolerance: float, stators: int, points: int) -> float:
    """Return the expected time in s of the points of a sweep, where ``scene`` is the scene of one of them."""
    expected = plan(scene, tolerance=tolerance)["expected"]
    contacts = POINT * points if scene.burst is not None else AVERAGED_POINT * points
    contacts += PLANE_ALONE[_beats(scene)] * points * scene.planar
    return stators * expected["stator_seconds"] + contacts


def _beats(scene: Scene) -> bool:
    """Return whether waves of several frequencies drive the slider."""
    if scene.wave is None:
        return scene.drive is not None and len(scene.drive.frequencies) > 1
    return len({each.frequency or scene.wave.frequency for each in scene.wave.sources or ()}) > 1


def band_seconds(model: Model, frequencies: np.ndarray, *, tolerance: float) -> float:
    """Return the expected time in s of the admittances of a resolved scene at rising frequencies in Hz."""
    scene = model.scene
    plane = replace(scene, slider=None, stator=replace(scene.stator, diffraction=False))
    one = plan(plane, tolerance=tolerance)["expected"]["stator_seconds"]
    ports = sum(each.has_two_electrodes for each in scene.transducer) if model.diffracts else 1
    return one * ports**2 * sum(BAND if len(group) > 1 else 1 for group in groups(model, frequencies))


def announced(expected: float, more: str = "") -> tuple[str, ...]:
    """Return a sentence on an expected time in s if it exceeds a minute; otherwise an empty tuple.

    Examples
    --------
    >>> announced(59.0), announced(61.0)
    ((), ('expected time: about 1 minute, within a factor of 3',))
    >>> announced(6000.0)
    ('expected time: about 100 minutes, within a factor of 3',)
    """
    if expected < MINUTE:
        return ()
    minutes = round(expected / MINUTE)
    hours = f"{expected / 3600:.2g} hours" if expected > 2 * 3600 else f"{minutes} minute{'s' * (minutes > 1)}"
    return (f"expected time: about {hours}, within a factor of {TIME_WITHIN:g}{more}",)


def explanation(plan: dict) -> str:
    """Return the text that ``sawmotor run --explain`` prints."""
    entries, expected = [], plan["expected"]
    for part in plan["parts"]:
        sizes = [[f"{each[key]:.4g}" if key == "megabytes" else str(each[key]) for key in HEADS]
                 for each in part.get("levels", ())]  # fmt: skip
        lines = [*part["facts"], *(table([list(HEADS.values()), *sizes]) if sizes else ())]
        entries += [(part["name"], lines), ("", [""])]
    entries += [
        ("left out", [line for each in plan["left_out"] for line in textwrap.wrap(each, WIDTH)]),
        ("error", [f"at most {plan['tolerance']:.1e}, as required by the tolerance"]),
        ("expected time", [f"{expected['seconds']:.2g} s without bursts, within a factor of {TIME_WITHIN:g} (number of "
                           f"operations over {SPEED:.1e} per second)"]),
        ("expected memory", [f"{expected['bytes'] / 1e6:.0f} MB without pictures, within a factor of "
                             f"{MEMORY_WITHIN:g}"]),
    ]  # fmt: skip
    title = plan["title"] or "no title"
    return "\n".join([title, "what a run would compute; nothing has been computed", "", *labelled(entries)])


def _driven(model: Model, tolerance: float) -> tuple[list[dict], dict, float, float]:
    """Return the parts of a driven stator, the keywords for `left_out`, the operations and the bytes of the blocks."""
    scene, slider, (along, _) = model.scene, model.scene.slider, model.first_section((0.0, 0.0))
    stator, transducers = along.stator, along.transducers
    strips = fem.strips_of(transducers) if scene.in_strips else ()
    sections = len(strips) or (len(model.groups) if scene.crossed else 1)
    if strips:  # the middle one has all transducers
        transducers = strips[len(strips) // 2].transducers
    resolutions = [*fem.planned_levels(stator, tolerance if slider is None else tolerance * SHARE)]
    if scene.stator.ends != "absorbing" and resolutions[-1] + 1 < len(fem.LEVELS):
        resolutions.append(resolutions[-1] + 1)  # resonances between reflecting ends amplify the error
    sizes = {
        k: fem.stator_size(stator, transducers, frequency=scene.frequency, resolution=fem.LEVELS[k])
        for k in {*resolutions, 1}
    }
    finest, fingers = sizes[resolutions[-1]], sum(len(each.signs) for each in transducers)
    facts = [_stator_text(scene)]
    if finest.meshes:
        facts.append(
            f"{_counted(len(finest.meshes), 'meshed piece')}, {len(finest.distinct_meshes)} of them condensed: "
            f"{finest.meshes[0].unknowns} unknowns in the first on the finest discretisation"
        )
    facts.append(
        f"fingers: {fingers}, of {_counted(len(transducers), 'transducer')} of {_counted(finest.scatterers, 'kind')}"
    )
    if scene.crossed:
        grouping = "one for each group of parallel transducers; the sizes are those of the first"
        facts.append(f"{sections} sections, {grouping}")
    if strips:
        facts.append(f"{sections} strips along y, a section each; the sizes are those of the middle one")
    facts += [
        "two discretisations, whose difference is the error; a third if it exceeds the tolerance",
        f"fields {', '.join(finest.section.solid.fields)}; finite elements under the fingers, in "
        f"{'complex' if finest.complex else 'real'} arithmetic, and guided modes between them",
    ]
    parts = [{"name": "stator", "facts": facts, "levels": [_level_sizes(sizes[k]) for k in resolutions]}]
    operations = sections * sum(_operations(sizes[k]) for k in resolutions)
    block_bytes = sections * sum(sorted(sizes[k].block_bytes for k in resolutions)[-2:])
    positions = None if slider is None else slider.contact_positions
    reason = section_reason(scene.stator, stator, positions, scene.transducer)
    if not reason:
        how = "guided modes at every wavenumber across the aperture, evaluated under the slider"
        parts.append({"name": "beam", "facts": [how]})
        block_bytes += BEAM_BYTES * len(scene.transducer) / MEMORY_FACTOR
        isotropic_beam = ABSORBED_BEAM if stator.absorbs_below else BEAM
        operations += isotropic_beam if fem.isotropic_about_normal(stator.solid) else CUT_BEAM
    left_out_options = {"beam": not reason, "reason": reason}
    if slider is not None and scene.burst is not None:
        covered = any(abs(slider.center[0] - each.center_xy[0]) <= each.half_length for each in scene.transducer)
        if not covered:
            left_out_options["ringing"] = RingUp(error=0.0)
            how = "frequency response over a band; the number of frequencies, and so the time, is not known in advance"
            parts.append({"name": "ring-up", "facts": [how]})
            operations += BAND * _operations(sizes[1])
            block_bytes += 5 * sizes[1].block_bytes
    return parts, left_out_options, operations, block_bytes


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"


def _level_sizes(size) -> dict:
    return {
        "order": size.resolution.order, "edge_layers": size.resolution.edge_layers,
        "elements": len(size.section.heights), "megabytes": size.block_bytes / 1e6,
    } | {key: getattr(size, key) for key in ("line", "columns", "unknowns", "condensed", "joins")}  # fmt: skip


def _operations(size) -> float:
    """Return the number of real operations to solve a driven stator on one discretisation."""
    modes = size.line if size.section.odd is not None else 2 * size.line
    pieces = JOIN * (size.joins + size.condensed) * (1.0 if size.complex else 0.25)
    meshes = MESH * sum(each.operations for each in size.distinct_meshes)
    return (pieces + 3 * JOIN * (2 + size.scatterers + len(size.meshes))) * size.line**3 + MODES * modes**3 + meshes


def _stator_text(scene: Scene) -> str:
    block = scene.stator
    sides = f"bottom {block.bottom}, ends {block.ends}, above {block.above}"
    return f"{section(block)}, {sides}, at {scene.frequency / 1e6:g} MHz"
