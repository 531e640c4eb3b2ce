"""Steady motion of a slider in the plane on continuous waves, and the mean forces at a given motion."""

import math
import time
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from contact import parameter_check
from contact.averaged.sweep_kernel import MAX_RATIO_HELD
from contact.choice import Answer
from contact.error_estimate import OF_BEAT, OF_VELOCITY, larger_wave, speed_scale
from contact.exceptions import ConvergenceError, InputError
from contact.plane.averaged import ANSWER, CHECK, Averaged, Means, Root, balanced, dragged, least_at_rest
from contact.plane.cycle import Extra
from contact.plane.disc_contacts import Count, Sum
from contact.plane.from_rest import SAME, mean_from_rest, speed_of
from contact.plane.long_run import long_run
from contact.plane.plane_shooting import CHECK as CHECK_SHOOTING
from contact.plane.plane_shooting import lost_in_dampers, periodic, sums_of
from contact.plane.plane_waves import Surface, SurfaceWaves, surface_under
from contact.plane.rest import Forces
from contact.plane.scaling import FREE, averaging_error, beats_slowly, refuse_slow_beat, resonance_ratios, slowest_beat
from contact.plane.state import Band, PlaneState, Powers
from contact.slider import Slider

METHODS = ("auto", "averaged", "exact")
# Slip power of a held slider's contact, over friction times the fastest slip, up to which it only touches its limit:
# rounding makes 1e-16 of it, a contact that slips while another holds the slider a twentieth
# (tests/contact/test_plane_averaged.py)
AT_LIMIT = 1e-9
COMMENSURABLE = 1e-9  # relative change of a frequency for a common period that counts as rounding


def steady(
    slider: Slider, surface: Surface, *, tolerance: float, method: str = "auto", near: PlaneState | None = None
) -> PlaneState:  # fmt: skip
    """Return the steady motion of a slider on continuous waves.

    Parameters
    ----------
    slider : Slider
        With `freedom` "xy", "xy yaw" or "axle"; with "x" the motion across the wave and the yaw are held.
    surface : SurfaceWaves or Field
        Motion of the surface under each contact; of a field that where the slider starts.
    tolerance : float
        Allowed error of the speed, relative to max(|V|, omega |u_t|/10).
    method : str
        "averaged" (first order in (f_n/f)^2), "exact" (the full motion that repeats, by shooting) or "auto".
    near : PlaneState, optional
        A state from which the search begins: that of a slider or of waves that differ little takes half the time.

    Raises
    ------
    InputError
        If the parameters contradict each other.
    ConvergenceError
        With status "runaway", "not applicable" or "not converged".

    Examples
    --------
    >>> slider = Slider(
    ...     radius=1e-3, mass=math.inf, preload=0.87309e-3, load=(0.0, 0.0), friction_coefficient=0.08,
    ...     effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0,
    ...     contact_damping=0.0, normal_damping=0.0, tangential_damping=0.0, freedom="xy",
    ... )
    >>> both = [[-6.7e-9j, 6.7e-9, 10e-9 + 10e-9j]]  # a wave along x and one along y, a quarter of a period ahead
    >>> state = steady(slider, SurfaceWaves(frequencies=[2.2e6], amplitudes=[both]), tolerance=1e-7)
    >>> print(state.velocity.round(6), state.status)
    [0.020225 0.081674] ok
    """
    begun = time.perf_counter()
    parameter_check.positive("tolerance", tolerance, "")
    parameter_check.choice("method", method, METHODS)
    waves = surface_under(slider, surface)
    refuse(slider)
    if method != "exact":
        refuse_slow_beat(slider, waves)
    elif slider.mass == math.inf:
        raise ConvergenceError("not applicable", "a slider of infinite mass has the averaged motion: method averaged")
    if method == "exact" and beats_slowly(slider, waves):
        try:
            return _exact_on_slow_beat(slider, waves, tolerance, begun)
        except ConvergenceError as error:
            if error.status == "runaway" or not _hops(slider, waves):
                refuse_slow_beat(slider, waves, str(error))
        return _of_long_run(slider, waves, tolerance, begun)
    if method == "averaged" or slider.mass == math.inf:
        return _averaged(slider, waves, near, tolerance, tolerance, begun)[0]
    try:
        state, averaged, root = _averaged(
            slider, waves, near, tolerance, min(tolerance, 1e-6) if method == "exact" else tolerance, begun
        )
        # a slider that is held does not move
        if (method == "auto" and state.status == "ok") or (root.held and not _hops(slider, waves)):
            return state
        if not root.held:
            return _exact(averaged, waves, root, state, tolerance, begun)
    except ConvergenceError as error:
        if error.status == "runaway" or not (error.status == "unstable" or _hops(slider, waves)):
            raise
    return _of_long_run(slider, waves, tolerance, begun)


