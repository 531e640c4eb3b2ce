"""The ledger of a run's contact: where the work of the wave goes, at a few of its points, as mean powers."""

from dataclasses import dataclass

from studies.chain import SHARE
from studies.chain.driven_contact import DrivenContact
from studies.chain.points import STEADY_METHODS
from studies.record import Record

__all__ = ["Balance", "balances"]

MOST = 3  # points: the first that moves, one between, the last
ENTRIES = (
    ("wave_normal", "work of the wave through the normal force"),
    ("wave_tangential", "work of the wave through the tangential force"),
    ("slip", "lost in slip"),
    ("contact_damper", "lost in R_n1"),
    ("normal_damper", "lost in R_n2"),
    ("tangential_damper", "lost in R_t"),
    ("load", "work against the load"),
    ("leak", "leak of the elastic law without the reciprocal force"),
)


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
    if scene.slider is None:
        return ()
    driven = DrivenContact.of_run(record)
    share = len(scene.slider.offsets) if isinstance(scene.slider.contacts, int) else 1
    method = scene.slider.method if scene.slider.method in STEADY_METHODS else "auto"
    found = []
    for level in _chosen(record):
        given = {"tolerance": record.tolerance * SHARE, "method": method}
        state = contact.steady(driven.slider, driven.at(level), **given)
        power = share * scene.frequency
        entries = tuple((text, getattr(state.ledger, name) * power) for name, text in ENTRIES)
        found.append(Balance(level=level, entries=entries, residual=state.ledger.relative_residual))
    return tuple(found)


def _chosen(record: Record) -> list[float]:
    moving = sorted({point[record.level] for point in record.points if point.get("velocity_m_per_s")})
    if len(moving) <= MOST:
        return moving
    return [moving[0], moving[len(moving) // 2], moving[-1]]
