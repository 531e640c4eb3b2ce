"""Statistics of the motion at a point of a run: events by kind, smallest gap, chatter, residual of the energy balance.

Events of steady states are counted per wave cycle; those of a burst that was solved event by event over the burst, and
over the slide after it.
"""

import math

import numpy as np

from studies.record.point import Point

EVENTS = ("contact", "release", "stick_to_slip", "slip_to_stick", "reversal", "graze")


def steady_events(state) -> Point:
    """Return the events of a `contact.SteadyState`; empty where a closed form answers."""
    counted = state.statistics
    if "contact" not in counted:
        return Point()
    cycles, period = counted.get("averaged_cycles", 1), counted.get("period_cycles", 1)
    return Point(
        **{f"{name}_per_cycle": counted[name] / cycles for name in EVENTS},
        period_cycles=None if period == 1 else period,  # 0: none was seen
        other_velocity_m_per_s=state.other_velocity,
        smallest_gap_s=_gap(counted),
        chatter=bool(counted["chatter"]),
        # of a slider that sticks the wave does no work to compare with
        ledger_relative_residual=None if state.regime == "stick" else state.ledger.relative_residual,
    )


def burst_values(trajectory) -> Point:
    """Return velocity at the burst's end and displacement of a slider in a burst."""
    followed = trajectory.displacement  # along a track
    displacement = float(np.trapezoid(trajectory.velocity, trajectory.time) if followed is None else followed[-1])
    return Point(velocity_at_burst_end_m_per_s=trajectory.velocity_at_burst_end, displacement_m=displacement)


def burst_events(trajectory) -> Point:
    """Return the events of a `contact.Trajectory`."""
    counted, events = trajectory.statistics, Point(burst_method=trajectory.method)
    for prefix, name in (("", "burst"), ("after_", "after")):
        if f"{prefix}contact" in counted:
            columns = {f"{name}_{event}": counted[f"{prefix}{event}"] for event in EVENTS}
            columns |= {f"{name}_smallest_gap_s": _gap(counted, prefix)}
            events |= Point(**columns, **{f"{name}_chatter": bool(counted[f"{prefix}chatter"])})
    for name, book in (("burst", trajectory.ledger), ("after", trajectory.after_ledger)):
        if book is not None:
            events |= Point(**{f"{name}_ledger_relative_residual": book.relative_residual})
    return events


def _gap(counted, prefix="") -> float | None:
    """Return the smallest gap in s, where there were two events."""
    gap = counted.get(f"{prefix}smallest_gap", math.inf)
    return gap if math.isfinite(gap) else None
