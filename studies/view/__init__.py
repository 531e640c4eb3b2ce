"""``sawmotor view``: show the wave field or the contact of a run in a window, or write it to a file.

The files are pictures, movies, HTML pages and data. For a scene without a stator, the default is the contact. Only the
directory of the run is needed: the field is computed again and drawn by pyvista; the contact is drawn by matplotlib.
"""

import logging
import os
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import fem
from studies.record import Record, plots
from studies.record.point import Point
from studies.refusal import RunError, SceneError, refuse_if, writing
from studies.report.beam_map import draw_surface_map, pixels
from studies.report.page import picture_page
from studies.view import field_data, movie, wave_page
from studies.view.contact_view import contact_writers
from studies.view.field_quantities import palette, quantity
from studies.view.picture import Picture, solid_height
from studies.view.plane_contact_view import plane_contact_writers
from studies.view.run_field import NO_STATOR, recomputed_motion, run_field, saved_run
from studies.view.view_options import Wanted
from studies.view.views import limits, near, span_views, views
from studies.view.window import open_window

LOGGER = logging.getLogger(__name__)

__all__ = ["view"]

STILL_SIZE, MOVIE_SIZE, WINDOW_SIZE = (1600, 1100), (1000, 400), (1500, 900)
FRAMES, RATE = 24, 16.0  # pictures of a movie, which shows one period of the wave, and pictures per second
INSTANTS = 12  # instants of a .pvd file


def view(run: str | Path | Record, wanted: Wanted, *, note: Callable[[str], None] = warnings.warn) -> None:
    """Show a run.

    Parameters
    ----------
    run : str, Path or Record
        Directory written by ``sawmotor run``, or its record.
    wanted : Wanted
    note : callable, optional
        Function that receives remarks for the user: why there is no field, or how large a file will be.

    Raises
    ------
    SceneError
        If the directory holds no run, an option does not fit, or a file cannot be written.
    RunError
        If something is missing on this machine.
    """
    record = run if isinstance(run, Record) else saved_run(run)
    show = wanted.show or ("field" if record.scene.stator is not None else "contact")
    wanted.check(show)
    quantity(wanted.quantity)
    if wanted.movie is not None and wanted.movie.lower().endswith(".mp4"):
        movie.ffmpeg()
    if not wanted.files:
        _refuse_without_display()
    if show == "contact":
        writers = (plane_contact_writers if record.scene.planar else contact_writers)(record, wanted)
    elif show == "beam":
        writers = _beam_writers(record, wanted)
    else:
        writers = _field_writers(record, wanted, show, note)
    for option, file in wanted.files.items():
        LOGGER.info(f"writing {file}")
        with writing(file, f"--{option}"):
            writers[option](file)
    if not wanted.files:
        writers["window"]()
    if record.scene.stator is None and not wanted.show:
        note(f"{NO_STATOR}; this is its contact")


def _field_writers(record: Record, wanted: Wanted, show: str, note) -> dict[str, Callable]:
    """Return functions that write the field of a run, by option, and the function ``window`` that opens a window."""
    field = run_field(record)
    span = None if wanted.span is None else limits(field, wanted.span)
    max_factor = -float(field.field.z[0]) / (float(abs(field.field.displacement).max()) or 1.0)
    if wanted.factor is not None and wanted.factor > max_factor:
        rule = f"must be at most {max_factor:.3g}, where the displacement is drawn as large as the stator is thick"
        raise SceneError("--scale", f"{rule}, got {wanted.factor:g}")
    options: dict[str, Any] = {"quantity": wanted.quantity, "phase": wanted.phase, "factor": wanted.factor}

    def still(file) -> None:
        shown = () if show == "solid" else views(field) if span is None else span_views(field, span)
        size = wanted.size or (STILL_SIZE if shown else (STILL_SIZE[0], solid_height(field, STILL_SIZE[0])))
        Picture(field, shown, size=size, **options).save(file, whole=bool(wanted.size))

    def film(file) -> None:
        picture = Picture(field, span_views(field, span), size=wanted.size or MOVIE_SIZE, **options)
        count = wanted.frames or FRAMES
        movie.save(
            lambda number: picture.image(wanted.phase + 2 * np.pi * number / count), count, file, rate=RATE,
            palette=palette(picture.shade.colour_map),
        )  # fmt: skip

    def page(file) -> None:
        Path(file).write_text(wave_page.page(field, span=span, **options), encoding="utf-8")

    def data(file) -> None:
        instants = wanted.frames or INSTANTS
        field_data.save(field, file, span=span, surface=wanted.surface, instants=instants, note=note)

    def window() -> None:
        shown = () if show == "solid" else span_views(field, span or near(field))[-1:]
        open_window(Picture(field, shown, size=WINDOW_SIZE, framed=False, **options))

    return {"screenshot": still, "movie": film, "html": page, "data": data, "window": window}


def _beam_writers(record: Record, wanted: Wanted) -> dict[str, Callable]:
    """Return functions that draw the beam of a run from above, by option, and the function that opens a window."""
    scene = record.scene
    refuse_if(not scene.transducer, "--show", "beam needs a driven stator: this run has none")
    LOGGER.info("solving the stator")
    try:
        motion = recomputed_motion(record)
        beam = motion.beam or fem.surface_beam(motion.wave, mirror_width=scene.stator.mirror_width)
        if len(scene.drive.frequencies) > 1:
            from studies.report.plane_drawing import Together

            beam = Together((beam, *(recomputed_motion(record, each).beam for each in scene.drive.frequencies[1:])))
    except fem.BeamError as error:
        raise RunError(f"no beam to show: {error}") from None

    width, height = wanted.size or pixels(scene.stator)
    size, draw = (
        (width / plots.DPI, height / plots.DPI),
        partial(draw_surface_map, beam, scene, point=_shown_point(record, wanted)),
    )

    def still(file) -> None:
        plots.saved(file, draw, size=size)

    def page(file) -> None:
        picture = plots.as_uri(draw, size=size, kind="png"), "size of u_z over the surface"
        Path(file).write_text(picture_page(f"{scene.title}: beam", [picture]), encoding="utf-8")

    return {"screenshot": still, "html": page, "window": lambda: plots.show(draw)}


def _shown_point(record: Record, wanted: Wanted) -> Point | None:
    """Return the point of a run at the wanted level, or at its largest one."""
    points = [each for each in record.points if wanted.level in (None, each.level)]
    return max(points, key=lambda each: each.level, default=None) if record.scene.slider is not None else None


def _refuse_without_display() -> None:
    """Raise an error if there is no display to open a window on."""
    if os.name == "posix" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise RunError(
            "there is no display to open a window on; --screenshot FILE, --movie FILE and --html FILE draw without one"
        )
