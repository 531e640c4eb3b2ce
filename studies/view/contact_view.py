"""The contact of a run: two cycles of the wave in slow motion, in the steady state; a picture, movie, page or table."""

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from matplotlib.animation import FuncAnimation

import contact
from studies.chain.driven_contact import DrivenContact
from studies.chain.surface_motion import surface_motion
from studies.record import Record
from studies.refusal import RunError, SceneError
from studies.report.figures import data_uri, refuse_without_toolkit
from studies.report.files import write_columns
from studies.view import movie
from studies.view.contact_pictures import SlowMotion, moments, strip
from studies.view.run_field import motion_again

__all__ = ["contact_moments", "contact_writers", "film_contact"]

CYCLES, INSTANTS = 2, 240  # per cycle
FRAMES, RATE = 48, 12.0  # of a movie
DPI = 110


def contact_writers(record: Record, wanted, progress: Callable[[str], None]) -> dict[str, Callable]:
    """Return what writes each option's file of a run's contact, and what opens its window."""
    found, title = contact_moments(record, level=wanted.level, progress=progress)

    def film(file) -> None:
        film_contact(found, title, wanted.frames or FRAMES, file, rate=RATE)

    def still(file) -> None:
        strip(found, title=title).savefig(file, dpi=DPI)

    def page(file) -> None:
        with tempfile.TemporaryDirectory() as folder:
            pictures = Path(folder) / "contact.gif", Path(folder) / "contact.png"
            for picture, write in zip(pictures, (film, still), strict=True):
                write(picture)
            uris = [data_uri(each.read_bytes(), each.suffix[1:]) for each in pictures]
        images = [movie.image(uri, title) for uri in uris]
        Path(file).write_text(movie.page(title, images), encoding="utf-8")

    return {
        "screenshot": still,
        "movie": film,
        "html": page,
        "data": lambda file: write_columns(Path(file), found),
        "window": lambda: _window(found, title),
    }


def contact_moments(record: Record, *, level: float | None, progress: Callable[[str], None]):
    """Return the first contact over two cycles of the steady state of a record, and its title.

    The level is a voltage in V, or the amplitude of a given wave in m; the largest of the scene if None.
    """
    scene = record.scene
    if scene.slider is None:
        raise SceneError("", "there is no contact to show: the scene of this run has no slider")
    level = max(scene.levels) if level is None else level
    if level == 0:
        raise SceneError("--voltage", "must be above 0: at 0 nothing moves")
    if scene.wave is None and record.surface_motion is None:
        progress("solving the stator")
        motion = motion_again(record, progress=progress)
        if motion.beam is None:
            motion = surface_motion(motion.wave, scene.stator, scene.slider.places)
        record = replace(record, surface_motion=motion)
    progress("following the contact")
    driven = DrivenContact.of_run(record)
    slider, orbits = driven.slider, driven.at(level)
    try:
        speed = contact.steady(slider, orbits, tolerance=record.tolerance).velocity * 1e3
        history = contact.contact_history(
            slider, orbits, stage="steady", skip=0, cycles=CYCLES, points_per_cycle=INSTANTS
        )
    except contact.ConvergenceError as error:
        raise RunError(" ".join(str(error).split())) from None
    said = f"slider at {speed:.4g} mm/s" if speed else "slider held at rest"
    return moments(history), f"{scene.title}: {driven.named(level)}, {said}"


def film_contact(found, title: str, count: int, file, *, rate: float, dpi: float = 100) -> None:
    """Write a movie of the contact's first cycle, which repeats."""
    motion = SlowMotion(found, title=title)
    motion.figure.set_dpi(dpi)
    movie.save(lambda number: motion.image(round(number * INSTANTS / count)), count, file, rate=rate)


def _window(found, title: str) -> None:
    """Show the slow motion until its window is closed."""
    from matplotlib import pyplot

    refuse_without_toolkit("a window of the contact", "--screenshot, --movie and --html FILE need none")
    figure = pyplot.figure(figsize=(9.0, 4.6), layout="constrained")
    motion = SlowMotion(found, title=title, figure=figure)
    figure.animation = FuncAnimation(
        figure, motion.show, frames=range(0, INSTANTS, INSTANTS // FRAMES), interval=1000 / RATE
    )
    pyplot.show()
