"""Whether the finite-element cell gives the Rayleigh wave of the half-space, and at what cost.

Method: the periodic one-wavelength cell of PZT-4, bare (D_n = 0) and metallised, at several orders and
refinements, against the half-space without a mesh: velocity, surface ratio, profile with depth, and wall
time (best of three). Expected: errors of the velocity fall as h^(2p), as the theory of a symmetric
eigenproblem has it; 1e-9 within 3000 unknowns; high orders win by far.  Run time: about 10 s.
"""

import math
import time
from collections.abc import Callable

from studies.study import Finding, Panel, StudyRecord, of_record

__all__ = ["figure", "run"]

MATERIAL = "PZT-4"
SURFACES = ("open", "metallised")
# order: columns along half a wavelength; four layers of depth for each
MESHES = {1: (4, 8, 16), 2: (2, 4, 8, 16), 3: (1, 2, 4, 8), 4: (1, 2, 4), 6: (1, 2, 3), 8: (1, 2)}
LAYERS_PER_COLUMN = 4
FLOOR = 1e-12  # rounding: below it nothing converges any more
REPEATS = 3
QUICK = {"meshes": {2: (2, 4), 8: (1,)}, "repeats": 1}
DEPTHS = tuple(k / 50 for k in range(101))  # wavelengths


def run(
    *,
    surfaces: tuple[str, ...] = SURFACES,
    meshes: dict[int, tuple[int, ...]] = MESHES,
    repeats: int = REPEATS,
    progress: Callable[[str], None] | None = None,
) -> StudyRecord:
    """Return velocity errors, unknowns and times of every mesh, and the profile at order 8.

    Parameters
    ----------
    surfaces : tuple of str
        Electric conditions, of `SURFACES`.
    meshes : dict
        Columns of elements in a wavelength, from coarse to fine, for each order.
    repeats : int
        Of each solution; the shortest time counts.
    progress : callable, optional
        Told what is being done.
    """
    import numpy as np

    import fem
    from studies.evidence.peers.periodic_wave import periodic_wave

    begun = time.perf_counter()
    say = progress or (lambda text: None)
    solid = fem.material(MATERIAL)
    panels, findings = [], []
    for surface in surfaces:
        exact = fem.rayleigh(solid, surface)
        table = {"order": [], "columns": [], "unknowns": [], "relative_error": [], "seconds": []}
        for order, sizes in meshes.items():
            for columns in sizes:
                say(f"{surface}: order {order}, {columns} columns")
                wave, seconds = _timed(periodic_wave, solid, surface, order, columns, repeats)
                row = (order, columns, wave.unknowns, abs(wave.velocity / exact.velocity - 1), seconds)
                for column, value in zip(table.values(), row, strict=True):
                    column.append(value)
        panels.append(
            Panel(name=f"convergence_{surface}", title=f"{MATERIAL}, {surface} surface", data=table)
        )
        findings += [*_orders(table, surface), _best(table, surface)]
        best, _ = _timed(periodic_wave, solid, surface, 8, 2, repeats)
        depths = np.array(DEPTHS)
        meshed, analytic = best.profile(depths)[0], exact.profile(depths)[0]
        data = {"depth_wavelengths": depths, "half_space": analytic, "cell": meshed}
        panels.append(Panel(name=f"profile_{surface}", title=f"{MATERIAL}, {surface} surface", data=data))
        findings += [
            Finding(
                statement=f"The profile with depth is that of the half-space ({surface}).",
                quantity="largest difference over u_z at the surface, order 8",
                expected="below 1e-6: errors of shapes are the square roots of those of velocities",
                found=float(np.max(abs(meshed - analytic))),
                confirmed=bool(np.max(abs(meshed - analytic)) < 1e-6),
            ),
            Finding(
                statement=f"The surface ratio is that of the half-space ({surface}).",
                quantity="relative difference of |u_x/u_z|, order 8",
                expected="below 1e-6",
                found=abs(best.surface_ratio / exact.surface_ratio - 1),
                confirmed=abs(best.surface_ratio / exact.surface_ratio - 1) < 1e-6,
            ),
        ]
    return StudyRecord(
        name="rayleigh", panels=tuple(panels), findings=tuple(findings), seconds=time.perf_counter() - begun
    )


