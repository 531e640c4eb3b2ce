"""A motor for other simulators: an FMU, C with a header, or its tables as CSV.

The burst of a scene with a waveform goes with them as a table of the input ``drive`` over time.
"""

from collections.abc import Sequence

import numpy as np

from studies.export.averaged_motor import averaged_motor
from studies.export.c_source import description, header, source
from studies.export.exported import Exported
from studies.export.fmu import FMI_VERSIONS, FmuModel, fmu, fmu_of
from studies.export.force_grid import COLUMNS, ROWS
from studies.export.law_grid import places
from studies.export.motor_model import AveragedMotor, force_exponent
from studies.export.reduced_motor import index
from studies.export.reduced_motor.force_tables import EDGE
from studies.record.waveform import instants, modulation
from studies.refusal import refuse_other
from studies.scene import Scene


def fmu_files(scene: Scene, name: str, *, fmi: str = "3", tolerance: float) -> Exported:
    """Return NAME.fmu of a scene with a slider; ``fmi``: "3" or "2"."""
    refuse_other(fmi, FMI_VERSIONS, "--fmi")
    drive_input(scene, name)  # refuses a waveform before anything is computed
    if scene.planar:
        model = _planar(scene, tolerance)
        inputs = drive_input(scene, name, _drives(model))
        content, remark = fmu_of(model, fmi)
        files = inputs | {f"{name}.fmu": content}
        return Exported(files=files, answer=_lines(model.lines), remarks=(remark,) * bool(remark))
    inputs = drive_input(scene, name)
    motor = averaged_motor(scene, tolerance=tolerance)
    content, remark = fmu(motor, fmi)
    return Exported(files=inputs | {f"{name}.fmu": content}, answer=_answer(motor), remarks=(remark,) * bool(remark))


def c_files(scene: Scene, name: str, *, tolerance: float) -> Exported:
    """Return motor.c and motor.h of a scene with a slider."""
    drive_input(scene, name)  # refuses a waveform before anything is computed
    if scene.planar:
        model = _planar(scene, tolerance)
        files = drive_input(scene, name, _drives(model))
        files |= {file: model.sources[file] for file in ("motor.c", "motor.h")}
        return Exported(files=files, answer=_lines(model.lines))
    inputs = drive_input(scene, name)
    motor = averaged_motor(scene, tolerance=tolerance)
    return Exported(files=inputs | {"motor.c": source(motor), "motor.h": header(motor)}, answer=_answer(motor))


def drive_input(scene: Scene, name: str, drives: Sequence[str] = ("drive",)) -> dict[str, bytes | str]:
    """Return the inputs of the drives over time of a scene with a waveform, at its largest level, as NAME.drive.csv.

    Raises
    ------
    SceneError
        If the waveform changes phase or frequency, which the averaged motor does not take.
    """
    shape = modulation(scene) if scene.source is not None and scene.source.waveform is not None else None
    if shape is None:
        return {}
    if shape.turns:
        rule = "must keep phase and frequency here: the averaged motor takes amplitudes, sawmotor run takes both"
        scene.refuse(f"{scene.source.block}.waveform", rule)
    duration, level = scene.burst, max(scene.levels)
    time = instants(shape.envelope, duration)
    drive = level * abs(shape.envelope.at(time))
    column = np.append(drive, 0.0)  # a step down at the burst's end
    rows = np.column_stack([np.append(time, duration), *[column] * len(drives)])
    return {f"{name}.drive.csv": ",".join(("time", *drives)) + "\n" + _rows(rows)}


def tables(motor: AveragedMotor) -> dict[str, str]:
    """Return the tables of a motor (`studies.export.reduced_motor`) as CSV text by file name."""
    head = "".join(f"# {line}\n" for line in description(motor))
    tau = np.linspace(0.0, 1.0, ROWS)
    nu = np.linspace(0.0, 1.0, COLUMNS) ** 2
    slider, files = motor.slider, {}
    if motor.parameters[index.DEPTHS] > 0.5:
        return _tables_of_depths(motor, head)
    for number, drive in enumerate(motor.drives):
        start = motor.parameters[index.FIRST_DRIVE + number * index.DRIVE_SIZE :].astype(int)
        loads = motor.tables[start[index.LOADS] :][:ROWS]
        forces = motor.tables[start[index.FORCES] :][: 2 * ROWS * COLUMNS].reshape(2, ROWS, COLUMNS)
        if start[index.FACING] < 0:
            forces = -forces[::-1]
        drive_head = head + (
            f"# drive {drive.name}: s = {drive.amplitude!r} m per {motor.unit}, v_1 = {drive.saturation(slider)!r} "
            "(m/s)/m\n# tau = sqrt(s)/(sqrt(s) + sqrt(h + s)), nu = V/(v_1 s), <P> = n K (h + s)^e R, Q = mu <P> g\n"
            f"# n K = {slider.normal_stiffness * len(drive.orbits) * motor.share!r} N/m^e, "
            f"e = {force_exponent(slider)}, mu = {slider.friction_coefficient!r}\n"
        )
        label = drive.name.replace(" ", "_")
        files[f"mean_load_{label}.csv"] = drive_head + "tau,R\n" + _rows(np.column_stack([tau, loads]))
        both_sides = np.hstack([forces[0, :, :0:-1], forces[1, :, 1:]])
        limits = np.column_stack([forces[0, :, 0], forces[1, :, 0]])
        signed = np.concatenate([-nu[:0:-1], nu[1:]])
        columns = ",".join(["tau", "g_at_0_from_below", "g_at_0_from_above", *(f"g_at_nu={v:.8g}" for v in signed)])
        files[f"mean_force_{label}.csv"] = (
            drive_head + columns + "\n" + _rows(np.column_stack([tau, limits, both_sides]))
        )
        files |= _response_table(drive, drive_head, label)
    return files


