"""Random motors of the contact, from one place: each function is a family, aimed at one thing that may go wrong.

A family returns the same motor for a number in every process and session: tests know draws by their numbers.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from contact import Envelope, Orbit, Slider
from tests.seed_motor import SLIDER

# a slider of the seed's solids without dampers; its mass is replaced by that of a bounce (`mass_of_bounce`)
PLAIN = SLIDER | {"mass": 1e-6, "normal_damping": 0.0, "tangential_damping": 0.0}
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)  # of `around_the_seed`
SLOWEST_BOUNCE, FASTEST_BOUNCE = -2.0, -0.53  # powers of ten of f_n/f in `slow_bounce`
# ranges of the quantities of a corner; those in MAY_BE_ZERO are zero in one of four draws
CORNER_RANGES = {
    "moduli over the seed's": (1e-3, 1e3), "preload": (1e-9, 1e3), "amplitude": (1e-12, 1e-5),
    "friction_coefficient": (1e-3, 5.0), "mass": (1e-12, 1.0), "radius": (1e-9, 1.0), "frequency": (1.0, 1e10),
    "stick_band": (1e-6, 10.0), "contact_damping": (1e-6, 1e6), "normal_damping": (1e-6, 1e6),
    "tangential_damping": (1e-6, 1e6), "load": (1e-9, 1.0), "tangential_ratio": (1e-2, 10.0),
}  # fmt: skip
MAY_BE_ZERO = (
    "stick_band", "contact_damping", "normal_damping", "tangential_damping", "load", "preload", "friction_coefficient",
)  # fmt: skip


def mass_of_bounce(slider: Slider, contacts: int, frequency: float, ratio: float) -> float:
    """Return the mass in kg with which a slider bounces at a ratio of the wave's frequency."""
    return slider.mass * (slider.normal_resonance(contacts) / frequency / ratio) ** 2


def aimed(number: int):
    """Return (slider, orbits, method, cycles, tolerance) of a burst that fast methods may misjudge.

    Punches, contact dampers, light dampers, few cycles.
    """
    draw = np.random.default_rng([2411, number])
    n, frequency = int(draw.integers(1, 4)), 10.0 ** draw.uniform(5, 7.5)
    omega, ratio = 2.0 * math.pi * frequency, 10.0 ** draw.uniform(-3, -1.02)
    punch, mu, preload = draw.random() < 0.4, draw.uniform(0.05, 0.45), 10.0 ** draw.uniform(-4.6, -2.7)
    slider = Slider(**PLAIN | {
        "radius": 10.0 ** (draw.uniform(-6.3, -5) if punch else draw.uniform(-4, -3)), "preload": preload,
        "friction_coefficient": mu, "shape": "punch" if punch else "sphere",
        "load": float(draw.choice([0.0, draw.uniform(0, 0.9)])) * mu * preload,
    })  # fmt: skip
    mass, rest = mass_of_bounce(slider, n, frequency, ratio), slider.rest_approach(n)
    amplitude = rest * 10.0 ** draw.uniform(-0.4, 1.2)
    chi = float(draw.choice([0.0, 10.0 ** draw.uniform(-3, -0.5)])) / (omega * max(amplitude, rest))
    slider = replace(
        slider, mass=mass, contact_damping=chi,
        normal_damping=float(draw.choice([0.0, mass * omega * ratio * 10.0 ** draw.uniform(-4, 0)])),
        tangential_damping=float(draw.choice([0.0, mass * omega * 10.0 ** draw.uniform(-6, -2.5)])),
        heights=tuple(draw.uniform(0, 1, n) * rest) if n > 1 and draw.random() < 0.3 else (),
    )  # fmt: skip
    slope, tilt = 10.0 ** draw.uniform(-1.4, 0.3), draw.choice([0.0, draw.uniform(-1.4, 1.4)])
    orbits = tuple(
        Orbit(
            frequency=frequency, normal=amplitude * np.exp(1j * phase),
            tangential=-1j * slope * draw.uniform(0.3, 1.0) * amplitude * np.exp(1j * (phase + tilt)),
        )
        for phase in draw.uniform(0, 2 * math.pi, n)
    )  # fmt: skip
    method = ("stepped", "averaged")[int(draw.integers(2))]
    return slider, orbits, method, int(10.0 ** draw.uniform(1.2, 3.9)), 10.0 ** -float(draw.integers(2, 7))


