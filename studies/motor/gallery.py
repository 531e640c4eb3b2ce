"""What a surface-acoustic-wave motor looks like: its field, its orbits, its contact, its maps.

Method: a scene with transducers and a slider (``twente`` when none is named) is run and drawn: the wave field (still,
moving, as a solid of the whole width), orbits at 12 places, amplitude with its ripple, profile through the depth
against the half-space's, slow motion of one contact, start and stop, regimes, velocity, and where power and energy go.
What is drawn is held against numbers of other origin.  Expected: retrograde orbits beside the driven transducer, the
computed wavelength, the run's amplitude under the slider, power and ledger that balance.
Run time: about a minute.
"""

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from studies.chain import bridge
from studies.chain.record import Record
from studies.scene import Scene
from studies.study import Finding, Panel, StudyRecord

__all__ = ["draw", "run"]

TAKES_SCENE = True
VOLTAGE, BURSTS = 30.0, (12.0, 24.0, 48.0)  # V: of the contact, and of start and stop
BURST = 0.12  # s


@dataclass(frozen=True, kw_only=True)
class Gallery(StudyRecord):
    """What the pictures are drawn from.

    Attributes
    ----------
    record : Record
        Of the run.
    found : studies.view.run_field.RunField
    contact : tuple
        `contact_pictures.Moments` and title.
    bursts : tuple of (str, contact.Trajectory)
    acceleration : float
        mu preload / m, m/s^2.
    ledger : dict
        J, of one cycle.
    others : tuple of (module, Panel)
        Regime map and admittance, from their own studies.
    """

    record: Record = field(repr=False)
    found: object = field(repr=False)
    contact: tuple = field(repr=False)
    bursts: tuple = field(repr=False)
    acceleration: float
    ledger: dict = field(repr=False)
    others: tuple = field(repr=False)


def run(scene: str | Scene = "twente", *, progress: Callable[[str], None] | None = None) -> Gallery:
    """Return everything that the gallery draws.

    Parameters
    ----------
    scene : str or Scene
        A path, a shipped name or a scene with transducers and a slider.
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
    record = run_chain(chosen, tolerance=1e-3, progress=say)
    found = of_record(record.scene, record.to_dict(), progress=say)
    say("following the contact")
    slow = contact_moments(record.scene, record.to_dict(), level=VOLTAGE, progress=say)
    slider = bridge.contact_slider(record.scene.slider)
    orbits = bridge.orbits_per_volt(record.surface_wave, record.scene.slider)
    say("bursts")
    bursts = tuple(
        (
            f"{level:g} V",
            contact.burst(
                slider, bridge.scaled(orbits, level), duration=BURST, after=0.1, tolerance=1e-3, samples=1500
            ),
        )
        for level in BURSTS
    )
    state = contact.steady(slider, bridge.scaled(orbits, VOLTAGE), tolerance=1e-6)
    others = tuple((each, each.run(progress=say).panels[0]) for each in (regime_map, admittance))
    panel = Panel(name="wave", title=chosen.title, data={"wavelength_m": found.wavelength})
    return Gallery(
        name="gallery",
        panels=(panel,),
        findings=_findings(record, found, state, slow[0]),
        seconds=time.perf_counter() - begun,
        record=record,
        found=found,
        contact=slow,
        bursts=bursts,
        acceleration=slider.friction_coefficient * slider.preload / slider.mass,
        ledger=vars(state.ledger),
        others=others,
    )


def _findings(record: Record, found, state, slow) -> tuple[Finding, ...]:
    import numpy as np

    from studies.view.surface_pictures import anticlockwise

    top = found.field.displacement[:, -1]
    normal, tangential = top[:, 2], top[:, 0]
    driven = next(each for each in record.scene.transducer if each.name == record.scene.drive.transducer)
    places = _beside(found, driven)
    turning = anticlockwise(tangential[places], normal[places])
    away = np.sign(found.field.x[places] - driven.center)
    phase = np.unwrap(np.angle(normal[places]))
    at = found.field.x[places]
    measured = 2 * np.pi / abs(np.polyfit(at, phase, 1)[0])
    told = record.wave["normal_m_per_V"]
    amplitude = abs(found.surface(record.scene.slider.position)[1] / told - 1)
    return (
        Finding(
            statement="A Rayleigh wave turns the surface against its own direction at the crest.",
            quantity="share of places on the way from the transducer to the slider with a retrograde orbit",
            expected="1",
            found=float(np.mean(turning == (away > 0))),
            confirmed=bool(np.all(turning == (away > 0))),
        ),
        Finding(
            statement="The drawn field has the wavelength of the surface wave.",
            quantity="wavelength by the phase of the drawn u_z over that of the run, less 1",
            expected="below 1e-3",
            found=float(abs(measured / found.wavelength - 1)),
            confirmed=bool(abs(measured / found.wavelength - 1) < 1e-3),
        ),
        Finding(
            statement="The drawn field moves the surface under the slider as the run says.",
            quantity="relative difference of u_z",
            expected="below 1e-10",
            found=float(amplitude),
            confirmed=bool(amplitude < 1e-10),
        ),
        Finding(
            statement="What the wave gives the contact is accounted for.",
            quantity="residual of the ledger, relative",
            expected="below 1e-6",
            found=float(state.ledger.relative_residual),
            confirmed=bool(state.ledger.relative_residual < 1e-6),
        ),
        Finding(
            statement="The slider in slow motion runs at the steady velocity.",
            quantity="difference of the mean velocities, relative",
            expected="below 1e-6",
            found=float(abs(slow.slider_velocity.mean() / state.velocity - 1)),
            confirmed=bool(abs(slow.slider_velocity.mean() / state.velocity - 1) < 1e-6),
        ),
    )


def draw(gallery: Gallery, folder: Path, *, progress: Callable[[str], None]) -> None:
    """Draw the gallery's pictures into a directory."""
    from studies.view.gallery_pictures import draw_all

    draw_all(gallery, folder, voltage=VOLTAGE, progress=progress)


def _beside(found, driven):
    """Lines between the driven transducer and the slider."""
    ends = sorted((driven.center, found.scene.slider.position))
    x = found.field.x
    return (x > ends[0]) & (x < ends[1]) & ~found.near_transducer(x)


if __name__ == "__main__":
    from studies.__main__ import main

    sys.exit(main(["study", "gallery", *sys.argv[1:]]))
