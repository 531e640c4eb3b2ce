"""Motion of the surface and currents of the transducers by a force of 1 N under the slider, along z and along x.

Method: the force acts on a strip along y at the slider of the scene (``twente`` by default; in the middle of a stator
without a slider), half a wavelength long by default, and the sources of the drive are replaced by their
impedances. The motion follows from the guided modes that a force sends (`fem.forced_wave`), spread at every lateral
wavenumber (`fem.surface_beam`); the currents into the transducers by reciprocity with their own beams. Where no beam is
computed, the force is spread over the narrowest aperture of the plane section. With ``--band 1.9:2.5:13`` (MHz) the
currents are computed at those frequencies too. Expected: the charges that the waves of the force induce carry the same
currents within 30 %, because they take these waves at the centre of each transducer, and within 2 % far away; in the
plane section the current into the driven transducer per newton equals the velocity at the force per volt within three
tolerances. An estimated error above the tolerance is a remark, also near the force, whose evanescent waves are left
out. Run time: about 8 s; a frequency of a band takes 2 s with a beam and 0.05 s in the plane section.
"""

import logging
from dataclasses import dataclass, replace

import numpy as np

import fem
from studies.model.model import Model
from studies.model.scene_errors import as_run_errors
from studies.record.plots import PALETTE, curve, lines
from studies.record.quantities import quantity
from studies.refusal import RunError
from studies.report.explanation import band_seconds, plan
from studies.scene import Scene
from studies.solve import passband
from studies.study_list import Answered, Panel, judged, of_record, study

LOGGER = logging.getLogger(__name__)

QUICK = {"count": 60, "tolerance": 0.1}
BY_CHARGES = "largest relative difference of the currents by induced charges from those by reciprocity with the beams"
BY_VOLT = "largest relative difference of the current per newton from the velocity at the force per volt"
ROUNDING = 1e-15  # A or V per newton: the current of an open transducer, the voltage of a shorted one
FORCES = {"z": "normal", "x": "tangential"}


@study("twente")
def run(
    scene: Scene, *, band: str | None = None, width: float | None = None, count: int = 400, tolerance: float = 1e-3,
) -> Answered:  # fmt: skip
    """Return the motion along the stator and the currents into the transducers.

    Parameters
    ----------
    band : str, optional
        START:STOP:N, frequencies in MHz at which the currents are computed.
    width : float, optional
        Length of the strip along y, m; by default half a wavelength, or the narrowest aperture in the plane section.
    count : int
        Points along the stator.
    tolerance : float
        Relative, of the surface motion two wavelengths from the force.
    """
    model = passband.driven_model(scene)
    resolved, problem = model.scene, _ForceProblem.of(model, width, tolerance)
    LOGGER.info("stator: the response to a force")
    answers = {component: problem.response(component, resolved.frequency) for component in FORCES}
    x = np.linspace(0.0, resolved.stator.length, count)
    x = x[abs(x - problem.position[0]) > problem.wavelength]
    data, worst, worst_x = dict(x_m=x), 0.0, 0.0
    for component, name in FORCES.items():
        motion, error = problem.motion_and_error(answers[component], x)
        data[f"{name}_m_per_N"] = motion
        # relative to the rms motion: beside it, minima of standing waves have a large relative error
        of_rms = error * abs(motion) / np.sqrt(np.mean(abs(motion) ** 2))
        worst, worst_x = max((worst, worst_x), (float(of_rms.max()), float(x[of_rms.argmax()])))
    answer = [
        ("force", f"1 N on a strip of {problem.width * 1e3:.4g} mm at x = {problem.position[0] * 1e3:.6g} mm, "
                  f"y = {problem.position[1] * 1e3:.4g} mm, {resolved.frequency / 1e6:.6g} MHz"),
        ("method", "finite aperture" if problem.spreads else f"plane section: {problem.reason}"),
    ]  # fmt: skip
    for component in FORCES:
        circuit = answers[component].circuit
        for port, current, voltage in zip(circuit.names, circuit.currents, circuit.voltages, strict=True):
            sizes = (f"{abs(current) * 1e6:.4g} uA", f"{abs(voltage) * 1e3:.4g} mV")
            there = [size for size, value in zip(sizes, (current, voltage), strict=True) if abs(value) > ROUNDING]
            answer.append((port, f"{' and '.join(there)} per newton along {component}"))
    beside = max(problem.motion_and_error(each, np.array(problem.beside))[1].max() for each in answers.values())
    answer.append(("relative error", f"{beside:.1e} two wavelengths beside the force, asked for {tolerance:.1e}; up to "
                                     f"{worst:.1e} of the rms motion elsewhere"))  # fmt: skip
    if problem.spreads:
        of_currents = max(each.received_error for each in answers.values())
        answer.append(("", f"{of_currents:.1e} of the currents into transducers at a voltage of zero"))
    panels = [Panel(name="along", title=f"{resolved.title}: u_z by 1 N at {problem.position[0] * 1e3:g} mm", data=data)]
    if band is not None:
        panels += _over_the_band(problem, passband.band_frequencies(model, band))
    bound = {"high": 1.000001 * tolerance, "expected": f"at most {tolerance:g}"}
    findings = (
        *_reciprocity(problem, answers),
        judged("The motion beside the force meets the tolerance.",
               "estimated error two wavelengths beside the force", beside, **bound),
        judged("The motion along the whole stator meets the tolerance.",
               f"largest estimated error over the rms motion, which is at x = {worst_x * 1e3:.4g} mm", worst, **bound),
    )  # fmt: skip
    return panels, findings, answer


