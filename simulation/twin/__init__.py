"""The digital twin as an experiment sees it: what drives the plate in, what reads it out.

=====================  ================================================================
``instruments``        inputs and outputs of an experiment as loads and readings
``transfer``           outputs per input, all sensors connected at once
``plain_twin``         for model updating: E, nu and eta
``local_solution``     answers over a band in few coordinates
``local_slopes``       derivatives of a state's matrices, in these coordinates
``sensitivity``        derivatives of the answers: a field and its adjoint
``strain_energy``      of the plate as it is: self-consistent, line by line
``line_solver``        lines whose stiffness follows their own answer
``reading``            what the recorder reads
``effect_twin``        for the gap workflow: any state, and derivatives
=====================  ================================================================
"""