@of_record
def figure(record: Panel, ax):
    """Draw the error against run time for each order, or the profile with depth."""
    if "half_space" in record.data:
        return _profile(record, ax)
    import matplotlib

    table = record.data
    colours = matplotlib.colormaps["cividis"]
    orders = list(dict.fromkeys(table["order"]))
    for index, order in enumerate(orders):
        rows = [row for row, p in enumerate(table["order"]) if p == order]
        x, y = ([table[key][row] for row in rows] for key in ("seconds", "relative_error"))
        colour = colours(0.9 * index / max(len(orders) - 1, 1))
        ax.loglog(x, y, "o-", color=colour, markersize=4, linewidth=0.8, label=f"order {order}")
        for row in rows:
            ax.annotate(
                str(table["unknowns"][row]), (table["seconds"][row], table["relative_error"][row]), fontsize=6
            )
    ax.axhline(1e-9, color="black", linestyle=":", linewidth=0.8)
    ax.set_xlabel("run time (s); beside the points: unknowns (1)")
    ax.set_ylabel("error of the velocity (relative)")
    ax.set_title(record.title, fontsize="medium")
    ax.grid(alpha=0.3)
    ax.legend(frameon=False)
    return ax


def _profile(record: Panel, ax):
    from studies.record.plots import COLOURS

    depth = record.data["depth_wavelengths"]
    for axis, name, colour in ((0, "Im u_x", "intermittent"), (2, "Re u_z", "slip")):
        exact, cell = (record.data[key][:, axis] for key in ("half_space", "cell"))
        exact, cell = (exact.imag, cell.imag) if axis == 0 else (exact.real, cell.real)
        ax.plot(depth, exact, color=COLOURS[colour], linewidth=1, label=f"{name}, half-space")
        ax.plot(
            depth[::4], cell[::4], "o", color=COLOURS[colour], markersize=3, label=f"{name}, cell of order 8"
        )
    ax.set_xlabel("depth (wavelengths)")
    ax.set_ylabel("displacement over u_z at the surface (1)")
    ax.set_title(record.title, fontsize="medium")
    ax.grid(alpha=0.3)
    ax.legend(frameon=False)
    return ax


def _timed(solve: Callable, solid, surface: str, order: int, columns: int, repeats: int):
    """Return the wave and the shortest of a few wall times in s."""
    times = []
    for _ in range(repeats):
        begun = time.perf_counter()
        elements = columns, LAYERS_PER_COLUMN * columns
        wave = solve(solid, 1e-3, order=order, surface=surface, elements=elements)
        times.append(time.perf_counter() - begun)
    return wave, min(times)


def _orders(table: dict, surface: str) -> list[Finding]:
    """Return the order observed on the two finest meshes above the rounding, for each element order."""
    findings = []
    for order in dict.fromkeys(table["order"]):
        rows = [
            row
            for row, p in enumerate(table["order"])
            if p == order and table["relative_error"][row] > 10 * FLOOR
        ]
        if len(rows) < 2:
            continue
        coarse, fine = rows[-2:]
        gain = math.log(table["relative_error"][coarse] / table["relative_error"][fine])
        observed = gain / math.log(table["columns"][fine] / table["columns"][coarse])
        findings.append(
            Finding(
                statement=f"Order {order} converges as h^{2 * order} ({surface}).",
                quantity="order observed on the two finest meshes",
                expected=f"{2 * order}, within 10 %",
                found=observed,
                confirmed=abs(observed / (2 * order) - 1) < 0.1,
            )
        )
    return findings


def _best(table: dict, surface: str) -> Finding:
    errors = [
        error
        for error, unknowns in zip(table["relative_error"], table["unknowns"], strict=True)
        if unknowns <= 3000
    ]
    return Finding(
        statement=f"3000 unknowns give the velocity to nine digits ({surface}).",
        quantity="smallest relative error of the velocity within 3000 unknowns",
        expected="at most 1e-9",
        found=min(errors),
        confirmed=min(errors) <= 1e-9,
    )
