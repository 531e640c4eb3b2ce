"""A first scene of a motor, sized by rules of thumb that its own comments state."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import fem
from studies.model.contact_moduli import pair_moduli
from studies.model.scene_errors import as_run_errors, input_errors
from studies.model.solid_of_material import named_solid
from studies.record.quantities import quantity
from studies.refusal import RunError, SceneError, refuse_if, shown
from studies.runs import run
from studies.scene import Scene
from studies.scene.numbers import Quantity
from studies.scene.quantity import si_value
from studies.scene.slider_keys import Slider
from studies.scene.stator_keys import ORIENTATION
from studies.scene.toml import document

# Material of a cut that is named without one, and pairs of fingers of usual motors
CUTS = {"128YX": "LiNbO3", "YZ": "LiNbO3", "64YX": "LiNbO3", "X112Y": "LiTaO3", "ST-X": "quartz"}
PAIRS, PAIRS_OF_CERAMICS, PAIRS_OF_WEAK = 20, 10, 60
WEAK = 0.01  # coupling K^2 below which a transducer needs more fingers
# In wavelengths: aperture, from the transducer to the slider, from the ends to the transducers, thickness
APERTURE, AWAY, MARGIN, THICKNESS = 20.0, 40.0, 15.0, 5.0
SIDES = 1.6  # width of the stator over the aperture
FRICTION = 0.18  # steel on lithium niobate (Kurosawa, Takahashi and Higuchi 1998)
OF_FRICTION = "steel on lithium niobate, Kurosawa et al. 1998: measure yours"
RISE = 10e-9  # m: normal amplitude of a motor without a wanted speed
SHARE_OF_CREST = 0.5  # speed of a slider over that of the wave's crests, where it presses half of its time
PRESSED = 0.5  # approach of a ball at rest over the normal amplitude
# Force at the stall over mu times the preload: of balls that hop, and of pillars, which load the wave
SHARE_OF_FRICTION, SHARE_OF_PILLARS = 0.9, 0.75
BALLS, PILLARS = "steel", "silicon"
RADIUS, SLENDER = 1e-3, 16.0  # largest radius of a ball in m, and the aperture over the largest radius
PITCH = 3.0  # distance of neighbouring balls, in radii
# Pillars of published motors: diameter in m and at most in wavelengths, height and least pitch over it; the chip, m
PILLAR, PILLAR_OF_WAVE, PILLAR_HEIGHT, PILLAR_PITCH, CHIP = 20e-6, 0.05, 0.1, 2.0, 0.5e-3
SPREAD = 0.4  # wavelengths: largest pitch of pillars, whose stiffness over their area makes the wave faster
BEAM = 0.5  # part of the aperture over which the balls stand, and of the way to the fingers on both sides of the centre
DAMPED = 0.1  # of the bounce, over its critical damping
SAMPLES = 8  # voltages
# What can be made: the longest block and the usual one, the narrowest fingers (a quarter of a wavelength) of optical
# lithography, and the smallest ball, m
LONGEST, USUAL, NARROWEST, SMALLEST_BALL = 1.0, 0.15, 0.3e-6, 0.1e-3
FINGER = 0.25  # wavelengths: width of a finger at a metallisation of 0.5
ROUGH = 1e-2  # tolerance of the wave that sizes the voltage


@dataclass(frozen=True, kw_only=True)
class FirstScene:
    """A scene that runs, and why its numbers are what they are.

    Attributes
    ----------
    table : dict
        The scene's TOML document.
    reasons : dict of str to str
        The rule of each key, by dotted key.
    remarks : tuple of str
        Lines for the head of the file.
    unusual : tuple of str
        Those of them about sizes that are hard to get.
    """

    table: dict
    reasons: dict[str, str]
    remarks: tuple[str, ...]
    unusual: tuple[str, ...] = ()

    @property
    def scene(self) -> Scene:
        """The scene."""
        return Scene.from_table("", self.table)

    def __str__(self) -> str:
        """Return the file's text, each line with its rule."""
        return document(self.table, remarks=self.remarks, beside=self.reasons)


