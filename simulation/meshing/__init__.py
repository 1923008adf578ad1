"""Meshes of plates of any outline.

===============  ================================================================
``arrangement``  borders as a planar graph: edges, nodes and faces
``recipe``       how fine
``strips``       quadrilaterals along every border
``fill``         triangles for the rest
``mesher``       all of it: the mesh of a plate
``plate_mesh``   what comes out
===============  ================================================================
"""
