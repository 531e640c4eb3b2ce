"""Each answer again for the mirrored motor and with its contacts in another order, with all signed columns.

Truth: a mirror image moves the other way, with the same sizes and errors; the order of the contacts is a name alone.
All columns of an answer are compared, so that a sign that is right in the simplest scene only does not pass.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import pytest

from contact import (
    Orbit,
    burst,
    contact_history,
    cycles_for,
    load_line,
    mean_forces,
    mean_motion,
    mean_traction,
    pillar_load_line,
    pillar_motion,
    pillar_traction,
    release,
    riding_height,
    stall,
    steady,
    steady_sweep,
    step,
    threshold,
    velocity_derivative,
)
from contact.answers.load_and_stall import blocked_thrust
from tests.contact.motors import FREQUENCY, orbit, slider
from tests.contact.test_pillars import grid, scatter, wave

NONE: Mapping = MappingProxyType({})


class Columns(NamedTuple):
    """The columns of an answer; with contacts as the last axis in ``each`` and ``signed_each``."""

    signed: dict  # change their sign in the mirror
    sizes: dict  # do not
    signed_each: Mapping = NONE
    each: Mapping = NONE


# Three balls of unequal heights under different parts of a wave; the first does not touch at rest (4.7 nm deep).
HEIGHTS = (-9e-9, 1e-9, 0.0)
ORBITS = (
    Orbit(frequency=FREQUENCY, normal=12e-9, tangential=-8e-9j),
    Orbit(frequency=FREQUENCY, normal=9e-9 * np.exp(0.4j), tangential=-7e-9j * np.exp(0.3j)),
    Orbit(frequency=FREQUENCY, normal=10e-9 * np.exp(-0.2j), tangential=-6e-9j),
)
# u_z in phase: a burst begins where that of the first contact crosses zero
IN_PHASE = tuple(replace(each, normal=abs(each.normal)) for each in ORBITS)
BODY = slider(heights=HEIGHTS)


def of_steady(body, orbits, **options):
    found = steady(body, orbits, tolerance=1e-6, **options)
    other = {} if found.other_velocity is None else {"other": found.other_velocity}
    sizes = {"height": found.height, "error": found.relative_error, "energies": np.array(found.ledger)}
    return Columns({"velocity": found.velocity} | other, sizes | {"regime": hash(found.regime)})


def of_mean(body, orbits):
    found = mean_motion(body, orbits)
    forces = mean_forces(body, orbits, found)
    sizes = {key: float(getattr(found, key)) for key in ("height", "relative_error", "blocked_thrust", "load_sign")}
    signed = {"velocity": float(found.velocity), "first order": float(found.first_order)}
    return Columns(
        signed, sizes | {"riding": riding_height(body, orbits)},
        {"tangential": forces.tangential, "first tangential": forces.first_tangential},
        {"normal": forces.normal, "first normal": forces.first_normal},
    )  # fmt: skip


def of_sweep(body, orbits):
    options = {"which": [(0, 0)] * 2, "factors": [0.7, 1.0], "wave_errors": [1e-4], "threads": 1}
    found = steady_sweep([body], [orbits], **options)
    sizes = {"error": found.relative_error, "error of the wave": found.error_from_wave, "thrust": found.blocked_thrust}
    return Columns({"velocity": found.velocity}, sizes | {"height": found.height})


def of_burst(body, orbits, **options):
    found = burst(body, orbits, duration=60 / FREQUENCY, after=40 / FREQUENCY, tolerance=1e-4, samples=50, **options)
    sizes = {"time": found.time, "position": found.position, "error": found.answer.error}
    return Columns({"velocity": found.velocity, "at the end": found.velocity_at_burst_end}, sizes)


def of_load_line(body, orbits):
    found = load_line(body, orbits, points=4, tolerance=1e-4)
    sizes = {key: getattr(found, key) for key in ("load", "velocity", "power", "efficiency", "relative_error")}
    assert np.all(found.velocity[:-1] > 0.0)  # in the direction of the motion without a load, wherever that is
    assert np.all(np.diff(found.velocity) < 0.0)
    assert np.all((found.efficiency >= 0.0) & (found.efficiency < 1.0))
    return Columns({}, sizes | {"stall": found.stall.value, "stall error": found.stall.error})


def of_stall(body, orbits):
    averaged, held = blocked_thrust(body, orbits)
    found = stall(body, orbits, tolerance=1e-3)
    return Columns({}, {"averaged": averaged, "held": held, "full": found.value, "error": found.error})


def of_step(body, orbits):
    found = step(body, orbits, cycles=20)
    signed = {key: getattr(found, key) for key in ("displacement", "during", "stopping", "velocity")}
    return Columns(signed, {key: getattr(found, key) for key in ("stopping_time", "ring", "error")})


def of_plan(body, orbits):
    less, enough = cycles_for(body, orbits, displacement=1e-9)
    signed = {"less": less.displacement, "enough": enough.displacement}
    return Columns(signed, {"cycles": enough.cycles, "one less": less.cycles, "ring": enough.ring})


def of_limits(body, orbits):
    answers = {"threshold": threshold(body, orbits), "release": release(body, orbits)}
    return Columns({}, {key: (each.value, each.error) for key, each in answers.items()})


def of_derivative(body, orbits):
    def family(s):
        return replace(body, friction_coefficient=body.friction_coefficient * (1 + s)), orbits

    return Columns({"slope": velocity_derivative(family)}, {})


def of_traction(body, orbits):
    """Over velocities to both sides: the mirror image has them in the other order."""
    velocities = np.linspace(-0.05, 0.05, 9)
    return Columns({"traction": mean_traction(body, orbits, velocities)}, {})


def of_history(body, orbits):
    found = contact_history(body, orbits, stage="steady", skip=0, cycles=1, points_per_cycle=40)
    return Columns(
        {"slider": found.slider_velocity, "answer": found.answer.value}, {"time": found.time},
        {"deformation": found.deformation, "force": found.tangential_force, "surface": found.surface_velocity},
        {"approach": found.approach, "normal": found.normal_force},
    )  # fmt: skip


LOADED = replace(BODY, load=1e-5)
HYSTERETIC = slider(law="hysteretic", heights=HEIGHTS)
UNDAMPED = slider(normal_damping=0.0, mass=8.9e-6, preload=8.73e-5)
BELOW = (orbit(0.99 * 1.525e-10),)
ANSWERS = {
    "steady": (of_steady, BODY, ORBITS, {}),
    "steady under a load": (of_steady, LOADED, ORBITS, {}),
    "steady, averaged": (of_steady, LOADED, ORBITS, {"method": "averaged"}),
    "held without a damper": (of_steady, UNDAMPED, BELOW, {}),
    "steady, hysteretic": (of_steady, HYSTERETIC, ORBITS, {}),
    "steady, reciprocal": (of_steady, replace(BODY, reciprocal=True), ORBITS, {}),
    "burst, hysteretic": (of_burst, HYSTERETIC, IN_PHASE, {"method": "exact"}),
    "step, hysteretic": (of_step, HYSTERETIC, IN_PHASE, {}),
    "dragged": (of_steady, replace(BODY, load=2e-4), ORBITS, {}),
    "averaged motion": (of_mean, LOADED, ORBITS, {}),
    "sweep": (of_sweep, LOADED, ORBITS, {}),
    "burst, stepped": (of_burst, LOADED, IN_PHASE, {"method": "stepped"}),
    "burst, averaged": (of_burst, LOADED, IN_PHASE, {"method": "averaged"}),
    "burst, exact": (of_burst, LOADED, IN_PHASE, {"method": "exact"}),
    "load line": (of_load_line, BODY, ORBITS, {}),
    "stall": (of_stall, BODY, ORBITS, {}),
    "step": (of_step, LOADED, IN_PHASE, {}),
    "planned step": (of_plan, BODY, IN_PHASE, {}),
    "limits": (of_limits, BODY, ORBITS, {}),
    "limits under a load": (of_limits, LOADED, ORBITS, {}),
    "derivative": (of_derivative, LOADED, ORBITS, {}),
    "traction": (of_traction, BODY, ORBITS, {}),
    "history": (of_history, LOADED, IN_PHASE, {}),
}
# Velocities by an event-driven motion are equal to the rounding of the sums over the contacts, which the bounce
# amplifies.
CLOSE = {
    "steady": 1e-8,
    "steady under a load": 1e-8,
    "step": 1e-6,
    "planned step": 1e-6,
    "burst, exact": 1e-7,
    "burst, stepped": 1e-7,
}


def of(name, body=None, orbits=None):
    function, own_body, own_orbits, options = ANSWERS[name]
    return function(own_body if body is None else body, own_orbits if orbits is None else orbits, **options)


@pytest.mark.parametrize("name", ANSWERS)
def test_the_mirror_image_moves_the_other_way(name):
    orbits = ANSWERS[name][2]
    here, there = of(name), of(name, orbits=tuple(each.mirrored() for each in orbits))
    turned = -1.0 if name != "traction" else -np.array(there.signed["traction"])[::-1] / there.signed["traction"]
    for one, other, sign in (
        (here.signed, there.signed, turned), (here.signed_each, there.signed_each, -1.0),
        (here.sizes, there.sizes, 1.0), (here.each, there.each, 1.0),
    ):  # fmt: skip
        assert one.keys() == other.keys()
        for key, value in one.items():
            assert np.all(np.isfinite(np.asarray(value))), key
            assert np.asarray(other[key]) * sign == pytest.approx(np.asarray(value), rel=1e-12, abs=0), key
    assert any(np.any(np.asarray(value) != 0.0) for each in here for value in each.values())


@pytest.mark.parametrize("name", [name for name, (_, _, orbits, _) in ANSWERS.items() if len(orbits) == 3])
@pytest.mark.parametrize("order", [(1, 2, 0), (0, 2, 1)])
def test_the_order_of_the_contacts_is_a_name(name, order):
    """The contact that does not touch at rest is the first, or the last."""
    _, body, orbits, _ = ANSWERS[name]
    heights, moved = tuple(body.heights[k] for k in order), tuple(orbits[k] for k in order)
    here, there = of(name), of(name, replace(body, heights=heights), moved)
    close = CLOSE.get(name, 1e-9)
    for one, other in ((here.signed, there.signed), (here.sizes, there.sizes)):
        for key, value in one.items():
            scale = float(np.max(np.abs(np.asarray(value))))
            if "error" not in key:  # of two answers that differ by less than their rounding
                assert np.asarray(other[key]) == pytest.approx(np.asarray(value), rel=close, abs=close * scale), key
    for one, other in ((here.signed_each, there.signed_each), (here.each, there.each)):
        for key, value in one.items():
            scale = float(np.max(np.abs(value)))
            assert other[key] == pytest.approx(value[..., list(order)], rel=close, abs=1e-8 * scale), key


def test_the_height_of_a_steady_motion_is_a_mean_over_the_cycle():
    """A contact at 0.23 of the wave's frequency: where the cycle begins, the slider is 2.6 % lower."""
    body = slider(mass=2e-6, preload=2e-3, friction_coefficient=0.15, normal_damping=0.25678, tangential_damping=0.0)
    light = orbit(4e-9, frequency=300e3)
    motion = contact_history(body, light, stage="steady", skip=0, cycles=1, points_per_cycle=1000)
    assert steady(body, light, tolerance=1e-6).height == pytest.approx(float(motion.approach.mean()), rel=1e-6)


