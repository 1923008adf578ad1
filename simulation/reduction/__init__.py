"""Reduced models of a plate, their error measured against the full one.

A plate over a range of materials:

=========================  ================================================================
``rational_krylov``        candidate vectors
``damped_modes``           real modes, cheap enough to train with
``resonance_lines``        lines that lie on narrow resonances
``energy_decomposition``   the candidates worth keeping
``certification``          the error against the full model where it was not trained
``basis_training``         for which materials, and how exactly
``galerkin``               a reduced model on given vectors
``reduce``                 all of it
``footprint_reduction``    the same, with forces and motions besides patches
``reduced_model``          small matrices that answer for the whole range
``lowest_modes``           its natural modes
``certified_lines``        frequencies at which it may be asked
``dashpots``               viscous supports, connected to a plate without them
``modal_form``             poles, and transfers as sums over them
``symmetric_poles``        poles of lightly coupled modes
``pole_sums``              these sums, at all lines of a band
``energy_sums``            energies of the answers, likewise
``modal_slopes``           their derivatives by changes of the stiffness
``basis_key``              a reduced model's name by all that decides it
``plate_basis``            functions and vectors behind a reduced model
``coarse_plate``           a plate known to a per cent, for a first look at data
=========================  ================================================================

The same plate with physical effects on it:

=========================  ================================================================
``projector``              strains and displacements of given vectors
``patch_projection``       every energy of the patches on given vectors
``effect_projection``      every field-weighted energy on given vectors
``missing_answers``        what the plain vectors miss in other states
``effect_operators``       the reduced matrices from which any state is composed
``composition``            a state composed of them
``effect_reduction``       all of it: operators of a plate
``effect_certification``   their error
``campaign_basis``         a smaller model for the few materials of one campaign
=========================  ================================================================
"""
