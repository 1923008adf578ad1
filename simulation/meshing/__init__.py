"""Meshes of plates of any outline.

===============  ================================================================
``crossings``    where borders cross or touch
``arrangement``  borders as a planar graph: edges, nodes and faces
``recipe``       sizes of the mesh
``corners``      angles between neighbouring edges of a face
``clearance``    free distances between borders
``sides``        division of edges into pieces, and widths of strips
``repairs``      changes from one round of meshing to the next
``cells``        a mesh under construction
``strips``       quadrilaterals along every border
``fill``         triangles in the remaining area
``grading``      refinement at corners
``numbering``    numbers of points, cells and edges
``quality``      quality of the cells
``mesher``       mesh of a plate, from all these steps
``plate_mesh``   the finished mesh
``foreign``      meshes of other programs
===============  ================================================================
"""
