"""The temperature that a stator's own heat gives it at a fixed frequency: ``stator.temperature = "steady"``.

Between absorbing ends the power hardly depends on the temperature: the stator is solved at its temperature again until
it does not change (secants), with the temperature at the driven fingers, whose place detunes. Between reflecting ends a
resonance moves with the temperature and may have several steady states. Its power over frequency is computed once, at
the ambient temperature; a stator at a rise t meets the drive f where the cold one meets f F(0)/F(t), F the velocity's
dependence on the temperature, so that the rise held at every temperature is known and all states and folds are seen
(`fem.heated_states`). The coolest stable one, to which a cold start comes, is then solved with the constants at its
temperature until the mean temperature agrees.
"""

import logging
import math
from dataclasses import dataclass, replace

import numpy as np

import fem
from studies.model.fem_objects import relative_frequency
from studies.model.model import Model
from studies.model.solid_of_material import crystal
from studies.record import Record
from studies.record.blocks import HeatBlock
from studies.refusal import RunError
from studies.scene.stator_keys import Stator
from studies.solve.electrical import electrical_block
from studies.solve.heat import KNOWN_RISE, duty, frequency_slope, plate, sources, temperature, thermal_constants
from studies.solve.spectrum import converged_admittances
from studies.solve.surface_blocks import surface_columns, wave_block
from studies.solve.surface_motion import solved_motion

LOGGER = logging.getLogger(__name__)

PER_WIDTH = 8  # samples in the half-power width f/Q of a resonance: a cubic spline errs by 1e-3 of its peak
MIN_SAMPLES, MAX_SAMPLES = 33, 2001
BESIDE = 6.0  # half-power widths that are sampled beyond the coldest and the hottest frequency, where folds may lie
FITTED = 7  # temperatures at which the velocity is computed; between them a polynomial
ROUNDS = 8  # solutions of the stator, at most
ROUNDING = 1e-12
RESPONSE_TOLERANCE = 5e-2  # of the sampled response, whose states are solved again to the tolerance of the run
AGREED = 1e-3  # relative change of the rise, or in K below 1 K, at which the temperature counts as found


@dataclass(frozen=True, kw_only=True)
class SteadyTemperature:
    """A stator's steady temperature and what other states there are."""

    temperature: float  # degC
    residual: float  # K, by which the rise that its powers hold differs
    others: tuple[float, ...] = ()  # degC, of the other stable states
    folds: tuple[float, ...] = ()  # Hz, of the drive: at each a stable state vanishes
    number: float | None = None  # foldover number; None between absorbing ends

    def block(self) -> HeatBlock:
        """Return the keys of run.json."""
        branch = "cold" if self.others else "only"
        return HeatBlock(
            steady_temperature_degC=self.temperature, steady_residual_K=self.residual, branch=branch,
            other_temperatures_degC=self.others or None, fold_frequencies_Hz=self.folds or None,
            foldover_number=self.number,
        )  # fmt: skip


def at_own_temperature(model: Model, tolerance: float) -> tuple[Model, HeatBlock]:
    """Return the model at the temperature of its own heat if it is to be solved there, and what is known of that."""
    if model.scene.stator is None or not model.scene.stator.is_steady:
        return model, HeatBlock()
    steady = steady_temperature(model, tolerance)
    return model.at_temperature(steady.temperature), steady.block()


def steady_temperature(model: Model, tolerance: float) -> SteadyTemperature:
    """Return the temperature that a resolved scene's own heat holds at its largest level.

    ``tolerance``: relative, of the surface's motion.

    Raises
    ------
    RunError
        If there is no steady temperature below the Curie temperature, or it is not found.
    """
    scene, stator = model.scene, model.scene.stator
    if not max(scene.levels, default=0.0) > 0.0:
        return SteadyTemperature(temperature=stator.ambient, residual=0.0)
    if stator.ends == "absorbing":
        return _agreed(model, tolerance, 0.0, None)
    frequencies, held = _response(model, tolerance)
    rises = _rises(stator)
    met = scene.frequency / _frequency_factors(stator, rises, scene.frequency)
    if met.min() < frequencies[0] * (1 - ROUNDING) or met.max() > frequencies[-1] * (1 + ROUNDING):
        raise RunError(f"the stator has no answer at all frequencies from {met.min():.6g} to {met.max():.6g} Hz")
    at = np.interp(met, frequencies, held)
    states = fem.heated_states(rises, at)
    stable = [each.rise for each in states if each.stable]
    if not stable:
        limit = stator.ambient + rises[-1]
        raise RunError(f"there is no steady temperature up to {limit:.3g} degC: lower the voltage or cool the stator")
    slope = float(np.interp(stable[0], rises, np.gradient(at, rises)))
    found = _agreed(model, tolerance, stable[0], slope)
    coefficient = frequency_slope(stator, scene.frequency)
    return replace(
        found, others=tuple(stator.ambient + rise for rise in stable[1:]),
        folds=fem.drive_folds(frequencies, held, coefficient),
        number=fem.sampled_foldover_number(frequencies, held, coefficient),
    )  # fmt: skip


