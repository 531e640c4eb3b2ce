"""Questions to a SAW motor: scenes, the chain from drive voltage to slider velocity, records, pictures.

>>> from studies import Scene
>>> Scene.load("twente").slider.mass
8.9e-05

Conventions: exp(+i omega t), peak amplitudes, SI units, x along the surface, z out of it, slider velocity
positive along +x.  Importing this package imports no numerical library; ``studies.chain.run`` imports what
its scene needs.
"""

from studies.blocks import (
    Damping,
    Drive,
    IsotropicSolid,
    PiezoelectricSolid,
    Slider,
    Stator,
    Transducer,
    Wave,
)
from studies.refusal import SceneError
from studies.scene import Scene, shipped_scenes

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
