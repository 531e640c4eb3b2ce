"""Rules of several parameters of a slider together, apart from the solvers: they also check the blocks of a scene."""

import json
from collections.abc import Iterator
from typing import Any

from contact.parameter_check import Checks


class SliderRules(Checks):
    """Rules of `contact.Slider`."""

    law: Any
    shape: str
    normal_law: Any = None
    adhesion: Any = None
    stick_band: float
    reciprocal: bool
    special_friction: Any  # what the friction depends on beside the normal force, in words; empty for Coulomb's law
    backing: str
    tilt: str
    freedom: str = "x"

    def check_law(self) -> Iterator[tuple[str, str]]:
        """Require a law, a stick band and a friction that go together."""
        if self.law == "hysteretic" and self.shape == "punch":
            yield "law", 'must be "elastic" with shape = "punch", which slips as a whole'
        if self.law == "hysteretic" and self.stick_band > 0:
            yield "stick_band", f"must be 0 with the hysteretic law, got {self.stick_band:g} m/s"
        plane = getattr(self, "freedom", "x")  # a scene without this key moves along x
        what = self.special_friction or ("" if plane == "x" else f'slider.freedom = "{plane}"')
        if not what:
            return
        special = f"with {what}"
        if self.law == "hysteretic":
            one_way = "" if plane == "x" else ': the hysteretic law has one direction: choose "elastic"'
            yield "law", f'must be "elastic" {special}{one_way}'
        elif self.reciprocal:
            yield "reciprocal", f"must be false {special}"
        elif self.stick_band > 0:
            yield "stick_band", f"must be 0 {special}"

    def check_adhesion(self) -> Iterator[tuple[str, str]]:
        """Require balls at one height with the elastic law where there is adhesion."""
        if self.adhesion is None:
            return
        if self.law == "hysteretic":
            yield "adhesion", 'has no hysteretic law: choose "elastic"'
        taken = {"shape": "sphere", "reciprocal": False, "tilt": "held", "backing": "rigid"}
        for name, only in taken.items():
            if getattr(self, name) != only:
                yield name, f"cannot be {json.dumps(getattr(self, name))} where balls attract (slider.adhesion)"

    def check_backing(self) -> Iterator[tuple[str, str]]:
        """Require a slider that is held on a soft backing."""
        if self.backing == "soft" and self.tilt != "held":
            yield (
                "tilt",
                f'must be "held" where slider.backing is "soft", which has no plane to tilt, got "{self.tilt}"',
            )

    def check_freedom(self) -> Iterator[tuple[str, str]]:
        """Require a law and a body whose motion in the plane is known."""
        plane = getattr(self, "freedom", "x")
        where = f'with slider.freedom = "{plane}"'
        if plane != "x" and self.special_friction:
            yield "friction", f"must be a number {where}"
        for name in ("normal_law", "adhesion") if plane != "x" else ():
            if getattr(self, name) is not None:
                yield name, f"must be left out {where}: the contacts are smooth and dry there"
        if plane != "x" and self.backing == "soft":
            yield "backing", f'must be "rigid" {where}'
        if plane != "x" and self.tilt == "pitch":
            yield "tilt", f'must be "held" or "free" {where}'


class AdhesionRules(Checks):
    """Rules of `contact.Adhesion`."""

    model: str
    work: float | None
    surface_tension: float | None
    contact_angle: float

    def check_model(self) -> Iterator[tuple[str, str]]:
        """Require the numbers of the model, and no others."""
        wet = self.model == "meniscus"
        needs, others = ("surface_tension", ("work",)) if wet else ("work", ("surface_tension", "contact_angle"))
        if getattr(self, needs) is None:
            yield needs, f'is required and missing: the model is "{self.model}"'
        others = (*others, *(["separation"] if self.model != "Maugis" else []))
        for other in others:
            if getattr(self, other, None):
                yield other, f'must be left out: the model is "{self.model}"'


class FrictionRules(Checks):
    """Rules of `contact.FallingFriction`."""

    sliding: float | None
    speed: float | None
    high_pressure: float | None
    pressure: float | None

    def check_pairs(self) -> Iterator[tuple[str, str]]:
        """Require both parameters of a dependence, and one dependence at least."""
        for one, other in (("sliding", "speed"), ("high_pressure", "pressure")):
            for present, missing in ((one, other), (other, one)):
                if getattr(self, present) is not None and getattr(self, missing) is None:
                    yield missing, f"is required and missing: {present} is given"
        if self.sliding is None and self.high_pressure is None and self.speed is None and self.pressure is None:
            yield "", "needs sliding with speed, or high_pressure with pressure; without them a friction is a number"
