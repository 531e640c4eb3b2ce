"""The reference of all keys: current, complete, and its example is a scene."""

import tomllib

import fem
from studies.model.fem_objects import solid
from studies.model.resolve import resolved
from studies.scene import Scene, shipped_scenes
from studies.scene.block import keys_of
from studies.scene.reference import BLOCKS, reference

PAGE = (shipped_scenes()["twente"].parent / "README.md").read_text(encoding="utf-8")


def test_the_reference_is_current():
    """It is written by ``python -m studies.scene.reference``."""
    assert reference() == PAGE


def test_every_key_and_every_material_has_its_row():
    for kind in BLOCKS.values():
        for name, key in keys_of(kind).items():
            assert f"| `{name}` |" in PAGE
            assert key.meaning.replace("|", "\\|") in PAGE
            assert key.meaning.endswith((".", "...")), name
    for name, material in fem.catalogue().items():
        assert f"| `{name}` |" in PAGE
        assert material.source in PAGE


def test_the_material_of_the_example_is_the_one_it_says():
    example = tomllib.loads(PAGE.partition("```toml")[2].partition("```")[0])
    block = resolved(Scene.from_table("", example)).stator
    mine, catalogue = solid(block), fem.material("PZT-8")
    for table in ("stiffness", "coupling", "permittivity"):
        one, other = getattr(mine, table), getattr(catalogue, table)
        assert abs(one - other).max() <= 1e-12 * abs(other).max()
    assert (mine.density, mine.mechanical_quality) == (7600.0, 800.0)
