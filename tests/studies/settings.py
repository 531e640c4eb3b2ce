"""Settings of a scene's table, as ``--set KEY=VALUE`` makes them."""

from functools import reduce

from studies.scene.override import replaced, setting_of


def assigned(table: dict, *settings: str) -> dict:
    """Return a copy of a scene's table changed by settings ``KEY=VALUE``."""
    return reduce(lambda changed, setting: replaced(changed, *setting_of(setting)), settings, table)
