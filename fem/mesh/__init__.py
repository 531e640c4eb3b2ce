"""Drawings of a stator's section: meshes of triangles and quadrilaterals from a file, and their quadrilaterals.

Input: a gmsh file in the plane (x, z), z = 0 the surface, and the length unit of its numbers.  Output: a checked
`SectionMesh`, the `MeshPiece` that places it on a stator, and the quadrilaterals that are assembled, refined towards
singular corners.
"""
