"""Pictures of the study ``gallery``: orbits, amplitude, depth profile, start and stop, power, ledger, wave and contact.

`draw_all` takes the results of the study. The other functions take plain numbers and return a matplotlib Figure. Lines
show theory, points show computed values.
"""

import logging
from functools import partial
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image

import fem
from fem import reference_matrices
from studies.model.model import model_of
from studies.record.plots import COLOURS, arrow, curve, finished, legend_below, new_figure, saved, shaded, titled
from studies.record.quantities import Quantity, quantity
from studies.record.run_pictures import surface, velocity
from studies.report.energies import LEDGER
from studies.view import movie
from studies.view.contact_view import film_contact, strip
from studies.view.field_quantities import MOTIONS, QUANTITIES, palette
from studies.view.picture import Picture
from studies.view.view_options import NORMAL
from studies.view.views import span_views, views

LOGGER = logging.getLogger(__name__)

TURN = np.linspace(0.0, 2 * np.pi, 121)
ORBITS = 12
MOVIE, SOLID, STILL = (720, 300), (1000, 470), (1200, 720)
FRAMES = 16
PALETTE_COLOURS = 128  # palette size of a diagram
DPI = 110
DEPTH = 3.0  # of the depth profile, in wavelengths
FIELD = {"quantity": NORMAL, "phase": 0.0, "factor": None}
SUPPLIED = ("wave_normal", "wave_tangential")


def draw_all(gallery, folder: Path) -> None:
    """Draw the pictures of a gallery into a directory."""
    run, record = gallery.wave_field, gallery.record
    title = record.scene.title
    positions = (np.arange(ORBITS) + 0.5) / ORBITS * run.length
    energies = run.with_energies
    passing = energies.densities.power_flow[..., 0] @ depth_weights(energies.z, energies.order) * run.aperture
    power = record.electrical.power_W_per_V2
    ledger, balance = ledger_entries(gallery.ledger)
    for picture, figure in (
        ("orbits", orbits(positions, *np.array([run.surface(x) for x in positions]).T, title=title)),
        ("amplitude", amplitude(record, wavelength=run.wavelength, focus=run.focus)),
        ("depth", _depth(run)),
        ("contact", strip(gallery.contact[0], title=gallery.contact[1])),
        ("start_stop", start_and_stop(gallery.bursts, acceleration=gallery.acceleration, title=title)),
        ("power", bars(powers(record.electrical), quantity.transducer_power_W_per_V2,
                       f"{title}\npower of the driven transducer")),
        ("power_flow", power_along(run.field.x, passing, covered=run.spans, fed=power, title=title)),
        ("ledger", bars(ledger, quantity.cycle_energy_J,
                        f"{title}: {gallery.voltage:g} V\nledger of one contact, {balance}",
                        remark="; blue: from the wave, orange: taken up")),
    ):  # fmt: skip
        LOGGER.info(f"drawing {picture}")
        figure.savefig(folder / f"{picture}.png", dpi=DPI)
        _reduce(folder / f"{picture}.png")
    for picture, name in (("wave", NORMAL), ("wave_power_flow", "power_flow")):
        LOGGER.info(f"drawing {picture}")
        still(Picture(run, views(run), size=STILL, **(FIELD | {"quantity": name})), folder / f"{picture}.png")
    others = {panel.name: partial(module.figure, panel) for module, panel in gallery.others}
    for picture, draw in {"velocity": partial(velocity, record), **others}.items():
        saved(folder / f"{picture}.png", draw)
        _reduce(folder / f"{picture}.png")
    if gallery.films:
        _films(gallery, folder)


