"""What a laboratory's instruments would record of a scene: data with known parameters, to test an evaluation.

A vibrometer's scan (CSV, UFF), a network analyser's file (Touchstone), an encoder's trace of a burst (CSV), the field
of the surface (VTU).  Noise is Gaussian; its standard deviation is a share of the largest value.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import fem
from studies.export.averaged_motor import averaged_motor
from studies.export.exported import Exported
from studies.export.simulators import tables
from studies.lab.csv_columns import csv_text
from studies.lab.encoder import recorded, travelled_distance
from studies.lab.scan import Scan, scan_csv
from studies.lab.scan_uff import scan_uff
from studies.model.fem_objects import free_span
from studies.model.model import Model
from studies.record.files import write_run
from studies.record.plots import curve, finished
from studies.record.quantities import quantity
from studies.refusal import refuse_if, refuse_other
from studies.report.explanation import band_seconds
from studies.runs import run
from studies.scene import Scene
from studies.scene.numbers import Quantity
from studies.scene.override import toml_value
from studies.scene.quantity import si_value
from studies.solve import passband
from studies.solve.scan_prediction import placed, scan_and_error
from studies.solve.scattering import converged_scattering, reference_impedance

PER_WAVELENGTH = 8  # points of a scan along x
LINES = 41  # of an area along y
CLEAR = 0.5  # wavelengths from the fingers
FREQUENCIES = 201
SCANS = ("x", "y", "xy", "frequency")
COARSE = 2  # points per wavelength along x of an area: enough for the beam, not for the ripple


@dataclass(frozen=True, kw_only=True)
class Recording:
    """How instruments record: the options of the command as text."""

    # What a vibrometer scans. "x": from the driven transducer to the next one or the stator's end, 8 points per
    # wavelength; "y": across the beam at the slider; "xy": an area; "frequency": at the slider, over `band`
    scan: str | None = None
    band: str | None = None  # START:STOP:N in MHz
    noise: str | None = None  # share of the largest value that is the standard deviation of each real number
    seed: int | None = None  # of the noise
    bandwidth: str | None = None  # of an encoder's low-pass filter
    sampling: str | None = None  # averaging time of an encoder
    z0: str | None = None  # reference impedance of a network analyser

    def __post_init__(self) -> None:
        """Refuse a wrong noise before anything is computed; SceneError."""
        _ = self.share

    @property
    def share(self) -> float:
        """Standard deviation of the noise over the largest value."""
        if self.noise is None:
            refuse_if(self.seed is not None, "--seed", "needs --noise")
            return 0.0
        text = str(self.noise).strip()
        percent = text.endswith("%")
        value = si_value("--noise", toml_value(text.rstrip("% ")), "") * (0.01 if percent else 1.0)
        refuse_if(
            not 0.0 <= value < 1.0, "--noise", f"must be at least 0 and below 1, or a percentage, got {self.noise}"
        )
        refuse_if(self.seed is None, "--noise", "needs --seed N, so that the same noise can be had again")
        return value

    @property
    def remark(self) -> tuple[str, ...]:
        """Remark on the noise in the head of a file."""
        text = f"noise: standard deviation {self.share:g} of the largest value in each part, seed {self.seed}"
        return () if self.noise is None else (text,)

    def noisy(self, values: np.ndarray, seed_offset: int = 0) -> np.ndarray:
        """Return real or complex values with noise, whose seed is offset."""
        size = self.share * float(np.max(np.abs(values)))
        if size == 0.0 or self.seed is None:
            return values
        random = np.random.default_rng(self.seed + seed_offset)
        scatter = random.standard_normal(values.shape) + 1j * random.standard_normal(values.shape)
        return values + size * (scatter if np.iscomplexobj(values) else scatter.real)

    def encoder(self, scene: Scene) -> dict[str, float]:
        """Return the options of `recorded`: ``bandwidth`` in Hz, ``sampling`` in s; SceneError without a burst."""
        encoder = {
            option: Quantity(unit).read(f"--{option}", toml_value(value))
            for option, value, unit in (("bandwidth", self.bandwidth, "Hz"), ("sampling", self.sampling, "s"))
            if value is not None
        }
        for option in encoder:
            refuse_if(
                scene.slider is None or scene.burst is None or self.scan is not None,
                f"--{option}",
                "is of an encoder: the scene needs a slider and a burst, and no --scan",
            )
        return encoder


def csv_files(scene: Scene, name: str, recording: Recording, *, tolerance: float) -> Exported:
    """Return scan.csv; with a slider and without ``recording.scan`` also burst.csv and the motor's tables."""
    encoder = recording.encoder(scene)
    files: dict[str, bytes | str] = {}
    answer: tuple[tuple[str, str], ...] = ()
    pictures: dict = {}
    if scene.transducer:
        scan, remarks = virtual_scan(scene, recording, tolerance)
        files["scan.csv"], answer = scan_csv(scan, remarks), _scan_answer(scan, remarks)
        pictures["scan.png"] = lambda ax: _draw(scan, ax)
    elif recording.scan is not None:
        scene.refuse("transducer", "is missing: a scan is of a driven stator")
    if scene.slider is not None and recording.scan is None:
        if scene.burst is not None:
            files["burst.csv"] = _trace(scene, recording, encoder, tolerance)
            answer += (("encoder", "burst.csv: position and velocity over time"),)
        motor = averaged_motor(scene, tolerance=tolerance)
        files |= tables(motor)
        forces = ", ".join(file for file in files if file.startswith("mean_"))
        answer += (("tables", f"mean forces of the averaged motor: {forces}"),)
    if not files:
        scene.refuse("transducer", "is missing: without it and without a slider there is nothing to record")
    return Exported(files=files, answer=answer, pictures=pictures)


