"""A line force on the bare surface of a uniform segment: what it sends to both sides.

A force F per width along y (N/m) at one position of the surface makes the nodal flux jump, f_right - f_left = -F e,
with e the surface's unknown of that component.  With the radiation impedances of both sides

    (X_right + X_left) u = -F e,                                                                    (1)

and the modes' amplitudes on either side follow from u.  The surface wave's part is the surface's compliance Gamma at
its pole: U_z to the right is -i Gamma F_z for a normal force.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Literal

import numpy as np

from fem.parameters import ComplexNumber, Number, Parameters
from fem.waveguide.end_conditions import with_gauge
from fem.waveguide.guided_modes import GuidedModes


@dataclass(frozen=True, kw_only=True)
class LineForce(Parameters):
    """A line force on the bare surface of a stator, uniform along y or over a strip of it.

    In the section it is the same all along y.  In the beam (`fem.surface_beam`) it acts on |y - center_y| < width / 2;
    several strips at one position are a profile along y.

    Attributes
    ----------
    name : str
    position : float
        m from the left end.
    component : "x" or "z"
        Along the surface, or normal to it (out of the body).
    amplitude : complex
        N per metre of y, peak; of a strip the force over its width.
    width : float
        Length of the strip along y, m; infinite by default.
    center_y : float
        Middle of the strip, m from the stator's middle line.
    """

    prefix = "force"
    owner = property(lambda self: self.name)
    name: str
    position: float
    component: Literal["x", "z"] = "z"
    amplitude: Annotated[complex, ComplexNumber("N/m")] = 1.0
    width: Annotated[float, Number("m", infinite=True)] = float("inf")
    center_y: Annotated[float, Number("m", negative=True)] = 0.0


@dataclass(frozen=True, kw_only=True)
class ForceResponse:
    """Response of a uniform segment without end to a unit line force (1 N/m) on its surface."""

    component: str  # "x" or "z"
    modes: GuidedModes
    line: np.ndarray = field(repr=False)  # unknowns of the line under the force, m per N/m, shape (n,)

    @cached_property
    def right(self) -> np.ndarray:
        """Amplitudes of all modes that are sent to the right, at the force, shape (n,)."""
        return self.modes.right_amplitudes(self.line)

    @cached_property
    def left(self) -> np.ndarray:
        """Amplitudes of all modes that are sent to the left, at the force, shape (n,)."""
        return self.modes.left_amplitudes(self.line)

    def motion(self, distance: float) -> np.ndarray:
        """u_x and u_z of the surface at a distance in m, to the right where positive, m per N/m: shape (2,)."""
        modes, x = self.modes, distance / self.modes.section.length_unit
        amplitudes, shapes, k = (
            (self.right, modes.right, modes.wavenumbers) if x >= 0 else (self.left, modes.left, modes.backwards)
        )
        return modes.section.surface_rows @ (shapes @ (amplitudes * np.exp(-1j * k * x)))

    @property
    def surface_wave(self) -> np.ndarray:
        """u_x and u_z of the surface wave sent to the right, at the force, m per N/m: shape (2,)."""
        surface_wave = self.modes.rayleigh
        return self.modes.section.surface_rows @ (self.modes.right[:, surface_wave] @ self.right[surface_wave])


def force_response(modes: GuidedModes, component: str) -> ForceResponse:
    """Response to a line force along "x" or "z" (normal) on a segment with these modes, by equation (1)."""
    section = modes.section
    load = section.surface_rows[("x", "z").index(component)] / section.solid.stress_unit
    line = -np.linalg.solve(_with_held_mean(modes), load)
    return ForceResponse(component=component, modes=modes, line=line)


def _with_held_mean(modes: GuidedModes) -> np.ndarray:
    """Sum of the radiation impedances; the constant potential, which carries no flux, is held at zero mean."""
    system = modes.impedance_sum.astype(complex)
    if not modes.section.floating_potential or modes.lateral_wavenumber:
        return system
    return with_gauge(system, modes.section.constant_potential)
