"""Vectors of a reduced model: spaces from which they come, choice among them, and the error that is left.

========================  =====================================================================================
``rational_krylov``       Krylov space of one material; additional vectors for the responses in other states
``energy_decomposition``  proper orthogonal decomposition of the candidate vectors; projection of a model onto
                          given vectors, and products with many vectors
``reduce``                plate to reduced model: candidates for its vectors, choice among them, measured error
``certification``         error against the full model outside the training set; vectors that correct the modes at
                          further materials, and the errors of these modes
========================  =====================================================================================
"""
