"""The energy balance of a run's contact at a few of its points: where the work of the wave goes, as mean powers."""

from dataclasses import dataclass

from studies.chain.bridge import DrivenContact
from studies.chain.points import SHARE, STEADY_METHODS
from studies.record import Record

MAX_POINTS = 3  # the first that moves, one between, the last
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
}  # what the wave gives, where it goes, and what is stored, which in a steady state is nothing
STORED = ("stored", "lifted", "slider")


@dataclass(frozen=True, kw_only=True)
class Balance:
    """Mean powers at one point, W, over all contacts; what the balance misses over the work of the wave."""

    level: float
    entries: tuple[tuple[str, float], ...]
    residual: float


def balances(record: Record) -> tuple[Balance, ...]:
    """Return the balance of the steady state at a few points of a record with a slider; those at rest have none."""
    import contact

    scene = record.scene
    if scene.slider is None or scene.slider.pillars is not None:  # the points have these powers
        return ()
    driven = DrivenContact.of_run(record)
    share = len(scene.slider.offsets) if isinstance(scene.slider.contacts, int) else 1
    method = scene.slider.method if scene.slider.method in STEADY_METHODS else "auto"
    rows = []
    for level in _chosen(record):
        options = {"tolerance": record.tolerance * SHARE, "method": method}
        state = contact.steady(driven.slider, driven.at(level), **options)
        power = share * scene.frequency
        spent = {name: text for name, text in LEDGER.items() if name not in STORED}
        entries = tuple((text, getattr(state.ledger, name) * power) for name, text in spent.items())
        rows.append(Balance(level=level, entries=entries, residual=state.ledger.relative_residual))
    return tuple(rows)


def _chosen(record: Record) -> list[float]:
    moving = sorted({point[record.level] for point in record.points if point.get("velocity_m_per_s")})
    if len(moving) <= MAX_POINTS:
        return moving
    return [moving[0], moving[len(moving) // 2], moving[-1]]
