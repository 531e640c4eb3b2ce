"""The averaged motor in the plane as C99, motor.c with its tables and motor.h, and the variables of its FMU."""

import re

from studies.export import reduced_plane
from studies.export.c_source import comment_safe, generated, source_text, token
from studies.export.fmu import FmuModel, Variable
from studies.export.planar_motor import PlanarMotor

FREE = {  # of x, y and yaw
    "xy": (True, True, False),
    "xy yaw": (True, True, True),
    "axle": (False, False, True),
}
DIRECTIONS = ("x", "y", "yaw")


def planar_model(motor: PlanarMotor) -> FmuModel:
    """Return what an FMU of a motor in the plane is made of."""
    return FmuModel(
        title=motor.title, lines=tuple(planar_description(motor)), token=token(motor),
        sources={
            "motor.c": planar_source(motor), "motor.h": planar_header(motor),
            "fmu_variables.c": source_text("plane_variables.c"),
        },
        variables=tuple(variables(motor)),
    )  # fmt: skip


def variables(motor: PlanarMotor):
    """Yield the variables of the FMU; value references are those of plane_variables.c."""
    moves, free = FREE[motor.freedom][0], FREE[motor.freedom]
    units, rates = ("m", "m", "rad"), ("m/s", "m/s", "rad/s")
    names = drive_names(motor)
    for k, (name, source) in enumerate(zip(names, motor.drives, strict=True)):
        meaning = f"peak level of {source}, zero or positive"
        yield Variable(1 + k, name, "input", "continuous", motor.unit, 0.0, meaning)
    for k, direction in enumerate("xy" if moves else ""):
        meaning = f"external force on the slider along +{direction}"
        yield Variable(3 + k, f"force_{direction}", "input", "continuous", "N", motor.load[k], meaning)
    if free[2]:
        meaning = "external torque on the slider, positive from x to y"
        yield Variable(5, "torque", "input", "continuous", "N.m", motor.load[2], meaning)
    meaning = "normal force that holds the slider down, positive"
    yield Variable(6, "preload", "input", "continuous", "N", motor.preload, meaning)
    for k, direction in enumerate(DIRECTIONS):
        if free[k]:
            meaning = "rotation of the slider, from x to y" if k == 2 else f"of the slider along {direction}"
            yield Variable(7 + k, direction, "output", "continuous", units[k], None, meaning)
    for k, name in enumerate(("velocity_x", "velocity_y", "yaw_rate")):
        if free[k]:
            yield Variable(10 + k, name, "output", "continuous", rates[k], None, "of the slider")
    if not moves:
        yield Variable(13, "rotation", "output", "continuous", "rpm", None, "of the rotor")
    for k, name in enumerate(names):
        meaning = f"largest normal amplitude under the contacts, peak, by {motor.drives[k]}"
        yield Variable(14 + k, f"surface_amplitude{name[5:]}", "output", "continuous", "m", None, meaning)
    for k, direction in enumerate("xy" if moves else ""):
        meaning = f"mean force of the surface on the slider along +{direction}"
        yield Variable(16 + k, f"tangential_force_{direction}", "local", "continuous", "N", None, meaning)
    if free[2]:
        yield Variable(18, "moment", "local", "continuous", "N.m", None, "mean, of the surface on the slider")
    yield Variable(19, "sticks", "local", "discrete", "", None, "friction holds the slider")


def drive_names(motor: PlanarMotor) -> list[str]:
    """Return the names of the inputs of the drives."""
    if len(motor.drives) == 1:
        return ["drive"]
    return [f"drive_{re.sub(r'[^A-Za-z0-9]+', '_', name)}" for name in motor.drives]


def planar_header(motor: PlanarMotor) -> str:
    """Return motor.h."""
    x, y, torque = motor.load
    constants = {
        "STATE_SIZE": motor.state_size, "DRIVES": len(motor.drives), "LEVEL_UNIT": f'"{motor.unit}"',
        "INPUTS": f"{{{{0.0, 0.0}}, {{{x!r}, {y!r}}}, {torque!r}, {motor.preload!r}}} /* those of the scene */",
        "REACH": f'"{comment_safe(motor.reach_in_words)}"', "TOKEN": f'"{token(motor)}"',
    }  # fmt: skip
    lines = [f"/* {comment_safe(line)} */" for line in planar_description(motor)]
    lines += [f"#define SAWMOTOR_{name} {value}" for name, value in constants.items()]
    return source_text("plane.h").replace("/* PARAMETERS */", "\n".join(lines))


def planar_source(motor: PlanarMotor) -> str:
    """Return motor.c."""
    return generated(motor, reduced_plane, "plane_api.c", "The averaged motor in the plane")


def planar_description(motor: PlanarMotor) -> list[str]:
    """Return title, drives, errors and neglected effects of a motor, one line each."""
    made = zip(drive_names(motor), motor.drives, motor.amplitudes, strict=True)
    drives = "; ".join(f"{name} is the level of {source}, {size:.6g} m per {motor.unit}" for name, source, size in made)
    return [
        motor.title,
        f"drives: {drives} of the largest u_z under the contacts (peak)",
        *([f"the tables reach up to {motor.reach_in_words}"] if motor.limits else []),
        "mean force: error over mu preload {:.1e}, at kinks {:.1e}".format(*reversed(motor.force_error)),
        f"steady motion: this error changes it by up to {motor.velocity_error:.1e}, averaging by "
        f"{motor.averaging_error:.1e}",
        *motor.left_out,
    ]
