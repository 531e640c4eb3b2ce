"""What a network analyser on the transducers would show: S-parameters, and circuits for simulators.

Method: the admittance matrix of all transducers with two combs over a band (`--band 1.9:2.5:401` in MHz; by default the
passband of the driven transducer about the drive's frequency), converted to S-parameters with a real reference
impedance (`--z0 50`). The ports are in the order of the scene, independent of how the scene drives or terminates them.
The result is written as ``network.sNp`` (Touchstone 1.1). A measured file (`--measured FILE.s2p`, or the table of an
impedance analyser) is drawn over it; nothing is fitted. `--port 2` takes one port of a file of several. Each
transducer, with the others terminated as in the scene, is also written as a SPICE subcircuit of a static capacitance
with one motional branch (Butterworth and Van Dyke) and with several branches. Expected: passive and reciprocal; the
circuit with several branches is within a tenth of the largest admittance. Run time: about 25 s.
"""

from pathlib import Path

import numpy as np

import fem
from studies.lab.network_file import read_network
from studies.lab.s_parameters import NetworkData
from studies.model.model import Model
from studies.record.plots import COLOURS, curve, finished, legend_below, lines, titled, upper_half
from studies.record.quantities import quantity
from studies.record.values import Columns
from studies.refusal import SceneError, refuse_if
from studies.report.explanation import band_seconds
from studies.scene import Scene
from studies.solve import passband
from studies.solve.scan_prediction import refuse_other_range
from studies.solve.scattering import converged_scattering, reference_impedance
from studies.solve.spectrum import driving_point
from studies.stator.network_deviation import deviations
from studies.study_list import Answered, Panel, StudyRecord, judged, of_record, study

QUICK = {"count": 11, "tolerance": 0.3}
BRANCHES = 5
CLOSE = 0.1  # error of a circuit that may stand for the transducer, over the largest admittance
PASSIVE, RECIPROCAL = 1e-12, 1e-11
CIRCLES = (0, 0.2, 0.5, 1, 2, 5)  # of the Smith chart, over the reference


