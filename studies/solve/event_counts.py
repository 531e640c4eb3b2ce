"""Statistics of the motion at a point of a run: events by kind, smallest gap, chatter, residual of the energy balance.

The dictionaries are flat, because their keys are also columns of velocity.csv.  Events of steady states are counted per
wave cycle; those of a burst that was solved event by event over the burst, and over the slide after it.
"""

import math

import numpy as np

EVENTS = ("contact", "release", "stick_to_slip", "slip_to_stick", "reversal", "graze")


def steady_tally(state) -> dict:
    """Return the tally of a `contact.SteadyState`; empty where a closed form answers."""
    counted = state.statistics
    if "contact" not in counted:
        return {}
    cycles = counted.get("averaged_cycles", 1)
    tally = {f"{name}_per_cycle": counted[name] / cycles for name in EVENTS}
    if counted.get("period_cycles", 1) != 1:
        tally["period_cycles"] = counted["period_cycles"]  # 0: none was seen
    if state.other_velocity is not None:
        tally["other_velocity_m_per_s"] = state.other_velocity
    tally |= _gap("", counted) | {"chatter": bool(counted["chatter"])}
    if state.regime != "stick":  # there the wave does no work to compare with
        tally["ledger_relative_residual"] = state.ledger.relative_residual
    return tally


def burst_values(trajectory) -> dict[str, float]:
    """Return the columns of a point for the motion of a slider in a burst."""
    followed = trajectory.displacement  # along a track
    displacement = float(np.trapezoid(trajectory.velocity, trajectory.time) if followed is None else followed[-1])
    return {"velocity_at_burst_end_m_per_s": trajectory.velocity_at_burst_end, "displacement_m": displacement}


def burst_tally(trajectory) -> dict:
    """Return the tally of a `contact.Trajectory`."""
    counted, tally = trajectory.statistics, {"burst_method": trajectory.method}
    for prefix, name in (("", "burst"), ("after_", "after")):
        if f"{prefix}contact" not in counted:
            continue
        tally |= {f"{name}_{event}": counted[f"{prefix}{event}"] for event in EVENTS}
        tally |= _gap(f"{name}_", counted, prefix) | {f"{name}_chatter": bool(counted[f"{prefix}chatter"])}
    for name, book in (("burst", trajectory.ledger), ("after", trajectory.after_ledger)):
        if book is not None:
            tally[f"{name}_ledger_relative_residual"] = book.relative_residual
    return tally


def _gap(name, counted, prefix=""):
    """Return the smallest gap, where there were two events."""
    gap = counted.get(f"{prefix}smallest_gap", math.inf)
    return {f"{name}smallest_gap_s": gap} if math.isfinite(gap) else {}
