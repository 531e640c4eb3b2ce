"""The record of a run: its numbers, their names and units, and their texts, plots and files."""

from studies.record.record import Record

__all__ = ["Record"]