@study("twente")
def run(
    scene: Scene,
    *,
    band: str | None = None,
    z0: str | float = 50.0,
    measured: str | None = None,
    port: str | int | None = None,
    count: int | None = None,
    tolerance: float = 1e-3,
) -> Answered:
    """Return the S-parameters of a scene's transducers and their circuits.

    Parameters
    ----------
    band : str, optional
        START:STOP:N in MHz, or with units.
    z0 : str or float
        Reference impedance, ohm.
    measured : str, optional
        Touchstone file of as many ports as the scene has transducers, or an impedance analyser's table for one.
        With a ``band``, its frequencies within that are taken.
    port : int, optional
        The port of the file that is taken for the scene's only transducer.
    count : int, optional
        Number of frequencies without a band; by default 401, or as many as resolve the ripple of returning waves.
    tolerance : float
        Relative, of the admittances.
    """
    model = passband.driven_model(scene)
    resolved = model.scene
    reference = reference_impedance(z0)
    at = passband.band_frequencies(model, band, count)
    lab_file = None
    if measured is not None:  # a wrong file is refused before anything is solved
        lab_file = _measured(Path(measured), model, reference, port)
        if band is not None:
            lab_file = lab_file.within(at[0], at[-1])
    elif port is not None:
        raise SceneError("--port", "is a port of a measured file: --measured FILE names it")
    names, ports, scattering, failures = converged_scattering(model, at, reference, tolerance)
    at = ports.frequency
    answer = [("no answer", failure) for failure in failures]
    shared = dict(frequency_Hz=at, ports=names, reference_ohm=reference, scattering=scattering)
    if lab_file is not None:
        shared |= {"measured_frequency_Hz": lab_file.frequency, "measured_scattering": lab_file.scattering,
                   "measured_file": lab_file.name, "measured_elements": lab_file.elements}  # fmt: skip
    panels = [
        Panel(name=name, title=f"{resolved.title}: {what}, {reference:g} ohm", data=shared)
        for name, what in (("smith", "reflection"), ("magnitude", "S-parameters"))
    ]
    if len(names) > 1:
        first, second = (each.center_xy[0] for each in resolved.transducer if each.name in names[:2])
        velocity = model.wave_velocity(resolved.frequency)
        travel_time = abs(second - first) / velocity
        delay = passband.group_delay(at, scattering[:, 1, 0], travel_time)
        data, title = (dict(frequency_Hz=at, group_delay_s=delay), f"{resolved.title}: {names[0]} to {names[1]}")
        if lab_file is not None:
            data |= _measured_delay(lab_file, travel_time)
        panels.append(Panel(name="group_delay", title=title, data=data))
    models = {}
    for name in names:
        admittance = driving_point(ports, model.transducers, name)
        models[name] = [fem.motional_model(at, admittance, branches) for branches in (1, BRANCHES)]
        panels.append(_circuit_panel(name, at, admittance, models[name]))
    if lab_file is not None:
        _, at_file, predicted, failures = converged_scattering(model, lab_file.frequency, reference, tolerance)
        answer += [("not compared", failure) for failure in failures]
        answer += deviations(lab_file.at(np.isin(lab_file.frequency, at_file.frequency)), predicted, names)
        answer += [("", panel.data["not_drawn"]) for panel in panels if "not_drawn" in panel.data]
    gain = float(np.linalg.svd(scattering, compute_uv=False).max())
    apart = float(abs(scattering - scattering.transpose(0, 2, 1)).max())
    findings = (
        judged("Transducers give no more power than they take.", "largest singular value of S, less 1", gain - 1,
               high=PASSIVE),
        judged("The network is reciprocal.", "largest |S_ij - S_ji|", apart, high=RECIPROCAL),
        judged("The admittances meet the tolerance.", "estimated error, over the largest admittance",
               ports.relative_error, high=1.000001 * tolerance, expected=f"at most {tolerance:g}"),
        *(judged(f"{name}: a circuit of {BRANCHES} motional branches has the transducer's admittance.",
                 "largest error over the largest admittance", several.error, high=CLOSE, holds=None,
                 remark=f"one branch leaves {one.error:.2g}; use the Touchstone file if that is too much")
          for name, (one, several) in models.items()),
    )  # fmt: skip
    return panels, findings, [*_in_words(names, at, scattering, models), *answer]


def expected_seconds(scene: Scene, band: str | None = None, tolerance: float = 1e-3) -> float:
    """Return about how long the study takes for a scene and a band, s: the field, pictures and circuits."""
    model = passband.driven_model(scene)
    return 5.0 + band_seconds(model, passband.band_frequencies(model, band), tolerance=tolerance)


def _in_words(names, at, scattering, models):
    """Yield lines of the answer: largest return loss, smallest insertion loss, and the circuit of each transducer."""
    for k, name in enumerate(names):
        size = abs(scattering[:, k, k])
        best = int(np.argmin(size))
        yield f"match, {name}", f"return loss {-20 * np.log10(size[best]):.3g} dB at {at[best] / 1e6:.6g} MHz"
    for j, i in zip(*np.triu_indices(len(names), 1), strict=True):
        size = abs(scattering[:, i, j])
        best = int(np.argmax(size))
        loss = f"insertion loss {-20 * np.log10(size[best]):.3g} dB at {at[best] / 1e6:.6g} MHz"
        yield f"{names[j]} to {names[i]}", loss
    for name, (one, several) in models.items():
        left = f"one branch leaves {100 * one.error:.2g} %, {BRANCHES} branches {100 * several.error:.2g} %"
        yield f"circuit, {name}", f"C0 {one.capacitance * 1e12:.4g} pF; {left} of the largest admittance"


def tables(record: StudyRecord) -> dict[str, str]:
    """Return the Touchstone file and the SPICE subcircuits, by file name."""
    data = record.panel("magnitude").data
    remarks = (record.panel("magnitude").title, "ports: " + ", ".join(data["ports"]))
    texts = fem.touchstone(data.frequency_Hz, data["scattering"], data["reference_ohm"], remarks)
    circuits = {f"{panel.name}.cir": panel.data["spice"] for panel in record.panels if "spice" in panel.data}
    return {f"network.s{len(data['ports'])}p": texts} | circuits


