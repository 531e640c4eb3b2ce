"""The parts of a run, before it: what each computes, how large that is and what it costs.

Unknowns, lines and pieces are counted from the geometry, as the run will have them.  At which discretisation the
stator ends, and how long a burst rings, only the run can tell: what ordinary layouts need is taken.
"""

from dataclasses import dataclass, replace

from studies.chain import SHARE
from studies.chain.neglected import driven_left_out, free_left_out
from studies.chain.ring_up import RingUp, ring_up_left_out
from studies.report import cost
from studies.report.equations import contact_equations, field_equations
from studies.scene import Scene, resolved

__all__ = ["Level", "Part", "contact_part", "driven_parts", "free_parts"]

EXACT_CYCLES = 3000  # of a burst, followed event by event up to here
STEADY = "periodic motion of the full equations, by Newton's method on the map of one cycle"
AVERAGED = "cycle means at constant height and velocity"
WAYS = {"exact": "event by event", "stepped": "in fixed steps", "averaged": "many cycles at once"}


@dataclass(frozen=True, kw_only=True)
class Level:
    """One discretisation of the stator.

    Attributes
    ----------
    order, edge_layers, elements : int
        Polynomial order, layers towards each finger edge, elements through the depth.
    line, columns, unknowns : int
        Unknowns of a vertical line and guided modes to either side; columns of elements under all fingers; unknowns of
        the problem that is condensed.
    condensed, joins : int
        Columns that differ, and pairs of neighbours that differ: what is computed.
    seconds, megabytes : float
    """

    order: int
    edge_layers: int
    elements: int
    line: int
    columns: int
    unknowns: int
    condensed: int
    joins: int
    seconds: float
    megabytes: float


@dataclass(frozen=True, kw_only=True)
class Part:
    """One part of the chain: its equations, and how they are solved."""

    name: str
    equations: tuple[str, ...]
    facts: tuple[str, ...]
    seconds: float
    levels: tuple[Level, ...] = ()
    band_bytes: float = 0.0  # of the blocks of one of a band's frequencies


def driven_parts(scene: Scene, tolerance: float, speed: float) -> tuple[list[Part], list[str]]:
    """Return the parts of a driven stator on a machine of a speed, and what they leave out."""
    from fem import stator_size
    from fem.discretize import refinement

    about = _with_frequency(scene)
    block, row = resolved.stator(about.stator), resolved.transducers(about)
    goal = tolerance if scene.slider is None else tolerance * SHARE
    planned = refinement.planned_levels(block, goal)
    sizes = {
        level: stator_size(block, row, frequency=about.frequency, resolution=refinement.LEVELS[level])
        for level in {*planned, 1}
    }
    levels = [
        _level(sizes[k], cost.solution_seconds(sizes[k], speed, audited=k == planned[-1])) for k in planned
    ]
    section = sizes[planned[-1]].section
    fingers = sum(len(each.signs) for each in row)
    facts = [
        _where(scene),
        f"transducers: {len(row)}, different ones: {sizes[1].scatterers}, fingers in all: {fingers}",
        "two discretisations, the second for the error; one more wherever their difference exceeds the tolerance",
        f"{'complex' if sizes[1].complex else 'real'} arithmetic in the pieces, guided modes between them, "
        f"{_ends(scene)}",
    ]
    parts = [
        Part(
            name="stator",
            equations=field_equations(section.solid.fields),
            facts=tuple(facts),
            seconds=sum(level.seconds for level in levels),
            levels=tuple(levels),
        )
    ]
    one = cost.solution_seconds(sizes[1], speed)
    band = Part(
        name="",
        equations=(),
        facts=(),
        seconds=cost.band_seconds(one, scene.stator.ends),
        band_bytes=sizes[1].block_bytes,
    )
    if scene.frequency == "center":
        how = ("many frequencies of a band, then Brent's search for the largest amplitude",)
        parts.insert(0, replace(band, name="centre frequency", facts=how))
    left_out = [*driven_left_out(block, about.frequency)]
    if scene.slider is not None and scene.burst is not None:
        left_out += _ring_up(scene, parts, band)
    return parts, left_out


def _ring_up(scene: Scene, parts: list[Part], band: Part) -> list[str]:
    """Add the ring-up of a burst to the parts; return what it leaves out."""
    if _covered(scene):
        return [*ring_up_left_out(scene, None, ())]
    how = (
        "response over a band of frequencies, as many as the ringing asks for; its time is the least certain",
    )
    parts.append(replace(band, name="ring-up", facts=how))
    return [*ring_up_left_out(scene, RingUp(envelope=None, ring_down=None, found=None, error=0.0), ())]


