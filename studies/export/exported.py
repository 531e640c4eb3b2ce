"""The result of an export: files by name, an answer in words, and pictures."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from studies.refusal import writing


@dataclass(frozen=True, kw_only=True)
class Exported:
    """Files of one export."""

    files: dict[str, bytes | str] = field(repr=False)
    answer: tuple[tuple[str, str], ...]  # lines of the printed answer: label and text
    pictures: dict[str, Callable] = field(default_factory=dict, repr=False)  # file: function that draws on an Axes
    remarks: tuple[str, ...] = ()  # printed on stderr

    def write(self, folder: Path) -> None:
        """Write the files into a directory."""
        for name, content in self.files.items():
            content = content.encode() if isinstance(content, str) else content
            (folder / name).write_bytes(content)

    def write_alone(self, path: Path) -> None:
        """Write the only file to a new path; SceneError if the path exists or cannot be written."""
        content = next(iter(self.files.values()))
        with writing(path, "--out"), path.open("xb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
