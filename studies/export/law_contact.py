"""Contacts of a scene whose mean forces the exports take from `contact.HeldMeans`: rough balls, adhesion that holds on.

Their steady velocities are those of a slider that is heavy on the time scale of the wave.
"""

from dataclasses import dataclass, field
from typing import Any

import contact
from studies.export.law_grid import BEYOND, MOST_PRELOAD, LawGrid, Nodes
from studies.model.balls import slider_of
from studies.model.roughness_of_balls import contact_body, largest_amplitude, realised_rms, rough_balls
from studies.model.scene_errors import slider_keys
from studies.model.wave_to_contact import Contact
from studies.solve.heavy_limits import heavy_limits

TOLERANCE = 1e-4  # of the steady velocities with which tables are compared
REACH = 4.0  # standard deviations by which the approach of rough balls exceeds that of smooth ones, at most
ROUGH = Nodes(depths=17, closed=41, open=25, columns=61)
STOPS = Nodes(depths=13, closed=15, open=15, columns=25)  # of asperities with a stop each, 1.6 ms a force
# Steady velocities on 20 waves of twente-contact err by 0.3 % (JKR, 0.05 J/m^2) and 0.1 % (Maugis); with half as many
# rows `closed` by 2.3 and 1.5 %, with two thirds of the depths by 0.8 and 0.1 %.
HOLDING = Nodes(depths=22, closed=121, open=15, columns=71, fastest=1.05)


@dataclass(frozen=True, kw_only=True)
class LawContact:
    """Balls of one scene, as one of `share` equal parts."""

    slider: contact.Slider
    share: int
    means: Any = field(repr=False)  # contact.HeldMeans
    balls: Any = field(repr=False)  # contact.RoughBalls or contact.AdhesiveBalls
    nodes: Nodes
    driven: Contact = field(repr=False)
    each: int  # orbits of the scene repeat so often, one for each ball

    @classmethod
    def of(cls, driven: Contact) -> "LawContact | None":
        """Return the balls of a scene; None of smooth ones without adhesion that holds on."""
        block = driven.scene.slider
        if not driven.heavy:
            return None
        if driven.rough:
            amplitude = largest_amplitude(driven.scene.levels, driven.orbits)
            with slider_keys():
                own = rough_balls(block, amplitude)[0]
                smooth = contact_body(block).rest_approach(len(block.offsets))
                deepest = MOST_PRELOAD * smooth + REACH * realised_rms(block.roughness) + BEYOND * amplitude
                means = contact.RoughMeans(own, deepest)
            sampled = block.roughness.sampled
            nodes = STOPS if sampled and block.law == "elastic" else ROUGH
            share, each = (1, block.share) if sampled else (block.share, 1)
            return cls(slider=own.slider, share=share, means=means, balls=own, nodes=nodes, each=each, driven=driven)
        with slider_keys():
            balls = contact.holding_balls(slider_of(block))
        return cls(
            slider=balls.slider, share=block.share, means=contact.AdhesiveMeans(balls), balls=balls, nodes=HOLDING,
            each=1, driven=driven,
        )  # fmt: skip

    def grid(self, count: int, amplitude: float) -> LawGrid:
        """Return the nodes of tables for so many orbits, up to an amplitude in m."""
        return LawGrid.of(
            self.means, self.nodes, count=count, preload=self.slider.preload, amplitude=amplitude,
            holds=isinstance(self.balls, contact.AdhesiveBalls),
        )  # fmt: skip

    @property
    def threshold(self) -> float:
        """Level at which the slider starts to move, that of a run."""
        return float(heavy_limits(self.driven)[0])

    def velocity(self, orbits: tuple) -> float:
        """Return the steady velocity in m/s that a run has."""
        motion = self.balls.motion(orbits, tolerance=TOLERANCE)
        answer = motion.velocity if isinstance(self.balls, contact.AdhesiveBalls) else motion.answer
        return float(answer.value)
