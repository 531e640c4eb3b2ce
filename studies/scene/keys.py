"""The rule and unit of any key of a scene by its dotted path, and the tolerances of a scene's numbers."""

from studies.refusal import SceneError, misread, nearest
from studies.scene.block import Blocks, Within, keys_of
from studies.scene.override import value_at
from studies.scene.rule import Count, Named, Rule
from studies.scene.scene import Scene
from studies.scene.uncertain import OPTIONS, Tolerance, half_width

# Last names of keys that are coordinates, whose origin is arbitrary: the unit of their changes, and its SI value
COORDINATES = {"center": ("um", 1e-6), "position": ("um", 1e-6), "angle": ("deg", 1.0)}
LEVELS = ("drive.voltage", "drive.power", "wave.normal_amplitude")


def coordinate(key: str) -> tuple[str, float] | None:
    """Return the unit in which changes of a coordinate are stated, and its SI value; None for another key.

    A share of a coordinate has no meaning, because its origin is arbitrary.

    Examples
    --------
    >>> coordinate("transducer.1.center"), coordinate("slider.mass")
    (('um', 1e-06), None)
    """
    names = [name for name in key.split(".") if not name.isdigit()]
    return COORDINATES.get(names[-1]) if len(names) > 1 else None


def rule_at(key: str) -> Rule:
    """Return the rule of a scene's key, lists of blocks numbered from 0, values in a table by their names.

    Raises
    ------
    SceneError
        For an unknown key.
    """
    rule: Rule = Within(Scene)
    path, parts = "", key.split(".")
    while parts:
        holder = next((each for each in getattr(rule, "rules", (rule,)) if isinstance(each, (Blocks, Within))), None)
        named = next((each for each in getattr(rule, "rules", (rule,)) if isinstance(each, Named)), None)
        if named is not None:
            name, *parts = parts
            path, rule = f"{path}.{name}", named.value
            continue
        if holder is None:
            raise SceneError(key, f"is no key of a scene: {path} holds no keys")
        if isinstance(holder, Blocks):
            index, *parts = parts
            if not index.isdigit() or not parts:
                first = next(iter(keys_of(*holder.kinds)))
                raise SceneError(path, f"is a list: say which one and its key, as in {path}.0.{first}")
            path = f"{path}.{index}"
        name, *parts = parts
        known = {name: one for kind in holder.kinds for name, one in keys_of(kind).items()}
        path = f"{path}.{name}" if path else name
        if name not in known:
            raise SceneError(path, f"is no key of a scene{nearest(name, known)}")
        rule = known[name].rule
    if isinstance(rule, (Blocks, Within)):
        raise SceneError(path, "is a block: name one of its keys")
    return rule


def unit_of(rule: Rule) -> str | None:
    """Return the SI unit of a rule's single number, None where it takes none."""
    return rule.number.unit if rule.number else None


def tolerances(scene: Scene) -> tuple[Tolerance, ...]:
    """Return the tolerances of a resolved scene; refuse keys that are no number, and intervals beyond a key's rule."""
    numbers, table = [], scene.to_table()
    for key, text in scene.uncertain or ():
        path = f"uncertain.{key}"
        if key in OPTIONS:
            continue
        try:
            rule = rule_at(key)
        except SceneError as error:
            raise error.moved("", "uncertain.") from None
        if key in LEVELS:
            if getattr(scene, key.split(".")[0]) is None:
                raise SceneError(path, "must be the key of a level that this scene has")
            if not isinstance(text, str) or not text.rstrip().endswith("%"):
                raise misread(path, "a percentage, common to all levels", text)
            numbers.append(Tolerance(key, 1.0, half_width(path, text, 1.0, "")))
            continue
        value, unit = value_at(table, key), unit_of(rule)
        if isinstance(rule.number, Count) or unit is None or not isinstance(value, (int, float)):
            raise misread(path, "the key of a number that this scene has", value)
        size = half_width(path, text, value, unit)
        for end in (value - size, value + size):
            rule.read(f"{path}, an end of whose interval, {end:g},", end)
        numbers.append(Tolerance(key, float(value), size))
    return tuple(numbers)
