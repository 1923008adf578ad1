"""The digital twin: transfers from the inputs to the outputs of an experiment, with derivatives.

======================  ================================================================
``twin``                transfer from one input to all outputs, with or without effects, and derivatives; recorded
                        signals, with factors and feedthrough of effects
``instrumented_plate``  a reduced plate with the experiment's instruments, in any state
``declared_plate``      as declared, of any material: for model updating
``effect_plate``        in any state that effects make of it: for the gap workflow
``instruments``         inputs and outputs of an experiment as loads and readings; transfers between them, with
                        all sensors connected
``local_plate``         a reduced plate in one state, and reduced coordinates for its responses over a band
``local_solution``      responses over the band in these coordinates, also between a scan's many ports
``loaded_modes``        free vibration with patches connected to inputs
``sensitivity``         derivatives of responses, by adjoint fields or sums over modes, and of the strain energy
``strain_energy``       self-consistent strain energy, line by line
======================  ================================================================
"""
