"""Energy balance of the contact at a few points of a run: mean powers supplied by the wave and dissipated."""

from dataclasses import dataclass

import contact
from studies.model.wave_to_contact import Contact
from studies.record import Record
from studies.solve.refinement import SHARE
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
    "adhesion": "lost by closing and opening",
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
    if driven.rough:
        return _of_rough_balls(record, driven)
    method = scene.slider.method if scene.slider.method in STEADY_METHODS else "auto"
    goal, results = record.tolerance * SHARE, []
    for level in _levels(record):
        state = contact.steady(driven.slider, driven.at(level), tolerance=goal, method=method)
        results.append(_balance(driven, level, state.ledger, scene.slider.share))
    return tuple(results)


def _balance(driven: Contact, level: float, ledger, share: int) -> Balance:
    """Return the powers of a cycle's ledger, of which the slider has a number of equal parts."""
    power = share * driven.scene.frequency
    absent = STORED if driven.holding else (*STORED, "adhesion")
    shown = {name: text for name, text in LEDGER.items() if name not in absent}
    entries = tuple((text, getattr(ledger, name) * power) for name, text in shown.items())
    return Balance(level=level, entries=entries, residual=ledger.relative_residual)


def _levels(record: Record) -> list[float]:
    """Return at most `MAX_POINTS` of the levels at which the slider moves."""
    moving = record.moving_levels
    return [moving[0], moving[len(moving) // 2], moving[-1]] if len(moving) > MAX_POINTS else moving


def _of_rough_balls(record: Record, driven: Contact) -> tuple[Balance, ...]:
    """Return the balances of rough balls."""
    from studies.solve.rough_answer import rough_ledger

    share = 1 if record.scene.slider.roughness.sampled else record.scene.slider.share  # as of `rough_balls`
    return tuple(
        _balance(driven, level, rough_ledger(driven, level, record.tolerance), share) for level in _levels(record)
    )