def slow_bounce(number: int):
    """Return (slider, orbits) of an aimed draw, with f_n/f from 0.01 to 0.3 and a damper that ends the bounce."""
    slider, orbits, *_ = aimed(number)
    ratio = 10.0 ** np.random.default_rng([2405, number]).uniform(SLOWEST_BOUNCE, FASTEST_BOUNCE)
    frequency = orbits[0].frequency
    mass = mass_of_bounce(slider, len(orbits), frequency, ratio)
    return replace(slider, mass=mass, normal_damping=0.3 * mass * math.pi * frequency * ratio), orbits


def around_the_seed(number: int):
    """Return (slider, orbits, cycles): every quantity of the seed's by up to a factor of ten either way."""
    draw = np.random.default_rng([20261, number])

    def around(value, factor):
        return float(value * factor ** draw.uniform(-1.0, 1.0))

    mass = around(SLIDER["mass"], 10.0)
    slider = Slider(**SLIDER | {
        "mass": mass, "preload": around(9.81 * mass, 3.0), "radius": around(1e-3, 10.0),
        "friction_coefficient": around(0.12, 3.0), "effective_modulus": around(64e9, 2.0),
        "tangential_modulus": around(12e9, 2.0),
        "normal_damping": around(5e3, 10.0) * mass, "tangential_damping": around(1.0, 30.0) * mass,
    })  # fmt: skip
    amplitude, angle = around(4e-9, 6.0), -0.5 * math.pi + float(draw.uniform(-0.4, 0.4))
    wave = Orbit(
        frequency=around(2.2e6, 4.0), normal=amplitude,
        tangential=around(0.7, 1.6) * amplitude * complex(np.exp(1j * angle)),
    )  # fmt: skip
    contacts, step = int(draw.choice([1, 1, 3])), float(draw.uniform(0.0, 2.0 * math.pi))
    orbits = tuple(wave.scaled(complex(np.exp(1j * step * k))) for k in range(contacts))
    return slider, orbits, int(100 * 60.0 ** draw.random())


def near_the_edge_of_slip(count: int) -> Iterator:
    """Yield (slider, orbits): velocities near the edges of slip, contacts near resonance, orbits of any shape."""
    rng = np.random.default_rng(20261123)
    for _ in range(count):
        body = Slider(**SLIDER | {
            "shape": str(rng.choice(["sphere", "punch"])), "radius": float(10 ** rng.uniform(-5, -3)),
            "preload": float(10 ** rng.uniform(-3.5, -1.5)), "friction_coefficient": float(rng.uniform(0.05, 0.4)),
            "contact_damping": float(rng.choice([0.0, 1e-6])), "tangential_damping": float(10 ** rng.uniform(-5, -2)),
        })  # fmt: skip
        contacts = int(rng.integers(1, 4))
        frequency = body.normal_resonance(contacts) / rng.uniform(0.08, 0.3)
        # from just above the first slip to well beyond release
        size = body.rest_approach(contacts) * 10 ** rng.uniform(-1.2, 0.5)
        shape = rng.uniform(0.2, 1.5) * np.exp(1j * rng.uniform(-np.pi, np.pi))
        wave = tuple(
            Orbit(frequency=frequency, normal=size, tangential=size * shape).scaled(np.exp(1j * rng.uniform(0.0, 6.0)))
            for _ in range(contacts)
        )  # fmt: skip
        load = rng.choice([0.0, 0.2]) * body.friction_coefficient * body.preload
        yield replace(body, load=float(load)), wave


def hard_to_average(seed: int, refused: Callable[[Slider, tuple], bool]) -> Iterator:
    """Yield (slider, orbits, cycles, tolerance) without end, those that averaging refuses left out.

    A strong damper of the contact, a load while the slider hops, no normal damping, and several contacts at different
    phases of the wave, in turn.
    """
    rng, kept = np.random.default_rng(seed), 0
    while True:
        kind = kept % 4
        mass, friction = 10 ** rng.uniform(-6, -4), rng.uniform(0.05, 0.3)
        preload = 10 ** rng.uniform(-4, -2.5)
        slider = Slider(**PLAIN | {
            "mass": mass, "preload": preload, "friction_coefficient": friction,
            "load": rng.uniform(0.3, 0.95) * friction * preload if kind == 1 else 0.0,
            "contact_damping": 10 ** rng.uniform(0, 2) if kind == 0 else 0.0,
            "normal_damping": 0.0 if kind == 2 and rng.random() < 0.4 else mass * 10 ** rng.uniform(2.5, 4.5),
            "tangential_damping": mass * 10 ** rng.uniform(-1, 2.5),
        })  # fmt: skip
        normal = 10 ** rng.uniform(-9, -7.7)
        first = Orbit(frequency=2.2e6, normal=normal, tangential=-1j * rng.uniform(0.3, 1.2) * normal)
        angles = [0.0, *rng.uniform(0.0, 2.0 * np.pi, int(rng.integers(1, 3)))] if kind == 3 else [0.0]
        orbits = tuple(first.scaled(np.exp(1j * angle)) for angle in angles)
        cycles, tolerance = int(rng.integers(600, 5000)), 10 ** rng.uniform(-5, -3)
        if not refused(slider, orbits):
            kept += 1
            yield slider, orbits, cycles, tolerance


