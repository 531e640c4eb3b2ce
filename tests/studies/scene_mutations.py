"""Scenes that nobody would write: what ships, with keys gone, doubled and renamed, and values of any kind and size.

Three layers, as a user may go wrong: the table (keys and values), the file (bytes), the command line (``--set``).
"""

import datetime
import json
from dataclasses import dataclass

from hypothesis import strategies as st

from studies import SceneError, shipped_scenes
from studies.scene import Scene, read_table, stator_keys
from studies.scene.block import keys_of
from studies.scene.drive import Drive, Wave
from studies.scene.friction import Friction
from studies.scene.numbers import Quantity
from studies.scene.pillar_keys import Pillars
from studies.scene.quantity import POWERS, si_value
from studies.scene.slider_keys import Damping, Slider
from studies.scene.stator_keys import IsotropicSolid, Piece, PiezoelectricSolid, Stator, Transducer

BLOCKS = (
    Scene, Stator, PiezoelectricSolid, IsotropicSolid, Transducer, Piece, Drive, Wave, Slider, Damping, Friction,
    Pillars,
)  # fmt: skip
KEYS = sorted({name for block in BLOCKS for name in keys_of(block)})
WORDS = (
    "auto center weight half-space free grounded clamped absorbing none vacuum open short elastic hysteretic exact "
    "stepped averaged Z X YZ 128YX ST-X PZT-8 PIC181 steel left right + - +-o0"
).split()
UNITS = sorted({unit for units in POWERS.values() for unit in units})
ODD_UNITS = [
    "furlong",
    "9^9^9^9",
    "m/s/s",
    "dB",
    "degC",
    "rad/s",
    "ohm ohm",
    "%",
    "m^-1",
    "kg m^2/s^3/A",
    "Å",
    "m" * 99,
]
EXTREMES = [
    *(0, -0.0, 1, -1, 2, 10**9, 2**63, 10**400, -(10**30), 0.5, 1 - 2**-53, 1e-3, 1e-9, 1e-30, 1e-160, 5e-324, 1e9),
    *(1e30, 1e154, 1e160, 1.7e308, float("nan"), float("inf"), float("-inf")),
]
NUMBERS = st.one_of(st.sampled_from(EXTREMES), st.floats(), st.floats(0, 1), st.integers(-3, 40), st.integers())
QUANTITIES = st.builds("{} {}".format, NUMBERS, st.sampled_from(UNITS + ODD_UNITS))
TEXTS = st.one_of(st.sampled_from(WORDS), QUANTITIES, st.text(max_size=20))
SCALARS = st.one_of(NUMBERS, TEXTS, st.booleans(), st.just(datetime.date(2020, 1, 1)), st.just(datetime.time(1, 2)))
TREES = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=7), st.dictionaries(st.sampled_from([*KEYS, "", "a b", "ü"]), inner, max_size=4)
    ),
    max_leaves=12,
)
LONG = st.builds(lambda value, count: [value] * count, SCALARS, st.sampled_from([37, 500, 4000]))
VALUES = st.one_of(NUMBERS, QUANTITIES, TEXTS, TREES, LONG)
PLATE = {"material": "PZT-8", "length": "6 mm", "thickness": "0.6 mm", "width": "5 mm", "ends": "absorbing"}
COMB = {"name": "a", "center": "2 mm", "finger_pairs": 1, "metallisation": 0.5, "aperture": "5 mm"}
DRIVE = {"frequency": "2.2 MHz", "transducer": "a", "voltage": [3, 20]}
BALL = {
    "radius": "1 mm",
    "mass": "0.089 g",
    "contacts": 1,
    "preload": "weight",
    "friction_coefficient": 0.08,
    "effective_modulus": "64 GPa",
    "tangential_modulus": "12 GPa",
    "damping": {"normal": 0.5, "tangential": 1e-4},
}
GIVEN = {"frequency": "2.2 MHz", "normal_amplitude": ["3 nm", "10 nm"], "tangential_ratio": 0.7}
ISOTROPIC = {"youngs_modulus": "70 GPa", "poisson_ratio": 0.33, "density": 2700, "mechanical_quality": 500}


def crystal() -> dict:
    """A user's table of constants: hard PZT of the catalogue."""
    from fem import material

    solid = material("PZT-8")
    return {
        "stiffness": solid.stiffness.tolist(),
        "coupling": solid.coupling.tolist(),
        "permittivity": (solid.permittivity / 8.8541878188e-12).tolist(),
        "density": solid.density,
        "mechanical_quality": 1000,
        "dielectric_loss": 0.004,
    }