def _averaged(slider, waves, near, tolerance, found_to, begun):
    """Return the averaged state, and what it is made of; its balance is found to another tolerance."""
    averaged = Averaged.of(slider, waves)
    guess = None if near is None or near.held else _unknown(averaged, near)
    root = balanced(averaged, guess, tolerance=found_to)
    return _state(averaged, waves, root, tolerance, begun), averaged, root


def _hops(slider, waves):
    """Return True if the slider's height and velocity change within a cycle, so that averaging cannot stand in."""
    strongly_damped = slider.contact_damping * slider.preload > 1e-2 * slider.unit_mass * waves.omega
    return resonance_ratios(slider, waves)[0] > MAX_RATIO_HELD or strongly_damped


def _unknown(averaged: Averaged, state: PlaneState) -> np.ndarray:
    """Return the unknown of a state: the inverse of `rigid_motion`."""
    units, slider = averaged.scaled, averaged.slider
    velocity = np.zeros(2) if slider.freedom == "axle" else np.asarray(state.velocity) / units.speed
    return averaged.basis @ averaged.basis.T @ [*velocity, state.yaw_rate * averaged.arm / units.omega]


def _exact_on_slow_beat(slider, waves, tolerance, begun) -> PlaneState:
    """Return the state of the full motion that repeats with the beat, from the averaged one."""
    averaged = Averaged.of(slider, waves)
    if averaged.scaled.period_change > COMMENSURABLE:
        raise ConvergenceError("not applicable", "the frequencies have no common period of at most 400 cycles")
    root = balanced(averaged, tolerance=min(tolerance, 1e-6))
    state = _state(averaged, waves, root, tolerance, begun)
    if root.held and _hops(slider, waves):
        return _of_long_run(slider, waves, tolerance, begun)
    return state if root.held else _exact(averaged, waves, root, state, tolerance, begun)


def _exact(averaged, waves, root, mean: PlaneState, tolerance, begun) -> PlaneState:
    """Return the state of the full motion that repeats, by two computations that differ in order and tolerance."""
    units = averaged.scaled
    fine, at = periodic(averaged, root, waves)
    rough, _ = periodic(averaged, root, waves, how=CHECK_SHOOTING, near=at)
    scale = np.array([1.0, 1.0, averaged.arm])
    unknown, change = fine.velocity * scale, np.abs(fine.velocity - rough.velocity) * scale + fine.change
    velocity, yaw_rate = rigid_motion(averaged, unknown)
    reference = speed_scale(_speed(averaged, velocity, yaw_rate), waves.peak_speed)
    missed, note = _missed_from_rest(averaged, waves, np.append(velocity, yaw_rate), reference)
    if missed.any():
        with suppress(ConvergenceError):
            other = (
                f"a motion that repeats has ({velocity[0]:.4g}, {velocity[1]:.4g}) m/s, but is not reached from rest"
            )
            return _of_long_run(averaged.slider, waves, tolerance, begun, other)
    return _in_time(
        averaged, waves, unknown, change * units.speed + missed,
        (sums_of(fine), fine.motion.state.counts, lost_in_dampers(fine)),
        ("the full motion in the plane that repeats, by shooting", *note), tolerance, begun,
        mean.statistics | {"multiplier": float(np.abs(fine.multipliers[0]))},
    )  # fmt: skip


def _of_long_run(slider, waves, tolerance, begun, why="no stable motion repeats with the waves") -> PlaneState:
    """Return the mean of a long run from rest, of a light slider; ``why`` it is taken."""
    averaged = Averaged.of(slider, waves)
    units, arm = averaged.scaled, averaged.arm * averaged.scaled.length
    period = (units.period if units.period_change <= COMMENSURABLE else 2.0 * math.pi) / units.omega
    run = long_run(slider, waves, period, speed_scale(0.0, waves.peak_speed), arm)
    note = f"every contact sticks after {run.passed} cycles from rest"
    if not run.sticks:
        note = f"mean of {run.cycles} cycles after {run.passed} from rest, for {why}"
    return _in_time(
        averaged, waves, run.rates / [units.speed, units.speed, units.omega / averaged.arm],
        run.error * [1.0, 1.0, arm], (run.sums, run.counts, run.lost + float(run.sums[:, Sum.DAMPER].sum())),
        (note,), tolerance, begun, {"averaged_cycles": run.cycles, "beat": slowest_beat(waves.frequencies)},
        held=run.sticks,
    )  # fmt: skip