def free_parts(scene: Scene, tolerance: float, speed: float) -> tuple[list[Part], list[str]]:
    """Return the part of a free wave, and what it leaves out."""
    import numpy as np

    from fem import Resolution, discretise, slowest_wavelength
    from fem.solve import free

    block = resolved.stator(scene.stator)
    unit = slowest_wavelength(block.solid, scene.frequency)
    orders = [order for order in free.ORDERS if order <= (6 if tolerance > 1e-5 else 8)]
    sections = [
        discretise(
            block,
            Resolution(order=order, edge_layers=0, lossy_elements=order + 2),
            wavelength=unit,
            surface_scale=np.inf,
        )
        for order in orders
    ]
    seconds = [cost.free_seconds([section.size], speed) for section in sections]
    levels = [
        Level(
            order=section.order,
            edge_layers=0,
            elements=len(section.heights),
            line=section.size,
            columns=0,
            unknowns=section.size,
            condensed=0,
            joins=0,
            seconds=each,
            megabytes=section.size**2 * 16 * 8 / 1e6,
        )
        for section, each in zip(sections, seconds, strict=True)
    ]
    names = sections[-1].solid.fields
    part = Part(
        name="free wave",
        equations=field_equations(names),
        facts=(_where(scene), "guided modes of the bare section: an eigenproblem through the depth alone"),
        seconds=sum(seconds),
        levels=tuple(levels),
    )
    return [part], [*free_left_out(block)]


def contact_part(scene: Scene) -> Part:
    """Return the part of a slider."""
    from contact import kernels

    slider = scene.slider
    contacts = 1 if isinstance(slider.contacts, int) else len(slider.contacts)
    points = len(scene.levels)
    unit = "amplitudes" if scene.wave is not None else "voltages"
    facts = [
        f"{slider.law} law, {contacts} contact{'s' if contacts > 1 else ''}, {points} {unit}",
        f"steady state: {AVERAGED if slider.method == 'averaged' else STEADY}",
    ]
    ready = kernels.ready()
    if not ready:
        facts.append(f"its kernels are compiled first, {kernels.how_often()}: about {cost.COMPILE:g} s")
    seconds = cost.contact_seconds(points, slider.law, contacts, ready=ready)
    if scene.burst is not None:
        frequency = _with_frequency(scene).frequency
        cycles, way = scene.burst * frequency, _way(scene, scene.burst * frequency)
        seconds += cost.burst_seconds(points, way, slider.law, cycles)
        facts.append(f"burst: {cycles:.4g} cycles of the wave, {WAYS[way]}, at each of them")
    return Part(name="contact", equations=contact_equations(slider), facts=tuple(facts), seconds=seconds)


def _way(scene: Scene, cycles: float) -> str:
    """Return the way through a burst that is tried first and usually serves."""
    slider = scene.slider
    if slider.method in WAYS:
        return slider.method
    rings = scene.transducer and not _covered(scene)
    if slider.law != "elastic" or slider.reciprocal or slider.stick_band > 0:
        return "exact"
    return "stepped" if rings else "exact" if cycles <= EXACT_CYCLES else "averaged"


def _with_frequency(scene: Scene) -> Scene:
    """Return the scene with a number for "center": the half-space's wave over the driven period."""
    if scene.frequency != "center":
        return scene
    return replace(scene, drive=replace(scene.drive, frequency=resolved.nominal_frequency(scene)))


def _covered(scene: Scene) -> bool:
    """Return whether the slider's centre stands over a transducer."""
    halves = [each.finger_pairs * each.period / 2 for each in scene.transducer]
    pairs = zip(scene.transducer, halves, strict=True)
    return any(abs(scene.slider.center[0] - each.center) <= half for each, half in pairs)


def _level(size, seconds: float) -> Level:
    return Level(
        order=size.resolution.order,
        edge_layers=size.resolution.edge_layers,
        elements=len(size.section.heights),
        line=size.line,
        columns=size.columns,
        unknowns=size.unknowns,
        condensed=size.condensed,
        joins=size.joins,
        seconds=seconds,
        megabytes=size.block_bytes / 1e6,
    )


def _where(scene: Scene) -> str:
    block = scene.stator
    thickness = block.thickness if isinstance(block.thickness, str) else f"{block.thickness * 1e3:g} mm"
    name = block.material if isinstance(block.material, str) else block.material.name
    at = scene.frequency if isinstance(scene.frequency, str) else f"{scene.frequency / 1e6:g} MHz"
    sides = f"bottom {block.bottom}, ends {block.ends}, above {block.above}"
    return f"{name}, {block.orientation}, {block.length * 1e3:g} mm x {thickness}, {sides}, at {at}"


def _ends(scene: Scene) -> str:
    return (
        "open ends exact"
        if scene.stator.ends == "absorbing"
        else f"{scene.stator.ends} ends send every mode back"
    )
