"""The laminated Mindlin shell on a mesh, and the matrices of a plate with patches.

==================  ================================================================
``lobatto``         hierarchical functions of one variable
``cells``           functions of the reference quadrilateral and triangle
``mapping``         places in curved cells, and back
``cell_group``      functions and points of quadrature on all cells of a kind
``space``           functions over a mesh, and their integrals
``rigidity``        strains of a shell, and cells' matrices from section rigidities
``edges``           supports along edges
``footprints``      discs on which transducers act
``points``          supports at points
``shell_plate``     a declared plate on a mesh: what every cell is made of
``unknowns``        which functions are unknowns, in which order
``dissection``      order of elimination that keeps factors sparse
``factors``         sparse factors
``condensation``    insides of cells eliminated before the sparse solver
``choice``          functions that a plate's answers need
``fineness``        mesh, degree and tolerance of that choice
``assembly``        from the declaration to matrices
``shell_model``     the assembled plate, answers by direct solution
``moving``          a mesh whose cells stretch so that a patch sits elsewhere
``piezo_material``  ceramic constants, and what a thin poled patch makes of them
``in_plane``        stiffness of a layer along the plate's axes
``plane_stress``    moduli in which the plate's stiffness is affine
``coupling``        force of one volt on each patch
``electric_load``   sensors on real inputs, all connected at once
==================  ================================================================
"""
