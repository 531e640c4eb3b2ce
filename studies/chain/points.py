"""The points of a run: for each level of drive the steady velocity, its regime and its error."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from studies.chain import bridge
from studies.chain.propagation import velocity_error
from studies.chain.tally import burst_tally, steady_tally
from studies.refusal import SceneError
from studies.scene import Scene

SAMPLES = 2000  # instants of a trajectory: it is drawn and kept, not integrated
STEADY_METHODS, BURST_METHODS = ("auto", "exact", "averaged"), ("auto", "exact", "stepped")
SHAPED_METHODS = ("auto", "stepped")  # which may follow an envelope
CONTACT_SHARE = 0.25  # of the tolerance, asked of the contact's solvers


@dataclass(frozen=True, kw_only=True)
class SliderAnswer:
    """What the slider does at every level."""

    points: tuple[dict, ...]  # as in run.json
    # Errors of each point from the stator and from the contact, over the reference speed
    parts: tuple[tuple[float, float], ...]
    summary: dict  # threshold and release
    trajectories: tuple  # with a burst

    def blocks(self, tolerance: float) -> dict:
        """Return the record's blocks, the error that of the worst point."""
        failed = [point for point in self.points if not point["status"].startswith(("ok", "above tolerance"))]
        known = [
            part for part, point in zip(self.parts, self.points, strict=True) if "relative_error" in point
        ]
        blocks = {"points": self.points, "summary": self.summary, "trajectories": self.trajectories}
        if known:
            stator, contact = max(known, key=sum)
            error = stator + contact
            blocks["error"] = {"relative": error, "parts": {"stator": stator, "contact": contact}}
            if error > tolerance:
                blocks["shortfall"] = (
                    f"the velocity's error is {error:.1e} (stator {stator:.1e}, contact {contact:.1e}), "
                    f"{tolerance:.1e} was asked for: see error.parts, or ask for less"
                )
        if failed:
            what = f"{len(failed)} of {len(self.points)} points have no answer: {failed[0]['status']}"
            blocks["shortfall"] = what
        return blocks


def slider_answer(
    scene: Scene,
    orbits: tuple,
    amplitudes: tuple[float, float],
    *,
    stator_error: float,
    tolerance: float,
    progress: Callable[[str], None],
    ringing=None,
    along=None,
) -> SliderAnswer:
    """Solve the contact at every level of a resolved scene, its solvers asked for a quarter of the tolerance.

    ``orbits`` (`contact.Orbit`) and ``amplitudes``, |u_z| and |u_x| at the slider's centre, are those of 1 V, or of 1 m
    of given amplitude; ``stator_error`` is the orbits', relative.  ``ringing`` (`chain.ring_up.RingUp`) says how they
    grow during a burst, ``along`` (`chain.travel.WaveAlong`) how they change along the field; without it the slider
    stays at its place.
    """
    from contact import kernels

    slider = _refusing(lambda: bridge.contact_slider(scene.slider))
    points, parts, trajectories = [], [], []
    summary, threshold = _summary(scene, slider, orbits, amplitudes[0])
    waiting = "" if kernels.ready() else f", compiling {kernels.how_often()}"
    for number, level in enumerate(scene.levels, start=1):
        progress(f"contact: point {number} of {len(scene.levels)}{waiting if number == 1 else ''}")
        point = {} if scene.wave is not None else {"voltage_V": level}
        for side, amplitude in zip(("normal", "tangential"), amplitudes, strict=True):
            point[f"{side}_amplitude_m"] = amplitude * level
        here = bridge.scaled(orbits, level)
        travelling = None if along is None or scene.slider.travel is False else (along, level)
        found, part, trajectory = _point(scene, slider, here, stator_error, tolerance, ringing, travelling)
        found |= contact_load(slider, here, threshold / level if level > 0.0 else math.inf)
        points.append(point | found)
        parts.append(part)
        trajectories += [] if trajectory is None else [(level, trajectory)]
    return SliderAnswer(
        points=tuple(points), parts=tuple(parts), summary=summary, trajectories=tuple(trajectories)
    )


