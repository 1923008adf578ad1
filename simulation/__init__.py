"""The computed plate: laminated Mindlin shells with piezo patches, and their reduced models.

=========================  ================================================================
``piezo_material``         ceramic constants, and what a thin poled patch makes of them
``laminate``               through-thickness integrals of plate and patches
``mesh``                   graded mesh lines, with strips where shear layers are
``shape_space``            hierarchical quadrilaterals and their elementary integrals
``thinning``               which functions a graded mesh can spare
``mindlin``                assembly: K1, K2, Kp, M, couplings, capacitances
``shell_model``            the assembled plate, answers by direct solution
``electric_load``          sensors on real inputs, all connected at once
``footprints``             rules that average a deflection over a transducer
``instruments``            ports of the plate, and what is driven, connected and read
``transfer``               outputs per unit of the input, and derivatives
``rational_krylov``        candidate vectors of a reduced model
``damped_modes``           real modes, cheap enough to train with
``energy_decomposition``   the candidates worth keeping
``certification``          the error against the full model where it was not trained
``reduction``              all of it: a plate over a box of materials and a band
``footprint_reduction``    the same with forces and motions besides patches
``basis_key``              a reduced model's name by all that decides it
``reduced_model``          small matrices that answer for the whole box
``modal_form``             poles, transfers as sums over them, and their derivatives
``twin``                   one input, all outputs, for model updating
=========================  ================================================================

The same plate with physical effects on it:

=========================  ================================================================
``plate_state``            what a plate is during one sweep; effects turn one into another
``effects``                the library of effects, one in a file
``plane_forms``            elementary energies with a weight over the plate
``state_matrices``         sparse matrices of any state, fields taken as they are
``field_basis``            smooth fields as Legendre polynomials
``effect_projection``      every field-weighted energy on given vectors
``sensor_offset``          what moving the first sensor changes
``effect_operators``       the reduced matrices from which any state is composed
``extreme_states``         the edges of what effects may do
``effect_reduction``       all of it: operators of a plate, with their error measured
``effect_certification``   that error
``campaign_basis``         a smaller model for the few materials of one campaign
``mesh_refinement``        vectors carried to a finer mesh
``damaged_spots``          what discs of less stiffness take away
``composition``            a state composed of reduced matrices
``certified_range``        where operators may be asked
``local_solution``         answers over a band in few coordinates
``local_slopes``           derivatives of a state's matrices, in these coordinates
``sensitivity``            derivatives of the answers: a field and its adjoint
``line_solver``            answers where the stiffness changes from line to line
``strain_energy``          that of a plate that follows it, and its derivatives
``reading``                outputs, and what effects do to signals
``mesh_disagreement``      how far this plate and the plain one, on another mesh, are apart
``effect_twin``            one input, all outputs, for the gap workflow
=========================  ================================================================
"""
