"""``sawmotor view``: a run's wave field in a window, as a picture, movie, page or data; without a stator, its contact.

What a run left is enough: the field is computed anew.  Pictures and movies are matplotlib's; the window and the solid
are pyvista's.
"""

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

from studies.refusal import RunError, SceneError
from studies.view import movie
from studies.view.options import Wanted
from studies.view.run_field import NO_STATOR, RunField, left_run, run_field

__all__ = ["plotter", "view"]

FORMATS = (".png", ".jpg", ".jpeg", ".tif", ".tiff")
STILL_SIZE, MOVIE_SIZE, WINDOW_SIZE = (1600, 1100), (1000, 400), (1500, 900)
FRAMES, RATE = 24, 16.0  # of a movie: one period of the wave
INSTANTS = 12  # of a .pvd


def view(
    folder: str | Path,
    wanted: Wanted,
    *,
    progress: Callable[[str], None],
    note: Callable[[str], None] = warnings.warn,
) -> None:
    """Show a run.

    Parameters
    ----------
    folder : str or Path
        What ``sawmotor run`` left.
    wanted : Wanted
    progress : callable
        Told what is being done.
    note : callable, optional
        Told what a reader must know: why there is no field, how large a file will be.

    Raises
    ------
    SceneError
        If the directory holds no run, or an option does not fit.
    RunError
        If something is missing on this machine, or a file cannot be written.
    """
    from studies.view import field_data
    from studies.view.quantities import palette, quantity
    from studies.view.section import limits

    _check_files(wanted)
    scene = left_run(folder).scene
    show = wanted.show or ("field" if scene.stator is not None else "contact")
    if show == "contact":
        from studies.view import contact_view

        contact_view.show(folder, wanted, written, progress=progress)
        if scene.stator is None and not wanted.show:
            note(f"{NO_STATOR}; this is its contact")
        return
    if show == "beam":
        from studies.view import beam_view

        beam_view.show(folder, wanted, written, progress=progress)
        return
    quantity(wanted.quantity)
    if not wanted.files:
        from studies.view.solid import refuse_without_display

        refuse_without_display()
    found = run_field(folder, progress=progress)
    span = limits(found, wanted.span)
    _check_scale(found, wanted.factor)
    if wanted.data is not None:
        field_data.save(
            found, wanted.data, span=span, instants=wanted.frames or INSTANTS, progress=progress, note=note,
            surface=wanted.surface,
        )  # fmt: skip
    if wanted.html is not None:
        from studies.view.wave_page import page

        progress("writing the page")
        text = page(found, quantity=wanted.quantity, phase=wanted.phase, factor=wanted.factor, span=span)
        written(wanted.html, lambda: Path(wanted.html).write_text(text, encoding="utf-8"))
    if wanted.screenshot is not None:
        progress("drawing")
        if show == "solid":
            drawn = _solid(found, wanted, wanted.size or STILL_SIZE, off_screen=True)
            written(wanted.screenshot, lambda: drawn.plotter.screenshot(wanted.screenshot))
            drawn.plotter.close()
        else:
            figure = _section(found, wanted, span, wanted.size or STILL_SIZE).figure
            written(wanted.screenshot, lambda: figure.savefig(wanted.screenshot, dpi=figure.dpi))
    if wanted.movie is not None:
        drawn, count = _section(found, wanted, span, wanted.size or MOVIE_SIZE), wanted.frames or FRAMES
        movie.save(
            drawn.figure, lambda number: drawn.show(wanted.phase + 2 * np.pi * number / count), count,
            wanted.movie, rate=RATE, progress=progress, palette=palette(drawn.shade.colour_map),
        )  # fmt: skip
    if not wanted.files:
        from studies.view.solid import open_window

        section = show != "solid"
        open_window(
            _solid(found, wanted, WINDOW_SIZE, off_screen=False, section=section, span=span), section=section
        )


def plotter(
    folder: str | Path,
    *,
    quantity: str = "u_z",
    phase: float = 0.0,
    span: str | tuple[float, float] | None = None,
    size: tuple[int, int] = STILL_SIZE,
):
    """Return the pyvista Plotter of a run's field, off screen, for pyvista's own notebook backends and other uses.

    Parameters
    ----------
    folder : str or Path
        What ``sawmotor run`` left.
    quantity : str
    phase : float
        rad.
    span : str or tuple of float or None
        As in `Wanted`.
    size : tuple of int
        Pixels.
    """
    from studies.view.section import limits

    found = run_field(folder, progress=lambda text: None)
    wanted = Wanted(quantity=quantity, phase=phase)
    return _solid(found, wanted, size, off_screen=True, section=True, span=limits(found, span)).plotter


def written(file: str, write: Callable[[], object]) -> None:
    """Write a file; what cannot be written is said in a sentence."""
    try:
        write()
    except OSError as error:
        raise RunError(f"the file {file!r} cannot be written: {error.strerror or error}") from None


def _check_files(wanted: Wanted) -> None:
    if wanted.screenshot is not None and Path(wanted.screenshot).suffix.lower() not in FORMATS:
        raise SceneError(
            "--screenshot", f"must end in one of {', '.join(FORMATS)}, got {wanted.screenshot!r}"
        )
    if wanted.movie is not None:
        movie.check(wanted.movie)
        if wanted.show == "solid":
            raise SceneError(
                "--movie", "shows the field or the contact, not the solid: leave --show solid out"
            )
    if wanted.html is not None and Path(wanted.html).suffix.lower() not in (".html", ".htm"):
        raise SceneError("--html", f"must end in .html, got {wanted.html!r}")
    if wanted.data is not None:
        from studies.view import field_data

        field_data.check(wanted.data, surface=wanted.surface)


def _section(found: RunField, wanted: Wanted, span, size):
    """Return the figure of the section: whole and near for a stretch or a movie, else also at the transducer."""
    from studies.view.section import Section, chosen_views, views

    shown = chosen_views(found, span) if span is not None or wanted.movie is not None else views(found)
    return Section(
        found, shown, quantity=wanted.quantity, phase=wanted.phase, factor=wanted.factor, size=size
    )


def _solid(found: RunField, wanted: Wanted, size, **given):
    from studies.view.solid import Solid

    return Solid(
        found, quantity=wanted.quantity, phase=wanted.phase, factor=wanted.factor, size=size, **given
    )


def _check_scale(found: RunField, factor: float | None) -> None:
    """Refuse a displacement drawn larger than the stator is thick."""
    most = -float(found.field.z[0]) / (float(abs(found.field.displacement).max()) or 1.0)
    if factor is not None and factor > most:
        rule = f"must be at most {most:.3g}, where the displacement is drawn as large as the stator is thick"
        raise SceneError("--scale", f"{rule}, got {factor:g}")
