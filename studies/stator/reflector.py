"""Reflection, transmission and scattering of the surface wave at the meshed pieces of a scene, over frequency.

Method: the pieces between semi-infinite uniform segments, joined to the guided modes of the section
(`fem.reflector`), without the transducers. Expected: reciprocity to rounding; the surface waves carry away no more
power than arrives. ``--band 2.1:2.3:5`` (MHz) gives the frequencies. Run time: about 1 s for each frequency and file.
"""

import logging
from collections.abc import Sequence

import numpy as np

import fem
from studies.model.model import Model
from studies.model.resolve import build
from studies.model.scene_errors import as_run_errors, stator_keys
from studies.record.plots import lines
from studies.record.quantities import quantity
from studies.record.values import Columns
from studies.scene import Scene
from studies.solve import passband
from studies.study_list import Answered, Panel, judged, of_record, study

LOGGER = logging.getLogger(__name__)

QUICK = {"count": 3, "tolerance": 0.1}
REACH = 0.05  # of the drive's frequency, either side


@study("reflector")
def run(scene: Scene, *, band: str | None = None, count: int = 11, tolerance: float = 1e-3) -> Answered:
    """Return reflection and transmission of the surface wave at the scene's pieces.

    Parameters
    ----------
    band : str, optional
        Frequencies START:STOP:N in MHz; the answer then states reflection and transmission at each.
    count : int
        Number of frequencies without a band, from 5 % below the scene's to 5 % above it.
    tolerance : float
        Of the amplitudes, over 1.
    """
    model = build(scene)
    resolved = model.scene
    if not resolved.piece:
        resolved.refuse("piece", "is missing: this study asks what a meshed piece sends back")
    stator, middle = stator_beside_pieces(model), resolved.frequency
    at = middle * np.linspace(1 - REACH, 1 + REACH, count) if count > 1 else np.array([middle])
    if band is not None:
        at = passband.band_frequencies(model, band)
    answers = []
    for f in at:
        LOGGER.info(f"reflection at {f / 1e6:.5g} MHz")
        with as_run_errors(f"at {f / 1e6:.6g} MHz"):
            answers.append(fem.reflector(stator, frequency=float(f), tolerance=tolerance))
    center = answers[len(answers) // 2]
    panels, answer, matrices = [], [], [each.scattering for each in answers if each.scattering is not None]
    if matrices:
        data = dict(
            frequency_Hz=at,
            reflection=np.array([each.reflection for each in answers]),
            transmission=np.array([each.transmission for each in answers]),
            scattered_share=np.array([each.scattered for each in answers]),
        )
        panels.append(Panel(name="row", title=f"{resolved.title}: all pieces together", data=data))
        where = f"at {center.frequency / 1e6:.5g} MHz"
        answer += [
            ("reflection", f"{abs(center.reflection):.4f} {where}"),
            ("transmission", f"{abs(center.transmission):.4f}"),
            ("scattered or lost", f"{center.scattered:.3g} of the power"),
        ]
        for each in answers if band is not None else ():
            amplitudes = f"reflection {abs(each.reflection):.4f}, transmission {abs(each.transmission):.4f}"
            answer.append((f"{each.frequency / 1e6:.5g} MHz", amplitudes))
        for index, (name, _) in enumerate(center.pieces if len(stator.placement.between) > 1 else ()):
            own = [each.pieces[index][1].scattering for each in answers]
            scattered = np.array([1 - np.sum(abs(each[:, 0]) ** 2) for each in own])
            data = from_the_left(at, own) | {"scattered_share": scattered}
            panels.append(Panel(name=f"piece_{index}", title=f"{resolved.title}: {name} alone", data=data))
            answer.append((f"{name} alone", f"reflection {abs(own[len(own) // 2][0, 0]):.4f}"))
    for index, (name, reflection) in enumerate(center.ends):
        sent = np.array([each.ends[index][1] for each in answers])
        data = dict(frequency_Hz=at, reflection=sent)
        panels.append(Panel(name=f"end_{index}", title=f"{resolved.title}: {name}", data=data))
        answer.append((name, f"reflection {abs(reflection):.4f}"))
    findings = []
    if matrices:
        uneven = max(abs(each - each.T).max() for each in matrices)
        powers = max(np.sum(abs(each) ** 2, axis=0).max() for each in matrices)
        findings = [
            judged("What passes from the left passes from the right.", "largest difference of S from its transpose",
                   uneven, high=1e-9),
            judged("The surface waves take away no more power than arrives.", "largest share", powers,
                   high=1 + tolerance, expected="at most 1"),
        ]  # fmt: skip
    return tuple(panels), tuple(findings), answer


def stator_beside_pieces(model: Model) -> fem.Stator:
    """Return the stator of a resolved scene; refuse a piece that is all of it."""
    with stator_keys("piece"):
        fem.check_beside_pieces(model.stator)
    return model.stator


def from_the_left(at: np.ndarray, matrices: Sequence[np.ndarray]) -> Columns:
    """Return what scattering matrices over frequencies (Hz) make of the surface wave from the left, for a panel."""
    half = len(matrices[0]) // 2
    reflection, transmission = (np.array([each[row, 0] for each in matrices]) for row in (0, half))
    return Columns(frequency_Hz=at, reflection=reflection, transmission=transmission)


@of_record
def figure(record: Panel, ax):
    """Draw sizes of reflection and transmission over frequency."""
    rows = [("reflection", "o-", "slip", "reflection")]
    if "transmission" in record.data:
        rows.append(("transmission", "-", "line", "transmission"))
    return lines(
        ax, record, quantity.frequency_Hz, tuple(rows), quantity.reflection if len(rows) == 1 else quantity.wave_ratio
    )