def _in_time(
    averaged, waves, unknown, error, means, reasons, tolerance, begun, statistics, held=False
) -> PlaneState:  # fmt: skip
    """Return the state of a motion that was followed in time.

    ``error``: of both components and of the yaw rate times the arm, m/s; ``means``: of the contacts' forces and powers,
    their events, and the mean power that all dampers take, scaled.
    """
    units, (sums, counts, lost) = averaged.scaled, means
    velocity, yaw_rate = rigid_motion(averaged, unknown)
    speed = _speed(averaged, velocity, yaw_rate)
    reference = speed_scale(speed, waves.peak_speed)
    answer = Answer(value=speed, error=float(np.linalg.norm(error)), reasons=reasons)
    wave = float(sums[:, [Sum.WAVE_NORMAL, Sum.WAVE_TANGENTIAL]].sum())
    powers = Powers(
        wave=wave * units.power, slip=float(sums[:, Sum.SLIP].sum()) * units.power, dampers=lost * units.power,
        load=float(averaged.load @ unknown) * units.power, law=float(sums[:, Sum.LEAK].sum()) * units.power,
    )  # fmt: skip
    return PlaneState(
        answer=answer.judged(tolerance, reference), velocity=velocity, yaw_rate=yaw_rate, error=error[:2],
        yaw_error=float(error[2]) / (averaged.arm * units.length),
        force=sums[:, [Sum.ALONG_X, Sum.ALONG_Y]].sum(axis=0) * units.force,
        torque=float(sums[:, Sum.MOMENT].sum()) * units.force * units.length, powers=powers,
        regimes=tuple(_regime_in_time(*each) for each in zip(sums, counts, strict=True)),
        normal_loads=sums[:, Sum.NORMAL] * units.force,
        heights=(averaged.problem.height - averaged.height) * units.length, held=held, band=None, reference=reference,
        method="exact", statistics=statistics, seconds=time.perf_counter() - begun,
    )  # fmt: skip


def _speed(averaged, velocity, yaw_rate):
    """Return |V|, or of an axle the largest speed of a contact, m/s."""
    if averaged.slider.freedom == "axle":
        return abs(yaw_rate) * averaged.arm * averaged.scaled.length
    return float(np.hypot(*velocity))


def _regime_in_time(sums, counts):
    """Return the regime of a contact from its sums over a motion and its events."""
    if counts[Count.MADE] > 0 or counts[Count.OPENED] > 0:
        return "intermittent"
    if sums[Sum.CONTACT] == 0.0:
        return "open"
    return "slip" if counts[Count.SLIPS] > 0 or sums[Sum.STUCK] < sums[Sum.CONTACT] else "stick"


def _missed_from_rest(averaged, waves, rates, reference):
    """Return by how much a light slider from rest misses rates (v_x, v_y, yaw rate), (3,) m/s, and a note about it."""
    slider, units = averaged.slider, averaged.scaled
    ratio, _ = resonance_ratios(slider, waves)
    if ratio <= MAX_RATIO_HELD:
        return np.zeros(3), ()
    arm = averaged.arm * units.length
    # the centre of an axle has no velocity of its own
    rates = np.where(np.isin(range(3), FREE[slider.freedom]), rates, 0.0)
    try:
        seen, change, turn = mean_from_rest(slider, waves, rates, units.period / units.omega, reference, arm)
    except ConvergenceError:
        return np.zeros(3), ("whether a slider from rest comes to it was not found",)
    if speed_of(seen - rates, arm) <= (SAME + turn) * reference:
        return np.zeros(3), ()
    settles = "comes to" if change <= SAME * reference else "still changes at"
    yaw = f" and {seen[2]:.4g} rad/s" if slider.freedom in ("xy yaw", "axle") else ""
    missed = np.abs(seen - rates) * [1.0, 1.0, arm]
    return missed, (f"a slider from rest {settles} ({seen[0]:.4g}, {seen[1]:.4g}) m/s{yaw} in the mean",)


def mean_motion(slider: Slider, surface: Surface) -> PlaneState:
    """Return the averaged steady motion, with the tolerance 1e-8."""
    return steady(slider, surface, tolerance=1e-8, method="averaged")