@dataclass(frozen=True, repr=False)
class Mutant:
    """A scene file and what is set on the command line."""

    content: bytes
    settings: tuple[str, ...] = ()

    def __repr__(self):
        return f"Mutant({self.content[:2000]!r}, {str(self.settings)[:500]})"

    @property
    def words(self) -> list[str]:
        """The settings as options."""
        return [word for setting in self.settings for word in ("--set", setting)]


def bases() -> list[dict]:
    """Tables to start from: what ships, and keys that it does not use."""
    found = [read_table(name) for name in shipped_scenes()]
    own = read_table("twente")
    own["stator"]["material"] = crystal()
    own["drive"] |= {"source_impedance": [50, 10], "burst": "1 ms"}
    own["transducer"][0] |= {"split": True, "period": "0.98 mm"}
    own["transducer"][1] |= {"pattern": "+-o0" * 5, "termination": "50 ohm"}
    own["slider"] |= {"contacts": ["-3 mm", "4 mm"], "law": "hysteretic", "method": "exact", "gravity": 9.81}
    elastic = read_table("rayleigh")
    elastic["stator"] |= {"material": ISOTROPIC, "bottom": "absorbing", "above": "vacuum", "orientation": [0, 38, 0]}
    ball = read_table("twente-left")
    del ball["slider"]["effective_modulus"], ball["slider"]["tangential_modulus"]
    ball["slider"] |= {"ball": "steel", "reciprocal": True, "stick_band": 0, "load": "1 uN"}
    return [*found, own, elastic, ball]


SMALL = [  # seconds at most, whatever one or two keys become
    {"stator": PLATE, "transducer": [COMB], "drive": DRIVE},
    {
        "stator": PLATE | {"bottom": "grounded", "ends": "free"},
        "transducer": [COMB, COMB | {"name": "b", "center": "4 mm"}],
        "drive": DRIVE,
        "slider": BALL | {"position": "3 mm"},
    },
    {
        "stator": PLATE | {"thickness": "half-space", "above": "vacuum"},
        "transducer": [COMB],
        "drive": DRIVE | {"source_impedance": "50 ohm"},
    },
    {"stator": PLATE, "drive": {"frequency": "2.2 MHz"}},
    {"stator": PLATE | {"material": ISOTROPIC}, "drive": {"frequency": "2.2 MHz"}},
    {"wave": GIVEN, "slider": BALL},
    {"wave": GIVEN | {"burst": "20 us"}, "slider": BALL | {"law": "hysteretic"}},
]


def stress_bases() -> list[dict]:
    """More small scenes: a user's crystal under a burst, a cut of lithium niobate on an absorbing bottom."""
    niobate = PLATE | {"material": "LiNbO3 (Warner)", "orientation": "YZ", "bottom": "absorbing"}
    return [
        {
            "stator": PLATE | {"material": crystal()},
            "transducer": [COMB | {"period": "0.98 mm"}],
            "drive": DRIVE | {"burst": "20 us"},
            "slider": BALL | {"position": "4 mm"},
        },
        {"stator": niobate, "transducer": [COMB], "drive": DRIVE},
    ]


def holders(table) -> list:
    """Every table and list inside a table, itself included."""
    inner = table.values() if isinstance(table, dict) else table
    return [table, *(deep for each in inner if isinstance(each, (dict, list)) for deep in holders(each))]


def changed(draw, table: dict) -> None:
    """Mutate one place of a table."""
    holder = draw(st.sampled_from(holders(table)))
    places = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
    kind = draw(st.sampled_from(["value", "value", "value", "gone", "renamed", "added", "doubled", "wrapped"]))
    if kind == "added" or not places:
        value = draw(VALUES)
        if isinstance(holder, dict):
            holder[draw(st.one_of(st.sampled_from(KEYS), st.text(max_size=8)))] = value
        else:
            holder.append(value)
        return
    place = draw(st.sampled_from(places))
    if kind == "value":
        holder[place] = draw(VALUES)
    elif kind == "gone":
        del holder[place]
    elif kind == "wrapped":
        holder[place] = [holder[place]]
    elif kind == "doubled" and isinstance(holder, list):
        holder.insert(place, holder[place])
    elif isinstance(holder, dict):
        name = draw(st.one_of(st.sampled_from(KEYS), st.just(str(place)[:-1]), st.just(str(place).upper())))
        holder[name] = holder[place] if kind == "doubled" else holder.pop(place)


def toml(value) -> str:
    """One line of TOML for any value."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {toml(each)}" for key, each in value.items()) + "}"
    return value.isoformat() if hasattr(value, "isoformat") else repr(value)


@st.composite
def tables(draw, start: list[dict] | None = None, most: int = 3) -> dict:
    """A table with one to ``most`` mutations."""
    table = json.loads(json.dumps(draw(st.sampled_from(start or bases()))))
    for _ in range(draw(st.integers(1, most))):
        changed(draw, table)
    return table


def document(table: dict) -> bytes:
    """Bytes of a table's file."""
    lines = [f"{json.dumps(key)} = {toml(value)}" for key, value in table.items()]
    return "\n".join(lines).encode()


