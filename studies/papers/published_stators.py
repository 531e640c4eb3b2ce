"""Whether the stators that are published convert, match and return power as their papers say.

Method: P-matrices (`fem.p_matrix`, nothing fitted) of a row of 21 finger pairs of 400 um and of 32 pairs of reflecting
strips beside it, on 128YX lithium niobate at 9.61 MHz with 9 mm of aperture (Tokyo Institute of Technology, KAKEN
reports 22360101, 2010, and 15H03943).  Only the surface wave travels between them; the body is a half-space.  Strips at
the distance that sends the largest share of the power to one side.  A second transducer of the same kind with its
conjugate as the load returns that share of what arrives, by reciprocity; with circulation (Asai, Kurosawa and Higuchi,
IEEE Ultrasonics Symp. 2000, "Novel power circulation methods for a surface acoustic wave motor") the source gives the
rest.  What is not stated is swept, every combination: strips open or connected, their period, what the wave loses on
its way (diffraction, slider, mount), whether the load's resistance is across or in series
with its reactance, and whether 20.5 V is the peak value or from peak to peak.  Expected: each
published number in its band.  Run time: about 30 s.
"""

import time
from collections.abc import Callable
from itertools import product

from studies.papers.published import Unknown
from studies.refusal import RunError
from studies.study import Finding, Panel, StudyRecord, of_record

__all__ = ["figure", "run"]

FREQUENCY, PERIOD, APERTURE, PAIRS, STRIP_PAIRS = 9.61e6, 400e-6, 9e-3, 21, 32
ELECTRODES = {"open": "o", "connected": "+"}
SCALES = (1.0, 1.0075, 1.015, 1.0225, 1.03)  # open strips reflect most at 1.028, connected ones at 1.015
PATH = Unknown(name="power left after the path", taken=0.9, swept=(0.8, 1.0))
READING = Unknown(name="20.5 V: peak over stated value", taken=1.0, swept=(0.5, 1.0))
PLACES = 400  # distances looked at in half a wavelength, after which a reflection's phase repeats
QUICK = {"scales": (1.0, 1.015), "electrodes": ("connected",), "tolerance": 0.3}
PUBLISHED = {
    "gain": ("KAKEN 22360101: reflectors put 1.7 times the power into the wave", 1.7, "", 1.0),
    "share": ("KAKEN 22360101: 85 % of the electric power goes into the wave", 0.85, "", 1.0),
    "load_ohm": ("KAKEN 22360101: the matched load has 70 ohm", 70.0, "ohm", 1.0),
    "standing_wave_ratio": ("KAKEN 22360101: standing-wave ratio 1.2 before the second transducer", 1.2, "", 1.0),
    "recovered": ("KAKEN 22360101: 65 % of the power is recovered", 0.65, "", 1.0),
    "input_ratio": ("Asai and Kurosawa: 1/7 of the input power for the same wave", 1 / 7, "", 1.0),
    "motion_m_per_V": ("KAKEN 15H03943: 20.5 V give 4.7 nm", 4.7e-9 / 20.5, "nm/V", 1e9),
}  # fmt: skip


def run(
    *,
    scales: tuple[float, ...] = SCALES,
    electrodes: tuple[str, ...] = tuple(ELECTRODES),
    pairs: int = PAIRS,
    strip_pairs: int = STRIP_PAIRS,
    tolerance: float = 2e-2,
    progress: Callable[[str], None] | None = None,
) -> StudyRecord:
    """Return predictions with their bands beside what is published.

    Parameters
    ----------
    scales : tuple of float
        Period of the strips over that of the fingers.
    electrodes : tuple of str
        Of the strips, "open", "connected" or both.
    pairs, strip_pairs : int
        Of the transducer, and of the strips.
    tolerance : float
        Of the P-matrices.
    progress : callable, optional
        Told what is being done.
    """
    begun = time.perf_counter()
    row, cases = _p_matrix(None, 1.0, pairs, tolerance), []
    for kind, scale in product(electrodes, scales):
        if progress is not None:
            progress(f"strips {kind}, period {scale:g} of the fingers'")
        strips = _p_matrix(ELECTRODES[kind], scale, strip_pairs, tolerance)
        cases.append({"electrodes": kind, "scale": scale} | _one_sided(row, strips))
    columns = {key: [case[key] for case in cases] for key in cases[0]}
    bands = {key: _band(key, columns) for key in PUBLISHED}
    shared = f"swept: strips {' or '.join(electrodes)}, their period {min(scales):g} to {max(scales):g} of the fingers'"
    extra = {
        "load_ohm": "; resistance across a reactance or in series with it",
        "recovered": f"; {PATH}",
        "input_ratio": f"; {PATH}; transducers of the KAKEN stator, theirs are not known here",
        "motion_m_per_V": f"; {READING}; not pressed on anything",
    }
    findings = []
    for key, (low, high) in bands.items():
        statement, published, unit, scale = PUBLISHED[key]
        inside = low <= published <= high
        findings.append(
            Finding(
                statement=statement,
                quantity=f"nearest prediction{f' ({unit})' if unit else ''}",
                expected=f"the published {published * scale:.3g} in the band {low * scale:.3g} to {high * scale:.3g}",
                found=float(min(max(published, low), high) * scale),
                confirmed=bool(inside),
                remark=shared + extra.get(key, ""),
            )
        )
    columns |= {"names": [row[0] for row in PUBLISHED.values()], "published": [row[1] for row in PUBLISHED.values()],
                "low": [bands[key][0] for key in PUBLISHED], "high": [bands[key][1] for key in PUBLISHED]}  # fmt: skip
    title = "Published stators of 128YX (bands: what the papers do not state)"
    panel = Panel(name="published_stators", title=title, data=columns)
    return StudyRecord(
        name="published_stators",
        panels=(panel,),
        findings=tuple(findings),
        seconds=time.perf_counter() - begun,
    )


