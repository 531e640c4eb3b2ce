"""The beam of a run from above: the size of u_z over the surface, with apertures, balls and side faces."""

import base64
import html
import io
from collections.abc import Callable
from pathlib import Path

from studies.refusal import RunError, SceneError
from studies.report.surface_map import draw_surface_map
from studies.view.run_field import left_run, motion_again

__all__ = ["drawn", "image", "show"]

WIDE, SQUARE, DPI = (
    (1600, 430),
    (1000, 900),
    110,
)  # pixels; of a long stator, and of one that is nearly square


def show(folder, wanted, written: Callable, *, progress: Callable[[str], None]) -> None:
    """Draw the beam of a run into the files that are wanted, or in a window."""
    import fem

    record = left_run(folder)
    scene = record.scene
    if not scene.transducer:
        raise SceneError("--show", "beam needs a driven stator: this run has none")
    for option in ("movie", "data"):
        if getattr(wanted, option) is not None:
            raise SceneError(
                f"--{option}", "shows the field or the contact; sawmotor run --field writes surface_map.csv"
            )
    progress("solving the stator")
    motion = motion_again(record, progress=progress)
    try:
        beam = motion.beam or fem.surface_beam(motion.wave, mirror_width=scene.stator.mirror_width)
    except fem.BeamError as error:
        raise RunError(f"no beam to show: {error}") from None
    progress("drawing the beam")
    if not wanted.files:
        from matplotlib import pyplot

        draw_surface_map(
            beam, scene, pyplot.subplots(figsize=_inches(wanted, scene), layout="constrained")[1]
        )
        pyplot.show()
        return
    figure = drawn(beam, scene, _inches(wanted, scene))
    if wanted.screenshot is not None:
        written(wanted.screenshot, lambda: figure.savefig(wanted.screenshot))
    if wanted.html is not None:
        written(
            wanted.html, lambda: Path(wanted.html).write_text(_page(figure, scene.title), encoding="utf-8")
        )


def drawn(beam, scene, inches=None):
    """Return a figure of a beam from above."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=inches or _inches(None, scene), dpi=DPI, layout="constrained")
    draw_surface_map(beam, scene, figure.add_subplot())
    return figure


def image(figure) -> str:
    """Return a figure as an HTML element."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    picture = base64.b64encode(buffer.getvalue()).decode("ascii")
    return f'<img alt="size of u_z over the surface" src="data:image/png;base64,{picture}" width="100%">'


def _inches(wanted, scene) -> tuple[float, float]:
    usual = WIDE if scene.stator.length > 1.2 * scene.stator.width else SQUARE
    return tuple(each / DPI for each in (wanted and wanted.size) or usual)


def _page(figure, title: str) -> str:
    """Return a page that holds the picture."""
    return (
        f'<!DOCTYPE html><html lang="en"><meta charset="utf-8"><title>{html.escape(title)}: beam</title>'
        f"{image(figure)}</html>\n"
    )
