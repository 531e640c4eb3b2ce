"""Energy balance of the contact at a few points of a run: mean powers supplied by the wave and dissipated."""

from dataclasses import dataclass

import contact
from studies.record import Record
from studies.solve.contact_at_level import SHARE
from studies.solve.slider_burst import STEADY_METHODS
from studies.solve.solved_stator import contact_of_run

MAX_POINTS = 3  # first moving point, middle point, last point
LEDGER = {
    "wave_normal": "wave, normal force",
    "wave_tangential": "wave, friction force",
    "slip": "lost in slip",
    "contact_damper": "damper in the contact",
    "normal_damper": "normal damper",
    "tangential_damper": "tangential damper",
    "load": "work against the load",
    "leak": "not conserved by the elastic law",
    "stored": "held by the springs",
    "lifted": "held by the preload",
    "slider": "held by the slider",
}  # text by ledger entry: supplied energies, dissipated energies, stored energies (zero in a steady state)
STORED = ("stored", "lifted", "slider")


@dataclass(frozen=True, kw_only=True)
class Balance:
    """Mean powers in W over all contacts at one point, and the residual of the balance relative to the wave's work."""

    level: float
    entries: tuple[tuple[str, float], ...]
    residual: float


def balances(record: Record) -> tuple[Balance, ...]:
    """Return the energy balances of the steady state at a few moving points of a record with a slider."""
    scene = record.scene
    # the points of a slider on a passing wave already contain these powers
    if scene.slider is None or any(point.friction_power_W is not None for point in record.points):
        return ()
    driven = contact_of_run(record)
    method = scene.slider.method if scene.slider.method in STEADY_METHODS else "auto"
    power = scene.slider.share * scene.frequency
    shown = {name: text for name, text in LEDGER.items() if name not in STORED}
    results = []
    moving = record.moving_levels
    if len(moving) > MAX_POINTS:
        moving = [moving[0], moving[len(moving) // 2], moving[-1]]
    for level in moving:
        state = contact.steady(driven.slider, driven.at(level), tolerance=record.tolerance * SHARE, method=method)
        entries = tuple((text, getattr(state.ledger, name) * power) for name, text in shown.items())
        results.append(Balance(level=level, entries=entries, residual=state.ledger.relative_residual))
    return tuple(results)
