"""Regimes of the slider (stick, slip, intermittent contact, hopping) against amplitude and preload.

Method: the slider of a scene (``twente-contact`` by default) on the orbits of its [wave] or of its stator's wave,
on a grid of amplitudes and preloads. Steady states come from averaging with its second-order correction. They are
compared with the closed forms of the threshold, A sqrt(r^2 + c^2) = c h, of the release, A = h, and of hopping, h = 0,
beyond which the slider rides above the surface at rest (h < 0, contact for less than half of each cycle). Here
A = |u_z|, r = |u_x/u_z|, c is the slope of the slip limit over the approach (`limit_slope`), and h the slider's mean
approach on the wave, at which the cycle mean of the normal force is the preload. The levels of the scene are marked.
Points to which averaging does not apply (close to the threshold) are marked and not judged. Expected: every other point
lies on the side of the lines that corresponds to its regime; the event-driven method gives the same velocity to 1e-6 at
a dozen points. Run time: about 1 s, plus the time of the stator.
"""

import logging
import math
from dataclasses import replace

import numpy as np

import contact
from contact.error_estimate import averaged_threshold_error
from studies.model.wave_to_contact import Contact, scaled
from studies.record.plots import COLOURS, curve, finished, logarithmic, own
from studies.record.quantities import quantity
from studies.scene import Scene
from studies.study_list import Answered, Panel, driven_contact, judged, of_record, study

LOGGER = logging.getLogger(__name__)

QUICK = {"amplitudes": 8, "preloads": 5, "checked": 2}
MARGIN = 1.05  # of the axis of amplitudes beyond its first and last point
KINDS = ("stick", "slip", "intermittent", "hopping")
HALF_WAVE = math.gamma(1.25) / (2.0 * math.sqrt(math.pi) * math.gamma(1.75))  # cycle mean of max(cos, 0)^1.5


@study("twente-contact")
def run(
    scene: Scene, *, amplitudes: int = 36, preloads: int = 28, checked: int = 12, tolerance: float = 1e-3
) -> Answered:
    """Return the map of regimes, the theoretical lines and the operating points.

    Parameters
    ----------
    amplitudes, preloads : int
        Number of grid points along each axis.
    checked : int
        Number of points that the event-driven method solves again.
    tolerance : float
        Of the slider velocity, for the stator.
    """
    driven = driven_contact(scene, tolerance=tolerance)
    resolved_scene, slider = driven.scene, driven.slider
    per_metre = driven.at(1.0 / driven.amplitude)  # orbits at an amplitude of 1 m, so that their factors are amplitudes
    if slider.shape != "sphere" or slider.heights or slider.normal_law or slider.adhesion:
        resolved_scene.refuse("slider", "must stand on smooth dry balls of equal height for a map of regimes")
    operating_preload = slider.preload
    refuse_frictionless(resolved_scene)
    share = resolved_scene.slider.share  # contacts that move alike are computed as one, with its part of the preload
    at, loads, operating = _grid(driven, per_metre, amplitudes, preloads)
    LOGGER.info(f"regime map: {at.size * loads.size} steady states")
    sliders = [replace(slider, preload=float(preload)) for preload in loads]
    # (slider, orbits) of each point (preload, amplitude): one slider for each preload, and 0, the only set of orbits
    which = np.stack([*np.indices((loads.size, 1))], axis=-1).repeat(at.size, axis=1)
    factors = np.tile(at, (loads.size, 1))
    states = contact.steady_sweep(sliders, [per_metre], which=which, factors=factors, wave_errors=[0.0])
    kind = np.where((states.regime == "intermittent") & (states.height < 0.0), "hopping", states.regime)
    kind[states.held] = "stick"  # with different orbits, some balls can slip while the slider does not move
    shares = sum(abs(orbit.normal) ** 1.5 for orbit in per_metre)
    release = [contact.release(s, per_metre) for s in sliders]
    lines = {
        "threshold": np.array([contact.threshold(s, per_metre).value for s in sliders]),
        "release": np.array([each.value for each in release]),
        # at h = 0 the mean of max(cos, 0)^1.5 over a cycle carries the preload, of all contacts together
        "hopping": np.array([s.rest_approach(1) for s in sliders]) / (shares * HALF_WAVE) ** (2.0 / 3.0),
    }
    # A point below the threshold sticks, one below the release slips, one below hopping is intermittent: `np.select`
    # takes the first line, in this order, that the amplitude does not reach.
    below = [at[None, :] < line[:, None] for line in lines.values()]
    # a point within the error of a line may lie on either side
    error = np.array([each.error / each.value for each in release])[:, None]
    # the simulated points are averaged, but the lines hold for the exact motion
    bounce = np.array([s.normal_resonance(len(per_metre)) / per_metre[0].frequency for s in sliders])[:, None]
    error = np.maximum(error, averaged_threshold_error(bounce, 0.0))
    close = [abs(at[None, :] / line[:, None] - 1.0) <= error for line in lines.values()]
    known, expected = (kind != "unknown") & ~np.any(close, axis=0), np.select(below, KINDS[:3], KINDS[3])
    # a load changes only the threshold; the other lines depend on the normal motion alone
    agree = float(np.mean(expected[known] == kind[known]))
    LOGGER.info("regime map: checks by the event-driven method")
    findings = (
        judged("The closed forms of threshold, release and hopping separate the simulated regimes.",
               "fraction of simulated points on the expected side", agree, holds=agree == 1.0, expected="1",
               remark=f"without {np.sum(kind == 'unknown')} points to which averaging does not apply, and those "
                      "within the error of a line"),
        judged("Averaging gives the steady velocity of the full motion.",
               f"largest difference over max(|v|, omega |u_x|/10) at {checked} points",
               _largest_difference(sliders, per_metre, at, states, checked), high=1e-6),
    )  # fmt: skip
    panel = Panel(name="regime_map", title=f"{resolved_scene.title}: regimes", data=dict(
        amplitude_m=at, preload_N=share * loads, kind=kind.tolist(),
        velocity_m_per_s=finite_lists(states.velocity),
        lines_m=lines, operating_amplitude_m=operating, operating_preload_N=share * operating_preload,
        contacts=len(per_metre),
    ))  # fmt: skip
    return (panel,), findings


