"""Directories of results: nothing that somebody put there is lost, and the numbers are whole or absent."""

from studies.results.directory import MARKS, DirectoryInUseError, ResultDirectory, locked, result_directory
from studies.results.manifest import MANIFEST, Origin, read_manifest

__all__ = [
    "MANIFEST", "MARKS", "DirectoryInUseError", "Origin", "ResultDirectory", "locked", "read_manifest",
    "result_directory",
]  # fmt: skip
