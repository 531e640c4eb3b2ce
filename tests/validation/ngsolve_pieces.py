"""NGSolve alone on stators with grooves, strips, steps and bevelled ends: references for the meshed pieces.

The whole section is one Netgen mesh of one high order, hp-refined geometrically towards electrode ends, re-entrant
corners and corners where solids meet.  The matrix is complex symmetric and condensed statically; the charges of the
electrodes are reactions of the residual.  Ends that absorb are layers of constant stretching x -> s x.  Only the
tables of materials are shared with the program.  Fields exp(+i omega t); lengths in mm.

Source: Schoeberl, *C++11 implementation of finite elements in NGSolve*, ASC report 30/2014, TU Wien.
"""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from fem.materials import material, rotated
from tests.fem.piece_references import REFERENCES, places

RATIO = 0.15  # of the geometric layers
STRAINS = {0: {0: 0, 2: 4}, 1: {0: 5, 2: 3}, 2: {0: 4, 2: 2}}  # displacement: derivative: Voigt number
SAME = 1e-9  # mm


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """A section as polygons.

    Attributes
    ----------
    regions : list of (str, list)
        Name of the solid or of an absorber, and corners (x, z).
    electrodes : dict
        Name to its straight segments ((x, z), (x, z)).
    clamped : list
        Straight segments without displacement.
    singular : list
        Points that the mesh is refined towards besides the ends of electrodes.
    absorbers : dict
        Name to the solid and the stretching s.  A mode k = a - i b that goes right must decay in its layer too, Im(k s)
        < 0: -Im s / Re s must stay below b / |a| of all modes with a < 0, or the layer is wrong at any depth.
    """

    regions: list
    electrodes: dict
    clamped: list = field(default_factory=list)
    singular: list = field(default_factory=list)
    absorbers: dict = field(default_factory=dict)

    @property
    def vertices(self) -> list:
        """All points that edges of the mesh must end at."""
        segments = [*self.clamped, *(s for each in self.electrodes.values() for s in each)]
        return [p for _, corners in self.regions for p in corners] + [p for s in segments for p in s]

    @property
    def refined(self) -> list:
        """All points that the mesh is refined towards."""
        ends = []
        for segments in self.electrodes.values():
            points = [p for s in segments for p in s]
            ends += [p for p in points if sum(_apart(p, q) < SAME for q in points) == 1]
        return [*self.singular, *ends]


def _apart(p, q) -> float:
    return float(np.hypot(p[0] - q[0], p[1] - q[1]))


def _lies_on(segment, p) -> bool:
    a, b = segment
    return abs(_apart(a, p) + _apart(p, b) - _apart(a, b)) < SAME