def refuse(slider: Slider) -> None:
    """Raise an InputError for a law that has no two directions, and where there is no friction or no preload."""
    if slider.law != "elastic":
        raise InputError("slider.law", 'must change: the hysteretic law has one direction: choose "elastic"')
    slider.refuse_other_laws(" in the plane")
    for name, unit in (("preload", "N"), ("friction_coefficient", "")):
        parameter_check.positive(f"slider.{name}", getattr(slider, name), unit)
    if slider.adhesion is not None:
        raise InputError(
            "slider.adhesion", "must be left out in the plane: a contact without attraction is known there"
        )
    if slider.backing != "rigid":
        raise InputError("slider.backing", 'must be "rigid" in the plane')


def _state(averaged: Averaged, waves: SurfaceWaves, root: Root, tolerance, begun) -> PlaneState:
    slider, units = averaged.slider, averaged.scaled
    velocity, yaw_rate = rigid_motion(averaged, root.unknown)
    error, yaw_error = np.abs(root.error[:2]) * units.speed, abs(root.error[2]) * units.omega / averaged.arm
    fastest = float(np.linalg.norm(averaged.rigid @ root.unknown, axis=1).max()) * units.speed
    turns = slider.freedom == "axle"
    speed = fastest if turns else float(np.hypot(*velocity))
    reference = speed_scale(speed, waves.peak_speed)
    reasons = ["averaged equilibrium in the plane"]
    by_averaging = averaging_error(slider, waves)
    size = float(np.linalg.norm(root.error)) * units.speed + by_averaging * reference
    # a relative error of the forces moves each contact, and so turns a slider that hardly turns
    arm = averaged.arm * units.length
    error, yaw_error = error + by_averaging * reference, yaw_error + by_averaging * max(reference / arm, abs(yaw_rate))
    yaw_error *= 2 in FREE[slider.freedom]
    if root.held and by_averaging > tolerance:
        with suppress(ConvergenceError):
            size, error, yaw_error = _motion_on_larger_waves(slider, waves)
    if units.period_change > COMMENSURABLE:
        reasons.append(f"frequencies changed by {units.period_change:.1g} to have a common period")
    band = None
    if root.near_rest:
        raise ConvergenceError(
            "near the threshold", "friction holds the slider or nearly so, and averaging cannot tell which"
        )
    if root.held:
        band = force_band(averaged)
        stuck = "its contacts never slip" if set(_regimes(averaged, root)) == {"stick"} else "held"
        reasons.append(f"{stuck}: they carry {band.least:.3g} to {band.largest:.3g} N along {band.direction.round(3)}")
    answer = Answer(value=speed, error=size, reasons=tuple(reasons)).judged(tolerance, reference)
    contacts = root.means.contacts
    return PlaneState(
        answer=answer, velocity=velocity, yaw_rate=yaw_rate, error=error, yaw_error=yaw_error,
        force=root.means.force[:2] * units.force, torque=float(root.means.force[2]) * averaged.arm * units.force
        * units.length, powers=_powers(averaged, root), regimes=_regimes(averaged, root),
        normal_loads=contacts[:, Sum.NORMAL] * units.force,
        heights=(averaged.problem.height - averaged.height) * units.length, held=root.held, band=band,
        reference=reference, method="averaged", seconds=time.perf_counter() - begun,
        statistics={
            "evaluations": averaged.evaluations, "made": contacts[:, Extra.MADE].astype(int).tolist(),
            "slips": contacts[:, Extra.SLIPS].astype(int).tolist(),
            "periods": contacts[:, Extra.PERIODS].astype(int).tolist(),
            "cycles": round(units.period / (2.0 * math.pi)), "beat": slowest_beat(waves.frequencies),
        },
    )  # fmt: skip


def _motion_on_larger_waves(slider, waves):
    """Return speed, |v_x| and |v_y|, and |yaw rate| on waves larger by as much as averaging may misjudge a threshold.

    They are the errors of a slider that is held.
    """
    ratio, of_beat = resonance_ratios(slider, waves)
    waves = waves.scaled(larger_wave(math.sqrt(ratio**2 + OF_BEAT / OF_VELOCITY * of_beat**2)))
    averaged = Averaged.of(slider, waves)
    velocity, yaw_rate = rigid_motion(averaged, balanced(averaged, tolerance=1e-3).unknown)
    return _speed(averaged, velocity, yaw_rate), np.abs(velocity), abs(yaw_rate)


