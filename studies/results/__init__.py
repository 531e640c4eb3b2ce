"""Directories of results: nothing that somebody put there is lost, and the numbers are whole or absent."""

from studies.results.directory import MANIFEST, MARKS, Origin, ResultDirectory, read_manifest, result_directory

__all__ = ["MANIFEST", "MARKS", "Origin", "ResultDirectory", "read_manifest", "result_directory"]