@of_record
def figure(record: Panel, ax):
    """Draw reflections in the Smith chart, magnitudes in dB, the group delay, or an admittance with its circuits."""
    data, across = record.data, quantity.frequency_Hz
    if record.name == "smith":
        return _smith(record, ax)
    if "group_delay_s" in data:
        if "measured_group_delay_s" in data:
            at, delay = data["measured_frequency_Hz"] * across.scale, data["measured_group_delay_s"]
            curve(ax, at, delay * quantity.group_delay_s.scale, "o", "stick", "measured", size=2.5)
        title = record.title + (f"\n{data['not_drawn']}" if "not_drawn" in data else "")
        record = Panel(name=record.name, title=title, data=data)
        return lines(ax, record, quantity.frequency_Hz, (("group_delay_s", "-", "slip", None),), quantity.group_delay_s)
    if "spice" in data:
        up = quantity.admittance_S
        for key, part, style in (
            ("admittance_S", "field", "o"),
            ("one_branch_S", "circuit of one branch", "--"),
            ("several_branches_S", f"circuit of {BRANCHES}", "-"),
        ):
            at, values = data.frequency_Hz * across.scale, data[key] * up.scale
            curve(ax, at, values.real, style, "slip", f"conductance, {part}", size=2.5)
            curve(ax, at, values.imag, style, "intermittent", f"susceptance, {part}", size=2.5)
        return finished(ax, across.axis, up.axis, record.title, columns=3)
    return _magnitudes(record, ax)


def _magnitudes(record: Panel, ax):
    """Draw transmissions in dB, above them the reflections, which are small losses on a scale of their own."""
    data, across = record.data, quantity.frequency_Hz
    upper = upper_half(ax, share=True) if len(data["ports"]) > 1 and ax.get_subplotspec() is not None else ax
    for prefix, style, at, remark in _sources(data):
        for i, j in zip(*np.tril_indices(len(data["ports"])), strict=True):  # one half of a reciprocal network
            if prefix and not data["measured_elements"][i, j]:
                continue
            size = 20 * np.log10(np.maximum(abs(data[f"{prefix}scattering"][:, i, j]), 1e-15))
            options = {"color": f"C{i * len(data['ports']) + j}", "markersize": 3, "label": f"S{i + 1}{j + 1}{remark}"}
            (upper if i == j else ax).plot(at, size, style, **options | (_overlaid(prefix, int(i)) if i == j else {}))
    if upper is ax:
        return finished(ax, across.axis, quantity.magnitude.axis, record.title)
    titled(upper, record.title)
    upper.set_ylabel(quantity.magnitude.axis)
    upper.grid(alpha=0.3)
    finished(ax, across.axis, quantity.magnitude.axis, "", columns=0)
    legend_below(ax, [*upper.lines, *ax.lines])
    return ax


def _overlaid(prefix: str, port: int) -> dict:
    """Return how a predicted reflection is drawn: equal ones coincide, so the first lies wide below the others."""
    if prefix:
        return {}
    return {"linewidth": 3.5, "alpha": 0.45} if port == 0 else {"linewidth": 1.2}


