"""From a scene to pillars on a passing wave: positions, heights, stiffnesses, and the waves from both sides.

A pillar of radius a, height h, cross-section A = pi a^2 and second moment I = pi a^4/4 on the pair's moduli E* and G*:

    1/k_n = f/(2 a E*) + h/(E A),    1/k_t = f/(8 a G*) + h/(0.9 G A) + h^3/(12 E I)

(Johnson, *Contact Mechanics*, eq. 3.36 and section 7.2; Timoshenko's beam between two faces that stay parallel). The
neighbours' dents lower the mean plane of a square grid, so that a punch is stiffer relative to it: f = 1 - 2.4830 a/p
for point loads (lattice sum), which holds up to a/p = 0.1; beyond, f comes from the table `NEIGHBOURS` (boundary
elements, +-1 %). For point loads the factor of k_t is the same: a force Q along x moves the surface by
u_x = Q ((1 - nu) + nu cos^2 theta)/(2 pi G r) (Cerruti; Johnson, section 3.6), whose sum over a square grid is that of
Q (2 - nu)/(4 pi G r), because cos^2 theta is 1/2 in the mean. Over the pillar's own Q/(8 a G*) this is the same share
as that of the normal forces, whatever nu is. Beyond a/p = 0.1, and for unequal pitches, this is an assumption.

A prescribed [wave], whose surface points move towards +x at its crests, runs towards -x (retrograde motion).
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

import contact
import fem
from fem.parameters import refuses
from studies.lab.column_heads import DISPLACEMENTS, POSITIONS
from studies.lab.csv_columns import CsvColumns
from studies.model.model import Model
from studies.model.scene_errors import input_errors, slider_keys
from studies.model.slider_wave import mean_amplitudes, stator_wave
from studies.refusal import SceneError
from studies.scene import Scene
from studies.scene.drive import Wave
from studies.scene.pillar_keys import MAX_PILLARS, SEED
from studies.scene.slider_keys import Slider

LENGTHS = POSITIONS | DISPLACEMENTS  # units of the columns of a file
LATTICE, LATTICE_REACH = 2.4830, 0.1  # sum over a square lattice, and the a/p up to which it holds
# a/p beyond that, and the stiffness of a punch relative to the mean plane over that of one alone
NEIGHBOURS = (0.2, 0.3, 0.4), (1.92, 3.21, 6.96)
SILICON = "silicon"  # default material of the pillars


def resolved(slider: Slider) -> Slider:
    """Return a slider whose pillars have their seed and their own moduli as numbers."""
    block = slider.pillars
    own: dict[str, Any] = {}
    if block.height_scatter > 0.0 and block.seed is None:
        own["seed"] = SEED
    if block.height is not None and None in (block.youngs_modulus, block.poisson_ratio):
        with input_errors("slider.ball"):
            c = fem.material(slider.ball or SILICON).stiffness
        lame, shear = float(c[0, 1]), float(c[3, 3])
        modulus, ratio = shear * (3 * lame + 2 * shear) / (lame + shear), lame / (2 * (lame + shear))
        own["youngs_modulus"] = block.youngs_modulus or modulus
        own["poisson_ratio"] = ratio if block.poisson_ratio is None else block.poisson_ratio
    return replace(slider, pillars=replace(block, **own), shape="punch")


class Layout(NamedTuple):
    """Geometry of the pillars of a slider, in m; x and y from the slider's centre."""

    x: np.ndarray
    y: np.ndarray
    heights: np.ndarray
    diameter: np.ndarray  # of each
    pitch: float  # mean
    across: float  # pitch along y


@lru_cache(16)
def layout(slider: Slider) -> Layout:
    """Return the geometry of the pillars of a slider, from its grid or its file."""
    block = slider.pillars
    if block.file is not None:
        x, y, heights, diameter = _of_file(block)
        if not np.all(diameter > 0.0):
            block.refuse("file", f"must hold positive diameters, got {diameter.min():g} m")
        _refuse_overlap(block, x, y, diameter)
        area = (np.ptp(x) + diameter.max()) * (np.ptp(y) + diameter.max())
        pitch = math.sqrt(area / x.size)
        lines = np.unique(np.round(y / max(np.ptp(y), 1e-300), 9)).size
        across = np.ptp(y) / (lines - 1) if 1 < lines < 2 * math.sqrt(x.size) else pitch
    else:
        (along, across), counts = block.pitches, block.counts
        positions = [(np.arange(n) - (n - 1) / 2) * p for n, p in zip(counts, (along, across), strict=True)]
        x, y = (each.ravel() for each in np.meshgrid(*positions, indexing="ij"))
        heights = np.zeros(x.size)
        if block.height_scatter > 0.0:
            seed = SEED if block.seed is None else block.seed
            heights = np.random.default_rng(seed).normal(scale=block.height_scatter, size=x.size)
        diameter, pitch = np.full(x.size, block.diameter), math.sqrt(along * across)
    if block.height is not None and np.abs(heights).max() > block.height:
        tallest = heights[np.abs(heights).argmax()]
        rule = f"must be larger than every deviation of the heights, of which one is {tallest:g} m"
        block.refuse("height", f"{rule}, got {block.height:g} m")
    return Layout(x, y, heights, diameter, pitch, float(across))