def _agreed(model: Model, tolerance: float, rise: float, slope: float | None) -> SteadyTemperature:
    """Return the temperature at which the stator holds its own rise, by secants from a rise in K.

    ``slope``: of the held rise with the rise there; None: the first step takes the held rise.
    """
    stator, tried = model.scene.stator, list[tuple[float, float]]()  # rise, and what the heat holds beyond it, K
    ambient = stator.ambient
    while len(tried) < ROUNDS and 0.0 <= rise <= _largest_rise(stator):
        LOGGER.info(f"stator at {ambient + rise:.4g} degC")
        excess = _held(model, ambient + rise, tolerance) - rise
        if abs(excess) <= AGREED * max(rise, 1.0):
            return SteadyTemperature(temperature=ambient + rise, residual=abs(excess))
        if tried:
            slope = 1.0 + (excess - tried[-1][1]) / (rise - tried[-1][0])
        tried.append((rise, excess))
        rise += excess if slope is None or slope >= 1.0 else excess / (1.0 - slope)
    last, excess = tried[-1]
    raise RunError(
        f"the steady temperature was not found near {ambient + last:.4g} degC, where the heat holds "
        f"{ambient + last + excess:.4g} degC: lower the voltage, or give stator.temperature as a number"
    )


def _held(model: Model, temperature_degC: float, tolerance: float) -> float:
    """Return the rise in K that the powers of the stator at a temperature hold: at the fingers, or between ends."""
    scene, warm = model.scene, model.at_temperature(temperature_degC)
    motion = solved_motion(
        warm.alone, scene.positions, tolerance=tolerance, slider=scene.slider is not None, missed=True
    )  # fmt: skip
    record = Record(
        scene=warm.scene, tolerance=tolerance, wave=wave_block(warm.scene, motion, None),
        surface=surface_columns(warm.scene, motion),
        electrical=electrical_block(scene.drive, motion, _further(warm, tolerance)),
    )  # fmt: skip
    if scene.stator.ends != "absorbing":
        return _plate(scene.stator).steady_rise(sum(each.power for each in sources(record, duty(scene.drive) or 1.0)))
    warmed = temperature(record)
    return 0.0 if warmed is None else float(warmed.at(scene.driven_transducer.center_xy[0]))


def _further(model: Model, tolerance: float) -> list:
    """Return the motions at the further frequencies of the sources."""
    if len(model.scene.drive.frequencies) < 2:
        return []
    from studies.solve.plane_surface import further_motions

    return further_motions(model, tolerance)


def _response(model: Model, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies in Hz and the mean rise in K that the stator at the ambient temperature holds at each."""
    scene, stator = model.scene, model.scene.stator
    cold = model.at_temperature(stator.ambient)
    quality = stator.mechanical_quality or crystal(stator.material).mechanical_quality
    met = scene.frequency / _frequency_factors(stator, _rises(stator), scene.frequency)
    margin = BESIDE * scene.frequency / quality if math.isfinite(quality) else 0.0
    low, high = met.min() - margin, met.max() + margin
    wanted = PER_WIDTH * (high - low) / (scene.frequency / quality) if math.isfinite(quality) else MAX_SAMPLES
    at = np.linspace(low, high, int(np.clip(math.ceil(wanted), MIN_SAMPLES, MAX_SAMPLES)))
    ports, _ = converged_admittances(cold, at, max(tolerance, RESPONSE_TOLERANCE))
    pairs = zip(ports.matrix, ports.frequency, strict=True)
    powers = [fem.solve_circuit(y, ports.names, cold.transducers, cold.drive, f).power for y, f in pairs]
    others = sum(each.circuit.power for each in _further(cold, tolerance))  # hardly depend on the temperature
    share = (duty(scene.drive) or 1.0) * max(scene.levels) ** 2
    return np.asarray(ports.frequency), _plate(stator).resistance * share * (np.array(powers) + others)


def _plate(stator: Stator) -> fem.HeatedPlate:
    body = plate(stator)
    assert body is not None  # `studies.model.resolve` has refused a scene without
    return body


def _frequency_factors(stator: Stator, rises: np.ndarray, frequency: float) -> np.ndarray:
    """Return the resonances' frequency, near ``frequency`` in Hz, at rises in K over that at ambient temperature."""
    ambient = stator.ambient
    nodes = np.linspace(0.0, rises[-1], FITTED)
    cold = relative_frequency(stator, ambient, frequency)
    values = [relative_frequency(stator, ambient + each, frequency) / cold for each in nodes]
    return np.polynomial.Polynomial.fit(nodes, values, FITTED - 1)(rises)


def _rises(stator: Stator) -> np.ndarray:
    """Return the rises in K among which states are looked for."""
    return np.linspace(0.0, _largest_rise(stator), MAX_SAMPLES)


def _largest_rise(stator: Stator) -> float:
    curie = thermal_constants(stator.material)["curie_temperature"]
    return KNOWN_RISE if curie is None else curie - stator.ambient
