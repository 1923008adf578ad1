"""The estimator of model updating and of the gap workflow, and the residual it leaves.

======================  =============================================================
``state``               laws, readings, gain and effects: the unknowns of a fit
``normal_equations``    whitened least squares of every sweep
``schur_complement``    unknowns of single groups and sweeps eliminated
``gap_fit``             result of a fit
``bounded_step``        one step inside bounds
``fit``                 Levenberg-Marquardt over all unknowns
``misfit``              relative misfit over the lines
``whiteness``           correlation of neighbouring residuals
``residual_map``        residual over channel, frequency, temperature, ramp and level
======================  =============================================================
"""
