"""Earlier names of sliders on pillars: functions that return a `Slider`, or results under the names of then.

Nothing in the packages uses them. In place of `Pillars(...)` write `Slider(...)` with positions and stiffnesses, in
place of `pillar_motion` and `pillar_load_line` `steady` and `load_line` on a `PassingWave`.
"""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from contact import parameter_check
from contact.answers.load_and_stall import load_line
from contact.answers.steady import steady
from contact.averaged.coupled_motion import CoupledSearch
from contact.passing_wave import PassingWave
from contact.slider import Slider

STILL: dict[str, Any] = {
    "mass": math.inf, "load": 0.0, "law": "elastic", "reciprocal": False, "stick_band": 0.0, "contact_damping": 0.0,
    "normal_damping": 0.0, "tangential_damping": 0.0,
}  # fmt: skip
TOLERANCE = 1.0  # of `steady`; the results of then had no status


class Renamed:
    """A result with further names for its attributes, and those of the parts that it is made of."""

    def __init__(self, found, *parts, **names):
        self.found, self._parts, self._names = found, (found, *parts), names

    def __getattr__(self, name):
        if name in self._names:
            return self._names[name]
        for part in self._parts:
            if hasattr(type(part), name) or name in vars(part):
                return getattr(part, name)
        raise AttributeError(name)


def Pillars(*, x, y, preload, friction_coefficient, shape="punch", **given) -> Slider:
    """Return a slider of infinite mass on contacts with their own places; the keywords are those of `Slider`.

    Examples
    --------
    >>> slider = Pillars(
    ...     x=[-1e-4, 0.0, 2e-4], y=[0.0, 0.0, 0.0], normal_stiffness=1.8e6, tangential_stiffness=1.52e6,
    ...     friction_coefficient=0.18, preload=9e-3,
    ... )
    >>> slider.number
    3.0
    """
    for name, value, unit in (("preload", preload, "N"), ("friction_coefficient", friction_coefficient, "")):
        parameter_check.positive(f"slider.{name}", value, unit)
    own: dict[str, Any] = {"x": np.atleast_1d(np.asarray(x, dtype=float)), "y": y, "shape": shape}
    return Slider(**STILL | own | given, preload=preload, friction_coefficient=friction_coefficient)


def balls_of(slider: Slider, x, y=0.0, *, radius=None, weights=1.0) -> Slider:
    """Return the contacts of a `Slider` at their own positions in m, of infinite mass and without its load.

    Examples
    --------
    >>> from contact import Orbit, Slider
    >>> slider = Slider(
    ...     radius=1e-3, mass=8.9e-5, preload=8.7e-4, load=0.0, friction_coefficient=0.08, effective_modulus=64e9,
    ...     tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0,
    ...     normal_damping=0.5, tangential_damping=1e-4,
    ... )
    >>> float(balls_of(slider, x=[0.0, 1e-3], radius=[1e-3, 4e-3]).normal_stiffness @ [-0.5, 0.25])
    0.0
    """
    slider.refuse_other_laws()
    place = {"x": np.atleast_1d(np.asarray(x, dtype=float)), "y": y, "weights": weights}
    given = {"radius": slider.radius if radius is None else radius, "mass": math.inf, "load": 0.0}
    return replace(slider, **place, **given, contact_damping=0.0, normal_damping=0.0)


def pillar_motion(pillars: Slider, wave: PassingWave, *, load: float = 0.0, loading=None, near=None) -> Renamed:
    """Return the `steady` state of a slider under a load in N, on a wave with this `loading`; ``near``: as for it.

    Examples
    --------
    Ten thousand pillars of 20 um on 5 mm x 5 mm:

    >>> x, y = (each.ravel() for each in np.meshgrid(np.arange(100) * 50e-6 - 2.475e-3, np.arange(100) * 50e-6))
    >>> slider = Pillars(
    ...     x=x, y=y, normal_stiffness=1.8e6, tangential_stiffness=1.52e6, friction_coefficient=0.18, preload=30.0
    ... )
    >>> wave = PassingWave(
    ...     frequency=9.61e6, wavelength=414.05e-6, ratio=0.88995, forward=20e-9,
    ...     compliance=2.5078e-12, strip_width=5e-3,
    ... )
    >>> round(pillar_motion(slider, wave, loading=False).velocity, 8)
    -0.92621972
    >>> loaded = pillar_motion(slider, wave)
    >>> bool(abs(loaded.ledger_residual) < 1e-12)
    True
    """
    start = None if near is None else near.found
    body, passing = replace(pillars, load=load, mass=math.inf), replace(wave, loading=loading)
    return _motion(steady(body, passing, tolerance=TOLERANCE, near=start), pillars, wave)


def _motion(state, pillars, wave):
    rows, forces, scale = state.loaded, state.loaded.forces, state.orbits.peak_speed / 10.0
    return Renamed(
        state, rows, approach=state.height, pillars=pillars, wave=wave, held=state.regime == "stick",
        wave_work=sum(rows.work), normal_force=forces.normal, first_normal=forces.first_normal,
        first_tangential=forces.first_tangential, speed_scale=max(abs(state.velocity), scale, 1e-300),
    )  # fmt: skip


def pillar_load_line(pillars: Slider, wave: PassingWave, *, points: int = 20, loading=None) -> Renamed:
    """Return the `load_line` of a slider on a wave with this `loading`; its velocities are along +x."""
    body, passing = replace(pillars, mass=math.inf), replace(wave, loading=loading)
    line = load_line(body, passing, points=points, tolerance=TOLERANCE)
    sign = math.copysign(1.0, line.states[0].velocity)
    motions = tuple(_motion(state, pillars, wave) for state in line.states)
    return Renamed(line, stall=line.stall.value, velocity=sign * line.velocity, motions=motions)


def pillar_traction(pillars: Slider, wave: PassingWave, *, load: float = 0.0, loading=None, near=None):
    """Return a function traction(velocity in m/s, factor on the wave) that gives the mean tangential force in N."""
    rows = None if near is None else near.found.loaded
    passing = replace(wave, loading=loading if rows is None else rows.loading)
    search = CoupledSearch(replace(pillars, mass=math.inf), passing, 1 if rows is None else rows.harmonics, rows)
    return lambda velocity, factor=1.0: search.traction(velocity, load, factor)
