"""The pictures of a run in windows, until they are closed."""

from studies.record import Record
from studies.refusal import RunError
from studies.report import figures

__all__ = ["refuse_without_toolkit", "show"]


def refuse_without_toolkit() -> None:
    """Refuse where matplotlib can open no window, before anything is computed.

    Raises
    ------
    RunError
        Naming what to do instead.
    """
    from matplotlib import pyplot

    if pyplot.get_backend().lower() == "agg":
        raise RunError(
            "--plot opens windows, and matplotlib has no toolkit or no display for them: pip install PySide6 on a "
            "machine with a display; without --plot the same pictures are files in the result directory"
        )


def show(record: Record) -> None:
    """Show what a run found: velocity and trajectories, or surface or profile."""
    from matplotlib import pyplot

    for draw in figures.pictures(record).values():
        pyplot.figure(figsize=(7.0, 4.3), layout="constrained")
        draw(record, pyplot.gca())
    pyplot.show()