def expected_seconds(scene: Scene, band: str | None = None, tolerance: float = 1e-3) -> float:
    """Return about how long the study takes for a scene, s: two forces, at one frequency and at those of a band."""
    model = passband.driven_model(scene)
    one = len(FORCES) * plan(replace(model.scene, slider=None), tolerance=tolerance)["expected"]["stator_seconds"]
    seconds = 5.0 + one
    if band is not None:
        at = passband.band_frequencies(model, band)
        spreads = _ForceProblem.of(model, None, tolerance).spreads
        seconds += len(at) * one if spreads else band_seconds(model, at, tolerance=tolerance)
    return seconds


@dataclass(frozen=True, kw_only=True)
class _ForceProblem:
    """Position and width of the force on the stator of a scene."""

    model: Model
    position: tuple[float, float]  # m
    width: float  # m, along y
    tolerance: float
    wavelength: float  # m
    reason: str  # why no beam is computed; empty if one is

    @classmethod
    def of(cls, model: Model, width: float | None, tolerance: float) -> "_ForceProblem":
        scene, stator = model.scene, model.stator
        position = scene.positions[0] if scene.slider is None else scene.slider.center
        wavelength = fem.bound_wave(stator, scene.frequency).velocity / scene.frequency
        reason = "stator.diffraction is false" if scene.stator.diffraction is False else fem.beam_refusal(stator)
        if not reason and stator.ends != "absorbing":
            reason = "the beam of a force needs stator.ends = 'absorbing'"
        narrowest = min(each.aperture for each in model.section_transducers)
        if reason and width is not None:
            scene.refuse("stator", f"must allow a beam for a strip of a specified width: {reason}")
        width = width or (narrowest if reason else wavelength / 2)
        return cls(
            model=model, position=position, width=width, tolerance=tolerance, wavelength=wavelength, reason=reason
        )

    @property
    def scene(self) -> Scene:
        """The resolved scene."""
        return self.model.scene

    @property
    def spreads(self) -> bool:
        """True if the beam of the strip is computed."""
        return not self.reason

    @property
    def beside(self) -> tuple[float, ...]:
        """Positions on the stator two wavelengths from the force, m."""
        length = self.scene.stator.length
        both = (self.position[0] + side * 2 * self.wavelength for side in (-1, 1))
        return tuple(each for each in both if 0.0 <= each <= length) or (length / 2,)

    def force(self, component: str):
        """Return the ``fem.LineForce`` of 1 N."""
        strip = {"width": self.width, "center_y": self.position[1]} if self.spreads else {}
        return fem.LineForce(
            name="force", position=self.position[0], component=component, amplitude=1.0 / self.width, **strip
        )

    def spread(self, wave):
        """Return the beam of a section's wave if one is computed, else the wave."""
        if not self.spreads:
            return wave
        try:
            return fem.surface_beam(wave, mirror_width=self.scene.stator.mirror_width)
        except fem.BeamError as error:
            raise RunError(f"the beam of this scene: {error}") from None

    def solved(self, solve, frequency: float, **options):
        """Return the result of a solver of ``fem`` for the scene's stator at a frequency in Hz."""
        scene, model = self.scene, self.model
        try:
            with as_run_errors(f"at {frequency / 1e6:.6g} MHz"):
                return solve(
                    model.stator, model.section_transducers, frequency=float(frequency), tolerance=self.tolerance,
                    drive=model.drive, **options,
                )  # fmt: skip
        except fem.InputError as error:
            if error.key != "force.position":
                raise
            key = "stator" if scene.slider is None else "slider.position"
            raise scene.refuse(key, f"{error.rule}: the force acts there") from None

    def response(self, component: str, frequency: float):
        """Return the beam or the section's answer to the force at a frequency in Hz."""
        return self.spread(self.solved(fem.forced_wave, frequency, forces=(self.force(component),), places=self.beside))

    def motion_and_error(self, answer, x: np.ndarray):
        """Return u_z in m per newton along the line of the force, and its relative error."""
        if not self.spreads:
            return answer.motion(x)[1], np.full(len(x), answer.relative_error)
        motion, error = answer.motion_and_error(x, self.position[1])
        return motion[2], error * abs(motion[[0, 2]]).max(axis=0) / abs(motion[2])


