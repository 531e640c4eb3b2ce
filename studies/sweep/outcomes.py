"""What a point of a sweep is answered with beside its velocity: amplitudes, power, limits, thrust, efficiency."""

from dataclasses import dataclass

from studies.chain import bridge
from studies.chain.points import contact_load, half_thrust
from studies.scene import Scene
from studies.sweep.source import Source


@dataclass(frozen=True, kw_only=True)
class Driven:
    """A point made ready: its resolved scene, the motion per unit of its level, and what it comes from."""

    scene: Scene
    level: float
    orbits: tuple
    amplitudes: tuple[float, float]
    error: float
    source: Source | None
    final: bool


def electrical(driven: Driven) -> dict:
    """Return a point's amplitudes and, with a stator, what its driven comb takes."""
    normal, tangential = driven.amplitudes
    found = {"normal_amplitude_m": normal * driven.level, "tangential_amplitude_m": tangential * driven.level}
    if driven.source is None:
        return found
    source = driven.source
    return found | {
        "frequency_Hz": source.frequency,
        "conductance_S": source.admittance.real,
        "susceptance_S": source.admittance.imag,
        "power_W": 0.5 * source.admittance.real * abs(source.comb_voltage * driven.level) ** 2,
    }


def also_asked(question, driven: Driven, answer: dict) -> dict:
    """Return the answer with what was asked for beside the velocity, totals of the slider."""
    if not question.also or "velocity_m_per_s" not in answer:
        return answer
    import contact

    slider, orbits = bridge.contact_slider(driven.scene.slider), bridge.scaled(driven.orbits, driven.level)
    if "limits" in question.also:
        for name, factor in (("threshold", contact.threshold_factor), ("release", contact.release_factor)):
            answer[f"{name}_factor"] = factor(slider, orbits)
    if "pressure" in question.also:
        answer |= contact_load(slider, orbits, contact.threshold_factor(slider, orbits))
    if "step" in question.also:
        answer |= _step(slider, orbits)
    if not {"thrust", "efficiency"} & set(question.also):
        return answer
    share = driven.scene.slider.mass / slider.mass
    thrust = answer.pop("thrust_N", None)
    if thrust is None:
        try:
            thrust = max(contact.blocked_thrust(slider, orbits)[0], 0.0)
        except contact.ConvergenceError:
            return answer
    answer["thrust_N"] = thrust * share
    if "efficiency" in question.also:
        answer |= _efficiency(driven, slider, orbits, thrust, question.tolerance)
    return answer


def _step(slider, orbits) -> dict:
    """Return the size of the step that one cycle makes from rest."""
    import contact

    try:
        return {"step_m": abs(contact.step(slider, orbits, cycles=1).displacement)}
    except contact.ConvergenceError:
        return {}


def _efficiency(driven, slider, orbits, thrust, tolerance) -> dict:
    """Return the efficiencies at half the blocked thrust: of the contact, and of the power into the driven comb."""
    import contact

    try:
        out, share = half_thrust(slider, orbits, thrust, tolerance)
    except contact.ConvergenceError:
        return {}
    found = {"contact_efficiency": share}
    power = electrical(driven).get("power_W", 0.0)
    if power > 0.0:
        found["motor_efficiency"] = out * driven.scene.slider.mass / slider.mass / power
    return found
