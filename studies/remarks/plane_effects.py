"""Estimates of what motion in the plane leaves out, and motion along x of the plane, as fields of `blocks.Effect`.

Sources:

- spin of a contact: the moment of a Hertz contact that slips about its own normal is (3 pi/16) mu P a (K. L. Johnson,
  Contact Mechanics, 1985, section 4.2 with q = mu p; P. Contensou, Kreiselprobleme, 1963);
- motion across the wave: a contact that slips along x while the surface also moves across loses a part of its force,
  of second order in u_y/u_x.
"""

import math

import numpy as np

from studies.model.wave_to_contact import contact_slider
from studies.record import Record
from studies.remarks.stator_effects import Effects
from studies.scene.plane_keys import AXLE

SPIN = 3.0 * math.pi / 16.0
# Loss of velocity over (u_y/u_x)^2 at the contact with the most, of three balls of which two have u_y in step with u_x
# and of opposite signs, as in a beam that spreads: 2.4 to 4.9 for 3 to 15 nm and u_y/u_x of 0.03 to 0.1; a quarter of
# a period apart a gain of 0.4 to 0.6 (tests/studies/test_plane.py)
ACROSS = 3.0
NONE_ACROSS = 1e-3  # u_y/u_x that changes 3e-6 of the velocity: rounding on the axis of a beam is 1e-13
ACROSS_NAME = "motion of the surface across the wave, u_y"


def spin(record: Record) -> Effects:
    """Yield the moment of contacts that turn about their own normals, over that of their forces."""
    slider = record.scene.slider
    if slider is None or not slider.turns or slider.shape != "sphere" or not slider.preload_force > 0.0:
        return
    body = contact_slider(slider.along_x)
    radius = float(np.max(body.contact_radius(body.rest_approaches(slider.computed_contacts))))
    x, y = (slider.axis or (0.0, 0.0)) if slider.freedom == AXLE else (0.0, 0.0)
    arm = float(np.mean([math.hypot(a - x, b - y) for a, b in slider.offsets]))
    how = "(3 pi/16) mu P a over mu P b: Contensou's moment of full spin, which slip of the whole contact reduces"
    yield "spin of the contacts about their normals", "the torque of the contacts", SPIN * radius / arm, how


def across(record: Record) -> Effects:
    """Yield what u_y takes from the velocity of a slider that moves along x alone."""
    ratio, scene = record.wave.largest_lateral_ratio or 0.0, record.scene
    if scene.slider is None or scene.planar or scene.on_pillars or ratio < NONE_ACROSS:
        return
    if any(point.velocity_m_per_s for point in record.points):
        how = 'three balls on one beam, in proportion to (u_y/u_x)^2; slider.freedom = "xy" computes it'
        yield ACROSS_NAME, "velocity", -min(ACROSS * ratio**2, 1.0), how
