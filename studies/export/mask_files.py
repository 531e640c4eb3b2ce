"""The mask of a scene as a file, and as a picture on the beam that its transducers make."""

from dataclasses import replace

import numpy as np

from studies.export.exported import Exported
from studies.export.mask import Mask, Sizes, draw, dxf, gds, layer_table, mask
from studies.record.quantities import quantity
from studies.scene import Scene


def gds_files(scene: Scene, name: str, *, size: list[str] | None = None, tolerance: float, progress) -> Exported:
    """Return NAME.gds and a table of its layers."""
    drawn = mask(scene, Sizes.read(size or []))
    files = {f"{name}.gds": gds(drawn), "layers.csv": layer_table(drawn)}
    return _exported(drawn, files, scene, tolerance, progress)


def dxf_files(scene: Scene, name: str, *, size: list[str] | None = None, tolerance: float, progress) -> Exported:
    """Return NAME.dxf."""
    drawn = mask(scene, Sizes.read(size or []))
    return _exported(drawn, {f"{name}.dxf": dxf(drawn)}, scene, tolerance, progress)


def _exported(drawn: Mask, files, scene: Scene, tolerance: float, progress) -> Exported:
    counts = {layer: sum(each.layer == layer for each in drawn.polygons) for layer in ("fingers", "busbars", "pads")}
    shift, widening = (round(each * 1e9, 3) for each in (drawn.shift, drawn.width_error))  # nm
    answer = (
        ("mask", f"{drawn.title}: chip {drawn.length * 1e3:g} mm x {drawn.width * 1e3:g} mm, unit 1 um"),
        ("", ", ".join(f"{number} {layer}" for layer, number in counts.items())),
        ("grid", f"{drawn.grid * 1e9:g} nm: corners moved by at most {shift:g} nm, widths of fingers by "
                 f"{widening:g} nm; narrowest gap {drawn.gap * 1e6:.4g} um"),
    )  # fmt: skip
    return Exported(
        files=files, answer=answer, pictures={"mask.png": lambda ax: _picture(drawn, scene, ax, tolerance, progress)},
        remarks=(drawn.left_out,) * bool(drawn.left_out),
    )  # fmt: skip


def _picture(drawn: Mask, scene: Scene, ax, tolerance: float, progress) -> None:
    """Draw the mask on |u_z| of the finite aperture, where it can be computed."""
    from studies.chain import run
    from studies.record.surface_map import surface_map

    beam = None
    if scene.drive is not None and not scene.piece:  # with a mesh no finite aperture is computed
        progress("the beam, for the picture")
        alone = replace(scene, slider=None, stator=replace(scene.stator, diffraction=True))
        alone = alone.at_level(max(scene.levels)).with_source(burst=None)
        beam = run(alone, tolerance=max(tolerance, 1e-2), progress=progress).surface_motion.beam
    if beam is not None:
        _, _, motion = surface_map(beam, scene.stator)
        size = np.abs(motion[2]).T * 1e9
        top = float(np.quantile(size, 0.995))
        edges = (0.0, scene.stator.length * 1e3, -scene.stator.width * 5e2, scene.stator.width * 5e2)
        image = ax.imshow(size, origin="lower", extent=edges, cmap="viridis", vmin=0.0, vmax=top, aspect="equal")
        ax.figure.colorbar(image, ax=ax, label=quantity("normal_m_per_V").axis, shrink=0.7)
    draw(drawn, ax, beam=beam is not None)