def _point(scene: Scene, slider, orbits: tuple, stator_error: float, tolerance: float, ringing, travelling):
    """Return the point's values, the parts of its error and its trajectory; a failure is its status."""
    import contact

    steady_method = _method(scene, "the steady state", STEADY_METHODS)
    asked = tolerance * CONTACT_SHARE

    def steady(some):
        return contact.steady(slider, some, tolerance=asked, method=steady_method)

    try:
        state = _refusing(lambda: steady(orbits))
        from_stator = velocity_error(state.velocity, orbits, stator_error, _nearby(slider, state, steady))
        values = {"velocity_m_per_s": state.velocity, "regime": state.regime}
        tally = steady_tally(state)
        from_contact, status, message, trajectory = state.relative_error, state.status, state.message, None
        if scene.burst is not None:
            trajectory = _burst(scene, slider, orbits, state.velocity, asked, ringing)
            if travelling is not None:
                trajectory, moved = _along(scene, slider, trajectory, *travelling)
                values |= moved
            values["velocity_at_burst_end_m_per_s"] = trajectory.velocity_at_burst_end
            tally |= burst_tally(trajectory)
            from_stator += 0.0 if ringing is None else ringing.error
            if trajectory.relative_error > from_contact or status == "ok":
                from_contact = max(from_contact, trajectory.relative_error)
                status, message = trajectory.status, trajectory.message
    except contact.ConvergenceError as error:
        return {"status": " ".join(str(error).split())}, (0.0, 0.0), None
    error = values["relative_error"] = from_stator + from_contact
    if status == "above tolerance" and error <= tolerance:
        status = "ok"  # the contact missed its share, the sum of both parts keeps the tolerance
    elif error > tolerance and status == "ok":
        status, message = "above tolerance", f"stator {from_stator:.1e}, contact {from_contact:.1e}"
    values["status"] = status if status == "ok" else f"{status}: {message}"
    return values | tally, (from_stator, from_contact), trajectory


def _nearby(slider, state, steady):
    """Return what gives the velocity near a state: cycle means, shifted to it, or where they fail the state's way."""
    import contact

    def mean(orbits):
        return contact.mean_motion(slider, orbits).velocity

    try:
        shift = state.velocity - mean(state.orbits)
    except contact.ConvergenceError:
        return lambda some: steady(some).velocity

    def velocity(some):
        try:
            return mean(some) + shift
        except contact.ConvergenceError:
            return steady(some).velocity

    return velocity


def _burst(scene: Scene, slider, orbits: tuple, velocity: float, tolerance: float, ringing):
    """Follow the burst, and the slider until it has stopped and rung for some periods."""
    import contact

    friction = slider.friction_coefficient * slider.preload
    stopping = abs(velocity) * slider.mass / friction if friction > 0 else 0.0
    after_ring = 20 / slider.tangential_resonance(len(orbits)) if slider.preload > 0 else 0.0
    method = _method(scene, "a burst", BURST_METHODS)

    rings = 0.0 if ringing is None or ringing.ring_down is None else float(ringing.ring_down.time[-1])

    def followed(shape, fading=None):
        after = min(1.2 * stopping + after_ring, 10 * scene.burst)
        return contact.burst(
            slider,
            orbits,
            duration=scene.burst,
            after=after if fading is None else (after + rings, fading),
            tolerance=tolerance,
            samples=SAMPLES,
            method=method,
            envelope=shape,
        )

    if ringing is None or ringing.envelope is None or method not in SHAPED_METHODS:
        return followed(None)
    try:
        return followed(ringing.envelope, ringing.ring_down)
    except contact.ConvergenceError:
        if method != "auto":
            raise
        return followed(None)  # this motion needs the events, and they take no envelope


def _along(scene: Scene, slider, trajectory, along, level: float):
    """Return the trajectory along the field, and what the point says of it; unchanged where the slider hardly moves."""
    import contact
    from studies.chain.propagation import reference_speed
    from studies.chain.travel import LEAST_TRAVEL, travelled, with_travel

    on = trajectory.time <= trajectory.duration * (1 + 1e-12)
    expected = float(np.trapezoid(trajectory.velocity[on], trajectory.time[on]))
    if scene.slider.travel is None and abs(expected) <= LEAST_TRAVEL * along.wavelength:
        return trajectory, {}
    found = travelled(slider, along, level, trajectory.duration, expected)
    if found.ended:
        raise contact.ConvergenceError(
            "not applicable",
            f"a ball reaches the stator's end {found.time[-1]:.3g} s after the start: shorten drive.burst, or set "
            "slider.travel = false for the velocity that the wave at the slider's place would give",
        )
    # what the averaged equation misses of the burst at one place, it misses of the change too
    speed = reference_speed(trajectory.velocity_at_burst_end, trajectory.orbits)
    missed = abs(found.held_velocity[-1] - trajectory.velocity_at_burst_end) / speed
    error = trajectory.relative_error + (found.error + missed * abs(found.change)) / speed
    return replace(with_travel(trajectory, found), relative_error=error), {"travel_m": float(found.place[-1])}


