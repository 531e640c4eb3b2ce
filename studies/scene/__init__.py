"""A scene: what is modelled, no more.  A block that is absent is left out of the model.

``Scene.load("motor.toml")`` equals the ``Scene(...)`` built from the same blocks in Python.  The checks here are those
of the text alone; what needs the physics (a value `auto`, a material) is resolved and checked in
`studies.chain.resolve`.
"""

from studies.scene.file import SceneFile, read_table, scene_path, shipped_scenes
from studies.scene.scene import Scene

__all__ = ["Scene", "SceneFile", "read_table", "scene_path", "shipped_scenes"]
