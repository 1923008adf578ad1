"""The laminated Mindlin shell on a mesh, and the matrices of a plate with patches.

===================  ================================================================
``shape_functions``  hierarchical functions of one variable, and of the reference cells; places in curved cells,
                     and back
``space``            function space over a mesh, and its integrals
``rigidity``         strains of a shell, flat or curved; stiffness of a layer along the plate's axes, and cells'
                     matrices from section rigidities, with its shear correction
``edges``            supports along edges
``points``           forces, masses, springs and sensors at points; footprints of transducers and attachments
``shell_plate``      a declared plate on a mesh: its borders, sections and matrices of every cell; force of one
                     volt on each patch
``unknowns``         selection and order of unknowns, matrices over them and their factors
``fineness``         mesh, degree and tolerance, by the shortest bending wave
``assembly``         assembly of the matrices, with all functions or those that responses need; condensation of
                     interior ones
``shell_model``      the assembled plate, with responses by direct solution
``piezo_material``   constants of piezoceramics, and those of a thin poled patch
``electric_load``    sensor patches with the impedance of their inputs
===================  ================================================================
"""