def under_an_envelope(number: int):
    """Return (slider, orbits, cycles, envelope): kinks within a cycle, short peaks, phases that run by up to 10 rad."""
    rng = np.random.default_rng([4405, number])
    contacts, frequency = int(rng.integers(1, 4)), 10.0 ** rng.uniform(5.3, 6.7)
    omega, ratio = 2.0 * np.pi * frequency, 10.0 ** rng.uniform(-2.5, -1.0)
    friction, preload = rng.uniform(0.05, 0.35), 10.0 ** rng.uniform(-4.0, -2.5)
    punch = rng.random() < 0.2
    plain = Slider(**PLAIN | {
        "radius": 1e-6 if punch else 10.0 ** rng.uniform(-3.5, -2.8), "preload": preload,
        "friction_coefficient": friction, "shape": "punch" if punch else "sphere",
        "load": float(rng.choice([0.0, rng.uniform(0.2, 0.8)])) * friction * preload,
        "effective_modulus": 90e9, "tangential_modulus": 20e9,
    })  # fmt: skip
    mass, rest = mass_of_bounce(plain, contacts, frequency, ratio), plain.rest_approach(contacts)
    slider = replace(
        plain, mass=mass, normal_damping=mass * omega * ratio * 10.0 ** rng.uniform(-1.5, -0.3),
        tangential_damping=mass * omega * 10.0 ** rng.uniform(-5.0, -2.5),
        heights=tuple(rng.uniform(0.0, rest, contacts)) if contacts > 1 and rng.random() < 0.3 else (),
    )  # fmt: skip
    normal, slope = rest * 10.0 ** rng.uniform(-0.7, 0.8), rng.uniform(0.3, 1.0)
    first = Orbit(frequency=frequency, normal=normal, tangential=-1j * slope * normal)
    orbits = tuple(first.scaled(np.exp(1j * angle)) for angle in [0.0, *rng.uniform(0.0, 6.28, contacts - 1)])
    cycles, corners = int(rng.integers(20, 160)), int(rng.integers(1, 6))
    if number % 4 == 0:  # a peak of less than a cycle
        time = rng.uniform(1.0, cycles - 2.0) + np.array([0.0, 0.3, 0.7])
        amplitude, phase = np.array([1.0, rng.uniform(0.0, 3.0), 1.0]), np.array([0.0, rng.uniform(-1.5, 1.5), 0.0])
    else:
        time = np.sort(np.append(rng.uniform(0.0, cycles, corners), [0.0, cycles]))
        amplitude = rng.uniform(0.0, 1.0, time.size) if number % 4 == 1 else np.ones(time.size)
        phase = np.cumsum(rng.uniform(-3.0, 3.0, time.size))
    return slider, orbits, cycles, Envelope(time=time / frequency, amplitude=amplitude, phase=phase)