@of_record
def figure(panel: Panel, ax):
    """Draw band and case by case over the published value."""
    from studies.report.figures import COLOURS, legend_below

    data, marks = panel.data, {"open": "o", "connected": "s"}
    for at, key in enumerate(PUBLISHED):
        published = data["published"][at]
        ax.plot([data["low"][at] / published, data["high"][at] / published], [at, at],
                color=COLOURS["stick"], linewidth=5, alpha=0.4, solid_capstyle="butt")  # fmt: skip
        for kind, mark in marks.items():
            values = [
                value / published for value, own in zip(data[key], data["electrodes"], strict=True)
                if own == kind
            ]  # fmt: skip
            label = f"strips {kind}" if at == 0 and values else None
            ax.plot(values, [at] * len(values), mark, color=COLOURS["slip"], fillstyle="none", label=label)
    ax.axvline(1.0, color=COLOURS["line"], linewidth=1)
    names = [name.partition(": ")[2] for name in data["names"]]
    ax.set_yticks(range(len(names)), names, fontsize="x-small")
    ax.set_ylim(len(names) - 0.5, -0.5)
    ax.set_xlabel("predicted over published (a mark for each period of the strips)")
    ax.set_title(panel.title, fontsize="medium")
    ax.grid(axis="x", alpha=0.3)
    legend_below(ax, columns=2)
    return ax


def _p_matrix(electrodes: str | None, scale: float, pairs: int, tolerance: float):
    """Return the P-matrix of fingers, or of strips of one kind of electrode."""
    import fem

    solid = fem.rotated(fem.material("LiNbO3 (Kovacs)"), "128YX")
    stator = fem.Stator(solid=solid, length=1.0, thickness=float("inf"), ends="absorbing")
    transducer = fem.Transducer(
        name="row", center=0.5, finger_pairs=pairs, period=PERIOD * scale, metallisation=0.5, aperture=APERTURE,
        pattern=electrodes and electrodes * 2 * pairs,
    )  # fmt: skip
    try:
        return fem.p_matrix(stator, transducer, frequency=FREQUENCY, tolerance=tolerance)
    except fem.ConvergenceError as error:
        raise RunError(str(error)) from None


def _one_sided(row, strips) -> dict:
    """Return what fingers with strips to the left do at the best distance: sent to the right, received from there."""
    import numpy as np

    distance = np.linspace(0, PERIOD / 2, PLACES, endpoint=False)
    back = np.exp(-2j * row.wavenumbers[0] * distance) * strips.scattering[1, 1]
    (own, _), (_, right) = row.scattering
    to_left, to_right = row.excitation
    returned = back / (
        1 - own * back
    )  # of what leaves the fingers to the left, counted once, what arrives there
    excitation = to_right + row.scattering[1, 0] * returned * to_left
    admittance = row.admittance + row.detection[0] * returned * to_left
    share = abs(excitation) ** 2 / admittance.real
    best = int(np.argmax(share))
    p, y = excitation[best], admittance[best]
    reflection = right + row.scattering[1, 0] * returned[best] * row.scattering[0, 1]
    reflection += p**2 / y.real  # of the conjugate load, which takes the share of what arrives
    alone = abs(row.excitation[1]) ** 2 / row.admittance.real
    return {
        "gain": float(share[best] / alone),
        "share": float(share[best]),
        "load_ohm": float(1 / y.real),
        "series_ohm": float((1 / y).real),
        "standing_wave_ratio": float((1 + abs(reflection)) / (1 - abs(reflection))),
        "recovered": float(PATH.taken * share[best] ** 2),
        "input_ratio": float(alone / share[best] * (1 - PATH.taken * share[best] ** 2)),
        "motion_m_per_V": float(abs(p) * row.surface_motion[0]),
        "alone": float(alone),
    }


def _band(key: str, columns: dict) -> tuple[float, float]:
    """Return the lowest and highest of all cases, with the unknowns that a case does not hold."""
    values = columns[key]
    if key == "load_ohm":
        values = [*values, *columns["series_ohm"]]
    if key == "recovered":
        values = [path * share**2 for path in PATH.swept for share in columns["share"]]
    if key == "input_ratio":
        values = [
            alone / share * (1 - path * share**2)
            for path in PATH.swept
            for alone, share in zip(columns["alone"], columns["share"], strict=True)
        ]
    if key == "motion_m_per_V":
        values = [reading * each for reading in READING.swept for each in values]
    return min(values), max(values)
