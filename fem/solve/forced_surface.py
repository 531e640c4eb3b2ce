"""Line forces on a stator's bare surface: the motion that they make along the whole stator, with its error.

A force per metre along y acts on the surface at one position, tangential or normal to it.  It stands for a slider's
contact or, by reciprocity, for a vibrometer: the current into a shorted transducer per newton at a position equals the
velocity there per volt.  The response includes transducers, pieces and ends.  Each transducer's voltage is the one that
its received current produces across its termination.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from fem.circuit import Drive
from fem.discretize.element_sizes import Resolution
from fem.discretize.mesh_refinement import GAIN_NEAR_FORCE, NEAR_FORCE, refine_stator
from fem.exceptions import refuse_above
from fem.geometry import Stator, Transducer, on_stator
from fem.layout import check_layout
from fem.parameters import InputError, positive, refuses
from fem.results.driven_answer import SurfaceWave, surface_wave
from fem.results.field_evaluation import surface_of
from fem.results.stator_solution import Solution, driven_solution
from fem.solve.driven_stator import motion_difference
from fem.threads import one_blas_thread
from fem.waveguide.line_force import LineForce
from fem.waveguide.port_fields import stator_cascade


@one_blas_thread
def forced_wave(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    forces: tuple[LineForce, ...],
    *,
    frequency: float,
    tolerance: float,
    drive: str | Drive | None = None,
    places: tuple[float, ...],
) -> SurfaceWave:
    """Surface motion of a stator under line forces, in m; powers in W over the widest aperture, or per metre of y.

    Parameters
    ----------
    stator : Stator
    transducers : tuple of Transducer
        Each with its termination; may be empty.
    forces : tuple of LineForce
        They act together, each with its amplitude.
    frequency : float
        Hz.
    tolerance : float
        Relative, of the surface motion at ``places``; under strips, whose beam is asked for elsewhere too, also a
        wavelength beside them.
    drive : str or Drive, optional
        Its source voltages are set to zero; its impedances terminate their transducers.
    places : tuple of float
        m from the left end, away from the forces: under a line force the motion is infinite.

    Raises
    ------
    InputError
        For a force that does not stand on the bare surface, or if all amplitudes are zero.
    ConvergenceError
        If the finest discretisation does not reach the tolerance; its ``reached`` is the best answer.

    Examples
    --------
    The surface wave far from a normal force is that of the half-space, |u_z| = Gamma F:

    >>> from fem import LineForce, Stator, forced_wave, isotropic, wave_compliance
    >>> glass = isotropic(name="glass", density=2500.0, youngs_modulus=70e9, poisson_ratio=0.25)
    >>> block = Stator(solid=glass, length=60e-3, thickness=float("inf"), ends="absorbing")
    >>> push = LineForce(name="tip", position=5e-3, component="z")
    >>> wave = forced_wave(block, (), (push,), frequency=2e6, tolerance=1e-3, places=(50e-3,))
    >>> ratio = abs(wave.motion(50e-3)[1]) / wave_compliance(glass, "open")
    >>> bool(abs(ratio - 1) < 0.01)
    True
    """
    check_layout(stator, transducers)
    for name, value, unit in (("tolerance", tolerance, ""), ("frequency", frequency, "Hz")):
        positive(name, value, unit)
    _refuse_forces(stator, forces)
    at = np.array(places)
    nearest = _nearest(forces, at)
    at = np.append(at, _beside_strips(stator, forces, frequency))
    amplitudes = np.array([each.amplitude for each in forces])

    def at_level(resolution: Resolution) -> tuple[Solution, np.ndarray]:
        cascade = stator_cascade(
            stator, transducers, frequency=frequency, resolution=resolution, forces=forces, nearest=nearest
        )
        solution = driven_solution(cascade.solved(), drive, amplitudes)
        return solution, surface_of(solution).motion(at)

    beside = nearest < NEAR_FORCE * stator.slowest_wavelength(frequency)
    refined = refine_stator(
        stator,
        at_level,
        differences=lambda fine, coarse: (motion_difference(fine[1], coarse[1]),),
        tolerance=tolerance,
        least_gain=GAIN_NEAR_FORCE if beside else np.inf,
    )
    wave = surface_wave(refined.answer[0], relative_error=refined.errors[0], admittance_error=np.nan)
    advice = "ask for less, or at positions farther from the forces"
    refuse_above(wave.relative_error, tolerance, "the surface motion is", advice=advice, reached=wave)
    return wave


def _nearest(forces: tuple[LineForce, ...], places: np.ndarray) -> float:
    """Smallest distance in m of the places from a force; an InputError if a place is that of a force."""
    distances = [float(abs(places - each.position).min()) for each in forces]
    for each, distance in zip(forces, distances, strict=True):
        if not distance:
            rule = "must lie beside the forces: under a line force the motion is infinite"
            raise InputError("places", rule, each.position, "m")
    return min(distances)


def _beside_strips(stator: Stator, forces: tuple[LineForce, ...], frequency: float) -> np.ndarray:
    """Places on the stator a wavelength beside the forces of finite width, m, away from the other forces."""
    away = NEAR_FORCE * stator.slowest_wavelength(frequency)
    beside = np.array([each.position + side * away for each in forces if np.isfinite(each.width) for side in (-1, 1)])
    beside = beside[(beside >= 0) & (beside <= stator.length)]
    distances = abs(np.subtract.outer(beside, [each.position for each in forces])).min(axis=1, initial=np.inf)
    return beside[distances > away / 2]


@refuses(InputError)
def _refuse_forces(stator: Stator, forces: tuple[LineForce, ...]) -> Iterator[Any]:
    """Raise an InputError if there is no force, all amplitudes are zero, or one force stands beside the stator."""
    if not forces:
        yield "force", "is missing: at least one must act"
    for each in forces:
        if rule := on_stator(each.position, stator.length):
            yield "force.position", rule, each.position, "m", each.name
    if not any(each.amplitude for each in forces):
        yield "force.amplitude", "must differ from zero for one force at least", 0.0, "N/m"
