"""Layout of the meshed pieces on a stator: their order, which of them are its ends, and the rules for their places."""

import itertools
from dataclasses import dataclass

import numpy as np

from fem.input_error import InputError
from fem.materials.solids import Solid
from fem.mesh.piece import FLOATING, GROUNDED, SAME, MeshPiece
from fem.mesh.section_mesh import ELECTRODE
from fem.mesh.shapes import CORNERS

MAX_UNKNOWNS = 2_000_000  # of one piece
# Unknowns of a quadrilateral at the coarsest level, at the least: order 4 (fem.condense.mesh), u_x, u_z and phi.
LEAST_PER_QUAD = 3 * 4**2
UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "inch": 0.0254}  # m


@dataclass(frozen=True, kw_only=True)
class Placement:
    """Meshed pieces by their part in the row."""

    between: tuple[MeshPiece, ...]  # from left to right, with an interface on both sides
    ends: tuple[MeshPiece | None, MeshPiece | None]  # the left and the right end, where they are meshes
    whole: MeshPiece | None  # the stator from end to end: it has no interface
    # start, stop: where the uniform stator begins and ends, m
    start: float
    stop: float


def is_step(piece: MeshPiece, thickness: float) -> bool:
    """True if a piece is a step from the stator's thickness to another one."""
    sides = ("left", "right")
    return (
        all(piece.interface(side) for side in sides)
        and sum(piece.fits(side, thickness) for side in sides) == 1
    )


def placement(pieces: tuple[MeshPiece, ...], *, length: float, thickness: float) -> Placement:
    """Sort pieces by their part in the row: between uniform segments, an end of the stator, or all of it."""
    whole = None
    between: list[MeshPiece] = []
    ends: list[MeshPiece | None] = [None, None]
    for piece in sorted(pieces, key=lambda each: each.extent[0]):
        left, right = piece.interface("left"), piece.interface("right")
        if left is None and right is None:
            whole = piece
            continue
        if is_step(piece, thickness):
            side = 1 if piece.fits("left", thickness) else 0
        elif left is None and right is not None:
            side = 0
        elif right is None and left is not None:
            side = 1
        else:
            between.append(piece)
            continue
        if ends[side] is not None:
            raise InputError(
                "piece", f'"{piece.name}" and "{ends[side].name}" are both the {("left", "right")[side]} end'
            )
        ends[side] = piece
    start = 0.0 if ends[0] is None else ends[0].interface("right")[0]
    stop = length if ends[1] is None else ends[1].interface("left")[0]
    return Placement(between=tuple(between), ends=(ends[0], ends[1]), whole=whole, start=start, stop=stop)


def check_pieces(
    pieces: tuple[MeshPiece, ...],
    *,
    length: float,
    thickness: float,
    bottom: str,
    ends: str,
    above: str,
    absorbs_below: bool,
    solid: Solid,
    transducers: dict[str, tuple[float, float, str]],
) -> None:
    """Check that the pieces fit the stator and each other; ``transducers``: edges (m) and signs by name.

    Raises
    ------
    InputError
        Names the piece, the rule, the values and the unit.
    """
    if not pieces:
        return
    if absorbs_below or above != "none":
        key, value = ("stator.above", above) if above != "none" else ("stator.bottom", "absorbing")
        raise InputError(
            key,
            f"must be {'none' if above != 'none' else 'free, grounded or clamped'} with a meshed piece, got {value!r}",
        )
    placed = placement(pieces, length=length, thickness=thickness)
    if placed.whole is not None:
        _check_whole(placed.whole, len(pieces), length, thickness, ends, transducers)
    for piece in pieces:
        _check_heights(piece, thickness)
        _check_size(piece)
        _check_materials(piece)
        _check_electrodes(piece, transducers, placed)
        _check_electrode_lines(piece, solid)
        if bottom in ("grounded", "clamped") and "bottom" not in piece.mesh.lines:
            raise InputError(
                "piece", f"has no line group bottom, and stator.bottom is {bottom}", owner=piece.name
            )
    for side, piece in enumerate(placed.ends):
        if piece is not None and is_step(piece, thickness) and ends != "absorbing":
            raise InputError(
                "stator.ends",
                f"must be absorbing behind the step of thickness of piece {piece.name!r}, got {ends!r}",
            )
        if piece is not None and not 0 < piece.interface("right" if side == 0 else "left")[0] < length:
            raise InputError(
                "piece",
                f"begins beside the stator, 0 to {length * 1e3:g} mm: {_where(piece)}",
                owner=piece.name,
            )
    _check_overlaps(placed, length, transducers)


def _where(piece: MeshPiece) -> str:
    low, high = piece.extent
    return f"{low * 1e3:.6g} to {high * 1e3:.6g} mm"


