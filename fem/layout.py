"""Rules for the positions of transducers and meshed pieces on a stator, and for what a piece is made of."""

from collections.abc import Iterator
from functools import partial
from itertools import combinations, pairwise
from typing import Any, NamedTuple

import numpy as np

from fem.exceptions import InputError
from fem.geometry import Stator, Transducer, fingers_off_stator, repeated_names, separation
from fem.materials.solids import Solid
from fem.mesh.mesh_piece import FLOATING, GROUNDED, MAX_UNKNOWNS, SAME, MeshPiece
from fem.mesh.placement import Placement, is_step
from fem.mesh.section_mesh import ELECTRODE
from fem.mesh.shape_functions import CORNERS
from fem.parameters import refuse_if, refuses

# Smallest number of unknowns per quadrilateral: u_x, u_z and phi at order 4, the coarsest level
# (fem.condense.condensed_mesh).
LEAST_PER_QUAD = 3 * 4**2
TURNED = "where a transducer is turned or stands beside the middle line"  # condition of a rule, as printed
LENGTH_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "inch": 0.0254}  # m


def check_layout(stator: Stator, transducers: tuple[Transducer, ...]) -> None:
    """Check that the transducers of a section lie on the stator, do not overlap, are not rotated and differ in name.

    Raises
    ------
    InputError
        If a rule is broken; positions in the message are in mm.
    """
    _check_names(transducers)
    beside = stator.solids[::-1][max(stator.plane - 1, 0) : stator.plane + 1]
    metal = next((each.name for each in beside if each.conducting), None)
    rule = f"must not touch a metal layer, which shorts the fingers: {metal} is beside them"
    refuse_if(transducers and stator.layers and metal, "transducer.plane", rule, stator.plane or "surface")
    for transducer in transducers:
        refuse_if(
            transducer.angle,
            "transducer",
            f"must have the angle 0 in a section along x, got {transducer.angle:g} "
            "rad: an answer from one section of all transducers does not exist for rotated ones",
            owner=transducer.name,
        )
    placed = sorted(transducers, key=lambda transducer: transducer.center)
    for transducer in placed:
        _check_along(transducer.name, *transducer.extent, stator.length)
    for first, second in pairwise(placed):
        refuse_if(
            first.extent[1] >= second.extent[0],
            "transducer.center",
            f"must keep the fingers of {second.name!r} off those of {first.name!r}: the former begin at "
            f"{second.extent[0] * 1e3:.6g} mm, the latter end at {first.extent[1] * 1e3:.6g} mm",
            owner=second.name,
        )
    _check_pieces(stator, transducers)


def check_plan(stator: Stator, width: float, transducers: tuple[Transducer, ...]) -> None:
    """Check in the plan view that the transducers lie on the surface, do not overlap and differ in name.

    Raises
    ------
    InputError
        If a rule is broken; positions in the message are in mm.
    """
    _check_names(transducers)
    for each in transducers:
        (left, low), (right, high) = each.corners.min(axis=0), each.corners.max(axis=0)
        _check_along(each.name, left, right, stator.length, axis="x = ")
        refuse_if(
            max(-low, high) > width / 2 * (1 + 1e-12),
            "transducer.center",
            f"must keep the fingers on the stator, y from -{width * 500:g} to {width * 500:g} mm, got fingers from "
            f"y = {low * 1e3:.6g} to {high * 1e3:.6g} mm",
            owner=each.name,
        )
    for one, other in combinations(transducers, 2):
        refuse_if(
            separation(one, other)[0] <= 0,
            "transducer.center",
            f"must keep the fingers of {other.name!r} off those of {one.name!r}: they overlap on the surface",
            owner=other.name,
        )


def _check_along(name: str, left: float, right: float, length: float, axis: str = "") -> None:
    if rule := fingers_off_stator(left, right, length, axis):
        raise InputError("transducer.center", rule, owner=name)


def _check_names(transducers: tuple[Transducer, ...]) -> None:
    for index, rule in repeated_names(transducers):
        raise InputError("transducer.name", rule, owner=transducers[index].name)