def pillar_columns(body, passing, **options):
    found = pillar_motion(body, passing, **options)
    line = pillar_load_line(body, passing, points=4, loading=options.get("loading"))
    traction = pillar_traction(body, passing, near=found)
    sizes = {
        key: getattr(found, key)
        for key in ("approach", "share_in_contact", "duty", "friction_power", "thrust_power", "wave_power_in",
                    "wave_power_out", "loading_number", "overtone", "wave_work")
    }  # fmt: skip
    sizes |= {key: abs(getattr(found, key)) for key in ("exit_over_entry", "reflected_over_entry")}
    sizes |= {"overtones": abs(found.exit_overtones)} if found.harmonics > 1 else {}
    sizes |= {"stall": line.stall, "held": line.held_up_to, "power": line.power, "efficiency": line.efficiency}
    sizes |= {"roll": found.tilt[1], "loads": line.load}
    signed = {
        "velocity": found.velocity, "pitch": found.tilt[0], "load": found.load, "traction": found.traction,
        "line": line.velocity, "at rest": traction(math.copysign(1e-9, found.velocity)),
        "faster": traction(1.2 * found.velocity),
    }  # fmt: skip
    each = {"P": found.normal_force, "loss": found.friction, "P_1": abs(found.first_normal)}
    return Columns(signed, sizes, {}, each | {"Q_1": abs(found.first_tangential)})


