"""The peer package NGSolve on the driven stator, as its expert would run it.

Netgen triangles of about a wavelength, hp-refined geometrically towards every finger edge (`RefineHP`), one high order
throughout, the scaled weak form, fingers as Dirichlet data, charges as reactions of the residual.  Stiffness and mass
are assembled once; at each frequency their sum is factorised by `sparsecholesky` with its symbolic analysis reused, or,
on request, assembled anew with static condensation: whichever is faster depends on the order (the study times both).
Absorbing ends: perfectly matched layers behind the outer transducers, x -> s x with a constant complex s, bilinear
and not conjugated.  Fields exp(+i omega t); lengths in wavelengths.

Limits: plain transducers, every one but the driven left open, a free bottom with D_n = 0, nothing above; u_y uncoupled.

Source: Schoeberl, *C++11 implementation of finite elements in NGSolve*, ASC report 30/2014, TU Wien.
"""

from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

from studies.refusal import RunError

__all__ = ["Peer", "PeerMesh", "installed"]

_GAP = 1.0  # wavelengths of ordinary plate between the outer fingers and the absorbing layers
_STRAIN = (0, 2, 4)  # Voigt 11, 33, 13
_PLANE = (0, 2)


def installed() -> bool:
    """Whether NGSolve can be imported."""
    return find_spec("ngsolve") is not None


@dataclass(frozen=True, kw_only=True)
class PeerMesh:
    """How finely NGSolve resolves the stator.

    Attributes
    ----------
    order : int
    element_size : float
        Largest element in wavelengths.
    edge_layers : int
        Levels of hp-refinement towards finger edges, ratio 0.15.
    absorber : float
        Width of the absorbing layers in wavelengths.
    stretch : complex
        Their s.
    condense : bool
        Assemble anew at each frequency and condense the interior of the elements, instead of adding stored matrices.
    """

    order: int
    element_size: float = 1.0
    edge_layers: int = 2
    absorber: float = 4.0
    stretch: complex = 1 - 2j
    condense: bool = False