def turned_rules(ends: str, sides: str = "absorbing") -> Iterator[tuple[str, str]]:
    """Yield key and rule of conditions with which the beams of turned transducers are not computed."""
    for key, value in (("ends", ends), ("sides", sides)):
        if value != "absorbing":
            yield f"stator.{key}", f"must be absorbing {TURNED}, got {value!r}"


@refuses(InputError)
def check_turned(stator: Stator) -> Iterator[Any]:
    """Raise an InputError for a stator on which no transducer may be turned or stand beside the middle line."""
    for key, rule in turned_rules(stator.ends):
        yield key, rule
    if not stator.isotropic_about_normal:
        rule = "may be rotated, or stand beside the middle line, only in solids isotropic about z, unlike this cut of"
        yield "transducer", f"{rule} {stator.solid.name}"


def _refuse(piece: MeshPiece, rule: str, key: str = "piece") -> None:
    raise InputError(key, rule, owner=piece.name)


@refuses(InputError)
def check_interfaces(stator: Stator) -> Iterator[Any]:
    """Check that the meshed pieces of a stator meet its section: as high, up to the surface, without field above.

    Raises
    ------
    InputError
        If a rule is broken; lengths in the message are in mm.
    """
    if stator.pieces and stator.above != "none":
        rule = "must be none with a meshed piece, whose model error states the effect of the field above"
        yield "stator.above", rule, stator.above
    for piece in stator.pieces:
        _check_heights(piece, stator.depth)


@refuses(InputError)
def check_beside_pieces(stator: Stator) -> Iterator[Any]:
    """Raise an InputError if a meshed piece is the whole stator, so that no wave arrives at it."""
    if stator.placement.whole is not None:
        yield ("piece", "must leave some uniform stator: this piece is all of it, and no wave arrives there")


@refuses(InputError)
def _check_pieces(stator: Stator, transducers: tuple[Transducer, ...]) -> Iterator[Any]:
    """Raise an InputError if the pieces do not fit the stator, the transducers or each other."""
    if not stator.pieces:
        return
    check_interfaces(stator)
    placed = stator.placement
    if placed.whole is not None:
        _check_whole(placed.whole, stator, transducers)
    for piece in stator.pieces:
        _check_size(piece)
        _check_materials(piece)
        _check_electrodes(piece, transducers, at_end=piece in placed.ends)
        _check_electrode_lines(piece, stator.solid)
        if stator.bottom != "free" and not stator.absorbs_below and "bottom" not in piece.mesh.lines:
            _refuse(piece, f"must have the line group bottom, as stator.bottom is {stator.bottom}, got none")
    # inner: x at which the end piece meets the uniform stator
    for index, (end, inner) in enumerate(zip(placed.ends, (placed.start, placed.stop), strict=True)):
        if end is None:
            continue
        if not is_step(end, stator.depth):
            _check_outer_end(end, index, stator.length)
        elif stator.ends != "absorbing":
            yield (
                "stator.ends",
                f"must be absorbing behind the step of thickness of piece {end.name!r}, got {stator.ends!r}",
            )
        if not 0 < inner < stator.length:
            _refuse(end, _off_stator(end, stator.length))
    if placed.whole is None:
        _check_overlaps(placed, stator.length, transducers)


def _off_stator(piece: MeshPiece, length: float) -> str:
    return f"must lie on the stator, 0 to {length * 1e3:g} mm, got {piece.where}"


def _check_outer_end(piece: MeshPiece, index: int, length: float) -> None:
    """Raise an InputError for an end piece whose far side is not the stator's end; ``index``: 0 left, 1 right."""
    side, at, intended = ("left", "right")[index], piece.extent[index], (0.0, length)[index]
    if abs(at - intended) > SAME * length:
        _refuse(
            piece,
            f'has no line group {side} in its file "{piece.mesh.name}", which makes it the {side} end of the stator: '
            f"it must end at x = {intended * 1e3:.6g} mm{' (stator.length)' if index else ''}, got "
            f"{at * 1e3:.6g} mm",
        )


