"""The peer package NGSolve on a plate of layers, with fingers at any interface and an elastic bond below one layer.

Netgen triangles, hp-refined towards the finger edges, one high order throughout; each layer has its own integrand. With
a bond the displacements below and above it are two spaces that springs on the interface join; the potential is one.
Plate with free ends and faces, D_n = 0 on them; fingers as Dirichlet data, charges as reactions of the residual. Fields
exp(+i omega t); lengths in ``unit``.

Source: Schoeberl, *C++11 implementation of finite elements in NGSolve*, ASC report 30/2014, TU Wien.
"""

import numpy as np

_STRAIN, _PLANE = (0, 2, 4), (0, 2)  # Voigt 11, 33, 13


def layered_plate(stator, transducer, *, frequency, unit, order, size, edge_layers, place):
    """Return admittance (S) and u_x, u_z (m per V) at a place (m) of the surface of a `fem.Stator` with layers."""
    import ngsolve as ng

    heights = np.cumsum([0.0, stator.thickness, *(each.thickness for each in stator.layers)]) / unit
    plane = len(heights) - 1 - stator.plane
    mesh = ng.Mesh(_geometry(stator, transducer, heights, plane, unit).GenerateMesh(maxh=size))
    mesh.RefineHP(edge_layers, factor=0.15)
    solids = stator.solids
    stress = max(float(each.stiffness.max()) for each in solids)
    potential = float(np.sqrt(stress / max(each.permittivity.max() for each in solids)))
    bonded = next((k for k, each in enumerate(stator.layers) if each.bond), None)
    names = [f"solid{k}" for k in range(len(solids))]
    split = len(names) if bonded is None else bonded + 1
    electric = ng.H1(mesh, order=order, complex=True, dirichlet="plus|minus")
    low = ng.VectorH1(mesh, order=order, complex=True, definedon="|".join(names[:split]))
    parts = [low]
    if bonded is not None:
        parts.append(ng.VectorH1(mesh, order=order, complex=True, definedon="|".join(names[split:])))
    space = ng.FESpace([*parts, electric])
    trials, tests = space.TnT()
    form = ng.BilinearForm(space, symmetric=True)

    def table(values):
        return ng.CF(tuple(complex(value) for value in values.ravel()), dims=values.shape)

    def strain(w):
        slope = ng.Grad(w)
        return ng.CF((slope[0, 0], slope[1, 1], slope[0, 1] + slope[1, 0]))

    phi, psi = trials[-1], tests[-1]
    for number, solid in enumerate(solids):
        u, v = (each[int(number >= split)] for each in (trials, tests))
        elastic = table(solid.stiffness_lossy[np.ix_(_STRAIN, _STRAIN)] / stress)
        coupling = solid.coupling[np.ix_(_PLANE, _STRAIN)] * (potential / stress)
        dielectric = table(-solid.permittivity_lossy[np.ix_(_PLANE, _PLANE)] * (potential**2 / stress))
        square = (2 * np.pi * frequency * unit) ** 2 * solid.density / stress
        own = (elastic * strain(u) + table(coupling.T.copy()) * ng.grad(phi)) * strain(v) - square * (u * v)
        own += (table(coupling) * strain(u) + dielectric * ng.grad(phi)) * ng.grad(psi)
        form += own * ng.dx(definedon=mesh.Materials(names[number]))
    if bonded is not None:
        bond = stator.layers[bonded].bond
        springs = np.array([bond.tangential, bond.normal]) * unit / stress
        jump, other = trials[1] - trials[0], tests[1] - tests[0]
        form += sum(springs[k] * jump[k] * other[k] for k in (0, 1)) * ng.ds(definedon=mesh.Boundaries(f"face{split}"))
    form.Assemble()
    lifted = ng.GridFunction(space)
    lifted.components[-1].Set(
        mesh.BoundaryCF({"plus": 0.5, "minus": -0.5}, default=0.0), definedon=mesh.Boundaries("plus|minus")
    )
    load, answer, residual = lifted.vec, ng.GridFunction(space), lifted.vec.CreateVector()
    residual.data = -(form.mat * load)
    answer.vec.data = load + form.mat.Inverse(space.FreeDofs(), inverse="umfpack") * residual
    residual.data = form.mat * answer.vec
    charge = -ng.InnerProduct(residual, load, conjugate=False) * stress / potential**2
    at = mesh(place / unit, heights[-1] - 1e-12)
    motion = np.array(answer.components[len(parts) - 1](at)) / potential
    return complex(2j * np.pi * frequency * transducer.aperture * charge), motion


def _geometry(stator, transducer, heights, plane, unit):
    from netgen.geom2d import SplineGeometry

    shape, length = SplineGeometry(), stator.length / unit
    ends = [[shape.AppendPoint(x, z) for x in (0.0, length)] for z in heights]
    last = len(heights) - 1

    def side(a, b, **rest):
        shape.Append(["line", a, b], **rest)

    for level, (left, right) in enumerate(ends):
        both = {"leftdomain": level + 1 if level < last else 0, "rightdomain": level}  # from left to right
        here = left
        if level == plane:
            for sign, (start, stop) in zip(transducer.signs, transducer.fingers / unit, strict=True):
                begin, end = (shape.AppendPoint(x, heights[level], hpref=1) for x in (start, stop))
                side(here, begin, bc=f"face{level}", **both)
                side(begin, end, bc="plus" if sign == "+" else "minus", **both)
                here = end
        side(here, right, bc=f"face{level}", **both)
        if level < last:
            for k, swap in ((0, True), (1, False)):
                inside = (
                    {"leftdomain": 0, "rightdomain": level + 1} if swap else {"leftdomain": level + 1, "rightdomain": 0}
                )
                side(ends[level][k], ends[level + 1][k], bc="side", **inside)
            shape.SetMaterial(level + 1, f"solid{level}")
    return shape
