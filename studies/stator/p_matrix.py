"""What coupled modes leave out: P-matrices of the transducers, their cascade, and the whole stator beside it.

Method: P-matrix of each transducer alone from its field (`fem.p_matrix`, nothing fitted) for the surface wave only, at
frequencies of the passband; their cascade along the stator against the admittances of the whole stator, which has bulk
waves, decaying fields and ends too (both of the plane section; terminations are left out on both sides: short-circuit
admittances).  Expected: reciprocity to rounding; the surface wave's part of the conductance at most all of it where the
solid is lossless; the cascade within 30 % of the stator in the transfer admittance's maximum.  Run time: about 15 s.
"""

from dataclasses import replace

import numpy as np

import fem
from studies.chain import passband, resolve
from studies.chain.spectrum import port_admittances
from studies.record.plots import COLOURS, curve, lines
from studies.refusal import RunError
from studies.scene import Scene
from studies.study import Answered, Panel, judged, of_record, study

QUICK = {"count": 3, "tolerance": 0.2}


@study("twente")
def run(scene: Scene, *, count: int = 25, tolerance: float = 3e-2, progress=None) -> Answered:
    """Return P-matrices, their cascade and the whole stator.

    Parameters
    ----------
    count : int
        Frequencies.
    tolerance : float
        Of the P-matrices and of the admittances.
    """
    chosen = passband.driven_scene(scene)
    block = resolve.stator(chosen.stator)
    row = tuple(sorted(resolve.section_row(chosen), key=lambda each: each.center))
    if len({each.aperture for each in row}) > 1:
        chosen.refuse("transducer", "must have equal apertures for this study: their waves are one beam")
    ports = [k for k, each in enumerate(row) if {"+", "-"} <= set(each.signs)]
    at, known, first, cascade = passband.frequencies(chosen, count), {}, [], []
    for f in at:
        progress(f"P-matrices at {f / 1e6:.5g} MHz")
        kinds = [(f, each.signs, each.pitch, each.metallisation) for each in row]
        try:
            for kind, each in zip(kinds, row, strict=True):
                if kind not in known:
                    known[kind] = fem.p_matrix(block, each, frequency=float(f), tolerance=tolerance)
        except fem.ConvergenceError as error:
            raise RunError(f"at {f / 1e6:.6g} MHz {error}") from None
        parts = [known[kind] for kind in kinds]
        ends = [
            each.center + side * part.length / 2
            for each, part in zip(row, parts, strict=True)
            for side in (-1, 1)
        ]
        distances = [right - left for left, right in zip(ends[1::2], ends[2::2], strict=False)]
        cascade.append(fem.cascade_admittance(parts, distances)[np.ix_(ports, ports)])
        first.append(parts[ports[0]])
    plane = replace(chosen, stator=replace(chosen.stator, diffraction=False, sides="absorbing"))
    last = len(ports) - 1
    whole = port_admittances(plane, at, tolerance, progress).matrix[:, last, 0]
    joined = np.array(cascade)[:, last, 0]
    apart = abs(joined - whole).max() / abs(whole).max()
    sent = np.array([np.sum(abs(part.excitation) ** 2) for part in first])
    admittance = np.array([part.admittance for part in first])
    uneven = max(float(abs(p.detection + 2 * p.excitation).max() / abs(p.excitation).max()) for p in first)
    name, reflects = "transfer admittance" if last else "admittance", chosen.stator.ends != "absorbing"
    findings = (
        judged("A transducer receives as it sends: P31 = -2 P13.", "largest difference, relative", uneven, high=1e-9),
        judged("The surface wave takes no more than the source gives.",
               "largest share of the conductance that goes into the surface wave", np.max(sent / admittance.real),
               high=1 + tolerance, expected="at most 1"),
        judged("A cascade of P-matrices is the stator, but for bulk waves, decaying fields and ends.",
               f"largest difference of the {name}, over its largest size", apart,
               high=0.3, holds=None if reflects else True, expected="below 0.3 between absorbing ends",
               remark="the ends reflect, and the cascade has none" if reflects else ""),
    )  # fmt: skip
    panels = (
        Panel(name="p_matrix", title=f"{chosen.title}: transducer {row[ports[0]].name!r} alone", data={
            "frequency_Hz": at, "reflection_shorted": np.array([abs(part.scattering[0, 0]) for part in first]),
            "reflection_open": np.array([abs(part.loaded(np.inf)[0, 0]) for part in first]),
            "excitation_squared_S": sent, "admittance_S": admittance,
        }),
        Panel(name="cascade", title=f"{chosen.title}: {name}", data={
            "frequency_Hz": at, "cascade_S": joined, "stator_S": whole,
        }),
    )  # fmt: skip
    return panels, findings


@of_record
def figure(record: Panel, ax):
    """Draw the transducer's reflections and conductance, or cascade and stator."""
    data, at = record.data, record.data["frequency_Hz"] / 1e6
    if "cascade_S" in data:
        rows = (("stator_S", "o", "slip", "stator"), ("cascade_S", "-", "line", "cascade of P-matrices"))
        return lines(ax, record, "frequency_Hz", rows, "size of the admittance (mS)", factor=1e3)
    curve(ax, at, data["admittance_S"].real * 1e3, "o", "slip", "Re P33 (mS)")
    sent = data["excitation_squared_S"] * 1e3
    curve(ax, at, sent, "-", "slip", "|P13|\u00b2 + |P23|\u00b2 (mS): the surface wave's part")
    reflection = ax.twinx()
    for key, style, name in (
        ("reflection_shorted", "--", "|P11|, electrodes shorted"),
        ("reflection_open", ":", "|P11|, electrodes open"),
    ):
        curve(reflection, at, data[key], style, "intermittent", name)
        ax.plot(
            [], [], style, color=COLOURS["intermittent"], label=name
        )  # its line in the legend of both axes
    reflection.set_ylim(0, 1)
    reflection.set_ylabel("reflection of the surface wave (1)", color=COLOURS["intermittent"])
    ax.set_ylim(bottom=0)
    return lines(ax, record, "frequency_Hz", (), "conductance (mS)", columns=2)
