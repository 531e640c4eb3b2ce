"""P-matrices of transducers and pieces, and their cascade compared with the whole stator: what coupled modes neglect.

Method: the P-matrix of each transducer alone, computed from its field (`fem.p_matrix`, nothing is fitted), and of each
meshed piece (`fem.reflector`), for the surface wave only, at frequencies of the passband. Their cascade along the
stator is compared with the admittances of the whole stator, which also include bulk waves, decaying fields and ends.
Both describe the plane section with short-circuited terminations. Expected: reciprocity to rounding; the surface wave
takes at most the whole conductance if the solid is lossless; the cascade agrees with the stator within 30 % in the
maximum of the transfer admittance. Of a unidirectional transducer (`transducer.cell`) the directivity is stated in dB,
beside that of coupled modes. Run time: about 8 s.
"""

import logging
from dataclasses import replace
from itertools import pairwise

import numpy as np

import fem
from studies.model.scene_errors import as_run_errors
from studies.record.plots import COLOURS, curve, lines
from studies.record.quantities import quantity
from studies.scene import Scene
from studies.solve import passband
from studies.solve.spectrum import port_admittances
from studies.stator.reflector import from_the_left, stator_beside_pieces
from studies.study_list import Answered, Finding, Panel, judged, of_record, study

LOGGER = logging.getLogger(__name__)

QUICK = {"count": 3, "tolerance": 0.2}


@study("twente")
def run(scene: Scene, *, count: int = 25, tolerance: float = 3e-2) -> Answered:
    """Return P-matrices, their cascade and the whole stator.

    Parameters
    ----------
    count : int
        Number of frequencies.
    tolerance : float
        Of the P-matrices and of the admittances.
    """
    model = passband.driven_model(scene)
    resolved, stator = model.scene, stator_beside_pieces(model)
    row = tuple(sorted(model.section_transducers, key=lambda each: each.center))
    if len({each.aperture for each in row}) > 1:
        resolved.refuse("transducer", "must have equal apertures for this study: their waves are one beam")
    ports = [k for k, each in enumerate(row) if {"+", "-"} <= set(each.signs)]
    at, by_kind, first, cascade = passband.frequencies(model, count), {}, [], []
    pieces: list[fem.Reflector] = []
    for f in at:
        LOGGER.info(f"P-matrices at {f / 1e6:.5g} MHz")
        kinds = [(f, replace(each, name="", center=0.0, termination="open")) for each in row]
        with as_run_errors(f"at {f / 1e6:.6g} MHz"):
            for kind, each in zip(kinds, row, strict=True):
                if kind not in by_kind:
                    by_kind[kind] = fem.p_matrix(stator, each, frequency=float(f), tolerance=tolerance)
            if stator.pieces:
                pieces.append(fem.reflector(stator, frequency=float(f), tolerance=tolerance))
        parts = [by_kind[kind] for kind in kinds]
        located = [(each.center - part.length / 2, part) for each, part in zip(row, parts, strict=True)]
        if pieces:
            located += [(left, pieces[-1].pieces[number][1]) for left, number in pieces[-1].positions]
        order = sorted(range(len(located)), key=lambda k: located[k][0])
        from_left, electrical = [located[k] for k in order], [order.index(k) for k in ports]
        distances = [start - (before + part.length) for (before, part), (start, _) in pairwise(from_left)]
        admittance = fem.cascade_admittance([part for _, part in from_left], distances)
        cascade.append(admittance[np.ix_(electrical, electrical)])
        first.append(parts[ports[0]])
    plane = model.with_blocks(stator=replace(resolved.stator, diffraction=False, sides="absorbing"))
    last = len(ports) - 1
    whole = port_admittances(plane, at, tolerance).matrix[:, last, 0]
    joined = np.array(cascade)[:, last, 0]
    apart = abs(joined - whole).max() / abs(whole).max()
    sent = np.array([np.sum(abs(part.excitation) ** 2) for part in first])
    admittance = np.array([part.admittance for part in first])
    uneven = max(float(abs(p.detection + 2 * p.excitation).max() / abs(p.excitation).max()) for p in first)
    directivity = directivity_in_dB(first)
    name = "transfer admittance" if last else "admittance"
    reflects = resolved.stator.ends != "absorbing" or any(stator.placement.ends if stator.pieces else ())
    findings: tuple[Finding, ...] = (
        judged("A transducer receives as it sends: P31 = -2 P13.", "largest difference, relative", uneven, high=1e-9),
        judged("The surface wave takes no more than the source gives.",
               "largest share of the conductance that goes into the surface wave", np.max(sent / admittance.real),
               high=1 + tolerance, expected="at most 1"),
        judged("A cascade of P-matrices equals the stator except for bulk waves, decaying fields and ends.",
               f"largest difference of the {name}, over its largest size", apart,
               high=0.3, holds=None if reflects else True, expected="below 0.3 between absorbing ends",
               remark="the ends reflect, and the cascade has no ends" if reflects else ""),
    )  # fmt: skip
    if row[ports[0]].cell != "plain":
        findings += (_directivity_found(first, directivity),)
    panels = (
        Panel(name="p_matrix", title=f"{resolved.title}: transducer {row[ports[0]].name!r} alone", data=dict(
            frequency_Hz=at, reflection_shorted=np.array([abs(part.scattering[0, 0]) for part in first]),
            reflection_open=np.array([abs(part.loaded(np.inf)[0, 0]) for part in first]),
            excitation_squared_S=sent, admittance_S=admittance, directivity_dB=directivity,
        )),
        Panel(name="cascade", title=f"{resolved.title}: {name}", data=dict(
            frequency_Hz=at, cascade_S=joined, stator_S=whole,
        )),
    )  # fmt: skip
    return panels + _of_pieces(resolved.title, at, pieces), findings


