"""``sawmotor wave --temperature``: the Rayleigh wave of a lossless half-space at several temperatures.

TCV = (1/v) dv/dT, and TCF = TCV less the expansion along the propagation, (1/l) dl/dT: the relative change of the
frequency at which fingers on the surface work. Its second order is half of d^2f/dT^2 over f. Both are differences of
velocities that are exact to 1e-12, over steps in which the constants' third orders make less than 1e-9/K.
"""

from collections.abc import Sequence

import fem
from studies.model.scene_errors import as_run_errors, input_errors
from studies.model.solid_of_material import solid_at, thermal_table
from studies.record.quantities import quantity
from studies.record.text import labelled, table
from studies.results.content import plain
from studies.scene.stator_keys import MATERIAL, ORIENTATION

STEP, WIDE_STEP = 1.0, 5.0  # K, of the differences of first and second order


def warm_half_space(material: str, temperatures: Sequence[float], *, orientation="Z", surface: str = "vacuum") -> dict:
    """Return the Rayleigh wave of a half-space at temperatures in degC as JSON-compatible data.

    Parameters
    ----------
    material : str
        A catalogue name, or a file of constants; with temperature coefficients.
    temperatures : sequence of float
        degC.
    orientation, surface
        As in `studies.report.free_surface.half_space_wave`.

    Returns
    -------
    dict
        ``material``, and ``temperatures``: a row for each with ``temperature_degC``, ``velocity_m_per_s``,
        ``coupling_K2`` (of a piezoelectric solid), ``TCV_per_K``, ``TCF_per_K``, ``second_TCF_per_K2`` and
        ``expansion_per_K`` along the propagation.
    """
    orientation = ORIENTATION.read("--orientation", orientation)
    read = MATERIAL.read("material", material)
    own = thermal_table(read)
    with input_errors():
        surface = fem.surface_named(surface)

        def solid(temperature: float) -> fem.Solid:
            return fem.rotated(solid_at(read, temperature), orientation)

        def velocity(temperature: float) -> float:
            return fem.rayleigh(solid(temperature), surface).velocity

        def length(temperature: float) -> float:
            return 1.0 + fem.expansion_along(own, orientation, temperature)

        with as_run_errors():
            rows = [_row(each, solid(each), velocity, length) for each in temperatures]
    about = own["temperature"]
    answer = {
        "material": {"name": own["name"], "orientation": solid(temperatures[0]).frame, "source": own.get("source", "")},
        "surface": surface,
        "coefficients": {"source": about.get("source", ""), "confirmed": about.get("confirmed", "")},
        "temperatures": rows,
    }
    return {key: plain(key, value) for key, value in answer.items()}


def _row(temperature: float, solid: fem.Solid, velocity, length) -> dict[str, float]:
    """Return a temperature's row; ``velocity`` in m/s and relative ``length`` are functions of the temperature."""

    def frequency(at: float) -> float:
        return velocity(at) / length(at)

    def slope(of) -> float:
        return (of(temperature + STEP) - of(temperature - STEP)) / (2 * STEP * of(temperature))

    here = frequency(temperature)
    bend = frequency(temperature + WIDE_STEP) - 2 * here + frequency(temperature - WIDE_STEP)
    return {
        "temperature_degC": float(temperature),
        quantity.velocity_m_per_s.column: velocity(temperature),
        **({"coupling_K2": fem.coupling(solid)} if "phi" in fem.fields(solid) else {}),
        "TCV_per_K": slope(velocity),
        "TCF_per_K": slope(frequency),
        "second_TCF_per_K2": bend / (2 * WIDE_STEP**2 * here),
        "expansion_per_K": slope(length),
    }


def warm_answer(answer: dict) -> str:
    """Return the waves of `warm_half_space` as text."""
    material, about = answer["material"], answer["coefficients"]
    title = f"{material['name']}, {material['orientation']}, surface {answer['surface']} ({material['source']})"
    head = ["degC", "velocity m/s", "TCV ppm/K", "TCF ppm/K", "second order ppb/K^2", "expansion ppm/K"]
    coupled = "coupling_K2" in answer["temperatures"][0]
    rows = [[*head, "K2 %"] if coupled else head]
    for row in answer["temperatures"]:
        cells = [f"{row['temperature_degC']:g}", f"{row[quantity.velocity_m_per_s.column]:.4f}"]
        cells += [f"{1e6 * row[key]:.3f}" for key in ("TCV_per_K", "TCF_per_K")]
        cells += [f"{1e9 * row['second_TCF_per_K2']:.2f}", f"{1e6 * row['expansion_per_K']:.3f}"]
        rows.append([*cells, f"{100 * row['coupling_K2']:.4g}"] if coupled else cells)
    sources = [("coefficients", about["source"] or "without a source")]
    sources += [("confirmed by", about["confirmed"] or "nothing published that was found")]
    return "\n".join([title, "", *table(rows), "", *labelled(sources, 15)])
