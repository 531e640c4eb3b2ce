"""What a surface-acoustic-wave motor looks like: its field, its orbits, its contact, its maps.

Method: a scene with transducers and a slider (``twente`` when none is named) is run and drawn: the wave field (still,
moving, as a solid of the whole width), orbits at 12 places, amplitude with its ripple, profile through the depth
against the half-space's, slow motion of one contact, start and stop, regimes, velocity, and where power and energy go.
What is drawn is held against numbers of other origin.  Expected: retrograde orbits beside the driven transducer, the
computed wavelength, the run's amplitude under the slider, power and ledger that balance.
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
from studies.study import Finding, Panel, StudyRecord

__all__ = ["draw", "figure", "run"]

TAKES_SCENE = True
QUICK = {"films": False, "maps": False}
CONTACT, BURSTS = 0.5, (0.2, 0.4, 0.8)  # of the largest voltage: the scene's nearest ones are drawn
LONG = 2.0  # burst over the time in which friction alone would reach the steady velocity
MAX_STANDING = 2.0  # standing-wave ratio up to which the phase along x gives the wavelength


@dataclass(frozen=True, kw_only=True)
class Gallery(StudyRecord):
    """What the pictures are drawn from.

    Attributes
    ----------
    record : Record
        Of the run.
    found : studies.view.run_field.RunField
    voltage : float
        Of the contact and its ledger, V.
    contact : tuple
        `contact_pictures.Moments` and title.
    bursts : tuple of (str, contact.Trajectory)
    acceleration : float
        mu preload / m, m/s^2.
    ledger : dict
        J, of one cycle.
    others : tuple of (module, Panel)
        Regime map and admittance, from their own studies.
    films : bool
        Whether the films and the solid are drawn.
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
        findings=_findings(record, found, state, slow[0]),
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
    followed = [
        contact.burst(
            slider,
            bridge.scaled(orbits, level),
            duration=duration,
            after=duration,
            tolerance=1e-3,
            samples=1500,
        )
        for level in voltages
    ]
    return tuple((f"{level:g} V", each) for level, each in zip(voltages, followed, strict=True)), acceleration


def _findings(record: Record, found, state, slow) -> tuple[Finding, ...]:
    told = record.wave.get("section_normal_m_per_V", record.wave["normal_m_per_V"])
    amplitude = float(abs(found.surface(record.scene.slider.center[0])[1] / told - 1))
    residual = float(state.ledger.relative_residual)
    speed = float(abs(slow.slider_velocity.mean() / state.velocity - 1))
    return (
        *_wave_findings(record, found),
        Finding.judged(
            "The drawn field moves the surface under the slider as the run says.",
            "relative difference of u_z", amplitude, high=1e-10,
        ),
        Finding.judged(
            "What the wave gives the contact is accounted for.", "residual of the ledger, relative", residual, high=1e-6
        ),
        Finding.judged(
            "The slider in slow motion runs at the steady velocity.",
            "difference of the mean velocities, relative", speed, high=1e-6,
        ),
    )  # fmt: skip


def _wave_findings(record: Record, found) -> list[Finding]:
    """Return what the surface between transducer and slider shows; nothing where the slider lies under it."""
    import numpy as np

    from studies.view.surface_pictures import anticlockwise

    driven = next(each for each in record.scene.transducer if each.name == record.scene.drive.transducer)
    places, top = _beside(found, driven), found.field.displacement[:, -1]
    at, normal, tangential = found.field.x[places], top[places, 2], top[places, 0]
    if len(at) < 2:
        return []
    retrograde = anticlockwise(tangential, normal) == (at > driven.center)
    findings = [
        Finding(
            statement="A Rayleigh wave turns the surface against its own direction at the crest.",
            quantity="share of places on the way from the transducer to the slider with a retrograde orbit",
            expected="1",
            found=float(np.mean(retrograde)),
            confirmed=bool(np.all(retrograde)),
        )
    ]
    if record.wave["standing_wave_ratio"] < MAX_STANDING and np.ptp(at) > found.wavelength:
        measured = 2 * np.pi / abs(np.polyfit(at, np.unwrap(np.angle(normal)), 1)[0])
        difference, bound = float(abs(measured / found.wavelength - 1)), 0.1 * found.wavelength / np.ptp(at)
        findings.append(
            Finding.judged(
                "The drawn field has the wavelength of the surface wave.",
                "wavelength by the phase of the drawn u_z over that of the run, less 1", difference, high=bound,
                expected=f"below {bound:.1g}: a tenth of a wavelength on the way from the transducer to the slider",
            )
        )  # fmt: skip
    return findings


def figure(record: Gallery, ax):
    """Draw velocity against voltage, the gallery's first picture; ``draw`` makes all of them."""
    from studies.report.figures import velocity

    return velocity(record.record, ax)


def draw(gallery: Gallery, folder: Path, *, progress: Callable[[str], None]) -> None:
    """Draw the gallery's pictures into a directory."""
    from studies.view.gallery_pictures import draw_all

    draw_all(gallery, folder, progress=progress)


def _beside(found, driven):
    """Lines between the driven transducer and the slider."""
    ends = sorted((driven.center, found.scene.slider.center[0]))
    x = found.field.x
    return (x > ends[0]) & (x < ends[1]) & ~found.near_transducer(x)
