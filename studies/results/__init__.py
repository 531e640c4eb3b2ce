"""Directories of results: files of the user are kept, and a result is written completely or not at all."""

from studies.results.directory import MANIFEST, MARKS, Origin, ResultDirectory, read_manifest, result_directory

__all__ = ["MANIFEST", "MARKS", "Origin", "ResultDirectory", "read_manifest", "result_directory"]
