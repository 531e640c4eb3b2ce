"""A scene: the parts of a motor that are modelled.  A block that is absent is left out of the model.

``Scene.load("motor.toml")`` equals the ``Scene(...)`` built from the same blocks in Python.  The checks here are of
the text alone; `studies.model.resolve` resolves and checks what needs the physics (a value `auto`, a material).
"""

from studies.scene.file import SceneFile, read_table, scene_path, shipped_scenes
from studies.scene.scene import Scene

__all__ = ["Scene", "SceneFile", "read_table", "scene_path", "shipped_scenes"]