def rigid_motion(averaged: Averaged, unknown) -> tuple[np.ndarray, float]:
    """Return the velocity of the slider's centre in m/s and the yaw rate in rad/s."""
    slider, units = averaged.slider, averaged.scaled
    velocity, yaw_rate = unknown[:2] * units.speed, float(unknown[2]) * units.omega / averaged.arm
    if slider.freedom == "axle":
        velocity = velocity + yaw_rate * np.array([slider.axis[1], -slider.axis[0]])
    return velocity + 0.0, yaw_rate + 0.0


def _regimes(averaged: Averaged, root: Root) -> tuple[str, ...]:
    least = AT_LIMIT * averaged.friction * averaged.top_speed if root.held else 0.0
    return tuple(_regime(each, least) for each in root.means.contacts)


def _regime(contact, least_slip):
    if contact[Sum.CONTACT] == 0.0:
        return "open"
    if contact[Extra.STUCK] == 1.0:
        return "stick"
    if contact[Extra.MADE] > 0:
        return "intermittent"
    return "slip" if contact[Sum.SLIP] > least_slip else "stick"


def _powers(averaged, root):
    contacts, u = root.means.contacts, root.unknown
    unit = averaged.scaled.power
    return Powers(
        wave=float(contacts[:, Sum.WAVE_TANGENTIAL].sum()) * unit, slip=float(contacts[:, Sum.SLIP].sum()) * unit,
        dampers=float(averaged.damping @ u**2) * unit, load=float(averaged.load @ u) * unit,
        law=float(contacts[:, Sum.LEAK].sum()) * unit,
    )  # fmt: skip


def force_band(averaged: Averaged, direction=None) -> Band:
    """Return the forces that a slider at rest can carry along a direction, by default that of its load or x."""
    if direction is None:
        load = averaged.load[:2]
        direction = load / np.linalg.norm(load) if load.any() else np.array([1.0, 0.0])
    known = Forces.none()
    ends = [s * least_at_rest(averaged, np.append(s * np.asarray(direction), 0.0), known=known) for s in (1.0, -1.0)]
    least, largest = (end * averaged.scaled.force for end in ends)
    return Band(direction=np.array(direction), least=least, largest=largest)


@dataclass(frozen=True, kw_only=True)
class MeanPlaneForces:
    """Mean forces of the contacts on a slider that keeps a velocity and a yaw rate.

    Attributes
    ----------
    force : (2,) array
        N.
    torque : float
        About the centre, or the axle, N m.
    error, torque_error : float
        Of the force and the torque, against means with other nodes and another tolerance.
    slip_power, wave_power : float
        W.
    """

    force: np.ndarray
    torque: float
    error: float
    torque_error: float
    slip_power: float
    wave_power: float


def mean_forces(slider: Slider, surface: Surface, velocity, yaw_rate: float = 0.0) -> MeanPlaneForces:
    """Return the mean forces of the contacts on a slider with this velocity (2,) in m/s and yaw rate in rad/s.

    The velocity is that of the slider's centre; with "axle" it is that of the point on the axle.
    """
    refuse(slider)
    waves = surface_under(slider, surface)
    refuse_slow_beat(slider, waves)
    averaged = Averaged.of(slider, waves)
    units = averaged.scaled
    unknown = np.array([*np.asarray(velocity, float) / units.speed, yaw_rate * averaged.arm / units.omega])
    # a contact that never opens is dragged to its limit against its motion
    averaged.deformation = dragged(averaged, unknown)
    fine, coarse = averaged.at(unknown, ANSWER), averaged.at(unknown, CHECK)
    return forces_of(averaged, fine, coarse)


def forces_of(averaged: Averaged, fine: Means, coarse: Means) -> MeanPlaneForces:
    """Return mean forces with their difference from coarser ones as error."""
    units = averaged.scaled
    moment = averaged.arm * units.force * units.length
    change = np.abs(fine.force - coarse.force)
    return MeanPlaneForces(
        force=fine.force[:2] * units.force, torque=float(fine.force[2]) * moment,
        error=float(np.hypot(*change[:2])) * units.force, torque_error=float(change[2]) * moment,
        slip_power=float(fine.contacts[:, Sum.SLIP].sum()) * units.power,
        wave_power=float(fine.contacts[:, Sum.WAVE_TANGENTIAL].sum()) * units.power,
    )  # fmt: skip