def _over_the_band(problem: _ForceProblem, at: np.ndarray) -> list[Panel]:
    """Return currents and voltages of all transducers per newton at frequencies in Hz; open ones have no current."""
    sizes: dict[str, dict] = {"A": dict(frequency_Hz=at), "V": dict(frequency_Hz=at)}
    prepared = None if problem.spreads else _band(problem, at)
    for component, name in FORCES.items():
        if prepared is None:
            circuits = []
            for frequency in at:
                LOGGER.info(f"stator: force along {component} at {frequency / 1e6:.5g} MHz")
                circuits.append(problem.response(component, frequency).circuit)
        else:
            circuits = prepared.forced(at, problem.force(component), problem.model.drive)
        for number, port in enumerate(circuits[0].names):
            for unit, field in (("A", "currents"), ("V", "voltages")):
                values = np.array([getattr(each, field)[number] for each in circuits])
                if abs(values).max() > ROUNDING:
                    sizes[unit][f"{port}_{name}_{unit}_per_N"] = values
    titles = {"A": ("currents", "current per newton"), "V": ("voltages", "voltage per newton")}
    where = f"at {problem.position[0] * 1e3:g} mm"
    return [
        Panel(name=name, title=f"{problem.scene.title}: {what} {where}", data=sizes[unit])
        for unit, (name, what) in titles.items()
        if len(sizes[unit]) > 1
    ]


def _band(problem: _ForceProblem, at: np.ndarray):
    """Return the `fem.Band` of the plane section."""
    model = problem.model
    return fem.frequency_band(
        model.stator, model.section_transducers, lowest=float(at.min()), highest=float(at.max()), drive=model.drive,
        tolerance=problem.tolerance, places=(problem.position[0],),
    )  # fmt: skip


def _reciprocity(problem: _ForceProblem, answers: dict) -> tuple:
    """Return the finding on reciprocity: current per newton and velocity per volt, or currents by two methods."""
    if problem.spreads:
        worst, quantity, high = max(each.scattering_error for each in answers.values()), BY_CHARGES, 0.3
    else:
        drive, scene = problem.model.drive, problem.scene
        if len(drive.sources) > 1 or drive.match:
            return ()
        LOGGER.info("stator: the response to a volt")
        driven = problem.solved(fem.driven_wave, scene.frequency, places=(problem.position[0],))
        (name, volts), worst = next(iter(drive.sources.items())), 0.0
        own = next(each.aperture for each in problem.model.section_transducers if each.name == name)
        for component, answer in answers.items():
            moved = driven.motion(problem.position[0])["xz".index(component)] * own / problem.width
            current = answer.circuit.currents[answer.circuit.names.index(name)]
            worst = max(worst, abs(current / (2j * np.pi * scene.frequency * moved / volts) - 1))
        quantity, high = BY_VOLT, 3 * problem.tolerance
    return (judged("A transducer receives from a force what it sends to it.", quantity, worst, high=high),)


@of_record
def figure(record: Panel, ax):
    """Draw u_z along the stator, or the currents over frequency."""
    if "x_m" in record.data:
        x, along = record.data.x_m, quantity.x_m
        gap = int(np.argmax(np.diff(x))) + 1  # one wavelength either side of the force
        for (component, name), colour in zip(FORCES.items(), PALETTE, strict=False):
            motion = abs(record.data[f"{name}_m_per_N"]) * quantity.normal_m_per_N.scale
            for part, label in ((slice(0, gap), f"force along {component}"), (slice(gap, None), None)):
                curve(ax, x[part] * along.scale, motion[part], "-", colour, label)
        return lines(ax, record, quantity.x_m, (), quantity.normal_m_per_N)
    (unit,) = {key.split("_")[-3] for key in record.data if key.endswith("_per_N")}
    keys = [key for key in record.data if key.endswith("_per_N")]
    rows = [
        (key, "o-" if "_normal_" in key else "s--", PALETTE[number % len(PALETTE)],
         key.removesuffix(f"_{unit}_per_N").replace("_", ", "))
        for number, key in enumerate(keys)
    ]  # fmt: skip
    return lines(
        ax, record, quantity.frequency_Hz, rows, quantity.current_A_per_N if unit == "A" else quantity.voltage_V_per_N
    )
