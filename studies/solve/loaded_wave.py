"""The wave below a slider that loads it, as values of a point: powers, contact ratios, ends and transducers."""

import math

import numpy as np

import contact
from studies.model.scene_errors import slider_keys
from studies.model.wave_to_contact import Contact, scaled
from studies.record.point import Point

SHOWN_OVERTONES = 7  # largest number of overtones in slider_wave.csv


def wave_state(driven: Contact, level: float, *, near=None, orbits=None, slider=None):
    """Return the averaged `contact.SteadyState` of a slider on a passing wave at a level.

    ``near``: a similar state, from which the search starts; ``orbits``, ``slider``: in place of those of the contact.
    """
    with slider_keys():
        return contact.steady(
            driven.slider if slider is None else slider, scaled(driven.orbits if orbits is None else orbits, level),
            tolerance=1.0, method="averaged", near=near,
        )  # fmt: skip


def wave_velocity(driven: Contact, level: float) -> float:
    """Return the velocity at a level in m/s without its error; NaN if the solver does not converge."""
    try:
        return wave_state(driven, level).velocity
    except contact.ConvergenceError:
        return math.nan


def wave_point(driven: Contact, state, level: float) -> Point:
    """Return the values of a point from a `contact.SteadyState` on a passing wave; empty without such a wave."""
    rows = state.loaded
    if rows is None or rows.wave.amplitude == 0.0:
        return Point()
    point = Point(
        approach_m=state.height, tilt_rad=list(state.tilt), share_in_contact=rows.share_in_contact, duty=rows.duty,
        friction_power_W=rows.friction_power, thrust_power_W=rows.thrust_power,
        exit_over_entry=rows.exit_over_entry, reflected_over_entry=rows.reflected_over_entry,
        contact_pressure_Pa=float(np.max(driven.slider.pressure(rows.deepest))),
    )  # fmt: skip
    if rows.wave.compliance > 0.0:
        point |= Point(
            wave_power_in_W=rows.wave_power_in, wave_power_out_W=rows.wave_power_out,
            loading_number=rows.loading_number, overtone_ratio=rows.overtone, harmonics=rows.harmonics,
        )  # fmt: skip
    point |= Point(ledger_relative_residual=abs(rows.ledger_residual))
    return point | _at_the_transducers(driven, rows, level)


def _at_the_transducers(body: Contact, motion, level: float) -> Point:
    """Return the effects of the loaded wave on the transducers, as values of a point.

    The first effect is the change of admittance of the driven transducer. By reciprocity, a force F on the stator
    causes the current i omega F u/V in a transducer that moves the point of the force by u at a voltage V
    (tests/fem/solve/test_forced.py). Here F are the forces of the loaded wave and u is the motion of the wave without
    the slider. The second effect is that receivers behind the slider get the wave multiplied by `exit_over_entry`.
    The wave that the transducers send back after a reflection at the slider is neglected; it is of second order.
    """
    wave, scene = motion.wave, body.scene
    if scene.stator is None or not motion.loading:
        return Point()
    backward_change, forward_change = motion.backward[0] - wave.backward, motion.forward[-1] - wave.forward
    # sum (P_1 u_z + Q_1 u_x) i Gamma/w
    reaction = wave.forward * backward_change + wave.backward * forward_change
    change = -wave.omega * wave.strip_width / wave.compliance * reaction / level**2
    direction = 1.0 if abs(wave.forward) >= abs(wave.backward) else -1.0
    centre, driven = scene.slider.center[0], scene.drive.driven
    behind = (each for each in scene.transducer if (each.center_xy[0] - centre) * direction > 0.0)
    received = motion.exit_over_entry if any(not driven.get(each.name) for each in behind) else None
    return Point(admittance_change_S=change, received_over_free=received)


def wave_tables(state) -> dict[str, dict]:
    """Return the columns of pillars.csv and of slider_wave.csv, by the name of the table; none without such a wave."""
    if state is None or state.loaded is None:
        return {}
    body, motion = state.slider, state.loaded
    of_pillars = {
        "x_m": np.array(body.x), "y_m": np.array(body.y), "height_m": np.array(body.heights),
        "normal_force_N": motion.forces.normal, "friction_power_W": motion.friction,
    }  # fmt: skip
    of_wave = {"x_m": motion.row_x, "forward_m": motion.forward, "backward_m": motion.backward}
    of_wave |= {f"overtone_{n}_m": each for n, each in enumerate(motion.overtones.T[:SHOWN_OVERTONES], start=2)}
    return {"pillars": of_pillars, "slider_wave": of_wave}
