"""The reference of all keys of a scene, ``studies/scenes/README.md``, generated from the blocks and the catalogue.

``python -m studies.scene.reference`` writes it and the JSON Schema beside it.
"""

import json
from pathlib import Path

from studies.scene.block import Block, Blocks, Within, keys_of
from studies.scene.blocks import (
    Damping,
    Drive,
    IsotropicSolid,
    PiezoelectricSolid,
    Recovery,
    Slider,
    Stator,
    Transducer,
    Wave,
)
from studies.scene.file import SHIPPED, shipped_scenes
from studies.scene.scene import Scene
from studies.scene.schema import FILE_NAME, schema_text

BLOCKS = {
    "The file": Scene,
    "[stator]": Stator,
    "[[transducer]]": Transducer,
    "[drive]": Drive,
    "[drive.recovery]": Recovery,
    "[wave]": Wave,
    "[slider]": Slider,
    "[slider.damping]": Damping,
    "[stator.material], a piezoelectric crystal or ceramic": PiezoelectricSolid,
    "[stator.material], an isotropic solid": IsotropicSolid,
}
INTRODUCTION = """\
# Scenes

A scene is one TOML file: what is modelled, no more. A block that is absent is left out of the model.

    sawmotor scenes                            # the scenes that ship
    sawmotor scenes --copy twente motor.toml   # one of them, to start from
    sawmotor check motor.toml                  # every fault with its line, nothing is computed
    sawmotor run motor.toml

- A **quantity** is a number in the SI unit given below, or a string with a unit: `"2.2 MHz"`, `"0.267 g"`, `"5 mN"`.
  Any unit of the right dimension is read. A number needs a digit on both sides of its decimal point: `0.15`, not `.15`.
- **Several levels** are a list, `voltage = ["5 V", "10 V"]`, or a range: `voltage = "20:100:5"` is five values from 20
  to 100 V, `normal_amplitude = "1 nm:20 nm:10:log"` ten with even steps of the logarithm.
- **Amplitudes and voltages are peak values**; x runs along the surface from the stator's left end, z out of
  it.
- A key **without a default is required** when its block is there, unless its meaning says otherwise. `-` stands for no
  unit, or for a default that is the key's absence.
- A scene has `[stator]` and `[drive]`, perhaps `[[transducer]]` blocks and a `[slider]`; or, instead of those three,
  a given surface motion `[wave]` and a `[slider]`.
- One key is changed from the command line by `--set slider.mass=1e-4` or `--set transducer.1.center="900 mm"` (blocks
  of a list are numbered from 0), the voltages by `--voltage 5:60:12`.
- A **tolerance** is written with the value, `friction_coefficient = "0.08 +- 0.02"`, or in the block `[uncertain]`:
  `slider.preload = "+- 5 %"`, `slider.radius = "+- 2 um"`, `drive.voltage = "+- 2 %"` (of all levels). It holds the
  number with 95 % probability. A run then states 95 % bands of velocity, threshold and release: `method = "linear"`
  (default) adds half the differences between the ends of each tolerance in quadrature, which is wrong where the answer
  bends, as at the threshold; `method = "sampled"` takes percentiles of `samples = 500` points of a Latin hypercube. A
  number of the stator costs two solutions of it (linear), or one for each sample.
- An editor that knows JSON Schema completes and checks the keys: begin the file with `#:schema schema.json` and put the
  output of `sawmotor schema` beside it.

Refused as well: fingers beyond the stator or in each other, contacts beyond the stator, an aperture wider than the
stator, a driven transducer without fingers of both combs, `frequency = "center"` with `period = "auto"`, a burst that
would take more than an hour to follow.
"""
CUSTOM = """\
## A material of your own

Constants in the crystal frame, in the Voigt order 11 22 33 23 13 12 with engineering shear strain; the orientation
turns them. This is PZT-8 of the catalogue, written as a table, with a quality factor of its own:

```toml
[stator]
orientation = "Z"
length = "160 mm"
thickness = "5 mm"
width = "35 mm"
ends = "absorbing"

[stator.material]
name = "my ceramic"
density = "7.6 g/cm^3"
mechanical_quality = 800
dielectric_loss = 0.004
stiffness = [           # c^E, Pa
    [146.9e9,  81.1e9,  81.1e9,       0,       0,      0],
    [ 81.1e9, 146.9e9,  81.1e9,       0,       0,      0],
    [ 81.1e9,  81.1e9, 131.7e9,       0,       0,      0],
    [      0,       0,       0, 31.35e9,       0,      0],
    [      0,       0,       0,       0, 31.35e9,      0],
    [      0,       0,       0,       0,       0, 32.9e9],
]
coupling = [            # e, C/m^2
    [    0,     0,     0,     0, 10.34, 0],
    [    0,     0,     0, 10.34,     0, 0],
    [-3.88, -3.88, 13.91,     0,     0, 0],
]
permittivity = [        # eps^S over that of vacuum
    [904,   0,   0],
    [  0, 904,   0],
    [  0,   0, 562],
]

[drive]
frequency = "2.2 MHz"
```
"""


