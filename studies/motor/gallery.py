"""What a surface-acoustic-wave motor looks like: its field, its orbits, its contact, its maps.

Method: a scene with transducers and a slider (``twente`` when none is named) is run and drawn: the wave field (still,
moving, as a solid of the whole width), orbits at 12 places, amplitude with its ripple, profile through the depth
against the half-space's, slow motion of one contact, start and stop, regimes, velocity, and where power and energy go.
Expected: pictures; what they show is judged by the studies of each.
Run time: about a minute.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from studies.chain import bridge
from studies.record import Record
from studies.scene import Scene
from studies.study import Panel, StudyRecord

TAKES_SCENE = True
QUICK = {"films": False, "maps": False}
CONTACT, BURSTS = 0.5, (0.2, 0.4, 0.8)  # of the largest voltage: the scene's nearest ones are drawn
LONG = 2.0  # burst over the time in which friction alone would reach the steady velocity


@dataclass(frozen=True, kw_only=True)
class Gallery(StudyRecord):
    """What the pictures are drawn from: run and field, contact and ledger at a voltage, bursts, maps of other studies.

    Attributes
    ----------
    voltage : float
        Of the contact and its ledger, V.
    contact : tuple
        `contact_pictures.Moments` and title.
    bursts : tuple of (str, contact.Trajectory)
    acceleration : float
        mu preload / m, m/s^2.
    ledger : dict
        J, of one cycle.
    """

    record: Record = field(repr=False)
    found: object = field(repr=False)
    voltage: float
    contact: tuple = field(repr=False)
    bursts: tuple = field(repr=False)
    acceleration: float
    ledger: dict = field(repr=False)
    others: tuple = field(repr=False)
    films: bool = True


def run(
    scene: str | Scene = "twente",
    *,
    films: bool = True,
    maps: bool = True,
    progress: Callable[[str], None] | None = None,
) -> Gallery:
    """Return everything that the gallery draws.

    Parameters
    ----------
    scene : str or Scene
        A path, a shipped name or a scene with transducers and a slider.
    films : bool
        Whether the films and the solid are drawn.
    maps : bool
        Whether regime map and admittance are computed.
    progress : callable, optional
        Told what is being done.
    """
    import contact
    from studies.chain import run as run_chain
    from studies.motor import regime_map
    from studies.stator import admittance
    from studies.view.contact_view import contact_moments
    from studies.view.run_field import of_record

    begun = time.perf_counter()
    say = progress or (lambda text: None)
    chosen = scene if isinstance(scene, Scene) else Scene.load(scene)
    if not chosen.transducer or chosen.slider is None:
        chosen.refuse("transducer", "and slider are needed: the gallery shows a whole motor")
    say("running the scene")
    record = run_chain(replace(chosen, drive=replace(chosen.drive, burst=None)), tolerance=1e-3, progress=say)
    found = of_record(record, progress=say)
    slider = bridge.contact_slider(record.scene.slider)
    orbits = bridge.orbits_per_volt(record.surface_motion, record.scene.slider)
    voltage, *voltages = _voltages(record)
    say("following the contact")
    slow = contact_moments(record, level=voltage, progress=say)
    say("bursts")
    bursts, acceleration = _bursts(slider, orbits, voltages)
    state = contact.steady(slider, bridge.scaled(orbits, voltage), tolerance=1e-6)
    studies = (regime_map, admittance) if maps else ()
    others = tuple((each, each.run(chosen, progress=say).panels[0]) for each in studies)
    panel = Panel(name="wave", title=chosen.title, data={"wavelength_m": found.wavelength})
    return Gallery(
        name="gallery",
        panels=(panel,),
        findings=(),
        seconds=time.perf_counter() - begun,
        record=record,
        found=found,
        voltage=voltage,
        contact=slow,
        bursts=bursts,
        acceleration=acceleration,
        ledger=vars(state.ledger),
        others=others,
        films=films,
    )


def _voltages(record: Record) -> list[float]:
    """Return the scene's voltage whose contact is drawn, then those of start and stop; the slider moves at all."""
    threshold = record.summary.get("threshold_voltage_V", math.inf)
    moving = [level for level in record.scene.levels if level > threshold]
    if not moving:
        record.scene.refuse(
            "drive.voltage",
            f"must hold a value above the threshold, {threshold:.4g} V: the gallery shows a motion",
        )
    largest = max(moving)
    nearest = [min(moving, key=lambda level: abs(level - share * largest)) for share in (CONTACT, *BURSTS)]
    return [nearest[0], *dict.fromkeys(nearest[1:])]


def _bursts(slider, orbits: tuple, voltages: list[float]) -> tuple:
    """Return start and stop at some voltages, and friction's largest acceleration, m/s^2."""
    import contact

    acceleration = slider.friction_coefficient * slider.preload / slider.mass
    largest = abs(contact.steady(slider, bridge.scaled(orbits, max(voltages)), tolerance=1e-3).velocity)
    duration = float(f"{LONG * largest / acceleration:.2g}")
    given = {"duration": duration, "after": duration, "tolerance": 1e-3, "samples": 1500}
    return tuple(
        (f"{level:g} V", contact.burst(slider, bridge.scaled(orbits, level), **given)) for level in voltages
    ), acceleration


def figure(record: Gallery, ax):
    """Draw velocity against voltage, the gallery's first picture; ``draw`` makes all of them."""
    from studies.report.figures import velocity

    return velocity(record.record, ax)


def draw(gallery: Gallery, folder: Path, *, progress: Callable[[str], None]) -> None:
    """Draw the gallery's pictures into a directory."""
    from studies.view.gallery_pictures import draw_all

    draw_all(gallery, folder, progress=progress)