def contact_load(slider, orbits: tuple, threshold: float) -> dict:
    """Return the pressure under a contact on the highest crest, and how far the amplitude is below the threshold.

    ``threshold``: factor on the orbits at which the slider starts to move; infinite where it never does.
    """
    from contact import riding_height

    found = {"stick_margin": threshold - 1.0} if math.isfinite(threshold) else {}
    if slider.preload > 0.0:
        crests = slider.offsets(len(orbits)) + [abs(orbit.normal) for orbit in orbits]
        found["contact_pressure_Pa"] = float(slider.pressure(riding_height(slider, orbits) + max(crests)))
    return found


def averaged(asked: list[tuple], threads: int | None = None) -> list[tuple]:
    """Return averaged steady states, each of (slider, orbits, wave error, factor on the orbits).

    An answer is velocity, regime, error, error from the wave and blocked thrust.  Those with equally many orbits are
    computed side by side, in one compiled loop (`contact.steady_sweep`); what averaging does not know has the regime
    "unknown".
    """
    import contact

    groups, answers = {}, [()] * len(asked)
    for at, (_, orbits, _, _) in enumerate(asked):
        groups.setdefault(len(orbits), []).append(at)
    for members in groups.values():
        some, sliders, waves = [asked[at] for at in members], {}, {}
        which = [
            (sliders.setdefault(slider, len(sliders)), waves.setdefault((orbits, error), len(waves)))
            for slider, orbits, error, _ in some
        ]
        orbits, errors = zip(*waves, strict=True)
        found = contact.steady_sweep(
            list(sliders),
            orbits,
            which=which,
            factors=[each[-1] for each in some],
            wave_errors=errors,
            threads=threads,
        )
        names = ("velocity", "regime", "relative_error", "error_from_wave", "blocked_thrust")
        rows = zip(*(getattr(found, name).tolist() for name in names), strict=True)
        for at, row in zip(members, rows, strict=True):
            answers[at] = row
    return answers


def half_thrust(slider, orbits: tuple, thrust: float, tolerance: float) -> tuple[float, float]:
    """Return what a slider gives out under half of its blocked thrust (N), W, and over what the wave puts in."""
    import contact

    if not thrust > 0.0:
        return 0.0, 0.0
    state = contact.steady(replace(slider, load=0.5 * thrust), orbits, tolerance=tolerance)
    out, put_in = 0.5 * thrust * abs(state.velocity), state.ledger.wave * orbits[0].frequency
    return out, out / put_in if put_in > 0.0 else 0.0


def _summary(scene: Scene, slider, orbits: tuple, amplitude: float) -> tuple[dict, float]:
    """Return threshold and release, what never comes absent; and the factor on the orbits at the threshold."""
    import contact

    found, factors = {}, (contact.threshold_factor(slider, orbits), contact.release_factor(slider, orbits))
    for name, factor in zip(("threshold", "release"), factors, strict=True):
        if math.isfinite(factor):
            found[f"{name}_amplitude_m"] = factor * amplitude
            if scene.wave is None:
                found[f"{name}_voltage_V"] = factor
    return found, factors[0]


def _method(scene: Scene, what: str, available: tuple[str, ...]) -> str:
    """Return the contact's method for a task: the other task's method leaves this one automatic."""
    wanted = scene.slider.method
    if wanted in available:
        return wanted
    if scene.burst is None or wanted not in STEADY_METHODS + BURST_METHODS:
        names = " or ".join(f'"{name}"' for name in available)
        raise SceneError("slider.method", f"must be {names} for {what}, got {wanted!r}")
    return "auto"


def _refusing(call: Callable):
    """Return what a call gives; the contact's refusal of a slider is the scene's."""
    try:
        return call()
    except ValueError as error:
        if str(error).startswith("slider."):
            raise SceneError("", str(error)) from None
        raise