def first_scene(
    frequency: float | str, material: str, *, speed: float | str | None = None, thrust: float | str | None = None
) -> FirstScene:
    """Return a motor for a frequency and a material.

    Parameters
    ----------
    frequency : float or str
        Hz, or with a unit.
    material : str
        A catalogue name, with a cut behind it where it has several ("LiNbO3 128YX"), a cut alone ("128YX"), or a file.
    speed : float or str, optional
        Wanted without a load, m/s or with a unit.
    thrust : float or str, optional
        Wanted at the stall, N or with a unit.

    Raises
    ------
    SceneError
        If a value is refused, the material is not piezoelectric, or neither balls nor pillars on the beam bear the
        force.

    Examples
    --------
    >>> motor = first_scene("2.2 MHz", "PZT-8")
    >>> motor.table["transducer"][0]["aperture"], motor.scene.frequency
    ('20 mm', 2200000.0)
    """
    written, frequency = frequency, _read("--frequency", frequency, "Hz")
    name, cut, solid = _cut(material)
    with as_run_errors():
        wave = fem.rayleigh(solid, fem.surface_named("vacuum"))
    refuse_if(
        "phi" not in wave.fields, "--material", f"must be piezoelectric, and {solid.name} is not in this orientation"
    )
    wavelength, ratio = wave.velocity / frequency, abs(wave.surface_ratio)
    ceramic = cut == "Z"
    pairs = PAIRS_OF_CERAMICS if ceramic else PAIRS if fem.coupling(solid) > WEAK else PAIRS_OF_WEAK
    length_of = pairs * wavelength
    center, place = MARGIN * wavelength + 0.5 * length_of, MARGIN * wavelength + length_of + AWAY * wavelength
    _refuse_what_cannot_be_made(frequency, wavelength, 2.0 * place, solid.name)
    aperture = _round(APERTURE * wavelength)
    table: dict = {
        "title": f"First motor: {quantity.frequency_Hz.with_unit(frequency)} on {solid.name}",
        "stator": {
            "material": name, "orientation": cut, "length": _length(2.0 * place),
            "thickness": _length(THICKNESS * wavelength),
            "width": _length(SIDES * aperture), "ends": "absorbing", "bottom": "absorbing",
        },
        "transducer": [
            {
                "name": "left", "center": _length(center), "finger_pairs": pairs, "period": "auto",
                "metallisation": 0.5, "aperture": _length(aperture),
            },
        ],
        "drive": {"frequency": written, "transducer": "left", "voltage": 1.0},
    }  # fmt: skip
    amplitude, of_speed = RISE, ", as in published motors"
    if speed is not None:
        amplitude = _read("--speed", speed, "m/s") / (SHARE_OF_CREST * 2.0 * math.pi * frequency * ratio)
        speed = _with_unit(speed, "m/s")
        of_speed = f": {speed} is {SHARE_OF_CREST:g} of 2 pi f u_x, the speed of the wave's crests"
    slider, why = _slider(solid, wavelength, aperture, amplitude, thrust)
    table["slider"] = {"position": _length(place)} | slider
    volts = _volts(table, amplitude)
    table["drive"]["voltage"] = [f"{volts * (k + 1) / (SAMPLES - 2):.3g} V" for k in range(SAMPLES)]
    of_wave = f"{wavelength * 1e3:.4g} mm, the wavelength of {wave.velocity:.0f} m/s"
    reasons = {
        "stator.length": f"slider in the middle, {AWAY:g} wavelengths from the fingers",
        "stator.thickness": f"{THICKNESS:g} wavelengths: little of the wave reaches the bottom",
        "stator.width": f"{SIDES:g} times the aperture",
        "stator.ends": "glue or wax at both ends; absent: free, with a standing wave",
        "stator.bottom": "glued to a base that absorbs; absent: free, and waves that it reflects make the speed uneven",
        "transducer.0.center": f"{MARGIN:g} wavelengths from the end, {of_wave}",
        "transducer.0.finger_pairs": "as in published motors"
        if pairs < PAIRS_OF_WEAK
        else "many: the coupling is weak",
        "transducer.0.period": "the one that gives the strongest wave",
        "transducer.0.aperture": f"{APERTURE:g} wavelengths: the beam stays together up to the slider",
        "drive.voltage": f"{volts:.3g} V give {amplitude * 1e9:.3g} nm under the slider{of_speed}",
    } | why
    wanted = [f"{_with_unit(written, 'Hz')} on {material}"]
    wanted += [f"{speed} without a load"] if speed is not None else []
    wanted += [f"{_with_unit(thrust, 'N')} at the stall"] if thrust is not None else []
    unusual = tuple(hard_to_get(2.0 * place, slider))
    remarks = (
        "A first motor, sized by rules of thumb: what a measurement or a data sheet says is better than each of them.",
        f"Wanted: {', '.join(wanted)}.",
        "sawmotor run FILE computes it; sawmotor design FILE searches better numbers within ranges.",
        *unusual,
    )
    return FirstScene(table=table, reasons=reasons, remarks=remarks, unusual=unusual)


