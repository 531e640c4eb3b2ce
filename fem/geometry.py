"""The stator and its transducers: the sagittal section, x along the surface, z out of it, body at z < 0.

A transducer is an array of massless, perfectly conducting, equipotential fingers of equal width and pitch.  By default
the fingers alternate: finger 0 belongs to the positive electrode and finger 1 to the negative one, and two fingers and
two gaps make a period.  Split fingers ("++--") are four to a period.  Any other arrangement is a pattern with
one sign per finger: "+" and "-" are the two electrodes, "0" is a finger that is omitted (withdrawal weighting), and "o"
is an open strip, whose potential is such that it carries no net charge.  Fingers "o" alone are an open reflector,
fingers "+" alone a shorted one.

Two cells of single-phase unidirectional transducers (`CELLS`) have three fingers to a period, of which a wider one
reflects; a chirp changes the local period along the transducer.  Such fingers are neither equal nor equally spaced.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, Literal

import numpy as np

from fem.materials import Solid, fields, isotropic_about_normal
from fem.materials.christoffel import slowest_wavelength
from fem.mesh.mesh_piece import MeshPiece
from fem.mesh.placement import Placement, placement
from fem.parameters import ComplexNumber, Count, InputError, Number, Parameters, Signs, Words, refuses, shown

Bottom = Literal["free", "grounded", "clamped", "absorbing"]
Ends = Literal["absorbing", "free", "clamped"]
Above = Literal["none", "vacuum"]
MIN_WIDTH = 1e-3  # of a finger or a gap, relative to the pitch; narrower ones take ever finer elements
# Cells of unidirectional transducers: signs, and middle and width of each finger over the period at a metallisation of
# 1/2, from the left end of the cell.  The sources are in the middle of the second finger; the reflections are in the
# middle of the third one, 3/8 of a period to the right.
# DART: T. Kodama, H. Kawabata, Y. Yasuhara, H. Sato, Proc. IEEE Ultrasonics Symp. 1986, 59.  EWC: C. S. Hartmann and
# B. P. Abbott, Proc. IEEE Ultrasonics Symp. 1989, 79.
CELLS = {
    "DART": ("-+-", ((1 / 8, 1 / 8), (3 / 8, 1 / 8), (6 / 8, 3 / 8))),
    "EWC": ("-+-", ((5 / 32, 1 / 8), (13 / 32, 1 / 8), (25 / 32, 1 / 4))),
}
MAX_CHIRP = 1.0  # the local period at one end is then three times that at the other
# Strips along y of an apodised or slanted transducer: largest number of one, and default of a slanted one.  The
# admittance of a slant of 0.2 over 10 periods changes by 2e-4 from 8 strips to 16 (tests/fem/beam/test_strips.py).
MAX_STRIPS, SLANT_STRIPS = 256, 8
# Finger edges of a mesh and of a transducer are equal if they differ by less than this fraction of the pitch.
SAME_FINGER = 1e-3
# Largest outer gap of a transducer, as a fraction of the bare surface up to its neighbour: both gaps together fit.
CLEARANCE = 0.45


@dataclass(frozen=True, kw_only=True)
class Bond(Parameters):
    """An elastic joint below a layer: stiffness per area against motion along z and in the surface, N/m^3."""

    prefix = "bond"
    normal: Annotated[float, Number("N/m^3")]
    tangential: Annotated[float, Number("N/m^3")]


@dataclass(frozen=True, kw_only=True)
class Layer(Parameters):
    """A layer of a solid in the stator's frame (x along the propagation, z out of the surface).

    Attributes
    ----------
    solid : Solid
        Its losses are ignored by the analytic answers.
    thickness : float or None
        m; a frequency is then needed.
    wavelengths : float or None
        Thickness over the wavelength of the wave; one of the two is given.
    bond : Bond or None
        Joint to what lies below; None for a perfect one.
    """

    prefix = "layer"
    solid: Solid
    thickness: Annotated[float | None, Number("m")] = None
    wavelengths: Annotated[float | None, Number("wavelengths")] = None
    bond: Bond | None = None

    def check_size(self) -> Iterator[tuple[str, str]]:
        """Require one of thickness and wavelengths."""
        if (self.thickness is None) == (self.wavelengths is None):
            yield "", "must have either a thickness or a number of wavelengths"


@dataclass(frozen=True, kw_only=True)
class Stator(Parameters):
    """Body of the stator: its solid, its size and the boundary conditions on its sides.

    Attributes
    ----------
    solid : Solid
        Rotated to the stator's axes x (propagation), y, z (outward normal).
    length : float
        Extent along x in m.
    thickness : float
        Extent of the solid along z in m, below the layers; infinite for a half-space.
    bottom, ends, above : str
        Boundary conditions on the other sides, in the words of the scene file.
    pieces : tuple of MeshPiece
        Parts of the section that the user describes by meshes.
    layers : tuple of Layer
        On the solid, from the solid up, each with a thickness in m; the last is the surface, z = 0.
    plane : int
        Number of layers above the fingers; 0: the fingers are on the surface.
    """

    prefix = "stator"
    solid: Solid
    length: Annotated[float, Number("m")]
    thickness: Annotated[float, Number("m", infinite=True)]
    bottom: Bottom = "free"
    ends: Ends
    above: Above = "none"
    pieces: tuple[MeshPiece, ...] = ()
    layers: tuple[Layer, ...] = ()
    plane: Annotated[int, Count(least=0)] = 0

    def __post_init__(self):
        super().__post_init__()
        _check_layers(self)

    @property
    def solids(self) -> tuple[Solid, ...]:
        """The solid and those of its layers, from the bottom up."""
        return (self.solid, *(each.solid for each in self.layers))

    @property
    def fields(self) -> tuple[str, ...]:
        """Fields, out of "ux", "uy", "uz", "phi", that take part in the sagittal motion."""
        return fields(*self.solids)

    @property
    def coating(self) -> float:
        """Thickness of all layers together in m."""
        return sum(each.thickness or 0.0 for each in self.layers)

    @property
    def isotropic_about_normal(self) -> bool:
        """True if the directions along the surface are alike in all solids."""
        return all(isotropic_about_normal(each) for each in self.solids)

    def slowest_wavelength(self, frequency: float) -> float:
        """Wavelength in m of the slowest bulk wave of all solids at a frequency in Hz."""
        return min(slowest_wavelength(each, frequency) for each in self.solids)

    @property
    def relative_wavelengths(self) -> tuple[float, ...]:
        """Wavelengths of the slowest bulk waves of the solid and its layers over the least of them."""
        own = [slowest_wavelength(each, 1.0) for each in self.solids]
        return tuple(each / min(own) for each in own)

    @property
    def absorbs_below(self) -> bool:
        """True if no wave is reflected from the bottom."""
        return self.bottom == "absorbing" or not np.isfinite(self.thickness)

    @property
    def depth(self) -> float:
        """Thickness in m; infinite also with an absorbing bottom, where every thickness stands for a half-space."""
        return np.inf if self.absorbs_below else self.thickness

    @cached_property
    def placement(self) -> Placement:
        """Position of each meshed piece in the cascade, and both ends of the uniform part of the stator."""
        return placement(self.pieces, length=self.length, thickness=self.depth)

    def piece_warnings(self, frequency: float, transducers: tuple["Transducer", ...] = ()) -> tuple[str, ...]:
        """Warnings about the meshed pieces at a frequency in Hz, one sentence each."""
        from fem.mesh.piece_warnings import arc_warnings, corner_warnings  # that of a plain stator imports no mesh

        warnings = []
        wavelength = self.slowest_wavelength(frequency)
        for piece in self.pieces:
            warnings += corner_warnings(piece, self.bottom, wavelength) + arc_warnings(piece, wavelength)
        warnings += [f"{each}: the mesh counts" for each in self.other_fingers(transducers)]
        return tuple(dict.fromkeys(warnings))

    def other_fingers(self, transducers: tuple["Transducer", ...]) -> list[str]:
        """One sentence for each transducer whose fingers are not those drawn in a mesh of the whole stator."""
        whole = self.placement.whole
        return [] if whole is None else [each for one in transducers for each in _other_fingers(whole, one)]

    @property
    def bare_surface(self) -> str:
        """Electrical condition on the surface beside the fingers, as `rayleigh` names it."""
        return "open" if self.above == "none" else "vacuum"


@dataclass(frozen=True, kw_only=True)
class Transducer(Parameters):
    """Two interleaved electrodes on the surface.

    Attributes
    ----------
    name : str
        Name by which the drive refers to it.
    center : float
        x of the centre of the fingers, measured from the stator's left end, in m.
    finger_pairs : int
        Number of finger pairs, one finger of each electrode in a pair.
    period : float
        Width of two fingers and two gaps, in m.
    metallisation : float
        Finger width over finger width plus gap, between 0 and 1.
    aperture : float
        Overlap of the fingers along y, in m.
    termination : str or complex
        "open", "short" or the impedance in ohm between the electrodes, if the transducer is not driven.
    pattern : str, optional
        One of "+-0o" per finger; by default "+-" (split: "++--") is repeated.
    split : bool
        True for four fingers per period instead of two.
    cell : str
        "plain", or one of `CELLS`: three fingers per period, of a single-phase unidirectional transducer.
    mirrored : bool
        True reflects the cells in x.
    chirp : float
        Change of the local period from the left end to the right one over ``period``, which is its mean.
    overlaps : tuple of float, optional
        For each finger, how far it reaches over ``aperture``: the fingers "+", which come from +y, to y = -a W/2, the
        fingers "-" to y = a W/2.  Beyond its tip a dummy finger of the other electrode goes on.  By default all are 1.
    slant : float
        Change of the period from y = -W/2 to y = W/2 over ``period``, which is that of the middle.
    slant_strips : int
        Number of strips along y with one period each, that stand for a slanted transducer.
    center_y : float
        y of the centre of the fingers, measured from the stator's middle line, in m.  It affects only the beam, not the
        solution of the section.
    angle : float
        Rotation about the surface normal, from x towards y, in rad; it must be 0 in a section.
    """

    prefix = "transducer"
    owner = property(lambda self: self.name)
    name: str
    center: Annotated[float, Number("m", negative=True)]
    finger_pairs: Annotated[int, Count(most=100_000)]
    period: Annotated[float, Number("m")]
    metallisation: Annotated[float, Number(least=MIN_WIDTH, most=1 - MIN_WIDTH)]
    aperture: Annotated[float, Number("m")]
    termination: Annotated[str | complex, Words(("open", "short")) | ComplexNumber("ohm")] = "open"
    pattern: Annotated[str | None, Signs("+-0o")] = None
    split: bool = False
    cell: Annotated[str, Words(("plain", *CELLS))] = "plain"
    mirrored: bool = False
    chirp: Annotated[float, Number(negative=True, least=-MAX_CHIRP, most=MAX_CHIRP)] = 0.0
    overlaps: tuple[float, ...] | None = None
    slant: Annotated[float, Number(negative=True, least=-MAX_CHIRP, most=MAX_CHIRP)] = 0.0
    slant_strips: Annotated[int, Count(most=MAX_STRIPS)] = SLANT_STRIPS
    center_y: Annotated[float, Number("m", negative=True)] = 0.0
    angle: Annotated[float, Number("rad", negative=True)] = 0.0

    def check_pattern(self) -> Iterator[tuple[str, str]]:
        """Require a pattern of one sign for each finger, which leaves at least one."""
        per_period, pattern = len(cell_signs(self.cell, self.split, self.mirrored)), self.pattern
        count = self.finger_pairs * per_period
        if self.split and self.cell != "plain":
            yield "split", f"must be absent with the cell {self.cell}, whose fingers are its own"
        if self.mirrored and self.cell == "plain":
            yield "mirrored", f"must be absent with the cell plain: it is for {' and '.join(CELLS)}"
        if pattern is not None and len(pattern) != count:
            each = {2: "two", 3: "three", 4: "four"}[per_period]
            rule = f"must have {count} signs, {each} for each of the {self.finger_pairs} finger_pairs"
            yield "pattern", f"{rule}, got {len(pattern)}: {shown(pattern)}"
        overlaps = vars(self).get("overlaps")  # a scene has another key for it
        if overlaps is not None and (len(overlaps) != count or not all(0.0 <= each <= 1.0 for each in overlaps)):
            yield "overlaps", f"must be {count} numbers from 0 to 1, one for each finger, got {len(overlaps)}"
        if pattern is not None and set(pattern) == {"0"}:
            yield "pattern", f"must leave at least one finger, got {shown(pattern)}"

    @property
    def signs(self) -> str:
        """One of "+-0o" per finger, from left to right."""
        return self.pattern or cell_signs(self.cell, self.split, self.mirrored) * self.finger_pairs

    @property
    def uniform_along_y(self) -> bool:
        """True if all fingers are straight along y and reach over the whole aperture."""
        return self.slant == 0.0 and (self.overlaps is None or min(self.overlaps) == 1.0)

    def at_strip(self, low: float, high: float) -> "Transducer":
        """Transducer that stands for this one at low < y < high, m: signs and period as in the middle of the strip."""
        relative = (low + high) / self.aperture  # 2 y / W
        overlaps = self.overlaps or (1.0,) * len(self.signs)
        signs = "".join(
            "-" if sign == "+" and relative < -a else "+" if sign == "-" and relative > a else sign
            for sign, a in zip(self.signs, overlaps, strict=True)
        )
        return replace(
            self, pattern=None if signs == replace(self, pattern=None).signs else signs,
            period=self.period * (1.0 + self.slant * relative / 2), aperture=high - low, center_y=(low + high) / 2,
            overlaps=None, slant=0.0,
        )  # fmt: skip

    @property
    def per_period(self) -> int:
        """Number of fingers in a period."""
        return len(cell_signs(self.cell, self.split, self.mirrored))

    @property
    def even(self) -> bool:
        """True if all fingers are equal and equally spaced."""
        return self.cell == "plain" and self.chirp == 0.0

    @property
    def pitch(self) -> float:
        """Distance between the centres of neighbouring fingers in m; its mean unless they are `even`."""
        return self.period / self.per_period

    @property
    def finger_width(self) -> float:
        """Width of a finger in m; the smallest one unless they are `even`."""
        return self.metallisation * self.pitch if self.even else float(np.ptp(self.fingers, axis=1).min())

    @property
    def half_gap(self) -> float:
        """Half of the gap between two fingers in m; the smallest one unless they are `even`."""
        return (1 - self.metallisation) * self.pitch / 2 if self.even else float(self.gaps.min()) / 2

    @property
    def gaps(self) -> np.ndarray:
        """Gaps between neighbouring fingers in m, shape (fingers - 1,)."""
        return self.fingers[1:, 0] - self.fingers[:-1, 1]

    @property
    def extent(self) -> tuple[float, float]:
        """Left edge of the first and right edge of the last finger in m; omitted fingers count too."""
        if not self.even:
            return float(self.fingers[0, 0]), float(self.fingers[-1, 1])
        half = len(self.signs) * self.pitch / 2 - self.half_gap
        return self.center - half, self.center + half

    @property
    def corners(self) -> np.ndarray:
        """Corners (x, y) in m of the rectangle that contains all fingers, in cyclic order, shape (4, 2)."""
        return self.on_surface(np.array([self.extent]))[0]

    def on_surface(self, strips: np.ndarray) -> np.ndarray:
        """Corners (x, y) in m, shape (n, 4, 2), of strips whose edges (n, 2) are measured along the transducer."""
        along = np.asarray(strips)[:, [0, 1, 1, 0]] - self.center
        across = np.broadcast_to(self.aperture / 2 * np.array([-1, -1, 1, 1]), along.shape)
        return np.array([self.center, self.center_y]) + np.stack([along, across], axis=-1) @ turn(self.angle)

    @property
    def fingers(self) -> np.ndarray:
        """Left and right edges of all fingers in m, including the omitted ones, shape (fingers, 2)."""
        if not self.even:
            edges = cell_edges(self.cell, self.split, self.mirrored, self.metallisation)
            periods = (np.arange(self.finger_pairs)[:, None, None] + edges).reshape(-1, 2)
            return self.center + self.period * chirped(periods, self.finger_pairs, self.chirp)
        left = self.extent[0] + np.arange(len(self.signs)) * self.pitch
        return np.stack([left, left + self.finger_width], axis=1)

    def strips(self, sign: str) -> np.ndarray:
        """Edges of the fingers of one sign in m, shape (n, 2)."""
        return self.fingers[[each == sign for each in self.signs]]


def cell_signs(cell: str, split: bool, mirrored: bool) -> str:
    """Return the signs of the fingers of one period."""
    signs = CELLS[cell][0] if cell in CELLS else "++--" if split else "+-"
    return signs[::-1] if mirrored else signs


def cell_edges(cell: str, split: bool, mirrored: bool, metallisation: float) -> np.ndarray:
    """Return the left and right edges of the fingers of one period over its length, shape (fingers, 2).

    In a cell of `CELLS` every edge moves with the metallisation as those of its narrow fingers, an eighth of a period
    wide at 1/2.
    """
    if cell in CELLS:
        middle, width = np.array(CELLS[cell][1]).T
        half = width / 2 + (metallisation - 0.5) / 8
    else:
        count = 4 if split else 2
        middle, half = (np.arange(count) + 0.5) / count, np.full(count, metallisation / count / 2)
    edges = np.stack([middle - half, middle + half], axis=1)
    return 1.0 - edges[::-1, ::-1] if mirrored else edges


def chirped(periods: np.ndarray, count: int, chirp: float) -> np.ndarray:
    """Return positions over the mean period, from the middle, at numbers of periods 0 to ``count`` from the left end.

    The local period, over the mean one, is 1 + chirp (u / count - 1/2) at u periods.
    """
    return periods - count / 2 + chirp * (periods**2 / count - periods) / 2


@dataclass(frozen=True, kw_only=True)
class LateralStrip:
    """Part of the surface between two lines y, and the transducers that stand for those of the scene there."""

    low: float  # y, m
    high: float
    transducers: tuple[Transducer, ...]


def strips_of(transducers: tuple[Transducer, ...]) -> tuple[LateralStrip, ...]:
    """Return the strips along y between whose borders all fingers are uniform, from -y to +y.

    Raises
    ------
    InputError
        If a transducer is turned or beside the middle line, or there are more than `MAX_STRIPS`.
    """
    borders: set[float] = set()
    for each in transducers:
        if each.angle or each.center_y:
            rule = "must lie along x on the middle line beside an apodised or slanted one"
            raise InputError("transducer", rule, owner=each.name)
        relative = {1.0, *(each.overlaps or ())} - {0.0}
        relative |= set((np.arange(1, each.slant_strips) * 2 / each.slant_strips - 1).tolist()) if each.slant else set()
        borders |= {round(sign * a * each.aperture / 2, 12) for a in relative for sign in (-1.0, 1.0)}
    lines = sorted(borders)
    if len(lines) > MAX_STRIPS:
        rule = f"must be at most {MAX_STRIPS} strips of different fingers along y, got {len(lines) - 1}"
        raise InputError("transducer", rule)
    return tuple(
        LateralStrip(
            low=low, high=high,
            transducers=tuple(
                each.at_strip(low, high) for each in transducers if max(-low, high) <= each.aperture / 2 + 1e-12
            ),
        )
        for low, high in pairwise(lines)
    )  # fmt: skip


def plane_rule(plane: int, layers: int) -> str:
    """Return the rule that fingers below so many of all layers break; empty if none."""
    if 0 <= plane <= layers:
        return ""
    above = f"the number of layers above the fingers, 1 to {layers}" if layers else "absent without layers"
    return f'must be "surface" or {above}'


@refuses(InputError)
def _check_layers(stator: Stator) -> Iterator[Any]:
    """Raise an InputError for layers or a plane of the fingers that a section cannot have."""
    for number, each in enumerate(stator.layers):
        if each.thickness is None:
            yield (f"stator.layer.{number}.thickness", "must be a length in m", each.wavelengths, "wavelengths")
    if stator.layers and stator.pieces:
        yield "piece", "cannot stand in a stator with layers: the section beside it is one solid"
    if rule := plane_rule(stator.plane, len(stator.layers)):
        yield "transducer.plane", rule, stator.plane


def _other_fingers(piece: MeshPiece, transducer: Transducer) -> list[str]:
    """Return a sentence if the fingers in a mesh differ from those of a transducer."""
    drawn = [piece.strips(transducer.name + sign) for sign in "+-"]
    specified = [transducer.strips(sign) for sign in "+-"]
    if all(
        len(a) == len(b) and np.allclose(a, b, rtol=0, atol=SAME_FINGER * transducer.pitch)
        for a, b in zip(drawn, specified, strict=True)
    ):
        return []

    def listed(strips: list[np.ndarray], names: tuple[str, str]) -> str:
        return " and ".join(
            f"{len(each)}{name} from {each.min() * 1e3:.4g} to {each.max() * 1e3:.4g} mm"
            for each, name in zip(strips, names, strict=True)
            if len(each)
        )

    here = listed(drawn, (' fingers "+"', ' "-"'))
    return [f'transducer "{transducer.name}": the mesh draws {here}, the block has {listed(specified, ("", ""))}']


def one_electrode(where: str, pattern: str | None) -> str:
    """Return the rule that a pattern without fingers of both electrodes breaks."""
    return f"must have + and - fingers {where}, got {shown(pattern)}"


def repeated_names(transducers: Iterable[Any]) -> Iterator[tuple[int, str]]:
    """Yield the index of each transducer that has the name of one before it, and the rule that it breaks."""
    names = [each.name for each in transducers]
    for index, name in enumerate(names):
        if name in names[:index]:
            yield index, f"must differ from the others, got {shown(name)} twice"


def fingers_off_stator(left: float, right: float, length: float, axis: str = "") -> str:
    """Return the rule that fingers from left to right, or their middle alone, break on a stator; empty if none; m."""
    if left > 0 and right < length:
        return ""
    got = f"fingers from {axis}{left * 1e3:.6g} to {right * 1e3:.6g} mm"
    if left == right:
        got = f"their middle at {left * 1e3:g} mm"
    return f"must keep the fingers on the stator, 0 to {length * 1e3:g} mm, got {got}"


def on_stator(x, length: float) -> str:
    """Return the rule that positions x along a stator break, all in m; an empty text if none does."""
    return "" if np.all((x >= 0) & (x <= length)) else f"must lie on the stator, 0 to {length:g} m"


def separation(one: Transducer, other: Transducer) -> tuple[float, float]:
    """Widest gap between two transducers in m, and the direction of this gap in rad; overlap gives 0 or less.

    Two rectangles that do not overlap are separated by a line parallel to a side of one of them (separating axis
    theorem).  The direction from centre to centre is tried as well, because the gap may be wider there.
    """
    between = np.arctan2(other.center_y - one.center_y, other.center - one.center)
    sides = [each.angle + quarter * np.pi / 2 for each in (one, other) for quarter in range(4)]
    gaps = []
    for angle in (between, *sides):
        normal = np.array([np.cos(angle), np.sin(angle)])
        gaps.append((float((other.corners @ normal).min() - (one.corners @ normal).max()), float(angle)))
    return max(gaps)


def covers(transducer: Transducer, point: tuple[float, float]) -> bool:
    """True if a point (x, y) in m lies within the rectangle of a transducer's fingers."""
    across = turn(transducer.angle)
    own, corners = across @ np.array(point), transducer.corners @ across.T
    return bool(np.all((own >= corners.min(axis=0)) & (own <= corners.max(axis=0))))


def turn(angle: float) -> np.ndarray:
    """Rotation matrix whose rows are the unit vectors along and across a direction at an angle (rad) to x.

    Coordinates in the rotated axes times this matrix are x and y.
    """
    c, s = (each if abs(each) > 1e-12 else 0.0 for each in (np.cos(angle), np.sin(angle)))  # 90 deg is exact
    return np.array([[c, s], [-s, c]])


def outer_gaps(stator: Stator, transducers: tuple[Transducer, ...]) -> list[tuple[float, float]]:
    """Widths in m of the bare surface to the left and right of each transducer that are computed as part of it.

    Each is half a gap between fingers, or less if a neighbour or an end of the stator is near.
    """
    gaps, placed = [], stator.placement
    others = [*(each.extent for each in placed.between), *(each.extent for each in transducers)]
    for transducer in transducers:
        half = transducer.half_gap
        left, right = transducer.extent
        before = left - max([stop for start, stop in others if start < left], default=placed.start)
        after = min([start for start, stop in others if stop > right], default=placed.stop) - right
        gaps.append((min(half, CLEARANCE * before), min(half, CLEARANCE * after)))
    return gaps