class Reference:
    """A drawing meshed by Netgen, with elements of at most ``size`` mm, and its spaces of one order."""

    def __init__(self, drawing: Drawing, solids: dict, *, order: int, layers: int, size: float):
        import ngsolve as ng

        self.drawing, self.solids = drawing, solids
        self._electrodes = [f"electrode{k}" for k in range(len(drawing.electrodes))]  # NGSolve reads "+" as a pattern
        self.mesh = ng.Mesh(self._geometry().GenerateMesh(maxh=size))
        self.mesh.RefineHP(layers, factor=RATIO)
        self.axes = (0, 1, 2) if any(_couples_y(each) for each in solids.values()) else (0, 2)
        piezo = "|".join(name for name in self.mesh.GetMaterials() if self._solid(name).is_piezoelectric)
        displacement = ng.H1(self.mesh, order=order, complex=True, dirichlet="clamped")
        potential = ng.H1(self.mesh, order=order, complex=True, definedon=piezo, dirichlet="|".join(self._electrodes))
        self.space = ng.FESpace([displacement] * len(self.axes) + [potential])
        first = next(iter(solids.values()))
        self.stress = float(first.stiffness.max())
        self.potential = float(np.sqrt(self.stress / first.permittivity.max()))

    def _solid(self, name: str):
        return self.solids[self.drawing.absorbers.get(name, (name,))[0]]

    def _geometry(self):
        from netgen.occ import Face, Glue, OCCGeometry, Segment, Wire

        faces = []
        for name, polygon in self.drawing.regions:
            corners = []
            for a, b in pairwise([*polygon, polygon[0]]):
                inner = [p for p in self.drawing.vertices if _lies_on((a, b), p)]
                corners += [a, *sorted(inner, key=lambda p, a=a: _apart(a, p))]
            corners = [
                p for p, before in zip(corners, [corners[-1], *corners], strict=False) if _apart(p, before) > SAME
            ]
            face = Face(Wire([Segment((*a, 0), (*b, 0)) for a, b in pairwise([*corners, corners[0]])]))
            face.faces.name = name
            faces.append(face)
        shape = Glue(faces) if len(faces) > 1 else faces[0]
        groups = {"clamped": self.drawing.clamped} | dict(
            zip(self._electrodes, self.drawing.electrodes.values(), strict=True)
        )
        for edge in shape.edges:
            middle = edge.center.x, edge.center.y
            own = [name for name, segments in groups.items() if any(_lies_on(s, middle) for s in segments)]
            edge.name = own[0] if own else "free"
        for vertex in shape.vertices:
            if any(_apart((vertex.p.x, vertex.p.y), p) < SAME for p in self.drawing.refined):
                vertex.hpref = 1
        return OCCGeometry(shape, dim=2)

    def _form(self, frequency: float, condense: bool):
        import ngsolve as ng

        *u, phi = self.space.TrialFunction()
        *v, psi = self.space.TestFunction()
        form = ng.BilinearForm(self.space, symmetric=True, condense=condense)
        inertia = (2 * np.pi * frequency * 1e-3) ** 2 / self.stress
        for name in self.mesh.GetMaterials():
            solid, s = self._solid(name), self.drawing.absorbers.get(name, (name, 1.0))[1]

            def slopes(w, s=s):
                return {0: ng.grad(w)[0] / s, 2: ng.grad(w)[1]}

            def strain(w):
                found: dict = {}
                for axis, each in zip(self.axes, w, strict=True):
                    for way, value in slopes(each).items():
                        row = STRAINS[axis][way]
                        found[row] = found[row] + value if row in found else value
                return found

            one, other = strain(u), strain(v)
            terms = [
                complex(solid.stiffness_lossy[i, j] / self.stress) * other[i] * one[j] for i in other for j in one
            ] + [-inertia * solid.density * a * b for a, b in zip(u, v, strict=True)]
            if solid.is_piezoelectric:
                coupling = solid.coupling * self.potential / self.stress
                permittivity = solid.permittivity_lossy * self.potential**2 / self.stress
                first, second = slopes(phi), slopes(psi)
                for k in first:
                    terms += [float(coupling[k, i]) * (other[i] * first[k] + second[k] * one[i]) for i in one]
                    terms += [-complex(permittivity[k, m]) * second[k] * first[m] for m in first]
            form += s * sum(terms[1:], terms[0]) * ng.dx(definedon=self.mesh.Materials(name))
        return form

    def solve(self, frequency: float) -> None:
        """Solve for a unit potential on every electrode alone: ``fields``, and ``matrix`` of the reactions."""
        import ngsolve as ng

        form, whole = (self._form(frequency, condense) for condense in (True, False))
        form.Assemble()
        inverse = form.mat.Inverse(self.space.FreeDofs(True), inverse="sparsecholesky")
        free = ng.Projector(self.space.FreeDofs(), True)
        names = self._electrodes
        self.fields, lifted = [], []
        self.residual = 0.0
        for name in names:
            one = ng.GridFunction(self.space)
            one.components[-1].Set(
                self.mesh.BoundaryCF({name: 1.0}, default=0.0), definedon=self.mesh.Boundaries("|".join(names))
            )
            load, gap, step = (one.vec.CreateVector() for _ in range(3))
            load.data = one.vec
            for turn in range(3):
                whole.Apply(one.vec, gap)
                gap.data = -1 * (free * gap)
                if turn == 0:
                    size = gap.Norm()
                elif turn == 2:
                    self.residual = max(self.residual, gap.Norm() / size)
                    break
                gap.data += form.harmonic_extension_trans * gap
                step.data = inverse * gap
                step.data += form.harmonic_extension * step
                step.data += form.inner_solve * gap
                one.vec.data += step
            self.fields.append(one)
            lifted.append(load)
        self.matrix = np.zeros((len(names),) * 2, dtype=complex)
        for column, each in enumerate(self.fields):
            whole.Apply(each.vec, gap)
            for row, load in enumerate(lifted):
                self.matrix[row, column] = ng.InnerProduct(gap, load, conjugate=False)
        self.frequency = frequency

    def driven(self, name: str, aperture: float, places) -> tuple[complex, np.ndarray]:
        """Admittance (S) between the electrodes ``name+`` and ``name-``, and u_x, u_z (m/V) at places (x, z) in mm.

        All other electrodes float; u has the shape (2, places).
        """
        names = list(self.drawing.electrodes)
        plus, minus = names.index(f"{name}+"), names.index(f"{name}-")
        weights = np.zeros(len(names), dtype=complex)
        weights[[plus, minus]] = 0.5, -0.5
        others = [k for k in range(len(names)) if k not in (plus, minus)]
        if others:
            weights[others] = np.linalg.solve(self.matrix[np.ix_(others, others)], -(self.matrix[others] @ weights))
        charge = -0.5 * ((self.matrix[plus] - self.matrix[minus]) @ weights) * self.stress / self.potential**2
        u = np.zeros((2, len(places)), dtype=complex)
        for row, axis in enumerate((0, len(self.axes) - 1)):
            for column, (x, z) in enumerate(places):
                at = self.mesh(x, z)
                u[row, column] = sum(w * f.components[axis](at) for w, f in zip(weights, self.fields, strict=True))
        return complex(2j * np.pi * self.frequency * aperture * charge), u / self.potential


