"""``sawmotor view``: a run's wave field in a window, as a picture, movie, page or data; without a stator, its contact.

What a run left is enough: the field is computed anew.  Everything but the window is drawn off screen, on machines
without a display and without a graphics card too.
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

FORMATS = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")
STILL_SIZE, MOVIE_SIZE = (1600, 1100), (1000, 400)
FRAMES, RATE = 24, 16.0  # of a movie: one period of the wave
INSTANTS = 12  # of a .pvd
NARROWEST = 0.05  # wavelengths


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
    _check_files(wanted)
    _, scene = left_run(folder)
    show = wanted.show or ("field" if scene.stator is not None else "contact")
    if show == "contact":
        from studies.view import contact_view

        contact_view.show(folder, wanted, progress=progress)
        if scene.stator is None and not wanted.show:
            note(f"{NO_STATOR}; this is its contact")
        return
    from studies.view.shading import quantity

    quantity(wanted.quantity)
    if not wanted.files:
        from studies.view.frame import refuse_without_display
        from studies.view.window import Window

        refuse_without_display()
    found = run_field(folder, progress=progress)
    span = _limits(found, wanted.span)
    _check_scale(found, wanted.factor)
    if wanted.data is not None:
        from studies.view import field_data

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
        _screenshot(found, wanted, span, show)
    if wanted.movie is not None:
        _movie(found, wanted, span, progress)
    if not wanted.files:
        if show == "solid":
            _solid(found, wanted, STILL_SIZE, off_screen=False).show()
        else:
            Window(
                found, quantity=wanted.quantity, phase=wanted.phase, factor=wanted.factor, span=span
            ).open()


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
    found = run_field(folder, progress=lambda text: None)
    wanted = Wanted(quantity=quantity, phase=phase, span=span)
    return _stage(found, wanted, _limits(found, span), size, smooth=True).plotter


def written(file: str, write: Callable[[], object]) -> None:
    """Write a file; what cannot be written is said in a sentence."""
    try:
        write()
    except OSError as error:
        raise RunError(f"the file {file!r} cannot be written: {error.strerror or error}") from None


def check_picture(file: str) -> None:
    """Refuse a picture of an unknown format."""
    if Path(file).suffix.lower() not in FORMATS:
        raise SceneError("--screenshot", f"must end in one of {', '.join(FORMATS)}, got {file!r}")


def _check_files(wanted: Wanted) -> None:
    if wanted.screenshot is not None:
        check_picture(wanted.screenshot)
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


def _screenshot(found: RunField, wanted: Wanted, span, show: str) -> None:
    size = wanted.size or STILL_SIZE
    if show == "solid":
        drawn = _solid(found, wanted, size, off_screen=True)
    else:
        stage = _stage(found, wanted, span, size, smooth=True)
        stage.plotter.render()
        drawn = stage.plotter
    written(wanted.screenshot, lambda: drawn.screenshot(wanted.screenshot))
    drawn.close()


def _movie(found: RunField, wanted: Wanted, span, progress) -> None:
    size, count = wanted.size or MOVIE_SIZE, wanted.frames or FRAMES
    from studies.view.shading import palette

    stage = _stage(found, wanted, span, size, smooth=False, moving=True)

    def frames():
        for number in range(count):
            progress(f"picture {number + 1} of {count}")
            stage.set_phase(wanted.phase + 2 * np.pi * number / count)
            yield stage.image()

    movie.save(frames(), wanted.movie, rate=RATE, palette=palette(stage.shade.colour_map))
    stage.close()


def _stage(found: RunField, wanted: Wanted, span, size, *, smooth: bool, moving: bool = False):
    from studies.view.stage import Stage, chosen_views, views

    shown = chosen_views(found, span) if span is not None or moving else views(found)
    return Stage(
        found,
        shown,
        quantity=wanted.quantity,
        phase=wanted.phase,
        factor=wanted.factor,
        size=size,
        off_screen=True,
        smooth=smooth,
    )


def _solid(found: RunField, wanted: Wanted, size, *, off_screen: bool):
    from studies.view.beam import solid
    from studies.view.stage import magnification

    factor = magnification(found) if wanted.factor is None else wanted.factor
    return solid(
        found, quantity=wanted.quantity, phase=wanted.phase, factor=factor, size=size, off_screen=off_screen
    )


def _check_scale(found: RunField, factor: float | None) -> None:
    """Refuse a displacement drawn larger than the stator is thick."""
    most = -float(found.field.z[0]) / (float(abs(found.field.displacement).max()) or 1.0)
    if factor is not None and factor > most:
        rule = f"must be at most {most:.3g}, where the displacement is drawn as large as the stator is thick"
        raise SceneError("--scale", f"{rule}, got {factor:g}")


def _limits(found: RunField, span) -> tuple[float, float] | None:
    """Return the stretch that is meant, m."""
    if span is None:
        return None
    if span == "whole":
        return 0.0, found.length
    if isinstance(span, str):
        half = (0.5 if span == "wavelength" else 7.0) * found.wavelength
        _, place = found.focus
        return max(place - half, 0.0), min(place + half, found.length)
    if not 0 <= span[0] < span[1] <= found.length * (1 + 1e-9):
        rule = f"must lie on the stator, 0:{found.length * 1e3:g} mm"
        raise SceneError("--span", f"{rule}, got {span[0] * 1e3:g}:{span[1] * 1e3:g} mm")
    least = NARROWEST * found.wavelength
    if span[1] - span[0] < least:
        rule = f"must be at least {least * 1e3:.3g} mm long, a twentieth of a wavelength"
        raise SceneError("--span", f"{rule}, got {(span[1] - span[0]) * 1e3:.3g} mm")
    return span
