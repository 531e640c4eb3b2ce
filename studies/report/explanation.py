"""What a run would compute, before it: equations, sizes, memory, time, what is left out; nothing is solved.

Unknowns, lines and pieces are counted from the geometry, as the run will have them.  At which discretisation the stator
ends only the run can tell: what ordinary layouts need is taken.  The stator's work is dense algebra whose operations
are counted and divided by one measured speed; the contact takes milliseconds for each point, and a burst that is
followed event by event about 5e-5 s for each cycle of the wave.
"""

import textwrap
from dataclasses import dataclass

from studies.chain import SHARE, slider_left_out
from studies.chain.neglected import diffraction_left_out, driven_left_out, free_left_out
from studies.chain.ring_up import RingUp, ring_up_left_out
from studies.chain.surface_motion import wanted_diffraction
from studies.refusal import RunError
from studies.report.answer import table
from studies.scene import Scene, resolved
from studies.scene.blocks import Slider

__all__ = ["MEMORY_WITHIN", "TIME_WITHIN", "Plan", "explanation", "plan"]

TIME_WITHIN, MEMORY_WITHIN = 3.0, 2.0  # factors within which the predictions have been seen to hold
SPEED = 2.5e10  # real operations per second of the stator's algebra: one core of an x86_64 machine of 2026
START, COMPILE = 0.5, 15.0  # s: imports and the contact's points; its kernels when they are not there yet
BEAM, CUT_BEAM = 0.6, 4.0  # s: the spreading beam under the slider; where the lateral direction matters
JOIN, MODES = 51, 100  # real operations over n^3 of joining two pieces, and of n guided modes
BAND = 10  # solutions that a band of frequencies is worth
PROCESS, KEPT = 90e6, 1.35  # bytes of Python with its libraries; memory over that of the blocks alone
WIDTH = 110  # columns of a line of what is left out
HEADS = {
    "order": "order", "edge_layers": "edge layers", "elements": "elements in depth", "line": "line, modes",
    "columns": "columns", "condensed": "condensed", "joins": "joins", "unknowns": "unknowns", "megabytes": "MB",
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Part:
    """One part of the chain: its equations, how they are solved, and the sizes of its discretisations."""

    name: str
    equations: tuple[str, ...] = ()
    facts: tuple[str, ...] = ()
    levels: tuple[dict, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What a run would compute, its size and its cost."""

    scene: Scene
    tolerance: float
    parts: tuple[Part, ...]
    left_out: tuple[str, ...]
    seconds: float
    bytes: float

    def to_dict(self) -> dict:
        """Return the plan as plain numbers, text, lists and tables."""
        return {
            "title": self.scene.title,
            "scene": self.scene.to_table(),
            "tolerance": self.tolerance,
            "parts": [{key: value for key, value in vars(part).items() if value} for part in self.parts],
            "left_out": list(self.left_out),
            "expected": {
                "seconds": self.seconds,
                "seconds_within": TIME_WITHIN,
                "bytes": self.bytes,
                "bytes_within": MEMORY_WITHIN,
            },
        }


def plan(scene: Scene, *, tolerance: float) -> Plan:
    """Return the plan of a scene's run.

    Parameters
    ----------
    scene : Scene
    tolerance : float
        As of the run.

    Raises
    ------
    SceneError
        If the scene is refused by the physics.
    RunError
        If a run would refuse its size.
    """
    scene = resolved.resolved(scene)
    parts, left_out, operations, kept = [], [], 0.0, 0.0
    if scene.wave is not None:
        left_out = ["stator, transducers and electric field: the surface motion is given"]
    elif scene.transducer:
        from fem import ConvergenceError

        try:
            parts, left_out, operations, kept = _driven(scene, tolerance)
        except ConvergenceError as error:
            raise RunError(str(error)) from None
    else:
        parts, left_out = _free(scene)
    seconds = START + operations / SPEED
    if any(part.name == "beam" for part in parts):
        from fem import isotropic_about_normal

        seconds += BEAM if isotropic_about_normal(resolved.solid(scene.stator)) else CUT_BEAM
    if scene.slider is not None:
        from contact import kernels

        seconds += 0.0 if kernels.ready() else COMPILE
        parts.append(_contact(scene))
    return Plan(
        scene=scene, tolerance=tolerance, parts=tuple(parts), left_out=(*left_out, *slider_left_out(scene)),
        seconds=seconds, bytes=PROCESS + KEPT * kept,
    )  # fmt: skip


def explanation(plan: Plan) -> str:
    """Return what ``sawmotor run --explain`` prints."""
    lines = [plan.scene.title or "no title", "what a run would compute; nothing has been computed", ""]
    for part in plan.parts:
        lines += [
            f"{part.name if index == 0 else '':<18}{text}"
            for index, text in enumerate((*part.equations, *part.facts))
        ]
        if part.levels:
            rows = [list(HEADS.values())]
            rows += [[f"{level[key]:.4g}" if key == "megabytes" else str(level[key]) for key in HEADS]
                     for level in part.levels]  # fmt: skip
            lines += [f"{'':<18}{line}" for line in table(rows)]
        lines.append("")
    left_out = [line for each in plan.left_out for line in textwrap.wrap(each, WIDTH)]
    return "\n".join(
        [
            *lines,
            f"{'left out':<18}" + f"\n{'':<18}".join(left_out),
            f"{'error':<18}at most {plan.tolerance:.1e} is asked for",
            f"{'expected time':<18}{plan.seconds:.2g} s within a factor of {TIME_WITHIN:g}, bursts apart: counted "
            f"operations at {SPEED:.1e} per second",
            f"{'expected memory':<18}{plan.bytes / 1e6:.0f} MB within a factor of {MEMORY_WITHIN:g}, pictures apart",
        ]
    )


def _driven(scene: Scene, tolerance: float) -> tuple[list[Part], list[str], float, float]:
    """Return the parts of a driven stator, what they leave out, their operations, and the bytes of their blocks."""
    from fem import LEVELS, planned_levels, stator_size

    stator, row = resolved.stator(scene.stator), resolved.transducers(scene)
    planned = [*planned_levels(stator, tolerance if scene.slider is None else tolerance * SHARE)]
    if scene.stator.ends != "absorbing" and planned[-1] + 1 < len(LEVELS):
        planned.append(planned[-1] + 1)  # resonances of the block multiply the error
    sizes = {
        k: stator_size(stator, row, frequency=scene.frequency, resolution=LEVELS[k]) for k in {*planned, 1}
    }
    finest = sizes[planned[-1]]
    ends = (
        "open ends exact"
        if scene.stator.ends == "absorbing"
        else f"{scene.stator.ends} ends send every mode back"
    )
    facts = (
        _where(scene),
        f"transducers: {len(row)}, different ones: {finest.scatterers}, fingers in all: "
        f"{sum(len(each.signs) for each in row)}",
        "two discretisations, the second for the error; one more wherever their difference exceeds the tolerance",
        f"{'complex' if finest.complex else 'real'} arithmetic in the pieces, guided modes between them, {ends}",
    )
    parts = [
        Part(
            name="stator", equations=_field_equations(finest.section.solid.fields), facts=facts,
            levels=tuple(_level(sizes[k]) for k in planned),
        )
    ]  # fmt: skip
    left_out, bands = [*driven_left_out(stator, scene.frequency)], 0
    diffraction = wanted_diffraction(scene.stator.diffraction, scene.slider is not None)
    refusal = resolved.default_refusal(stator) if diffraction is None else ""
    spreads = diffraction is not False and not refusal
    if spreads:
        how = "guided modes at every wavenumber across the aperture, under the slider"
        parts.append(Part(name="beam", facts=(how,)))
    left_out += diffraction_left_out(scene, spreads, refusal)
    if scene.slider is not None and scene.burst is not None:
        rings = not any(abs(scene.slider.center[0] - each.place[0]) <= each.finger_pairs * each.period / 2
                        for each in scene.transducer)  # fmt: skip
        if rings:
            bands += 1
            how = (
                "response over a band of frequencies, as many as the ringing asks for; the least certain time"
            )
            parts.append(Part(name="ring-up", facts=(how,)))
        ring_up = RingUp(envelope=None, ring_down=None, found=None, error=0.0) if rings else None
        left_out += ring_up_left_out(scene, ring_up, ())
    operations = sum(_operations(sizes[k]) for k in planned) + BAND * bands * _operations(sizes[1])
    kept = sum(sorted(sizes[k].block_bytes for k in planned)[-2:]) + (
        5 * sizes[1].block_bytes if bands else 0
    )
    return parts, left_out, operations, kept


def _level(size) -> dict:
    return {
        "order": size.resolution.order, "edge_layers": size.resolution.edge_layers,
        "elements": len(size.section.heights), "megabytes": size.block_bytes / 1e6,
    } | {key: getattr(size, key) for key in ("line", "columns", "unknowns", "condensed", "joins")}  # fmt: skip


def _operations(size) -> float:
    """Return the real operations of a driven stator on one discretisation: joins, columns, guided modes, ends."""
    modes = size.line if size.section.odd is not None else 2 * size.line
    pieces = JOIN * (size.joins + size.condensed) * (1.0 if size.complex else 0.25)
    return (pieces + 3 * JOIN * (2 + size.scatterers)) * size.line**3 + MODES * modes**3


def _free(scene: Scene) -> tuple[list[Part], list[str]]:
    from fem import fields

    stator = resolved.stator(scene.stator)
    facts = (_where(scene), "guided modes of the bare section: an eigenproblem through the depth alone")
    equations = _field_equations(fields(stator.solid))
    return [Part(name="free wave", equations=equations, facts=facts)], [*free_left_out(stator)]


def _contact(scene: Scene) -> Part:
    from contact import kernels

    slider = scene.slider
    contacts = 1 if isinstance(slider.contacts, int) else len(slider.contacts)
    unit = "amplitudes" if scene.wave is not None else "voltages"
    averaged = "cycle means at constant height and velocity"
    full = "periodic motion of the full equations, by Newton's method on the map of one cycle"
    facts = [
        f"{slider.law} law, {contacts} contact{'s' if contacts > 1 else ''}, {len(scene.levels)} {unit}",
        f"steady state: {averaged if slider.method == 'averaged' else full}",
    ]
    if not kernels.ready():
        facts.append(f"its kernels are compiled first, {kernels.how_often()}: about {COMPILE:g} s")
    if scene.burst is not None:
        facts.append(f"burst: {scene.burst * scene.frequency:.4g} cycles of the wave at each of them")
    return Part(name="contact", equations=_contact_equations(slider), facts=tuple(facts))


def _where(scene: Scene) -> str:
    block = scene.stator
    thickness = block.thickness if isinstance(block.thickness, str) else f"{block.thickness * 1e3:g} mm"
    name = block.material if isinstance(block.material, str) else block.material.name
    at = scene.frequency if isinstance(scene.frequency, str) else f"{scene.frequency / 1e6:g} MHz"
    sides = f"bottom {block.bottom}, ends {block.ends}, above {block.above}"
    return f"{name}, {block.orientation}, {block.length * 1e3:g} mm x {thickness}, {sides}, at {at}"


def _field_equations(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the stator's equations for these fields of `fem`."""
    fields = ", ".join({"ux": "u_x", "uy": "u_y", "uz": "u_z"}.get(name, name) for name in names)
    if "phi" not in names:
        return ("div T = -rho omega^2 u,  T = c S", f"fields: {fields}")
    return (
        "div T = -rho omega^2 u,  div D = 0,  T = c S - e^T E,  D = e S + eps E,  E = -grad phi",
        f"fields: {fields}",
    )


def _contact_equations(slider: Slider) -> tuple[str, ...]:
    """Return the equations of a slider's contact and motion, without the terms that are zero."""
    spring = (
        "Q = mu P sign(x) [1 - (1 - |x|/x_max)^1.5],  |x| <= x_max = mu E* z / (4 G*)"
        if slider.law == "elastic"
        else "Q(z, x) after Mindlin and Deresiewicz, with memory of the turning points"
    )
    damping = slider.damping
    normal = "m z_s'' = P" + (" + chi P z'" if damping.contact else "")
    normal += (" - R_n2 z_s'" if damping.normal else "") + " - preload"
    tangential = "m v_s' = Q" + (" - R_t v_s" if damping.tangential else "")
    tangential += " - load" if slider.load else ""
    return ("P = (4/3) E* sqrt(R) z^1.5", spring, f"{normal},  {tangential}")
