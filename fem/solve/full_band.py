"""A band of frequencies for the two stators that the reduced model cannot represent.

One has a step of thickness; the other is a single mesh from end to end.  The discretisation is the finest that three
frequencies of the band need to meet the tolerance.  A stator that is one mesh is interpolated between a few condensed
matrices (`fem.reduce.piece_band`).  If it has too many resonances in the band for this, or has a step, every frequency
takes the time of one full solution.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.geometry import Stator, Transducer
from fem.reduce.piece_band import WholePiece, piece_of_whole_stator
from fem.waveguide.guided_modes import guided_modes
from fem.waveguide.line_force import LineForce
from fem.waveguide.port_fields import StatorCascade, joined_cascade, stator_cascade
from fem.waveguide.stator_meshes import StatorMeshes

FIRST_NODES = 3  # first frequencies of the interpolation: both limits and the middle of the band


@dataclass(frozen=True, kw_only=True)
class FullModel:
    """A stator without reduced lines over a band; it answers as `fem.reduce.reduced_model.ReducedModel` does."""

    stator: Stator
    transducers: tuple[Transducer, ...]  # from left to right
    limits: tuple[float, float]  # lowest and highest frequency in Hz
    resolution: Resolution
    # the mesh that is the whole stator, and its interpolation; None where every frequency is solved anew
    interpolation: tuple[StatorMeshes, WholePiece] | None = field(default=None, repr=False)

    def cascade(self, frequency: float, forces: tuple[LineForce, ...] = ()) -> StatorCascade:
        """Cascade at a frequency of the band (Hz), with line forces on the bare surface."""
        stator, transducers, resolution = self.stator, self.transducers, self.resolution
        if self.interpolation is None:
            return stator_cascade(stator, transducers, frequency=frequency, resolution=resolution, forces=forces)
        meshes, piece = self.interpolation
        modes = guided_modes(meshes.section, frequency)
        (contents,) = meshes.assemblies  # the mesh that is the whole stator
        pieces = meshes.arranged({contents: piece.at(frequency)}, modes)
        return joined_cascade(stator, transducers, [], modes=modes, resolution=resolution, pieces=pieces, forces=forces)

    def interpolated(
        self, potentials: np.ndarray, positions: np.ndarray, tolerance: float
    ) -> tuple["FullModel", float]:
        """Return this model with an interpolation over the band, and the relative error of the interpolation.

        The stator must be a single mesh.  The error is that of the motion at ``positions`` (m) and of the reactions of
        the ports for ``potentials``, shape (ports, columns).  If it exceeds the tolerance, because the stator resonates
        too often in the band, the model is returned as it is, with an error of 0.
        """
        unit = self.stator.slowest_wavelength(self.limits[1])
        section = discretise(self.stator, self.resolution, wavelength=unit, surface_scale=np.inf)
        meshes = StatorMeshes(self.stator, section, self.resolution, self.limits[1])
        (assembly,) = meshes.assemblies.values()
        condensed = [assembly.condensed(float(frequency)) for frequency in np.linspace(*self.limits, FIRST_NODES)]
        piece, error = piece_of_whole_stator(condensed, potentials, positions / unit, self.limits, tolerance)
        if error > tolerance:
            return self, 0.0
        return replace(self, interpolation=(meshes, piece)), error