def _refuse_what_cannot_be_made(frequency: float, wavelength: float, length: float, name: str) -> None:
    """Raise a SceneError for a frequency at which the rules give a block, or fingers, that nobody makes."""
    finger = FINGER * wavelength
    got, lowest, highest = (
        quantity.frequency_Hz.with_unit(_round(each, 3))
        for each in (frequency, frequency * length / LONGEST, frequency * finger / NARROWEST)
    )
    refuse_if(
        length > LONGEST, "--frequency",
        f"must be at least {lowest} on {name}, got {got}: by the rules the stator would be {length:.3g} m long, "
        f"and they hold up to {LONGEST:g} m",
    )  # fmt: skip
    refuse_if(
        finger < NARROWEST, "--frequency",
        f"must be at most {highest} on {name}, got {got}: a finger would be {finger * 1e9:.3g} nm wide, and optical "
        f"lithography makes {NARROWEST * 1e9:g} nm",
    )  # fmt: skip


def hard_to_get(length: float, slider: dict) -> Iterator[str]:
    """Yield a line for each size by the rules that is hard to get."""
    if length > USUAL:
        yield f"The stator is longer than usual blocks and wafers of {USUAL * 1e3:g} mm: put the slider nearer."
    if "radius" in slider and (radius := si_value("", slider["radius"], "m")) < SMALLEST_BALL:
        yield (
            f"Balls of {radius * 1e6:.3g} um are smaller than bearing balls: published motors of such frequencies have "
            "sliders of silicon pillars (sawmotor scenes --copy silicon-slider)."
        )


def _read(option: str, value, unit: str) -> float:
    """Return a positive quantity of an option in SI units."""
    negative = isinstance(value, str) and value.strip().startswith("-")
    refuse_if(negative, option, f"must be positive, got {shown(value)}")
    return Quantity(unit).read(option, si_value(option, value, unit))


def _with_unit(value: float | str, unit: str) -> str:
    return value if isinstance(value, str) else f"{value:g} {unit}"


def _cut(text: str) -> tuple:
    """Return the name of a material, its orientation and the rotated solid."""
    name, cut = (CUTS[text], text) if text in CUTS else (text, "Z")
    try:
        material, solid = named_solid(name)
    except (SceneError, fem.InputError) as refusal:
        name, space, cut = text.rpartition(" ")
        try:
            material, solid = named_solid(name if space else text)
        except (SceneError, fem.InputError):
            hint = '; a cut stands behind its material, as in "LiNbO3 127YX"'
            raise SceneError("--material", f"{getattr(refusal, 'rule', refusal)}{hint}") from None
    with input_errors("--material"):
        rotated = fem.rotated(solid, ORIENTATION.read("--material", cut))
    return material if isinstance(material, str) else name, cut, rotated


def _slider(solid, wavelength: float, aperture: float, amplitude: float, thrust) -> tuple[dict, dict]:
    """Return the slider's block and the rules of its keys; lengths in m.

    Balls, or pillars where the balls that a thrust needs do not fit on the beam.
    """
    radius, approach = min(RADIUS, _round(aperture / SLENDER)), PRESSED * amplitude
    per_ball = 4.0 / 3.0 * pair_moduli(BALLS, solid)[0] * math.sqrt(radius) * approach**1.5
    rows, columns = (int(BEAM * length / (PITCH * radius)) + 1 for length in (aperture, 2.0 * AWAY * wavelength))
    preload, rule, balls = 3.0 * per_ball, None, 3
    if thrust is not None:
        wanted = _read("--thrust", thrust, "N")
        preload, rule = _preload(wanted, SHARE_OF_FRICTION)
        balls = max(3, math.ceil(preload / per_ball))
        if balls > rows * columns:
            return _pillars(solid, wavelength, aperture, approach, wanted)
    along = (2 * math.ceil(2.0 * PITCH * radius / wavelength - 0.5) + 1) * wavelength / 4.0
    places = ball_places(balls, rows, along, PITCH * radius)
    return _balls(radius, places, preload, approach, rule)


def _preload(thrust: float, share: float) -> tuple[float, str]:
    """Return the preload for a thrust at the stall, both in N, and its rule."""
    return thrust / (share * FRICTION), f"{thrust * 1e3:.3g} mN over {share:g} mu"


