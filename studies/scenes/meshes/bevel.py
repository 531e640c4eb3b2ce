"""A bevelled right end of a plate of 2 mm: 1.5 mm long below, 0.9 mm above.  Needs gmsh; writes bevel.msh, in mm."""

import gmsh

FOOT, TOP, HEIGHT, SIZE = 1.5, 0.9, 2.0, 0.5

gmsh.initialize()
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
corners = [(0, -HEIGHT), (FOOT, -HEIGHT), (TOP, 0), (0, 0)]
points = [gmsh.model.geo.addPoint(x, z, 0, SIZE) for x, z in corners]
lines = [gmsh.model.geo.addLine(points[k], points[(k + 1) % 4]) for k in range(4)]
body = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(lines)])
gmsh.model.geo.synchronize()
gmsh.model.addPhysicalGroup(1, [lines[0]], name="bottom")
gmsh.model.addPhysicalGroup(1, [lines[3]], name="left")
gmsh.model.addPhysicalGroup(2, [body], name="stator")
gmsh.model.mesh.generate(2)
gmsh.write("bevel.msh")
