"""``sawmotor materials``: what the catalogue holds, and one solid with its constants and the waves of usual cuts."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

import fem
from studies.model.scene_errors import stator_keys
from studies.model.solid_of_material import named_solid
from studies.record.quantities import quantity
from studies.record.text import labelled
from studies.record.values import Columns
from studies.refusal import misread, writing
from studies.results.content import plain

# usual cuts by crystal class; others have Z alone
CUTS = {"6mm": ("Z", "X"), "4mm": ("Z", "X"), "3m": ("YZ", "128YX"), "32": ("ST-X", "YZ"), "-43m": ("Z",)}
EPS0 = fem.VACUUM_PERMITTIVITY


def listed() -> tuple[dict, str]:
    """Return the materials of the catalogue as JSON content and as text."""
    rows, answer = [("name", "class", "kg/m^3", "confirmed", "source")], {}
    for name, solid in fem.catalogue().items():
        own = fem.catalogue_table(name)
        kind = own.get("crystal_class", "isotropic")
        answer[name] = {
            "class": kind, "density_kg_per_m3": solid.density, "source": solid.source,
            "aliases": list(own.get("aliases", ())), "confirmed": own.get("confirmed"),
        }  # fmt: skip
        rows.append((name, kind, f"{solid.density:g}", "yes" if "confirmed" in own else "-", solid.source))
    widths = [max(len(row[k]) for row in rows) for k in range(4)]
    lines = ["  ".join([*(row[k].ljust(widths[k]) for k in range(4)), row[4]]) for row in rows]
    note = "sawmotor materials NAME shows one; --copy FILE writes its file, to change it"
    return {"materials": answer}, "\n".join([*lines, "", note])


def material_answer(name: str) -> dict:
    """Return a material's constants and, for its usual cuts, the velocity of the surface wave and its coupling.

    ``name``: of the catalogue, an alias, or a file of constants.
    """
    with stator_keys("material"):
        material, solid = named_solid(name)
    own = fem.catalogue_table(name) if isinstance(material, str) else material.to_table()
    kind = own.get("crystal_class") or ("isotropic" if "youngs_modulus" in own else "")
    answer = {
        "name": solid.name, "class": kind, "source": own.get("source", ""), "axes": own.get("axes", ""),
        "confirmed": own.get("confirmed", ""), "remark": own.get("remark", ""),
        "aliases": list(own.get("aliases") or ()),
        "density_kg_per_m3": solid.density, "stiffness_Pa": solid.stiffness,
        "coupling_C_per_m2": solid.coupling, "permittivity_relative": solid.permittivity / EPS0,
        "mechanical_quality": solid.mechanical_quality if math.isfinite(solid.mechanical_quality) else None,
        "dielectric_loss": solid.dielectric_loss,
        "probable_mistakes": [] if isinstance(material, str) else list(fem.plausibility(solid)),
        "cuts": {cut: _wave(solid, cut) for cut in CUTS.get(kind, ("Z",))},
    }  # fmt: skip
    return plain("", answer)


def _wave(solid, cut: str) -> dict:
    """Return velocity and coupling of the surface wave of a lossless half-space, or why there is none."""
    lossless = fem.rotated(replace(solid, mechanical_quality=math.inf, dielectric_loss=0.0), cut)
    try:
        wave = fem.rayleigh(lossless, "vacuum")
        coupled = "phi" in fem.fields(lossless)
        return dict(velocity_m_per_s=wave.velocity) | ({"coupling_K2": fem.coupling(lossless)} if coupled else {})
    except (fem.ConvergenceError, ValueError) as error:
        return {"refused": " ".join(str(error).split())}


def material_text(answer: dict) -> str:
    """Return what ``sawmotor materials NAME`` prints."""
    lines = [
        ("also called", ", ".join(answer["aliases"])), ("class", answer["class"]), ("axes", answer["axes"]),
        ("source", answer["source"]), ("confirmed by", answer["confirmed"] or "nothing published that was found"),
        ("remark", answer["remark"]),
        ("density", f"{answer['density_kg_per_m3']:g} kg/m^3"),
        ("losses", _losses(answer)),
    ]  # fmt: skip
    for cut, wave in answer["cuts"].items():
        wave = Columns(wave)
        if "refused" in wave:
            lines.append((cut, wave["refused"]))
            continue
        coupling = f", K2 {100 * wave['coupling_K2']:.3g} %" if "coupling_K2" in wave else ""
        lines.append((cut, f"surface wave {wave.velocity_m_per_s:.6g} m/s{coupling}"))
    keys = [("stiffness_Pa", "at constant E"), ("coupling_C_per_m2", ""), ("permittivity_relative", "")]
    tables = [
        (f"{shown.axis} {condition}".rstrip(), np.array(answer[key]) * shown.scale)
        for key, condition in keys
        for shown in (quantity(f"crystal.{key}"),)
    ]
    shown_tables = [line for label, own in tables if abs(own).max() > 0 for line in _rows(label, own)]
    return "\n".join([answer["name"], "", *labelled([each for each in lines if each[1]]), "", *shown_tables])


def _losses(answer: dict) -> str:
    quality, loss = answer["mechanical_quality"], answer["dielectric_loss"]
    if quality is None and not loss:
        return "none given"
    return f"Q {'infinite' if quality is None else f'{quality:g}'}, tan delta {loss:g}"


def _rows(label: str, own) -> list[str]:
    rows = [[f"{float(each):.6g}" for each in row] for row in own]
    width = max(len(each) for row in rows for each in row)
    return [label, *("  " + "  ".join(each.rjust(width) for each in row) for row in rows)]


def copied(name: str, file: str) -> Path:
    """Write the file of a material of the catalogue; refuse one that exists."""
    path = Path(file)
    with stator_keys("material"):
        text = fem.catalogue_text(name)
    if path.suffix != ".toml":
        raise misread("--copy", "a file whose name ends with .toml", file)
    with writing(file, "--copy"), path.open("x", encoding="utf-8") as opened:
        opened.write(text)
    return path