def orbits(positions, tangential, normal, *, title: str):
    """Draw the orbits of surface points at positions in m, from complex u_x and u_z in m per V."""
    columns = min(6, len(positions))
    rows = -(-len(positions) // columns)
    size, shared = ((1.35 * columns + 0.6, 1.55 * rows + 0.7), {"sharex": True, "sharey": True, "squeeze": False})
    figure, axes = new_figure(*size, rows=rows, columns=columns, **shared)
    is_anticlockwise = anticlockwise(tangential, normal)
    (across, up), along = (QUANTITIES[name].entry(False) for name in MOTIONS[::2]), quantity.x_m
    components = up.scale * np.array([tangential, normal])
    limit = 1.15 * abs(components).max()
    for number, ax in enumerate(axes.flat):
        if number >= len(positions):
            ax.set_visible(False)
            continue
        motion, colour = components[:, number, None], "slip" if is_anticlockwise[number] else "intermittent"
        u_x, u_z = (motion * np.exp(1j * TURN)).real
        curve(ax, u_x, u_z, "-", colour)
        # omega t of the largest u_z; the arrow marks the direction of motion there
        crest = -np.angle(motion[1])
        tail, head = (motion * np.exp(1j * (crest + np.array([-0.35, 0.35])))).real.T
        arrow(ax, tail, head, COLOURS[colour], width=1.0)
        ax.plot([0], [0], "+", color=COLOURS["line"], markersize=5)
        ax.set_title(f"x = {along.with_unit(positions[number])}", fontsize="small")
        ax.set(aspect="equal", xlim=(-limit, limit), ylim=(-limit, limit))
        ax.tick_params(labelsize="x-small")
        ax.grid(alpha=0.3)
    figure.supxlabel(f"{across.axis}; arrow: motion at the crest", fontsize="small")
    figure.supylabel(up.axis, fontsize="small")
    colours = f"{is_anticlockwise.sum()} anticlockwise (blue), {(~is_anticlockwise).sum()} clockwise (orange)"
    figure.suptitle(f"{title}\nsurface orbits, {colours}", fontsize="medium")
    return figure


def anticlockwise(tangential, normal) -> np.ndarray:
    """Return whether orbits are anticlockwise, for x to the right and z upwards: x dz/dt - z dx/dt > 0.

    The orbits of a Rayleigh wave towards +x are anticlockwise (retrograde: at a crest, the surface moves against the
    wave). Those of a wave towards -x are clockwise.

    Examples
    --------
    >>> bool(anticlockwise(1j, 1.0)), bool(anticlockwise(-1j, 1.0))
    (True, False)
    """
    return np.imag(np.asarray(tangential) * np.conj(normal)) > 0


def amplitude(record, *, wavelength: float, focus: tuple[str, float]):
    """Draw |u_x| and |u_z| along the surface, and within 4 wavelengths of ``focus`` = (name, position in m)."""
    figure, (whole, near) = new_figure(7.2, 5.6, rows=2)
    name, middle = focus
    size = abs(record.surface.u_z_m_per_V[abs(record.surface.x_m - middle) <= wavelength])
    surface(record, whole, window=False)
    surface(record, near, curves=True)
    whole.get_legend().remove()
    titled(whole, f"{record.scene.title}\namplitude along the surface (grey: transducers)")
    near.set_xlim(*((middle + np.array([-4, 4]) * wavelength) * quantity.x_m.scale))
    ripple = f"largest over smallest |u_z| {size.max() / size.min():.3g} within one"
    titled(near, f"within 4 wavelengths of the {name}: {ripple}")
    return figure


def depth_profile(line_depth, analytic, computed, *, title: str):
    """Draw computed depth profiles, name to (depth in wavelengths, components by name), on those of the half-space."""
    figure, ax = new_figure(7.2, 4.2)
    for (name, values), colour in zip(analytic.items(), ("slip", "intermittent"), strict=True):
        curve(ax, line_depth, values, "-", colour, f"{name}, half-space (theory)")
    for number, (what, (depth, parts)) in enumerate(computed.items()):
        for (name, values), colour, mark in zip(parts.items(), ("slip", "intermittent"), "o^", strict=True):
            curve(ax, depth, values, mark, "stick" if number else colour, f"{name}, {what}", size=3.5)
            ax.lines[-1].set_zorder(2 - number)
    ax.axhline(0, color=COLOURS["line"], linewidth=0.6)
    finished(ax, quantity.depth_wavelengths.axis, quantity.relative_displacement.axis, title, columns=2)
    return figure


def start_and_stop(trajectories, *, acceleration: float, title: str):
    """Draw the velocity in bursts, an enlarged view of the stop, and the largest acceleration (m/s^2) by friction."""
    figure, (whole, end) = new_figure(7.6, 6.0, rows=2)
    time, after_burst, up = quantity.time_s, quantity.time_after_burst_s, quantity.velocity_m_per_s
    colours = matplotlib.colormaps["cividis"](np.linspace(0.0, 0.85, len(trajectories)))
    for (name, motion), colour in zip(trajectories, colours, strict=True):
        after = motion.time >= motion.duration - 1e-12
        whole.plot(motion.time * time.scale, motion.velocity * up.scale, color=colour, linewidth=1.3, label=name)
        later = motion.time[after] - motion.duration
        end.plot(later * after_burst.scale, motion.velocity[after] * up.scale, color=colour)
    fastest = max((motion for _, motion in trajectories), key=lambda each: abs(each.velocity_at_burst_end))
    last = fastest.velocity_at_burst_end
    sign, label = np.sign(last) or 1.0, "mu preload / m (theory)"
    fall, rise = (np.array([0.0, speed / acceleration]) for speed in (abs(last), abs(fastest.velocity).max()))
    curve(end, fall * after_burst.scale, (last - sign * acceleration * fall) * up.scale, ":", "line", label)
    curve(whole, rise * time.scale, sign * acceleration * rise * up.scale, ":", "line", label)
    whole.axvline(fastest.duration * time.scale, color=COLOURS["stick"], linewidth=1, label="end of the burst")
    finished(whole, time.axis, up.axis, f"{title}\nstart and stop", columns=0)
    finished(end, after_burst.axis, up.axis, "", columns=0)
    legend_below(end, whole.get_legend_handles_labels()[0], columns=5)
    return figure


def powers(electrical: dict) -> list[tuple[str, float, str]]:
    """Return (name, power in W per V^2, colour) for the source, the radiated and the dissipated power."""
    return [
        (name, electrical[f"power_{key}W_per_V2"], COLOURS[colour])
        for name, key, colour in (
            ("delivered by the source", "", "slip"),
            ("sent out beyond the transducers", "radiated_", "second"),
            ("lost in the solid", "dissipated_", "intermittent"),
        )
    ]


def ledger_entries(ledger) -> tuple[list[tuple[str, float, str]], str]:
    """Return (name, energy in J, colour) for one cycle of the contact, and a text on the residual of the balance."""
    energies = {key: getattr(ledger, key) for key in LEDGER}
    largest = max(map(abs, energies.values())) or 1.0
    entries = [
        (name, energies[key], COLOURS["slip" if key in SUPPLIED else "intermittent"])
        for key, name in LEDGER.items()
        if key in SUPPLIED or abs(energies[key]) > 1e-6 * largest
    ]
    missed = sum(energies[key] * (1 if key in SUPPLIED else -1) for key in LEDGER)
    return entries, f"balance to {abs(missed) / largest:.0e} of the largest"


def bars(entries, drawn: Quantity, title: str, *, remark: str = ""):
    """Draw a bar chart of entries (name, value in SI units, colour); ``remark`` follows the label of the axis."""
    figure, ax = new_figure(7.2, 1.2 + 0.33 * len(entries))
    names, sizes, colours = zip(*entries, strict=True)
    heights, values = np.arange(len(entries))[::-1], [size * drawn.scale for size in sizes]
    bar_container = ax.barh(heights, values, color=colours, height=0.62)
    ax.bar_label(bar_container, [*map(drawn.with_unit, sizes)], padding=3, fontsize="small")
    ax.set_yticks(heights, names)
    low, high = min([0.0, *values]), max([0.0, *values])
    extent = (high - low) or 1.0
    ax.axvline(0, color=COLOURS["line"], linewidth=0.8)
    ax.set_xlim(low - (0.45 * extent if low < 0 else 0), high + 0.45 * extent)
    finished(ax, drawn.axis + remark, "", title, columns=0)
    return figure


def power_along(x, power, *, covered, fed: float, title: str):
    """Draw the power (W per V^2) through each cross-section of the stator, with the transducers shaded.

    ``fed`` is the power in W per V^2 that the source gives. Half of it to each side is drawn for comparison, because a
    bidirectional transducer radiates equally to both. ``covered``: spans in m of the transducers along x.
    """
    figure, ax = new_figure(7.2, 3.4)
    along, up = quantity.x_m, quantity.power_flow_W_per_V2
    curve(ax, x * along.scale, power * up.scale, "-", "slip", "through the section, mean of a cycle")
    for share, label in ((0.5, "half of what the source gives"), (-0.5, None)):
        ax.axhline(share * fed * up.scale, color=COLOURS["line"], linestyle=":", linewidth=1, label=label)
    for span in covered:
        shaded(ax, *np.multiply(span, along.scale))
    ax.axhline(0, color=COLOURS["line"], linewidth=0.6)
    title = f"{title}\npower flow (grey: transducers)"
    finished(ax, along.axis, up.axis, title)
    return figure


def depth_weights(z: np.ndarray, order: int) -> np.ndarray:
    """Return quadrature weights of the nodes over the depth, exact for polynomials of the given order."""
    lumped = reference_matrices(order).mass.sum(axis=1)
    weights = np.zeros(len(z))
    for part, height in enumerate(np.diff(z[::order])):
        weights[part * order : (part + 1) * order + 1] += height * lumped
    return weights


def _depth(run):
    """Draw the depth profiles of the free wave and of the driven stator, compared with that of the half-space."""
    stator, scene, (name, middle) = model_of(run.scene).plain, run.scene, run.focus
    free = fem.free_wave(stator, frequency=scene.frequency, tolerance=1e-6)
    line = run.field.displacement[np.searchsorted(run.field.x, middle - 1e-9)]

    def parts(u):
        return {"Re u_z": u[:, 2].real, "Im u_x": u[:, 0].imag}

    computed, at = {}, np.linspace(0, DEPTH, 200)
    for what, z, u in (
        ("free wave of the section", free.depth, free.profile),
        (f"driven stator under the {name}, all modes", run.field.z, line),
    ):
        shallow = z > -DEPTH * run.wavelength
        computed[what] = -z[shallow] / run.wavelength, parts(u[shallow] / u[-1, 2])
    theory, title = fem.bound_wave(stator, scene.frequency, "open").profile(at)[0], "profile through the depth"
    return depth_profile(at, parts(theory), computed, title=f"{scene.title}\n{title}")


def _films(gallery, folder: Path) -> None:
    run = gallery.wave_field
    LOGGER.info("wave and contact in slow motion")
    moving = Picture(run, span_views(run, None), size=MOVIE, **FIELD)
    movie.save(
        lambda number: moving.image(2 * np.pi * number / FRAMES), FRAMES, folder / "wave.gif", rate=12.0,
        palette=palette(moving.shade.colour_map),
    )  # fmt: skip
    history, title = gallery.contact
    film_contact(history, title, 2 * FRAMES, folder / "contact.gif", rate=10.0, dpi=DPI)
    LOGGER.info("drawing the solid")
    still(Picture(run, size=SOLID, **FIELD), folder / "solid.png")


def still(picture: Picture, file: Path) -> None:
    """Save a picture of the field with a palette of its own colour map."""
    picture.save(file)
    _reduce(file, palette(picture.shade.colour_map))


def _reduce(file: Path, colours: Image.Image | None = None) -> None:
    """Reduce a picture to the palette of an image, or of its own colours, which makes it three times smaller."""
    with Image.open(file) as image:
        plain = image.convert("RGB")
    colours = plain.quantize(PALETTE_COLOURS) if colours is None else colours
    plain.quantize(palette=colours, dither=Image.Dither.NONE).save(file, optimize=True)
