"""Reduced models of a plate, with their error measured against the full one.

A plate over a range of materials:

=========================  ================================================================
``damped_modes``           transfers by real modes, a fast approximation for training; energies as sums over poles;
                           frequency lines, including those on narrow resonances
``reduced_model``          the reduced model: small matrices for the whole range; its natural modes
``modal_form``             poles of a reduced plate at one set of constants, transfers as sums over them,
                           derivatives by stiffness; viscous supports, added to a plate without them
``basis_key``              settings of the reduction: training materials and tolerance; cache key of a reduced
                           model, from all its inputs
``plate_basis``            declaration to reduced model, with forces and measured motions beside the patches
``vectors``                the vectors of a reduced model, chosen among candidates, and their certified error
``coarse_plate``           coarse model, made in a second: transfers to every place, shapes of its modes
                           everywhere
=========================  ================================================================

The same plate with physical effects on it:

=========================  ================================================================
``effect_projection``      strains and displacements of given vectors, the stiffness of the cells by them, and
                           energies of plate and patches
``places``                 forces anywhere on the plate, and its compliance there
``effect_operators``       the reduced matrices from which any state is composed
``composition``            matrices of one state, summed from these
``effect_reduction``       the whole reduction to the operators of a plate
``effect_certification``   states at the limits of the effects, for training, and error of the operators in states
                           outside of it
``sufficient_fineness``    finer mesh and selection where the usual ones are not exact enough
=========================  ================================================================
"""
