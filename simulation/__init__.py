"""The computed plate: finite-element model, reduced models and twin of a declared plate.

====================  ================================================================
``meshing``           meshes of any outline
``shell``             the laminated Mindlin shell with piezo patches on such a mesh
``state``             state of a plate during one sweep, and its matrices
``effects``           the library of effects, one in a file; each turns one state into another
``tolerance``         a declared quantity that is not exact
``tolerances``        declared quantities as parameters of the twin, applied before any effect
``sheet_tolerances``  those of an orthotropic sheet: moduli and losses by direction
``reduction``         reduced models for a whole range of materials and states
``heat``              heat equation of the plate, on the same mesh
``twin``              transfers from inputs to outputs, with derivatives
``verification``      comparison with exact and published solutions
====================  ================================================================
"""
