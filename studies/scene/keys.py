"""The rule of any key of a scene, by its dotted path, and the unit of its numbers."""

from studies.refusal import SceneError, nearest
from studies.scene.block import Blocks, Within, keys_of
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
        inner = next(
            (part for part in getattr(rule, "rules", (rule,)) if isinstance(part, (Blocks, Within))), None
        )
        if isinstance(inner, Blocks) and (parts or inner is rule):
            if not parts or not parts[0].isdigit():
                raise SceneError(here, f"is a list: say which one, as in {here}.0")
            here, kinds = f"{here}.{parts.pop(0)}", (inner.kind,)
        elif inner is not None and (parts or inner is rule):
            kinds = inner.kinds
        elif parts:
            raise SceneError(key, f"is no key of a scene: {here} holds no keys")
        else:
            return rule
        if not parts:
            raise SceneError(here, f"is a block: name one of its keys{nearest('', ())}")
        done = here
    raise SceneError(key, "is no key of a scene")


def unit_of(rule) -> str | None:
    """Return the SI unit of a rule's single number, None where it takes none."""
    return rule.number and rule.number.unit