def directivity_in_dB(parts: list[fem.PMatrix]) -> np.ndarray:
    """Return the power that P-matrices send to the right over that to the left, dB, shape (parts,)."""
    # halves of one length each: the number of modes grows with the frequency
    left, right = np.transpose([[np.sum(abs(half) ** 2) for half in np.split(part.excitation, 2)] for part in parts])
    return 10 * np.log10(right / left)


def _directivity_found(parts: list[fem.PMatrix], directivity: np.ndarray) -> Finding:
    """Return the directivity where the fingers reflect most, beside that of coupled modes.

    A row whose reflections are in best phase with its sources sends exp(kappa L) times as much one way as the other,
    at the centre of its stop band, where |P11| = tanh(kappa L) (Hartmann, Wright, Kansy and Garber, Proc. IEEE
    Ultrasonics Symp. 1982, 40).
    """
    reflected = np.array([abs(part.scattering[0, 0]) for part in parts])
    peak = int(np.argmax(reflected))
    limit = 20 / np.log(10) * np.arctanh(min(reflected[peak], 1 - 1e-12))
    return judged(
        "Reflections in best phase with the sources send exp(kappa L) times as much one way, |P11| = tanh(kappa L).",
        f"directivity, right over left, at {parts[peak].frequency / 1e6:.5g} MHz where |P11| is largest, dB",
        directivity[peak],
        holds=None,
        expected=f"{limit:.3g} dB to one side by coupled modes",
    )


def _of_pieces(title: str, at: np.ndarray, pieces: list[fem.Reflector]) -> tuple[Panel, ...]:
    """Return what each different piece and all of them together do to the surface wave, where there are pieces."""
    if not pieces:
        return ()
    matrices = {name: [each.pieces[k][1] for each in pieces] for k, (name, _) in enumerate(pieces[0].pieces)}
    if len(pieces[0].positions) > 1:
        matrices["all pieces together"] = [each.cascade for each in pieces]
    return tuple(
        Panel(name=f"piece_{k}", title=f"{title}: {name}", data={
            key: abs(values) for key, values in from_the_left(at, [each.scattering for each in own]).items()
        })
        for k, (name, own) in enumerate(matrices.items())
    )  # fmt: skip


@of_record
def figure(record: Panel, ax):
    """Draw the transducer's reflections and conductance, cascade and stator, or what a piece sends back."""
    data, at = record.data, record.data.frequency_Hz * quantity.frequency_Hz.scale
    if "cascade_S" in data:
        rows = (("stator_S", "o", "slip", "stator"), ("cascade_S", "-", "line", "cascade of P-matrices"))
        return lines(ax, record, quantity.frequency_Hz, rows, quantity.admittance_S)
    if "transmission" in data:
        rows = (("reflection", "-", "line", "|P11|"), ("transmission", "--", "slip", "|P21|"))
        return lines(ax, record, quantity.frequency_Hz, rows, quantity.reflection)
    up = quantity.admittance_S
    curve(ax, at, data.admittance_S.real * up.scale, "o", "slip", f"Re P33 ({up.shown})")
    sent = data["excitation_squared_S"] * up.scale
    curve(ax, at, sent, "-", "slip", f"|P13|\u00b2 + |P23|\u00b2 ({up.shown}): the surface wave's part")
    reflection = ax.twinx()
    for key, style, name in (
        ("reflection_shorted", "--", "|P11|, electrodes shorted"),
        ("reflection_open", ":", "|P11|, electrodes open"),
    ):
        curve(reflection, at, data[key], style, "intermittent", name)
        ax.plot([], [], style, color=COLOURS["intermittent"], label=name)  # its line in the legend of both axes
    reflection.set_ylim(0, 1)
    reflection.set_ylabel(quantity.reflection.axis, color=COLOURS["intermittent"])
    ax.set_ylim(bottom=0)
    return lines(ax, record, quantity.frequency_Hz, (), quantity.conductance_S, columns=2)
