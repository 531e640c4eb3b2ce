"""Order of the meshed pieces on a stator: between uniform segments, its ends, or the whole of it."""

from dataclasses import dataclass

from fem.exceptions import InputError
from fem.mesh.mesh_piece import MeshPiece


@dataclass(frozen=True, kw_only=True)
class Placement:
    """Meshed pieces by their part in the cascade."""

    between: tuple[MeshPiece, ...]  # from left to right, with an interface on both sides
    ends: tuple[MeshPiece | None, MeshPiece | None]  # the left and the right end, where they are meshes
    whole: MeshPiece | None  # the stator from end to end: it has no interface
    # start, stop: where the uniform stator begins and ends, m
    start: float
    stop: float


def is_step(piece: MeshPiece, thickness: float) -> bool:
    """True if a piece is a step from the stator's thickness to another one."""
    sides = ("left", "right")
    return all(piece.interface(side) for side in sides) and sum(piece.fits(side, thickness) for side in sides) == 1


def placement(pieces: tuple[MeshPiece, ...], *, length: float, thickness: float) -> Placement:
    """Sort pieces by their part in the cascade: between uniform segments, an end of the stator, or all of it."""
    whole = None
    between: list[MeshPiece] = []
    ends: list[MeshPiece | None] = [None, None]
    start, stop = 0.0, length
    for piece in sorted(pieces, key=lambda each: each.extent[0]):
        left, right = piece.interface("left"), piece.interface("right")
        if left is None and right is None:
            whole = piece
            continue
        step = is_step(piece, thickness)
        if right is not None and (left is None or (step and not piece.fits("left", thickness))):
            side, start = 0, right[0]
        elif left is not None and (right is None or step):
            side, stop = 1, left[0]
        else:
            between.append(piece)
            continue
        other = ends[side]
        if other is not None:
            raise InputError(
                "piece",
                f'"{other.name}" ({other.where}) and "{piece.name}" ({piece.where}) are both the '
                f"{('left', 'right')[side]} end, as the line group {('left', 'right')[side]} is absent or not as high "
                "as the stator",
            )
        ends[side] = piece
    return Placement(between=tuple(between), ends=(ends[0], ends[1]), whole=whole, start=start, stop=stop)