def _check_heights(piece: MeshPiece, thickness: float) -> None:
    lines = {side: piece.interface(side) for side in ("left", "right") if piece.interface(side) is not None}
    wrong = [side for side in lines if not piece.fits(side, thickness)]
    if len(wrong) < len(lines) or not wrong:
        return
    side = wrong[0]
    _, height, top = lines[side]
    if abs(height - thickness) <= SAME * thickness:
        raise InputError(
            "piece",
            f"must end at the surface z = 0: the upper end of the group {side} is at z = {top * 1e3:.6g} mm",
            owner=piece.name,
        )
    raise InputError(
        "piece",
        f"must be as thick as the stator at its interface: the group {side} is {height * 1e3:.6g} mm high, the stator "
        f"is {thickness * 1e3:.6g} mm thick{_unit_question(piece, height, thickness)}",
        owner=piece.name,
    )


def _unit_question(piece: MeshPiece, drawn: float, meant: float) -> str:
    """Return the advice to change the file's length unit, if another unit gives a drawn length its intended value."""
    unit = piece.mesh.unit * meant / drawn
    hint = next((name for name, each in UNITS.items() if abs(unit / each - 1) < 0.02), "")
    return f": is the file's length unit {hint}?" if hint else ""


def _check_whole(
    piece: MeshPiece, pieces: int, length: float, thickness: float, ends: str, transducers: dict
) -> None:
    """Raise an InputError for a piece without interface that is not the whole stator."""

    def refuse(rule: str, key: str = "piece") -> None:
        raise InputError(key, rule, owner=piece.name)

    low, high = piece.extent
    if max(abs(low), abs(high - length)) > SAME * length:
        refuse(
            "has no line group left or right, where a mesh meets the uniform stator; without them it must be the whole "
            f"stator, 0 to {length * 1e3:.6g} mm, it reaches from {_where(piece)}"
            f"{_unit_question(piece, high - low, length)}"
        )
    if pieces > 1:
        refuse(
            f"has no line group left or right and is the whole stator: it must be the only piece, got {pieces}"
        )
    bottom, top = (each * 1e3 for each in piece.mesh.depth)
    if max(abs(bottom + thickness * 1e3), abs(top)) > SAME * thickness * 1e3:
        refuse(
            f"is the whole stator: its surface group stator must reach from z = -{thickness * 1e3:.6g} mm (minus "
            f"stator.thickness) to 0, it reaches from {bottom:.6g} to {top:.6g} mm"
            f"{_unit_question(piece, (top - bottom) * 1e-3, thickness)}"
        )
    if ends != "free":
        refuse(
            f'must be free with piece "{piece.name}", which is the whole stator: its line group clamped says what is '
            f"held, and a mesh does not absorb; got {ends!r}",
            key="stator.ends",
        )
    connected = {connection for _, connection in piece.electrodes}
    for name, (_, _, signs) in transducers.items():
        for sign in "+-":
            if sign in signs and name + sign not in connected:
                refuse(
                    f"must connect a line group electrode:NAME to {name}{sign}: the piece is the whole stator, and the "
                    f'fingers of transducer "{name}" are those that the mesh draws',
                    key="piece.electrodes",
                )


def _check_size(piece: MeshPiece) -> None:
    """Raise an InputError for a mesh with too many unknowns even at the coarsest level."""
    quads = sum(CORNERS[cells.kind] * len(cells.nodes) for cells in piece.mesh.cells)
    least = quads * LEAST_PER_QUAD
    if least <= MAX_UNKNOWNS:
        return
    count = sum(len(cells.nodes) for cells in piece.mesh.cells)
    size = np.median(
        [np.median(np.ptp(piece.mesh.points[cells.nodes, 0], axis=1)) for cells in piece.mesh.cells]
    )
    raise InputError(
        "piece.file",
        f"has {count} elements, about {size * 1e3:.2g} mm wide, and at least {least:.2g} unknowns, at most "
        f"{MAX_UNKNOWNS:.0g} are solved for: draw elements of {size * 1e3 * np.sqrt(least / MAX_UNKNOWNS):.2g} mm or "
        "more; the program refines corners itself and raises the order",
        owner=piece.name,
    )


def _check_materials(piece: MeshPiece) -> None:
    known = ["stator", *(name for name, _ in piece.solids)]
    if "stator" in known[1:]:
        raise InputError(
            "piece.materials", 'must not name "stator", whose material is stator.material', owner=piece.name
        )
    for name in piece.mesh.solids:
        if name not in known:
            raise InputError(
                "piece.materials",
                f'must name every solid: the surface group "{name}" is no solid of the scene: '
                f"{', '.join(known)}",
                owner=piece.name,
            )
    for name in known[1:]:
        if name not in piece.mesh.solids:
            groups = (
                ", ".join(each for each in piece.mesh.solids if each != "stator") or "none besides stator"
            )
            raise InputError(
                "piece.materials",
                f'names "{name}", which is no surface group of the file: {groups}',
                owner=piece.name,
            )