def _tables_of_depths(motor: AveragedMotor, head: str) -> dict[str, str]:
    """Return the tables of contacts whose force is no power of the approach; see `tables`."""
    p, files = motor.parameters, {}
    depths, rows, split, columns = (
        int(p[each]) for each in (index.DEPTHS, index.TAU_NODES, index.SPLIT, index.NU_NODES)
    )
    t = np.linspace(0.0, 1.0, split), np.linspace(0.0, 1.0, rows - split)
    tau = np.concatenate([EDGE * (1.0 - (1.0 - t[0]) ** 2), EDGE + (1.0 - EDGE) * t[1] ** 2])
    crest = places(depths, float(p[index.DEEPEST]), float(p[index.FORCE_SCALE]))
    z, taus = (each.ravel() for each in np.meshgrid(crest, tau, indexing="ij"))
    nu = (p[index.FASTEST] * np.linspace(0.0, 1.0, columns)) ** 2
    nodes = int(p[index.FORCE_NODES])
    at_rest = places(nodes, float(p[index.DEEPEST]), float(p[index.FORCE_SCALE]))
    force = motor.tables[int(p[index.FORCE_TABLE]) :][:nodes] ** p[index.EXPONENT]
    for number, drive in enumerate(motor.drives):
        start = p[index.FIRST_DRIVE + number * index.DRIVE_SIZE :].astype(int)
        size = depths * rows
        shares = [motor.tables[start[index.LOADS] :][:size]]
        if start[index.PULLS] >= 0:
            shares.append(motor.tables[start[index.PULLS] :][:size])
        forces = motor.tables[start[index.FORCES] :][: 2 * size * columns].reshape(2, size, columns)
        if start[index.FACING] < 0:
            forces = -forces[::-1]
        drive_head = head + (
            f"# drive {drive.name}: s = {drive.amplitude!r} m per {motor.unit}, "
            f"v_1 = {float(drive.saturation(motor.slider))!r} (m/s)/m\n"
            f"# z = h + s - ({float(p[index.START])!r} m), tau = sqrt(s)/(sqrt(s) + sqrt(z)), nu = V/(v_1 s), mean "
            "repulsion R P(z), mean attraction A P(z), Q = mu R P(z) g; P(z) is the repulsion at rest of a part of "
            f"1/{motor.share} of the slider\n# mu = {motor.slider.friction_coefficient!r}\n"
        )
        label, names = drive.name.replace(" ", "_"), "RA"[: len(shares)]
        files[f"force_at_rest_{label}.csv"] = drive_head + "z_m,P_N\n" + _rows(np.column_stack([at_rest, force]))
        head_line = ",".join(["z_m", "tau", *names]) + "\n"
        files[f"mean_load_{label}.csv"] = drive_head + head_line + _rows(np.column_stack([z, taus, *shares]))
        signed = np.concatenate([-nu[:0:-1], nu[1:]])
        title = ",".join(
            ["z_m", "tau", "g_at_0_from_below", "g_at_0_from_above", *(f"g_at_nu={v:.8g}" for v in signed)]
        )
        both = [forces[0, :, 0], forces[1, :, 0], forces[0, :, :0:-1], forces[1, :, 1:]]
        files[f"mean_force_{label}.csv"] = drive_head + title + "\n" + _rows(np.column_stack([z, taus, *both]))
        files |= _response_table(drive, drive_head, label)
    return files


def _response_table(drive, drive_head: str, label: str) -> dict[str, str]:
    """Return the step response of the surface as CSV text by file name, of a drive that has one."""
    if drive.response is None:
        return {}
    time = drive.response_step * np.arange(len(drive.response))
    numbers = np.column_stack([time, drive.response.real, drive.response.imag])
    return {f"ring_up_{label}.csv": drive_head + "time_s,factor_real,factor_imaginary\n" + _rows(numbers)}


def _rows(table: np.ndarray) -> str:
    return "\n".join(",".join(f"{value:.9g}" for value in row) for row in table.tolist()) + "\n"


def _planar(scene: Scene, tolerance: float) -> FmuModel:
    """Return the averaged motor of a slider in the plane as the parts of an FMU."""
    # with the equations in the plane, which a motor along x does without
    from studies.export.planar_export import planar_motor
    from studies.export.planar_source import planar_model

    return planar_model(planar_motor(scene, tolerance=tolerance))


def _drives(model: FmuModel) -> list[str]:
    """Return the names of the inputs that are drives."""
    return [each.name for each in model.variables if each.causality == "input" and each.name.startswith("drive")]


def _answer(motor: AveragedMotor) -> tuple:
    return _lines(description(motor))


def _lines(description_of_motor: Sequence[str]) -> tuple:
    title, *lines = description_of_motor
    return (("motor", title), *(("", line) for line in lines))
