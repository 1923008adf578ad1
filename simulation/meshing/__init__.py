"""Meshes of plates of any outline.

===============  ================================================================
``arrangement``  borders as a planar graph: edges, nodes, faces, and the angles in their corners
``strips``       quadrilaterals along every border, whose edges are divided for them
``fill``         triangles in the remaining area
``mesher``       mesh of a plate, from all these steps, and the quality of its cells
``plate_mesh``   sizes of the mesh; the finished mesh, and one under construction
``foreign``      meshes of other programs
===============  ================================================================
"""
