"""The contact of a run: two cycles of the wave in slow motion, in the steady state; a picture, movie, page or table."""

import base64
import tempfile
from collections.abc import Callable
from html import escape
from pathlib import Path

from studies.chain import bridge
from studies.chain.surface_motion import surface_motion
from studies.record import Record
from studies.refusal import RunError, SceneError
from studies.report.figures import refuse_without_toolkit
from studies.report.files import write_columns
from studies.view import movie
from studies.view.contact_pictures import SlowMotion, moments, strip
from studies.view.run_field import left_run, motion_again

__all__ = ["contact_moments", "show", "slow_motion"]

CYCLES, INSTANTS = 2, 240  # per cycle
FRAMES, RATE = 48, 12.0  # of a movie
DPI = 110


def show(folder, wanted, written: Callable, *, progress: Callable[[str], None]) -> None:
    """Draw the contact of a run into the files that are wanted, or in a window."""
    record = left_run(folder)
    if wanted.data is not None and not wanted.data.lower().endswith(".csv"):
        raise SceneError("--data", f"must end in .csv for a contact, got {wanted.data!r}")
    if wanted.surface:
        raise SceneError("--surface", "belongs to the field, and this shows the contact")
    if not wanted.files:
        from studies.view.solid import refuse_without_display

        refuse_without_display()
    found, title = contact_moments(record, level=wanted.level, progress=progress)
    progress("drawing the contact")
    for file, write in (
        (wanted.screenshot, lambda: strip(found, title=title).savefig(wanted.screenshot, dpi=DPI)),
        (wanted.data, lambda: write_columns(Path(wanted.data), found.columns())),
        (wanted.html, lambda: Path(wanted.html).write_text(_page(found, title), encoding="utf-8")),
    ):
        if file is not None:
            written(file, write)
    if wanted.movie is not None:
        count = wanted.frames or FRAMES
        movie.save(*slow_motion(found, title, count), count, wanted.movie, rate=RATE)
    if not wanted.files:
        _window(found, title)


def contact_moments(record: Record, *, level: float | None, progress: Callable[[str], None]):
    """Return the first contact over two cycles of the steady state of a record, and its title.

    The level is a voltage in V, or the amplitude of a given wave in m; the largest of the scene if None.
    """
    import contact

    scene = record.scene
    if scene.slider is None:
        raise SceneError("", "there is no contact to show: the scene of this run has no slider")
    level = max(scene.levels) if level is None else level
    if level == 0:
        raise SceneError("--voltage", "must be above 0: at 0 nothing moves")
    if scene.wave is not None:
        orbits, named = bridge.given_orbits(scene.wave), f"{level * 1e9:.4g} nm"
    else:
        progress("solving the stator")
        motion = motion_again(record, progress=progress)
        if motion.beam is None:
            motion = surface_motion(motion.wave, scene.stator, scene.slider.places)
        orbits, named = bridge.orbits_per_volt(motion, scene.slider), f"{level:.4g} V"
    progress("following the contact")
    slider, orbits = bridge.contact_slider(scene.slider), bridge.scaled(orbits, level)
    try:
        speed = contact.steady(slider, orbits, tolerance=record.tolerance).velocity * 1e3
        history = contact.contact_history(
            slider, orbits, stage="steady", skip=0, cycles=CYCLES, points_per_cycle=INSTANTS
        )
    except contact.ConvergenceError as error:
        raise RunError(" ".join(str(error).split())) from None
    said = f"slider at {speed:.4g} mm/s" if speed else "slider held at rest"
    return moments(history), f"{scene.title}: {named}, {said}"


def slow_motion(found, title: str, count: int, figure=None):
    """Return the figure of the contact's first cycle, which repeats, and what shows one of its pictures."""
    motion = SlowMotion(found, title=title, figure=figure)
    return motion.figure, lambda number: motion.show(round(number * INSTANTS / count))


def _page(found, title: str) -> str:
    """Return a page with the moving and the still picture in it."""
    with tempfile.TemporaryDirectory() as folder:
        moving, still = Path(folder) / "contact.gif", Path(folder) / "contact.png"
        movie.save(*slow_motion(found, title, FRAMES), FRAMES, moving, rate=RATE)
        strip(found, title=title).savefig(still, dpi=DPI)
        return picture_page(title, {file.suffix[1:]: file.read_bytes() for file in (moving, still)})


def picture_page(title: str, pictures: dict[str, bytes]) -> str:
    """Return an HTML page that holds pictures, each by its kind, such as "png"."""
    images = "\n".join(
        f'<p><img alt="{escape(title)}" src="data:image/{kind};base64,{base64.b64encode(data).decode()}"></p>'
        for kind, data in pictures.items()
    )
    head = f'<meta charset="utf-8"><link rel="icon" href="data:,"><title>{escape(title)}</title>'
    return f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body>\n{images}\n</body></html>\n'


def _window(found, title: str) -> None:
    """Show the slow motion until its window is closed."""
    from matplotlib import pyplot
    from matplotlib.animation import FuncAnimation

    refuse_without_toolkit("a window of the contact", "--screenshot, --movie and --html FILE need none")
    figure = pyplot.figure(figsize=(9.0, 4.6), layout="constrained")
    figure, show = slow_motion(found, title, FRAMES, figure)
    figure.animation = FuncAnimation(figure, show, frames=FRAMES, interval=1000 / RATE)
    pyplot.show()
