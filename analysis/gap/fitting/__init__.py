"""Estimator of model updating and of the gap workflow, and analysis of its residual.

======================  =============================================================
``state``               laws, readings, gain and effects: the unknowns of a fit
``normal_equations``    whitened least squares of every sweep
``sites``               sites from which effects are searched
``schur_complement``    elimination of the unknowns of single groups and sweeps
``gap_fit``             result of a fit, its misfit over the lines, constants of an orthotropic sheet in it
``bounded_step``        step inside bounds
``fit``                 Levenberg-Marquardt over all unknowns
``linearised_sweeps``   a campaign linearised once, for fits and score tests near it
``residual_map``        residual over channel, frequency, temperature, ramp and level; correlation of neighbours
======================  =============================================================
"""
