"""A slider in the plane, seen from above: its body, its contacts and their velocities on a map of the surface."""

import math
from dataclasses import dataclass

import numpy as np

from studies.record.plots import COLOURS, arrow
from studies.record.point import Point
from studies.record.quantities import quantity
from studies.record.run_pictures import velocity
from studies.scene import Scene
from studies.scene.plane_keys import AXLE

ARROW = 0.6  # length of the longest arrow over the distance of the farthest contact from the middle of all
NARROW = 4e-3  # m: that distance where all contacts are at one place
MOVES = 1e-6  # m/s: a contact that is slower has no arrow


@dataclass(frozen=True)
class Together:
    """Beams of several frequencies on one surface, whose sizes are added as powers are."""

    beams: tuple

    @property
    def wave(self):
        """The section wave of the first beam."""
        return self.beams[0].wave

    @property
    def rows(self):
        """Groups of transducers of the first beam, which has those of all."""
        return self.beams[0].rows

    @property
    def pictured(self):
        """The same beams for a picture."""
        return Together(tuple(each.pictured for each in self.beams))

    def motion(self, x, y):
        """Return the root of the sum of the squared sizes of u_x, u_y and u_z at points (x, y) in m, m per V."""
        return np.sqrt(sum(np.abs(each.motion(x, y)) ** 2 for each in self.beams))


def contact_velocities(scene: Scene, point: Point) -> np.ndarray:
    """Return the velocities (n, 2) in m/s of the contacts of a slider at a point of a run."""
    slider, rate = scene.slider, point.yaw_rate_rad_per_s or 0.0
    places = np.array(slider.offsets[: slider.computed_contacts])
    about = np.array(slider.axis) if slider.freedom == AXLE else np.zeros(2)
    base = np.zeros(2)
    if slider.freedom != AXLE:
        base = np.array([point.velocity_m_per_s or 0.0, point.lateral_velocity_m_per_s or 0.0])
    arms = places - about
    return base + rate * np.stack([-arms[:, 1], arms[:, 0]], axis=1)


def draw_body(ax, scene: Scene, point: Point) -> str:
    """Draw the body, its contacts and the arrow of each one's velocity; return what the arrows are, for the title."""
    scale, orange = quantity.x_m.scale, COLOURS["intermittent"]
    places = np.array(scene.slider.contact_positions)
    middle = places.mean(axis=0)
    order = np.argsort(np.arctan2(*(places - middle).T[::-1]))
    ax.fill(*(places[order] * scale).T, facecolor=orange, edgecolor="white", alpha=0.35, linewidth=1.0)
    velocities = contact_velocities(scene, point)
    speeds = np.hypot(*velocities.T)
    reach = float(np.hypot(*(places - middle).T).max()) or NARROW
    if speeds.max() > MOVES:
        for place, velocity, speed in zip(places, velocities, speeds, strict=False):
            if speed > MOVES:
                head = place + ARROW * reach * velocity / speeds.max()
                arrow(ax, place * scale, head * scale, COLOURS["line"], width=2.0)
    if scene.slider.freedom == AXLE:
        axle = (np.array(scene.slider.center) + scene.slider.axis) * scale
        ax.plot(*axle, "+", color="white", markersize=10, markeredgewidth=2.0)
    return f"; arrows: velocities of the contacts at {scene.named(point.level)}, {_motion(scene, point)}"


def _motion(scene: Scene, point: Point) -> str:
    """Return the slider's motion in words."""
    turning = ""
    if scene.slider.turns and point.rotation_rpm is not None:
        turning = f"{quantity.rotation_rpm.with_unit(point.rotation_rpm)}"
    if scene.slider.freedom == AXLE:
        return turning
    speed = math.hypot(point.velocity_m_per_s or 0.0, point.lateral_velocity_m_per_s or 0.0)
    return f"{quantity.velocity_m_per_s.with_unit(speed)}{', ' + turning if turning else ''}"


def drawings_of_sheet(sheet) -> dict:
    """Return the functions that draw a datasheet's pictures on an Axes, by caption."""
    return {"speed against drive": lambda sheet, ax: velocity(sheet.record, ax)}
