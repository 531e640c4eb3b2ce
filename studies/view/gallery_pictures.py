"""The pictures of the gallery, from the results of its study, by what draws them for ``sawmotor view``."""

from collections.abc import Callable
from pathlib import Path

__all__ = ["draw_all"]

ORBITS = 12
MOVIE, SOLID, STILL = (720, 300), (1000, 470), (1200, 720)
FRAMES = 16
COLOURS = 128  # of a diagram
DPI = 80
DEPTH = 3.0  # wavelengths


def draw_all(gallery, folder: Path, *, progress: Callable[[str], None]) -> None:
    """Draw the pictures of a gallery into a directory, and tell what is being done."""
    from studies.report.figures import saved, velocity
    from studies.view.contact_pictures import start_and_stop, strip
    from studies.view.power_pictures import ledger_bars, power_bars
    from studies.view.section import Section, views

    found, record = gallery.found, gallery.record
    title = record.scene.title
    given = {"phase": 0.0, "factor": None}
    for name, figure in (
        ("orbits", _orbits(found)),
        ("amplitude", _amplitude(found)),
        ("depth", _depth(found)),
        ("contact", strip(gallery.contact[0], title=gallery.contact[1])),
        ("start_stop", start_and_stop(gallery.bursts, acceleration=gallery.acceleration, title=title)),
        ("power", power_bars(record.electrical, title=title)),
        ("power_flow", _power_flow(found)),
        ("ledger", ledger_bars(gallery.ledger, title=f"{title}: {gallery.voltage:g} V")),
        *(
            (name, Section(found, views(found), quantity=quantity, size=STILL, **given).figure)
            for name, quantity in (("wave", "u_z"), ("wave_power_flow", "power_flow"))
        ),
    ):
        progress(f"drawing {name}")
        figure.savefig(folder / f"{name}.png", dpi=100 if name.startswith("wave") else DPI)
    saved(folder / "velocity.png", lambda ax: velocity(record, ax))
    for module, panel in gallery.others:
        saved(folder / f"{panel.name}.png", lambda ax, module=module, panel=panel: module.figure(panel, ax))
    if gallery.films:
        _films(gallery, folder, progress, given)
    for picture in folder.glob("*.png"):
        _reduce(picture)


def _films(gallery, folder: Path, progress, given: dict) -> None:
    import numpy as np

    from studies.view import movie
    from studies.view.contact_view import slow_motion
    from studies.view.quantities import palette
    from studies.view.section import Section, chosen_views
    from studies.view.solid import Solid

    found = gallery.found
    progress("wave and contact in slow motion")
    moving = Section(found, chosen_views(found, None), quantity="u_z", size=MOVIE, **given)
    movie.save(
        moving.figure, lambda number: moving.show(2 * np.pi * number / FRAMES), FRAMES, folder / "wave.gif", rate=12.0,
        palette=palette(moving.shade.colour_map),
    )  # fmt: skip
    figure, show = slow_motion(*gallery.contact, 2 * FRAMES)
    figure.set_dpi(DPI)
    movie.save(figure, show, 2 * FRAMES, folder / "contact.gif", rate=10.0)
    progress("drawing the solid")
    solid = Solid(found, quantity="u_z", size=SOLID, off_screen=True, **given).plotter
    solid.screenshot(folder / "solid.png")
    solid.close()


def _orbits(found):
    import numpy as np

    from studies.view.surface_pictures import orbits

    places = (np.arange(ORBITS) + 0.5) / ORBITS * found.length
    tangential, normal = np.array([found.surface(place) for place in places]).T
    return orbits(places, tangential, normal, per="nm per V", title=found.scene.title)


def _amplitude(found):
    from studies.view.surface_pictures import amplitude

    top, x = found.field.displacement[:, -1], found.field.x
    return amplitude(
        x, top[:, 0], top[:, 2], wavelength=found.wavelength, covered=found.spans, focus=found.focus,
        per="nm per V", title=found.scene.title,
    )  # fmt: skip


def _depth(found):
    """Profiles of the section's free wave and of the driven stator under the slider, on the half-space's."""
    import numpy as np

    import fem
    from studies.scene import resolved
    from studies.view.surface_pictures import depth_profile

    stator, scene = resolved.stator(found.scene.stator), found.scene
    half_space, free = (
        fem.rayleigh(stator.solid, "open"),
        fem.free_wave(stator, frequency=scene.frequency, tolerance=1e-6),
    )
    field, (_, place) = found.field, found.focus
    line = field.displacement[np.searchsorted(field.x, place - 1e-9)]

    def parts(u):
        return {"Re u_z": u[:, 2].real, "Im u_x": u[:, 0].imag}

    def near(z, u):
        chosen = z > -DEPTH * found.wavelength
        return -z[chosen] / found.wavelength, parts(u[chosen] / u[-1, 2])

    at = np.linspace(0, DEPTH, 200)
    return depth_profile(
        at,
        parts(half_space.profile(at)[0]),
        {
            "free wave of the section": near(free.depth, free.profile),
            f"driven stator under the {found.focus[0]}, all modes": near(field.z, line),
        },
        title=f"{scene.title}\nprofile through the depth",
    )


def _power_flow(found):
    from studies.view.power_pictures import depth_weights, power_along

    field = found.whole(energies=True)
    passing = field.densities.power_flow[..., 0] @ depth_weights(field.z, field.order) * found.aperture
    return power_along(
        field.x, passing, covered=found.spans, given=found.record.electrical["power_W_per_V2"],
        title=found.scene.title,
    )  # fmt: skip


def _reduce(picture: Path) -> None:
    """Write a picture again with a palette: a third of the size."""
    from PIL import Image

    from studies.view.quantities import DIVERGING, palette

    with Image.open(picture) as image:
        plain = image.convert("RGB")
    field = picture.stem in ("wave", "wave_power_flow", "solid")
    colours = palette(DIVERGING) if field else plain.quantize(COLOURS)
    plain.quantize(palette=colours, dither=Image.Dither.NONE).save(picture, optimize=True)