def on_a_track(number: int) -> dict:
    """Return keywords of the oracle `Traveller`: reflection 0.2 to 0.9, f_n/f 0.005 to 0.06, one to three balls."""
    random = np.random.default_rng(number)
    frequency, ratio = 10 ** random.uniform(6.0, 6.7), 10 ** random.uniform(np.log10(0.005), np.log10(0.06))
    count, amplitude = int(random.integers(1, 4)), random.uniform(3e-9, 15e-9)
    reflection = random.uniform(0.2, 0.9) * np.exp(2j * np.pi * random.uniform())
    stiffness, approach = 4.0 / 3.0 * 64e9 * 1e-3**0.5, amplitude * random.uniform(0.3, 2.0)
    mass = 1.5 * count * stiffness * approach**0.5 / (2.0 * np.pi * frequency * ratio) ** 2
    rate = mass * 2.0 * np.pi * frequency
    return {
        "mass": mass, "preload": count * stiffness * approach**1.5, "frequency": frequency,
        "wavelength": 2200.0 / frequency, "amplitude": amplitude, "reflection": reflection,
        "ratio": random.uniform(0.5, 0.9), "mu": random.uniform(0.05, 0.3),
        "balls": tuple(random.uniform(-1e-3, 1e-3, count)),
        "normal_damping": rate * ratio * random.uniform(0.02, 0.3),
        "tangential_damping": rate * random.choice([0.0, 1e-5]),
    }  # fmt: skip


def corner(number: int) -> dict:
    """Return quantities by name, about half of them extreme: a random case of the study `stability`."""
    draw = np.random.default_rng([20260, number])
    values: dict[str, float | str] = {}
    for name, (low, high) in CORNER_RANGES.items():
        if draw.random() < 0.5:
            continue
        zero = name in MAY_BE_ZERO and draw.random() < 0.25
        values[name] = 0.0 if zero else float(low * (high / low) ** draw.random())
    values["angle"] = float(draw.uniform(-np.pi, np.pi)) if draw.random() < 0.3 else -0.5 * math.pi
    values["contacts"] = int(draw.choice([1, 1, 3]))
    values["law"] = str(draw.choice(["elastic", "elastic", "hysteretic"]))
    values["reciprocal"] = bool(draw.random() < 0.25)
    if values["law"] == "hysteretic":
        values["stick_band"] = 0.0
    return values


def balls_on_orbits(number: int) -> tuple[dict, list[dict]]:
    """Return keywords of a slider on one to eight balls or punches, and of the orbit of each contact.

    Sizes of real motors, f_n/f from 0.001 to 0.28; heights, of which some do not touch; loads up to 0.7 of friction.
    """
    rng = np.random.default_rng([4501, number])
    n, frequency, punch = int(rng.choice([1, 1, 2, 3, 3, 4, 6, 8])), 10.0 ** rng.uniform(5.3, 7.5), rng.random() < 0.35
    radius = 10.0 ** (rng.uniform(-6.0, -4.3) if punch else rng.uniform(-4.3, -2.5))
    modulus, preload, friction = (
        10.0 ** rng.uniform(10.6, 11.3),
        10.0 ** rng.uniform(-4.5, -1.5),
        rng.uniform(0.05, 0.45),
    )
    omega, ratio = 2.0 * math.pi * frequency, 10.0 ** rng.uniform(-3.0, -0.55)
    power = 1.0 if punch else 1.5
    stiffness = 2.0 * modulus * radius if punch else 4.0 / 3.0 * modulus * math.sqrt(radius)
    rest = (preload / n / stiffness) ** (1.0 / power)
    mass = power * preload / rest / (omega * ratio) ** 2
    heights = tuple((rng.uniform(-1.5, 1.0, n) * rest).tolist()) if rng.random() < 0.4 else ()
    body = {
        "radius": radius, "mass": mass, "preload": preload, "friction_coefficient": friction, "heights": heights,
        "load": float(rng.choice([0.0, rng.uniform(0.0, 0.7)])) * friction * preload, "effective_modulus": modulus,
        "tangential_modulus": modulus * rng.uniform(0.15, 0.4), "law": "elastic", "reciprocal": False,
        "stick_band": 0.0, "contact_damping": 0.0,
        "normal_damping": mass * omega * ratio * 10.0 ** rng.uniform(-1.5, 0.0),
        "tangential_damping": mass * omega * 10.0 ** rng.uniform(-6.0, -2.5), "shape": "punch" if punch else "sphere",
    }  # fmt: skip
    amplitude, slope, tilt = rest * 10.0 ** rng.uniform(-0.4, 1.1), rng.uniform(0.2, 1.3), rng.uniform(-0.7, 0.7)
    size, phase = amplitude * rng.uniform(0.6, 1.0, n), rng.uniform(0.0, 2.0 * math.pi, n)
    orbits = [
        {"frequency": frequency, "normal": complex(a * np.exp(1j * p)),
         "tangential": complex(-1j * slope * a * np.exp(1j * (p + tilt)))}
        for a, p in zip(size, phase, strict=True)
    ]  # fmt: skip
    return body, orbits