def _check_heights(piece: MeshPiece, thickness: float) -> None:
    """Raise an InputError if no interface of the piece is as high as the stator, or if one covers part of its border.

    One interface that fits is enough: behind the other one a stator of another thickness may follow (a step).
    """
    # by side: position, height and upper end z of the interface
    lines = {side: line for side in ("left", "right") if (line := piece.interface(side)) is not None}
    for side, (_, height, _) in lines.items():
        border = piece.mesh.border(side)
        if height < (1 - SAME) * border and not piece.fits(side, thickness):
            _refuse(
                piece,
                f'must have all lines of its {side} border in the line group {side}: in the file "{piece.mesh.name}" '
                f"the group covers {height * 1e3:.6g} of {border * 1e3:.6g} mm",
            )
    if np.isinf(thickness):
        _check_lower_side(piece, lines)
        return
    if not lines or any(piece.fits(side, thickness) for side in lines):
        return
    side, (_, height, top) = next(iter(lines.items()))
    if abs(height - thickness) <= SAME * thickness:
        _refuse(piece, f"must have the upper end of its group {side} at the surface z = 0, got z = {top * 1e3:.6g} mm")
    _refuse(
        piece,
        f"must be as thick as the stator at its interface: the group {side} is {height * 1e3:.6g} mm high, the stator "
        f"is {thickness * 1e3:.6g} mm thick{_unit_question(piece, height, thickness)}",
    )


def _check_lower_side(piece: MeshPiece, lines: dict[str, tuple[float, float, float]]) -> None:
    """Raise an InputError if a piece of a half-space cannot be continued downwards.

    Where the bottom absorbs, the program continues the solid uniformly below the lower side of the mesh.  Interfaces
    (``lines``, by side) must therefore reach down to that side; and it must be straight, of the stator's own material
    and without boundary condition.
    """
    mesh, depth = piece.mesh, piece.depth * 1e3

    refuse = partial(_refuse, piece)
    for side, (_, height, top) in lines.items():
        if not piece.fits(side, np.inf):
            refuse(
                f"must reach at its group {side} from the surface, z = 0, down to its lowest point, z = -{depth:.6g} mm"
                f", as the bottom absorbs, got z = {top * 1e3:.6g} to {(top - height) * 1e3:.6g} mm"
            )
    lowest_edges = mesh.foot
    low, high = mesh.extent
    width, lowest_width = high - low, float(abs(np.diff(mesh.points[lowest_edges, 0], axis=1)).sum())
    if abs(lowest_width - width) > SAME * width:
        refuse(
            "must have one straight horizontal lower side, below which the program continues the solid as the bottom "
            f"absorbs: {lowest_width * 1e3:.6g} of {width * 1e3:.6g} mm lie at z = -{depth:.6g} mm"
        )
    edges = [tuple(edge) for edge in lowest_edges.tolist()]
    other_solids = {mesh.cells[mesh.edges[edge][0][0]].solid for edge in edges} - {"stator"}
    if other_solids:
        refuse(
            "must consist of the stator's own material at its lower side, which the program continues as the bottom "
            f"absorbs, got {other_solids.pop()!r}"
        )
    undirected = {frozenset(edge) for edge in edges}
    for name, line in mesh.lines.items():
        if name != "bottom" and any(frozenset(edge) in undirected for edge in line.tolist()):
            refuse(
                "must have no other line group than bottom at its lower side, below which the program continues "
                f"the solid as the bottom absorbs, got {name!r}"
            )


def _unit_question(piece: MeshPiece, drawn: float, intended: float) -> str:
    """Return the advice to change the file's length unit, if another unit gives a drawn length its intended value."""
    unit = piece.mesh.unit * intended / drawn
    hint = next((name for name, each in LENGTH_UNITS.items() if abs(unit / each - 1) < 0.02), "")
    return f": is the file's length unit {hint}?" if hint else ""


