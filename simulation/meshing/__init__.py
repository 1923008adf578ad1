"""Meshes of plates of any outline.

===============  ================================================================
``arrangement``  borders as a planar graph: edges, nodes, faces, and the angles in their corners
``recipe``       sizes of the mesh
``cells``        a mesh under construction, and changes from one round to the next
``strips``       quadrilaterals along every border, whose edges are divided for them
``fill``         triangles in the remaining area
``mesher``       mesh of a plate, from all these steps, and the quality of its cells
``plate_mesh``   the finished mesh
``foreign``      meshes of other programs
===============  ================================================================
"""
