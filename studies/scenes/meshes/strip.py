"""A thick strip of another solid on an electrode, on a plate of 2 mm.  Needs gmsh; writes strip.msh, in mm."""

import gmsh

LENGTH, LEFT, RIGHT, THICK, HEIGHT, SIZE = 1.0, 0.35, 0.65, 0.1, 2.0, 0.5

gmsh.initialize()
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
corners = [(0, -HEIGHT), (LENGTH, -HEIGHT), (LENGTH, 0), (RIGHT, 0), (LEFT, 0), (0, 0), (LEFT, THICK), (RIGHT, THICK)]
points = [gmsh.model.geo.addPoint(x, z, 0, SIZE) for x, z in corners]
below = [gmsh.model.geo.addLine(points[k], points[(k + 1) % 6]) for k in range(6)]
above = [gmsh.model.geo.addLine(points[a], points[b]) for a, b in ((4, 6), (6, 7), (7, 3))]
body = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(below)])
strip = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop([*above, below[3]])])
gmsh.model.geo.synchronize()
for name, line in (("bottom", 0), ("right", 1), ("electrode:strip", 3), ("left", 5)):
    gmsh.model.addPhysicalGroup(1, [below[line]], name=name)
gmsh.model.addPhysicalGroup(2, [body], name="stator")
gmsh.model.addPhysicalGroup(2, [strip], name="strip")
gmsh.model.mesh.generate(2)
gmsh.write("strip.msh")
