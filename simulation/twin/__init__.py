"""The digital twin: transfers from the inputs to the outputs of an experiment, with derivatives.

======================  ================================================================
``twin``                transfer from one input to all outputs, with or without effects, and derivatives
``instrumented_plate``  a reduced plate with the experiment's instruments, in any state
``reduced_plate``       protocol of a reduced plate
``declared_plate``      as declared, of any material: for model updating
``effect_plate``        in any state that effects make of it: for the gap workflow
``states``              states of a plate: effects of a library applied in order
``instruments``         inputs and outputs of an experiment as loads and readings
``transducer_rows``     where transducers act, what they weigh, and derivatives of both
``transfer``            outputs per input, with all sensors connected
``reading``             recorded signals, with factors and feedthrough of effects
``local_basis``         reduced coordinates for one state and band
``local_plate``         a plate's matrices in these coordinates
``local_solution``      responses over the band in these coordinates
``seated_modes``        the same with attachments, between a scan's many ports
``loaded_modes``        free vibration with patches connected to inputs
``local_slopes``        derivatives of a state's matrices, in these coordinates
``sensitivity``         derivatives of responses, by adjoint fields or sums over modes
``derivatives``         derivatives of the recorded signals by material and effects
``moved_patches``       what moves of patches change in all other derivatives
``vicinity``            one sweep's state, and complex steps of every parameter
``strain_energy``       self-consistent strain energy, line by line
``line_solver``         solution at lines whose stiffness or damping differs
======================  ================================================================
"""