def _couples_y(solid) -> bool:
    """Whether u_y takes part in the section."""
    plane, across = [0, 2, 4], [3, 5]
    return bool(solid.stiffness[np.ix_(plane, across)].any() or (solid.coupling[np.ix_((0, 2), across)]).any())


FREQUENCY, APERTURE = 2.17e6, 10e-3
LENGTH, THICKNESS = 8.0, 1.1
RESOLUTIONS = {"five grooves": (11, 10, 0.5), "step": (10, 10, 0.5)}  # order, layers, size; others: 12, 12, 0.45
SURFACE = {"step": -0.3}  # at the last place


def drawing_of(case: str) -> tuple[Drawing, dict]:
    """Drawing and solids of a case of `tests.fem.piece_references`."""
    fingers = [((1.325 + 0.5 * k, 0.0), (1.575 + 0.5 * k, 0.0)) for k in range(4)]
    electrodes = {"t+": fingers[::2], "t-": fingers[1::2]}
    solids = {"stator": rotated(material("PZT-4"), "Z")}
    grooves = {"groove": [(5.25, 0.25, 0.15)], "five grooves": [(4.5 + 0.5 * k, 0.25, 0.1) for k in range(5)]}.get(
        case, []
    )
    left, bottom = [(0.0, 0.0), (0.0, -THICKNESS)], (LENGTH, -THICKNESS)
    outline = [*left, bottom, (LENGTH, 0.0)]
    for x, width, depth in grooves[::-1]:
        outline += [(x + width, 0.0), (x + width, -depth), (x, -depth), (x, 0.0)]
    singular = [(x, -depth) for a, width, depth in grooves for x in (a, a + width)]
    regions, absorbers = [("stator", outline)], {}
    if case == "strip":
        solids["strip"] = material("aluminium")
        regions.append(("strip", [(5.2, 0.0), (5.5, 0.0), (5.5, 0.1), (5.2, 0.1)]))
        electrodes["strip"] = [((5.2, 0.0), (5.5, 0.0))]
    elif case == "bevel":
        regions = [("stator", [*left, bottom, (7.6, 0.0)])]
    elif case == "step":
        low, foot = -0.3, (5.5, -0.3)
        before, behind = LENGTH, 10.0  # mm of absorber
        regions = [
            ("stator", [*left, bottom, (LENGTH, low), foot, (5.5, 0.0)]),
            ("ahead", [(-before, 0.0), (-before, -THICKNESS), left[1], left[0]]),
            ("behind", [(LENGTH, low), bottom, (LENGTH + behind, -THICKNESS), (LENGTH + behind, low)]),
        ]
        absorbers = {"ahead": ("stator", 1 - 1.5j), "behind": ("stator", 2 - 0.36j)}
        singular = [foot]
    return Drawing(regions=regions, electrodes=electrodes, singular=singular, absorbers=absorbers), solids


def reference_of(case: str, order: int, layers: int, size: float) -> tuple[complex, np.ndarray]:
    """Admittance (S) and u_x, u_z (m/V, shape (2, 3)) of a case."""
    solved = Reference(*drawing_of(case), order=order, layers=layers, size=size)
    solved.solve(FREQUENCY)
    x = places(case) * 1e3
    return solved.driven("t", APERTURE, [(x[0], 0.0), (x[1], 0.0), (x[2], SURFACE.get(case, 0.0))])


def main() -> None:
    """Print every case as `tests.fem.piece_references` holds it; 2 CPU minutes."""
    for case in REFERENCES:
        admittance, motion = reference_of(case, *RESOLUTIONS.get(case, (12, 12, 0.45)))
        print(f'"{case}": ({admittance:.10e}, np.array({motion.tolist()})),')


if __name__ == "__main__":
    main()
