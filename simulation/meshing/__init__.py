"""Meshes of plates of any outline.

===============  ================================================================
``crossings``    where borders cross or touch
``arrangement``  borders as a planar graph: edges, nodes, faces, and the angles in their corners
``recipe``       sizes of the mesh
``sides``        division of edges into pieces, and widths of strips
``cells``        a mesh under construction, and changes from one round to the next
``strips``       quadrilaterals along every border
``fill``         triangles in the remaining area
``grading``      refinement at corners
``mesher``       mesh of a plate, from all these steps, and the quality of its cells
``plate_mesh``   the finished mesh
``foreign``      meshes of other programs
===============  ================================================================
"""
