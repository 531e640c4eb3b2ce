"""Pictures of where power and energy go: along the stator, at the transducer, in one cycle of the contact.

Every function takes plain numbers and returns a matplotlib Figure; nothing is shown or written.
"""

import numpy as np

from studies.report.figures import COLOURS, legend_below
from studies.view.surface_pictures import MM, new_figure

__all__ = ["depth_weights", "ledger_bars", "power_along", "power_bars"]

LEDGER = {
    "wave_normal": "wave, normal force",
    "wave_tangential": "wave, friction force",
    "slip": "lost in slip",
    "contact_damper": "damper in the contact",
    "normal_damper": "normal damper",
    "tangential_damper": "tangential damper",
    "load": "work against the load",
    "leak": "leak of the elastic law",
    "stored": "held by the springs",
    "lifted": "held by the preload",
    "slider": "held by the slider",
}
GIVEN = ("wave_normal", "wave_tangential")


def power_bars(electrical: dict, *, title: str):
    """Draw the powers of ``electrical`` of run.json: given by the source, sent out as waves, lost."""
    rows = (
        ("given by the source", electrical["power_W_per_V2"], "slip"),
        ("sent out beyond the transducers", electrical["power_radiated_W_per_V2"], "second"),
        ("lost in the solid", electrical["power_dissipated_W_per_V2"], "intermittent"),
    )
    figure, ax = new_figure(7.2, 2.3)
    _bars(ax, [(name, value * 1e3, COLOURS[colour]) for name, value, colour in rows], "mW per V^2")
    ax.set_xlabel("power (mW per V^2 of the source, peak)")
    ax.set_title(f"{title}\npower of the driven transducer", fontsize="medium")
    return figure


def power_along(x, power, *, covered, given: float, title: str):
    """Draw the power (W per V^2) that passes each line of the stator, between the transducers that cover it."""
    figure, ax = new_figure(7.2, 3.4)
    ax.plot(
        x * MM,
        power * 1e3,
        color=COLOURS["slip"],
        linewidth=1.2,
        label="through the section, mean of a cycle",
    )
    for sign in (1, -1):
        label = "half of what the source gives" if sign > 0 else None
        ax.axhline(sign * 0.5e3 * given, color=COLOURS["line"], linestyle=":", linewidth=1, label=label)
    for start, stop in covered:
        ax.axvspan(start * MM, stop * MM, color=COLOURS["stick"], alpha=0.3, linewidth=0)
    ax.axhline(0, color=COLOURS["line"], linewidth=0.6)
    ax.set_xlabel("x along the surface (mm)")
    ax.set_ylabel("power along +x (mW per V^2)")
    ax.set_title(f"{title}\npower flow (grey: transducers)", fontsize="medium")
    ax.grid(alpha=0.3)
    legend_below(ax)
    return figure


def ledger_bars(ledger: dict, *, title: str):
    """Draw the energies (J) of one cycle of the contact by attribute of its ledger: from the wave, and to where."""
    largest = max(abs(value) for value in ledger.values()) or 1.0
    rows = [
        (name, ledger[key] * 1e12, COLOURS["slip" if key in GIVEN else "intermittent"])
        for key, name in LEDGER.items()
        if key in GIVEN or abs(ledger[key]) > 1e-6 * largest
    ]
    figure, ax = new_figure(7.2, 1.2 + 0.33 * len(rows))
    _bars(ax, rows, "pJ")
    given = sum(ledger[key] for key in GIVEN)
    missed = given - sum(ledger[key] for key in LEDGER if key not in GIVEN)
    balance = f"balance to {abs(missed) / largest:.0e} of the largest"
    ax.set_xlabel("energy in one cycle of the wave (pJ); blue: from the wave, orange: to where")
    ax.set_title(f"{title}\nledger of one contact, {balance}", fontsize="medium")
    return figure


def depth_weights(z: np.ndarray, order: int) -> np.ndarray:
    """Return the weights that integrate values at the nodes over the depth, exactly for polynomials of the order."""
    from fem import reference_matrices

    lumped = reference_matrices(order).mass.sum(axis=1)
    weights = np.zeros(len(z))
    for part, height in enumerate(np.diff(z[::order])):
        weights[part * order : (part + 1) * order + 1] += height * lumped
    return weights


def _bars(ax, rows, unit: str) -> None:
    places = np.arange(len(rows))[::-1]
    values = [value for _, value, _ in rows]
    ax.barh(places, values, color=[colour for *_, colour in rows], height=0.62)
    ax.set_yticks(places, [name for name, *_ in rows])
    low, high = min([0.0, *values]), max([0.0, *values])
    reach = (high - low) or 1.0
    for place, value in zip(places, values, strict=True):
        side = "left" if value >= 0 else "right"
        ax.text(
            value + (0.01 if value >= 0 else -0.01) * reach, place, f"{value:.3g} {unit}", va="center", ha=side,
            fontsize="small",
        )  # fmt: skip
    ax.axvline(0, color=COLOURS["line"], linewidth=0.8)
    ax.set_xlim(low - (0.45 * reach if low < 0 else 0), high + 0.45 * reach)
    ax.grid(alpha=0.3, axis="x")
