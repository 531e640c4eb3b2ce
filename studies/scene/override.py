"""Changes of a scene from the command line: ``--set slider.mass=1e-4``, ``--over slider.mass=1e-4:2e-4:5``."""

import tomllib
from collections.abc import Iterator
from datetime import date, time
from typing import Any

from studies.refusal import SceneError, misread, refuse_repeated, refuse_unknown, shown


def toml_value(text: str):
    """Return a text as a TOML value; a text that is not TOML stays a string.

    Examples
    --------
    >>> toml_value("1e-4"), toml_value("[1, 2]"), toml_value("900 mm")
    (0.0001, [1, 2], '900 mm')
    >>> toml_value("10:50:20")
    '10:50:20'
    """
    try:
        document = tomllib.loads(f"value = {text}")
    except (tomllib.TOMLDecodeError, RecursionError, ValueError):
        return text
    value = document.get("value") if list(document) == ["value"] else text
    # 10:50:20 is a time of day in TOML, here START:STOP:N
    return text if isinstance(value, date | time) else value


def setting_of(text: str) -> tuple[str, object]:
    """Return key and value of ``KEY=VALUE``, the key a dotted path."""
    form = "KEY=VALUE with a dotted key"
    key, value = parts_of("--set", text, form)
    keys = [part.strip() for part in key.split(".")]
    if not all(keys):
        raise misread("--set", form, text)
    return ".".join(keys), toml_value(value)


def replaced(holder, key: str, value, path: str = ""):
    """Return a copy of a scene's table with the value at a dotted key replaced, entries of lists numbered from 0.

    None removes the key.

    ``path``: dotted key of the holder in the scene.
    """
    key, dot, rest = key.partition(".")
    here = f"{path}.{key}" if path else key
    if isinstance(holder, list):
        if not (key.isascii() and key.isdigit() and len(key) < 10 and int(key) < len(holder)):
            raise SceneError(here, f"is no entry of {path}: its {len(holder)} entries are numbered from 0")
        inner = replaced(holder[int(key)], rest, value, here) if dot else value
        return [inner if index == int(key) else entry for index, entry in enumerate(holder)]
    if isinstance(holder, dict):
        whole = holder | {key: replaced(holder.get(key, {}), rest, value, here) if dot else value}
        return {name: each for name, each in whole.items() if each is not None}
    raise SceneError(here, f"cannot be set: {path} is {shown(holder)} and holds no keys")


def merged(holder, changes):
    """Return a scene's table with changed keys; None removes a key, and blocks of a list are changed by their names."""
    if isinstance(changes, dict) and isinstance(holder, dict):
        whole = holder | {key: merged(holder.get(key), value) for key, value in changes.items()}
        return {key: value for key, value in whole.items() if value is not None}
    named = isinstance(holder, list) and all(isinstance(each, dict) and "name" in each for each in holder)
    if not (isinstance(changes, dict) and named):
        return changes
    names = [each["name"] for each in holder]
    for name in changes:
        refuse_unknown(name, names, "transducer", f"has none of the name {shown(name)}")
    return [merged(each, changes.get(each["name"], {})) for each in holder]


def value_at(table: dict, key: str):
    """Return the value at a dotted key of a scene's table; None where it has none."""
    at = table
    for part in key.split("."):
        try:
            at = at[int(part)] if isinstance(at, list) else at[part]
        except (KeyError, IndexError, TypeError, ValueError):
            return None
    return at


def walk(value, path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the dotted path and the value of every key and list entry inside a table."""
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in pairs:
        here = f"{path}.{key}" if path else str(key)
        yield here, inner
        yield from walk(inner, here)


def parts_of(option: str, text: str, form: str) -> tuple[str, str]:
    """Return key and value, as texts, of the ``KEY=VALUE`` of an option; ``form`` describes it in the refusal.

    Examples
    --------
    >>> parts_of("--over", "slider.preload=1 mN:5 mN:3", "KEY=LIST")
    ('slider.preload', '1 mN:5 mN:3')
    """
    key, sign, value = (part.strip() for part in text.partition("="))
    if not sign or not key:
        raise misread(option, form, text)
    return key, value


def read_axes(settings: list[str]) -> dict[str, str]:
    """Return the axes of ``--over KEY=VALUES``, values by key."""
    axes: dict[str, str] = {}
    for setting in settings:
        key, text = parts_of("--over", setting, "KEY=START:STOP:N or KEY=LIST")
        refuse_repeated([*axes, key], "--over")
        axes[key] = text
    return axes
