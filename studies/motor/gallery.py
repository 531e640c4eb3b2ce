"""Pictures of a surface-acoustic-wave motor: field, orbits, contact and maps.

Method: a scene with transducers and a slider (``twente`` by default) is run and drawn: the wave field (still, moving,
and as a solid of the whole width), orbits at 12 positions, the amplitude with its ripple, the profile through the depth
compared with the half-space, one contact in slow motion, start and stop, regimes, velocity, and the balances of power
and energy. Expected: pictures only; other studies judge what they show.
Run time: about a minute.
"""

import logging
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import contact
from studies.motor import regime_map
from studies.record import Record
from studies.record.run_pictures import velocity
from studies.runs import run as run_chain
from studies.scene import Scene
from studies.solve.solved_stator import contact_of_run
from studies.stator import admittance
from studies.study_list import Panel, StudyRecord
from studies.view.contact_view import steady_history
from studies.view.gallery_pictures import draw_all
from studies.view.run_field import run_field

if TYPE_CHECKING:
    from contact.answers.ledger import Ledger
    from studies.view.run_field import RunField

LOGGER = logging.getLogger(__name__)

QUICK = {"films": False, "maps": False}
# fractions of the largest voltage; the nearest voltages of the scene are used
CONTACT, BURSTS = 0.5, (0.2, 0.4, 0.8)
BURST_RATIO = 2.0  # burst duration over the time in which the full friction force would reach the steady velocity


@dataclass(frozen=True, kw_only=True)
class Gallery(StudyRecord):
    """Data of the pictures: run, wave field, contact and ledger at one voltage, bursts, and other studies."""

    record: Record = field(repr=False)
    wave_field: "RunField" = field(repr=False)
    voltage: float  # voltage of ``contact`` and ``ledger``, V
    contact: tuple = field(repr=False)  # of `contact_view.steady_history`: waveforms and title
    bursts: tuple = field(repr=False)  # pairs (str, contact.Trajectory)
    acceleration: float  # mu preload / m, m/s^2
    ledger: "Ledger" = field(repr=False)  # of one cycle
    others: tuple = field(repr=False)  # pairs (study, panel)
    films: bool = True


def run(scene: str | Scene = "twente", *, films: bool = True, maps: bool = True) -> Gallery:
    """Compute the data of all pictures of the gallery.

    Parameters
    ----------
    scene : str or Scene
        A path, a shipped name or a scene with transducers and a slider.
    films : bool
        True to draw the movies and the solid.
    maps : bool
        True to compute the regime map and the admittance.
    """
    start_time = time.perf_counter()
    loaded = Scene.load(scene)
    if not loaded.transducer or loaded.slider is None:
        loaded.refuse("transducer", "and slider are needed: the gallery shows a whole motor")
    LOGGER.info("running the scene")
    record = run_chain(loaded.with_source(burst=None), tolerance=1e-3)
    wave_field, driven = run_field(record), contact_of_run(record)
    moving = driven.above(1.0)
    nearest = (min(moving, key=lambda level: abs(level - share * moving[-1])) for share in (CONTACT, *BURSTS))
    voltage, *voltages = nearest
    LOGGER.info("bursts")
    slider = driven.slider
    acceleration = slider.least_friction(len(driven.orbits)) / slider.mass
    largest = abs(contact.steady(slider, driven.at(max(voltages)), tolerance=1e-3).velocity)
    duration = float(f"{BURST_RATIO * largest / acceleration:.2g}")
    options = {"duration": duration, "after": duration, "tolerance": 1e-3, "samples": 1500}
    bursts = tuple(
        (driven.scene.named(level), contact.burst(slider, driven.at(level), **options))
        for level in dict.fromkeys(voltages)
    )
    studies = (regime_map, admittance) if maps else ()
    panel = Panel(name="wave", title=loaded.title, data={"wavelength_m": wave_field.wavelength})
    return Gallery(
        name="gallery", panels=(panel,), findings=(), record=record, wave_field=wave_field, voltage=voltage,
        contact=steady_history(record, level=voltage), bursts=bursts, acceleration=acceleration,
        ledger=contact.steady(slider, driven.at(voltage), tolerance=1e-6).ledger,
        others=tuple((each, each.run(loaded).panels[0]) for each in studies), films=films,
        seconds=time.perf_counter() - start_time,
    )  # fmt: skip


def figure(record: Gallery, ax):
    """Draw velocity against voltage; `draw` makes all pictures of the gallery."""
    return velocity(record.record, ax)


draw = draw_all  # all pictures of a gallery, into a directory
