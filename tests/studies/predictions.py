"""A run of a scene in a process of its own: ``python -m tests.studies.predictions SCENE T [KEY=VALUE | -BLOCK]...``.

Prints as JSON what it took: CPU seconds of the process, imports included, largest memory, unknowns, order, what was
left out.
"""

import json
import sys
import time

from studies.chain import run
from studies.evidence.own_process import peak_memory
from studies.scene import Scene, read_table
from tests.studies.settings import assigned


def changed(name: str, *settings: str) -> Scene:
    """Return a shipped scene with some keys set; ``-slider`` leaves that block out."""
    table = read_table(name)
    for setting in settings:
        if setting.startswith("-"):
            del table[setting[1:]]
        else:
            table = assigned(table, setting)
    return Scene.from_table("", table)


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