class Peer:
    """A stator meshed, its spaces and constant matrices set up.

    Parameters
    ----------
    stator : fem.Stator
    transducers : tuple of fem.Transducer
    wavelength : float
        m.
    mesh : PeerMesh

    Raises
    ------
    RunError
        If NGSolve is not installed.
    """

    def __init__(self, stator, transducers, *, wavelength: float, mesh: PeerMesh):
        if not installed():
            raise RunError("the comparison with NGSolve needs it: pip install 'sawmotor[peers]'")
        import ngsolve as ng

        self.stator, self.settings, self.unit = stator, mesh, wavelength
        self.transducers = tuple(sorted(transducers, key=lambda each: each.center))
        self.absorbs = stator.ends == "absorbing"
        self.mesh = ng.Mesh(self._geometry().GenerateMesh(maxh=mesh.element_size))
        if mesh.edge_layers:
            self.mesh.RefineHP(mesh.edge_layers, factor=0.15)
        self.combs = [f"{index}{sign}" for index in range(len(transducers)) for sign in "pm"]
        electric = ng.H1(self.mesh, order=mesh.order, complex=True, dirichlet="|".join(self.combs))
        self.space = ng.VectorH1(self.mesh, order=mesh.order, complex=True) * electric
        solid = stator.solid
        self.stress = float(solid.stiffness.max())
        self.potential = float(np.sqrt(self.stress / solid.permittivity.max()))
        self.square = ng.Parameter(0.0)
        self._lifted = [self._lifting(comb) for comb in self.combs]
        self._factor = None
        stiffness, mass = self._forms()
        self.system = ng.BilinearForm(self.space, symmetric=True, condense=mesh.condense)
        self.system += stiffness * ng.dx
        if mesh.condense:
            self.system += self.square * mass * ng.dx
            return
        self.system.Assemble()
        self._stiffness = self.system.mat.CreateMatrix()
        self._stiffness.AsVector().data = self.system.mat.AsVector()
        inertia = ng.BilinearForm(self.space, symmetric=True)
        inertia += stiffness * ng.dx(definedon=self.mesh.Materials("nowhere"))  # the same sparsity
        inertia += mass * ng.dx
        self._mass = inertia.Assemble().mat

    @property
    def unknowns(self) -> int:
        """Of the whole space."""
        return self.space.ndof

    def solve(self, frequency: float, *, driven: str, place: float) -> tuple[complex, np.ndarray]:
        """Admittance (S) and u_x, u_z (m per V, shape (2,)) at a place (m) of the surface, at a frequency (Hz)."""
        import ngsolve as ng

        square = -((2 * np.pi * frequency * self.unit) ** 2) * self.stator.solid.density / self.stress
        self.square.Set(square)
        if self.settings.condense:
            self.system.Assemble()
        else:
            self.system.mat.AsVector().data = self._stiffness.AsVector() + square * self._mass.AsVector()
        if self._factor is None:
            free = self.space.FreeDofs(self.settings.condense)
            self._factor = self.system.mat.Inverse(free, inverse="sparsecholesky")
        else:
            self._factor.Update()
        drives = self._drives(driven)
        fields, charges = [], np.zeros((len(drives),) * 2, dtype=complex)
        loads = [self._combined(drive) for drive in drives]
        for load in loads:
            fields.append(self._solved(load))
        residual = loads[0].CreateVector()
        for column, each in enumerate(fields):
            residual.data = self.system.mat * each
            for row, load in enumerate(loads):
                charges[row, column] = ng.InnerProduct(residual, load, conjugate=False)
        weights = np.append(1.0, np.linalg.solve(charges[1:, 1:], -charges[1:, 0]) if len(drives) > 1 else [])
        aperture = next(each.aperture for each in self.transducers if each.name == driven)
        charge = -(charges[0] @ weights) * self.stress / self.potential**2
        answer = ng.GridFunction(self.space)
        for weight, each in zip(weights, fields, strict=True):
            answer.vec.data += complex(weight) * each
        at = self.mesh(place / self.unit, -1e-12)
        return complex(2j * np.pi * frequency * aperture * charge), np.array(answer.components[0](at)) / self.potential

    def _drives(self, driven: str) -> list[np.ndarray]:
        """Comb potentials of the driven voltage, then of every comb that floats."""
        index = [each.name for each in self.transducers].index(driven)
        unit = np.eye(len(self.combs))
        voltage = (unit[2 * index] - unit[2 * index + 1]) / 2
        return [voltage, *(row for comb, row in enumerate(unit) if comb // 2 != index)]

    def _combined(self, potentials):
        load = self._lifted[0].CreateVector()
        load[:] = 0
        for potential, each in zip(potentials, self._lifted, strict=True):
            if potential:
                load.data += complex(potential) * each
        return load

    def _solved(self, load):
        answer, residual = load.CreateVector(), load.CreateVector()
        answer.data = load
        residual.data = -(self.system.mat * load)
        if not self.settings.condense:
            answer.data += self._factor * residual
            return answer
        residual.data += self.system.harmonic_extension_trans * residual
        answer.data += self._factor * residual
        answer.data += self.system.harmonic_extension * answer
        return answer

    def _lifting(self, comb: str):
        import ngsolve as ng

        one = ng.GridFunction(self.space)
        one.components[1].Set(
            self.mesh.BoundaryCF({comb: 1.0}, default=0.0), definedon=self.mesh.Boundaries("|".join(self.combs))
        )
        return one.vec

    def _forms(self):
        """Integrands of stiffness and of -mass over the square of the frequency."""
        import ngsolve as ng

        solid, stress, potential = self.stator.solid, self.stress, self.potential

        def table(values):
            return ng.CF(tuple(complex(value) for value in values.ravel()), dims=values.shape)

        elastic = table(solid.stiffness_lossy[np.ix_(_STRAIN, _STRAIN)] / stress)
        coupling = solid.coupling[np.ix_(_PLANE, _STRAIN)] * (potential / stress)
        dielectric = table(-solid.permittivity_lossy[np.ix_(_PLANE, _PLANE)] * (potential**2 / stress))
        (u, phi), (v, psi) = self.space.TnT()
        stretch = self.mesh.MaterialCF({"absorber": self.settings.stretch}, default=1.0)
        inverse = self.mesh.MaterialCF({"absorber": 1 / self.settings.stretch}, default=1.0)

        def strain(w):
            slope = ng.Grad(w)
            if self.absorbs:
                return ng.CF((inverse * slope[0, 0], slope[1, 1], slope[0, 1] + inverse * slope[1, 0]))
            return ng.CF((slope[0, 0], slope[1, 1], slope[0, 1] + slope[1, 0]))

        def slope(w):
            return ng.CF((inverse * ng.grad(w)[0], ng.grad(w)[1])) if self.absorbs else ng.grad(w)

        traction = elastic * strain(u) + table(coupling.T.copy()) * slope(phi)
        displacement = table(coupling) * strain(u) + dielectric * slope(phi)
        stiffness = traction * strain(v) + displacement * slope(psi)
        return (stretch * stiffness, stretch * (u * v)) if self.absorbs else (stiffness, u * v)

    def _geometry(self):
        """Section in wavelengths, finger edges marked for refinement; absorbing layers beside it if it goes on."""
        from netgen.geom2d import SplineGeometry

        unit, depth = self.unit, -self.stator.thickness / self.unit
        first, last = self.transducers[0].extent[0] / unit, self.transducers[-1].extent[1] / unit
        left, right = (first - _GAP, last + _GAP) if self.absorbs else (0.0, self.stator.length / unit)
        shape = SplineGeometry()

        def side(a, b, *, name, inside, outside=0):
            shape.Append(["line", a, b], leftdomain=inside, rightdomain=outside, bc=name)

        def corner(x, z, **marks):
            return shape.AppendPoint(x, z, **marks)

        beside = (2, 3) if self.absorbs else (0, 0)
        below = corner(left, depth), corner(right, depth)
        above = corner(left, 0.0), corner(right, 0.0)
        side(below[0], below[1], name="bottom", inside=1)
        side(below[1], above[1], name="right", inside=1, outside=beside[1])
        here = above[1]
        for index in reversed(range(len(self.transducers))):
            own = self.transducers[index]
            for sign, (start, stop) in list(zip(own.signs, own.fingers / unit, strict=True))[::-1]:
                end, begin = (corner(x, 0.0, hpref=1) for x in (stop, start))
                side(here, end, name="top", inside=1)
                side(end, begin, name=f"{index}{'p' if sign == '+' else 'm'}", inside=1)
                here = begin
        side(here, above[0], name="top", inside=1)
        side(above[0], below[0], name="left", inside=1, outside=beside[0])
        if self.absorbs:
            wide = self.settings.absorber
            ahead = corner(right + wide, depth), corner(right + wide, 0.0)
            for a, b in ((below[1], ahead[0]), ahead, (ahead[1], above[1])):
                side(a, b, name="far", inside=3)
            behind = corner(left - wide, 0.0), corner(left - wide, depth)
            for a, b in ((above[0], behind[0]), behind, (behind[1], below[0])):
                side(a, b, name="far", inside=2)
            shape.SetMaterial(2, "absorber")
            shape.SetMaterial(3, "absorber")
        shape.SetMaterial(1, "body")
        return shape