def _check_whole(piece: MeshPiece, stator: Stator, transducers: tuple[Transducer, ...]) -> None:
    """Raise an InputError for a piece without interface that is not the whole stator."""
    length, thickness, refuse = stator.length, stator.thickness, partial(_refuse, piece)
    low, high = piece.extent
    if max(abs(low), abs(high - length)) > SAME * length:
        refuse(
            "has no line group left or right, where a mesh meets the uniform stator; without them it must be the whole "
            f"stator, 0 to {length * 1e3:.6g} mm, got {piece.where}"
            f"{_unit_question(piece, high - low, length)}"
        )
    if len(stator.pieces) > 1:
        refuse(
            "has no line group left or right and is the whole stator: it must be the only piece, got "
            f"{len(stator.pieces)}"
        )
    bottom, top = (each * 1e3 for each in piece.mesh.depth_range)
    thickness = piece.depth if stator.absorbs_below else thickness  # the program continues what is drawn
    if max(abs(bottom + thickness * 1e3), abs(top)) > SAME * thickness * 1e3:
        refuse(
            f"is the whole stator: its surface group stator must reach from z = -{thickness * 1e3:.6g} mm (minus "
            f"stator.thickness) to 0, got {bottom:.6g} to {top:.6g} mm"
            f"{_unit_question(piece, (top - bottom) * 1e-3, thickness)}"
        )
    if stator.ends != "free":
        refuse(
            f'must be free with piece "{piece.name}", which is the whole stator: its line group clamped says what is '
            f"held, and a mesh does not absorb; got {stator.ends!r}",
            key="stator.ends",
        )
    connected = {connection for _, connection in piece.electrodes}
    for each in transducers:
        for sign in "+-":
            if sign in each.signs and each.name + sign not in connected:
                refuse(
                    f"must connect a line group electrode:NAME to {each.name}{sign}: the piece is the whole stator, "
                    f'and the fingers of transducer "{each.name}" are those that the mesh draws',
                    key="piece.electrodes",
                )


def _check_size(piece: MeshPiece) -> None:
    """Raise an InputError for a mesh with too many unknowns even at the coarsest level."""
    # every element is divided into as many quadrilaterals as it has corners (fem.mesh.quad_mesh)
    quads = sum(CORNERS[cells.kind] * len(cells.nodes) for cells in piece.mesh.cells)
    least = quads * LEAST_PER_QUAD
    if least <= MAX_UNKNOWNS:
        return
    count = sum(len(cells.nodes) for cells in piece.mesh.cells)
    size = np.median([np.median(np.ptp(piece.mesh.points[cells.nodes, 0], axis=1)) for cells in piece.mesh.cells])
    _refuse(
        piece,
        f"has {count} elements, about {size * 1e3:.2g} mm wide, and at least {least:.2g} unknowns, at most "
        f"{MAX_UNKNOWNS:.0g} are solved for: draw elements of {size * 1e3 * np.sqrt(least / MAX_UNKNOWNS):.2g} mm or "
        "more; the program refines corners itself and raises the order",
        "piece.file",
    )


def _check_materials(piece: MeshPiece) -> None:
    """Raise an InputError for surface groups without a solid, or solids without a surface group."""
    refuse = partial(_refuse, piece, key="piece.materials")
    known = ["stator", *(name for name, _ in piece.solids)]
    if "stator" in known[1:]:
        refuse('must not name "stator", whose material is stator.material')
    for name in piece.mesh.solids:
        if name not in known:
            refuse(f'must give the solid of every surface group but "stator", got none for "{name}"')
    for name in known[1:]:
        if name not in piece.mesh.solids:
            groups = ", ".join(each for each in piece.mesh.solids if each != "stator") or "none besides stator"
            refuse(f'names "{name}", which is no surface group of the file: {groups}')


def _check_electrodes(piece: MeshPiece, transducers: tuple[Transducer, ...], *, at_end: bool) -> None:
    """Raise an InputError for connections to electrodes or transducers that do not exist."""
    refuse = partial(_refuse, piece, key="piece.electrodes")
    signs = {each.name: each.signs for each in transducers}
    for name, connection in piece.electrodes:
        if name not in piece.mesh.electrodes:
            groups = ", ".join(piece.mesh.electrodes) or "none"
            refuse(f'names "{name}", which is no line group electrode:NAME of the file: {groups}')
        if connection in (FLOATING, GROUNDED):
            continue
        comb, sign = connection[:-1], connection[-1:]
        if sign not in ("+", "-") or comb not in signs:
            known = ", ".join(f"{each}+, {each}-" for each in signs)
            refuse(f'must connect "{name}" to floating, grounded or a comb ({known}), got {connection!r}')
        if sign not in signs[comb]:
            refuse(f'connects "{name}" to {connection}, and that transducer has no finger "{sign}"')
        if at_end:
            refuse(f'must leave "{name}" floating or grounded: a piece at the stator\'s end is connected to no comb')


