"""The laminated Mindlin shell on a mesh, and the matrices of a plate with patches.

===================  ================================================================
``shape_functions``  hierarchical functions of one variable, and of the reference cells
``mapping``          places in curved cells, and back
``space``            function space over a mesh, and its integrals
``rigidity``         strains of a shell, and cells' matrices from section rigidities
``curved_surface``   strains of a curved plate in its tangent plane
``shear_factor``     correction of the transverse shear stiffness
``theory_error``     errors of natural frequencies by the theory itself
``edges``            supports along edges
``footprints``       discs on which transducers act
``points``           supports at points
``plate_borders``    borders and mesh of a declared plate
``shell_plate``      a declared plate on a mesh: sections and matrices of every cell
``unknowns``         selection of the unknowns, and their order for sparse factors: nested dissection
``factors``          sparse factorization
``condensation``     static condensation of interior functions of cells
``fineness``         mesh, degree and tolerance, by the shortest bending wave
``assembly``         assembly of the matrices, with all functions or with those that the responses need
``shell_model``      the assembled plate, with responses by direct solution
``piezo_material``   constants of piezoceramics, and those of a thin poled patch
``in_plane``         stiffness of a layer along the plate's axes
``coupling``         force of one volt on each patch
``electric_load``    sensor patches with the impedance of their inputs
===================  ================================================================
"""
