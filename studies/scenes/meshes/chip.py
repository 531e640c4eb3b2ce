"""A whole stator of 12 mm x 1 mm with 8 fingers and a slanted right end.  Needs gmsh; writes chip.msh, in mm."""

import gmsh

FOOT, TOP, HEIGHT, SIZE = 12.0, 11.4, 1.0, 0.5
FIRST, WIDTH, PITCH, FINGERS = 2.0, 0.25, 0.5, 8

gmsh.initialize()
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
edges = [FIRST + PITCH * finger + side for finger in range(FINGERS) for side in (0, WIDTH)]
corners = [(0, -HEIGHT), (FOOT, -HEIGHT), (TOP, 0), *((x, 0) for x in edges[::-1]), (0, 0)]
points = [gmsh.model.geo.addPoint(x, z, 0, SIZE) for x, z in corners]
lines = [gmsh.model.geo.addLine(points[k], points[(k + 1) % len(points)]) for k in range(len(points))]
body = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(lines)])
gmsh.model.geo.synchronize()
fingers = lines[3 : 3 + 2 * FINGERS : 2]  # from right to left
gmsh.model.addPhysicalGroup(1, [lines[0]], name="bottom")
gmsh.model.addPhysicalGroup(1, fingers[1::2], name="electrode:plus")
gmsh.model.addPhysicalGroup(1, fingers[0::2], name="electrode:minus")
gmsh.model.addPhysicalGroup(2, [body], name="stator")
gmsh.model.mesh.generate(2)
gmsh.write("chip.msh")
