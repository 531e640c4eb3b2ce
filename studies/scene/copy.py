"""A scene that ships, copied to start from: with the comment that tells an editor where its JSON Schema is."""

from pathlib import Path

from studies.refusal import RunError, SceneError, nearest, shown
from studies.scene.file import SHIPPED, shipped_scenes
from studies.scene.schema import FILE_NAME


def copied(name: str, file: Path) -> Path:
    """Write a scene that ships into a new file and return the file."""
    shipped = shipped_scenes()
    if name not in shipped:
        raise SceneError("--copy", f"no shipped scene is named {shown(name)}{nearest(name, shipped)}")
    text = shipped[name].read_text(encoding="utf-8")
    schema = (SHIPPED / FILE_NAME).resolve().as_uri()
    text = text.replace(f"#:schema {FILE_NAME}\n", f"#:schema {schema}\n", 1)
    try:
        with file.open("x", encoding="utf-8") as target:
            target.write(text)
    except FileExistsError:
        raise SceneError(
            "--copy", f"does not overwrite {str(file)!r}, which exists: name another file"
        ) from None
    except OSError as error:
        raise RunError(f"{str(file)!r} cannot be written: {error.strerror}") from None
    return file