def _check_electrode_lines(piece: MeshPiece, solid: Solid) -> None:
    """Raise an InputError for electrodes that touch each other or an interface, or touch no piezoelectric solid."""
    mesh, owner = piece.mesh, dict[int, str]()
    solids = {"stator": solid} | dict(piece.solids)
    coupled = {int(n) for each in mesh.cells if solids[each.solid].is_piezoelectric for n in np.unique(each.nodes)}

    def refuse(rule: str, at: set[int] | None = None) -> None:  # {} in the rule: position of one of the nodes ``at``
        where = " at ({:.4g}, {:.4g}) mm".format(*mesh.points[min(at)] * 1e3) if at else ""
        _refuse(piece, rule.format(where), "piece.file")

    for name in mesh.electrodes:
        nodes = set(mesh.lines[ELECTRODE + name].ravel().tolist())
        if len(nodes & coupled) < 2:  # a corner alone is no contact
            refuse(f'must draw the line group "electrode:{name}" on a piezoelectric solid')
        if shared := nodes & owner.keys():
            refuse(f'"electrode:{owner[min(shared)]}" and "electrode:{name}" touch{{}}: give them one name', shared)
        for side in ("left", "right"):
            if shared := nodes.intersection(mesh.lines.get(side, np.empty(0)).ravel().tolist()):
                refuse(f'"electrode:{name}" reaches the interface {side}{{}}: it must end before it', shared)
        owner |= dict.fromkeys(nodes, name)


class _Span(NamedTuple):
    """Part of the surface, m, that a piece or a transducer occupies."""

    low: float
    high: float
    kind: str  # "piece" or "transducer"
    name: str

    def __str__(self):
        if self.low == -float("inf"):
            return f"(the left end to {self.high * 1e3:.6g} mm)"
        if self.high == float("inf"):
            return f"({self.low * 1e3:.6g} mm to the right end)"
        return f"({self.low * 1e3:.6g} to {self.high * 1e3:.6g} mm)"


@refuses(InputError)
def _check_overlaps(placed: Placement, length: float, transducers: tuple[Transducer, ...]) -> Iterator[Any]:
    """Raise an InputError for a piece that lies off the stator, overlaps another one, or meets a transducer."""
    tolerance = SAME * length
    for piece in placed.between:
        low, high = piece.extent
        if low < -tolerance or high > length + tolerance:
            _refuse(piece, f"{_off_stator(piece, length)}{_millimetre_question(piece, length)}")
    spans = [_Span(*each.extent, "piece", each.name) for each in placed.between]
    left_end, right_end = placed.ends
    if left_end is not None:
        spans.append(_Span(-float("inf"), left_end.extent[1], "piece", left_end.name))
    if right_end is not None:
        spans.append(_Span(right_end.extent[0], float("inf"), "piece", right_end.name))
    spans += [_Span(*each.extent, "transducer", each.name) for each in transducers]
    for left, right in pairwise(sorted(spans, key=lambda span: (span.low, span.high))):
        # the message begins with a piece: with the left one if both are pieces
        piece_span, other = (left, right) if left.kind == "piece" else (right, left)
        overlap = left.high > right.low + 1e-3 * tolerance
        # two pieces may touch, but between a piece and a finger there must be bare surface
        touch = left.kind != right.kind and left.high > right.low - tolerance
        if overlap or touch:
            verb = "overlaps" if overlap else "touches"
            yield ("piece", f'"{piece_span.name}" {piece_span} {verb} the {other.kind} "{other.name}" {other}')


def _millimetre_question(piece: MeshPiece, length: float) -> str:
    """Return a question about the unit if a position far beyond the stator would lie on it as a number of mm."""
    fits_in_mm = 10 * length < piece.position <= 1e3 * length
    return f': is "{piece.position:g} mm" meant? A number without a unit is in m' if fits_in_mm else ""