def _smith(record: Panel, ax):
    """Draw the reflections over circles of resistance and arcs of reactance."""
    data, circle = record.data, np.exp(1j * np.linspace(0, 2 * np.pi, 361))
    for r in CIRCLES:
        z = (r + circle) / (1 + r)
        ax.plot(z.real, z.imag, color=COLOURS["line"], linewidth=1 if r == 0 else 0.4)
        options = {"textcoords": "offset points", "fontsize": "x-small", "alpha": 0.7}
        ax.annotate(f"{r:g}", ((r - 1) / (r + 1), 0), (2, 2), **options)
    reactance = np.concatenate([[0], np.geomspace(1e-3, 1e3, 400)])
    for x in (*CIRCLES, *np.negative(CIRCLES)):
        z = reactance + 1j * x
        arc = (z - 1) / (z + 1)
        ax.plot(arc.real, arc.imag, color=COLOURS["line"], linewidth=0.4)
    for prefix, style, _, remark in _sources(data):
        for i, name in enumerate(data["ports"]):
            if prefix and not data["measured_elements"][i, i]:
                continue
            s = data[f"{prefix}scattering"][:, i, i]
            options = {"color": f"C{i}", "markersize": 3, "label": f"S{i + 1}{i + 1}, {name}{remark}"}
            ax.plot(s.real, s.imag, style, **options | _overlaid(prefix, i))
    ax.set_aspect("equal")
    across = "Re S (resistance over the reference on the axis)"
    return finished(ax, across, "Im S", record.title, columns=2, grid=False)


def _sources(data: Columns):
    """Yield prefix, line style, frequencies in the axis's unit and remark of the prediction and of a measurement."""
    scale = quantity.frequency_Hz.scale
    yield "", "-", data.frequency_Hz * scale, ""
    if "measured_frequency_Hz" in data:
        yield "measured_", ".", data["measured_frequency_Hz"] * scale, f" ({data['measured_file']})"


def _circuit_panel(name: str, at, admittance, models) -> Panel:
    safe = "".join(letter if letter.isalnum() else "_" for letter in name)
    texts = [model.spice(f"{safe}_{kind}") for model, kind in zip(models, ("bvd", "motional"), strict=True)]
    one, several = (model.admittance(at) for model in models)
    title = (
        f"Transducer {name!r}: admittance and its equivalent circuits\none branch is {models[0].error:.1%} off, "
        f"{BRANCHES} branches are {models[1].error:.1%} off"
    )
    return Panel(name=f"circuit_{safe}", title=title, data=dict(
        frequency_Hz=at, admittance_S=admittance, one_branch_S=one, several_branches_S=several,
        spice="".join(texts),
    ))  # fmt: skip


def _measured(file: Path, model: Model, reference: float, port: str | int | None) -> NetworkData:
    """Return the data of a file for the scene's transducers, with their reference, which meets the passband."""
    refuse_if(not file.is_file(), "--measured", f"must be a network analyser's file, and {str(file)!r} is none")
    ports = sum(each.has_two_electrodes for each in model.scene.transducer)
    data = read_network(file, "--measured")
    if port is not None:
        refuse_if(not str(port).isdigit(), "--port", f"must be a number of a port, got {port!r}")
        refuse_if(ports != 1, "--port", f"takes one port for one transducer, and the scene has {ports}")
        data = data.one_port(int(port))
    hint = ": --port N takes one of them" if ports == 1 else ""
    refuse_if(
        data.ports != ports, "--measured", f"must be a file of {ports} ports, and {file.name!r} has {data.ports}{hint}"
    )
    data = data.with_reference(reference)
    refuse_other_range(model, data, "--measured")
    return data


def _measured_delay(measured: NetworkData, travel_time: float) -> dict:
    """Return the group delay of a file, or why it is not drawn: steps too wide to unwrap the phase."""
    if len(measured.frequency) < 2:
        return {"not_drawn": "the measured group delay is not drawn: it needs two frequencies"}
    step = float(np.max(np.diff(measured.frequency)))
    # echoes travel the distance twice more: their phase relative to the first arrival may change by pi per step
    widest = 0.5 / (2.0 * travel_time)
    if step > widest:
        rule = f"steps of {step / 1e3:.4g} kHz, at most {widest / 1e3:.4g} kHz would do"
        return {"not_drawn": f"the measured group delay is undersampled and not drawn: {rule}"}
    if not measured.elements[1, 0]:
        return {"not_drawn": "the measured group delay is not drawn: S21 was not measured"}
    delay = passband.group_delay(measured.frequency, measured.scattering[:, 1, 0], travel_time)
    return {"measured_frequency_Hz": measured.frequency, "measured_group_delay_s": delay}
