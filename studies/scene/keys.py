"""The rule of any key of a scene, by its dotted path, and the unit of its numbers."""

from studies.refusal import SceneError, nearest
from studies.scene.block import Blocks, OneOf, Within, keys_of
from studies.scene.rule import Count, Impedance, Listed, Place, Quantity
from studies.scene.scene import Scene


def rule_at(key: str):
    """Return the rule of a scene's key, its lists of blocks numbered from 0; SceneError if there is none."""
    kinds, done, parts = (Scene,), "", key.split(".")
    while parts:
        name = parts.pop(0)
        here = f"{done}.{name}" if done else name
        known = {name: one for kind in kinds for name, one in keys_of(kind).items()}
        if name not in known:
            raise SceneError(here, f"is no key of a scene{nearest(name, known)}")
        rule = known[name].rule
        if isinstance(rule, Blocks):
            if not parts or not parts[0].isdigit():
                raise SceneError(here, f"is a list: say which one, as in {here}.0")
            here, kinds = f"{here}.{parts.pop(0)}", (rule.kind,)
        elif isinstance(rule, Within):
            kinds = (rule.kind,)
        elif isinstance(rule, OneOf) and parts:
            kinds = rule.kinds
        elif parts:
            raise SceneError(key, f"is no key of a scene: {here} holds no keys")
        else:
            return rule
        if not parts:
            raise SceneError(here, f"is a block: name one of its keys{nearest('', ())}")
        done = here
    raise SceneError(key, "is no key of a scene")


def unit_of(rule) -> str | None:
    """Return the SI unit of a rule's numbers, None where it takes words."""
    if isinstance(rule, Listed):
        return unit_of(rule.alone or rule.each)
    if isinstance(rule, Quantity):
        return rule.unit
    if isinstance(rule, Place):
        return rule.along.unit
    return "ohm" if isinstance(rule, Impedance) else "" if isinstance(rule, Count) else None
