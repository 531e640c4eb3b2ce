"""The seed's motor and its wave, for the tests of the contact."""

from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from contact import Orbit, Slider, steady_sweep
from tests.oracles.contact_friction import Motor
from tests.oracles.contact_stop import StopMotor
from tests.seed_motor import FREQUENCY, SLIDER

HEAVY = 1e4  # kg: a slider that does not move within a cycle, (f_n/f)^2 = 2e-13, as the averaged theory takes it


def slider(**changed) -> Slider:
    """Return the seed's slider with one ball, some parameters changed."""
    return Slider(**(SLIDER | changed))


def orbit(amplitude: float, ratio: float = 0.7, frequency: float = FREQUENCY) -> Orbit:
    """Return the seed's orbit: quadrature, at the crest towards +x."""
    return Orbit(frequency=frequency, normal=amplitude, tangential=-1j * ratio * amplitude)


def steady_map(slider: Slider, orbits, *, factors, preloads, threads=None):
    """Return the averaged steady states over preloads (first axis) and factors on the orbits."""
    waves = [(orbits,) if isinstance(orbits, Orbit) else orbits]
    which = np.stack([*np.indices((len(preloads), 1))], axis=-1).repeat(len(factors), axis=1)
    return steady_sweep(
        [replace(slider, preload=float(preload)) for preload in preloads], waves, which=which,
        factors=np.tile(factors, (len(preloads), 1)), wave_errors=[0.0], threads=threads,
    )  # fmt: skip


def friction_motor(friction, coefficient, shape="sphere"):
    """Return two unequal contacts and their waves, and the same for the oracle with mu = `coefficient`(p, w)."""
    own = {"radius": 5e-6} if shape == "punch" else {}
    amplitudes, phases, heights = (4e-9, 3e-9), (0.0, 1.1), (0.0, 0.4e-9)
    s = slider(friction_coefficient=0.3, friction=friction, shape=shape, heights=heights, **own)
    waves = tuple(
        Orbit(frequency=FREQUENCY, normal=-1j * a * np.exp(1j * p), tangential=-0.7 * a * np.exp(1j * p))
        for a, p in zip(amplitudes, phases, strict=True)
    )
    same = Motor(mu=coefficient, amplitudes=amplitudes, phases=phases, heights=heights, punch=shape == "punch", **own)
    return s, waves, same


def way_to_rest(approaches, deformations, c, power=1.5, load=0.0) -> float:
    """Return the d at which springs of deformations x - d carry a load over mu K: z^p - (z - |x - d|/c)^p, in sum."""
    z = np.maximum(approaches, 0.0)

    def left(d):
        x = deformations - d
        return float(np.sum(np.sign(x) * (z**power - np.maximum(z - abs(x) / c, 0.0) ** power))) - load

    return brentq(left, -1e-6, 1e-6, xtol=1e-24, rtol=1e-15)


def stop_motor(slider: Slider, orbits, **changed) -> StopMotor:
    """Return the same slider for the oracle without events; its load acts along -x unless changed."""
    return StopMotor(**({
        "mass": slider.mass, "preload": slider.preload, "mu": slider.friction_coefficient, "load": slider.load,
        "frequency": orbits[0].frequency, "normal": tuple(each.normal for each in orbits),
        "tangential": tuple(each.tangential for each in orbits), "radii": (slider.radius,) * len(orbits),
        "E": slider.effective_modulus, "G": slider.tangential_modulus, "chi": slider.contact_damping,
        "normal_damping": slider.normal_damping, "tangential_damping": slider.tangential_damping,
        "punch": slider.shape == "punch", "band": slider.stick_band, "heights": slider.heights,
    } | changed))  # fmt: skip
