"""The shell on a mesh: hierarchical functions, and the matrices of a plate with patches.

============  ================================================================
``lobatto``   hierarchical functions of one variable
``cells``     functions of the reference quadrilateral and triangle
``mapping``     how reference cells lie in the plate
``space``     functions over a mesh, and their integrals
============  ================================================================
"""