def uff_files(scene: Scene, name: str, recording: Recording, *, tolerance: float) -> Exported:
    """Return NAME.uff, the virtual vibrometer's scan as datasets 58b."""
    scan, remarks = virtual_scan(scene, recording, tolerance)
    return Exported(
        files={f"{name}.uff": scan_uff(scan, remarks)}, answer=_scan_answer(scan, remarks),
        pictures={"scan.png": lambda ax: _draw(scan, ax)},
    )  # fmt: skip


def expected_seconds(scene: Scene, recording: Recording, tolerance: float) -> float:
    """Return the expected time in s of a recording over a band of frequencies."""
    model = passband.driven_model(scene)
    return band_seconds(model, _frequencies(model, recording.band), tolerance=tolerance)


def touchstone_files(scene: Scene, name: str, recording: Recording, *, tolerance: float) -> Exported:
    """Return NAME.sNp, the S-parameters of all transducers with two combs, in the scene's order."""
    model = passband.driven_model(scene)
    resolved = model.scene
    reference = reference_impedance(50.0 if recording.z0 is None else recording.z0)
    at = _frequencies(model, recording.band)
    names, ports, scattering, failures = converged_scattering(model, at, reference, tolerance)
    at, missing = ports.frequency, tuple(f"no answer {each}" for each in failures)
    remarks = (resolved.title or name, "ports: " + ", ".join(names), *recording.remark, *missing)
    text = fem.touchstone(at, recording.noisy(scattering), reference, remarks)
    span = f"{at[0] / 1e6:.5g} to {at[-1] / 1e6:.5g} MHz"
    summary = f"{len(at)} frequencies, {span}, ports {', '.join(names)}, {reference:g} ohm"
    return Exported(
        files={f"{name}.s{len(names)}p": text},
        answer=(
            ("network", summary),
            *(("noise", each) for each in recording.remark),
            *(("", each) for each in missing),
        ),
    )


def vtu_files(scene: Scene, name: str, *, tolerance: float) -> Exported:
    """Return field.vtu and the surface map of a scene with a driven stator."""
    if not scene.transducer:
        scene.refuse("transducer", "is missing: the field of a driven stator is written")
    alone = replace(scene.with_source(burst=None), uncertain=None, slider=None)
    record = run(alone, tolerance=tolerance)
    with TemporaryDirectory() as folder:
        write_run(record, Path(folder), field=True)
        files = {each.name: each.read_bytes() for each in Path(folder).iterdir() if each.suffix == ".vtu"}
    return Exported(files=dict(sorted(files.items())), answer=(("field", ", ".join(sorted(files))),))


