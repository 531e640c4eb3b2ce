"""What a command prints, and the directory that its results go to."""

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from studies.refusal import InterruptedRunError, RunError
from studies.results import Origin, ResultDirectory, result_directory
from studies.scene import Scene, scene_path, shipped_scenes


def origin_of(kind: str, scene: str) -> Origin:
    """Return the origin of a result of a scene: name, and file unless it is shipped."""
    path = scene_path(scene)
    ships = path == shipped_scenes().get(path.stem)
    return Origin(kind=kind, name=path.stem, source=None if ships else path)


def results_folder(arguments: argparse.Namespace, name: str) -> Path:
    """Return the directory of ``--out``, or results/NAME."""
    return Path(arguments.out or Path("results") / name)


@contextmanager
def results_of(arguments: argparse.Namespace, kind: str, ending: str) -> Iterator[tuple]:
    """Yield the directory of a call's results and its path; None, None for --json without --out."""
    origin, out = origin_of(kind, arguments.scene), arguments.out
    if out is None and arguments.json:
        yield None, None
        return
    folder = results_folder(arguments, f"{origin.name}{ending}")
    with result_directory(folder, origin, named_by_user=out is not None) as result:
        yield result, folder
    say(result.notes)


@contextmanager
def committed_pictures(result: ResultDirectory) -> Iterator[None]:
    """Commit pictures that are drawn in the block; the numbers have been committed before.

    Pictures that this machine cannot draw or write, such as on a full disk, become a note.
    """
    try:
        yield
    except KeyboardInterrupt:
        raise InterruptedRunError(f"interrupted while drawing: the numbers are in {result.target}") from None
    except (RunError, OSError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        result.notes.append(f"pictures are missing in {result.target}: {reason}")
    except Exception as error:
        error.add_note(f"the numbers are in {result.target}")
        raise
    result.commit()


def print_answer(arguments: argparse.Namespace, whole: dict, text: str) -> None:
    """Print an answer as JSON or as text."""
    if arguments.json:
        from studies.record.text import print_json

        print_json(whole)
    else:
        print(text)


def say(sentences) -> None:
    """Print sentences on stderr."""
    for each in sentences:
        print(f"sawmotor: {each}", file=sys.stderr, flush=True)


def warn(warnings) -> None:
    """Print warnings on stderr."""
    say(f"warning: {each}" for each in warnings)


def warn_of_scene(scene: Scene) -> tuple[str, ...]:
    """Print the warnings about a scene and return them."""
    from studies.remarks.scene_warnings import scene_warnings

    warnings = tuple(scene_warnings(scene))
    warn(warnings)
    return warnings
