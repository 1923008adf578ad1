"""Reduced models of a plate, with their error measured against the full one.

A plate over a range of materials:

=========================  ================================================================
``rational_krylov``        Krylov space of one material
``mode_corrections``       vectors that correct the modes at further materials, and the errors of these modes
``candidates``             candidate vectors: these spaces and corrections at all training materials
``damped_modes``           real modes, a fast approximation for training
``resonance_lines``        frequency lines, including those on narrow resonances
``energy_decomposition``   proper orthogonal decomposition of the candidate vectors
``certification``          error against the full model outside the training set
``basis_training``         settings: training materials and tolerance
``galerkin``               projection of a model onto given vectors, and products with many vectors
``reduce``                 the whole reduction, from these steps
``footprint_reduction``    the same for forces and motions in addition to patches
``reduced_model``          the reduced model: small matrices for the whole range
``cell_stiffness``         stiffness of every cell: moduli that differ from cell to cell
``lowest_modes``           natural modes of a reduced model
``certified_lines``        check that frequencies are within the certified band
``dashpots``               viscous supports, added to a plate without them
``modal_form``             poles, and transfers as sums over them
``symmetric_poles``        poles of lightly coupled modes
``pole_sums``              evaluation of these sums at all lines of a band
``energy_sums``            energies of the responses as sums over poles
``modal_slopes``           derivatives of transfers with respect to the stiffness
``basis_key``              cache key of a reduced model, from all its inputs
``plate_basis``            finite-element functions and vectors of a reduced model
``coarse_plate``           fast model with errors of a per cent, for a first check of data
``coarse_places``          the same with one transducer anywhere on the plate
``coarse_shapes``          its modes at the points of an experiment and everywhere else
=========================  ================================================================

The same plate with physical effects on it:

=========================  ================================================================
``projector``              strains and displacements of given vectors
``patch_projection``       energies of the patches on given vectors
``effect_projection``      field-weighted energies of the plate on given vectors
``missing_responses``      additional vectors for the responses in other states
``places``                 forces anywhere on the plate, and its compliance there
``effect_operators``       the reduced matrices from which any state is composed
``composition``            matrices of one state, summed from these
``effect_reduction``       the whole reduction to the operators of a plate
``effect_certification``   error of the operators
``sufficient_fineness``    finer mesh and selection where the usual ones are not exact enough
=========================  ================================================================
"""
