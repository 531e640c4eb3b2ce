"""Errors of ``fem`` and ``contact`` as errors of a run, or about the scene's own keys."""

from collections.abc import Iterator
from contextlib import contextmanager

import contact
import fem
from studies.refusal import RunError, SceneError


@contextmanager
def as_run_errors(where: str = "") -> Iterator[None]:
    """Turn a solver's `ConvergenceError` into a `RunError`; its message begins with ``where``."""
    try:
        yield
    except (fem.ConvergenceError, contact.ConvergenceError) as error:
        raise RunError(" ".join(f"{where} {error}".split())) from None
    except contact.InputError as error:
        if error.key != "slider.freedom":
            raise
        raise SceneError(
            error.key, "of a slider in the plane has no answer here: it is that of motion along x"
        ) from None


@contextmanager
def input_errors(key: str = "") -> Iterator[None]:
    """Turn an `InputError` of ``fem`` or ``contact`` into a `SceneError` with the same rule, about ``key`` if given."""
    try:
        yield
    except (fem.InputError, contact.InputError) as error:
        raise SceneError(key or error.key, error.rule) from None


@contextmanager
def stator_keys(path: str, names=(), pieces=()) -> Iterator[None]:
    """Turn an `fem.InputError` into a `SceneError` about the scene's key; otherwise as `as_run_errors`.

    ``path``: key of the block that is read; ``names``, ``pieces``: names of the transducers and of the meshed pieces.
    """
    try:
        with as_run_errors():
            yield
    except fem.InputError as error:
        key, rule = error.key, error.rule
        if error.owner in names:
            key = key.replace("transducer", f"transducer.{names.index(error.owner)}", 1)
        if key.startswith("piece") and error.owner in pieces:
            key = key.replace("piece", f"piece.{pieces.index(error.owner)}", 1)
            rule = f'("{error.owner}") {rule}'
        if not key.startswith(("stator.", "transducer", "piece")):
            key = path if f".{path}".endswith(f".{key}") else f"{path}.{key}"
        raise SceneError(key, rule) from None
    except ValueError as error:
        raise SceneError(path, str(error).splitlines()[0]) from None


@contextmanager
def slider_keys() -> Iterator[None]:
    """Turn a `contact.InputError` about a slider, or its load on the wave, into a `SceneError` about the key."""
    try:
        yield
    except contact.InputError as error:
        key = {"wave.loading": "slider.loading", "sample": "slider.roughness"}.get(error.key, error.key)
        key = key if "." in key and not key.startswith(("roughness.", "adhesion.")) else f"slider.{key}"
        if not key.startswith("slider."):
            raise
        raise SceneError(key, error.rule) from None
