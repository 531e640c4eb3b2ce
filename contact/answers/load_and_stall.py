r"""Load line of a motor: steady velocity against a constant load, blocked thrust and mechanical efficiency.

The blocked thrust is the smallest load at which the motor stalls. First-order averaging gives it as the mean tangential
force at v = 0, with an error of O((f_n/f)^2). `stall` instead searches the load at which the steady velocity of the
full motion falls to zero. If a contact sticks at rest, the load line ends with a jump to zero, and the slider is held
over an interval of loads. The efficiency is the work against the load over the work of the wave per cycle, from the
ledger.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from contact import parameter_check
from contact.answers.steady import SteadyState, steady
from contact.averaged.adhesive_motion import holding_balls
from contact.averaged.burst import STIFFEST_STEADY, refuse_unless_applicable
from contact.averaged.coupled_motion import CoupledSearch, unloaded
from contact.averaged.equilibrium import mean_tangential_forces, rest_forces
from contact.averaged.event_equilibrium import event_rest_forces, event_tangential_forces
from contact.averaged.steady_sweep import mean_motion
from contact.choice import Answer
from contact.error_estimate import averaged_stall_error, search_error
from contact.exceptions import ConvergenceError
from contact.orbit import towards_plus
from contact.passing_wave import Surface, coupling, frequency, prescribed, resonance_ratio
from contact.problem import scaled
from contact.slider import Slider

# Largest relative tolerance of the search for the load at which the full motion stops. In eight motors it took 3 to 6
# steady states, with 1e-3 2 to 4 and with 1e-9 5 to 10: a larger value would hardly save time.
STALL_TOLERANCE = 1e-5
# The next load of the search lies at this fraction of the distance from the largest load that moves to the
# extrapolated stall: the extrapolation needs a positive velocity. In 16 searches
# the total of steady states was 145 with 0.5, 90 with 0.9, 77 with 0.99 and 295 with 1.
APPROACH = 0.9


@dataclass(frozen=True, kw_only=True)
class LoadLine:
    """Velocity, power and efficiency against load.

    Attributes
    ----------
    load : (k,) array
        Loads in N, against the direction of the unloaded motion.
    velocity : (k,) array
        Velocities in m/s, positive in the direction of the unloaded motion.
    power : (k,) array
        Mechanical power (load times velocity), W.
    efficiency : (k,) array
        Mechanical power over the power of the wave; 0 if the slider is held.
    relative_error : (k,) array
        Errors of the velocities over max(|v|, omega |u_x|/10). The last entry is the relative error of the stall load.
    stall : Answer
        Load at which the motor stalls, N, and its error.
    held_up_to : float
        Largest load under which the slider stays at rest, N, by averaging. A larger load drags it backwards.
    states : tuple of SteadyState
        The states at the loads but the last.
    status, message : str
        Status "ok", or the status of a point that misses the tolerance, and its reasons.
    """

    load: np.ndarray
    velocity: np.ndarray
    power: np.ndarray
    efficiency: np.ndarray
    relative_error: np.ndarray
    stall: Answer
    held_up_to: float
    states: tuple[SteadyState, ...]
    status: str
    message: str

    @property
    def blocked_thrust(self) -> float:
        """Load at which the motor stalls, N."""
        return self.stall.value


def blocked_thrust(slider: Slider, orbits: Surface) -> tuple[float, float]:
    """Return (smallest load, largest load) in N under which the slider is held, by first-order averaging.

    They are the extreme mean tangential forces of a cycle at rest. The smallest one is the blocked thrust.

    Parameters
    ----------
    slider, orbits
        As for `steady`; the slider's own load is not used.

    Raises
    ------
    ConvergenceError
        Status "not applicable" where averaging does not apply.
    """
    if coupling(slider, orbits):
        search, _, direction = unloaded(slider, orbits)
        return search.stall(direction)
    if slider.profile.hold is not None:
        free, listed = prescribed(replace(slider, load=0.0), orbits)
        low, high = holding_balls(free).held_loads(tuple(listed))
        return (low, high) if high > -low else (-high, -low)
    _, problem, unit = _unloaded(slider, orbits)
    low, high = event_rest_forces(problem) if slider.law == "hysteretic" else rest_forces(problem)
    # a slider that is driven against the crests moves towards -x, so that both forces change sign
    return (float(low * unit), float(high * unit)) if high > -low else (float(-high * unit), float(-low * unit))


def mean_traction(slider: Slider, orbits: Surface, velocities: np.ndarray) -> np.ndarray:
    """Return the mean tangential force of the surface on a slider at constant velocities, N along +x (averaged).

    Parameters
    ----------
    slider, orbits
        As for `steady`; the slider's tangential damping is not used, and of its load only the tilt that it causes.
    velocities : ndarray, shape (k,)
        Velocities along +x, m/s.

    Returns
    -------
    ndarray, shape (k,)

    Raises
    ------
    ConvergenceError
        Status "not applicable" where averaging does not apply.
    """
    if coupling(slider, orbits):
        search = CoupledSearch(slider, orbits)
        return np.array([search.traction(v, math.copysign(slider.load, v)) for v in np.asarray(velocities, float)])
    if slider.profile.hold is not None:
        free, listed = prescribed(replace(slider, load=0.0), orbits)
        balls = holding_balls(free)
        return np.array([balls.traction(tuple(listed), float(v)) for v in np.asarray(velocities, float)])
    side, problem, unit = _unloaded(slider, orbits)
    speeds = side * np.asarray(velocities, float) / problem.speed
    means = event_tangential_forces if slider.law == "hysteretic" else mean_tangential_forces
    return side * means(problem, speeds) * unit


def _unloaded(slider: Slider, orbits: Surface):
    """Return (drive direction, problem without load whose crests drive towards +x, its unit of force in N)."""
    slider, listed = prescribed(slider, orbits)
    free = slider if slider.load == 0.0 else replace(slider, load=0.0)
    refuse_unless_applicable(free, listed, STIFFEST_STEADY, memory=slider.law == "hysteretic")
    side, driven = towards_plus(listed)
    problem = scaled(free, driven, direction=1.0, start=0.0)
    return side, problem, slider.unit_mass * problem.omega**2 * problem.length


def stall(slider: Slider, orbits: Surface, *, tolerance: float) -> Answer:
    """Return the load in N at which the motor stalls: where the steady velocity of the full motion falls to zero.

    Parameters
    ----------
    slider, orbits
        As for `steady`; the slider's own load is not used.
    tolerance : float
        Allowed relative error of the load.

    Returns
    -------
    Answer
        The averaged load if its estimated error is within the tolerance or if the full motion cannot be computed.

    Raises
    ------
    ConvergenceError
        Status "not applicable" if averaging, which gives the initial guess, does not apply; "held" if the wave does not
        move the unloaded slider.
    """
    return _stalled(slider, orbits, tolerance)[0]


def _stalled(slider, orbits, tolerance):
    """Return the `stall` and the largest load in N under which the slider stays at rest."""
    guess, held_up_to = blocked_thrust(slider, orbits)
    if guess <= 0.0:
        raise ConvergenceError(
            "held", "the wave does not move the unloaded slider; raise the amplitude above the threshold"
        )
    error = guess * averaged_stall_error(resonance_ratio(slider, orbits))
    averaged_answer = Answer(value=guess, error=error, reasons=("mean traction at rest",))
    if coupling(slider, orbits) or averaged_answer.error <= tolerance * guess:
        return averaged_answer.judged(tolerance, guess), held_up_to
    try:
        answer = full_stall(*prescribed(slider, orbits), averaged_answer, min(STALL_TOLERANCE, 0.5 * tolerance))
    except ConvergenceError as failed:
        reason = f"the full motion near the stall was not found: {failed}"
        answer = replace(averaged_answer, reasons=(*averaged_answer.reasons, reason))
    return answer.judged(tolerance, guess), held_up_to


def full_stall(slider, orbits, near, tolerance):
    """Return the load in N at which the full motion stalls, bracketed and extrapolated from smaller loads.

    ``near`` is the stall of the averaged motion, from which the search starts. The relative error of the answer is at
    most twice `tolerance`, half of it for the steady states and half for the search.

    A secant extrapolates to zero velocity, through the last load against which the slider advances and the load tried
    last (it interpolates if that drags the slider back at a finite speed). The next load lies a little below that
    estimate (`APPROACH`), because a load above the stall gives no slope. Where the secant fails - the slider is held or
    is dragged back without limit, or the velocity does not fall - the bracket is bisected.

    `low` has been seen to move. `high` is first the averaged load plus twice its error, or the static
    friction, above which the contacts cannot hold the slider; where the secant points beyond it, it is verified, and
    raised if the slider still moves there. Later it is a load that has been seen to stall.
    """
    free = replace(slider, load=0.0)
    answer = mean_motion(free, orbits) if slider.law == "elastic" else steady(free, orbits, tolerance=tolerance)
    direction = np.sign(answer.velocity)
    limit = slider.static_friction(len(orbits)) * (1.0 - 1e-12)  # at the friction itself nothing holds the slider

    def velocity(load):
        try:
            state = steady(replace(slider, load=load), orbits, tolerance=tolerance)
        except ConvergenceError as failed:
            if failed.status == "runaway":
                return -math.inf  # dragged back without limit: certainly beyond the stall
            raise
        if state.relative_error > tolerance and state.velocity != 0.0:
            raise ConvergenceError("above tolerance", state.message)
        return direction * state.velocity

    reach = max(2.0 * near.error / near.value, 1e-3)
    high, low = min(near.value * (1.0 + reach), limit), near.value * (1.0 - reach)
    previous = low, velocity(low)  # (load, velocity)
    if previous[1] <= 0.0:
        raise ConvergenceError("held", "the full motion stalls far below the averaged load")
    estimate, error = near.value, near.error
    for _ in range(16):
        load = low + APPROACH * (estimate - low)
        latest = load, velocity(load)
        if latest[1] <= 0.0:
            high = load
        else:
            low = load
        if math.isinf(latest[1]) or latest[1] == 0.0 or latest[1] >= previous[1]:
            estimate, error = 0.5 * (low + high), 0.5 * (high - low)
        else:
            secant = latest[0] + latest[1] * (latest[0] - previous[0]) / (previous[1] - latest[1])
            if secant >= high and high < limit and velocity(high) > 0.0:  # the stall lies beyond the bracket
                low, high = high, min(high + 2.0 * (high - near.value), limit)
            if low < secant < high:
                estimate, error = secant, abs(secant - estimate)
            else:
                estimate, error = 0.5 * (low + high), 0.5 * (high - low)
            previous = latest if latest[1] > 0.0 else previous
        if search_error(error, low, high) < tolerance * estimate:
            break
    error = search_error(error, low, high) + tolerance * estimate
    return Answer(value=estimate, error=error, reasons=("load at which the full motion stops",))


def load_line(slider: Slider, orbits: Surface, *, points: int, tolerance: float) -> LoadLine:
    """Return the load line from zero load to the blocked thrust.

    Parameters
    ----------
    slider, orbits
        As for `steady`; the slider's own load is not used.
    points : int
        Number of evenly spaced loads, at least 2.
    tolerance : float
        As for `steady`.
    """
    parameter_check.count("points", points, 2)
    stalled, held_up_to = _stalled(slider, orbits, tolerance)
    loads = stalled.value * np.linspace(0.0, 1.0, points)
    states: list[SteadyState] = []
    for load in loads[:-1].tolist():
        near = states[-1] if states else None
        states.append(steady(replace(slider, load=load), orbits, tolerance=tolerance, near=near))
    velocity, wave_power = np.zeros(points), np.zeros(points)
    errors = np.full(points, stalled.error / stalled.value)
    velocity[:-1] = [math.copysign(1.0, states[0].velocity) * state.velocity for state in states]
    errors[:-1] = [state.relative_error for state in states]
    wave_power[:-1] = [state.ledger.wave * frequency(orbits) for state in states]
    power = loads * velocity
    efficiency = np.divide(power, wave_power, out=np.zeros(points), where=wave_power > 0.0)
    reported = next((each for each in (stalled, *states) if each.status != "ok"), states[-1])
    return LoadLine(
        load=loads, velocity=velocity, power=power, efficiency=efficiency, relative_error=errors, stall=stalled,
        held_up_to=held_up_to, states=tuple(states), status=reported.status, message=reported.message,
    )  # fmt: skip