def _of_file(block) -> tuple[np.ndarray, ...]:
    """Return x, y, heights and diameters of the pillars in the CSV file of a block, m."""
    table = CsvColumns.read(block.file, "slider.pillars.file")
    table.refuse_uneven()
    table.refuse_if(len(table.rows) > MAX_PILLARS, f"must hold at most {MAX_PILLARS} pillars, got {len(table.rows)}")
    x, y, height, own = (table.column(noun, LENGTHS) for noun in ("x", "y", "height", "diameter"))
    if x is None or y is None or height is None:
        raise table.error(f"must have the columns x_m, y_m, height_m, got {', '.join(table.names)}")
    if own is None and block.diameter is None:
        block.refuse("diameter", "is required and missing: the file has no column diameter_m")
    diameter = np.full(len(table.rows), block.diameter) if own is None else own[0]
    return x[0], y[0], height[0], diameter


def _refuse_overlap(block, x, y, diameter):
    """Refuse pillars of a file that overlap."""
    from scipy.spatial import cKDTree

    if x.size < 2:
        return
    points = np.stack([x, y], axis=1)
    (_, apart), (_, other) = (each.T for each in cKDTree(points).query(points, k=2))  # the first is the point itself
    gap = apart - 0.5 * (diameter + diameter[other]) * (1 - 1e-9)
    worst = int(gap.argmin())
    if gap[worst] < 0.0:
        first, second = sorted((worst + 1, int(other[worst]) + 1))
        rule = f"must hold pillars that do not overlap, got {apart[worst]:g} m between points {first} and {second}"
        block.refuse("file", rule)


def neighbours(radius_over_pitch):
    """Return the compliance of a punch relative to the mean plane of a square grid over that of one alone.

    Examples
    --------
    >>> [round(1 / neighbours(each), 2) for each in (0.05, 0.1, 0.2)]
    [1.14, 1.33, 1.92]
    """
    from scipy.interpolate import PchipInterpolator

    ratio = float(radius_over_pitch)
    if ratio <= LATTICE_REACH:
        return 1.0 - LATTICE * ratio
    ratios, stiffer = NEIGHBOURS
    if ratio > ratios[-1]:
        rule = f"knows a radius of at most {ratios[-1]:g} pitches, got {ratio:.3g}"
        raise SceneError("slider.pillars.interaction", rule)
    joint = np.array([LATTICE_REACH / 2, LATTICE_REACH])  # two points of the line keep its slope at LATTICE_REACH
    compliances = [*(1.0 - LATTICE * joint), *(1.0 / np.array(stiffer))]
    return float(PchipInterpolator([*joint, *ratios], compliances)(ratio))


def stiffnesses(slider: Slider, interaction: bool | None = None):
    """Return k_n and k_t of the pillars of a resolved slider, arrays, N/m; ``interaction`` replaces the scene's."""
    block, geometry = slider.pillars, layout(slider)
    a = geometry.diameter / 2
    near = neighbours(a.mean() / geometry.pitch) if (block.interaction if interaction is None else interaction) else 1.0
    normal, tangential = near / (2 * a * slider.effective_modulus), near / (8 * a * slider.tangential_modulus)
    if block.height is not None:
        E, h, A = block.youngs_modulus, block.height, np.pi * a**2
        G = E / (2 * (1 + block.poisson_ratio))
        normal = normal + h / (E * A)
        tangential = tangential + h / (0.9 * G * A) + h**3 / (12 * E * np.pi * a**4 / 4)
    return 1 / normal, 1 / tangential


