"""Meshes of plates of any outline.

===============  ================================================================
``crossings``    where borders cross or touch
``arrangement``  borders as a planar graph: edges, nodes and faces
``recipe``       how fine
``corners``      angles between neighbouring edges of a face
``clearance``    free distances between borders
``sides``        edges cut into pieces, and the widths of strips
``repairs``      what a round of meshing teaches the next one
``strips``       quadrilaterals along every border
``fill``         triangles for the rest
``grading``      smaller cells at corners
``numbering``    points, cells and edges numbered
``quality``      how sound the cells are
``mesher``       all of it: the mesh of a plate
``plate_mesh``   what comes out
``foreign``      meshes made elsewhere
===============  ================================================================
"""
