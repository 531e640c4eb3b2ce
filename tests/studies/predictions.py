"""A run of a scene in a process of its own: ``python -m tests.studies.predictions SCENE T [KEY=VALUE | -BLOCK]...``.

Prints as JSON what it took: CPU seconds of the process, imports included, largest memory, unknowns, order, what was
left out.
"""

import json
import sys
import time

from studies.evidence.own_process import peak_memory
from studies.runs import run
from studies.scene import Scene
from tests.studies.settings import changed


def used(scene: Scene, tolerance: float) -> dict:
    """Run a scene and return what this process took for it."""
    record = run(scene, tolerance=tolerance)
    wave = record.surface_wave
    return {
        "seconds": time.process_time(),
        "bytes": peak_memory(),
        "unknowns": None if wave is None else wave.unknowns,
        "order": None if wave is None else wave.solution.fields.resolution.order,
        "left_out": record.left_out,
    }


if __name__ == "__main__":
    print(json.dumps(used(changed(sys.argv[1], *sys.argv[3:]), float(sys.argv[2]))))
