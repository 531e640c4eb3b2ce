"""Questions to a SAW motor: scenes, the chain from drive voltage to slider velocity, records, pictures.

>>> from studies import Scene
>>> Scene.load("twente").slider.mass
8.9e-05

Conventions: exp(+i omega t), peak amplitudes, SI units, x along the surface, z out of it, slider velocity
positive along +x.  Importing this package imports no numerical library; ``studies.chain.run`` imports what
its scene needs.

Packages, bottom to top: scene (the file and its rules) - chain (voltage to velocity) - report (the files of a run) -
view (looking at fields and contacts), sweep (many runs of one scene) - command (the command line) - stator, papers,
motor (questions, one file each) - evidence (what shows that the rest can be trusted).
"""

from studies.refusal import SceneError
from studies.scene import Scene, shipped_scenes
from studies.scene.blocks import (
    Damping,
    Drive,
    IsotropicSolid,
    PiezoelectricSolid,
    Slider,
    Stator,
    Transducer,
    Wave,
)

__all__ = [
    "Damping",
    "Drive",
    "IsotropicSolid",
    "PiezoelectricSolid",
    "Scene",
    "SceneError",
    "Slider",
    "Stator",
    "Transducer",
    "Wave",
    "shipped_scenes",
]
