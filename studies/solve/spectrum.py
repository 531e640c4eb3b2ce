"""A driven scene at many frequencies: interpolated over bands where its transducers allow it, else solved one by one.

`fem.frequency_band` interpolates over a band of limited width; a wider range is divided into several bands.  It cannot
be used if fingers are left out or uneven, if a neighbour or an end is nearer than half a gap, or for a position under a
transducer.  Every frequency is then solved alone, which is slower and gives the same numbers.
"""

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

import fem
from studies.model.model import Model
from studies.model.scene_errors import as_run_errors
from studies.refusal import RunError

LOGGER = logging.getLogger(__name__)

MAX_BAND_RATIO = 1.6  # highest over lowest frequency of one band
MAX_SINGLE = 5  # frequencies that cost less one by one than the set-up of a band


@dataclass(frozen=True, kw_only=True)
class Response:
    """A driven stator at any frequency of a range, with the interface that ``fem.burst_response`` needs."""

    limits: tuple[float, float]  # Hz
    bands: tuple = field(repr=False)  # fem.Band, from low to high; empty if every frequency is solved alone
    alone: Callable = field(repr=False)  # frequency -> fem.SurfaceWave, solved alone

    def wave(self, frequency: float, drive):
        """Return the fem.SurfaceWave at a frequency in Hz."""
        for band in self.bands:
            if band.limits[0] <= frequency <= band.limits[1]:
                try:
                    return band.wave(frequency, drive)
                except fem.ConvergenceError:
                    break
        return self.alone(frequency)

    def waves(self, frequencies, drive) -> list:
        """Return the fem.SurfaceWave at many frequencies in Hz, in their order; those of bands side by side."""
        each = fem.side_by_side if self.bands else map
        return list(each(lambda frequency: self.wave(float(frequency), drive), frequencies))


def response(
    model: Model, lowest: float, highest: float, *, positions: tuple[float, ...], tolerance: float
) -> Response:
    """Prepare a resolved scene with transducers for frequencies from lowest to highest (Hz).

    ``positions``: where the motion is evaluated, m from the left end; ``tolerance``: relative, of the motion there.
    """
    block, transducers = model.stator, model.section_transducers
    common = {"drive": model.drive, "tolerance": tolerance, "places": tuple(positions)}

    def alone(frequency: float):
        LOGGER.info(f"stator: {frequency / 1e6:.5g} MHz")
        with as_run_errors(f"at {frequency / 1e6:.6g} MHz"):
            return fem.driven_wave(block, transducers, frequency=float(frequency), **common)

    bands = []
    if takes_bands(block, transducers, positions):
        for low, high in pairwise(band_edges(lowest, highest)):
            LOGGER.info(f"stator: band {low / 1e6:.4g} to {high / 1e6:.4g} MHz")
            try:
                bands.append(fem.frequency_band(block, transducers, lowest=low, highest=high, **common))
            except fem.ConvergenceError:
                bands = []
                break
    return Response(limits=(lowest, highest), bands=tuple(bands), alone=alone)


def groups(model: Model, frequencies: np.ndarray) -> list[np.ndarray]:
    """Return rising frequencies in Hz as the bands that `port_admittances` solves, or each by itself."""
    edges = band_edges(frequencies[0], frequencies[-1])[1:-1]
    bands = np.split(frequencies, np.searchsorted(frequencies, edges))
    strips = [each.transducers for each in fem.strips_of(model.transducers)] if model.scene.in_strips else []
    sections = strips or [model.section_transducers]
    if len(frequencies) <= MAX_SINGLE * len(bands) or not all(takes_bands(model.stator, each, ()) for each in sections):
        return np.split(frequencies, len(frequencies))
    return bands


def port_admittances(model: Model, frequencies, tolerance: float):
    """Return the ``fem.PortAdmittance`` of a resolved scene over rising frequencies in Hz, computed as in a run.

    Raises
    ------
    RunError
        If some of the frequencies have no answer within the tolerance.
    """
    ports, failures = converged_admittances(model, frequencies, tolerance)
    if failures:
        raise RunError(failures[0])
    return ports


def converged_admittances(model: Model, frequencies, tolerance: float):
    """Return the ``fem.PortAdmittance`` at those frequencies in Hz that have an answer, and why the others have none.

    Raises
    ------
    RunError
        If no frequency has an answer.
    """
    parts: list = []
    failures: list[str] = []
    done = 0
    for group in groups(model, frequencies):
        last = done + len(group)
        which = f"frequency {last}" if len(group) == 1 else f"frequencies {done + 1} to {last}"
        LOGGER.info(f"stator: {which} of {len(frequencies)}, from {group[0] / 1e6:.5g} MHz")
        done = last
        try:
            with as_run_errors(f"from {group[0] / 1e6:.6g} to {group[-1] / 1e6:.6g} MHz"):
                parts.append(model.port_admittance(group, tolerance))
        except RunError as error:
            failures.append(str(error))
    if not parts:
        raise RunError(failures[0])
    ports = fem.PortAdmittance(
        names=parts[0].names, frequency=np.concatenate([part.frequency for part in parts]),
        matrix=np.concatenate([part.matrix for part in parts]),
        relative_error=max(part.relative_error for part in parts),
    )  # fmt: skip
    return ports, tuple(failures)


def driving_point(ports, transducers, drive):
    """Return the admittance, S, that a drive or a transducer's name meets at each frequency of `port_admittances`."""
    pairs = zip(ports.matrix, ports.frequency, strict=True)
    return np.array([fem.solve_circuit(y, ports.names, transducers, drive, f).admittance for y, f in pairs])


def band_edges(lowest: float, highest: float) -> list[float]:
    """Return the ends of the bands that a range is cut into, Hz."""
    count = max(1, math.ceil(math.log(highest / lowest) / math.log(MAX_BAND_RATIO)))
    return [lowest * (highest / lowest) ** (k / count) for k in range(count)] + [highest]


def takes_bands(block, transducers, positions) -> bool:
    """Return whether `fem.frequency_band` can be used, see the module's docstring."""
    ordered = tuple(sorted(transducers, key=lambda each: each.center))
    for each, gaps in zip(ordered, fem.outer_gaps(block, ordered), strict=True):
        left, right = each.extent[0] - gaps[0], each.extent[1] + gaps[1]
        narrow = any(gap < each.half_gap * (1 - 1e-9) for gap in gaps)
        if not each.even or "0" in each.signs or narrow or any(left <= position <= right for position in positions):
            return False
    return True
