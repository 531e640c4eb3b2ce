"""Bad input that ``contact`` refuses, as a refusal of the scene's own keys."""

from collections.abc import Iterator
from contextlib import contextmanager

import contact
from studies.refusal import SceneError


@contextmanager
def slider_keys() -> Iterator[None]:
    """Turn an input error about a slider, or its pillars, into a `SceneError` about the scene's key."""
    try:
        yield
    except contact.InputError as error:
        key = error.key.replace("pillars.", "slider.", 1)
        key = key if "." in key else f"slider.{key}"
        if not key.startswith("slider."):
            raise
        raise SceneError(key, error.rule) from None
