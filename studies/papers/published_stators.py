"""Predictions for published stators: conversion, matching and recovery of power.

Method: P-matrices (`fem.p_matrix`, without fitted parameters) of 21 finger pairs with a period of 400 um and of 32
pairs of reflecting strips beside them, on 128YX lithium niobate at 9.61 MHz with an aperture of 9 mm (Tokyo Institute
of Technology, KAKEN reports 22360101, 2010, and 15H03943). Only the surface wave travels between them. The plate of
1.5 mm is thick enough that its upper face has a surface wave of its own (1e-3 of the amplitude on the lower face). By
reciprocity, a second transducer of the same kind with the conjugate load recovers the same share of the arriving power
as it would send. With circulation (Asai, Kurosawa and Higuchi, "Novel power circulation methods for a surface acoustic
wave motor", IEEE Ultrasonics Symp. 2000) the source supplies the rest. Quantities that are not stated are swept in
every combination: open or connected strips, their period, their distance (for the largest share of the power to one
side, or for the largest power per volt), the loss on the way (diffraction, slider, mount), a load resistance parallel
to the reactance or in series with it, and 20.5 V as peak or as peak-to-peak value. Expected: each published number lies
in its band, and one layout meets all numbers of KAKEN 22360101 to 15 %. Run time: about 5 s.
"""

import logging
from itertools import product

import numpy as np

import fem
from studies.papers.published import Unknown
from studies.record.plots import COLOURS, finished
from studies.refusal import RunError
from studies.study_list import Answered, Finding, Panel, judged, of_record, study

LOGGER = logging.getLogger(__name__)

FREQUENCY, PERIOD, APERTURE, THICKNESS, PAIRS, STRIP_PAIRS = 9.61e6, 400e-6, 9e-3, 1.5e-3, 21, 32
ELECTRODES = {"open": "o", "connected": "+"}
SCALES = (1.0, 1.0075, 1.015, 1.0225, 1.03, 1.0375)  # open strips reflect most at 1.028, connected ones at 1.015
PATH = Unknown(name="power left after the path", taken=0.9, swept=(0.8, 1.0))
READING = Unknown(name="20.5 V: peak over stated value", taken=1.0, swept=(0.5, 1.0))
DISTANCES = 400  # in half a wavelength, after which the phase of a reflection repeats
AGREEMENT = 0.15
# KAKEN 15H03943, report of 2018: the wave is that on a plate of sapphire whose end is pressed on the chip's surface
MOTION, PLATE = 4.7e-9, "sapphire"
QUICK = {"scales": (1.0, 1.015), "electrodes": ("connected",), "tolerance": 0.3}
PUBLISHED = {
    "gain": ("KAKEN 22360101: reflectors put 1.7 times the power into the wave", 1.7, "", 1.0),
    "share": ("KAKEN 22360101: 85 % of the electric power goes into the wave", 0.85, "", 1.0),
    "load_ohm": ("KAKEN 22360101: the matched load has 70 ohm", 70.0, "ohm", 1.0),
    "standing_wave_ratio": ("KAKEN 22360101: standing-wave ratio 1.2 before the second transducer", 1.2, "", 1.0),
    "recovered": ("KAKEN 22360101: 65 % of the power is recovered", 0.65, "", 1.0),
    "input_ratio": ("Asai and Kurosawa: 1/7 of the input power for the same wave", 1 / 7, "", 1.0),
    "motion_m_per_V": ("KAKEN 15H03943: 20.5 V give 4.7 nm", MOTION / 20.5, "nm/V", 1e9),
}  # fmt: skip


