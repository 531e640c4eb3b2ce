"""The record of a run: its numbers, their names and units, and their texts, plots and files."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from studies.record.record import Record  # 3 ms, see above

__all__ = ["Record"]


def __getattr__(name: str) -> Any:
    """Import the class when it is first asked for: commands that run nothing need the texts alone."""
    if name != "Record":
        raise AttributeError(f"module 'studies.record' has no attribute {name!r}")
    from studies.record.record import Record  # 3 ms, see above

    return Record