def _check_electrodes(piece: MeshPiece, transducers: dict, placed: Placement) -> None:
    for name, connection in piece.electrodes:
        if name not in piece.mesh.electrodes:
            groups = ", ".join(piece.mesh.electrodes) or "none"
            raise InputError(
                "piece.electrodes",
                f'names "{name}", which is no line group electrode:NAME of the file: {groups}',
                owner=piece.name,
            )
        if connection in (FLOATING, GROUNDED):
            continue
        comb, sign = connection[:-1], connection[-1:]
        if sign not in ("+", "-") or comb not in transducers:
            known = ", ".join(f"{each}+, {each}-" for each in transducers)
            raise InputError(
                "piece.electrodes",
                f'must connect "{name}" to floating, grounded or a comb ({known}), got {connection!r}',
                owner=piece.name,
            )
        if sign not in transducers[comb][2]:
            raise InputError(
                "piece.electrodes",
                f'connects "{name}" to {connection}, and that transducer has no finger "{sign}"',
                owner=piece.name,
            )
        if piece in placed.ends:
            raise InputError(
                "piece.electrodes",
                f'must leave "{name}" floating or grounded: a piece at the stator\'s end is connected to no comb',
                owner=piece.name,
            )


def _check_electrode_lines(piece: MeshPiece, solid: Solid) -> None:
    """Raise an InputError for electrodes that touch each other or an interface, or touch no piezoelectric solid."""
    mesh, owner = piece.mesh, dict[int, str]()
    solids = {"stator": solid} | dict(piece.solids)
    coupled = {
        int(n) for each in mesh.cells if solids[each.solid].is_piezoelectric for n in np.unique(each.nodes)
    }

    def refuse(rule: str, at: set[int] | None = None) -> None:
        where = " at ({:.4g}, {:.4g}) mm".format(*mesh.points[min(at)] * 1e3) if at else ""
        raise InputError("piece.file", rule.format(where), owner=piece.name)

    for name in mesh.electrodes:
        nodes = set(mesh.lines[ELECTRODE + name].ravel().tolist())
        if len(nodes & coupled) < 2:  # a corner alone is no contact
            refuse(f'must draw the line group "electrode:{name}" on a piezoelectric solid')
        if shared := nodes & owner.keys():
            refuse(
                f'"electrode:{owner[min(shared)]}" and "electrode:{name}" touch{{}}: give them one name',
                shared,
            )
        for side in ("left", "right"):
            if shared := nodes.intersection(mesh.lines.get(side, np.empty(0)).ravel().tolist()):
                refuse(f'"electrode:{name}" reaches the interface {side}{{}}: it must end before it', shared)
        owner |= dict.fromkeys(nodes, name)


def _check_overlaps(placed: Placement, length: float, transducers: dict) -> None:
    if placed.whole is not None:
        return
    spans = [(each.extent, f'piece "{each.name}"') for each in placed.between]
    for side, piece in enumerate(placed.ends):
        if piece is not None:
            low, high = piece.extent
            spans.append(
                ((-float("inf"), high) if side == 0 else (low, float("inf")), f'piece "{piece.name}"')
            )
    spans += [((low, high), f'transducer "{name}"') for name, (low, high, _) in transducers.items()]
    room = SAME * length
    for piece in placed.between:
        low, high = piece.extent
        if low < -room or high > length + room:
            raise InputError(
                "piece",
                f"must lie on the stator, 0 to {length * 1e3:g} mm, it reaches from {_where(piece)}",
                owner=piece.name,
            )
    spans.sort(key=lambda each: each[0])
    for (one, first), (other, second) in itertools.pairwise(spans):
        if one[1] > other[0] + room * 1e-3:
            here, there = (first, one), (second, other)
            if not here[0].startswith("piece"):
                here, there = there, here
            raise InputError(
                "piece",
                f"{here[0].removeprefix('piece ')} {_span(here[1])} overlaps the {there[0]} {_span(there[1])}",
            )


def _span(span: tuple[float, float]) -> str:
    low, high = span
    if low == -float("inf"):
        return f"(the left end to {high * 1e3:.6g} mm)"
    if high == float("inf"):
        return f"({low * 1e3:.6g} mm to the right end)"
    return f"({low * 1e3:.6g} to {high * 1e3:.6g} mm)"
