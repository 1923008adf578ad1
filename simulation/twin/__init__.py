"""The digital twin as an experiment sees it: what drives the plate in, what reads it out.

======================  ================================================================
``twin``                one input, all outputs, with effects or without, and derivatives
``instrumented_plate``  a reduced plate with the experiment's instruments, in any state
``reduced_plate``       what a reduced plate must offer to it
``declared_plate``      as declared, of any material: for model updating
``effect_plate``        in any state that effects make of it: for the gap workflow
``states``              these states: effects of a library applied in their order
``instruments``         inputs and outputs of an experiment as loads and readings
``transfer``            outputs per input, all sensors connected at once
``reading``             what the recorder reads
``local_basis``         few coordinates for one state and band
``local_solution``      answers over the band in these coordinates
``local_slopes``        derivatives of a state's matrices, in these coordinates
``sensitivity``         derivatives of the answers: a field and its adjoint, or sums over modes
``derivatives``         derivatives of what is read, by material and effects alike
``vicinity``            one sweep's state, and the steps of every parameter from it
``strain_energy``       of the plate as it is: self-consistent, line by line
``line_solver``         lines whose stiffness follows their own answer
======================  ================================================================
"""
