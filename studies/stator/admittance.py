"""Conductance and susceptance of a driven transducer against frequency.

Method: the admittance of the driven transducer of the scene (``twente`` by default), with the terminations of the other
transducers as in the scene, at 81 frequencies of a band, or at as many as resolve the ripple of returning waves. It is
compared with the quasi-static estimate of a transducer without reflections. Expected: the conductance is never
negative, and its maximum is within a factor of 2 of the estimate; at the edges of the band, where hardly any wave is
sent, the susceptance is that of the static capacitance within 25 %. Run time: about 25 s for two transducers.
"""

import numpy as np

import fem
from studies.record.plots import lines
from studies.record.quantities import quantity
from studies.scene import Scene
from studies.solve import passband
from studies.solve.spectrum import driving_point, port_admittances
from studies.study_list import Answered, Panel, judged, of_record, study

QUICK = {"count": 5, "tolerance": 0.1}


@study("twente")
def run(scene: Scene, *, count: int | None = None, tolerance: float = 1e-2) -> Answered:
    """Return the admittance against frequency and its estimate.

    Parameters
    ----------
    count : int, optional
        Number of frequencies; by default 81, or as many as resolve the ripple of returning waves.
    tolerance : float
        Relative, of the admittances.
    """
    model = passband.driven_model(scene)
    resolved, at = model.scene, passband.frequencies(model, count, 81)
    ports = port_admittances(model, at, tolerance)
    admittance = driving_point(ports, model.transducers, model.drive)
    theory = passband.expected(model)
    susceptance, conductance = 2 * np.pi * at * theory.capacitance, theory.conductance(at)
    findings = (
        judged("A transducer takes up power: its conductance is not negative.",
               "smallest conductance (S)", admittance.real.min(), low=0),
        judged("The largest conductance is that of charges that send a Rayleigh wave.",
               "largest conductance over the estimate's", admittance.real.max() / conductance.max(), low=0.5, high=2,
               expected="between 0.5 and 2: the estimate includes no reflections and no bulk waves"),
        judged("Outside the passband, the transducer is a capacitor.",
               "susceptance at the band's edges over that of the static capacitance, mean",
               np.mean((admittance.imag / susceptance)[[0, -1]]), low=0.75, high=1.25),
        judged("The admittances meet the tolerance.",
               "estimated error of the admittances over the largest", ports.relative_error, high=1.000001 * tolerance,
               expected=f"at most {tolerance:g}"),
    )  # fmt: skip
    data = dict(
        frequency_Hz=at, conductance_S=admittance.real, susceptance_S=admittance.imag,
        estimated_conductance_S=conductance, capacitive_susceptance_S=susceptance,
        relative_error=ports.relative_error,
    )  # fmt: skip
    panel = Panel(name="admittance", title=f"{resolved.title}: {resolved.drive.transducer!r}", data=data)
    model = fem.motional_model(at, admittance, 1)
    series, inductance, _ = model.branches[0]
    peak = int(np.argmax(admittance.real))
    answer = [
        ("largest G", f"{admittance.real[peak] * 1e3:.4g} mS at f0 = {at[peak] / 1e6:.6g} MHz"),
        ("static C0", f"{model.capacitance * 1e12:.4g} pF (of the band's circuit with one motional branch)"),
        ("quality", f"Q = {2 * np.pi * at[peak] * inductance / series:.4g} of that branch, which leaves "
                    f"{100 * model.error:.2g} % of the largest admittance"),
    ]  # fmt: skip
    return (panel,), findings, answer


@of_record
def figure(record: Panel, ax):
    """Draw conductance and susceptance, computed points, and estimates dashed."""
    curves = (
        ("conductance_S", ".-", "slip", "Re Y"),
        ("estimated_conductance_S", "--", "slip", "Re Y, no reflections (estimate)"),
        ("susceptance_S", ".-", "intermittent", "Im Y"),
        ("capacitive_susceptance_S", "--", "intermittent", "static capacitance (estimate)"),
    )
    return lines(ax, record, quantity.frequency_Hz, curves, quantity.admittance_S, columns=2)
