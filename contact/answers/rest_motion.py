"""The slider at rest before a burst, and its motion when the wave has stopped."""

from contact.averaged.event_equilibrium import opposed
from contact.body import Paths
from contact.codes import At
from contact.events.collocation import collocation
from contact.events.motion import Motion, rest_state
from contact.problem import scaled, without_wave


def rest_problem(slider, orbits):
    """Return the scaled problem; at phase 0 u_z of the first contact crosses zero upwards."""
    return scaled(slider, orbits, direction=opposed(slider, orbits), start=orbits[0].upward_zero)


def rest(slider, orbits, problem, *, nodes, truncation, factor=1.0):
    """Return the motion at phase 0 of a slider at rest whose contacts are deformed by the load alone.

    `factor` is the envelope's value at phase 0. The wave of that size decides which contacts touch at the start: a
    contact that touches keeps its deformation. A contact with memory is deformed on the surface at rest, before the
    wave displaces the surface.
    """
    begun = problem if factor == 1.0 else problem._replace(paths=times(problem.paths, factor))
    state, motion = rest_state(slider, problem), Motion(begun, grid=collocation(nodes), truncation=truncation)
    if motion.memory is not None:
        motion.problem = without_wave(problem)
        motion.set_state(*state[: At.DEFORMATIONS], state[At.DEFORMATIONS :])
    motion.set_state(*state[: At.DEFORMATIONS], state[At.DEFORMATIONS :], problem=begun)
    motion.problem = problem
    return motion


def times(paths, factor):
    """Return the paths of a wave times a complex factor."""
    normal = factor * (paths.normal_cos - 1j * paths.normal_sin)
    tangential = factor * (paths.tangential_cos - 1j * paths.tangential_sin)
    return Paths(paths.height, normal.real.copy(), -normal.imag, tangential.real.copy(), -tangential.imag)


def silence(motion):
    """Return a copy of the motion that continues from the state at phase 0 without the wave."""
    still = motion.copy()
    still.set_state(*motion.state[:3], motion.state[3:], problem=without_wave(motion.problem))
    still.begin()
    return still
