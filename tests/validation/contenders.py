"""Ways to solve the driven stator: high order, structure, a band of frequencies, the peer NGSolve.

Each is made ready for a problem and a resolution and then solves one frequency at a time; `attempt` measures it.
"""

from dataclasses import dataclass

import numpy as np

__all__ = ["CURVES", "Problem", "missing"]

BAND = (0.955, 1.045)  # of the frequency: what `frequency_band` is prepared for


@dataclass(frozen=True, kw_only=True)
class Problem:
    """A driven stator and the two outputs asked for.

    Attributes
    ----------
    stator : fem.Stator
    transducers : tuple of fem.Transducer
        From left to right; the first is driven, the others are open.
    frequency : float
        Hz.
    wavelength : float
        m; the period of the transducers.
    place : float
        Where the motion of the surface is asked for, m.
    """

    stator: object
    transducers: tuple
    frequency: float
    wavelength: float
    place: float


def _direct(problem: Problem, *, order: int, edge_layers: int):
    from fem import Resolution, slowest_wavelength, solve_circuit
    from tests.fem.direct import direct_solution

    def once():
        solution = direct_solution(
            problem.stator,
            problem.transducers,
            frequency=problem.frequency,
            resolution=Resolution(order=order, edge_layers=edge_layers),
            wavelength=slowest_wavelength(problem.stator.solid, problem.frequency),
            segment_size=1.0,
        )
        driven = problem.transducers[0].name
        wired = solve_circuit(solution.admittances, solution.names, problem.transducers, driven, problem.frequency)
        motion = solution.surface(np.array([problem.place]))[:, 0] @ wired.voltages
        return wired.admittance, motion, solution.unknowns

    return once


def _structured(problem: Problem, *, level: int):
    from fem import LEVELS, one_blas_thread, solve_driven, surface_of

    @one_blas_thread
    def once():
        solution = solve_driven(
            problem.stator,
            problem.transducers,
            frequency=problem.frequency,
            drive=problem.transducers[0].name,
            resolution=LEVELS[level],
        )
        motion = surface_of(solution).motion(problem.place)
        return solution.circuit.admittance, motion, solution.fields.unknowns

    return once


def _band(problem: Problem, *, tolerance: float):
    from fem import frequency_band, one_blas_thread

    driven = problem.transducers[0].name
    band = frequency_band(
        problem.stator,
        problem.transducers,
        lowest=BAND[0] * problem.frequency,
        highest=BAND[1] * problem.frequency,
        drive=driven,
        tolerance=tolerance,
        places=(problem.place,),
    )

    @one_blas_thread
    def once():
        wave = band.wave(problem.frequency, driven)
        return wave.admittance, wave.motion(problem.place), wave.unknowns

    return once


def _peer(problem: Problem, **mesh):
    from tests.validation.ngsolve_stator import Peer, PeerMesh

    peer = Peer(problem.stator, problem.transducers, wavelength=problem.wavelength, mesh=PeerMesh(**mesh))

    def once():
        driven = problem.transducers[0].name
        answer = peer.solve(problem.frequency, driven=driven, place=problem.place)
        return *answer, peer.unknowns

    return once


def _hp(order, edge_layers, element_size, **rest) -> dict:
    return {"order": order, "edge_layers": edge_layers, "element_size": element_size, **rest}


_FINE = {"absorber": 8.0, "stretch": 1 - 1j}
# curve: what makes it ready, settings from coarse to fine, packages beyond the program's own
CURVES = {
    "high order, no edge layers": (_direct, tuple({"order": p, "edge_layers": 0} for p in (4, 5, 6)), ("pypardiso",)),
    "high order, edge layers": (
        _direct,
        tuple({"order": p, "edge_layers": layers} for p, layers in ((4, 1), (5, 1), (6, 1))),
        ("pypardiso",),
    ),
    "NGSolve": (
        _peer,
        (_hp(6, 2, 0.7), _hp(8, 2, 1.0), _hp(8, 3, 0.8, **_FINE), _hp(9, 4, 0.8, **_FINE)),
        ("ngsolve",),
    ),
    "structured": (_structured, tuple({"level": level} for level in range(6)), ()),
    "band": (_band, tuple({"tolerance": tolerance} for tolerance in (1e-2, 1e-3, 1e-4, 1e-5)), ()),
}


def missing(curve: str) -> tuple[str, ...]:
    """Return the packages that a curve needs and that are not installed."""
    from importlib.util import find_spec

    return tuple(package for package in CURVES[curve][2] if find_spec(package) is None)
