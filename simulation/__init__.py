"""The computed plate: finite-element model, reduced models and twin of a declared plate.

====================  ================================================================
``meshing``           meshes of any outline
``shell``             the laminated Mindlin shell with piezo patches on such a mesh
``state``             state of a plate during one sweep, and its matrices
``effects``           the library of effects, one in a file; each turns one state into another
``tolerances``        declared quantities as parameters of the twin, each with its tolerance
``reduction``         reduced models for a whole range of materials and states
``heat``              heat equation of the plate, on the same mesh
``twin``              transfers from inputs to outputs, with derivatives
====================  ================================================================
"""
