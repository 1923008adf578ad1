"""The computed plate: from its declaration to volts, newtons and metres per second.

================  ================================================================
``meshing``       meshes of any outline
``shell``         the laminated Mindlin shell with piezo patches on such a mesh
``state``         what a plate is during one sweep, and its matrices then
``effects``       the library of effects, one in a file; each turns one state into another
``reduction``     small matrices that answer for a whole range of materials and states
``twin``          inputs in, outputs out, with derivatives
``verification``  exact and published solutions that the plate is held against
================  ================================================================
"""
