"""A groove in a plate of 2 mm; several in a row are a reflector.  Needs gmsh; writes groove.msh, in mm."""

import gmsh

LENGTH, LEFT, RIGHT, DEPTH, HEIGHT, SIZE = 0.95, 0.35, 0.6, 0.06, 2.0, 0.5

gmsh.initialize()
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
corners = [(0, -HEIGHT), (LENGTH, -HEIGHT), (LENGTH, 0), (RIGHT, 0), (RIGHT, -DEPTH), (LEFT, -DEPTH), (LEFT, 0), (0, 0)]
points = [gmsh.model.geo.addPoint(x, z, 0, SIZE) for x, z in corners]
lines = [gmsh.model.geo.addLine(points[k], points[(k + 1) % 8]) for k in range(8)]
body = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(lines)])
gmsh.model.geo.synchronize()
for name, line in (("bottom", 0), ("right", 1), ("left", 7)):
    gmsh.model.addPhysicalGroup(1, [lines[line]], name=name)
gmsh.model.addPhysicalGroup(2, [body], name="stator")
gmsh.model.mesh.generate(2)
gmsh.write("groove.msh")