@st.composite
def settings(draw) -> str:
    """What may stand behind ``--set``."""
    if draw(st.integers(0, 4)) == 0:
        return draw(st.text(max_size=30))
    part = st.one_of(st.sampled_from(KEYS), st.sampled_from(["0", "1", "-1", "9", "0x1", "٣", ""]))
    path = ".".join(draw(st.lists(part, min_size=1, max_size=4)))
    value = draw(VALUES)
    return f"{path}={value if isinstance(value, str) else toml(value)}"


@st.composite
def spoilt(draw) -> bytes:
    """A scene's file with bytes cut out, put in, doubled or changed."""
    content = bytearray(draw(st.sampled_from(sorted(shipped_scenes().values()))).read_bytes())
    for _ in range(draw(st.integers(1, 3))):
        start = draw(st.integers(0, len(content)))
        stop = min(len(content), start + draw(st.integers(0, 60)))
        kind = draw(st.sampled_from(["cut", "put", "doubled", "line", "end", "noise"]))
        if kind == "cut":
            del content[start:stop]
        elif kind == "put":
            content[start:start] = draw(st.binary(max_size=12))
        elif kind == "doubled":
            content[start:start] = content[start:stop]
        elif kind == "line":
            lines = content.splitlines(keepends=True)
            content += draw(st.sampled_from(lines)) if lines else b""
        elif kind == "end":
            del content[start:]
        else:
            content[start:stop] = draw(st.binary(min_size=stop - start, max_size=stop - start))
    return bytes(content)


@st.composite
def mutants(draw) -> Mutant:
    """A scene nobody would write."""
    content = draw(st.one_of(tables().map(document), tables().map(document), spoilt()))
    return Mutant(content, tuple(draw(st.lists(settings(), max_size=2))))


CHOICES = {
    "orientation": [*stator_keys.ORIENTATION.words, [10, 20, 30], [0, 0, 0], [0, 90, 0]],
    "material": ["PZT-8", "PIC181", "LiNbO3 (Warner)", "quartz (Bechmann)", "steel", ISOTROPIC],
    "bottom": ["free", "grounded", "clamped", "absorbing"],
    "ends": ["absorbing", "free", "clamped"],
    "above": ["none", "vacuum"],
    "thickness": ["half-space"],
    "period": ["auto"],
    "termination": ["open", "short", 0, "50 ohm", [0, 50]],
    "source_impedance": [0, "50 ohm", [0, -50], 1e9],
    "split": [True, False],
    "frequency": ["center"],
    "preload": ["weight", 0],
    "contacts": [1, 3, ["0 mm"], ["-1 mm", "1 mm"]],
    "law": ["elastic", "hysteretic"],
    "reciprocal": [True, False],
    "method": ["auto", "exact", "stepped", "averaged"],
    "burst": [1e-6, 1e-3],
    "voltage": [0, 1, [0, 1e-3, 1e3], 1e6],
    "finger_pairs": [1, 2, 7],
}
SIZES = st.one_of(
    st.floats(-3, 3).map(lambda decades: ("times", 10.0**decades)),
    st.floats(0.5, 2).map(lambda factor: ("times", factor)),
    st.sampled_from([("is", 0), ("is", 5e-324), ("is", 1e-200), ("is", 1e200), ("is", 1.7e308), ("is", 1.0)]),
)
KNOWN = {  # rules by key, whatever the block
    name: key.rule for block in BLOCKS for name, key in keys_of(block).items()
}


@st.composite
def extreme_tables(draw, start: list[dict], most: int = 4) -> dict:
    """A table whose keys are sound and whose values are not all sensible."""
    table = json.loads(json.dumps(draw(st.sampled_from(start))))
    for _ in range(draw(st.integers(1, most))):
        known = [each for each in holders(table) if isinstance(each, dict) and KNOWN.keys() & each.keys()]
        holder = draw(st.sampled_from(known))
        key = draw(st.sampled_from(sorted(KNOWN.keys() & holder.keys())))  # the keys of [drive.sources] are names
        rule, value = KNOWN[key], holder[key]
        if key in CHOICES and draw(st.booleans()):
            holder[key] = draw(st.sampled_from(CHOICES[key]))
        elif isinstance(rule.number, Quantity) and not rule.each and value not in list(rule.words):
            kind, size = draw(SIZES)
            try:
                holder[key] = size if kind == "is" else si_value(key, value, rule.number.unit) * size
            except SceneError:
                holder[key] = size
    return table