def contacts_on_a_wave(number: int) -> tuple[dict, dict, dict]:
    """Return keywords of a slider on 1 to 150 contacts at their places, of the wave below it, and of the question.

    Pillars or balls on a grid or at random places; heights, curvature, weights, own stiffnesses; held, free to tilt or
    on a soft backing; waves from one or both sides that the contacts load or not.
    """
    rng = np.random.default_rng([4502, number])
    across = int(rng.integers(1, 6))
    along = int(rng.integers(1, 31)) if across == 1 else int(rng.integers(2, 31))
    frequency = 10.0 ** rng.uniform(6.0, 7.3)
    wavelength = 3900.0 / frequency
    pitch = wavelength * 10.0 ** rng.uniform(-1.5, 0.3)
    x, y = (each.ravel() for each in np.meshgrid(np.arange(along) * pitch, np.arange(across) * pitch))
    if rng.random() < 0.3:
        x, y = rng.uniform(0.0, along * pitch, x.size), rng.uniform(0.0, across * pitch, x.size)
    x, y, n = x - x.mean(), y - y.mean(), x.size
    punch, friction = rng.random() < 0.75, rng.uniform(0.05, 0.4)
    power = 1.0 if punch else 1.5
    normal = 10.0 ** rng.uniform(5.5, 7.0) if punch else 4.0 / 3.0 * 64e9 * math.sqrt(10.0 ** rng.uniform(-4.3, -3.0))
    amplitude = 10.0 ** rng.uniform(-8.7, -7.3)
    depth = amplitude * 10.0 ** rng.uniform(-1.2, 0.3)
    weights = rng.integers(1, 6, n).astype(float) if rng.random() < 0.2 else 1.0
    tangential = normal * rng.uniform(0.4, 1.1)
    if rng.random() < 0.2:
        normal, tangential = normal * rng.uniform(0.6, 1.4, n), tangential * rng.uniform(0.6, 1.4, n)
    body = {
        "x": x, "y": y, "normal_stiffness": normal, "tangential_stiffness": tangential, "weights": weights,
        "heights": rng.normal(scale=depth * 10.0 ** rng.uniform(-1.0, 0.3), size=n) if rng.random() < 0.6 else 0.0,
        "friction_coefficient": friction, "preload": float(np.sum(weights * normal * np.ones(n))) * depth**power,
        "tangential_damping": 0.0, "shape": "punch" if punch else "sphere",
    }  # fmt: skip
    if rng.random() < 0.2:
        body["tangential_damping"] = 0.1 * friction * body["preload"] / (2.0 * math.pi * frequency * amplitude)
    holds = rng.random()
    if holds < 0.2 and along > 1:
        body["tilt"] = "pitch"
    elif holds < 0.4 and along > 1 and across > 2:
        body["tilt"] = "free"
    elif holds < 0.5:
        body["backing"] = "soft"
    if "tilt" in body:
        body["preload_at"] = (0.1 * rng.uniform(-1.0, 1.0) * np.ptp(x), 0.05 * rng.uniform(-1.0, 1.0) * np.ptp(y))
        body["load_height"] = float(rng.choice([0.0, rng.uniform(-0.1, 0.1) * np.ptp(x)]))
    if rng.random() < 0.2 and np.ptp(x) > 0.0:
        body["curvature"] = depth * rng.uniform(-1.0, 4.0) / np.ptp(x) ** 2
    wave = {
        "frequency": frequency, "wavelength": wavelength, "ratio": rng.uniform(0.6, 1.0), "forward": amplitude,
        "backward": complex(amplitude * rng.choice([0.0, 0.5, 1.3]) * np.exp(2j * np.pi * rng.random())),
        "compliance": float(rng.choice([0.0, 2.5e-12, 2.5e-12, 5e-12])),
        "strip_width": max(np.ptp(y) + pitch, wavelength),
    }  # fmt: skip
    if rng.random() < 0.15:
        wave["ratio"] = complex(wave["ratio"] * np.exp(0.2j * rng.uniform(-1.0, 1.0)))
    load = float(rng.choice([0.0, rng.uniform(0.0, 0.3)])) * friction * body["preload"]
    loading = bool(rng.random() < 0.6) and wave["compliance"] > 0.0
    plain = body.get("backing") != "soft" and punch
    question = {"load": load, "loading": "harmonics" if loading and plain and number % 10 == 0 else loading}
    return body, wave, question