def reference() -> str:
    """Return the text of ``studies/scenes/README.md``."""
    parts = [INTRODUCTION]
    for header, kind in BLOCKS.items():
        name = f"`{header}`" if header.startswith("[") and "," not in header else header
        parts.append(f"## {name}\n\n{kind.__doc__.splitlines()[0]}\n\n{_keys(kind)}\n")
    parts += [f"## Materials\n\n{_materials()}\n", CUSTOM, f"## Scenes that ship\n\n{_shipped()}\n"]
    return "\n".join(parts)


def _keys(kind: type[Block]) -> str:
    rows = [("key", "unit", "default", "allowed", "meaning")]
    for name, key in keys_of(kind).items():
        default = "required" if key.required else _written(key.rule, key.default)
        rows.append((f"`{name}`", key.rule.unit_name or "-", default, _allowed(key.rule), key.meaning))
    return _table(rows)


def _allowed(rule) -> str:
    if isinstance(rule, (Within, Blocks)):
        return "a block" if isinstance(rule, Within) else "blocks"
    return rule.range


def _written(rule, default) -> str:
    if default in (None, (), "") or isinstance(default, Block):
        return "-"
    return f"`{json.dumps(rule.written(default))}`"


def _materials() -> str:
    from fem import catalogue

    rows = [("name", "kind", "density (kg/m^3)", "Q", "tan delta", "source")]
    for name, solid in catalogue().items():
        lossless = solid.mechanical_quality == float("inf")
        rows.append(
            (
                f"`{name}`",
                "piezoelectric" if solid.coupling.any() else "isotropic",
                f"{solid.density:g}",
                "lossless" if lossless else f"{solid.mechanical_quality:g}",
                f"{solid.dielectric_loss:g}",
                solid.source,
            )
        )
    text = (
        "`stator.mechanical_quality` and `stator.dielectric_loss` replace a material's own Q and tan delta. "
    )
    text += "Sets of constants of one material differ between authors by more than this program's errors.\n\n"
    return text + _table(rows)


def _shipped() -> str:
    rows = [("name", "title")] + [(f"`{name}`", Scene.load(name).title) for name in shipped_scenes()]
    return _table(rows)


def _table(rows: list[tuple[str, ...]]) -> str:
    lines = [" | ".join(("", *(cell.replace("|", "\\|") for cell in row), "")).strip() for row in rows]
    lines.insert(1, "|" + "---|" * len(rows[0]))
    return "\n".join(lines)


def write(folder: Path = SHIPPED) -> None:
    """Write the reference and the schema into the folder of the shipped scenes."""
    (folder / "README.md").write_text(reference(), encoding="utf-8")
    (folder / FILE_NAME).write_text(schema_text(), encoding="utf-8")


if __name__ == "__main__":
    write()