def virtual_scan(scene: Scene, recording: Recording, tolerance: float) -> tuple[Scan, tuple[str, ...]]:
    """Return what a vibrometer would record per volt, u_z, and remarks."""
    kind, share = recording.scan or "x", recording.share
    refuse_other(kind, SCANS, "--scan")
    refuse_if(
        recording.band is not None and kind != "frequency",
        "--band",
        f"is for --scan frequency and the format touchstone, not for --scan {kind}",
    )
    model = passband.driven_model(scene)
    resolved = model.scene
    points = placed(resolved, _points(model, kind, recording.band))
    motion, error = scan_and_error(model, points, tolerance=tolerance)
    size = share * float(np.max(np.abs(motion)))
    scan = replace(
        points, name="scan", values=recording.noisy(motion),
        deviation=np.full(len(motion), size) if size > 0.0 else None,
    )  # fmt: skip
    accuracy = (
        f"estimated numerical error {100 * error:.2g} % rms of the motion, for a tolerance of {100 * tolerance:g} %"
    )
    convention = "u_z per volt of the source, peak, exp(+i omega t)"
    return scan, (resolved.title or "untitled", convention, accuracy, *recording.remark)


def _points(model: Model, kind: str, band) -> Scan:
    """Return the points of a kind of scan, with values of zero."""
    scene, wavelength = model.scene, model.wavelength
    driven, (slider_x, slider_y) = scene.driven_transducer, scene.positions[0]
    around = ((each.name, each.center_xy[0], each.half_length) for each in scene.transducer)
    rows = {name: (center - half, center + half) for name, center, half in around}
    ahead, length = slider_x >= driven.center_xy[0], scene.stator.length
    low, high = free_span(rows.values(), rows[driven.name][ahead], length, CLEAR * wavelength)
    low, high = (low, min(high, length - wavelength)) if ahead else (max(low, wavelength), high)
    if high <= low:
        low, high = max(slider_x - 2 * wavelength, 0.0), min(slider_x + 2 * wavelength, length)
    along = np.linspace(low, high, int(np.ceil(PER_WAVELENGTH * (high - low) / wavelength)) + 1)
    y = np.linspace(-0.5, 0.5, LINES) * min(1.5 * driven.aperture, scene.stator.width)
    if kind == "x":
        x, y, frequency = along, np.full(len(along), slider_y), None
    elif kind == "y":
        x, frequency = np.full(len(y), slider_x), None
    elif kind == "xy":
        along = along[:: PER_WAVELENGTH // COARSE]
        x, y, frequency = np.tile(along, len(y)), np.repeat(y, len(along)), None
    else:
        frequency = _frequencies(model, band)
        x, y = np.full(len(frequency), slider_x), np.full(len(frequency), slider_y)
    return Scan(name="scan", x=x, y=y, frequency=frequency, values=np.zeros(len(x), complex))


def _frequencies(model: Model, band: str | None) -> np.ndarray:
    """Return the frequencies of a band, or of the passband if it is None, in Hz."""
    return passband.frequencies(model, None, FREQUENCIES) if band is None else passband.band_frequencies(model, band)


def _trace(scene: Scene, recording: Recording, encoder: dict[str, float], tolerance: float) -> str:
    """Return what an encoder records of the scene's burst at its largest level, as CSV; the noise is added last."""
    level = max(scene.levels)
    if scene.planar:
        scene.refuse("slider.freedom", 'must be "x" for an encoder\'s trace: trajectory.csv of a run has the path')
    _, path = run(scene.at_level(level), tolerance=tolerance).trajectories[0]
    columns = {scene.level_column: np.full(len(path.time), level), quantity.time_s.column: path.time}
    for seed_offset, head, values in (
        (1, quantity.position_m.column, travelled_distance(path.time, path.velocity)),
        (0, quantity.velocity_m_per_s.column, path.velocity),
    ):  # fmt: skip
        columns[head] = recording.noisy(recorded(path.time, values, path.time, **encoder), seed_offset)
    filters = tuple(f"{name} {value:g} {'Hz' if name == 'bandwidth' else 's'}" for name, value in encoder.items())
    without_start = {head: column[1:] for head, column in columns.items()}
    return csv_text(without_start, (scene.title, *filters, *recording.remark))


def _scan_answer(scan: Scan, remarks) -> tuple:
    return (("scan", f"{len(scan.x)} points over {scan.kind}"), *(("", each) for each in remarks[1:]))


def _draw(scan: Scan, ax):
    along = {"frequency": quantity.frequency_Hz, "y": quantity.y_m}.get(scan.kind, quantity.x_m)
    up, sizes = quantity.amplitude_m_per_V, np.abs(scan.values)
    curve(ax, scan.coordinate * along.scale, sizes * up.scale, ".", "slip", "virtual vibrometer", size=2.5)
    return finished(ax, along.axis, up.axis, f"What a vibrometer would record of {scan.component}", columns=1)