@study()
def run(
    *, scales: tuple[float, ...] = SCALES, electrodes: tuple[str, ...] = tuple(ELECTRODES), pairs: int = PAIRS,
    strip_pairs: int = STRIP_PAIRS, tolerance: float = 2e-2,
) -> Answered:  # fmt: skip
    """Return predictions with their bands, and the published values.

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
    """
    fingers, cases = p_matrix_of(None, 1.0, pairs, tolerance), []
    for kind, scale in product(electrodes, scales):
        LOGGER.info(f"strips {kind}, period {scale:g} of the fingers'")
        strips = p_matrix_of(ELECTRODES[kind], scale, strip_pairs, tolerance)
        cases += [{"electrodes": kind, "scale": scale} | case for case in one_sided(fingers, strips)]
    columns = {key: [case[key] for case in cases] for key in cases[0]}
    every = {key: [value for case in cases for value in _values(key, case)] for key in PUBLISHED}
    bands = {key: (min(values), max(values)) for key, values in every.items()}
    shared = (
        f"swept: strips {' or '.join(electrodes)}, their period {min(scales):g} to {max(scales):g} of the fingers', "
        "distance of the largest share or of the largest power"
    )
    extra = {
        "load_ohm": "; resistance across a reactance or in series with it",
        "recovered": f"; {PATH}",
        "input_ratio": f"; {PATH}; transducers of the KAKEN stator, theirs are not known here",
        "motion_m_per_V": f"; {READING}; the chip's own surface, that of the sapphire plate pressed on it is below",
    }
    findings = []
    for key, (low, high) in bands.items():
        statement, published, unit, scale = PUBLISHED[key]
        findings.append(judged(
            statement, f"nearest prediction{f' ({unit})' if unit else ''}", min(max(published, low), high) * scale,
            expected=f"the published {published * scale:.3g} in the band {low * scale:.3g} to {high * scale:.3g}",
            holds=low <= published <= high, remark=shared + extra.get(key, ""),
        ))  # fmt: skip
    apart = [_deviation(case) for case in cases]
    best = cases[apart.index(min(apart))]
    findings.append(judged(
        "KAKEN 22360101: one layout has all five numbers", "largest relative difference of the nearest layout",
        min(apart), high=AGREEMENT,
        remark=f"strips {best['electrodes']}, period {best['scale']:g} of the fingers'; path and load free",
    ))  # fmt: skip
    findings.append(pressed_plate([20.5 * each for each in bands["motion_m_per_V"]]))
    names, values, *_ = zip(*PUBLISHED.values(), strict=True)
    columns |= {"names": list(names), "published": list(values),
                "low": [bands[key][0] for key in PUBLISHED], "high": [bands[key][1] for key in PUBLISHED]}  # fmt: skip
    title = "Published stators; bands: what is not stated"
    return (Panel(name="published_stators", title=title, data=columns),), findings


@of_record
def figure(panel: Panel, ax):
    """Draw band and all cases over the published value."""
    data, marks = panel.data, {"open": "o", "connected": "s"}
    for at, key in enumerate(PUBLISHED):
        published = data["published"][at]
        ax.plot([data["low"][at] / published, data["high"][at] / published], [at, at],
                color=COLOURS["stick"], linewidth=5, alpha=0.4, solid_capstyle="butt")  # fmt: skip
        for kind, mark in marks.items():
            every = zip(data[key], data["electrodes"], strict=True)
            values = [value / published for value, electrodes in every if electrodes == kind]
            label = f"strips {kind}" if at == 0 and values else None
            ax.plot(values, [at] * len(values), mark, color=COLOURS["slip"], fillstyle="none", label=label)
    ax.axvline(1.0, color=COLOURS["line"], linewidth=1)
    names = [name.partition(": ")[2] for name in data["names"]]
    ax.set_yticks(range(len(names)), names, fontsize="x-small")
    ax.set_ylim(len(names) - 0.5, -0.5)
    return finished(ax, "predicted over published", "", panel.title, columns=2)


def pressed_plate(amplitudes: list[float]) -> Finding:
    """Return the stiffness per area of the contact through which a chip moves the sapphire plate pressed on it.

    The chip's wave (k_1) pulls the plate by springs K per area: its wave (k_2) grows as -i Gamma_2 K u_1 exp(-i k_1 x)
    and is out of step after pi/|k_1 - k_2|, so that over any length |u_2| <= 2 Gamma_2 K |u_1| / |k_1 - k_2| (coupled
    modes, to first order). ``amplitudes``: least and largest |u_1| of the bare chip at 20.5 V, m.
    """
    chip = fem.rotated(fem.material("LiNbO3 (Kovacs)"), "128YX")
    plate = fem.rotated(fem.material(PLATE), "Z")
    velocities = [fem.rayleigh(each).velocity for each in (chip, plate)]
    out_of_step = 2 * np.pi * FREQUENCY * abs(1 / velocities[0] - 1 / velocities[1])
    least = [MOTION / each * out_of_step / (2 * fem.wave_compliance(plate)) for each in amplitudes[::-1]]
    return judged(
        "KAKEN 15H03943: a plate of sapphire pressed on the chip moves by 4.7 nm",
        "least stiffness of the contact (N/m^3)", least[0], holds=None, expected="not stated",
        remark=f"{least[0]:.2g} to {least[1]:.2g} N/m^3 for a chip that moves {amplitudes[1] * 1e9:.2g} to "
        f"{amplitudes[0] * 1e9:.2g} nm; waves of {velocities[0]:.5g} and {velocities[1]:.5g} m/s are out of step after "
        f"{np.pi / out_of_step * 1e6:.3g} um; sapphire's cut is not stated (Z is taken), its contact's length neither",
    )  # fmt: skip