def _grid(driven: Contact, per_metre: tuple, amplitudes: int, preloads: int) -> tuple:
    """Return amplitudes and preloads of a grid that covers all regimes, and the amplitudes of the scene."""
    operating = driven.amplitude * np.array(driven.levels)
    threshold = contact.threshold_factor(driven.slider, per_metre)
    release = contact.release_factor(driven.slider, per_metre)
    if not (np.isfinite(threshold) and np.isfinite(release) and threshold > 0.0):
        driven.scene.refuse(
            driven.scene.level_key, "must move the surface in both directions, so that the slider can start and part"
        )
    at = np.geomspace(min(0.4 * threshold, 0.8 * operating[0]), max(6.0 * release, 1.2 * operating[-1]), amplitudes)
    return at, driven.slider.preload * np.geomspace(0.08, 12.0, preloads), operating


def refuse_frictionless(scene: Scene) -> None:
    """Raise a SceneError for a slider without preload or friction, which has no regimes."""
    if scene.slider.preload == 0.0 or scene.slider.static_coefficient == 0.0:
        scene.refuse("slider.preload", "must be positive, with friction, for a map of regimes")


def finite_lists(values: np.ndarray) -> list:
    """Return an array as nested lists, with None for values that are not finite, as JSON needs them."""
    lists = values.astype(object)
    lists[~np.isfinite(values)] = None
    return lists.tolist()


def _largest_difference(sliders, per_metre, amplitudes, states, checked: int) -> float:
    """Return the largest difference from the event-driven method over a selection of moving points."""
    moving = np.argwhere(np.abs(np.nan_to_num(states.velocity)) > 0.0)
    differences = [0.0]
    for i, j in moving[:: max(1, len(moving) // checked)][:checked]:
        orbits = scaled(per_metre, float(amplitudes[j]))
        full = contact.steady(sliders[i], orbits, tolerance=1e-6).velocity
        differences.append(abs(full - states.velocity[i, j]) / contact.reference_speed(full, orbits[:1]))
    return float(max(differences))


@of_record
def figure(record: Panel, ax):
    """Draw simulated regimes as points, closed forms as lines, the operating points as stars."""
    data, kind = record.data, np.array(record.data["kind"])
    across, up = quantity.normal_amplitude_m, quantity.preload_N
    A, preload = np.asarray(data["amplitude_m"]) * across.scale, np.asarray(data["preload_N"]) * up.scale
    for name, mark, colour in zip(KINDS, "so^d", ("stick", "slip", "intermittent", "second"), strict=True):
        i, j = np.nonzero(kind == name)
        curve(ax, A[j], preload[i], mark, colour, f"{name} (simulated)")
    i, j = np.nonzero(kind == "unknown")
    if i.size:
        ax.plot(A[j], preload[i], "x", color=COLOURS["line"], markersize=5.0, label="unknown (averaged)")
    for (name, values), style in zip(data["lines_m"].items(), (":", "--", "-."), strict=True):
        whose = " of the first contact" if name == "release" and data["contacts"] > 1 else ""
        curve(ax, np.asarray(values) * across.scale, preload, style, "line", f"{name}{whose} (theory)")
    operating = np.asarray(data["operating_amplitude_m"]) * across.scale
    own(ax, operating, np.full(operating.size, data["operating_preload_N"] * up.scale), "operating points")
    ax.set_xlim(A[0] / MARGIN, A[-1] * MARGIN)  # no mark is cut by the frame
    logarithmic(ax.xaxis)
    logarithmic(ax.yaxis)
    return finished(ax, across.axis, up.axis, record.title, grid=False)
