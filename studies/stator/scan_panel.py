"""A vibrometer's scan drawn over a study's prediction: what `beam` and `frequency_response` share."""

from functools import partial

from studies.lab.measurement_csv import read_measured
from studies.lab.scan import Scan
from studies.model.model import Model
from studies.record.scan_comparison import scan_comparison
from studies.refusal import SceneError, refuse_if
from studies.scene import Scene
from studies.solve.measured_run import scan_block
from studies.solve.scan_prediction import placed, scan_and_error
from studies.study_list import Panel


def scan_file(scene: Scene, path: str, over: str) -> Scan:
    """Return the scan of a file at its positions on a resolved scene; ``over``: "position" or "frequency".

    Raises
    ------
    SceneError
        If the file holds no scan over this coordinate.
    """
    measured = read_measured(path).scan
    if measured is None:
        raise SceneError("--measured", f"must be a vibrometer's scan for this study, got {path!r}")
    scan = placed(scene, measured)
    refuse_if(
        (scan.kind == "frequency") != (over == "frequency"),
        "--measured",
        f"must be a scan over {over} for this study, got one over {scan.kind}",
    )
    return scan


def scan_panel(model: Model, scan: Scan, *, tolerance: float) -> Panel:
    """Return the panel of a scan beside the motion computed at its own points, for the study to draw."""
    block = scan_block(model, scan, partial(scan_and_error, model, tolerance=tolerance))
    return Panel(name="measured", title=f"{model.scene.title}: measured", data=block)


def scan_answer(panels) -> list[tuple[str, str]]:
    """Return the lines of a study's answer on its scan; none without a scan."""
    return [line for panel in panels if panel.name == "measured" for line in scan_comparison(panel.data)]