def p_matrix_of(electrodes: str | None, scale: float, pairs: int, tolerance: float):
    """Return the P-matrix of fingers, or of strips of one kind of electrode."""
    solid = fem.rotated(fem.material("LiNbO3 (Kovacs)"), "128YX")
    stator = fem.Stator(solid=solid, length=1.0, thickness=THICKNESS, ends="absorbing")
    transducer = fem.Transducer(
        name="array", center=0.5, finger_pairs=pairs, period=PERIOD * scale, metallisation=0.5, aperture=APERTURE,
        pattern=electrodes and electrodes * 2 * pairs,
    )  # fmt: skip
    try:
        return fem.p_matrix(stator, transducer, frequency=FREQUENCY, tolerance=tolerance)
    except fem.ConvergenceError as error:
        raise RunError(str(error)) from None


def one_sided(fingers, strips) -> list[dict]:
    """Return the predictions for fingers with strips on the left, at the distances of largest share and power."""
    # S and p hold the waves at the left edge, then from `far` on those at the right; the upper face's is the first
    far = len(fingers.wavenumbers)
    s, p = fingers.scattering[np.ix_([0, far], [0, far])], fingers.excitation[[0, far]]
    distance = np.linspace(0, PERIOD / 2, DISTANCES, endpoint=False)
    back = np.exp(-2j * fingers.wavenumbers[0] * distance) * strips.scattering[far, far]
    # what arrives from the strips, over what the fingers send to the left
    returned = back / (1 - s[0, 0] * back)
    excitation = p[1] + s[1, 0] * returned * p[0]
    admittance = fingers.admittance - 2 * p[0] * returned * p[0]
    share = abs(excitation) ** 2 / admittance.real
    # the conjugate load takes the share of what arrives
    reflection = s[1, 1] + s[1, 0] * returned * s[0, 1] + excitation**2 / admittance.real
    alone = abs(p[1]) ** 2 / fingers.admittance.real
    numbers = {
        "distance_m": distance,
        "gain": share / alone,
        "share": share,
        "load_ohm": 1 / admittance.real,
        "series_ohm": (1 / admittance).real,
        "standing_wave_ratio": (1 + abs(reflection)) / (1 - abs(reflection)),
        "recovered": PATH.taken * share**2,
        "input_ratio": alone / share * (1 - PATH.taken * share**2),
        "motion_m_per_V": abs(excitation) * fingers.surface_motion[0],
        "alone": np.full(DISTANCES, alone),
    }
    best = (int(np.argmax(share)), int(np.argmax(abs(excitation))))
    return [{key: float(values[at]) for key, values in numbers.items()} for at in best]


def _values(key: str, case: dict) -> list[float]:
    """Return the predictions of a layout, for each swept value of the unknowns that are not part of it."""
    share = case["share"]
    if key == "load_ohm":  # across a reactance, or in series with it
        return [case["load_ohm"], case["series_ohm"]]
    if key == "recovered":
        return [path * share**2 for path in PATH.swept]
    if key == "input_ratio":
        return [case["alone"] / share * (1 - path * share**2) for path in PATH.swept]
    if key == "motion_m_per_V":
        return [reading * case[key] for reading in READING.swept]
    return [case[key]]


def _deviation(case: dict) -> float:
    """Return the largest relative difference of a layout from KAKEN 22360101, path and kind of resistance free."""
    deviations = []
    for key in ("gain", "share", "standing_wave_ratio", "load_ohm", "recovered"):
        published, values = PUBLISHED[key][1], _values(key, case)
        if key == "recovered":  # any path between the swept ones
            values = [min(max(published, min(values)), max(values))]
        deviations.append(min(abs(value / published - 1) for value in values))
    return max(deviations)