@lru_cache(16)
def slider_of(slider: Slider, interaction: bool | None = None):
    """Return the `contact.Slider` of a resolved slider on pillars.

    Its mass is infinite: it is too heavy to follow the wave within a cycle, and does not bounce.
    """
    geometry, (k_n, k_t) = layout(slider), stiffnesses(slider, interaction)
    for name, value in (("friction_coefficient", slider.static_coefficient), ("preload", slider.preload_force)):
        if not value > 0.0:
            raise SceneError(f"slider.{name}", "must be positive with [slider.pillars]")
    with slider_keys():
        return contact.Slider(
            x=geometry.x, y=geometry.y, heights=geometry.heights, normal_stiffness=k_n, tangential_stiffness=k_t,
            radius=geometry.diameter / 2, friction_coefficient=slider.static_coefficient, mass=math.inf,
            preload=slider.preload_force, load=slider.load, law="elastic", reciprocal=False, stick_band=0.0,
            contact_damping=0.0, normal_damping=0.0, tangential_damping=slider.damping.tangential, shape="punch",
            tilt=slider.tilt, preload_at=slider.preload_at, load_height=slider.load_height, backing=slider.backing,
            curvature=slider.pillars.curvature,
        )  # fmt: skip


def extent(slider: Slider) -> tuple[float, float]:
    """Return the ends of the pillars along x on the stator, m."""
    geometry, centre = layout(slider), slider.center[0]
    half = geometry.diameter / 2
    return centre + float((geometry.x - half).min()), centre + float((geometry.x + half).max())


def intervals(slider: Slider) -> list[tuple[float, float]]:
    """Return the `extent` as the only interval that the pillars cover."""
    return [extent(slider)]


def places(slider: Slider) -> list[tuple[str, float, float]]:
    """Return the pillars at either end in words, with x and y in m."""
    return [("a pillar", x, slider.center[1]) for x in extent(slider)]


def lines(model: Model, weight: str, moduli: str) -> list[str]:
    """Return the pillars in words, after the weight of the slider and the moduli of the pair."""
    slider = model.scene.slider
    geometry, (k_n, k_t) = layout(slider), stiffnesses(slider)
    return [
        f"{weight}, {geometry.x.size} pillars of {geometry.diameter.mean() * 1e6:.4g} um, {moduli}",
        f"stiffness of a pillar {k_n.mean():.4g} N/m, along the surface {k_t.mean():.4g} N/m",
    ]


def strip_width(slider: Slider) -> float:
    """Return the width of the strip over which the pillars spread their load, m."""
    if slider.pillars.width is not None:
        return slider.pillars.width
    geometry = layout(slider)
    return float(np.ptp(geometry.y)) + geometry.across


def stator_motion(slider: Slider, stator, solved, motion: Callable[[], Any]) -> tuple:
    """Return the `contact.PassingWave` that is fitted to a stator's motion for 1 V, its misfit, and its amplitudes."""
    x = layout(slider).x
    passing, misfit = stator_wave(
        stator, motion(), center=slider.center, extent=float(np.ptp(x)), width=strip_width(slider),
        loading=slider.loading,
    )  # fmt: skip
    return passing, misfit, mean_amplitudes(x, passing)


def prescribed_motion(slider: Slider, wave: Wave) -> contact.PassingWave:
    """Return the `contact.PassingWave` of a [wave] of amplitude 1 m, which runs towards -x."""
    return contact.PassingWave(
        frequency=wave.frequency, wavelength=wave.wavelength or 1.0, ratio=wave.tangential_ratio, backward=1.0,
        compliance=wave.compliance or 0.0, strip_width=strip_width(slider), loading=slider.loading,
    )  # fmt: skip


@refuses(SceneError)
def check(scene: Scene) -> Iterator[Any]:
    """Refuse pillars beyond the stator or on a transducer's fingers; the slider is resolved."""
    slider = scene.slider
    geometry = layout(slider)
    slider_of(slider)
    if scene.stator is None:
        return
    half, middle, (left, right) = geometry.diameter / 2, slider.center[1], extent(slider)
    if left < 0.0 or right > scene.stator.length:
        rule = f"must keep the pillars on the stator, 0 to {scene.stator.length:g} m"
        yield "slider.position", f"{rule}, got some from {left:g} to {right:g} m"
    beside = float((np.abs(middle + geometry.y) + half).max())
    if beside > (side := scene.stator.width / 2):
        rule = f"must keep the pillars on the stator, y from -{side:g} to {side:g} m"
        yield "slider.position", f"{rule}, got some at y = {beside:g} m"
    for each in scene.transducer:
        x, y = each.center_xy
        reach = each.half_length
        if left < x + reach and right > x - reach and abs(middle - y) < (each.aperture + strip_width(slider)) / 2:
            rule = f"must keep the pillars off the fingers of {each.name!r}, {x - reach:g} to {x + reach:g} m"
            yield "slider.position", f"{rule}, got pillars from {left:g} to {right:g} m"
