"""The digital twin: transfers from the inputs to the outputs of an experiment, with derivatives.

======================  ================================================================
``twin``                transfer from one input to all outputs, with or without effects, and derivatives
``instrumented_plate``  a reduced plate with the experiment's instruments, in any state
``reduced_plate``       protocol of a reduced plate
``declared_plate``      as declared, of any material: for model updating
``effect_plate``        in any state that effects make of it: for the gap workflow
``states``              states of a plate: effects of a library applied in order
``instruments``         inputs and outputs of an experiment as loads and readings
``transfer``            outputs per input, with all sensors connected
``local_basis``         reduced coordinates for one state and band
``local_plate``         a plate's matrices in these coordinates
``local_solution``      responses over the band in these coordinates, also between a scan's many ports
``loaded_modes``        free vibration with patches connected to inputs
``sensitivity``         derivatives of responses, by adjoint fields or sums over modes
``recorded_signals``    recorded signals, with factors and feedthrough of effects, and their derivatives
``strain_energy``       self-consistent strain energy, line by line
``line_solver``         solution at lines whose stiffness or damping differs
======================  ================================================================
"""
