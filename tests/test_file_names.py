"""The base name of a file says alone what the file holds, and an enumeration of the contact has one name and place."""

import re
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[1]
# both libraries have their own exceptions
BOTH = {"exceptions"}
ENUMERATION = re.compile(r"^class (\w+)\((?:Int|Str)?Enum\):", re.MULTILINE)


def product_files() -> list[Path]:
    """Return the modules of the product, without packages' ``__init__``, examples and scripts of meshes."""
    return [
        path.relative_to(ROOT)
        for folder in ("fem", "contact", "studies")
        for path in sorted((ROOT / folder).rglob("*.py"))
        if not path.stem.startswith("__") and not {"examples", "meshes"} & {*path.parts}
    ]


def twice(names: list[str]) -> list[str]:
    """Return the names that occur more than once."""
    return sorted(name for name, count in Counter(names).items() if count > 1)


def test_no_file_name_stands_twice():
    assert set(twice([path.stem for path in product_files()])) <= BOTH
    assert twice(["wave", "orbit", "wave"]) == ["wave"]


def test_no_enumeration_of_the_contact_has_the_name_of_another():
    sources = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "contact").rglob("*.py"))]
    names = [name for text in sources for name in ENUMERATION.findall(text)]
    assert len(names) > 20
    assert twice(names) == []