def _pillars(solid, wavelength: float, aperture: float, approach: float, thrust: float) -> tuple[dict, dict]:
    """Return the block and the rules of a slider on pillars for a thrust in N; lengths in m."""
    diameter = _round(min(PILLAR, PILLAR_OF_WAVE * wavelength))
    preload, rule = _preload(thrust, SHARE_OF_PILLARS)
    per_pillar = pair_moduli(PILLARS, solid)[0] * diameter * approach  # flat punch, P = 2 a E* z
    side = math.ceil(math.sqrt(preload / per_pillar))
    fits = int(BEAM * aperture / (PILLAR_PITCH * diameter))
    refuse_if(
        side > fits, "--thrust",
        f"must be at most {SHARE_OF_PILLARS * FRICTION * per_pillar * fits**2:.2g} N here, got {thrust:g} N: "
        f"{side} x {side} pillars that approach by {approach * 1e9:.2g} nm each, of which {fits} x {fits} fit on the "
        "beam",
    )  # fmt: skip
    pitch = max(PILLAR_PITCH * diameter, min(SPREAD * wavelength, BEAM * aperture / side))
    block = {
        "ball": PILLARS, "mass": f"{(side * pitch) ** 2 * CHIP * fem.material(PILLARS).density * 1e3:.3g} g",
        "preload": f"{preload:.3g} N", "friction_coefficient": FRICTION,
        "pillars": {
            "diameter": _micrometres(diameter), "height": _micrometres(PILLAR_HEIGHT * diameter),
            "pitch": _micrometres(pitch), "rows": side, "columns": side,
        },
    }  # fmt: skip
    why = {
        "slider.mass": f"a chip of silicon of {CHIP * 1e3:g} mm",
        "slider.preload": f"{rule}, by a spring",
        "slider.friction_coefficient": OF_FRICTION,
        "slider.pillars.diameter": f"as in published motors, at most {PILLAR_OF_WAVE:g} of a wavelength",
        "slider.pillars.height": "equal heights: measure their scatter, and give it as height_scatter",
        "slider.pillars.pitch": f"over half the aperture, at most {SPREAD:g} of a wavelength: they load the wave less",
        "slider.pillars.rows": f"with the columns {side**2} pillars: each approaches by half the amplitude, "
        f"{approach * 1e9:.3g} nm; balls on the beam would not bear the preload",
    }
    return block, why


def _balls(radius: float, places: list, preload: float, approach: float, rule: str | None) -> tuple[dict, dict]:
    """Return the block and the rules of a slider on balls; ``rule`` is that of a preload in N for a thrust."""
    mass = _round(preload / Slider.gravity, 3)
    stiffness = 1.5 * preload / approach  # dP/dz = 1.5 P/z
    damping = 2.0 * DAMPED * math.sqrt(stiffness * mass)
    block = {
        "ball": BALLS, "radius": _length(radius),
        "contacts": places,
        "mass": f"{mass * 1e3:.3g} g", "preload": "weight", "friction_coefficient": FRICTION,
        "damping": {"normal": f"{damping:.2g} N s/m"},
    }  # fmt: skip
    goal = f"approaches by half the amplitude, {approach * 1e9:.3g} nm"
    why = {
        "slider.radius": f"at most 1 mm and 1/{SLENDER:g} of the aperture",
        "slider.contacts": f"{len(places)} balls"
        + (f", so that each {goal}" if rule else "")
        + ": [x, y] from the centre, columns an odd number of quarter wavelengths apart against a standing wave",
        "slider.preload": f"{preload * 1e3:.3g} mN: " + (rule or f"a ball at rest {goal}"),
        "slider.friction_coefficient": OF_FRICTION,
        "slider.damping.normal": "a tenth of critical for the bounce at rest",
    }
    return block, why


def ball_places(balls: int, rows: int, along: float, across: float) -> list[list[str]]:
    """Return [x, y] of balls about their centroid: a grid as square as fits ``rows``, with its distances in m."""
    columns = math.ceil(balls / min(rows, math.ceil(math.sqrt(balls))))
    each, more = divmod(balls, columns)
    sizes = [each + (column < more) for column in range(columns)]
    center = sum(column * size for column, size in enumerate(sizes)) / balls
    return [
        [_length((column - center) * along), _length((row - (size - 1) / 2) * across)]
        for column, size in enumerate(sizes)
        for row in range(size)
    ]


def _volts(table: dict, amplitude: float) -> float:
    """Return the voltage at which the wave has a normal amplitude in m under the slider."""
    record = run(Scene.from_table("", {key: table[key] for key in ("stator", "transducer", "drive")}), tolerance=ROUGH)
    if not record.points or not record.normal_amplitude[0] > 0.0:
        raise RunError(f"the stator gives no wave to size the voltage by: {record.shortfall}")
    return amplitude / float(record.normal_amplitude[0])


def _round(value: float, digits: int = 2) -> float:
    return float(f"{value:.{digits}g}")


def _micrometres(value: float) -> str:
    return f"{value * 1e6:.3g} um"


def _length(value: float) -> str:
    return f"{value * 1e3:.3g} mm"