PILLARS = grid(12, 4, heights=scatter(48, 8e-9, 4), tilt="free", preload_at=(5e-5, -2e-5), load_height=1e-4)
FRICTION = PILLARS.friction_coefficient * PILLARS.preload  # N
BOTH = wave(forward=20e-9, backward=6e-9j, strip_width=0.3e-3)
PILLAR_SCENES = {
    "free to tilt": (PILLARS, BOTH, {}),
    "under a load": (PILLARS, BOTH, {"load": 2e-3}),
    "overtones": (grid(12, 4, heights=scatter(48, 8e-9, 4)), BOTH, {"loading": "harmonics"}),
    "soft backing": (grid(12, 4, heights=scatter(48, 8e-9, 4), backing="soft"), BOTH, {"loading": True}),
}


@pytest.mark.parametrize("name", PILLAR_SCENES)
def test_the_mirror_image_of_a_slider_on_pillars_moves_the_other_way(name):
    body, passing, options = PILLAR_SCENES[name]
    turned = replace(body, x=-body.x, preload_at=(-body.preload_at[0], body.preload_at[1]))
    back = replace(passing, forward=passing.backward, backward=passing.forward)
    here, there = pillar_columns(body, passing, **options), pillar_columns(turned, back, **options)
    for one, other, sign in zip(here, there, (-1.0, 1.0, -1.0, 1.0), strict=True):
        for key, value in one.items():
            scale = FRICTION if key == "traction" else float(np.max(np.abs(value)))
            assert sign * np.asarray(other[key]) == pytest.approx(np.asarray(value), rel=1e-7, abs=1e-9 * scale), key


@pytest.mark.parametrize("name", PILLAR_SCENES)
def test_the_order_of_the_pillars_is_a_name(name):
    body, passing, options = PILLAR_SCENES[name]
    order = np.random.default_rng(1).permutation(body.x.size)
    moved = replace(body, x=body.x[order], y=body.y[order], heights=body.heights[order])
    here, there = pillar_columns(body, passing, **options), pillar_columns(moved, passing, **options)
    for one, other, each in zip(here, there, (slice(None),) * 3 + (order,), strict=True):
        for key, value in one.items():
            value = np.asarray(value)[each] if np.ndim(value) else np.asarray(value)
            scale = FRICTION if key == "traction" else float(np.max(np.abs(value)))
            assert np.asarray(other[key]) == pytest.approx(value, rel=1e-7, abs=1e-9 * scale), key
